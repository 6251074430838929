"""Data of a study for its runs."""

from collections.abc import Mapping
from dataclasses import dataclass

from pidpanel.coupon.bed import Bed
from pidpanel.damping.models import FilledDamper
from pidpanel.damping_ratio import DampingRatio


@dataclass(frozen=True)
class RunSettings:
    """Settings that all runs of a study share."""

    frequency_range: tuple[float, float]  # lowest and highest frequency [Hz]
    damping_ratio: DampingRatio  # ζ of the bare panel [1]
    wave_speed: float  # speed of the waves that excite the panel [m/s]
    # Time of a run: evaluated, and before that [s]
    duration: float
    settling: float
    # Numbers per patch
    stations: int
    cells: int
    # Modulus of the contacts [Pa]; None for the softest that is accurate enough
    youngs_modulus: float | None
    attributes: Mapping[str, str]  # of the records


@dataclass(frozen=True)
class SimulatedPatch:
    """A patch whose particles are simulated."""

    name: str
    youngs_modulus: float  # of the particles [Pa]
    beds: tuple[Bed, ...]  # one for each run


@dataclass(frozen=True)
class CoupledScenario:
    """A scenario whose panel and particles are integrated together."""

    name: str  # folder below ``results/<study>/coupled``
    factor: float  # PSD of the excitation over that of the study [1]
    patches: tuple[SimulatedPatch, ...]
    dampers: Mapping[str, FilledDamper]  # without simulated particles, by patch

    @property
    def beds(self) -> list[tuple[Bed, ...]]:
        """Beds of the patches, by run."""
        return list(zip(*(patch.beds for patch in self.patches), strict=True))
