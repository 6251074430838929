"""The points at which a coupon is shaken."""

import bisect
import math
from collections.abc import Iterator
from typing import Annotated

from pydantic import Field

from pidpanel.constants import LARGEST_GAMMA, STANDARD_GRAVITY
from pidpanel.study.base import Fill, SectionModel
from pidpanel.study.choice import Choice
from pidpanel.study.mistakes import Mistake
from pidpanel.study.particles import Diameter
from pidpanel.study.quantity import GRAVITIES, KILOHERTZ, MILLIMETRES, VELOCITY, Quantity

Frequency = Annotated[float, Quantity(1, 20000, units=KILOHERTZ)]  # of a drive [Hz]
MOST_VALUES = 10_000  # values that a range may have


class Range(SectionModel):
    """Equally spaced values: ``{from: 5, to: 2000, step: 10}``."""

    start: Frequency = Field(alias="from")
    """First value [Hz]."""
    stop: Frequency = Field(alias="to")
    """Largest value [Hz]; included if it is a whole number of steps away."""
    step: Annotated[float, Quantity(1e-3, 20000)]
    """Step between values [Hz]."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.stop < self.start:
            yield Mistake(("to",), f"must be at least from = {self.start:g}")
        elif self.count > MOST_VALUES:
            yield Mistake((), f"has {self.count} values; allowed are {MOST_VALUES}")

    @property
    def count(self) -> int:
        """Number of the values."""
        return int((self.stop - self.start) / self.step * (1 + 1e-12)) + 1

    def values(self) -> tuple[float, ...]:
        """Return the values, the end among them if it is a whole number of steps away.

        Examples
        --------
        >>> Range(**{"from": 1, "to": 1.3, "step": 0.1}).values()
        (1.0, 1.1, 1.2, 1.3)
        """
        return tuple(round(self.start + i * self.step, 9) for i in range(self.count))


# Amplitude of an acceleration [g].
Gamma = Annotated[float, Quantity(0, LARGEST_GAMMA, low_itself=False, units=GRAVITIES)]
# Of a displacement [mm].
Amplitude = Annotated[float, Quantity(0, 1000, low_itself=False, units=MILLIMETRES)]

# Frequencies and amplitudes of a sweep, below which an interpolation cannot be checked.
LEAST_VALUES = 3


class Sweep(SectionModel):
    """The points at which the coupon is shaken: every combination of the lists."""

    fill_fraction: Annotated[tuple[Fill, ...], Field(min_length=1)] = (0.1, 0.3, 0.5, 0.7, 0.9)
    """Fill fractions r: number of particles over that of a full cell."""
    frequency_hz: Annotated[Range | Annotated[tuple[Frequency, ...], Field(min_length=1)], Choice()]
    """Frequencies of the drive [Hz], as a list or as a range."""
    acceleration_g: tuple[Gamma, ...] = ()
    """Amplitude Γ of the acceleration, in units of standard gravity."""
    displacement_mm: tuple[Amplitude, ...] = ()
    """Amplitude W of the displacement [mm], instead of that of the acceleration."""
    diameter_mm: tuple[Diameter, ...] = ()
    """Diameters of the particles [mm]; by default ``particles.diameter_mm``."""
    max_velocity_m_s: Annotated[float, Quantity(1e-3, 1000, units=VELOCITY)] | None = None
    """Combinations with a larger velocity amplitude a/ω are omitted [m/s]."""

    @property
    def accelerations(self) -> tuple[float, ...]:
        """Amplitudes of the acceleration [m/s²]."""
        return tuple(level * STANDARD_GRAVITY for level in self.acceleration_g)

    @property
    def displacements(self) -> tuple[float, ...]:
        """Amplitudes of the displacement [m]."""
        return tuple(amplitude * 1e-3 for amplitude in self.displacement_mm)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies [Hz], a range of them written out."""
        if isinstance(self.frequency_hz, Range):
            return self.frequency_hz.values()
        return self.frequency_hz

    @property
    def is_coarse(self) -> bool:
        """Whether no case has neighbours on both sides in frequency and in amplitude.

        The error of an interpolation between the cases is then not known: none can be predicted
        from the others.
        """
        amplitudes = self.acceleration_g or self.displacement_mm
        return min(len(set(self.frequencies)), len(set(amplitudes))) < LEAST_VALUES

    def drive_count(self) -> int:
        """Return the number of combinations of frequency and amplitude that are not left out."""
        fastest = self.max_velocity_m_s or math.inf
        W, a = sorted(self.displacements), sorted(self.accelerations)
        return sum(
            bisect.bisect_right(W, fastest / omega) + bisect.bisect_right(a, fastest * omega)
            for omega in (2 * math.pi * frequency for frequency in self.frequencies)
        )

    def slowest(self) -> float:
        """Return the least velocity amplitude of all combinations [m/s]."""
        omega = [2 * math.pi * frequency for frequency in self.frequencies]
        if self.displacements:
            return min(omega) * min(self.displacements)
        return min(self.accelerations) / max(omega)

    def _mistakes_of_displacements(self) -> Iterator[Mistake]:
        """Yield displacements with an acceleration that no shaker and no panel has."""
        omega = 2 * math.pi * max(self.frequencies)
        fastest = self.max_velocity_m_s or math.inf
        for index, amplitude in enumerate(self.displacements):
            gamma = min(amplitude * omega, fastest) * omega / STANDARD_GRAVITY
            if gamma > LARGEST_GAMMA:
                longest = 1e3 * LARGEST_GAMMA * STANDARD_GRAVITY / omega**2
                says = (
                    f"{gamma:.3g} g at {max(self.frequencies):g} Hz; at most {LARGEST_GAMMA:g} g, "
                )
                says += f"{longest:.2g} mm there; max_velocity_m_s omits fast combinations"
                yield Mistake(("displacement_mm", index), says)

    def mistakes(self) -> Iterator[Mistake]:
        keys = self.model_fields_set
        if self.acceleration_g and self.displacement_mm:
            yield Mistake(("displacement_mm",), "not allowed together with acceleration_g")
        yield from self._mistakes_of_displacements()
        if not self.acceleration_g and not self.displacement_mm:
            says = "must have at least 1 value" if "acceleration_g" in keys else "missing"
            yield Mistake(("acceleration_g",), f"{says}; required unless displacement_mm is given")
        for key, values in self:
            texts: set[str] = set()
            for index, value in enumerate(values if isinstance(values, tuple) else ()):
                text = f"{value:.6g}"
                if text in texts:
                    says = "duplicate value; its cases would have the same labels"
                    yield Mistake((key, index), says)
                texts.add(text)


# Of a coupon that names none: coarse, from below the first mode of a panel to 2 kHz.
USUAL_SWEEP = Sweep(
    frequency_hz=(30, 80, 250, 700, 2000), acceleration_g=(4, 20, 120, 700), max_velocity_m_s=7
)
