"""C_e and m_a of the atlas for many particles at once, with their covariance over the tones.

It replaces the damping model of one coupon (`damping.atlas.AtlasDamping`): particles differ in e,
μ and r from row to row, and errors of the atlas are common to neighbouring tones.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping.atlas import DOF, REGIMES, Atlas, AtlasBed, Direction, atlas_bed
from pidpanel.damping.broadband import (
    LOG_DAMPING_ERROR,
    broadband_share,
    broadband_share_error,
    broadband_stroke,
    floor_load,
)
from pidpanel.damping.sides import Mixture, joint_covariance
from pidpanel.damping.surface_cases import onset

BULK_ERROR = 0.03  # relative, of the bulk fraction of a full cell that the atlas gives
# Errors of several values of a bed, along a change of e, over those of each value: 1.20 ± 0.10 of
# 135 packings that the atlas did not have (`benchmarks/identify_common.py`)
JOINT_SCALE = 1.2
# W/L of tones that may be in another state of motion, and the prior probability of each state
STATES, OTHER_STATE = (0.05, 1.0), 0.02
BLOCK = 800  # points that are predicted at once; their kernels fit in the cache


@dataclass(frozen=True)
class Specimen:
    """Known properties of the damper: cell and particles, without e, μ and r."""

    # across flats of the cell, its depth, and the diameter of the particles [m]
    width: float
    depth: float
    diameter: float
    direction: Direction  # of gravity
    gravity: float  # over g
    mass_per_fill: float  # m₁ of `Atlas.bulk_fraction` [kg/m²]
    particle_mass: float | None = None  # m″ of the particles if they were weighed [kg/m²]

    def bed(self, restitution: Array, friction: Array) -> AtlasBed:
        """Return the beds (n,) of particles."""
        directions = [self.direction] * len(restitution)
        return atlas_bed(
            restitution, friction, self.width, self.depth, self.diameter, directions, self.gravity
        )

    @property
    def onset_g(self) -> float:
        """Γ₀, up to which the particles ride along [g]."""
        return self.gravity if self.direction in ("flat", 0) else 0.0


class Tones(NamedTuple):
    """Motions of a test."""

    frequency: Array  # (n,) [Hz]
    acceleration_g: Array  # (n,) amplitude Γ, of broadband motion √2 times the rms value
    is_broadband: Flags  # (n,) whether the motion is random: C_e under sound, not of a tone


class Prediction(NamedTuple):
    """ln C_e [N s/m³], then m_a [kg/m²], of particles at tones."""

    mean: Array  # (b, 2n)
    covariance: Array  # (b, 2n, 2n)
    student_scale: Array  # (b, 2n) as `Atlas.student_scale`, of several values
    log_states: Array  # (b, n) ln of the prior probability of the states of motion

    @property
    def student_covariance(self) -> Array:
        """Scale matrix (b, 2n, 2n) of the errors as Student's t."""
        return self.covariance * self.student_scale[:, :, None] * self.student_scale[:, None, :]


