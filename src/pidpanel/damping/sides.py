"""A function that jumps, with a Gaussian process on each side of the jump.

With s = 1 where the bed crosses the gap and 0 where it rides (`jump`), a the function of the beds
that ride and b that of those that cross,

    g = (1 − s) a + s b,      E g = ā + p d,   d = b̄ − ā,   p = P(s = 1),

and between two points, with p_j the probability that the bed crosses at both,

    cov(g, g′) = (1 − p − p′ + p_j) cov(a, a′) + p_j cov(b, b′) + (p_j − p p′) d d′.

What is not known of the jump is taken as common to all points, p_j = min(p, p′): of points of one
fill and Γ that is so, of others it is the largest correlation there can be. Two functions that
jump together, ln C_e and m_a, err together by the last term.

What the processes take for noise belongs to the error of g: it is the scatter between packings and
what changes over less than the distance between cases. It is as wide as `GRAIN`. Where beds are
known to be restless, their further noise is reported.
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.gaussian_process import GaussianProcess
from pidpanel.damping.models import NODE_STEP

# Distance in r, ln Γ and ln W/L over which noise is no longer common; in ln f it is `NODE_STEP`.
GRAIN = np.array([0.2, 2 * NODE_STEP, 2 * NODE_STEP])


@dataclass(frozen=True)
class Mixture:
    """Values of a function at some points, with errors."""

    points: Array  # (n, 3) r, ln Γ, ln W/L
    # (n,) p, ā, d
    crossing: Array
    riding: Array
    step: Array
    restless: Array  # (2, n) further noise of a and b, standard deviations

    @property
    def mean(self) -> Array:
        """(n,) E g."""
        return self.riding + self.crossing * self.step


@dataclass(frozen=True)
class Sides:
    """A process on each side."""

    riding: GaussianProcess
    # b less what is known of it beforehand; None where nothing jumps
    crossing: GaussianProcess | None = None

    def mixture(
        self,
        points: Array,
        crossing: Array,
        expected: Array,
        restless: Array,
        trend: Array | float = 0.0,
    ) -> Mixture:
        """Return what is known at points (n, 3), with p (n,) and the expectation of b (n,).

        ``trend`` (n,) is added to the process of a.
        """
        riding = self.riding.mean(points) + trend
        if self.crossing is None:
            return Mixture(points, np.zeros(len(points)), riding, np.zeros(len(points)), restless)
        step = expected + self.crossing.mean(points) - riding
        return Mixture(points, crossing, riding, step, restless)

    def covariance(self, first: Mixture, second: Mixture) -> Array:
        """Return the covariance (n, m) of g between points, with what is taken for noise.

        Mixtures at (..., n) points, sets of them in the leading axes, have it (..., n, m).
        """
        joint = joint_crossing(first, second)
        neither = 1 - first.crossing[..., None] - second.crossing[..., None, :] + joint
        covariance = neither * _process(self.riding, first.points, second.points)
        riding, crossing = (
            _products(a, b) for a, b in zip(first.restless, second.restless, strict=True)
        )
        grain = _grain(first.points, second.points)
        covariance += (neither * riding + joint * crossing) * grain
        if self.crossing is not None:
            covariance += joint * _process(self.crossing, first.points, second.points)
        return covariance + common(first, second, first.step, second.step)

    def variance(self, mixture: Mixture) -> Array:
        """Return the diagonal (n,) of `covariance`."""
        p = mixture.crossing
        variance = (1 - p) * _variance(self.riding, mixture.points)
        variance += (1 - p) * mixture.restless[0] ** 2 + p * mixture.restless[1] ** 2
        if self.crossing is not None:
            variance += p * _variance(self.crossing, mixture.points)
        return np.asarray(variance + p * (1 - p) * mixture.step**2)

    def leave_one_out(
        self, values: Array, error: Array, side: Array, mixture: Mixture
    ) -> tuple[Array, Array]:
        """Return errors (n,) of the cases' values predicted by the others, and standard errors.

        ``side`` is 0 of the cases of `riding`, 1 of those of `crossing`, both in order; others are
        of neither. ``mixture`` is at the cases, with the jump as the others have it.
        """
        mean, variance = [mixture.riding, mixture.riding + mixture.step], []
        for number, process in enumerate((self.riding, self.crossing)):
            if process is None:
                variance.append(np.zeros(len(values)))
                continue
            rows = side == number
            deviation, size = process.leave_one_out()
            mean[number] = mean[number].copy()
            mean[number][rows] = values[rows] + deviation
            spread = _variance(process, mixture.points)
            spread[rows] = size**2 - process.error**2
            variance.append(spread + mixture.restless[number] ** 2)
        p, step = mixture.crossing, mean[1] - mean[0]
        spread = (1 - p) * variance[0] + p * variance[1] + p * (1 - p) * step**2 + error**2
        return mean[0] + p * step - values, np.sqrt(spread)


def joint_crossing(first: Mixture, second: Mixture) -> Array:
    """Return p_j (n, m)."""
    return np.minimum(first.crossing[..., None], second.crossing[..., None, :])


def common(first: Mixture, second: Mixture, first_step: Array, second_step: Array) -> Array:
    """Return what is common to two functions that jump together, (p_j − p p′) d d′, (n, m)."""
    shared = joint_crossing(first, second) - _products(first.crossing, second.crossing)
    return np.asarray(shared * _products(first_step, second_step))


def joint_covariance(
    sides: tuple[Sides, Sides], first: tuple[Mixture, Mixture], second: tuple[Mixture, Mixture]
) -> Array:
    """Return the covariance (..., 2n, 2m) of two functions that jump together, between points.

    Parameters
    ----------
    sides
        The processes of both functions.
    first, second
        Mixtures of both at (..., n) and (..., m) points, sets of them in the leading axes.
    """
    (a, b), (other_a, other_b) = first, second
    shared = (
        common(a, other_b, a.step, other_b.step), common(b, other_a, b.step, other_a.step)
    )  # fmt: skip
    return np.block(
        [[sides[0].covariance(a, other_a), shared[0]], [shared[1], sides[1].covariance(b, other_b)]]
    )


def _products(first: Array, second: Array) -> Array:
    """Return the outer products (..., n, m) of (..., n) and (..., m)."""
    return np.asarray(first[..., None] * second[..., None, :])


def _process(process: GaussianProcess, first: Array, second: Array) -> Array:
    return process.covariance(first, second) + process.scatter**2 * _grain(first, second)


def _grain(first: Array, second: Array) -> Array:
    """Return the correlation of noise (..., n, m) between points (..., n, 3) and (..., m, 3)."""
    count = len(GRAIN)
    distance = np.abs(first[..., None, :count] - second[..., None, :, :count])
    near = np.maximum(1 - distance / GRAIN, 0.0)
    return np.asarray(near.prod(axis=-1))


def _variance(process: GaussianProcess, points: Array) -> Array:
    return process.standard_error(points) ** 2 + process.scatter**2


def even_steps(low: float, high: float, step: float) -> Array:
    """Return two or more equally spaced values from ``low`` to ``high``, at most ``step`` apart."""
    if high - low < 1e-9:
        return np.array([low, low + step])
    return np.linspace(low, high, max(2, int(np.ceil((high - low) / step)) + 1))
