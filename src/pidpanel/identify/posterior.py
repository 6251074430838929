"""Posterior of e, μ and r from a measurement, on a grid.

With y the measured ln C_e and m_a, p(θ) and S(θ) the prediction of the atlas for θ = (e, ln μ, r)
with its covariance, and N the errors of the measurement,

    ln L(θ) = −½ (ν + 1) Σ_i ln(1 + z_i²/ν) − ½ ln det Σ,   z = C^(−½) D^(−½) (y − p(θ)),

with Σ_ij = σ_i σ_j S_ij + N_ij, its diagonal D and its correlations C. Errors of the atlas are
Student's t with ν = `DOF`, each with outliers of its own; σ is their scale over the calibrated
error (`Atlas.student_scale`). What the model does not know makes all errors s times as large: L is
the sum over s ≥ 1 of `MISFITS`, z over s, with the prior 1/s over ln s.

The prior is uniform in ln(1 − e²), on which ln C_e depends about linearly, and ln μ over the range
of the atlas, and uniform or normal in r. A coarse
grid locates the posterior, a fine one over that box resolves it. One set of particles is named,
judged by χ² = Σ z² and compared with the measurement: the mean of the posterior, or its mode where
the mean lies between modes and does not explain the measurement. Where the atlas explains the
measurement with gravity in the other direction, the mean of L over the prior is larger there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.special import logsumexp

from pidpanel.arrays import Array, Flags
from pidpanel.damping.atlas import DOF, SHARES, Atlas
from pidpanel.identify.prediction import Specimen, Tones, predict

COARSE, FINE = (14, 8, 7), (23, 15, 9)  # points of the grids along e, ln μ and r
NEGLIGIBLE = 1e-3  # share of the largest marginal density below which the fine grid ends
CREDIBILITY = 0.9  # probability of an interval
SAMPLES = 20_000  # random samples for the probability of χ²
LEAST_PROBABILITY = 0.01  # probability of χ² below which no particles explain a measurement
DOUBTFUL_PROBABILITY = 0.1  # below which they hardly do
DOUBTFUL_ODDS = 10.0  # of gravity in the other direction, above which the stated one is doubtful
MISFITS = np.geomspace(1.0, 8.0, 12)  # s, factors on all errors
NEARLY_PRIOR = 0.8  # share of the prior's interval from which on a test determines nothing
CUT_DENSITY = 0.2  # relative density at the end of a range above which an interval is truncated
FILL_SPAN_ERRORS = 3.0  # half width of the grid in r, in standard errors


@dataclass(frozen=True)
class MeasuredDamping:
    """Measured C_e and m_a of one specimen."""

    tones: Tones
    # (n,) C_e and its standard error [N s/m³]; NaN where not measured
    damping: Array
    damping_error: Array
    # (n,) m_a and its standard error [kg/m²]; NaN where not measured
    mass: Array
    mass_error: Array

    @property
    def values(self) -> Array:
        """(2n,) ln C_e, then m_a."""
        return np.concatenate([np.log(self.damping), self.mass])

    def rows(self, used: Flags) -> MeasuredDamping:
        """Return some of the tones."""
        f, gamma, is_broadband = self.tones
        tones = Tones(f[used], gamma[used], is_broadband[used])
        values = self.damping, self.damping_error, self.mass, self.mass_error
        return MeasuredDamping(tones, *(array[used] for array in values))

    @property
    def errors(self) -> Array:
        """(2n,) standard errors of `values`."""
        return np.concatenate([self.damping_error / self.damping, self.mass_error])


class FillPrior(NamedTuple):
    """Prior of the fill fraction r."""

    low: float
    high: float
    # expected value and standard error; NaN for none
    value: float = np.nan
    error: float = np.nan

    def log_density(self, fill: Array) -> Array:
        """Return the logarithm of the density up to a constant."""
        if np.isnan(self.value):
            return np.zeros(len(fill))
        return np.asarray(-0.5 * ((fill - self.value) / self.error) ** 2)


class ParameterEstimate(NamedTuple):
    """Value, standard deviation and 90 % interval of a parameter."""

    value: float  # of the particles that are named, `Posterior.best`
    error: float
    low: float
    high: float
    # Whether the prior's range truncates it
    cut_low: bool
    cut_high: bool
    is_determined: bool  # whether the interval is much narrower than that of the prior


@dataclass(frozen=True)
class Posterior:
    """Weights of particles on a grid."""

    axes: tuple[Array, Array, Array]  # e, ln μ, r
    weights: Array  # (n_e, n_mu, n_r), of sum 1
    chi_square: Array  # (n_e, n_mu, n_r)
    ranges: Sequence[tuple[float, float]]  # of the prior
    count: int  # measured values
    mean_chi_square: float = np.inf  # χ² of the particles with the mean of each parameter
    log_evidence: float = -np.inf  # ln of the integral of L over the grid
    gravity_odds: float = 0.0  # that integral with gravity in the other direction over it

    @property
    def particles(self) -> Array:
        """(b, 3) e, ln μ and r of the grid."""
        return grid_points(self.axes)

    def density(self, axis: int) -> Array:
        """Return the marginal density of a parameter on its axis."""
        share = self.weights.sum(axis=tuple(k for k in range(3) if k != axis))
        return np.asarray(share / quadrature(self.axes[axis]))

    @property
    def mean(self) -> Array:
        """Mean (3,) of e, ln μ and r."""
        return np.asarray(self.weights.ravel() @ self.particles)

    @property
    def _mode(self) -> int:
        """Index of the point with the largest density in ln(1 − e²), ln μ and r."""
        e, log_friction, fill = np.ix_(*(quadrature(x) for x in self.axes))
        e = e * _prior(self.axes[0])[:, None, None]
        return int(np.argmax(self.weights / (e * log_friction * fill)))

    @property
    def is_split(self) -> bool:
        """Whether the mean, as between two modes, explains a measurement less than the mode."""
        mode_chi_square = self.chi_square.ravel()[self._mode]
        is_good = self._probability(self.mean_chi_square) >= DOUBTFUL_PROBABILITY
        return not is_good and bool(mode_chi_square < self.mean_chi_square)

    @property
    def best(self) -> Array:
        """e, ln μ and r (3,) of the particles that are named: the mean, or the mode of a split."""
        return np.asarray(self.particles[self._mode]) if self.is_split else self.mean

    def estimate(self, axis: int) -> ParameterEstimate:
        """Return the estimate of e, ln μ or r, by the number of its axis."""
        x, density = self.axes[axis], self.density(axis)
        share = density * quadrature(x)
        error = float(np.sqrt(share @ (x - float(share @ x)) ** 2))
        low, high = quantiles(x, density, (0.5 - CREDIBILITY / 2, 0.5 + CREDIBILITY / 2))
        likelihood = density / _prior(x) if axis == 0 else density
        at_end = likelihood[[0, -1]] > CUT_DENSITY * likelihood.max()
        begin, end = self.ranges[axis]
        cut = at_end & np.isclose(x[[0, -1]], [begin, end])
        widths = np.array([[low, high], [begin, end]])
        widths = np.ptp(np.log1p(-(widths**2)) if axis == 0 else widths, axis=1)
        is_determined = widths[0] <= NEARLY_PRIOR * CREDIBILITY * widths[1]
        ends = low, high, bool(cut[0]), bool(cut[1])
        return ParameterEstimate(float(self.best[axis]), error, *ends, bool(is_determined))

    @property
    def correlation(self) -> Array:
        """(3, 3) correlation of e, ln μ and r; 0 with parameters that are known exactly."""
        weights = self.weights.ravel()
        deviation = self.particles - weights @ self.particles
        covariance = (weights[:, None] * deviation).T @ deviation
        sd = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
        return np.asarray(covariance / np.outer(sd, sd))

    @property
    def best_chi_square(self) -> float:
        """χ² of `best`."""
        mode_chi_square = self.chi_square.ravel()[self._mode]
        return float(mode_chi_square if self.is_split else self.mean_chi_square)

    @property
    def probability(self) -> float:
        """Probability of a larger χ² = Σ z² if `best` are the measured particles."""
        return self._probability(self.best_chi_square)

    def _probability(self, chi_square: float) -> float:
        free = sum(len(axis) > 1 for axis in self.axes)
        drawn = np.random.default_rng(0).standard_t(DOF, (SAMPLES, max(1, self.count - free)))
        return float(np.mean((drawn**2).sum(axis=1) >= chi_square))

    @property
    def is_doubtful(self) -> bool:
        """Whether the particles explain the measurement, but hardly."""
        return self.is_explained and self.probability < DOUBTFUL_PROBABILITY

    @property
    def is_other_gravity(self) -> bool:
        """Whether gravity in the other direction explains the measurement much better."""
        return self.gravity_odds > DOUBTFUL_ODDS

    @property
    def is_explained(self) -> bool:
        """Whether the particles explain the measurement."""
        return self.probability > LEAST_PROBABILITY


def identify(
    atlas: Atlas,
    specimen: Specimen,
    measured: MeasuredDamping,
    fill: FillPrior,
    ranges: tuple[tuple[float, float], tuple[float, float]],
) -> Posterior:
    """Return the posterior of the particles of a specimen.

    Parameters
    ----------
    atlas
        Simulated beds that predict C_e and m_a.
    specimen
        Cell and known properties of the specimen.
    measured
        Measured C_e and m_a with errors.
    fill
        Prior of r.
    ranges
        Lower and upper limits of e and of ln μ.
    """
    ends = [*ranges, _fill_range(fill)]
    axes = _axes(ends, COARSE)
    coarse = grid_posterior(atlas, specimen, measured, fill, axes)
    box = [_support(x, coarse.density(axis)) for axis, x in enumerate(coarse.axes)]
    fine = grid_posterior(atlas, specimen, measured, fill, _axes(box, FINE))
    mean = tuple(fine.mean[:, None])
    mean_chi_square = grid_posterior(atlas, specimen, measured, fill, mean).chi_square.item()
    across, odds = float(SHARES.get(specimen.direction, specimen.direction)), 0.0
    turned = replace(specimen, direction=1 - across)
    if measured.tones.acceleration_g.min() > turned.onset_g:  # else nothing would move
        other = grid_posterior(atlas, turned, measured, fill, axes)
        odds = float(np.exp(min(other.log_evidence - coarse.log_evidence, 99.0)))
    return replace(fine, ranges=ends, mean_chi_square=mean_chi_square, gravity_odds=odds)


def grid_posterior(
    atlas: Atlas,
    specimen: Specimen,
    measured: MeasuredDamping,
    fill: FillPrior,
    axes: tuple[Array, Array, Array],
) -> Posterior:
    """Return the posterior on a grid."""
    particles = grid_points(axes)
    predicted = predict(atlas, specimen, particles, measured.tones, measured.values)
    used = np.flatnonzero(np.isfinite(measured.values))
    noise = np.diag(measured.errors[used] ** 2)
    covariance = noise + predicted.student_covariance[:, used[:, None], used]
    scale = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    variance, eigenvectors = np.linalg.eigh(covariance / (scale[:, :, None] * scale[:, None, :]))
    deviation = (measured.values[used] - predicted.mean[:, used]) / scale
    whitened = (deviation[:, None] @ eigenvectors) / np.sqrt(variance)[:, None]
    square = (whitened @ eigenvectors.swapaxes(1, 2))[:, 0] ** 2
    scaled = np.log1p(square / (DOF * MISFITS[:, None, None] ** 2)).sum(axis=2)
    prior = (len(used) + 1) * np.log(MISFITS)[:, None]
    log = logsumexp(-0.5 * (DOF + 1) * scaled - prior, axis=0)
    log += fill.log_density(particles[:, 2]) + predicted.log_states.sum(axis=1)
    log -= np.log(scale).sum(axis=1) + 0.5 * np.log(variance).sum(axis=1)
    log += np.log(_prior(particles[:, 0]))
    weights = np.exp(log - log.max()).reshape([len(axis) for axis in axes])
    for axis, x in enumerate(axes):
        weights *= quadrature(x).reshape([-1 if k == axis else 1 for k in range(3)])
    ranges = [(float(x[0]), float(x[-1])) for x in axes]
    total, chi_square = weights.sum(), square.sum(axis=1).reshape(weights.shape)
    evidence = float(log.max() + np.log(total))
    return Posterior(axes, weights / total, chi_square, ranges, len(used), log_evidence=evidence)


def grid_points(axes: Sequence[Array]) -> Array:
    """Return the points (b, 3) of a grid, the last axis fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def quadrature(x: Array) -> Array:
    """Return the weights of the trapezoidal rule on equally spaced points; 1 for a single point."""
    if len(x) == 1:
        return np.ones(1)
    weights = np.full(len(x), x[1] - x[0])
    weights[[0, -1]] /= 2
    return weights


