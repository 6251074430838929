"""Constants of the paper's form from data at one amplitude, with confidence intervals.

    C_e = (1/2π) a₁ ω^(a₂−1) e^(−a₃ω)                                            (Eq. 5)

is linear in its constants once its logarithm is taken,

    ln(2π C_e) + ln ω = ln a₁ + a₂ ln ω − a₃ ω,

so at one fill the constants and their Student intervals are those of weighted linear least
squares. Over fill, in the structure of Eq. 6 with its leading factor taken out,

    a₁ = α r (1 + β₁ r + β₂ r²),   a₂ = γ₀ + γ₁ r,   a₃ = r (δ₀ + δ₁ r),

least squares in (ln α, β, γ, δ); the intervals are those of the linearised problem. ω is in
rad/s, a₁ in N s/m³ (rad/s)^(1−a₂), a₃ in s.

Errors of the values weigh them against each other; how far the points scatter about the form,
which is more than their errors where the form does not fit, is taken from the fit itself.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import least_squares
from scipy.special import stdtrit

from pidpanel.arrays import Array
from pidpanel.damping.surface_cases import ERROR, VALUE

AT_FILL = ("ln_a1", "a2", "a3")
OVER_FILL = ("ln_alpha", "beta1", "beta2", "gamma0", "gamma1", "delta0", "delta1")
CONFIDENCE = 0.95
CONVERGED = 1e-14  # relative changes of the cost and the constants with which a search ends


@dataclass(frozen=True)
class FittedValue:
    """Constants (p,) with confidence intervals, in the order of `AT_FILL` or `OVER_FILL`."""

    value: Array
    low: Array
    high: Array
    scatter: float  # standard deviation of ln C_e about the form, of a value of average weight


def constants_at(fill_fraction: Array, constants: Array) -> tuple[Array, Array, Array]:
    """Return a₁, a₂, a₃ at fills (n,) from constants (7,) in the order of `OVER_FILL`."""
    r = np.asarray(fill_fraction, float)
    log_alpha, beta1, beta2, gamma0, gamma1, delta0, delta1 = constants
    a1 = np.exp(log_alpha) * r * (1 + beta1 * r + beta2 * r**2)
    return a1, gamma0 + gamma1 * r, r * (delta0 + delta1 * r)


def fit_at_fill(frequency: Array, damping: Array, error: Array) -> FittedValue:
    """Return ln a₁, a₂ and a₃ of one fill from C_e (n,) at frequencies (n,) [Hz], four at least.

    Of the standard errors of ln C_e (n,) only the ratios matter.
    """
    omega = 2 * np.pi * np.asarray(frequency, float)
    if len(np.unique(omega)) < 4:
        raise ValueError(f"{len(np.unique(omega))} frequencies: at least 4 for three constants")
    scale, weight = omega.max(), _weights(error)
    design = np.stack([np.ones_like(omega), np.log(omega), -omega / scale], axis=1)
    design *= weight[:, None]
    value = (np.log(2 * np.pi * damping) + np.log(omega)) * weight
    constants = np.linalg.lstsq(design, value)[0]
    return _estimate(constants, value - design @ constants, design, np.array([1, 1, 1 / scale]))


def fit_over_fill(
    frequency: Array, fill_fraction: Array, damping: Array, error: Array
) -> FittedValue:
    """Return the constants of the structure of Eq. 6 over all fills at once, from C_e (n,).

    Eight points, three fills and four frequencies [Hz] at least; of the standard errors of ln C_e
    (n,) only the ratios matter.
    """
    omega = 2 * np.pi * np.asarray(frequency, float)
    r = np.asarray(fill_fraction, float)
    fills, frequencies = len(np.unique(r)), len(np.unique(omega))
    if len(r) < 8 or fills < 3 or frequencies < 4:
        raise ValueError(
            f"{len(r)} points, {fills} fills, {frequencies} frequencies: "
            "at least 8, 3 and 4 for seven constants"
        )
    scale, weight = omega.max(), _weights(error)
    log_omega, share = np.log(omega), omega / scale
    design = np.stack([log_omega, r * log_omega, -r * share, -(r**2) * share], axis=1)
    value = np.log(2 * np.pi * damping) + log_omega - np.log(r)

    def residual(constants: Array) -> Array:
        """Return residuals (n,) with weight, not finite where a₁ ≤ 0: the search steps back."""
        with np.errstate(invalid="ignore", divide="ignore"):
            log_factor = np.log(1 + constants[1] * r + constants[2] * r**2)
        return np.asarray((constants[0] + log_factor + design @ constants[3:] - value) * weight)

    def slope(constants: Array) -> Array:
        factor = 1 + constants[1] * r + constants[2] * r**2
        columns = np.column_stack([np.ones_like(r), r / factor, r**2 / factor, design])
        return np.asarray(columns * weight[:, None])

    start = np.zeros(7)
    linear = [0, 3, 4, 5, 6]
    start[linear] = np.linalg.lstsq(slope(start)[:, linear], value * weight)[0]
    optimum = least_squares(residual, start, slope, ftol=CONVERGED, xtol=CONVERGED, gtol=CONVERGED)
    units = np.array([1, 1, 1, 1, 1, 1 / scale, 1 / scale])
    return _estimate(optimum.x, optimum.fun, optimum.jac, units)


def _weights(error: Array) -> Array:
    """Return weights of mean square 1; all equal without errors."""
    error = np.asarray(error, float)
    weight = 1 / error if (error > 0).all() else np.ones(error.shape)
    return np.asarray(weight / np.sqrt(np.mean(weight**2)))


def _estimate(constants: Array, residual: Array, slope: Array, units: Array) -> FittedValue:
    """Return Student intervals from weighted residuals (n,) and their slope (n, p)."""
    freedom = len(residual) - slope.shape[1]
    scatter = float(np.sqrt(residual @ residual / freedom))
    variance = np.diag(np.linalg.pinv(slope.T @ slope))
    reach = stdtrit(freedom, 0.5 + CONFIDENCE / 2) * scatter * np.sqrt(variance)
    low, high = (constants - reach) * units, (constants + reach) * units
    return FittedValue(constants * units, low, high, scatter)


def _fit(frequency: Array, fill_fraction: Array, damping: Array, error: Array) -> FittedValue:
    """Return a fit at a single fill, or over several fills."""
    if np.ptp(fill_fraction) == 0:
        return fit_at_fill(frequency, damping, error)
    return fit_over_fill(frequency, fill_fraction, damping, error)


def fit_accelerations(cases: pd.DataFrame) -> pd.DataFrame:
    """Return the constants of the form at every amplitude of a sweep, and at every fill of it."""
    rows = []
    for gamma, at_gamma in cases.groupby("acceleration_g"):
        for fill, group in [(np.nan, at_gamma), *at_gamma.groupby("fill_fraction")]:
            frequency, value = group["frequency_hz"].to_numpy(), group[VALUE].to_numpy()
            error, r = (group[ERROR] / group[VALUE]).to_numpy(), group["fill_fraction"].to_numpy()
            try:
                # where the form misses by more than the errors of the cases, what it misses by
                # belongs to all alike, or the few best known would decide
                scatter = _fit(frequency, r, value, np.ones(len(group))).scatter
                lack = max(scatter**2 - float(np.mean(error**2)), 0.0)
                fitted = _fit(frequency, r, value, np.sqrt(error**2 + lack))
            except ValueError:
                continue  # too few cases
            names = OVER_FILL if len(fitted.value) == len(OVER_FILL) else AT_FILL
            rows += [
                (gamma, fill, name, *numbers, fitted.scatter, len(group))
                for name, *numbers in zip(names, fitted.value, fitted.low, fitted.high, strict=True)
            ]
    return pd.DataFrame(
        rows,
        columns=["acceleration_g", "fill_fraction", "constant", "value", "low", "high", "scatter",
                 "points"],
    )  # fmt: skip
