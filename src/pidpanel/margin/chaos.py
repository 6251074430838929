"""Polynomial chaos: an answer as a sum of Hermite polynomials of standard normal scores.

The polynomials are orthonormal, so that squares of coefficients are shares of the variance (Sudret
2008). Few of many candidates are selected one after another (orthogonal matching pursuit), as many
as the leave-one-out error wants (Blatman and Sudret 2011).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import factorial

import numpy as np
from numpy.polynomial.hermite_e import hermeval

from pidpanel.arrays import Array, Index

DEGREE = 4  # largest of one score
PAIRED = 12  # scores of the largest effect whose products are candidates
MOST_TERMS = 0.4  # terms over runs
FOLDS = 5
PATIENCE = 12  # further terms without a smaller error after which the selection ends


@dataclass(frozen=True)
class Chaos:
    """A polynomial of standard normal scores."""

    degrees: Index  # (n_terms, n_scores); the first term is the constant
    coefficient: Array  # (n_terms,)
    q2: float  # share of the variance explained in runs left out

    def __call__(self, scores: Array) -> Array:
        """Return the answer (n,) at scores (n, n_scores)."""
        return polynomials(self.degrees, scores) @ self.coefficient

    @property
    def variance(self) -> float:
        """Variance of the answer."""
        return float(np.sum(self.coefficient[1:] ** 2))

    def shares(self, groups: Sequence[slice]) -> tuple[Array, Array]:
        """Return first-order and total shares of the variance of groups of scores, (n_groups,)."""
        power = self.coefficient**2
        active = np.array([self.degrees[:, part].any(axis=1) for part in groups]).T
        total = power @ active
        alone = active & (active.sum(axis=1, keepdims=True) == 1)
        variance = max(self.variance, 1e-300)
        return power @ alone / variance, total / variance


def polynomials(degrees: Index, scores: Array) -> Array:
    """Return orthonormal Hermite polynomials (n, n_terms) of scores (n, n_scores)."""
    highest = int(degrees.max(initial=0))
    of_one = np.stack(
        [
            hermeval(scores, np.eye(highest + 1)[k]) / np.sqrt(factorial(k))
            for k in range(highest + 1)
        ]
    )
    values = np.ones((len(scores), len(degrees)))
    for score in np.flatnonzero(degrees.any(axis=0)):
        values *= of_one[degrees[:, score], :, score].T
    return values


def candidates(scores: Array, answer: Array) -> Index:
    """Return degrees (n_terms, n_scores) of the terms to choose from.

    Powers of all scores; products of two, to the third degree, of those with the largest effects.
    """
    count = scores.shape[1]
    unit = np.eye(count, dtype=int)
    terms = [0 * unit[:1], *(power * unit for power in range(1, DEGREE + 1))]
    effect = np.abs((answer - answer.mean()) @ polynomials(np.vstack([unit, 2 * unit]), scores))
    effect = np.maximum(*effect.reshape(2, count))
    strong = np.argsort(effect)[::-1][:PAIRED]
    for first, second in combinations(strong.tolist(), 2):
        pair = unit[[first]], unit[[second]]
        terms += [pair[0] + pair[1], 2 * pair[0] + pair[1], pair[0] + 2 * pair[1]]
    return np.vstack(terms)


def fitted(scores: Array, answer: Array) -> Chaos:
    """Return the chaos of an answer (n,) at scores (n, n_scores).

    Q² is counted in folds, each with a selection of its own: the leave-one-out error of terms that
    were selected with all runs is too small.

    Examples
    --------
    >>> z = np.random.default_rng(0).standard_normal((64, 3))
    >>> chaos = fitted(z, 5 + 2 * z[:, 0] + z[:, 1] * z[:, 0])
    >>> chaos.shares([slice(0, 1), slice(1, 2), slice(2, 3)])[1].round(6).tolist()
    [1.0, 0.2, 0.0]
    """
    error, fold = 0.0, np.arange(len(answer)) % FOLDS
    for number in range(FOLDS):
        unseen = fold == number
        part = _selection(scores[~unseen], answer[~unseen])
        error += float(np.sum((part(scores[unseen]) - answer[unseen]) ** 2))
    spread = max(float(np.sum((answer - answer.mean()) ** 2)), 1e-300)
    return replace(_selection(scores, answer), q2=1 - error / spread)


def _selection(scores: Array, answer: Array) -> Chaos:
    n, degrees = len(answer), candidates(scores, answer)
    matrix = polynomials(degrees, scores)
    size = np.linalg.norm(matrix, axis=0)
    spread = max(float(np.sum((answer - answer.mean()) ** 2)), 1e-300)
    basis = np.empty((n, 0))  # orthonormal columns of the chosen terms
    residual, leverage = answer.astype(float), np.zeros(n)
    chosen: list[int] = []
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
            leverage += column**2
            # leave-one-out, with the correction for the number of terms of Chapelle et al. 2002
            k = basis.shape[1]
            left_out = residual / np.maximum(1 - leverage, 1e-9)
            error = float(np.sum(left_out**2)) / spread * (1 + 2 * k / n)
            if error < best:
                best, best_count = error, len(chosen)
            elif len(chosen) - best_count > PATIENCE:
                break
        if best < 1e-14:
            break
        match = np.abs(residual @ matrix) / size
        match[chosen] = -1.0
        term = int(np.argmax(match))
    selected = chosen[:best_count]
    coefficient = np.asarray(
        np.linalg.lstsq(matrix[:, selected], answer, rcond=None)[0], np.float64
    )
    return Chaos(degrees[selected], coefficient, 1 - best)
