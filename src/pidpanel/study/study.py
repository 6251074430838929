"""A whole study, and what its sections ask of each other."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, model_validator

from pidpanel.study.base import Model
from pidpanel.study.coupon import Coupon
from pidpanel.study.damping import Damping
from pidpanel.study.panel import Panel
from pidpanel.study.response import Family, Response, Scenario, as_tuple
from pidpanel.study.sound import Sound


class CouponStudy(Model):
    """A study of the coupon alone: what the spheres dissipate, and on what it depends."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$")]
    title: str = ""
    assumptions: tuple[str, ...] = ()
    """What the source leaves out and this study assumes; printed in the report."""
    coupon: Coupon | None = None

    @model_validator(mode="after")
    def _coupon(self) -> CouponStudy:
        if self.coupon is None and type(self) is CouponStudy:
            raise ValueError("neither a coupon nor a panel: at least one of them")
        return self


class Study(CouponStudy):
    """All that a run of the whole workflow depends on."""

    damping: Damping = Damping()
    panel: Panel
    sound: Sound
    response: Response = Response()
    scenarios: Annotated[Mapping[str, Family], Field(min_length=1)]

    @model_validator(mode="after")
    def _hangs_together(self) -> Study:
        if "dem" in self.damping.readings:
            if self.coupon is None:
                raise ValueError("damping.readings names 'dem': the section 'coupon' must be there")
            if self.coupon.vary:
                raise ValueError(
                    "coupon.vary: for a study of the coupon alone; one panel takes one damping"
                )
        for name, family in self.scenarios.items():
            patches = (family.patch,) if isinstance(family.patch, str) else family.patch
            for patch in patches:
                if patch not in self.panel.patches:
                    raise ValueError(
                        f"scenarios.{name}.patch = {patch}: one of panel.patches, "
                        f"{', '.join(self.panel.patches) or 'of which there are none'}"
                    )
            fills = as_tuple(family.fill_fraction)
            if "dem" in self.damping.readings and self.coupon is not None:
                run = self.coupon.sweep.fill_fraction
                for fill in fills:
                    if not min(run) <= fill <= max(run):
                        raise ValueError(
                            f"scenarios.{name}.fill_fraction = {fill:g}: within the fills of "
                            f"coupon.sweep, {min(run):g} to {max(run):g}"
                        )
        labels = [s.label for s in self.all_scenarios()]
        for label in self.response.maps:
            if label not in labels:
                raise ValueError(f"response.maps: {label}: one of {', '.join(labels)}")
        return self

    def family_scenarios(self, name: str) -> tuple[Scenario, ...]:
        """The scenarios of one family, in the order of its list."""
        family = self.scenarios[name]
        levels = as_tuple(family.oaspl_db if family.oaspl_db is not None else self.sound.oaspl_db)
        return tuple(
            Scenario(patch=patch, fill_fraction=fill, oaspl_db=level)
            for patch, fill, level in itertools.product(
                as_tuple(family.patch), as_tuple(family.fill_fraction), levels
            )
        )

    def all_scenarios(self) -> tuple[Scenario, ...]:
        """Every scenario once, each level's bare panel first."""
        families = [s for name in self.scenarios for s in self.family_scenarios(name)]
        ordered = dict.fromkeys([s.bare for s in families] + families)
        return tuple(ordered)

    def mapped_scenarios(self) -> tuple[Scenario, ...]:
        """The scenarios of ``response.maps``."""
        labels = self.response.maps or (self.all_scenarios()[0].label,)
        return tuple(s for s in self.all_scenarios() if s.label in labels)
