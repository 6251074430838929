"""The jump at which a bed begins to cross the gap as one body, and the side of a motion.

A bed rides on the floor, thrown up and caught, or crosses the gap and meets both ends in every
cycle; where the two meet, C_e jumps by up to ten. The jump is at the stroke over gap

    (W/L) √(1 − 2Γ₀/(Γ W/L)) = e^τ,

with the root for the speed that is left at the lid of a bed thrown at ωW (none, and no crossing,
where it does not get there: 2Γ₀ ≥ Γ W/L). τ(r, ln Γ) is a Gaussian process about ln x₀. Of each
case it is known whether the bed crosses, and so on which side of it τ lies:

    P(crosses) = Φ((u − τ)/w),   u = ln(W/L) + ½ ln(1 − 2Γ₀/(Γ W/L)),

and the posterior of τ follows by expectation propagation (Rasmussen and Williams 2006, 3.6).
"""

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.linalg.blas import dger
from scipy.special import log_ndtr, ndtr

from pidpanel.arrays import Array
from pidpanel.damping.gaussian_process import matern
from pidpanel.damping.inelastic import LONGEST_GAP

# W/L from which on beds were found to dissipate as the closed form of the inelastic body.
WHOLE = 0.5

CENTRE = 0.5 * np.log(WHOLE / LONGEST_GAP)
# ln x₀ and the standard deviation of τ: the body meets both walls in every cycle from
# W/L = 1/√(π² + 4) on, and half of what lies between there and `WHOLE` in the logarithm is one
# standard deviation.
SIZE = 0.5 * np.log(WHOLE * LONGEST_GAP)

LENGTHS = np.array([0.3, 1.5])  # of r and ln Γ

WIDTH = 0.02  # w: what the sides of two beds of one fill and Γ overlap in ln(W/L)

SURE = 6.0  # standard deviations of τ and w beyond which a case adds no information

SWEEPS, CONVERGED = 50, 1e-6


def reach(log_stroke: Array, log_gamma: Array, onset_g: float | Array) -> Array:
    """Return u (n,) of ln(W/L) and ln Γ; −∞ where the bed does not get to the lid."""
    left = 1 - 2 * onset_g * np.exp(-log_stroke - log_gamma)
    with np.errstate(divide="ignore"):
        return log_stroke + 0.5 * np.log(np.maximum(left, 0.0))


class Jump:
    """The posterior of τ, given on which side cases lie.

    Parameters
    ----------
    points, reached
        (n, k) r, ln Γ and further coordinates of the cases, and (n,) u of `reach`.
    side
        (n,) their sides, 1 or 0; 0.5 for a case between the two, at the jump, used on both sides.
    lengths
        (k,) correlation lengths of the columns of the points.
    """

    def __init__(
        self, points: Array, reached: Array, side: Array, lengths: Array = LENGTHS
    ) -> None:
        self._points, self._reached, self._side, self._lengths = points, reached, side, lengths
        rides, crosses = np.flatnonzero(side < 1), np.flatnonzero(side > 0)
        case = np.concatenate([rides, crosses])
        sign = np.repeat([-1.0, 1.0], [len(rides), len(crosses)])
        distance = reached[case] - CENTRE
        tells = np.isfinite(distance)
        tells[tells] = sign[tells] * distance[tells] < SURE * np.hypot(SIZE, WIDTH)
        self._telling = case[tells]
        prior = self._kernel(points[self._telling], points[self._telling])
        precision, information = _propagated(prior, distance[tells], sign[tells])
        root = np.sqrt(precision)
        inner = np.eye(len(root)) + root[:, None] * prior * root
        half = solve_triangular(cholesky(inner, lower=True), np.diag(root), lower=True)
        # τ − ln x₀ is normal with the mean k·weights
        self._half, self._weights = half, information - half.T @ (half @ (prior @ information))

    def probability(self, points: Array, reached: Array) -> Array:
        """Return the probability (m,) that the bed crosses at points (m, k) and u (m,)."""
        cross = self._kernel(points, self._points[self._telling])
        mean, explained = cross @ self._weights, cross @ self._half.T
        variance = np.maximum(SIZE**2 - (explained**2).sum(axis=1), 0.0)
        return np.asarray(ndtr((reached - CENTRE - mean) / np.sqrt(WIDTH**2 + variance)))

    def leave_one_out(self) -> Array:
        """Return of each case the probability (n,) that it crosses, as the others have it."""
        probability = self.probability(self._points, self._reached)
        for i in np.unique(self._telling):
            points, reached, side = (
                np.delete(values, i, axis=0) for values in (self._points, self._reached, self._side)
            )
            remaining = Jump(points, reached, side, self._lengths)
            probability[i] = remaining.probability(self._points[[i]], self._reached[[i]])[0]
        return probability

    def _kernel(self, x: Array, y: Array) -> Array:
        square = (((x[:, None] - y[None]) / self._lengths) ** 2).sum(axis=2)
        return SIZE**2 * matern(square)


def _propagated(prior: Array, distance: Array, sign: Array) -> tuple[Array, Array]:
    """Return precision and information (n,) of the normal factors for Φ(±(away − δ)/w)."""
    covariance, mean = prior.copy(order="F"), np.zeros(len(sign))
    precision, information = np.zeros((2, len(sign)))
    for _ in range(SWEEPS):
        previous = mean.copy()
        for i in range(len(sign)):
            # the cavity, without this factor
            cavity = 1 / covariance[i, i] - precision[i]
            centre = (mean[i] / covariance[i, i] - information[i]) / cavity
            spread = np.sqrt(WIDTH**2 + 1 / cavity)
            z = sign[i] * (distance[i] - centre) / spread
            # mean and variance of its product with Φ (Rasmussen and Williams 2006, Eq. 3.58)
            ratio = np.exp(-(z**2) / 2 - np.log(2 * np.pi) / 2 - log_ndtr(z))
            moved = centre - sign[i] * ratio / (spread * cavity)
            narrowed = 1 / cavity - ratio * (z + ratio) / (spread * cavity) ** 2
            gained = max(1 / narrowed - cavity, 0.0) - precision[i]  # rounding
            precision[i] += gained
            changed = moved / narrowed - centre * cavity
            column = covariance[:, i].copy()
            share = gained / (1 + gained * column[i])
            # covariance − share column columnᵀ, in place, and its product with the information
            covariance = dger(-share, column, column, a=covariance, overwrite_a=True)
            more = changed - information[i]
            information[i] = changed
            mean += (more - share * (mean[i] + more * column[i])) * column
        mean = covariance @ information
        if np.abs(mean - previous).max(initial=0.0) < CONVERGED:
            break
    return precision, information
