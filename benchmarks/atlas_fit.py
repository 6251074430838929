"""Constants of the atlas: of its processes, and factors that calibrate their errors.

Split conformal prediction (Lei et al., *J. Am. Stat. Assoc.* 113, 1094 (2018)): cases are predicted
by those of the other parts of the table, with parts of whole packings: a coupon that the table does
not have. In each of three ranges of W/L the standard errors are multiplied by the factor for which
`COVERAGE` of the predicted cases lie within 1.96 of them. All packings have equal weight.
"""

import json
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import least_squares, minimize_scalar

from pidpanel.arrays import Array, Index
from pidpanel.atlas.table import PACKAGE_FILE
from pidpanel.damping.atlas import DOF, JUMP_LENGTHS, REGIMES, riding_trend
from pidpanel.damping.atlas_files import atlas_data, by_state
from pidpanel.damping.sides import Sides
from pidpanel.damping.surface_cases import STROKE, Constants, TrainingData

COVERAGE, WIDTH = 0.95, 1.96  # share of cases within this number of standard errors
PARTS = 10  # of the table, each predicted by the others


# ln A, p, q, k, then ln A and k of gravity across over these, ln B, s, t, v, w: where the search
# starts; each differs from it by about 1.
TREND_START = np.array([0.0, 0.0, 0.9, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0])

TREND_ERROR = 0.25  # of the trend about which cases are compared: few are outliers


class Predicted(NamedTuple):
    """Errors of predicted cases, and the standard errors that were predicted."""

    # (n,) of ln C_e
    damping: Array
    damping_error: Array
    # (n,) of m_a over the mass of the particles
    mass: Array
    mass_error: Array

    def scores(self) -> Array:
        """Return errors over standard errors (2, n)."""
        return np.stack([self.damping / self.damping_error, self.mass / self.mass_error])


def predict(
    known: TrainingData, unknown: TrainingData, damping: Constants, mass: Constants
) -> Predicted:
    """Predict cases from others, with the constants of a fit."""
    points, bed = unknown.points, unknown.bed
    jump = known.jump(JUMP_LENGTHS)
    crossing = np.zeros(len(points))
    if jump is not None:
        crossing = jump.probability(np.delete(points, STROKE, axis=1), bed.reached(points))
    results: list[Array] = []
    for sides, values, errors, expected, restless, trend in (
        (known.damping_sides(damping), unknown.log_damping, unknown.log_error,
         bed.inelastic(points)[0], bed.restless(points), bed.riding(points)),
        (known.mass_sides(mass), unknown.mass, unknown.mass_error, bed.inelastic(points)[1],
         np.zeros((2, len(points))), 0.0),
    ):  # fmt: skip
        mixture = sides.mixture(points, crossing, expected, restless, trend)
        results += [mixture.mean - values, np.sqrt(sides.variance(mixture) + errors**2)]
    return Predicted(*results)


def predict_parts(cases: pd.DataFrame, part: Index) -> Predicted:
    """Predict every case from the other parts of the table, by numbers of its part (n,).

    The constants are those of the other parts too: fitted to all, they would know the case.
    """
    parts = []
    for number in np.unique(part):
        known, unknown = by_state(cases[part != number]), cases[part == number]
        trend = trend_of(known)
        data = atlas_data(known, trend)
        damping, mass = (constants_of(sides) for sides in (data.damping_sides(), data.mass_sides()))
        parts.append(predict(data, atlas_data(unknown, trend), damping, mass))
    back = np.argsort(np.argsort(part, kind="stable"))  # to the order of the table
    return Predicted(*(np.concatenate(values)[back] for values in zip(*parts, strict=True)))


def trend_of(cases: pd.DataFrame) -> Array:
    """Return the constants (11,) of `atlas.riding_trend` of cases, a row for each state."""
    data = atlas_data(cases)
    rides = data.side == 0
    values = data.points[rides], data.log_damping[rides], data.side_error[0][rides]
    return np.asarray(fit_riding(*values).round(3))


def fit_riding(points: Array, log_loss: Array, error: Array) -> Array:
    """Return the constants (11,) of cases that ride, by robust least squares.

    Parameters
    ----------
    points, log_loss, error
        (n, 9), ln 2πη (n,) and its standard errors.
    """
    scale = np.hypot(error, TREND_ERROR)

    def deviation(constants: Array) -> Array:
        residual = (riding_trend(constants, points) - log_loss) / scale
        return np.concatenate([residual, constants - TREND_START])

    return np.asarray(least_squares(deviation, TREND_START, loss="soft_l1").x)


