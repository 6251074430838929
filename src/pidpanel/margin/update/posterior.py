"""Posterior of the scores after tests: Bayes' rule with the chaos of each measured quantity.

A test shows y = f(z) + e. f is the chaos of each channel, e has the covariance R of errors that are
independent, of those common to a kind of tests, and of what the chaos misses in runs left out. The
posterior of the scores z is sampled about its largest density, where it is nearly normal: normal
samples with weights, whose mean and covariance make the next normal (adaptive importance sampling,
tempered while few samples weigh).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg as la
from scipy.optimize import least_squares
from scipy.special import logsumexp
from scipy.stats import chi2, norm, qmc

from pidpanel.arrays import Array, Index
from pidpanel.margin.chaos import Chaos, fitted, polynomials
from pidpanel.margin.next_test import Observable, ScoreDistribution, common_errors
from pidpanel.margin.samples import DRAWS

DEGREE = 6  # of the chaoses: frequencies over a stiffness of edges are S-shaped
DRAWN = 2**13  # samples
COUNTED, FEWEST = 2**15, 8  # samples of the spreads, and the fewest beyond a result that count
ROUNDS = 6  # of normals at most
ENOUGH = 0.5  # effective samples over all
STEP = 1e-4  # of the scores, for derivatives


class Result(NamedTuple):
    """A test that has been made."""

    name: str
    observable: Observable
    value: Array  # (n,) what it showed
    channels: Sequence[str]  # names of these
    chaoses: Sequence[Chaos] = ()  # of these, if they are fitted


class Emulator:
    """What tests show at scores, with the covariance of their errors.

    Parameters
    ----------
    scores
        (n_runs, n_scores) of the runs.
    damping
        Scores of the errors of damping models. Where they are others at the level of a test, they
        have further scores behind those of the inputs.
    """

    def __init__(
        self, scores: Array, results: Sequence[Result], damping: Sequence[slice] = ()
    ) -> None:
        self.results = results
        self.value = np.concatenate([result.value for result in results])
        self._damping = np.concatenate([np.r_[part] for part in damping] or [np.zeros(0, int)])
        is_other = any(result.observable.common_damping < 1 for result in results)
        self.inputs = scores.shape[1]
        self.size = self.inputs + is_other * self._damping.size
        self.chaoses = [result.chaoses or _fitted(scores, result.observable) for result in results]
        self._terms = [_joined(part) for part in self.chaoses]
        missed = np.stack([chaos.missed for part in self.chaoses for chaos in part], axis=1)
        errors = np.concatenate([result.observable.error for result in results])
        self.error = missed.T @ missed / len(missed) + np.diag(errors**2)
        self.error += common_errors([result.observable for result in results])
        self._root = la.cholesky(self.error, lower=True)

    def __call__(self, scores: Array) -> Array:
        """Return what the tests show (n, n_channels) at scores (n, size)."""
        prediction = []
        for result, (degrees, coefficient) in zip(self.results, self._terms, strict=True):
            z, common = scores[:, : self.inputs].copy(), result.observable.common_damping
            if self.size > self.inputs:
                other = scores[:, self.inputs :]
                z[:, self._damping] *= common
                z[:, self._damping] += np.sqrt(1 - common**2) * other
            for columns in result.observable.unseen:
                z[:, columns] = 0.0
            prediction.append(polynomials(degrees, z) @ coefficient)
        return np.hstack(prediction)

    def misses(self, scores: Array) -> Array:
        """Return the differences from the results (n, n_channels), white and of variance 1."""
        difference = (self.value - self(scores)).T
        return np.asarray(la.solve_triangular(self._root, difference, lower=True).T)

    @cached_property
    def _possible(self) -> Array:
        """(n, n_channels) results with the stated spreads."""
        rng = np.random.default_rng(2)
        prediction = self(rng.standard_normal((COUNTED, self.size)))
        return np.asarray(prediction + rng.standard_normal(prediction.shape) @ self._root.T)

    def probability(self) -> tuple[float, Array]:
        """Return the probability of results that lie farther out, and the score of each channel.

        Far out of all channels together, by the distance of Mahalanobis, or of one by its score.
        Both are counted on samples of the stated spreads, beyond which they are those of normal
        distributions.
        """
        possible = self._possible
        scores = (np.vstack([possible, self.value]) - possible.mean(axis=0)) / possible.std(axis=0)
        root = la.cholesky(np.atleast_2d(np.corrcoef(possible, rowvar=False)), lower=True)
        square = np.sum(la.solve_triangular(root, scores.T, lower=True) ** 2, axis=0)
        largest, count = np.abs(scores).max(axis=1), scores.shape[1]
        shares = [float(np.mean(size[:-1] >= size[-1])) for size in (square, largest)]
        tails = chi2.sf(square[-1], count), 2 * count * norm.sf(largest[-1])
        few = FEWEST / COUNTED
        probable = [
            share if share > few else min(float(tail), few)
            for share, tail in zip(shares, tails, strict=True)
        ]
        return min(2 * min(probable), 1.0), scores[-1]

    def mode(self) -> ScoreDistribution:
        """Return the scores of the largest density, and the normal distribution about them."""

        def difference(z: Array) -> Array:
            return np.append(z, self.misses(z[None])[0])

        def slope(z: Array) -> Array:
            steps = STEP * np.eye(self.size)
            change = (self.misses(z + steps) - self.misses(z - steps)) / (2 * STEP)
            return np.vstack([np.eye(self.size), change.T])

        best = least_squares(difference, np.zeros(self.size), slope, xtol=1e-6, ftol=1e-6)
        return ScoreDistribution(best.x, la.inv(best.jac.T @ best.jac))

    def posterior(self, drawn: int = DRAWN) -> tuple[Array, float]:
        """Return samples of the scores (n, n_scores), and how many of all of them weigh."""
        about, rng = self.mode(), np.random.default_rng(3)
        for _ in range(ROUNDS):
            root = la.cholesky(about.covariance, lower=True)
            uniform = qmc.Sobol(self.size, rng=rng).random(drawn)
            white = norm.ppf(np.clip(uniform, 1e-9, 1 - 1e-9))
            z = about.mean + white @ root.T
            log_weight = (np.sum(white**2, axis=1) - np.sum(z**2, axis=1)
                          - np.sum(self.misses(z) ** 2, axis=1)) / 2  # fmt: skip
            weight = np.exp(log_weight - logsumexp(log_weight))
            effective = 1 / (drawn * float(np.sum(weight**2)))
            if effective >= ENOUGH:
                break
            tempered, power = weight, 1.0
            while drawn * float(np.sum(tempered**2)) > 1 / ENOUGH:
                power /= 2
                tempered = np.exp(power * log_weight - logsumexp(power * log_weight))
            about = ScoreDistribution(tempered @ z, np.cov(z, rowvar=False, aweights=tempered))
        place = np.searchsorted(np.cumsum(weight), (np.arange(drawn) + 0.5) / drawn)
        return z[np.minimum(place, drawn - 1), : self.inputs], effective


def _fitted(scores: Array, observable: Observable) -> list[Chaos]:
    columns = observable.values.T
    return [fitted(scores, values, draws=DRAWS, degree=DEGREE) for values in columns]


def _joined(chaoses: Sequence[Chaos]) -> tuple[Index, Array]:
    """Return the terms of some chaoses (n_terms, n_scores), and their coefficients in each."""
    rows = np.vstack([chaos.degrees for chaos in chaoses])
    degrees, place = np.unique(rows, axis=0, return_inverse=True)
    coefficient = np.zeros((len(degrees), len(chaoses)))
    column = np.repeat(np.arange(len(chaoses)), [len(chaos.degrees) for chaos in chaoses])
    coefficient[place.ravel(), column] = np.concatenate([chaos.coefficient for chaos in chaoses])
    return degrees, coefficient
