"""Closed forms for C_e(r, f, Γ) compared: how well each predicts cases left out of its fit.

With η = C_e/(m″ω), h = 1 − (Γ₀/Γ)² and x = W/L, the stroke over the clear gap (`clear_gap`):

- ``paper``: Eq. 5 and 6 with fitted constants, independent of Γ;
- ``paper_level``: the same times Γ^c;
- ``groups``: η = h A r^p Γ^−q x^s, a power law of the dimensionless groups;
- ``two_regimes``: η = h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)]. The first term is the agitated bed,
  whose particles collide out of step with the cell and take a share of its energy that falls with
  Γ; the second is the bed that crosses the gap as one and collides with both ends in step, at its
  best where the stroke is of the order of the gap (without gravity at x = 1/π).

Errors are those of ln C_e, every case counting alike: what a form leaves over is far more than
the errors of the cases.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import least_squares
from scipy.special import stdtrit

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.laws import FREQUENCY_RANGE, paper_corrected
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES, PARTICLE_MASS, VALUE, clear_gap, onset

FOLDS = 10

SPARE = 4
"""Cases beyond its constants that a form needs: a tenth of them left out, two degrees remain."""


@dataclass(frozen=True)
class Points:
    """Where the cases are: r, ω [rad/s], Γ, x = W/L and h, all (n,), and m₁ [kg/m²]."""

    fill_fraction: Array
    omega: Array
    acceleration_g: Array
    stroke_over_gap: Array
    onset: Array
    mass_per_fill: float

    def __getitem__(self, index: Index) -> Points:
        return Points(
            self.fill_fraction[index], self.omega[index], self.acceleration_g[index],
            self.stroke_over_gap[index], self.onset[index], self.mass_per_fill,
        )  # fmt: skip


@dataclass(frozen=True)
class Form:
    """A form of η: ``function`` of constants and points gives ln(C_e/(m₁ r ω))."""

    name: str
    constants: Sequence[str]
    start: Sequence[float]
    function: Callable[[Array, Points], Array]


def _paper(c: Array, p: Points) -> Array:
    # C_e/(m₁ r ω) of Eq. 5 and 6, ω in krad/s to keep the constants of one size
    r, w = p.fill_fraction, p.omega / 1e3
    factor = np.maximum(c[0] + c[1] * r + c[2] * r**2, 1e-12)  # a₁/r > 0
    return np.log(factor) + (c[3] + c[4] * r - 2) * np.log(w) - r * (c[5] + c[6] * r) * w


def _paper_level(c: Array, p: Points) -> Array:
    return _paper(c[:7], p) + c[7] * np.log(p.acceleration_g)


def _groups(c: Array, p: Points) -> Array:
    powers = c[1] * np.log(p.fill_fraction) - c[2] * np.log(p.acceleration_g)
    return np.log(p.onset) + c[0] + powers + c[3] * np.log(p.stroke_over_gap)


def _two_regimes(c: Array, p: Points) -> Array:
    # in logarithms, since a search may try a power of hundreds
    stroke = np.log(p.stroke_over_gap)
    agitated = c[0] + c[1] * np.log(p.fill_fraction) - c[2] * np.log(p.acceleration_g)
    as_one = c[3] + c[4] * stroke - np.logaddexp(0.0, c[6] * (stroke - c[5]))
    return np.log(p.onset) + np.logaddexp(agitated, as_one)


FORMS = (
    Form("paper", ("b0", "b1", "b2", "c0", "c1", "d0", "d1"), (1, 0, 0, 2, 0, 0, 0), _paper),
    Form("paper_level", ("b0", "b1", "b2", "c0", "c1", "d0", "d1", "c"),
         (1, 0, 0, 2, 0, 0, 0, -1), _paper_level),
    Form("groups", ("ln_A", "p", "q", "s"), (0, 0, 1, 0), _groups),
    Form("two_regimes", ("ln_A", "p", "q", "ln_B", "s", "ln_x0", "t"),
         (0, 0.3, 0.9, 1, 1, -1, 2), _two_regimes),
)  # fmt: skip


@dataclass(frozen=True)
class Fit:
    """A form with its constants (p,) and their 95 % intervals of the linearised problem.

    The errors are of ln C_e, over the cases and over a tenth of them left out at a time;
    ``information`` is Akaike's criterion corrected for few data, lower is better.
    """

    form: Form
    constants: Array
    low: Array
    high: Array
    rms: float
    held_out_rms: float
    held_out_largest: float
    information: float


def points_of(surface: DampingSurface, depth: float) -> tuple[Points, Array]:
    """Where the cases of a surface stand, and ln(C_e/(m₁ r ω)) there.

    Parameters
    ----------
    surface
        With a known ``mass_per_fill``.
    """
    r, f, level = surface.cases[list(AXES)].to_numpy(float).T
    omega = 2 * np.pi * f
    stroke = level * STANDARD_GRAVITY / omega**2 / (depth * clear_gap(r))
    h = onset(level, surface.onset_g)
    points = Points(r, omega, level, stroke, h, surface.mass_per_fill)
    value = surface.cases[VALUE].to_numpy(float)
    return points, np.log(value / (surface.mass_per_fill * r * omega))


def fit(form: Form, points: Points, log_eta: Array) -> Fit:
    """Least squares of a form, its intervals and its error over cases left out."""

    def solve(p: Points, y: Array, start: Sequence[float] | Array):  # type: ignore[no-untyped-def]
        return least_squares(lambda c: form.function(c, p) - y, start, x_scale="jac")

    optimum = solve(points, log_eta, form.start)
    n, count = len(log_eta), len(form.constants)
    variance = (optimum.fun**2).sum() / (n - count)
    covariance = np.linalg.pinv(optimum.jac.T @ optimum.jac) * variance
    reach = stdtrit(n - count, 0.975) * np.sqrt(np.diag(covariance))
    held_out = np.empty(n)
    for fold in folds(n):
        rest = np.setdiff1d(np.arange(n), fold)
        constants = solve(points[rest], log_eta[rest], optimum.x).x
        held_out[fold] = form.function(constants, points[fold]) - log_eta[fold]
    return Fit(
        form, optimum.x, optimum.x - reach, optimum.x + reach, _rms(optimum.fun), _rms(held_out),
        float(np.abs(held_out).max()), information(optimum.fun, count),
    )  # fmt: skip


def folds(count: int) -> list[Index]:
    """Return the numbers of cases left out together: every tenth, so that folds are spread."""
    return [np.arange(k, count, FOLDS) for k in range(min(FOLDS, count))]


def information(residual: Array, constants: int) -> float:
    """Akaike's criterion for normal errors of unknown variance, corrected for few data (AICc).

    NaN of fewer than two data more than constants and variance.
    """
    n, k = len(residual), constants + 1
    if n < k + 2:
        return float("nan")
    # an exact fit leaves nothing but rounding, and on some processors not even that
    square = max(float(np.mean(residual**2)), np.finfo(float).eps ** 2)
    return float(n * np.log(square) + 2 * k + 2 * k * (k + 1) / (n - k - 1))


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))


def compare(surface: DampingSurface, depth: float) -> tuple[pd.DataFrame, list[Fit]]:
    """Compare every form, the paper's law corrected and the surface itself, each with its errors.

    Returns
    -------
    table
        Columns ``form``, ``constants`` (their number), ``rms``, ``held_out_rms``,
        ``held_out_largest`` (of ln C_e), ``information`` (AICc; NaN where constants are not
        counted). A form of which there are too few cases, or the paper's law outside its
        frequencies, is left out.
    """
    points, log_eta = points_of(surface, depth)
    frequency = points.omega / (2 * np.pi)
    unit = points.mass_per_fill * points.fill_fraction * points.omega
    low, high = FREQUENCY_RANGE
    rows = []
    if low <= frequency.min() and frequency.max() <= high:
        corrected = [
            float(paper_corrected(f, r))
            for f, r in zip(frequency, points.fill_fraction, strict=True)
        ]
        away = np.log(np.array(corrected) / unit) - log_eta
        rows.append(("paper_corrected", 0, _rms(away), _rms(away), float(np.abs(away).max()),
                     information(away, 0)))  # fmt: skip
    enough = [form for form in FORMS if len(log_eta) > len(form.constants) + SPARE]
    fits = [fit(form, points, log_eta) for form in enough]
    rows += [
        (f.form.name, len(f.constants), f.rms, f.held_out_rms, f.held_out_largest, f.information)
        for f in fits
    ]
    if len(log_eta) > SPARE:
        rows.append(("surface", 0, *_surface_errors(surface), np.nan))
    names = ["form", "constants", "rms", "held_out_rms", "held_out_largest", "information"]
    return pd.DataFrame(rows, columns=names), fits


def _surface_errors(surface: DampingSurface) -> tuple[float, float, float]:
    """Rms error over its own cases, and rms and largest over those left out, of ln C_e."""
    # the bound and the mass at rest are those of the particles, whichever cases are left out
    mass = surface.mass_per_fill * surface.cases["fill_fraction"]
    cases = surface.cases.assign(**{PARTICLE_MASS: mass})
    point = [cases[axis].to_numpy(float) for axis in AXES]
    log_value = np.log(cases[VALUE].to_numpy(float))
    residuals = np.log(surface.evaluate(*point).equivalent_damping) - log_value
    held_out = np.empty(len(cases))
    for fold in folds(len(cases)):
        rest = DampingSurface.from_frame(
            cases.drop(cases.index[fold]), surface.onset_g, surface.bed.depth
        )
        predicted = rest.evaluate(*(axis[fold] for axis in point)).equivalent_damping
        held_out[fold] = np.log(predicted) - log_value[fold]
    return _rms(residuals), _rms(held_out), float(np.abs(held_out).max())
