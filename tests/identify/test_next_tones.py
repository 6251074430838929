"""The further tone that is proposed tells most, and what it is expected to leave is what is left."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.identify.next_tones import _drawn, candidates, next_tones
from pidpanel.identify.posterior import FillPrior, MeasuredDamping, identify
from pidpanel.identify.prediction import Specimen, Tones, predict

ATLAS = read_atlas()
SPECIMEN = Specimen(6.35e-3, 25e-3, 2e-3, "flat", 1.0, mass_per_fill=12.0, particle_mass=6.0)
TRUE = np.array([[0.7, np.log(0.2), 0.5]])
RANGES = (0.3, 0.95), (np.log(0.05), np.log(0.8))
KNOWN = FillPrior(0.5, 0.5)
ERROR = 0.03
FIRST = (60.0, 5.0), (800.0, 40.0)
FURTHER = candidates((20.0, 2000.0), 50.0, 10e-3, 1.0)


def measured(*tones):
    f, gamma = np.array(tones).T
    tones = Tones(f, gamma, np.zeros(len(f), bool))
    values = predict(ATLAS, SPECIMEN, TRUE, tones).mean[0]
    damping = np.exp(values[: len(f)])
    return MeasuredDamping(
        tones, damping, ERROR * damping, values[len(f) :], np.full(len(f), ERROR * 6)
    )


def test_the_shaker_limits_the_tones():
    tones = candidates((20.0, 2000.0), 50.0, 5e-3, 1.0)
    assert tones.frequency.min() >= 20 and tones.frequency.max() == pytest.approx(2000)
    assert tones.acceleration_g.max() == pytest.approx(50) and tones.acceleration_g.min() >= 1.5
    stroke = tones.acceleration_g * STANDARD_GRAVITY / (2 * np.pi * tones.frequency) ** 2
    assert 2.5e-3 < stroke.max() <= 5e-3
    assert len(candidates((1.0, 2.0), 50.0, 1e-6, 1.0).frequency) == 0


@pytest.fixture(scope="module")
def posterior():
    """What the tones `FIRST` leave."""
    return identify(ATLAS, SPECIMEN, measured(*FIRST), KNOWN, RANGES)


@pytest.fixture(scope="module")
def expected(posterior):
    """What further tones are expected to tell."""
    return next_tones(ATLAS, SPECIMEN, measured(*FIRST), posterior, FURTHER, ERROR)


def test_the_proposed_tone_narrows_more_than_others(posterior, expected):
    assert (expected["information_nat"] > -1e-9).all()
    errors = expected["restitution_error"], expected["log_friction_error"]
    for axis, after in enumerate(errors):
        before = posterior.estimate(axis).error
        assert (after <= before * (1 + 1e-9)).all() and after.min() < 0.95 * before
    best, *others = (
        area(identify(ATLAS, SPECIMEN, measured(*FIRST, tone_of(FURTHER, i)), KNOWN, RANGES))
        for i in (expected["information_nat"].idxmax(), *range(0, len(FURTHER.frequency), 8))
    )
    assert best < 0.7 * area(posterior) and best < 0.85 * np.median(others)


def tone_of(tones, number):
    return tones.frequency[number], tones.acceleration_g[number]


def area(posterior):
    """Joint standard error of e and ln μ."""
    errors = [posterior.estimate(axis).error for axis in (0, 1)]
    return np.prod(errors) * np.sqrt(1 - posterior.correlation[0, 1] ** 2)


@pytest.mark.parametrize("mass", ["weighed", "of the fill", "not measured", "at one tone"])
def test_errors_left_are_those_of_the_joint_normal_distribution(mass):
    """With precision matrices, a particle and a tone at a time."""
    specimen = replace(SPECIMEN, particle_mass=5.0 if mass == "weighed" else None)
    first = measured(*FIRST)
    kept = {"not measured": [False, False], "at one tone": [False, True]}.get(mass, [True, True])
    first = replace(first, mass=np.where(kept, first.mass, np.nan))
    fill = FillPrior(0.4, 0.6)
    posterior = identify(ATLAS, specimen, first, fill, RANGES)
    further = Tones(*(column[[20, 70]] for column in FURTHER))
    expected = next_tones(ATLAS, specimen, first, posterior, further, ERROR)

    particles = posterior.particles[_drawn(posterior.weights.ravel(), 160)]
    prior = np.cov(particles[:, :2].T, ddof=0)
    weight = 5.0 if mass == "weighed" else 12.0 * particles[:, 2].mean()
    noise = [ERROR, ERROR * weight][: 1 if mass == "not measured" else 2]
    known = np.isfinite(first.values)
    for number, tone in enumerate(zip(*further, strict=True)):
        means, covariances = [], []
        for particle in particles:
            tones = Tones(*(np.append(a, b) for a, b in zip(first.tones, tone, strict=True)))
            joint = predict(ATLAS, specimen, particle[None], tones)
            of_first, of_further = np.array([0, 1, 3, 4])[known], np.array([2, 5])[: len(noise)]
            order = np.append(of_first, of_further)
            errors = np.append(first.errors[known], np.zeros(len(noise)))
            precision = np.linalg.inv(
                joint.covariance[0][np.ix_(order, order)] + np.diag(errors**2)
            )
            m = len(of_first)
            within = np.linalg.inv(precision[m:, m:])
            away = first.values[known] - joint.mean[0, of_first]
            means.append(joint.mean[0, of_further] - within @ precision[m:, :m] @ away)
            covariances.append(within)
        both = np.cov(np.hstack([particles[:, :2], means]).T, ddof=0)
        both[2:, 2:] += np.mean(covariances, axis=0) + np.diag(np.square(noise))
        left = np.linalg.inv(np.linalg.inv(both)[:2, :2])
        assert expected["information_nat"][number] == pytest.approx(
            0.5 * np.log(np.linalg.det(prior) / np.linalg.det(left)), rel=1e-6
        )
        for axis, errors in enumerate(
            (expected["restitution_error"], expected["log_friction_error"])
        ):
            narrowed = np.sqrt(left[axis, axis] / prior[axis, axis])
            assert errors[number] == pytest.approx(
                narrowed * posterior.estimate(axis).error, rel=1e-6
            )
