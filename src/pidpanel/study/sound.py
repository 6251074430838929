"""The section ``sound`` of a study: a spectrum, its level and its field."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from pidpanel.study.base import Model, Positive


class Sound(Model):
    """The acoustic field: a band spectrum, its level, its coherence, where it was measured."""

    spectrum: Path
    oaspl_db: Annotated[float, Field(ge=60, le=200)] | None = None
    """Overall level the spectrum is shifted to; left out, the table's own."""
    shift_db: Annotated[float, Field(ge=-60, le=60)] = 0.0
    """Every band higher by so much, such as +3 dB for protoqualification; not with oaspl_db."""
    field: Literal["diffuse", "uncorrelated", "uniform", "plane_wave", "progressive_wave"] = (
        "diffuse"
    )
    """progressive_wave: a plane wave that grazes the panel, as in a progressive-wave tube."""
    incidence_deg: Annotated[float, Field(ge=0, le=90)] | None = None
    """Angle from the panel's normal at which a plane wave comes."""
    azimuth_deg: Annotated[float, Field(ge=-180, le=360)] | None = None
    """Direction in the plane of the panel, from x, in which a wave runs."""
    loaded_sides: Literal[1, 2] = 1
    """2: independent fields of that level on both faces, twice the PSD."""
    pressure_reference: Literal["surface", "room", "incident"] = "surface"
    speed_m_s: Positive = 343.0
    air_density_kg_m3: Positive = 1.2

    @property
    def incidence(self) -> float:
        """rad; a right angle for a progressive wave."""
        return math.radians(90.0 if self.incidence_deg is None else self.incidence_deg)

    @property
    def azimuth(self) -> float:
        """rad."""
        return math.radians(self.azimuth_deg or 0.0)

    @model_validator(mode="after")
    def _one_level_one_wave(self) -> Sound:
        if self.oaspl_db is not None and self.shift_db != 0:
            raise ValueError(
                f"oaspl_db = {self.oaspl_db:g} and shift_db = {self.shift_db:g}: one of the two"
            )
        if (self.field == "plane_wave") != (self.incidence_deg is not None):
            raise ValueError("incidence_deg goes with field: plane_wave, and only with it")
        if self.azimuth_deg is not None and not self.field.endswith("_wave"):
            raise ValueError("azimuth_deg goes with field: plane_wave or progressive_wave only")
        return self
