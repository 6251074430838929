"""Added mass of the air, held to the plain double integral through autocorrelations of sines."""

import numpy as np
import pytest
from scipy.integrate import quad

from pidpanel.sound.radiation import _rest, tabulate_added_mass
from tests.sound.panels import SIDES, sine_panel

MODES = [(1, 1), (2, 1), (3, 2), (9, 1)]


def autocorrelation(apart, side, m):
    """∫ sin(mπx/a) sin(mπ(x + d)/a) dx over the part of the side where both are."""
    turn = m * np.pi / side
    return ((side - apart) * np.cos(turn * apart) + np.sin(turn * apart) / turn) / 2


def double_integral(mode, k):
    """(1/2π) ∬ φφ cos(kR)/R dA dA′ in polar coordinates of the distance, where 1/R drops out."""
    node, weight = np.polynomial.legendre.leggauss(120)
    corner = np.arctan2(SIDES[1], SIDES[0])
    total = 0.0
    for low, high in ((0.0, corner), (corner, np.pi / 2)):
        for angle, share in zip((low + high + (high - low) * node) / 2, weight, strict=True):
            c, s = np.cos(angle), np.sin(angle)
            longest = min(SIDES[0] / c, SIDES[1] / s)
            R = longest / 2 * (1 + node)
            both = autocorrelation(R * c, SIDES[0], mode[0]) * autocorrelation(
                R * s, SIDES[1], mode[1]
            )
            total += share * (high - low) / 2 * longest / 2 * (weight @ (both * np.cos(k * R)))
    return 4 * total / (2 * np.pi)


@pytest.fixture(scope="module")
def table():
    return tabulate_added_mass(20.0, sine_panel(MODES))


@pytest.mark.slow
@pytest.mark.parametrize("k", [0.0, 1.19, 8.0, 20.0])
def test_added_mass_is_the_double_integral_of_cos_kr_over_r(table, k):
    # the wavenumbers integrated over reach to 90 rad/m, 5 times that of (9,1); 1e-5 as found
    static = np.diag(table.matrix([0.0])[0])
    expected = [double_integral(mode, k) for mode in MODES]
    np.testing.assert_allclose(np.diag(table.matrix([k])[0]), expected, atol=5e-5 * static.min())


def test_one_side_of_air_lowers_the_first_frequency_by_six_percent(table):
    # 64.9 Hz, m = 1.5 kg, 1.2 kg/m³: f/√(1 + ρ₀V/m), one figure is given
    mass = 1.2 * table.matrix([2 * np.pi * 64.9 / 343.0])[0, 0, 0]
    assert 1 / np.sqrt(1 + mass / 1.5) == pytest.approx(0.94, abs=0.005)


def test_added_mass_is_symmetric_and_does_not_couple_even_with_odd(table):
    static = table.matrix([0.0])[0]
    np.testing.assert_allclose(static, static.T, atol=1e-16)
    assert abs(static[0, 1]) < 1e-12 * static[0, 0]
    assert np.linalg.eigvalsh(static)[0] > 0


def test_beyond_the_last_wavenumber_the_sum_falls_with_a_power():
    # Ā κ = κ^(1−p) from K on; Q(K) = K^(2−p)/(p − 2), and ∫ κ^(1−p)/√(κ² − k²) dκ is left out
    power, reach, k = np.array([3.5, 5.0]), 2.0, 0.7
    content = reach ** (2 - power) / (power - 2)
    found = _rest(k, reach, np.diag(content), content * 2 ** (power / 2 - 1))
    expected = [
        quad(lambda t, p=p: t ** (1 - p) / np.sqrt(t**2 - k**2), reach, np.inf)[0] for p in power
    ]
    np.testing.assert_allclose(np.diag(found), expected, rtol=3e-5)
