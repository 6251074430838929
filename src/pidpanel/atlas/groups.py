"""Dimensionless groups of a bed of hard particles in a closed cell under a sine.

Density and size of hard particles enter through nothing else. What is left of them is the hardness,
ρ(ωW)²/E: how long contacts last and how deep they are.
"""

import math
from dataclasses import dataclass
from typing import Literal

from pidpanel.constants import STANDARD_GRAVITY

Direction = Literal["flat", "upright", "none"]
# Size [g] and direction of gravity; the motion is along z.
GRAVITY: dict[Direction, tuple[float, str]] = {
    "flat": (1.0, "0 0 -1"),
    "upright": (1.0, "1 0 0"),
    "none": (0.0, "0 0 -1"),
}


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
    """Displacement amplitude W [m]."""
    gap = (1 - groups.fill_fraction) * groups.depth * bead.diameter
    return groups.stroke_per_gap * gap


def angular_frequency(groups: Groups, bead: Bead) -> float:
    """ω = √(Γg/W) [rad/s].

    Examples
    --------
    >>> groups = Groups(0.5, 20.0, 0.01, 0.8, 0.3, 3.0, 12.5, "flat")
    >>> round(angular_frequency(groups, Bead()) / (2 * math.pi), 1)
    199.4
    """
    return math.sqrt(groups.gamma * STANDARD_GRAVITY / stroke(groups, bead))


def frequency(groups: Groups, bead: Bead) -> float:
    """Frequency of the drive [Hz]."""
    return angular_frequency(groups, bead) / (2 * math.pi)


def speed(groups: Groups, bead: Bead) -> float:
    """Velocity amplitude ωW [m/s]."""
    return angular_frequency(groups, bead) * stroke(groups, bead)
