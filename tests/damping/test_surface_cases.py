"""What cases teach: on which side of the jump they are, how restless, and what outliers weigh."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping import gaussian_process
from pidpanel.damping.inelastic import slug, slug_energy
from pidpanel.damping.jump import WHOLE
from pidpanel.damping.surface_cases import (
    AXES,
    SurfaceBed,
    TrainingData,
    _side,
    logarithmic,
    training_data,
)

MASS_PER_FILL = 12.0
BED = SurfaceBed(1.0, MASS_PER_FILL, 0.02)


def points_of(stroke):
    """Points of `BED` at r = 0.5 and 10 g with W/L."""
    coordinate = np.log(stroke) - np.log(STANDARD_GRAVITY / (4 * np.pi**2 * BED.depth))
    return np.stack(
        [np.full_like(coordinate, 0.5), np.full_like(coordinate, np.log(10)), coordinate]
    ).T


def test_beds_are_restless_near_the_jump():
    at = np.array([0.01, 0.06, np.sqrt(0.06 * 0.15), 0.15, np.sqrt(0.33 * 0.45), 0.45, 3.0])
    riding, crossing = BED.restless(points_of(at))
    np.testing.assert_allclose(riding, [0, 0, 0.125, 0.25, 0.25, 0.25, 0.25], atol=1e-12)
    np.testing.assert_allclose(crossing, [0.25, 0.25, 0.25, 0.25, 0.125, 0, 0], atol=1e-12)


def test_without_one_depth_no_bed_has_a_closed_form():
    assert BED.jumps
    assert not replace(BED, depth=np.array([0.02, np.nan])).jumps
    assert not replace(BED, mass_per_fill=np.nan).jumps


def test_a_bed_that_crosses_loses_what_the_inelastic_body_does():
    # C_e = E/(π ω W²) with E = slug_energy · m₁ r ω² W², here over r f
    for stroke in (0.4, 1.0):
        log_damping, mass = BED.inelastic(points_of(np.array([stroke])))
        assert np.exp(log_damping) == pytest.approx(2 * MASS_PER_FILL * slug_energy(1 / stroke))
        assert mass == pytest.approx(MASS_PER_FILL * slug(np.array([1 / stroke]))[1])


def test_between_a_third_and_six_tenths_of_the_loss_a_bed_is_on_neither_side():
    share = np.array([0.29, 0.31, 0.59, 0.61])
    near = np.full(4, np.log(WHOLE) - 0.01)
    np.testing.assert_array_equal(_side(share, near), [0, 0.5, 0.5, 1])
    np.testing.assert_array_equal(_side(share, near + 0.02), [0, 1, 1, 1])
    np.testing.assert_array_equal(_side(share, near - 5), 0)


def test_the_side_of_a_case_follows_from_its_share_of_the_loss_of_the_inelastic_body():
    # at W/L = 0.45 and 10 g, of C_e = 2 m₁ E r f h
    share, stroke, gap = np.array([0.2, 0.45, 0.7]), 0.45, 0.02 * (1 - 0.94 * 0.5)
    f = np.sqrt(10 * STANDARD_GRAVITY / (stroke * gap)) / (2 * np.pi)
    whole = 2 * MASS_PER_FILL * slug_energy(1 / stroke) * 0.5 * f * (1 - 0.1**2)
    cases = pd.DataFrame(
        {"fill_fraction": 0.5, "frequency_hz": f, "acceleration_g": 10.0,
         "equivalent_damping_n_s_m3": share * whole, "equivalent_damping_error_n_s_m3": 0.1,
         "apparent_mass_kg_m2": 0.0, "apparent_mass_error_kg_m2": 0.1}
    )  # fmt: skip
    np.testing.assert_array_equal(training_data(cases, BED).side, [0, 0.5, 1])


def test_a_bed_rides_below_nine_tenths_of_the_stroke_that_meets_both_walls():
    # an inelastic body meets both walls in every cycle from W/L = 1/√(π² + 4) on
    stroke = np.array([0.89, 0.91]) / np.sqrt(np.pi**2 + 4)
    np.testing.assert_array_equal(_side(np.full(2, 5.0), np.log(stroke)), [0, 1])


def training(spread, mass_spread, outliers=None):
    """40 cases that ride and 20 that cross, with C_e and m_a that differ by so much."""
    rng = np.random.default_rng(5)
    points = rng.uniform([0.1, 1, -3], [0.9, 5, 3], (60, 3))
    side = np.arange(60) >= 40
    wave = np.sin(points.sum(axis=1)) / 0.7
    error = np.full(60, 0.05)
    noise = rng.normal(0, 0.05, 60)
    return TrainingData(
        BED, points, side.astype(float), 3 + spread * wave + noise, error, np.stack([error, error]),
        MASS_PER_FILL * (0.5 + mass_spread * wave), MASS_PER_FILL * error, outliers=outliers,
    )  # fmt: skip


def test_priors_are_those_of_the_cases_or_of_beds_like_them():
    alike = training(0.1, 0.01)
    assert alike.damping_sides().riding.unit == pytest.approx(1.0)
    assert alike.damping_sides().crossing.unit == pytest.approx(0.2)
    assert alike.mass_sides().riding.unit == pytest.approx(0.05 * MASS_PER_FILL)
    assert alike.mass_sides().crossing.unit == pytest.approx(0.2 * MASS_PER_FILL)
    apart = training(3.0, 0.5)
    rides = apart.log_damping[:40], apart.mass[:40]
    for sides, values in zip((apart.damping_sides(), apart.mass_sides()), rides, strict=True):
        assert (sides.riding.unit, sides.riding.centre) == (values.std(), values.mean())
    none = replace(apart, side=np.ones(60))
    assert none.damping_sides().riding.unit == 1.0
    expected = BED.inelastic(none.points)[0].mean()
    assert none.damping_sides().riding.centre == pytest.approx(expected)


def test_each_side_has_its_own_cases_and_errors():
    data = training(1.0, 0.1)
    data.side_error[1] = 0.07
    data.side[::7] = 0.5  # of neither
    for sides, values, number in ((data.damping_sides(), data.log_damping, 0),
                                  (data.mass_sides(), data.mass, 1)):  # fmt: skip
        rides, crosses = data.side == 0, data.side == 1
        expected = BED.inelastic(data.points)[number]
        np.testing.assert_array_equal(sides.riding.points, data.points[rides])
        np.testing.assert_array_equal(sides.riding.values, values[rides])
        np.testing.assert_array_equal(sides.crossing.points, data.points[crosses])
        np.testing.assert_array_equal(sides.crossing.values, (values - expected)[crosses])
        assert sides.crossing.centre == 0
        errors = data.side_error if number == 0 else np.stack([data.mass_error] * 2)
        np.testing.assert_array_equal(sides.riding.error, errors[0][rides])
        np.testing.assert_array_equal(sides.crossing.error, errors[1][crosses])


class Trended(SurfaceBed):
    """A bed with a trend of beds that ride."""

    def riding(self, points):
        return 0.7 * points[:, 1]


def test_the_trend_is_taken_from_beds_that_ride_alone():
    # those that cross are compared to the inelastic body
    plain = training(1.0, 0.1)
    trended = replace(plain, bed=Trended(1.0, MASS_PER_FILL, 0.02))
    before, after = plain.damping_sides(), trended.damping_sides()
    np.testing.assert_allclose(after.crossing.values, before.crossing.values, atol=1e-12)
    gamma = before.riding.points[:, 1]
    np.testing.assert_allclose(after.riding.values, before.riding.values - 0.7 * gamma)


def test_many_cases_are_thinned_by_ratios_of_frequency_and_level():
    cases = pd.DataFrame(
        {"fill_fraction": [0.2, 0.4, 0.6], "frequency_hz": [10.0, 100, 1000],
         "acceleration_g": [4.0, 8, 16]}
    )  # fmt: skip
    steps = np.array([-1, 0, 1]) * np.sqrt(1.5)  # of standard deviation 1
    points = logarithmic(cases[list(AXES)].to_numpy(float))
    axes = points / gaussian_process.spreads(points)
    np.testing.assert_allclose(axes - axes.mean(axis=0), np.outer(steps, np.ones(3)), atol=1e-12)


def test_outliers_weigh_less_until_the_process_settles():
    among = np.arange(60) % 2 == 0
    data = training(1.5, 0.2, among)
    wrong = np.arange(0, 40, 8)
    data.log_damping[wrong] += 4.0
    riding = data.damping_sides().riding
    fitted = {
        "axes": gaussian_process.spreads(data.points), "centre": riding.centre, "unit": riding.unit
    }  # fmt: skip
    points, values, error = data.points[:40], data.log_damping[:40], data.side_error[0][:40]
    once = gaussian_process.fit(points, values, error, **fitted)
    stated = replace(riding, error=error).with_weaker_outliers(among[:40])
    np.testing.assert_array_equal(riding.error, stated.error)
    assert (riding.error[wrong] > 0.5).all() and (riding.error[~among[:40]] == 0.05).all()
    again = gaussian_process.fit(points, values, riding.error, **fitted)
    change = np.abs(np.log(again.constants / riding.constants)).max()
    assert change < 0.02 and np.abs(np.log(once.constants / riding.constants)).max() > 0.2
    plain = replace(data, outliers=np.zeros(60, bool)).damping_sides().riding
    np.testing.assert_array_equal(plain.constants, once.constants)
