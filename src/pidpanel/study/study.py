"""A whole study, and what its sections require of each other."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, TypeVar

from pydantic import Field

from pidpanel.study.base import Model, as_tuple
from pidpanel.study.coupon import Coupon
from pidpanel.study.damping import Damping
from pidpanel.study.mistakes import Keys, Mistake, mistakes_of_names
from pidpanel.study.panel import Panel
from pidpanel.study.response import Family, Response, Scenario
from pidpanel.study.sound import Sound

T = TypeVar("T")


class CouponStudy(Model):
    """A study of the coupon alone: what the particles dissipate, and on what it depends."""

    name: str
    """Name of the folder of its results; by default that of its file."""
    title: str = ""
    assumptions: tuple[str, ...] = ()
    """What the source leaves open and this study assumes; printed in the report."""
    coupon: Coupon | None = None

    def mistakes(self) -> Iterator[Mistake]:
        """Yield a name that cannot be that of a folder, and a study without any section."""
        if not re.fullmatch("[A-Za-z0-9][A-Za-z0-9_-]*", self.name):
            yield Mistake(
                ("name",),
                "must be letters a to z or A to Z, digits, '_' and '-', the first a letter or a "
                "digit; by default it is the name of the file",
            )
        if self.coupon is None and type(self) is CouponStudy:
            yield Mistake((), "must have a section coupon, panel, or both")


class Study(CouponStudy):
    """All that a run of the whole workflow depends on."""

    damping: Damping = Damping()
    panel: Panel
    sound: Sound
    response: Response = Response()
    scenarios: Annotated[Mapping[str, Family], Field(min_length=1)]

    def mistakes(self) -> Iterator[Mistake]:
        """Yield what the sections require of each other and do not get."""
        yield from super().mistakes()
        if "dem" in self.damping.readings:
            if self.coupon is None:
                yield Mistake(("coupon",), "missing; required for the reading 'dem' of damping")
            elif self.coupon.vary:
                yield Mistake(("coupon", "vary"), "only allowed in a study without a panel")
        yield from mistakes_of_names("scenarios", self.scenarios)
        for name, family in self.scenarios.items():
            yield from (one.below("scenarios", name) for one in self._mistakes_of(family))
        yield from self._mistakes_of_labels()
        labels = [scenario.label for scenario in self.all_scenarios()]
        for index, label in enumerate(self.response.maps):
            if label not in labels:
                yield Mistake(("response", "maps", index), f"must be one of {', '.join(labels)}")

    def _mistakes_of_labels(self) -> Iterator[Mistake]:
        """Yield families with a scenario whose label another scenario has."""
        named: dict[str, Scenario] = {}
        for name, family in self.scenarios.items():
            for scenario in self.family_scenarios(name):
                for one in (scenario.bare, scenario):
                    if named.setdefault(one.label, one) != one:
                        yield Mistake(
                            ("scenarios", name, family.varied),
                            f"two scenarios would be named {one.label}; "
                            "values must differ in their first six digits",
                        )

    def _mistakes_of(self, family: Family) -> Iterator[Mistake]:
        for keys, patch in _items("patch", family.patch):
            if patch not in self.panel.patches:
                names = ", ".join(self.panel.patches)
                yield Mistake(
                    keys,
                    f"must be one of panel.patches: {names}" if names else "there are no patches",
                )
        if "dem" in self.damping.readings and self.coupon is not None:
            low, high = (f(self.coupon.sweep.fill_fraction) for f in (min, max))
            for keys, fill in _items("fill_fraction", family.fill_fraction):
                if not low <= fill <= high:
                    yield Mistake(
                        keys, f"must be in the range of coupon.sweep, {low:g} to {high:g}"
                    )

    def family_scenarios(self, name: str) -> tuple[Scenario, ...]:
        """Return the scenarios of one family, in the order of its list."""
        family = self.scenarios[name]
        level = self.sound.oaspl_db if family.oaspl_db is None else family.oaspl_db
        return tuple(
            Scenario(patch=patch, fill_fraction=fill, oaspl_db=level)
            for patch, fill, level in itertools.product(
                as_tuple(family.patch), as_tuple(family.fill_fraction), as_tuple(level)
            )
        )

    def all_scenarios(self) -> tuple[Scenario, ...]:
        """Return every scenario once, the bare panel at each level first."""
        families = [s for name in self.scenarios for s in self.family_scenarios(name)]
        ordered = dict.fromkeys([s.bare for s in families] + families)
        return tuple(ordered)

    def mapped_scenarios(self) -> tuple[Scenario, ...]:
        """Return the scenarios of ``response.maps``."""
        labels = self.response.maps or (self.all_scenarios()[0].label,)
        return tuple(s for s in self.all_scenarios() if s.label in labels)


def _items(key: str, value: T | tuple[T, ...]) -> Iterator[tuple[Keys, T]]:
    """Yield each item of a key that may be a list, with the way to it."""
    if isinstance(value, tuple):
        yield from (((key, index), item) for index, item in enumerate(value))
    else:
        yield (key,), value
