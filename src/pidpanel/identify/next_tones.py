"""The tone whose measurement is expected to narrow e and μ most.

For particles drawn from the posterior, the prediction of a further tone follows from what was
measured at the others, with its covariance. With A the covariance of θ = (e, ln μ) and that
prediction over the particles, and B that of the prediction itself with all its errors, a
linear-Gaussian update leaves

    cov θ′ = cov θ − A B⁻¹ Aᵀ,

and the information gained from the tone is ½ ln(det cov θ / det cov θ′).
"""

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.atlas import Atlas
from pidpanel.identify.posterior import MeasuredDamping, Posterior
from pidpanel.identify.prediction import Specimen, Tones, predict

SAMPLES = 160  # particles of the posterior
STEPS = (12, 8)  # of frequency and Γ between the limits of a shaker, in the logarithm
LEAST_GAMMA = 1.5  # over gravity, of the atlas


def candidates(
    frequency: tuple[float, float], acceleration_g: float, stroke: float, gravity: float
) -> Tones:
    """Return the tones that a shaker can run.

    Parameters
    ----------
    frequency, acceleration_g, stroke
        Lowest and highest frequency [Hz], largest acceleration and displacement amplitude [m].
    gravity
        Γ₀ of the damper [g], below which nothing is dissipated.
    """
    frequencies = np.geomspace(*frequency, STEPS[0])
    gammas = np.geomspace(LEAST_GAMMA * max(gravity, 1.0), acceleration_g, STEPS[1])
    f, gamma = (values.ravel() for values in np.meshgrid(frequencies, gammas))
    possible = gamma * STANDARD_GRAVITY / (2 * np.pi * f) ** 2 <= stroke
    return Tones(f[possible], gamma[possible], np.zeros(int(possible.sum()), bool))


def next_tones(
    atlas: Atlas,
    specimen: Specimen,
    measured: MeasuredDamping,
    posterior: Posterior,
    further: Tones,
    relative_error: float,
) -> pd.DataFrame:
    """Return the information on e and ln μ from each of several further tones.

    Parameters
    ----------
    relative_error
        Standard error of C_e in the further test, and of m_a over the mass of the particles.

    Returns
    -------
    DataFrame
        A row for each tone, in the columns of ``next_tests.csv``: its frequency [Hz] and Γ, the
        expected standard deviations of e and ln μ, the expected fall of their entropy [nat].
    """
    drawn = posterior.particles[_drawn(posterior.weights.ravel(), SAMPLES)]
    theta = drawn[:, :2] - drawn[:, :2].mean(axis=0)
    mean, covariance = _conditional(atlas, specimen, measured, drawn, further)
    away = mean - mean.mean(axis=0)  # (b, n, k)
    noise = np.full(mean.shape[2], relative_error)
    noise[1:] *= specimen.particle_mass or specimen.mass_per_fill * drawn[:, 2].mean()
    prior = theta.T @ theta / len(drawn)
    cross = np.einsum("bi,bnk->nik", theta, away) / len(drawn)
    spread = np.einsum("bnk,bnl->nkl", away, away) / len(drawn)
    spread += covariance.mean(axis=0) + np.diag(noise**2)
    remaining = prior - cross @ np.linalg.solve(spread, cross.swapaxes(1, 2))
    fall = np.linalg.det(prior) / np.maximum(np.linalg.det(remaining), 1e-300)
    share = np.maximum(np.diagonal(remaining, axis1=1, axis2=2) / np.diag(prior), 0.0)
    errors = np.sqrt(share) * [posterior.estimate(axis).error for axis in range(2)]
    return pd.DataFrame(
        {
            "frequency_hz": further.frequency,
            "acceleration_g": further.acceleration_g,
            "restitution_error": errors[:, 0],
            "log_friction_error": errors[:, 1],
            "information_nat": 0.5 * np.log(fall),
        }
    )


def _conditional(
    atlas: Atlas, specimen: Specimen, measured: MeasuredDamping, particles: Array, further: Tones
) -> tuple[Array, Array]:
    """Return mean (b, n, k) and covariance (b, n, k, k) of ln C_e and m_a after a measurement.

    k is 1 where no m_a was measured.
    """
    tones = Tones(*(np.concatenate(pair) for pair in zip(measured.tones, further, strict=True)))
    predicted = predict(atlas, specimen, particles, tones)
    n, count = len(measured.tones.frequency), len(tones.frequency)
    values, errors = measured.values, measured.errors
    used = np.flatnonzero(np.isfinite(values))
    rows = np.where(used < n, used, used - n + count)
    quantities = 2 if np.isfinite(measured.mass).any() else 1
    new = n + np.arange(count - n)[:, None] + count * np.arange(quantities)
    inner = predicted.covariance[:, rows[:, None], rows] + np.diag(errors[used] ** 2)
    cross = predicted.covariance[:, new.ravel()[:, None], rows]
    gain = np.linalg.solve(inner, cross.swapaxes(1, 2)).swapaxes(1, 2)
    mean = predicted.mean[:, new.ravel()]
    mean = mean + (gain @ (values[used] - predicted.mean[:, rows])[..., None])[..., 0]
    shape = (len(particles), *new.shape)
    blocks = [a.reshape(*shape, len(rows)) for a in (gain, cross)]
    covariance = predicted.covariance[:, new[:, :, None], new[:, None, :]]
    return mean.reshape(shape), covariance - np.einsum("bnki,bnli->bnkl", *blocks)


def _drawn(weights: Array, count: int) -> Index:
    """Return the indices of ``count`` entries, each as often as its weight requires."""
    places = (np.arange(count) + 0.5) / count
    return np.asarray(np.searchsorted(np.cumsum(weights), places).clip(0, len(weights) - 1))
