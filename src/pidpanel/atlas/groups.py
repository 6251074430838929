"""Dimensionless groups of a bed of hard particles in a closed cell under a sine.

Density and size of hard particles enter through nothing else. What is left of them is the hardness,
ρ(ωW)²/E: how long contacts last and how deep they are.
"""

import math
from dataclasses import dataclass
from typing import Literal

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY

Direction = Literal["flat", "upright", "none"]
# Size [g] and direction of gravity; the motion is along z.
GRAVITY: dict[Direction, tuple[float, str]] = {
    "flat": (1.0, "0 0 -1"),
    "upright": (1.0, "1 0 0"),
    "none": (0.0, "0 0 -1"),
}

# Contact over the period and overlap over the radius up to which results do not depend on them;
# (1 − ν²)ρd/E over that of the atlas, up to which contacts are about as short as its own.
SHORT_CONTACT, SMALL_OVERLAP, SOFTEST = 0.02, 0.05, 3.0
# 2 ∫₀¹ dx/√(1 − x^{5/2}): duration of a Hertz contact in units of δ_max/v.
HERTZ_DURATION = 2.9432750


@dataclass(frozen=True)
class Groups:
    """Groups of a bed; restitution and friction are also those of the walls."""

    fill_fraction: float  # r
    gamma: float  # Γ = ω²W/g, with standard gravity even where there is none
    stroke_per_gap: float  # W/L with the clear gap L = (1 − r) depth
    restitution: float  # e
    friction: float  # μ
    width: float  # of the cell, over the diameter of a particle
    depth: float  # likewise
    direction: Direction  # of gravity: along the motion, across it, or none


@dataclass(frozen=True)
class Bead:
    """A particle that gives the groups a scale."""

    diameter: float = 2e-3  # [m]
    density: float = 1190.0  # [kg/m³]
    youngs_modulus: float = 3.2e9  # [Pa]
    poissons_ratio: float = 0.35


def stroke(groups: Groups, bead: Bead) -> float:
    """Return the displacement amplitude W [m]."""
    gap = (1 - groups.fill_fraction) * groups.depth * bead.diameter
    return groups.stroke_per_gap * gap


def angular_frequency(groups: Groups, bead: Bead) -> float:
    """Return ω = √(Γg/W) [rad/s].

    Examples
    --------
    >>> groups = Groups(0.5, 20.0, 0.01, 0.8, 0.3, 3.0, 12.5, "flat")
    >>> round(angular_frequency(groups, Bead()) / (2 * math.pi), 1)
    199.4
    """
    return math.sqrt(groups.gamma * STANDARD_GRAVITY / stroke(groups, bead))


def frequency(groups: Groups, bead: Bead) -> float:
    """Return the frequency of the drive [Hz]."""
    return angular_frequency(groups, bead) / (2 * math.pi)


def speed(groups: Groups, bead: Bead) -> float:
    """Return the velocity amplitude ωW [m/s]."""
    return angular_frequency(groups, bead) * stroke(groups, bead)


def is_hard(bead: Bead, frequency: Array, gamma: float) -> Flags:
    """Return (n,) whether a bed is no softer than those of the atlas at frequencies (n,) [Hz].

    Of a particle that hits a wall of its own material at ωW: δ/R = (5π/2 (1 − ν²) ρ v²/E)^0.4 and
    2.943 δ/v (Johnson, *Contact Mechanics* (1985), eq. 11.22 and 11.24).
    """
    per_square, usual = (
        (1 - particle.poissons_ratio**2) * particle.density / particle.youngs_modulus
        for particle in (bead, Bead())
    )
    v = gamma * STANDARD_GRAVITY / (2 * math.pi * frequency)
    overlap = (2.5 * math.pi * per_square * v**2) ** 0.4
    contact = HERTZ_DURATION * overlap * bead.diameter / 2 / v * frequency
    is_short: Flags = (overlap <= SMALL_OVERLAP) & (contact <= SHORT_CONTACT)
    return is_short | (per_square * bead.diameter <= SOFTEST * usual * Bead().diameter)