def quantiles(x: Array, density: Array, shares: Sequence[float]) -> tuple[float, ...]:
    """Return quantiles of a density that is interpolated by cubics.

    Examples
    --------
    >>> quantiles(np.linspace(0, 1, 11), np.ones(11), (0.05, 0.95))
    (0.05, 0.95)
    """
    if len(x) == 1:
        return tuple(float(x[0]) for _ in shares)
    between = np.linspace(x[0], x[-1], 40 * len(x))
    below = PchipInterpolator(x, density).antiderivative()(between)
    values = np.interp(np.array(shares) * below[-1], below, between)
    return tuple(round(float(q), 12) for q in values)


def _prior(restitution: Array) -> Array:
    """Return the prior density of e up to a constant: ln(1 − e²) is uniform."""
    return np.asarray(restitution / (1 - restitution**2))


def _axes(ends: Sequence[tuple[float, float]], counts: Sequence[int]) -> tuple[Array, Array, Array]:
    e, log_friction, fill = (
        np.linspace(low, high, count) if high > low else np.array([low])
        for (low, high), count in zip(ends, counts, strict=True)
    )
    return e, log_friction, fill


def _fill_range(fill: FillPrior) -> tuple[float, float]:
    """Return the fill fractions of the grid: all, or those near the expected one."""
    if np.isnan(fill.value):
        return fill.low, fill.high
    width = FILL_SPAN_ERRORS * fill.error
    return max(fill.value - width, fill.low), min(fill.value + width, fill.high)


def _support(x: Array, density: Array) -> tuple[float, float]:
    """Return the range in which a density is not negligible, extended by one point on each side."""
    places = np.flatnonzero(density > NEGLIGIBLE * density.max())
    return float(x[max(places[0] - 1, 0)]), float(x[min(places[-1] + 1, len(x) - 1)])
