"""The section ``claims`` of a study: statements that its results are compared with."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pidpanel.study.base import SectionModel, Text
from pidpanel.study.mistakes import Mistake, not_among
from pidpanel.study.quantity import Quantity
from pidpanel.study.scenarios import Family

# Comparisons of patches or of levels alone.
VARIED = {"nearest_patch": "patch", "nearest_point": "patch"}
VARIED |= {"linear": "oaspl_db", "linear_stretched": "oaspl_db"}


class Claim(SectionModel):
    """A statement on a family of scenarios; the report says whether it holds, at all points."""

    text: Text
    """The statement."""
    source: Text = ""
    """Where it is made."""
    scenarios: Text
    """Family under ``scenarios``."""
    comparison: Literal[
        "most_effective", "lowered", "alike", "high_frequency",
        "nearest_patch", "nearest_point", "linear", "linear_stretched",
    ]  # fmt: skip
    """``most_effective``: the scenario of ``values`` reduces g rms most. ``lowered``: all reduce
    it. ``alike``: reductions are alike. ``high_frequency``: the upper half of the third octaves is
    reduced more than the lower. ``nearest_patch``: the damper nearest to a point reduces it most.
    ``nearest_point``: a damper reduces the point nearest to it most. ``linear``: third octaves rise
    as the sound does. ``linear_stretched``: g rms and displacement do, with stretching."""
    values: tuple[Any, ...] = ()
    """Scenarios, by the key that the family varies. By default all; ``most_effective`` needs one."""
    alike_db: Annotated[float, Quantity(0.01, 40)] = 1.0
    """Difference up to which ``alike`` and ``linear`` hold [dB]."""

    def mistakes_with(self, families: Mapping[str, Family]) -> Iterator[Mistake]:
        """Yield a family or scenarios that are not there, or too few of them."""
        family = families.get(self.scenarios)
        if family is None:
            yield Mistake(("scenarios",), not_among("scenarios", self.scenarios, list(families)))
            return
        varied = VARIED.get(self.comparison, family.varied)
        if varied != family.varied:
            yield Mistake(("comparison",), f"only allowed where {self.scenarios} varies {varied}")
        stated = getattr(family, family.varied)
        for number, value in enumerate(self.values):
            if value not in stated:
                allowed = ", ".join(f"{one}" for one in stated)
                message = f"must be one of scenarios.{self.scenarios}.{family.varied}: {allowed}"
                yield Mistake(("values", number), message)
        is_single = self.comparison == "most_effective"
        if is_single and len(self.values) != 1:
            yield Mistake(("values",), f"must have 1 value, not {len(self.values)}")
        if len(stated if is_single else self.values or stated) < 2 and self.comparison != "lowered":
            yield Mistake(("scenarios",), "needs two scenarios to compare")
