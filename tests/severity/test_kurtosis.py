"""The cubic transformation has the kurtosis that it is made for, and its damage in closed form."""

import math

import numpy as np
import pytest

from pidpanel.severity.kurtosis import damage_factor, transformed


@pytest.mark.parametrize("excess", [0.1, 0.5, 1.0, 2.0])
def test_the_transformed_motion_has_unit_rms_and_about_the_kurtosis(excess):
    node, weight = np.polynomial.hermite_e.hermegauss(60)
    weight /= weight.sum()
    x = transformed(node, np.array(excess))
    assert weight @ x**2 == pytest.approx(1, abs=1e-12)
    # Winterstein's c is to second order in the excess: a tenth of it at 2
    assert weight @ x**4 - 3 == pytest.approx(excess, rel=0.12)


def test_without_excess_nothing_changes_and_below_none_neither():
    u = np.array([0.5, 3.0])
    np.testing.assert_allclose(transformed(u, np.zeros(2)), u)
    np.testing.assert_allclose(transformed(u, np.full(2, -0.4)), u)
    assert damage_factor(8.0, np.zeros(1), np.array([4.0])) == pytest.approx(1)


def test_damage_of_the_fourth_power_is_that_of_its_polynomial():
    # E[(h (R + c (R³ − 3R)))⁴] / E[R⁴] with E[Rⁿ] = 2^(n/2) Γ(1 + n/2); all amplitudes count
    excess = 0.6
    c = (math.sqrt(1 + 1.5 * excess) - 1) / 18
    h = 1 / math.sqrt(1 + 6 * c**2)
    moment = {n: 2 ** (n / 2) * math.gamma(1 + n / 2) for n in range(4, 13, 2)}
    low, high = 1 - 3 * c, c
    terms = {4: low**4, 6: 4 * low**3 * high, 8: 6 * low**2 * high**2,
             10: 4 * low * high**3, 12: high**4}  # fmt: skip
    expected = h**4 * sum(factor * moment[n] for n, factor in terms.items()) / moment[4]
    found = damage_factor(4.0, np.array([excess]), np.array([12.0]))[0]
    assert found == pytest.approx(expected, rel=1e-5)
    assert damage_factor(4.0, np.array([excess]), np.array([3.0]))[0] < expected
