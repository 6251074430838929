"""The prediction of many particles is the damping of the atlas, particle by particle."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.damping.atlas import atlas_bed
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.damping.broadband import LOG_DAMPING_ERROR
from pidpanel.identify.prediction import Specimen, Tones, predict

ATLAS = read_atlas()
STEEL = Specimen(6.35e-3, 25e-3, 2e-3, "flat", 1.0, mass_per_fill=90.0, particle_mass=36.0)
UPRIGHT = replace(STEEL, direction="upright")
PARTICLES = np.array([[0.8, np.log(0.3), 0.4], [0.55, np.log(0.1), 0.4]])
F = np.array([60.0, 200.0, 900.0, 80.0])
GAMMA = np.array([5.0, 20.0, 12.0, 45.0])
TONES = Tones(F, GAMMA, np.zeros(4, bool))


def damping(specimen, e, log_friction, *, is_broadband):
    bed = atlas_bed(
        e, np.exp(log_friction), specimen.width, specimen.depth, specimen.diameter,
        [specimen.direction],
    )  # fmt: skip
    model = ATLAS.damping_of(bed, specimen.mass_per_fill)
    return model.under_sound() if is_broadband else model


@pytest.mark.parametrize("specimen", [STEEL, UPRIGHT], ids=["flat", "upright"])
@pytest.mark.parametrize("is_broadband", [False, True])
def test_particles_have_the_damping_of_the_atlas(specimen, is_broadband):
    predicted = predict(
        ATLAS, specimen, PARTICLES, TONES._replace(is_broadband=np.full(4, is_broadband))
    )
    assert predicted.mean.shape == (2, 8) and predicted.covariance.shape == (2, 8, 8)
    for row, (e, log_friction, fill) in enumerate(PARTICLES):
        model = damping(specimen, e, log_friction, is_broadband=is_broadband)
        for tone in range(4):
            point = F[[tone]], fill, GAMMA[tone]
            values, covariance = model(*point), model.covariance(*point)
            # the surface interpolates between rows in steps of ln f and ln Γ
            assert np.exp(predicted.mean[row, tone]) == pytest.approx(
                values.equivalent_damping[0], rel=5e-3
            )
            assert predicted.mean[row, 4 + tone] == pytest.approx(values.apparent_mass[0], abs=0.2)
            expected = np.diag(covariance).copy()
            expected[0] += (LOG_DAMPING_ERROR * is_broadband) ** 2
            both = predicted.covariance[row][np.ix_([tone, 4 + tone], [tone, 4 + tone])]
            np.testing.assert_allclose(np.diag(both), expected, rtol=1e-9)
            assert both[0, 1] == pytest.approx(covariance[0, 1], rel=1e-9, abs=1e-15)


def test_errors_between_tones_of_one_amplitude_are_those_of_the_atlas():
    tones = Tones(F, np.full(4, 20.0), np.zeros(4, bool))
    predicted = predict(ATLAS, STEEL, PARTICLES, tones)
    for row, (e, log_friction, fill) in enumerate(PARTICLES):
        model = damping(STEEL, e, log_friction, is_broadband=False)
        expected = model.covariance(F, fill, 20.0)
        # terms of order ten cancel in both, in another order; the condition of the kernel is 3e8
        np.testing.assert_allclose(predicted.covariance[row], expected, rtol=1e-9, atol=1e-9)
    spread = np.sqrt(np.diag(predicted.covariance[0]))
    correlation = predicted.covariance[0] / np.outer(spread, spread)
    assert (np.abs(correlation - np.eye(8)) > 0.05).any()


def test_particles_that_were_not_weighed_have_the_mass_of_their_fill():
    # known to 3 % from the atlas
    weighed = predict(ATLAS, STEEL, PARTICLES, TONES)
    free = predict(ATLAS, replace(STEEL, particle_mass=None), PARTICLES, TONES)
    np.testing.assert_allclose(free.mean, weighed.mean, rtol=1e-12)  # 90 kg/m² · 0.4
    row = np.concatenate([np.ones(4), free.mean[1, 4:]])
    further = 0.03**2 * np.outer(row, row)
    np.testing.assert_allclose(free.covariance[1] - weighed.covariance[1], further, atol=1e-12)


def test_particles_on_a_floor_ride_along_up_to_gravity():
    # a bed that gravity presses on a side wall moves from the least acceleration on
    assert STEEL.onset_g == 1.0 and replace(STEEL, gravity=0.2).onset_g == 0.2
    assert UPRIGHT.onset_g == 0.0


def test_many_particles_are_predicted_in_blocks(monkeypatch):
    whole = predict(ATLAS, STEEL, PARTICLES, TONES)
    monkeypatch.setattr("pidpanel.identify.prediction.BLOCK", 4)
    for once, in_blocks in zip(whole, predict(ATLAS, STEEL, PARTICLES, TONES), strict=True):
        np.testing.assert_allclose(in_blocks, once, rtol=1e-10, atol=1e-12)
