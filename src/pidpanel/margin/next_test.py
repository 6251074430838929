"""The next test: what a measurement would leave of the variance of an answer.

Observations o = a + B z + e are linear in the scores z of the inputs, with B by least squares on
the runs that exist; what of the runs is not linear counts as error. The scores are then normal
after the test too, with the covariance C = (I + Bᵀ R⁻¹ B)⁻¹ and a mean whose own covariance is
I − C. The answer is the chaos at such scores: two samples with the same mean share what the test
tells, so that the covariance of both is the variance that it takes (pick and freeze).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la

from pidpanel.arrays import Array
from pidpanel.margin.assessment import PointAnswer
from pidpanel.margin.chaos import Chaos
from pidpanel.margin.samples import DRAWS

DRAWN = 2**14  # pairs of samples
INTERVAL = (0.05, 0.95)
# Standard errors of a coefficient of B below which it is 0: chance in many channels that count as
# independent would tell of inputs that no channel shows.
SIGNIFICANT = 3.0


class Observable(NamedTuple):
    """A measurement that could be made."""

    values: Array  # (n_runs, n) what it would show; of the first runs only, perhaps
    error: Array  # (n,) standard deviations of independent errors
    common: float = 0.0  # standard deviation of an error common to all, and to others of its kind
    kind: str = ""
    # Correlation of errors of the damping at its level and at that of the answer
    common_damping: float = 1.0
    # Scores of which it tells nothing: those of the launch spectrum, for a test with its own sound
    unseen: Sequence[slice] = ()


class ScoreDistribution(NamedTuple):
    """Mean (n,) and covariance (n, n) of the scores."""

    mean: Array
    covariance: Array


def joined(
    scores: Array, measurements: Sequence[Observable], damping: Sequence[slice] = ()
) -> tuple[Array, Array]:
    """Return B (n, n_scores) and R (n, n) of some measurements together.

    Parameters
    ----------
    damping
        Scores of the errors of damping models.
    """
    design = np.hstack([np.ones((len(scores), 1)), scores])
    gains, errors = [], []
    for part in measurements:
        runs = design[: len(part.values)]
        solution, _, rank, _ = np.linalg.lstsq(runs, part.values, rcond=None)
        square = np.sum((part.values - runs @ solution) ** 2, axis=0)
        left = square / max(len(runs) - rank, 1)
        B, variance = solution[1:].T.copy(), part.error**2 + left
        # what is not linear in the inputs of a panel is the same in all of its runs
        inverse = np.add.reduceat(np.linalg.pinv(runs)[1:], np.arange(0, len(runs), DRAWS), axis=1)
        B[np.abs(B) < SIGNIFICANT * np.sqrt(np.outer(left, np.sum(inverse**2, axis=1)))] = 0.0
        for columns in part.unseen:
            B[:, columns] = 0.0
        for columns in damping:
            variance += (1 - part.common_damping**2) * np.sum(B[:, columns] ** 2, axis=1)
            B[:, columns] *= part.common_damping
        gains.append(B)
        errors.append(variance)
    return np.vstack(gains), np.diag(np.concatenate(errors)) + common_errors(measurements)


def common_errors(measurements: Sequence[Observable]) -> Array:
    """Return the covariance (n, n) of errors that measurements of a kind have in common."""
    counts = [part.values.shape[1] for part in measurements]
    kinds = np.repeat([part.kind for part in measurements], counts)
    common = np.repeat([part.common for part in measurements], counts)
    return np.asarray(np.equal.outer(kinds, kinds) * np.outer(common, common))


def posterior(gain: Array, error: Array, prior: Array | None = None) -> Array:
    """Return the covariance C (n, n) of the scores after a test with B and R.

    ``prior`` (n, n) is their covariance before it; by default 1.

    Examples
    --------
    >>> posterior(np.array([[1.0, 0.0]]), np.array([[1.0]])).tolist()
    [[0.5, 0.0], [0.0, 1.0]]
    """
    initial = np.eye(gain.shape[1]) if prior is None else prior
    cross = gain @ initial
    return np.asarray(initial - cross.T @ la.solve(error + cross @ gain.T, cross, assume_a="pos"))


def _root(covariance: Array) -> Array:
    value, vector = np.linalg.eigh(covariance)
    return np.asarray(vector * np.sqrt(np.maximum(value, 0.0)))


def remaining(
    chaos: Chaos, covariance: Array, prior: ScoreDistribution | None = None
) -> tuple[float, float]:
    """Return the share of the variance that is left after a test, and the width of the interval.

    The share is that of the variance with ``prior``, by default the stated spreads.

    The width is that from 5 to 95 % about the result of the test, on average over results: of the
    difference of two samples with the same mean, over √2.
    """
    size, rng = len(covariance), np.random.default_rng(1)
    centre, initial = prior or ScoreDistribution(np.zeros(size), np.eye(size))
    mean = centre + rng.standard_normal((DRAWN, size)) @ _root(initial - covariance).T
    scatter = rng.standard_normal((2, DRAWN, size)) @ _root(covariance).T
    first, second = chaos(mean + scatter[0]), chaos(mean + scatter[1])
    variance = (np.var(first) + np.var(second)) / 2
    left = np.mean((first - second) ** 2) / 2
    width = np.ptp(np.quantile(first - second, INTERVAL)) / np.sqrt(2)
    return min(float(left) / max(float(variance), 1e-300), 1.0), float(width)


def test_rows(
    answer: PointAnswer,
    drawn: Array,
    scores: Array,
    measurements: Mapping[str, Observable],
    damping: Sequence[slice],
    prior: ScoreDistribution | None = None,
) -> list[dict[str, Any]]:
    """Return what no, each measurement, and any two, would leave; the most useful of each first.

    ``drawn`` (n,) are samples of the answer before them, with ``prior`` of the scores.
    """
    initial = np.eye(scores.shape[1]) if prior is None else prior.covariance
    chaos, total = answer.chaos, float(np.ptp(np.quantile(drawn, INTERVAL)))
    scale = total / remaining(chaos, initial, prior)[1]
    single = [(name,) for name in measurements]
    rows = [{"measurement": "none", "tests": 0, "share_left": 1.0, "interval_width_g": total}]
    for names in (*single, *combinations(measurements, 2)):
        parts = [measurements[name] for name in names]
        covariance = posterior(*joined(scores, parts, damping), initial)
        share, width = remaining(chaos, covariance, prior)
        row = {"measurement": " and ".join(names), "tests": len(names), "share_left": share}
        rows.append({**row, "interval_width_g": min(scale * width, total)})
    return sorted(rows, key=lambda row: (row["tests"], row["share_left"]))
