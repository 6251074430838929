"""The cubic transformation has the kurtosis that it is made for."""

import numpy as np
import pytest

from pidpanel.severity.kurtosis import transformed


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
