"""The level at which motion and damping agree."""

import math

import numpy as np
import pytest

from pidpanel.solve.dampers import PatchMotion
from pidpanel.solve.linearisation import (
    LinearisationError,
    NoFixedPoint,
    NotConverged,
    find_motions,
    sine_acceleration_g,
)
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches

G = 9.80665
LINES = np.array([100.0])


def uniform(value, within=True):
    """A damping law C_e = value(Γ), m_a = 0."""
    return lambda frequency, gamma: (
        np.full(frequency.shape, value(gamma)),
        np.zeros(frequency.shape),
        within,
    )


def rms_of_level(level):
    """The rms whose sine has Γ_out = level(C_e)."""
    return lambda damping, mass: level(damping[0]) * G / math.sqrt(2)


def test_gamma_is_the_amplitude_of_the_sine_with_the_same_rms():
    # red: math.sqrt(2) * → 1 * in `sine_acceleration_g`
    time = np.linspace(0, 1, 10_000, endpoint=False)
    sine = 3.0 * G * np.sin(2 * np.pi * time)
    assert sine_acceleration_g(np.std(sine)) == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize("exponent", [0.5, -0.5, -1.5])
def test_power_laws_meet_where_algebra_says(exponent):
    # Γ_out = 10/√C_e, C_e = Γ^p: Γ = 10^(1/(1 + p/2)); tolerance 1e-6 in ln h, slope 1 + p/2
    # red: root → root + 1e-4 in `_close_in`
    search = find_motions(
        LINES,
        uniform(lambda gamma: gamma**exponent),
        rms_of_level(lambda damping: 10 / math.sqrt(damping)),
        gamma_range=(1e-3, 1e5),
    )
    (point,) = search.fixed_points
    assert point.gamma == pytest.approx(10 ** (1 / (1 + exponent / 2)), rel=4e-6)
    assert abs(point.residual) < 1e-6
    assert point.stable and point.within_domain
    assert point.equivalent_damping[0] == pytest.approx(point.gamma**exponent)
    assert 31 < search.iterations < 45  # the scan and a few steps of Brent's method


def test_one_mode_with_a_dashpot_that_grows_with_level_moves_as_miles_says():
    # white noise on one mode with c = 2ζmω + C_e A, C_e = 40 Γ: closed form of the mean square of
    # a Lorentzian of acceleration, S ω²/(4 c m), cut to ±10 Hz by its arctangent. What is left is
    # the slope of ω⁴ over the band, 0.2 % of Γ; 0.4 % is allowed
    # red: math.sqrt(2) * → 2 * in `sine_acceleration_g`
    mass, area, slope, force_psd, omega = 2.0, 0.1, 40.0, 300.0, 2 * np.pi * 100.0
    basis = ModalBasis([100.0], [mass], 0.01)
    frequency = frequency_grid(90.0, 110.0, 0.01, lines_per_bandwidth=40)
    (bare,) = bare_panels(
        frequency,
        basis,
        [Patches(np.array([[[area]]]), np.array([area]))],
        [[1.0]],
        np.full(frequency.size, force_psd),
        [[1.0]],
    )

    rms = PatchMotion.of(bare).acceleration_rms
    (point,) = find_motions(frequency, uniform(lambda gamma: slope * gamma), rms).fixed_points

    def closed_form(gamma):
        """a_rms in the band by the arctangent of a Lorentzian, exact to order ζ."""
        damping = 2 * 0.01 * mass * omega + slope * gamma * area
        half_width = damping / (2 * mass) / (2 * np.pi)
        inside = np.arctan(10 / half_width) / (np.pi / 2)
        return math.sqrt(force_psd * omega**2 / (4 * damping * mass) * inside)

    assert math.sqrt(2) * closed_form(point.gamma) / G == pytest.approx(point.gamma, rel=0.004)


def peaked(gamma):
    """Damping that rises steeply to Γ = 2.5 and falls like 1/Γ² beyond, as a shaken bed's may."""
    return 0.2 + 100 / ((2.5 / gamma) ** 4 + (gamma / 2.5) ** 2.5)


