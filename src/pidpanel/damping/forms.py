"""One closed form for C_e(r, f, Γ) of all cases, with two regimes of the bed.

With η = C_e/(m″ω), h = 1 − (Γ₀/Γ)² and x = W/L, the stroke over the clear gap (`clear_gap`):

    η = h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)].

The first term is the agitated bed, whose particles collide out of step with the cell and take a
share of its energy that falls with Γ; the second is the bed that crosses the gap as one and
collides with both ends in step, at its best where the stroke is of the order of the gap (without
gravity at x = 1/π). It predicts cases left out of the fit far
better than Eq. 5 and 6 (docs/theory/damping.md).

Errors are those of ln C_e, every case counting alike: what a form leaves over is far more than
the errors of the cases.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.fit import student_reach
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES, VALUE, clear_gap, onset

CONSTANTS = ("ln_A", "p", "q", "ln_B", "s", "ln_x0", "t")
START = (0.0, 0.3, 0.9, 1.0, 1.0, -1.0, 2.0)  # of the search

FEWEST = len(CONSTANTS) + 5  # cases of a fit


@dataclass(frozen=True)
class Points:
    """Where the cases are: r, Γ, x = W/L and h, all (n,)."""

    fill_fraction: Array
    acceleration_g: Array
    stroke_over_gap: Array
    onset: Array


def two_regimes(c: Array, p: Points) -> Array:
    """Return ln η (n,) of the form with the constants (7,)."""
    # in logarithms, since a search may try a power of hundreds
    stroke = np.log(p.stroke_over_gap)
    agitated = c[0] + c[1] * np.log(p.fill_fraction) - c[2] * np.log(p.acceleration_g)
    as_one = c[3] + c[4] * stroke - np.logaddexp(0.0, c[6] * (stroke - c[5]))
    return np.log(p.onset) + np.logaddexp(agitated, as_one)


@dataclass(frozen=True)
class Fit:
    """Constants (7,) with the 95 % intervals of the linearised problem, and the error of ln C_e."""

    constants: Array
    low: Array
    high: Array
    rms: float


def points_of(surface: DampingSurface, depth: float) -> tuple[Points, Array]:
    """Return where the cases of a surface are, and ln η there.

    Parameters
    ----------
    surface
        With a known ``mass_per_fill``.
    depth
        Of the cells [m].
    """
    r, f, level = surface.cases[list(AXES)].to_numpy(float).T
    omega = 2 * np.pi * f
    stroke = level * STANDARD_GRAVITY / omega**2 / (depth * clear_gap(r))
    value = surface.cases[VALUE].to_numpy(float)
    log_eta = np.log(value / (surface.mass_per_fill * r * omega))
    return Points(r, level, stroke, onset(level, surface.onset_g)), log_eta


def fit(points: Points, log_eta: Array) -> Fit | None:
    """Return the least squares of the form; None of fewer than `FEWEST` cases."""
    if len(log_eta) < FEWEST:
        return None
    optimum = least_squares(lambda c: two_regimes(c, points) - log_eta, START, x_scale="jac")
    reach, _ = student_reach(optimum.fun, optimum.jac)
    rms = float(np.sqrt(np.mean(optimum.fun**2)))
    return Fit(optimum.x, optimum.x - reach, optimum.x + reach, rms)
