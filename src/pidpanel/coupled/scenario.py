"""What the runs of a study need of it, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pidpanel.coupon.bed import Bed
from pidpanel.damping.readings import DampingReading


@dataclass(frozen=True)
class RunSettings:
    """Settings that all runs of a study share.

    Attributes
    ----------
    frequency_range
        Lowest and highest frequency [Hz].
    damping_ratio
        ζ of the bare panel [1].
    wave_speed
        Speed of the waves that excite the panel [m/s].
    duration, settling
        Of a run, evaluated and before that [s].
    stations, cells
        Of a patch.
    youngs_modulus
        Of the contacts [Pa]; None for the softest that is accurate enough.
    attributes
        Of the records.
    """

    frequency_range: tuple[float, float]
    damping_ratio: float
    wave_speed: float
    duration: float
    settling: float
    stations: int
    cells: int
    youngs_modulus: float | None
    attributes: Mapping[str, str]


@dataclass(frozen=True)
class SimulatedPatch:
    """A patch whose particles are simulated.

    Attributes
    ----------
    youngs_modulus
        Of the particles [Pa].
    beds
        One for each run.
    """

    name: str
    fill_fraction: float
    youngs_modulus: float
    beds: tuple[Bed, ...]


@dataclass(frozen=True)
class GivenDamper:
    """A damper without simulated particles, on a patch."""

    patch: str
    model: DampingReading
    fill_fraction: float


@dataclass(frozen=True)
class CoupledScenario:
    """A scenario whose panel and particles are integrated together.

    Attributes
    ----------
    name
        Folder below ``results/<study>/coupled``.
    factor
        PSD of the excitation over that of the study [1].
    """

    name: str
    factor: float
    patches: tuple[SimulatedPatch, ...]
    dampers: tuple[GivenDamper, ...]

    @property
    def beds(self) -> list[tuple[Bed, ...]]:
        """Beds of the patches, by run."""
        return list(zip(*(patch.beds for patch in self.patches), strict=True))