def predict(
    atlas: Atlas, specimen: Specimen, particles: Array, tones: Tones, values: Array | None = None
) -> Prediction:
    """Predict a damper with each of several particles from the atlas.

    Parameters
    ----------
    particles
        (b, 3) e, ln μ and r.
    values
        (2n,) measured ln C_e, then m_a. A tone near the jump is then taken as riding, or as
        crossing, where that explains it better.

    Returns
    -------
    Prediction
        Values with the calibrated errors of the atlas. Errors of broadband motion and of the mass
        of the particles, unless they were weighed, are common to all tones.
    """
    step = max(1, BLOCK // len(tones.frequency))
    blocks = [
        _predict_block(atlas, specimen, particles[start : start + step], tones, values)
        for start in range(0, len(particles), step)
    ]
    return Prediction(*(np.concatenate(parts) for parts in zip(*blocks, strict=True)))


def _predict_block(
    atlas: Atlas, specimen: Specimen, particles: Array, tones: Tones, measured: Array | None
) -> Prediction:
    count, n = len(particles), len(tones.frequency)
    restitution, log_friction, fill = np.repeat(particles, n, axis=0).T
    frequency, gamma = np.tile(tones.frequency, count), np.tile(tones.acceleration_g, count)
    bed = specimen.bed(restitution, np.exp(log_friction))
    is_broadband = np.tile(tones.is_broadband, (count, 1))
    stroke = np.exp(bed.log_stroke(bed.points(fill, frequency, gamma)))
    frequency *= np.sqrt(np.where(is_broadband.ravel(), stroke / broadband_stroke(stroke), 1.0))
    points = bed.points(fill, frequency, gamma)
    surface = atlas.damping_of(bed, 1.0).surface
    mixtures = [mixture for mixture in surface.mixtures(points) if mixture is not None]
    stroke = np.exp(bed.log_stroke(points))
    weight = np.full(len(points), specimen.particle_mass or np.nan)
    if specimen.particle_mass is None:
        weight = specimen.mass_per_fill * fill
    h = onset(gamma, bed.onset_g)
    level = np.log(weight * h * frequency)
    load = floor_load(float(np.max(bed.onset_g)), specimen.gravity)
    level += np.where(is_broadband.ravel(), np.log(broadband_share(stroke, fill, load)), 0.0)
    log_states = np.zeros(len(points))
    if measured is not None:
        values = np.tile(measured.reshape(2, n), count)
        values = np.array([values[0] - level, (values[1] / weight - 1 + h) / h])
        tone_stroke = np.where(is_broadband.ravel(), 0.0, stroke)
        mixtures, log_states = _in_states(atlas, mixtures, values, tone_stroke)
    log_damping = level + mixtures[0].mean
    mass = weight * (h * mixtures[1].mean + 1 - h)
    mean = np.hstack([log_damping.reshape(count, n), mass.reshape(count, n)])
    first, second = (_by_particles(mixture, n) for mixture in mixtures)
    covariance = joint_covariance((atlas.damping, atlas.mass), (first, second), (first, second))
    regime = np.digitize(stroke, REGIMES)
    scale = atlas.calibration[:, regime] * [np.ones_like(h), weight * h]
    scale, student = (
        np.hstack([part.reshape(count, n) for part in parts])
        for parts in (scale, JOINT_SCALE * atlas.student_scale[:, regime])
    )
    covariance *= scale[:, :, None] * scale[:, None, :]
    rest = np.zeros((count, n))
    share_error = broadband_share_error(stroke, load).reshape(count, n)
    for error in (LOG_DAMPING_ERROR, share_error):
        covariance += _common(np.hstack([error * is_broadband, rest]))
    if specimen.particle_mass is None:
        covariance += _common(BULK_ERROR * np.hstack([rest + 1, mean[:, n:]]))
    return Prediction(mean, covariance, student, log_states.reshape(count, n))


def _in_states(
    atlas: Atlas, mixtures: list[Mixture], measured: Array, stroke: Array
) -> tuple[list[Mixture], Array]:
    """Return the mixtures, in another state where that explains more, and ln of its prior (n,)."""
    crossing = mixtures[0].crossing.copy()
    near = (stroke > STATES[0]) & (stroke < STATES[1]) & (crossing > 0)
    states = np.array([crossing[near], *np.mgrid[:2, : near.sum()][0]])
    log_prior = np.log([1 - 2 * OTHER_STATE, OTHER_STATE, OTHER_STATE])
    scores = np.repeat(log_prior[:, None], near.sum(), axis=1)
    for sides, mixture, values in zip((atlas.damping, atlas.mass), mixtures, measured, strict=True):
        points, _, riding, step, restless = vars(mixture).values()
        for score, state in zip(scores, states, strict=True):
            definite = Mixture(points[near], state, riding[near], step[near], restless[:, near])
            scale = np.sqrt(sides.variance(definite))
            square = np.nan_to_num(((values[near] - definite.mean) / scale) ** 2)
            score -= 0.5 * (DOF + 1) * np.log1p(square / DOF) + np.log(scale)
    choice, log_states = scores.argmax(axis=0), np.full(len(near), log_prior[0])
    crossing[near], log_states[near] = np.choose(choice, states), log_prior[choice]
    return [replace(mixture, crossing=crossing) for mixture in mixtures], log_states


def _by_particles(mixture: Mixture, n: int) -> Mixture:
    """Return a mixture with the points (b, n) of each of b particles."""
    points, *values, restless = (
        mixture.points, mixture.crossing, mixture.riding, mixture.step, mixture.restless,
    )  # fmt: skip
    crossing, riding, step = (value.reshape(-1, n) for value in values)
    points = points.reshape(-1, n, points.shape[1])
    return Mixture(points, crossing, riding, step, restless.reshape(2, -1, n))


def _common(error: Array) -> Array:
    """Return the covariance (b, m, m) of errors (b, m) that are fully correlated."""
    return np.asarray(error[:, :, None] * error[:, None, :])