def packings_of(cases: pd.DataFrame) -> Index:
    """Return the number of the packing (n,) of each case: cell, over the diameter, and friction."""
    names = ["friction", "width_per_diameter", "depth_per_diameter"]
    return np.asarray(cases.groupby(names, sort=False).ngroup(), np.int64)


def calibration_of(predicted: Predicted, stroke: Array, packing: Index) -> Array:
    """Return the factors (2, 3) of the errors of ln C_e and m_a below, in and above `REGIMES`.

    Parameters
    ----------
    stroke
        (n,) W/L of the predicted cases.
    packing
        (n,) number of their packing. In sum the cases of each weigh alike.
    """
    return _by_regime(predicted, stroke, packing, _conformal_factor)


def student_scale_of(predicted: Predicted, stroke: Array, packing: Index) -> Array:
    """Return the scales (2, 3) of Student's t in these errors; parameters of `calibration_of`."""
    return _by_regime(predicted, stroke, packing, fit_student_scale)


def _by_regime(
    predicted: Predicted, stroke: Array, packing: Index, factor: Callable[[Array, Array], float]
) -> Array:
    """Return a factor of each quantity and regime, 1 without cases, of scores and weights (n,)."""
    regime, weight = np.digitize(stroke, REGIMES), 1 / np.bincount(packing)[packing]
    factors = np.ones((2, len(REGIMES) + 1))
    for number in np.unique(regime):
        part = regime == number
        for side, scores in enumerate(np.abs(predicted.scores()[:, part])):
            factors[side, number] = factor(scores, weight[part])
    return factors


def _conformal_factor(scores: Array, weight: Array) -> float:
    order = np.argsort(scores)
    share = np.cumsum(weight[order])
    # the conformal quantile: a further case is taken as the mean of these
    rank = np.searchsorted(share, COVERAGE * share[-1] * (1 + 1 / len(share)) - 1e-9)
    return float(scores[order[min(int(rank), len(share) - 1)]] / WIDTH)


def fit_student_scale(scores: Array, weight: Array) -> float:
    """Return the scale of largest likelihood of Student's t with `DOF` degrees of freedom."""

    def cost(log_scale: float) -> float:
        log = 0.5 * (DOF + 1) * np.log1p((scores / np.exp(log_scale)) ** 2 / DOF)
        return float(weight @ (log + log_scale))

    ends = np.log(scores[scores > 0].min()), np.log(scores.max())
    return float(np.exp(minimize_scalar(cost, bounds=ends, method="bounded").x))


def fit_constants(cases: pd.DataFrame) -> dict[str, Any]:
    """Return the constants that `atlas_files.read_atlas` reads."""
    trend = trend_of(by_state(cases))
    data = atlas_data(by_state(cases), trend)
    damping, mass = (constants_of(sides) for sides in (data.damping_sides(), data.mass_sides()))
    stroke = cases["stroke_per_gap"].to_numpy(float)
    packing = packings_of(cases)
    predicted = predict_parts(cases, packing % PARTS)
    factors = calibration_of(predicted, stroke, packing)
    student_scale = student_scale_of(predicted, stroke, packing) / factors
    names = ("riding", "crossing")
    return {
        "version": json.loads(PACKAGE_FILE.read_text(encoding="utf-8"))["version"],
        "cases": len(cases),
        "bulk": _rounded(fit_bulk(cases)),
        "trend": trend.tolist(),
        "damping": {name: _rounded(c) for name, c in zip(names, damping, strict=True)},
        "mass": {name: _rounded(c) for name, c in zip(names, mass, strict=True)},
        "calibration": factors.round(3).tolist(),
        "student_scale": student_scale.round(3).tolist(),
    }


def fit_bulk(cases: pd.DataFrame) -> Array:
    """Return c₀, c₁ and c₂ of `atlas.Atlas.bulk_fraction` by least squares."""
    packings = cases.drop_duplicates(["width_per_diameter", "depth_per_diameter"])
    full = (packings["bulk_fraction"] / packings["fill_fraction"]).to_numpy(float)
    names = ["width_per_diameter", "depth_per_diameter"]
    shape = np.column_stack([np.ones(len(full)), 1 / packings[names].to_numpy(float)])
    return np.asarray(np.linalg.lstsq(shape, full, rcond=None)[0])


def constants_of(sides: Sides) -> Constants:
    """Return lengths, size and scatter of the processes of both sides."""
    crossing = sides.crossing
    return sides.riding.constants, None if crossing is None else crossing.constants


def _rounded(constants: Array | None) -> list[float]:
    return [] if constants is None else [float(f"{value:.4g}") for value in constants]
