"""The section ``severity`` of a study: results from the responses in addition to rms values."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, ClassVar

from pidpanel.study.base import SectionModel, file_in
from pidpanel.study.base_motion import GRms
from pidpanel.study.quantity import Quantity

# Least product of the lowest frequency and the duration: the largest peak of fewer cycles is not
# that of its formula.
LEAST_CYCLES = 100.0


class Fatigue(SectionModel):
    """An S-N line N = cycles (A/stress_mpa)^−exponent for the amplitude A, at zero mean stress."""

    stress_mpa: Annotated[float, Quantity(0.1, 5000, unit="megapascal")]
    """Amplitude, half the range, at which failure takes ``cycles`` [MPa]."""
    cycles: Annotated[float, Quantity(1, 1e12)] = 1e6
    """Cycles to failure at that amplitude."""
    exponent: Annotated[float, Quantity(1, 30)]
    """b of the line: 4 to 10 for metals."""


Strength = Annotated[float, Quantity(0.01, 1e5, unit="megapascal")]  # [MPa]


class PlyStrength(SectionModel):
    """Strength of a ply or of an isotropic layer, along (1) and across (2) its fibres."""

    tension_1_mpa: Strength
    """X_t [MPa]."""
    compression_1_mpa: Strength
    """X_c, positive [MPa]."""
    tension_2_mpa: Strength
    """Y_t [MPa]."""
    compression_2_mpa: Strength
    """Y_c, positive [MPa]."""
    shear_mpa: Strength
    """S [MPa]."""


class CoreStrength(SectionModel):
    """Shear strength of the core."""

    shear_xz_mpa: Strength
    """In planes normal to x [MPa]."""
    shear_yz_mpa: Strength
    """In planes normal to y [MPa]."""


class Strengths(SectionModel):
    """Strengths that 3σ stresses at the points are compared with."""

    layers: PlyStrength | None = None
    """Strength of all layers but the core."""
    core: CoreStrength | None = None
    """Strength of the core of a sandwich."""
    needed: ClassVar = ("layers", "core")


class Severity(SectionModel):
    """Oscillator spectra, peaks in a duration, fatigue, failure indices."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "limits": "is a top-level section now: limits: {A1: {psd: limit.csv}}; a point may have "
        "rms_g too"
    }

    quality: Annotated[float, Quantity(1, 1000)] = 10.0
    """Q of the oscillators of the vibration response spectrum, 1/2ζ."""
    duration_s: Annotated[float, Quantity(0.1, 1e7)] = 60.0
    """Duration of the sound at its level, for peaks and damage [s]."""
    fatigue: Fatigue | None = None
    """S-N line of the stresses at the points; without it, no damage is computed."""
    strength: Strengths | None = None
    """Strengths of layers and core; without them, no failure index is computed."""


class AccelerationLimit(SectionModel):
    """Largest acceleration allowed at a response point, under sound and random base motion."""

    rms_g: GRms | None = None
    """Largest rms acceleration over the frequencies of the response [g rms]."""
    psd: Annotated[Path, file_in()] | None = None
    """CSV table of the largest PSD: ``frequency_hz``, ``acceleration_psd_g2_hz`` and optionally
    ``slope_db_octave``."""
    needed: ClassVar = ("rms_g", "psd")

    @property
    def text(self) -> str:
        """The limit in words."""
        rms = [] if self.rms_g is None else [f"{self.rms_g:g} g rms"]
        return " and ".join(rms if self.psd is None else [*rms, f"the PSD of {self.psd.name}"])


def limit_tables(limits: Mapping[str, AccelerationLimit]) -> dict[str, Path]:
    """Return the tables of the largest PSDs by point."""
    return {point: limit.psd for point, limit in limits.items() if limit.psd is not None}
