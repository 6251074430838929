"""Motion of a coupon.

A drive is known by its values alone: a frozen dataclass of numbers, which goes to JSON and back as
it is. All that the coupon asks of a drive is below.

`frequency`, `period`, `angular_frequency`
    The repetition of the motion: the length of a row of the cycle file, of a time step, of the
    window of the energy balance.
`acceleration`, `speed`, `amplitude`, `gamma`
    The size of the motion at the frequency of the row: whether the contacts are softened, the speed
    of the impacts by which contact time and overlap are judged, the scale of C_e and m_a.
`acceleration_at`
    The motion itself over its phase, for the work of the inertial force.
`label`
    The drive as part of the label of a case.

C_e and m_a are read from the first harmonic of a row (`cycles.first_harmonic`): a drive with more
than one tone needs a way of its own to be read. A study's sweep becomes drives in `from_study`.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY


@dataclass(frozen=True)
class Tone:
    """A sinusoidal motion w = W sin ωt along z.

    Examples
    --------
    >>> tone = Tone(frequency=100.0, acceleration=10 * STANDARD_GRAVITY)
    >>> round(tone.speed, 4), round(tone.amplitude * 1e3, 4), round(tone.gamma, 9)
    (0.1561, 0.2484, 10.0)
    >>> tone.label
    'f100Hz_a10g'
    """

    frequency: float  # f [Hz]
    acceleration: float  # amplitude ω²W of the acceleration [m/s²]
    kind: Literal["tone"] = "tone"

    @property
    def angular_frequency(self) -> float:
        """ω = 2πf [rad/s]."""
        return 2 * math.pi * self.frequency

    @property
    def period(self) -> float:
        """1/f [s]."""
        return 1 / self.frequency

    @property
    def speed(self) -> float:
        """Return the velocity amplitude ωW [m/s]."""
        return self.acceleration / self.angular_frequency

    @property
    def amplitude(self) -> float:
        """Return the displacement amplitude W [m]."""
        return self.acceleration / self.angular_frequency**2

    @property
    def gamma(self) -> float:
        """Acceleration amplitude over standard gravity, Γ = ω²W/g [1]."""
        return self.acceleration / STANDARD_GRAVITY

    @property
    def label(self) -> str:
        """Part of the label of a case: ``f100Hz_a10g``."""
        return f"f{self.frequency:g}Hz_a{self.gamma:.4g}g"

    def acceleration_at(self, phase: Array) -> Array:
        """Return the acceleration ω²W sin φ of the inertial force in the frame of the cells [m/s²].

        The cells accelerate by −ω²W sin φ, so what is seen from them is driven the other way.
        """
        return self.acceleration * np.sin(phase)