def test_damping_that_falls_on_both_sides_may_have_three_levels_the_middle_one_unstable():
    # Γ_out = 60/C_e: found by a fine scan of h, written out here
    # red: `_sign_changes` that returns its first only; stable=falls → stable=True
    search = find_motions(LINES, uniform(peaked), rms_of_level(lambda damping: 60 / damping))
    gamma = np.geomspace(0.01, 1000, 400_001)
    above = 60 / peaked(gamma) > gamma
    crossings = np.flatnonzero(above[1:] != above[:-1])
    expected = np.sqrt(gamma[crossings] * gamma[crossings + 1])
    assert expected.size == 3
    found = [point.gamma for point in search.fixed_points]
    np.testing.assert_allclose(found, expected, rtol=5e-5)
    assert [point.stable for point in search.fixed_points] == [True, False, True]
    assert search.governing.gamma == found[-1]


def test_a_level_outside_the_data_is_marked():
    # red: np.all → np.any in `_close_in`
    law = uniform(lambda gamma: gamma, within=np.array([True, False]))
    lines = np.array([100.0, 200.0])
    search = find_motions(lines, law, rms_of_level(lambda damping: 10 / damping))
    assert not search.governing.within_domain


@pytest.mark.parametrize(("level", "side"), [(1e5, "above"), (1e-5, "below")])
def test_a_level_beyond_the_range_is_no_level(level, side):
    # red: the last scan value returned in the place of the error
    with pytest.raises(NoFixedPoint, match=f"Γ_out is {side} Γ.*widen gamma_range"):
        find_motions(LINES, uniform(lambda gamma: 1.0), rms_of_level(lambda damping: level))


def test_a_jump_of_the_damping_is_not_taken_for_a_level():
    # red: abs(residual) > tolerance → False in `_close_in`
    law = uniform(lambda gamma: 1.0 if gamma < 5 else 100.0)
    with pytest.raises(NotConverged, match=r"near Γ = 5 .*does C_e or m_a jump"):
        find_motions(LINES, law, rms_of_level(lambda damping: 20 / damping))


@pytest.mark.parametrize("rms", [math.nan, math.inf, 0.0])
def test_a_motion_that_is_no_motion_is_refused(rms):
    # red: no check of rms in `surplus`
    with pytest.raises(LinearisationError, match="finite, positive motion"):
        find_motions(LINES, uniform(lambda gamma: 1.0), lambda damping, mass: rms)


@pytest.mark.parametrize(
    "changes",
    [{"gamma_range": (0.0, 1.0)}, {"gamma_range": (2.0, 1.0)}, {"scan_count": 1}, {"tolerance": 0}],
)
def test_a_search_without_extent_is_refused(changes):
    with pytest.raises(ValueError, match="gamma_range"):
        find_motions(LINES, uniform(lambda gamma: 1.0), rms_of_level(lambda d: 1.0), **changes)


@pytest.mark.parametrize(
    ("gamma", "found"), [(0.0105, True), (0.0095, False), (9500, True), (10500, False)]
)
def test_motions_are_searched_from_a_hundredth_to_ten_thousand_g(gamma, found):
    # red: (0.01, 1e4) → (0.011, 1e4), (0.01, 1.1e4)
    law, rms = uniform(lambda gamma: 1.0), rms_of_level(lambda damping: gamma)
    if found:
        assert find_motions(LINES, law, rms).governing.gamma == pytest.approx(gamma, rel=1e-6)
    else:
        with pytest.raises(NoFixedPoint):
            find_motions(LINES, law, rms)


def test_the_scan_has_steps_of_a_factor_of_1_58():
    # 10^(6/30), as the docstring says; red: scan_count = 31 → 32
    asked = []
    law = uniform(lambda gamma: asked.append(gamma) or 1.0)
    find_motions(LINES, law, rms_of_level(lambda damping: 5.0))
    np.testing.assert_allclose(asked[:31], 0.01 * 10 ** (np.arange(31) / 5), rtol=1e-12)


@pytest.mark.parametrize(("jump", "accepted"), [(0.95e-6, True), (1.05e-6, False)])
def test_a_jump_within_a_millionth_is_a_motion_and_a_larger_one_is_none(jump, accepted):
    # Γ_out/Γ falls from e^jump to e^-jump at Γ = 1.3; red: tolerance = 1e-6 → 1.1e-6
    law = uniform(lambda gamma: gamma)
    rms = rms_of_level(lambda gamma: gamma * math.exp(jump if gamma < 1.3 else -jump))
    if accepted:
        assert find_motions(LINES, law, rms).governing.gamma == pytest.approx(1.3, rel=1e-6)
    else:
        with pytest.raises(NotConverged):
            find_motions(LINES, law, rms)
