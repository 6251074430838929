"""Gaussian process regression of a few hundred noisy points, with numpy and scipy alone.

Kernel (Rasmussen and Williams 2006, Eq. 4.17), squared distance d² = Σ_j ((x_j − x'_j)/l_j)²:

    k(x, x') = m² + s² (1 + √5 d + 5 d²/3) e^(−√5 d)

with m² a wide prior on the constant mean. Observations carry their own errors e_i and a common
scatter t: y_i = f(x_i) + N(0, e_i² + t²). Lengths l_j, size s and scatter t are those of largest
posterior probability under log-normal priors that are wide compared with the data (a factor e, one
standard deviation), but stabilise a fit of few points.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.linalg.lapack import dpotri
from scipy.optimize import minimize

from pidpanel.arrays import Array, Flags

MEAN_SD = 3.0  # m, in standard deviations of the values

OUTLIER = 2.0  # standard errors from what the others predict, beyond which a value is an outlier

PRIOR_MEDIAN_SIZE, PRIOR_SD_SIZE = 1.5, 0.7
PRIOR_MEDIAN_LENGTH, PRIOR_SD_LENGTH = 1.5, 1.0
# Priors of s and t in standard deviations of the values, of l in those of the points, and of logs.
PRIOR_MEDIAN_SCATTER, PRIOR_SD_SCATTER = 0.03, 1.5


@dataclass(frozen=True)
class GaussianProcess:
    """A posterior of a function of d variables."""

    points: Array  # (n, d)
    # (n,) observations and their standard errors
    values: Array
    error: Array
    lengths: Array  # (d,) l, in the units of the points
    # s and t, in the unit of the values
    size: float
    scatter: float
    # Expected mean and unit of the priors; None for those of the values. With both, values are
    # optional.
    centre: float | None = None
    unit: float | None = None

    @cached_property
    def _factor(self) -> Array:
        """Triangle of the covariance of the observations."""
        noise = np.diag(self.error**2 + self.scatter**2)
        return cholesky(self._kernel(self.points, self.points) + noise, lower=True)

    @cached_property
    def _centre(self) -> float:
        return float(np.mean(self.values)) if self.centre is None else self.centre

    @cached_property
    def _weights(self) -> Array:
        if not len(self.values):
            return self.values
        return cho_solve((self._factor, True), self.values - self._centre)

    @cached_property
    def _mean_sd(self) -> float:
        """m."""
        return MEAN_SD * (_spread(self.values) if self.unit is None else self.unit)

    def _kernel(self, x: Array, y: Array) -> Array:
        mean = self._mean_sd
        square = _squares(x / self.lengths, y / self.lengths)
        return mean**2 + self.size**2 * matern(square)

    def mean(self, points: Array) -> Array:
        """Return the expected value (k,) at ``points`` (k, d)."""
        return self._centre + self._kernel(points, self.points) @ self._weights

    def standard_error(self, points: Array) -> Array:
        """Return the standard deviation (k,) of the function without scatter at points (k, d)."""
        explained = self._whitened(points)
        prior = self.size**2 + self._mean_sd**2
        return np.sqrt(np.maximum(prior - (explained**2).sum(0), 0.0))

    def covariance(self, points: Array, other_points: Array | None = None) -> Array:
        """Return the posterior covariance (..., k, m) of the function between points and others.

        Parameters
        ----------
        points, other_points
            (..., k, d) and (..., m, d), sets of points in the leading axes.
        """
        other_points = points if other_points is None else other_points
        first = self._whitened(points.reshape(-1, points.shape[-1]))
        second = first
        if other_points is not points:
            second = self._whitened(other_points.reshape(-1, points.shape[-1]))
        first, second = (
            np.moveaxis(whitened.reshape(len(whitened), *of.shape[:-1]), 0, -2)
            for whitened, of in ((first, points), (second, other_points))
        )
        covariance: Array = self._kernel(points, other_points)
        return covariance - first.swapaxes(-1, -2) @ second

    def _whitened(self, points: Array) -> Array:
        cross = self._kernel(self.points, points)
        if not len(cross):
            return cross
        return solve_triangular(self._factor, cross, lower=True)

    def leave_one_out(self) -> tuple[Array, Array]:
        """Return errors (n,) of values predicted by the others, and the standard errors predicted.

        In closed form at the same l, s and t (Rasmussen and Williams 2006, Eq. 5.12).
        """
        inverse = cho_solve((self._factor, True), np.eye(len(self.values)))
        diagonal = np.diag(inverse)
        return -self._weights / diagonal, 1 / np.sqrt(diagonal)

    @property
    def constants(self) -> Array:
        """(d + 2,) lengths, size and scatter."""
        return np.array([*self.lengths, self.size, self.scatter])

    def with_weaker_outliers(self, among: Flags) -> "GaussianProcess":
        """Return the process with larger errors of values, among some (n,), predicted badly.

        Each is as large as puts its value `OUTLIER` standard errors from what the others predict:
        it pulls no harder than one that lies there (Huber, *Ann. Math. Stat.* 35, 73 (1964)).
        """
        if not among.any():
            return self
        deviation, size = self.leave_one_out()
        further = np.where(among, np.maximum((deviation / OUTLIER) ** 2 - size**2, 0.0), 0.0)
        return replace(self, error=np.sqrt(self.error**2 + further))


def matern(square: Array) -> Array:
    """Return (1 + √5 d + 5 d²/3) e^(−√5 d) of squared distances d²."""
    a = np.sqrt(5 * square)
    return (1 + a + a**2 / 3) * np.exp(-a)


def _squares(a: Array, b: Array) -> Array:
    """Return |a − b|² (..., n, m): one product in place of a cube of differences."""
    square = (a**2).sum(-1)[..., :, None] + (b**2).sum(-1)[..., None, :]
    return np.maximum(square - 2 * a @ b.swapaxes(-1, -2), 0.0)


def _spread(values: Array) -> float:
    """Return the standard deviation, or 1 where there is none."""
    spread = float(np.std(values))
    return spread if spread > 1e-12 * (1 + float(np.abs(values).max())) else 1.0


def spreads(points: Array) -> Array:
    """Return the standard deviation (d,) of points (n, d) by axis, 1 where there is none."""
    return np.array([_spread(column) for column in points.T])


def fit(
    points: Array,
    values: Array,
    error: Array,
    *,
    axes: Array | None = None,
    centre: float | None = None,
    unit: float | None = None,
    near: GaussianProcess | None = None,
) -> GaussianProcess:
    """Fit the process of largest posterior probability to values (n,) at points (n, d) with errors.

    An axis without spread plays no part. ``axes`` (d,) are of `spreads`, where the points are a
    part of those by which lengths are measured. ``near`` is a fit to the same values with nearly
    the same errors, from which the search starts.

    Examples
    --------
    >>> x = np.linspace(0, 6, 12)[:, None]
    >>> process = fit(x, np.sin(x[:, 0]), np.full(12, 0.01))
    >>> bool(abs(process.mean(np.array([[2.2]]))[0] - np.sin(2.2)) < 0.02)
    True
    """
    scale = unit, centre
    unit = _spread(values) if unit is None else unit
    axis = spreads(points) if axes is None else axes
    if not len(values):
        size, scatter = PRIOR_MEDIAN_SIZE * unit, PRIOR_MEDIAN_SCATTER * unit
        lengths = PRIOR_MEDIAN_LENGTH * axis
        return GaussianProcess(points, values, error, lengths, size, scatter, scale[1], scale[0])
    y = (values - (values.mean() if centre is None else centre)) / unit
    variance = (error / unit) ** 2
    x = (points - points.mean(axis=0)) / axis
    median = np.log([*[PRIOR_MEDIAN_LENGTH] * len(axis), PRIOR_MEDIAN_SIZE, PRIOR_MEDIAN_SCATTER])
    sd = np.array([*[PRIOR_SD_LENGTH] * len(axis), PRIOR_SD_SIZE, PRIOR_SD_SCATTER])

    def cost(logs: Array) -> tuple[float, Array]:
        """Return −ln posterior and its gradient in ln l, ln s, ln t."""
        scaled, size, scatter = x * np.exp(-logs[:-2]), np.exp(2 * logs[-2]), np.exp(2 * logs[-1])
        a = np.sqrt(5 * _squares(scaled, scaled))
        decay = np.exp(-a)
        signal = size * (1 + a + a**2 / 3) * decay
        factor = cholesky(MEAN_SD**2 + signal + np.diag(variance + scatter), lower=True)
        lower, _ = dpotri(factor, lower=True)
        inverse = lower + np.tril(lower, -1).T
        alpha = inverse @ y
        pull = np.outer(alpha, alpha) - inverse
        slope = pull * (size * 5 / 3 * (1 + a) * decay)
        # Σ slope_ij (x_i − x_j)² of each axis
        along = 2 * (slope.sum(axis=1) @ scaled**2 - (scaled * (slope @ scaled)).sum(axis=0))
        gradient = np.array([*along, 2 * np.sum(pull * signal), 2 * scatter * np.trace(pull)])
        deviation = (logs - median) / sd
        value = 0.5 * y @ alpha + np.log(np.diag(factor)).sum() + 0.5 * deviation @ deviation
        return float(value), -0.5 * gradient + deviation / sd

    bounds = list(zip(median - 3 * sd, median + 3 * sd, strict=True))
    starts = [median, median + sd * np.array([-0.7] * len(axis) + [0, 1])]
    if near is not None:
        starts = [np.log(near.constants / [*axis, unit, unit])]
    best = min(
        (minimize(cost, s, jac=True, method="L-BFGS-B", bounds=bounds) for s in starts),
        key=lambda optimum: optimum.fun,
    )
    lengths, (size, scatter) = np.exp(best.x[:-2]) * axis, np.exp(best.x[-2:]) * unit
    return GaussianProcess(
        points, values, error, lengths, float(size), float(scatter), scale[1], scale[0]
    )
