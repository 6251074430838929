"""Polynomial chaos: an answer, or its logarithm, as a sum of Hermite polynomials of scores.

The scores are standard normal, the polynomials orthonormal. Few of many candidates are selected one
after another (orthogonal matching pursuit), as many as the leave-one-out error wants (Blatman and
Sudret 2011). Levels, masses and damping multiply g rms, so that its logarithm needs fewer terms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from math import factorial

import numpy as np
from numpy.polynomial.hermite_e import hermevander
from scipy.stats import norm, qmc

from pidpanel.arrays import Array, Index
from pidpanel.constants import REACH

# With 4, runs far from the middle are missed.
DEGREE = 3  # largest of one score
PAIRED = 30  # scores of the largest effect whose products are candidates
MOST_TERMS = 0.3  # terms over runs
FOLDS = 5
DRAWN = 2**12  # samples of the shares: within 0.01
PATIENCE = 12  # further terms without a smaller error after which the selection ends


@dataclass(frozen=True)
class BandPower:
    """ln of an answer over levels of bands, as if nothing else varied: ½ ln Σ_b w_b 10^(L_b/10).

    Without it a polynomial needs many terms: Q² of 0.948 in place of 0.984 with 128 runs of
    `margin_launch.yaml`.
    """

    weight: Array  # (n_bands,) mean square of the nominal answer in each, over that of all
    mixing: Array  # (n_bands, n_scores) levels over the scores [dB]

    def __call__(self, scores: Array) -> Array:
        """Return it (n,) at scores (n, n_scores)."""
        return np.asarray(np.log(10 ** (scores @ self.mixing.T / 10) @ self.weight) / 2)


@dataclass(frozen=True)
class Chaos:
    """A polynomial of standard normal scores, or e to it."""

    degrees: Index  # (n_terms, n_scores); the first term is the constant
    coefficient: Array  # (n_terms,)
    q2: float  # share of the variance explained in runs left out
    is_log: bool = False  # the polynomial is that of the logarithm
    base: BandPower | None = None  # what is added to that of the logarithm
    # (n,) differences from runs left out, of the logarithm if so
    missed: Array = field(default_factory=lambda: np.zeros(1))

    def __call__(self, scores: Array) -> Array:
        """Return the answer (n,) at scores (n, n_scores)."""
        value = polynomials(self.degrees, scores) @ self.coefficient
        if self.base is not None:
            value = value + self.base(scores)
        return np.exp(value) if self.is_log else np.asarray(value)

    def shares(self, groups: Sequence[slice]) -> tuple[Array, Array]:
        """Return first-order and total shares of the variance of groups of scores, (n_groups,).

        Two sets of samples of which one group is exchanged, with the estimators of Jansen (1999).
        """
        count = self.degrees.shape[1]
        uniform = qmc.Sobol(2 * count, rng=np.random.default_rng(0)).random(DRAWN)
        first, second = np.split(norm.ppf(np.clip(uniform, 1e-9, 1 - 1e-9)), 2, axis=1)
        values, second_values = self(first), self(second)
        variance = max(float(np.var(np.append(values, second_values))), 1e-300)
        first_order, total = np.zeros(len(groups)), np.zeros(len(groups))
        for number, part in enumerate(groups):
            if self.base is not None or self.degrees[:, part].any():
                mixed = first.copy()
                mixed[:, part] = second[:, part]
                exchanged = self(mixed)
                first_order[number] = 1 - np.mean((second_values - exchanged) ** 2) / (2 * variance)
                total[number] = np.mean((values - exchanged) ** 2) / (2 * variance)
        return np.maximum(first_order, 0.0), total


def polynomials(degrees: Index, scores: Array) -> Array:
    """Return orthonormal Hermite polynomials (n, n_terms) of scores (n, n_scores).

    Scores end at `REACH`, where spreads do: a polynomial does not extrapolate.
    """
    scores = np.clip(scores, -REACH, REACH)
    highest = int(degrees.max(initial=0))
    size = np.sqrt([factorial(k) for k in range(highest + 1)])
    values = np.ones((len(degrees), len(scores)))
    for score in np.flatnonzero(degrees.any(axis=0)):
        hermite = (hermevander(scores[:, score], highest) / size).T
        terms = np.flatnonzero(degrees[:, score])
        values[terms] *= hermite[degrees[terms, score]]
    return np.ascontiguousarray(values.T)


def candidates(scores: Array, answer: Array, degree: int = DEGREE) -> Index:
    """Return degrees (n_terms, n_scores) of the terms to choose from.

    Powers of all scores; products of two, to the third degree, of those with the largest effects.
    """
    count = scores.shape[1]
    unit = np.eye(count, dtype=int)
    terms = [0 * unit[:1], *(power * unit for power in range(1, degree + 1))]
    effect = np.abs((answer - answer.mean()) @ polynomials(np.vstack([unit, 2 * unit]), scores))
    effect = np.maximum(*effect.reshape(2, count))
    strong = np.argsort(effect)[::-1][:PAIRED]
    for first, second in combinations(strong.tolist(), 2):
        pair = unit[[first]], unit[[second]]
        terms += [pair[0] + pair[1], 2 * pair[0] + pair[1], pair[0] + 2 * pair[1]]
    return np.vstack(terms)


def fitted(
    scores: Array,
    answer: Array,
    is_log: bool = False,
    draws: int = 1,
    degree: int = DEGREE,
    base: BandPower | None = None,
) -> Chaos:
    """Return the chaos of an answer (n,), or of its logarithm, at scores (n, n_scores).

    Q² is that of the answer itself. It is counted in folds, each with a selection of its own: the
    leave-one-out error of terms that were selected with all runs is too small. ``draws`` runs after
    one another, which share some scores, are in one fold.

    Examples
    --------
    >>> z = np.random.default_rng(0).standard_normal((64, 3))
    >>> chaos = fitted(z, 5 + 2 * z[:, 0] + z[:, 1] * z[:, 0])
    >>> chaos.shares([slice(0, 1), slice(1, 2), slice(2, 3)])[1].round(1).tolist()
    [1.0, 0.2, 0.0]
    """
    added = np.zeros(len(answer)) if base is None else base(scores)
    target = (np.log(answer) if is_log else answer) - added
    predicted, fold = np.empty(len(answer)), np.arange(len(answer)) // draws % FOLDS
    for number in range(FOLDS):
        unseen = fold == number
        part = _selection(scores[~unseen], target[~unseen], draws, degree)
        predicted[unseen] = part(scores[unseen])
    missed, value = target - predicted, predicted + added
    value = np.exp(value) if is_log else value
    spread = max(float(np.sum((answer - answer.mean()) ** 2)), 1e-300)
    q2 = 1 - float(np.sum((value - answer) ** 2)) / spread
    chaos = _selection(scores, target, draws, degree)
    return replace(chaos, q2=q2, is_log=is_log, base=base, missed=missed)


def _selection(scores: Array, answer: Array, draws: int, degree: int) -> Chaos:
    n, degrees = len(answer), candidates(scores, answer, degree)
    matrix = polynomials(degrees, scores)
    size = np.linalg.norm(matrix, axis=0)
    spread = max(float(np.sum((answer - answer.mean()) ** 2)), 1e-300)
    basis = np.empty((n, 0))  # orthonormal columns of the chosen terms
    residual = answer.astype(float)
    unexplained = np.tile(np.eye(draws), (n // draws, 1, 1))  # I − H of runs left out together
    chosen: list[int] = []
    order = degrees.sum(axis=1)
    base = min(int(np.sum(order <= 1)), int(MOST_TERMS * n))  # the constant and linear terms
    best, best_count, term = np.inf, 0, 0
    while len(chosen) < min(MOST_TERMS * n, len(degrees)):
        column = matrix[:, term].copy()
        for _ in range(2):
            column -= basis @ (basis.T @ column)
        norm = np.linalg.norm(column)
        chosen.append(term)
        if norm > 1e-8 * size[term]:
            column /= norm
            basis = np.column_stack([basis, column])
            residual = residual - column * (column @ residual)
            among = column.reshape(-1, draws, 1)
            unexplained -= among * among.swapaxes(1, 2)
            # leave-one-out, with the correction for the number of terms of Chapelle et al. 2002
            k = basis.shape[1]
            deleted = np.linalg.solve(unexplained, residual.reshape(-1, draws, 1))
            error = float(np.sum(deleted**2)) / spread * (1 + 2 * k / n)
            if len(chosen) >= base and error < best:
                best, best_count = error, len(chosen)
            elif len(chosen) > base and len(chosen) - best_count > PATIENCE:
                break
        if best < 1e-14:
            break
        match = np.abs(residual @ matrix) / size
        match[chosen] = -1.0
        if len(chosen) < base:
            match[order > 1] = -1.0
        term = int(np.argmax(match))
    selected = chosen[:best_count]
    coefficient = np.asarray(
        np.linalg.lstsq(matrix[:, selected], answer, rcond=None)[0], np.float64
    )
    return Chaos(degrees[selected], coefficient, 1 - best)
