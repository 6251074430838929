"""The section ``claims`` of a study: statements that its results are compared with."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pidpanel.study.base import SectionModel, Text, as_tuple
from pidpanel.study.mistakes import Mistake, not_among
from pidpanel.study.quantity import Quantity
from pidpanel.study.scenarios import Family


class Claim(SectionModel):
    """A statement on the scenarios of one family; the report says whether it holds."""

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
    """What must be true at all points. ``most_effective``: the scenario of ``values`` reduces g rms
    most. ``lowered``: every scenario reduces it. ``alike``: all reduce it alike.
    ``high_frequency``: the upper half of the third octaves is reduced more than the lower.
    ``nearest_patch``: the nearest patch reduces a point most. ``nearest_point``: a patch reduces
    the nearest point most. ``linear``: third octaves rise as the sound. ``linear_stretched``: g rms
    and displacement with stretching rise as the sound."""
    values: tuple[Any, ...] = ()
    """Values of the key that the family varies: the one for ``most_effective``, else those that are
    compared; by default all."""
    alike_db: Annotated[float, Quantity(0.01, 40)] = 1.0
    """Difference within which levels are alike, and a rise is linear [dB]."""

    def mistakes_with(self, families: Mapping[str, Family]) -> Iterator[Mistake]:
        """Yield a family or values that are not there, too few, or not for this comparison."""
        if self.scenarios not in families:
            yield Mistake(("scenarios",), not_among("scenarios", self.scenarios, list(families)))
            return
        varied, way = families[self.scenarios].varied, f"scenarios.{self.scenarios}"
        needed = {"nearest": "patch", "linear": "oaspl_db"}.get(self.comparison.split("_")[0])
        if needed not in (None, varied):
            yield Mistake(("comparison",), f"only allowed if {way} has a list {needed}")
        stated = as_tuple(getattr(families[self.scenarios], varied))
        for number, value in enumerate(self.values):
            if value not in stated or isinstance(value, bool):
                message = not_among(f"{way}.{varied}", str(value), [str(entry) for entry in stated])
                yield Mistake(("values", number), message)
        is_single = self.comparison == "most_effective"
        if is_single and len(self.values) != 1:
            yield Mistake(("values",), f"must have 1 value, not {len(self.values)}")
        compared = stated if is_single else self.values or stated
        if len(compared) < 2 and self.comparison not in ("lowered", "high_frequency"):
            yield Mistake(("scenarios",), "must be a family of two scenarios or more")
