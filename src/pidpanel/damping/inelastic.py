"""Closed forms of the perfectly inelastic body, to which the bed of a damper comes close.

A body that does not rebound forgets its past at each landing, so its periodic motion under
w = A sin ωt follows from one flight. Energies are per cycle, over m A² ω².
"""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from pidpanel.arrays import Array

# L/A = √(π² + 4) = 3.724: beyond it the body no longer meets both walls in every cycle.
LONGEST_GAP = math.sqrt(math.pi**2 + 4)

# Γ = √(1 + π²) = 3.297: beyond it a flight is longer than a period.
LARGEST_GAMMA = math.sqrt(1 + math.pi**2)


def slug_energy(gap_over_amplitude: float) -> float:
    """Return the loss of an inelastic body between two shaken walls without gravity [m A²ω²].

    It leaves a wall at the wall's greatest speed Aω and meets the other one φ later:

        L/A = φ − sin φ,  E = (1 − cos φ)² m A²ω²                  for L/A ≤ π
        L/A = π cos t + 2 sin t,  E = 4 cos² t m A²ω²              for π < L/A ≤ √(π² + 4)

    In the second range it lands when that wall has passed its greatest speed, so that it leaves at
    once, t after it. The largest loss, 4 m A²ω², is at L = πA: "collect and collide" (Sack, Heckel,
    Kollmer, Zimber & Pöschel, *Phys. Rev. Lett.* 111, 018001 (2013)). Outside 0 < L/A ≤ √(π² + 4) a
    `ValueError` is raised.

    Examples
    --------
    >>> round(slug_energy(math.pi), 9), round(slug_energy(1.0), 6)
    (4.0, 1.838186)
    """
    energy, _ = slug(gap_over_amplitude)
    return float(energy)


def slug(gap_over_amplitude: ArrayLike) -> tuple[Array, Array]:
    """Return loss [m A²ω²] and apparent mass [m] of the body of `slug_energy` at each L/A.

    With θ = ωt from the instant at which a wall has its greatest speed, the body moves at Aω for 0
    < θ < φ and with the other wall, at Aω cos θ, for φ < θ < π; in the second half the same the
    other way. The first harmonic of its momentum in phase with the wall is then

        m_a/m = (2/π) ∫ v cos θ dθ/(Aω) = (2/π)(sin φ + (π − φ)/2 − sin(2φ)/4)    for L/A ≤ π
        m_a/m = −(2/π) sin 2t                                    for π < L/A ≤ √(π² + 4)

    From m for no gap it falls through 0 and is negative beyond L = πA.

    Examples
    --------
    >>> energy, mass = slug(math.pi)
    >>> round(float(energy), 9), round(float(mass), 9)
    (4.0, 0.0)
    """
    gap = np.asarray(gap_over_amplitude, float)
    bad = gap[~((gap > 0) & (gap <= LONGEST_GAP))]
    if bad.size:
        raise ValueError(f"L/A = {bad.flat[0]:g}: above 0, up to {LONGEST_GAP:.4g}")
    phase = _landing(np.minimum(gap, math.pi))
    late = math.atan(2 / math.pi) - np.arccos(np.minimum(gap / LONGEST_GAP, 1.0))
    early = gap <= math.pi
    energy = np.where(early, (1 - np.cos(phase)) ** 2, 4 * np.cos(late) ** 2)
    sine_part = np.sin(phase) + (math.pi - phase) / 2 - np.sin(2 * phase) / 4
    mass = 2 / math.pi * np.where(early, sine_part, -np.sin(2 * late))
    return energy, mass


def _landing(gap: Array) -> Array:
    """Return φ of φ − sin φ = L/A ≤ π by Newton's method.

    φ − sin φ is convex, so that from above every step stays above: φ³/6 ≥ φ − sin φ makes
    (6L/A)^(1/3) at most φ, and φ at most 1.19 of it.
    """
    phase = np.minimum(1.2 * np.cbrt(6 * gap), math.pi)
    for _ in range(8):
        phase = phase - (phase - np.sin(phase) - gap) / (1 - np.cos(phase))
    return phase


def thrown_height(gamma: ArrayLike) -> Array:
    """Return the largest height over A (n,) of an inelastic body thrown by a floor, Γ = Aω²/g.

    It leaves the floor at sin φ₀ = 1/Γ, and the floor goes on in its period:

        H/A = max sin φ₀ + τ cos φ₀ − τ²/(2Γ) − sin(φ₀ + τ),  0 ≤ τ ≤ 2π

    So it reaches the lid at L within a period if H ≥ L. Without gravity, Γ = ∞, it always does so
    for L/A below 2π.

    Examples
    --------
    >>> thrown_height([1.0, 1.8, 4.6, 1e9]).round(2)
    array([0.  , 0.98, 3.41, 6.28])
    """
    start = np.arcsin(1 / np.asarray(gamma, float))[:, None]
    phase = np.linspace(0, 2 * np.pi, 181)
    flight = np.sin(start) + phase * np.cos(start) - phase**2 * np.sin(start) / 2
    return np.asarray((flight - np.sin(start + phase)).max(axis=1))


def floor_energy(gamma: float) -> float:
    """Return the loss of an inelastic body on a shaken floor under gravity [m A²ω²], Γ = Aω²/g.

    It leaves the floor at the phase φ₀ at which the floor falls away, sin φ₀ = 1/Γ, lands τ later
    in phase at the relative speed u (over Aω), and E = ½ u² m A²ω²:

        sin φ₀ + τ cos φ₀ − τ²/(2Γ) = sin(φ₀ + τ),  u = τ/Γ − cos φ₀ + cos(φ₀ + τ)

    Up to Γ = 1 it never leaves the floor and loses nothing. The largest loss, 2.2604 m A²ω², is at
    Γ = 2.581. Beyond √(1 + π²) a flight is longer than a period: a `ValueError` (Mehta & Luck,
    *Phys. Rev. Lett.* 65, 393 (1990)).

    Examples
    --------
    >>> floor_energy(0.9), round(floor_energy(2.0), 6)
    (0.0, 1.836182)
    """
    if not 0 < gamma <= LARGEST_GAMMA:
        raise ValueError(f"Γ = {gamma:g}: above 0, up to {LARGEST_GAMMA:.4g}")
    if gamma <= 1:
        return 0.0
    start = math.asin(1 / gamma)

    def height(flight: float) -> float:
        body = math.sin(start) + flight * math.cos(start) - flight**2 / (2 * gamma)
        return body - math.sin(start + flight)

    # it is above the floor when the parabola's slope, cos φ₀ − τ/Γ, passes through zero
    flight = brentq(height, math.sqrt(gamma**2 - 1), 2 * math.pi + 1e-9, xtol=1e-14)
    speed = flight / gamma - math.cos(start) + math.cos(start + flight)
    return 0.5 * speed**2


def ball_energy(gamma: float, restitution: float) -> float:
    """Return the loss of a ball that lands once per period of a floor [m A²ω²], Γ = Aω²/g.

    It is thrown up at gT/2 in each period T, whatever the amplitude:

        E = ½ m (gT)² (1 − e)/(1 + e) = 2π² (1 − e)/((1 + e) Γ²) m A²ω²

    which needs π(1 − e)/(1 + e) < Γ (Luck & Mehta, *Phys. Rev. E* 48, 3988 (1993)).

    Examples
    --------
    >>> round(ball_energy(1.25, 0.5), 4)
    4.211
    """
    return 2 * math.pi**2 * (1 - restitution) / ((1 + restitution) * gamma**2)
