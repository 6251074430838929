"""The section ``sound`` of a study: a spectrum, its level and its field."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pidpanel.paths import DATA
from pidpanel.study.base import Level, SectionModel, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity

SPEED = 343.0  # of sound in air [m/s]


class Sound(SectionModel):
    """The acoustic field: a spectrum, its level, its coherence, where it was measured."""

    spectrum: Annotated[Path, file_in(DATA / "spl")]
    """CSV table of octave or third-octave levels, or of a pressure PSD (``frequency_hz``,
    ``psd_pa2_hz``), relative to the study or from pidpanel."""
    oaspl_db: Level | None = None
    """Overall level to which the spectrum is shifted [dB]; by default that of the table."""
    shift_db: Annotated[float, Quantity(-60, 60)] = 0.0
    """Shift of every band [dB], such as 3 for protoqualification; not together with oaspl_db."""
    field: Literal["diffuse", "uncorrelated", "uniform", "plane_wave", "progressive_wave"] = (
        "diffuse"
    )
    """``diffuse``: waves from all directions equally; ``uncorrelated``: the paper's, without
    coherence; ``uniform``: in phase everywhere; ``plane_wave``: from ``incidence_deg``;
    ``progressive_wave``: a plane wave at grazing incidence, as in a progressive-wave tube."""
    incidence_deg: Annotated[float, Quantity(0, 90)] | None = None
    """Angle between the direction of a plane wave and the normal of the panel [°]."""
    azimuth_deg: Annotated[float, Quantity(-180, 360)] | None = None
    """Direction of a wave in the plane of the panel, from x [°]; 0 by default."""
    loaded_sides: Literal[1, 2] = 1
    """2: independent fields of that level on both faces, twice the PSD."""
    pressure_reference: Literal["surface", "room", "incident"] = "surface"
    """Where the levels of the table were measured. ``surface``: on the panel; ``room``: far from it
    in a diffuse field, so a rigid face has twice the PSD; ``incident``: an incoming wave alone,
    so it has four times the PSD."""
    speed_m_s: Annotated[float, Quantity(100, 1400, unit="velocity")] = SPEED
    """Speed of sound [m/s]."""
    air_density_kg_m3: Annotated[float, Quantity(0.01, 50, unit="density")] = 1.2
    """Density of the air [kg/m³]."""

    @property
    def incidence(self) -> float:
        """Angle of incidence [rad]; a right angle for a progressive wave."""
        return math.radians(90.0 if self.incidence_deg is None else self.incidence_deg)

    @property
    def azimuth(self) -> float:
        """Direction in the plane of the panel, from x [rad]."""
        return math.radians(self.azimuth_deg or 0.0)

    def mistakes(self) -> Iterator[Mistake]:
        if self.oaspl_db is not None and self.shift_db != 0:
            yield Mistake(("shift_db",), f"not allowed together with oaspl_db = {self.oaspl_db:g}")
        if (self.field == "plane_wave") != (self.incidence_deg is not None):
            message = "required for field: plane_wave, not allowed otherwise"
            yield Mistake(("incidence_deg",), message)
        if self.azimuth_deg is not None and not self.field.endswith("_wave"):
            message = "only allowed for field: plane_wave or progressive_wave"
            yield Mistake(("azimuth_deg",), message)
