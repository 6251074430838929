"""Particles that were measured are found again, with intervals that widen with the errors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import inv, sqrtm
from scipy.stats import t as student

from pidpanel.damping.atlas_files import read_atlas
from pidpanel.identify.posterior import (
    MISFITS,
    FillPrior,
    MeasuredDamping,
    Posterior,
    grid_posterior,
    identify,
    quadrature,
    quantiles,
)
from pidpanel.identify.prediction import Specimen, Tones, predict

ATLAS = read_atlas()
SPECIMEN = Specimen(6.35e-3, 25e-3, 2e-3, "flat", 1.0, mass_per_fill=12.0, particle_mass=6.0)
TRUE = np.array([0.7, np.log(0.2), 0.5])
TONES = Tones(
    np.array([60.0, 60.0, 200.0, 200.0, 800.0, 800.0]),
    np.array([5.0, 40.0, 5.0, 40.0, 5.0, 40.0]),
    np.zeros(6, bool),
)
RANGES = (0.3, 0.95), (np.log(0.05), np.log(0.8))
FREE, KNOWN, EXACT = FillPrior(0.05, 0.95), FillPrior(0.05, 0.95, 0.5, 0.01), FillPrior(0.5, 0.5)


def drawn(seed, error=0.03, factor=1.0, atlas=ATLAS):
    """What the atlas itself would measure: its errors, and those of the test, are drawn."""
    predicted = predict(atlas, SPECIMEN, TRUE[None], TONES)
    noise = np.diag(np.concatenate([np.full(6, error), np.full(6, 6 * error)]) ** 2)
    rng = np.random.default_rng(seed)
    values = rng.multivariate_normal(predicted.mean[0], predicted.covariance[0] + noise)
    damping = factor * np.exp(values[:6])
    return MeasuredDamping(TONES, damping, error * damping, values[6:], np.full(6, 6 * error))


def test_intervals_hold_what_they_say():
    hits, scores = [], []
    for seed in range(10):
        posterior = identify(ATLAS, SPECIMEN, drawn(seed), EXACT, RANGES)
        for axis in range(2):
            known = posterior.estimate(axis)
            hits.append(known.low <= TRUE[axis] <= known.high)
        scores.append(posterior.is_explained)
    # 90 % of 20 within two standard deviations
    assert 0.75 <= np.mean(hits)
    assert np.mean(scores) > 0.9


def test_a_fill_fraction_that_is_not_known_is_found():
    free = identify(ATLAS, SPECIMEN, drawn(3), FREE, RANGES)
    known = identify(ATLAS, SPECIMEN, drawn(3), KNOWN, RANGES)
    assert known.mean[2] == pytest.approx(0.5, abs=0.02)
    assert known.estimate(2).error <= 0.0101 < free.estimate(2).error
    assert free.estimate(2).low < 0.5 < free.estimate(2).high


def test_weights_are_those_of_students_t_of_each_value_and_of_all_misfits():
    measured, axes = drawn(4, factor=1.3), (np.array([0.5, 0.6]), np.log([0.2, 0.3]), np.r_[0.5])
    posterior = grid_posterior(ATLAS, SPECIMEN, measured, EXACT, axes)
    predicted = predict(ATLAS, SPECIMEN, posterior.particles, TONES, measured.values)
    expected, chi_square = [], []
    for mean, covariance, scale, log_states in zip(*predicted, strict=True):
        sigma = covariance * np.outer(scale, scale) + np.diag(measured.errors**2)
        sd = np.sqrt(np.diag(sigma))
        correlation = sigma / np.outer(sd, sd)
        z = inv(sqrtm(correlation)) @ ((measured.values - mean) / sd)
        # scaled by s, with the prior 1/s over ln s
        density = sum(student.pdf(z / s, 5).prod() / s ** (len(z) + 1) for s in MISFITS)
        density /= sd.prod() * np.sqrt(np.linalg.det(correlation))
        expected.append(density * np.exp(log_states.sum()))
        chi_square.append(z @ z)
    # ln(1 − e²) is uniform
    restitution = posterior.particles[:, 0]
    expected = np.array(expected) * restitution / (1 - restitution**2)
    # the integral by the trapezoidal rule; constants of all densities are left out
    total = np.sum(expected) * (0.1 / 2) * (np.log(1.5) / 2) / student.pdf(0, 5) ** 12
    assert posterior.log_evidence == pytest.approx(np.log(total), abs=1e-8)
    expected = np.array(expected) / np.sum(expected)
    np.testing.assert_allclose(posterior.weights.ravel(), expected, rtol=1e-8)
    np.testing.assert_allclose(posterior.chi_square.ravel(), chi_square, rtol=1e-8)


def test_gravity_in_the_other_direction_is_noticed():
    measured = drawn(1)
    known = identify(ATLAS, SPECIMEN, measured, EXACT, RANGES)
    assert known.gravity_odds < 0.1 and not known.is_other_gravity
    upright = replace(SPECIMEN, direction="upright")
    mistaken = identify(ATLAS, upright, measured, EXACT, RANGES)
    assert mistaken.is_other_gravity
    # along the motion no particle would move below 1 g
    slow = replace(measured, tones=TONES._replace(acceleration_g=TONES.acceleration_g / 6))
    assert identify(ATLAS, upright, slow, EXACT, RANGES).gravity_odds == 0


def test_the_probability_is_that_of_students_t():
    # with one value more than parameters, that of |t| > √χ²
    posterior = normal(0.6, 0.04)
    alone = replace(posterior, count=4, mean_chi_square=6.6)
    alone = replace(alone, chi_square=np.full(posterior.weights.shape, 6.6))
    assert alone.probability == pytest.approx(2 * student.sf(np.sqrt(6.6), 5), abs=0.005)
    assert replace(alone, count=40).probability > 0.99
    # no less than one, and one more where r is known
    assert replace(alone, count=2).probability == alone.probability

    def with_fills(*fills):
        """Fewer fill fractions on the grid."""
        size = len(fills)
        arrays = {name: getattr(alone, name)[..., :size] for name in ("weights", "chi_square")}
        return replace(alone, axes=(*alone.axes[:2], np.array(fills)), **arrays)

    known = with_fills(0.5)
    assert with_fills(0.4, 0.6).probability == alone.probability
    assert known.probability == replace(alone, count=5).probability > 1.5 * alone.probability


def test_what_the_model_does_not_know_widens_the_intervals():
    consistent = drawn(6)
    factor = np.array([1, 1, 3, 1 / 3, 3, 1 / 3])
    damping, error = consistent.damping * factor, consistent.damping_error * factor
    apart = replace(consistent, damping=damping, damping_error=error)
    good, poor = (identify(ATLAS, SPECIMEN, m, EXACT, RANGES) for m in (consistent, apart))
    assert good.probability > 0.1 > poor.probability
    known, vague = ([p.estimate(axis) for axis in range(2)] for p in (good, poor))
    assert all(one.is_determined for one in known)
    assert not any(one.is_determined for one in vague)
    # twice as wide in ln(1 − e²) and ln μ
    losses = [np.log1p(-np.square([one.low, one.high])) for one in (known[0], vague[0])]
    assert np.ptp(losses[1]) > 1.5 * np.ptp(losses[0])
    assert vague[1].high - vague[1].low > 1.5 * (known[1].high - known[1].low)


def test_particles_explain_a_tone_in_another_state_of_motion():
    usual = predict(ATLAS, SPECIMEN, TRUE[None], TONES)
    bed = SPECIMEN.bed(TRUE[:1], np.exp(TRUE[1:2]))
    points = bed.points(np.full(6, 0.5), TONES.frequency, TONES.acceleration_g)
    log_damping, mass = ATLAS.damping_of(bed, 1.0).surface.mixtures(points)
    assert log_damping.crossing[1] < 0.1  # at W/L = 0.2 the atlas expects the bed to ride
    values = usual.mean[0].copy()
    step = 1 - log_damping.crossing[1]
    values[1] += step * log_damping.step[1]
    values[7] += step * mass.step[1] * 6.0 * (1 - 1 / 40**2)
    error = 0.03 * np.exp(values[:6])
    measured = MeasuredDamping(TONES, np.exp(values[:6]), error, values[6:], np.full(6, 0.18))
    states = predict(ATLAS, SPECIMEN, TRUE[None], TONES, measured.values)
    np.testing.assert_allclose(states.mean[0], values, rtol=1e-6)
    assert (states.log_states[0] < np.log(0.5)).tolist() == [False, True, *4 * [False]]
    posterior = identify(ATLAS, SPECIMEN, measured, EXACT, RANGES)
    assert posterior.probability > 0.5
    assert all(
        posterior.estimate(axis).low < TRUE[axis] < posterior.estimate(axis).high
        for axis in range(2)
    )


def test_values_that_were_not_measured_do_not_count():
    measured = drawn(5)
    alone = replace(measured, mass=np.full(6, np.nan))
    posterior = identify(ATLAS, SPECIMEN, alone, EXACT, RANGES)
    assert posterior.count == 6 and np.isfinite(posterior.weights).all()
    first = measured.rows(np.arange(6) < 2)
    assert identify(ATLAS, SPECIMEN, first, EXACT, RANGES).count == 4


def test_the_answer_does_not_depend_on_the_grid():
    fine = identify(ATLAS, SPECIMEN, drawn(2), EXACT, RANGES)
    axes = tuple(np.linspace(a[0], a[-1], 2 * len(a) - 1) for a in fine.axes)
    finer = grid_posterior(ATLAS, SPECIMEN, drawn(2), EXACT, axes)
    for axis in range(2):
        coarse, exact = fine.estimate(axis), finer.estimate(axis)
        assert fine.mean[axis] == pytest.approx(finer.mean[axis], abs=0.05 * exact.error)
        assert coarse.high == pytest.approx(exact.high, abs=0.1 * exact.error)


def normal(mean, sd, ends=((0.3, 0.95), (-3.0, -0.2), (0.4, 0.6))):
    axes = tuple(np.linspace(*end, 41) for end in ends)
    e, log_friction, fill = np.meshgrid(*axes, indexing="ij")
    away = (e - mean) / sd, (log_friction + 1.5) / 0.3, (fill - 0.5) / 0.02
    weights = np.exp(-0.5 * (away[0] ** 2 + away[1] ** 2 + away[2] ** 2 - 1.2 * away[0] * away[1]))
    for axis, x in enumerate(axes):
        weights *= quadrature(x).reshape([-1 if k == axis else 1 for k in range(3)])
    return Posterior(axes, weights / weights.sum(), np.full(weights.shape, 3.0), ends, 5)


def test_a_normal_posterior_has_its_moments_and_intervals():
    posterior = normal(0.6, 0.04)
    known = posterior.estimate(0)
    sd = 0.04 / np.sqrt(1 - 0.6**2)
    assert posterior.mean[0] == pytest.approx(0.6, abs=1e-3)
    assert known.error == pytest.approx(sd, rel=1e-2)
    assert known.high - known.low == pytest.approx(2 * 1.645 * sd, rel=3e-2)  # steps of sd/3
    assert posterior.correlation[0, 1] == pytest.approx(0.6, abs=0.01)
    assert posterior.correlation[0, 2] == pytest.approx(0, abs=1e-9)
    assert not (known.cut_low or known.cut_high)
    high, low = normal(0.93, 0.05).estimate(0), normal(0.32, 0.05).estimate(0)
    assert (high.cut_low, high.cut_high) == (False, True)
    assert (low.cut_low, low.cut_high) == (True, False)
    # two standard deviations from the end its density is 0.14 of the largest
    assert not normal(0.825, 0.05).estimate(0).cut_high
    # a box within the range of the prior cuts nothing
    wide = replace(normal(0.93, 0.05), ranges=((0.2, 0.97), (-3.0, -0.2), (0.4, 0.6)))
    assert not wide.estimate(0).cut_high


def two_modes(mean_chi_square):
    """A posterior with 60 % of its weight at e = 0.4, 40 % at 0.8, and χ² = 1 and 2 there."""
    axes = np.linspace(0.3, 0.9, 7), np.linspace(-3.0, -1.0, 5), np.array([0.5])
    weights, chi_square = np.full((7, 5, 1), 1e-9), np.full((7, 5, 1), 60.0)
    for place, share, value in (((1, 2, 0), 0.6, 1.0), ((5, 1, 0), 0.4, 2.0)):
        weights[place], chi_square[place] = share, value
    ranges = (0.3, 0.95), (-3.0, -0.2), (0.5, 0.5)
    return Posterior(axes, weights / weights.sum(), chi_square, ranges, 4, mean_chi_square)


def test_one_set_of_particles_is_named_and_judged():
    split = two_modes(mean_chi_square=55.0)
    assert split.is_split and split.is_explained and split.best_chi_square == 1.0
    np.testing.assert_allclose(split.best, [0.4, -2.0, 0.5])
    assert [split.estimate(axis).value for axis in range(3)] == pytest.approx([0.4, -2.0, 0.5])
    assert split.mean[0] == pytest.approx(0.56)
    # where the mean explains the measurement it is named
    whole = two_modes(mean_chi_square=4.0)
    assert not whole.is_split and whole.best_chi_square == 4.0
    np.testing.assert_allclose(whole.best, [0.56, -2.2, 0.5], atol=1e-6)
    # nothing explains it, but the mean comes closest
    poor = replace(two_modes(mean_chi_square=55.0), chi_square=np.full((7, 5, 1), 60.0))
    assert not poor.is_split and poor.best_chi_square == 55.0 and not poor.is_explained


def test_the_mode_has_the_largest_density():
    split = two_modes(mean_chi_square=55.0)
    weights = np.full((7, 5, 1), 1e-9)
    weights[0, 2], weights[3, 2] = 0.45, 0.55  # densities 0.9 and 0.55
    at_end = replace(split, weights=weights / weights.sum(), chi_square=np.ones((7, 5, 1)))
    assert at_end.is_split
    np.testing.assert_allclose(at_end.best, [0.3, -2.0, 0.5])


def test_an_interval_as_wide_as_the_prior_determines_nothing():
    # 90 % of a range of 0.65 are 0.585
    density = normal(0.6, 10.0)
    assert not density.estimate(0).is_determined
    known = density.estimate(1)
    assert known.is_determined and known.high - known.low < 0.8 * 0.9 * 2.8
    assert normal(0.6, 0.1).estimate(0).is_determined


def test_quantiles_are_those_of_the_density():
    x = np.linspace(1.0, 3.0, 21)
    assert quantiles(x, x - 1, (0.25, 0.81)) == pytest.approx((2.0, 2.8), abs=1e-4)
    assert quantiles(x, np.ones(21), (0.02, 1.0)) == pytest.approx((1.04, 3.0))
    assert quantiles(np.r_[0.7], np.ones(1), (0.05, 0.95)) == (0.7, 0.7)
