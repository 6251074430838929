"""Viscoelastic impacts of spheres of one size: the faster, the lower their restitution.

LIGGGHTS' ``hertz/stiffness`` adds to Hertz's force k δ^{3/2} a viscous one, (3/2) A k √δ δ̇, with
k = (4/3) E* √R*. This is the contact of Kuwabara & Kono, Jpn. J. Appl. Phys. 26, 1230 (1987), and
Brilliantov et al., Phys. Rev. E 53, 5382 (1996). In units of the overlap (m* v²/k)^{2/5} and the
speed of impact v

    x″ = −x^{3/2} − b √x x′,   b = (3/2) A (k/m*)^{2/5} v^{1/5},

so e depends on b alone. A modulus that is softened, with A such that e is the stated one at its
speed, changes e at no other speed.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class ViscoelasticImpacts:
    """Speed of impact [m/s] at which e is stated, and the spheres: R [m], ρ [kg/m³]."""

    speed: float
    radius: float
    density: float

    def effective_mass(self, *, at_wall: bool) -> float:
        """Return m* of two spheres or of a sphere at a wall [kg]."""
        mass = self.density * 4 / 3 * math.pi * self.radius**3
        return mass if at_wall else mass / 2

    def viscosity(self, effective_modulus: float, restitution: float, *, at_wall: bool) -> float:
        """Return 2 E* A for E* [Pa] and e at the stated speed: viscous force over √(R* δ) δ̇ [Pa s].

        Examples
        --------
        >>> impacts = ViscoelasticImpacts(speed=1.0, radius=1e-3, density=1190.0)
        >>> round(impacts.viscosity(2.8e7, 0.8, at_wall=True), 1)
        207.6
        """
        radius = self.radius if at_wall else self.radius / 2
        stiffness = 4 / 3 * effective_modulus * math.sqrt(radius)
        rate = (stiffness / self.effective_mass(at_wall=at_wall)) ** 0.4 * self.speed**0.2
        return 4 / 3 * effective_modulus * viscous_group(restitution) / rate


def rebound(group: float) -> float:
    """Return e of an impact with b; it ends where the overlap does, as in LIGGGHTS.

    Examples
    --------
    >>> round(rebound(0.1), 4)
    0.8921
    """
    from scipy.integrate import solve_ivp

    def slope(_: float, state: Array) -> Array:
        depth, speed = state
        return np.array([speed, -math.sqrt(max(depth, 0.0)) * (depth + group * speed)])

    def overlap(_: float, state: Array) -> float:
        return float(state[0])

    overlap.terminal, overlap.direction = True, -1  # type: ignore[attr-defined]
    impact = solve_ivp(slope, (0, 100), [0, 1], events=overlap, rtol=1e-9, atol=1e-12)
    return float(-impact.y[1, -1])


@lru_cache
def viscous_group(restitution: float) -> float:
    """Return b of an impact with e from 0.05 to 1 [1].

    Examples
    --------
    >>> round(rebound(viscous_group(0.8)), 6)
    0.8
    """
    from scipy.optimize import brentq

    if restitution == 1:
        return 0.0
    return float(brentq(lambda group: rebound(group) - restitution, 0, 3, xtol=1e-10))
