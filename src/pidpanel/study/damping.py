"""The section ``damping`` of a study: the readings of C_e and m_a, and the target of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from pidpanel.study.base import Model, Positive

Reading = Literal["dem", "paper_corrected", "paper_printed", "table"]


class Level(Model):
    """The motion at which C_e(r, f, Γ) is read: a stated Γ, or the patch's own."""

    kind: Literal["patch", "stated"] = "patch"
    acceleration_g: Positive | None = None
    outside: Literal["mark", "refuse"] = "mark"

    @model_validator(mode="after")
    def _stated(self) -> Level:
        if (self.kind == "stated") != (self.acceleration_g is not None):
            raise ValueError("acceleration_g goes with kind: stated, and only with it")
        return self


class Target(Model):
    """Run no more of ``coupon.sweep`` than is needed to know every rms acceleration so well.

    The sweep is then what may be run. ``start`` cases spread over it come first; rounds of
    ``batch`` follow, each of the cases that narrow the rms values most, until the relative
    standard error of all of them is below ``relative_error`` or ``max_cases`` have been run.
    """

    relative_error: Annotated[float, Field(gt=0, lt=1)]
    start: Annotated[int, Field(ge=4)] = 10
    batch: Annotated[int, Field(ge=1)] = 4
    max_cases: Annotated[int, Field(ge=4)] = 2000

    @model_validator(mode="after")
    def _start_is_allowed(self) -> Target:
        if self.start > self.max_cases:
            raise ValueError(f"start = {self.start}: at most max_cases = {self.max_cases}")
        return self


class Damping(Model):
    """Where C_e and m_a come from. Each reading is carried through to the PSDs."""

    readings: Annotated[tuple[Reading, ...], Field(min_length=1)] = ("dem",)
    level: Level = Level()
    table: Path | None = None
    target: Target | None = None
    """Left out, the whole of ``coupon.sweep`` is run."""

    @model_validator(mode="after")
    def _target(self) -> Damping:
        if self.target is not None and "dem" not in self.readings:
            raise ValueError("target: goes with the reading 'dem'")
        return self

    @model_validator(mode="after")
    def _table(self) -> Damping:
        if len(set(self.readings)) != len(self.readings):
            raise ValueError(f"readings = {list(self.readings)}: each one once")
        if ("table" in self.readings) != (self.table is not None):
            raise ValueError("table: a CSV file, given together with the reading 'table'")
        return self
