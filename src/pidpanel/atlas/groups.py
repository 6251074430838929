"""Dimensionless groups of a bed of hard particles in a closed cell under a sine.

Density and size of hard particles enter through nothing else. What is left of them is the hardness,
ρ(ωW)²/E: how long contacts last and how deep they are.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeVar

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY

Direction = Literal["flat", "upright", "none"]  # of gravity: along the motion, across it, or none
Real = TypeVar("Real", float, Array)

# Contact over the period and overlap over the radius up to which results do not depend on them;
# (1 − ν²)ρd/E over that of the atlas, up to which contacts are about as short as its own.
SHORT_CONTACT, SMALL_OVERLAP, SOFTEST = 0.02, 0.05, 3.0
# 2 ∫₀¹ dx/√(1 − x^{5/2}): duration of a Hertz contact in units of δ_max/v.
HERTZ_DURATION = 2.9432750


@dataclass(frozen=True)
class ElasticSphere:
    """A sphere by what its contacts depend on.

    Examples
    --------
    >>> f"{ElasticSphere(1e-3, 1190.0, 5e7, 0.35).rayleigh_time:.4g}"
    '2.697e-05'
    """

    radius: float  # R [m]
    density: float  # ρ [kg/m³]
    youngs_modulus: float  # E [Pa]
    poissons_ratio: float  # ν [1]

    @property
    def softness(self) -> float:
        """(1 − ν²) ρ R/E, the square of a time over a length [s²/m]."""
        return (1 - self.poissons_ratio**2) * self.density * self.radius / self.youngs_modulus

    @property
    def rayleigh_time(self) -> float:
        """Time in which a Rayleigh wave runs half round the sphere [s].

        T_R = π R √(ρ/G) / (0.1631 ν + 0.8766), G = E/(2(1+ν)): the measure with which LIGGGHTS'
        ``fix check/timestep/gran`` compares the time step.
        """
        shear_modulus = self.youngs_modulus / (2 * (1 + self.poissons_ratio))
        wave = math.sqrt(self.density / shear_modulus)
        return math.pi * self.radius * wave / (0.1631 * self.poissons_ratio + 0.8766)

    def wall_overlap(self, speed: Real) -> Real:
        """Return the deepest overlap where it hits a wall of its own material head-on [m].

        ½ m v² = (8/15) E* √R δ^{5/2} with E* = E/(2(1−ν²)); Johnson, *Contact Mechanics* (1985),
        eq. 11.22.
        """
        mass = self.density * 4 / 3 * math.pi * self.radius**3
        effective_modulus = self.youngs_modulus / (2 * (1 - self.poissons_ratio**2))
        return (15 * mass * speed**2 / (16 * effective_modulus * math.sqrt(self.radius))) ** 0.4

    def wall_contact_time(self, speed: Real) -> Real:
        """Return the duration of that impact [s]: t_c = 2.943 δ_max / v (Johnson, eq. 11.24)."""
        return HERTZ_DURATION * self.wall_overlap(speed) / speed


USUAL = ElasticSphere(1e-3, 1190.0, 3.2e9, 0.35)  # of the cases of the atlas


def is_hard(sphere: ElasticSphere, frequency: Array, gamma: float, gravity: float = 1.0) -> Flags:
    """Return (n,) whether a bed is no softer than those of the atlas at frequencies (n,) [Hz].

    By its impact at ωW on a wall of its own material. Under some times g it is as soft as one under
    1 g with its modulus over that.
    """
    speed = gamma * STANDARD_GRAVITY / (2 * math.pi * frequency)
    is_short: Flags = sphere.wall_contact_time(speed) * frequency <= SHORT_CONTACT
    is_short = is_short & (sphere.wall_overlap(speed) <= SMALL_OVERLAP * sphere.radius)
    return is_short | (sphere.softness * gravity <= SOFTEST * USUAL.softness)
