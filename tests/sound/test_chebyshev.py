"""Polynomials through Chebyshev nodes."""

import numpy as np
import pytest
from numpy.polynomial import chebyshev

from pidpanel.sound.wavenumber_table import interpolation, unit_nodes


def test_nodes_are_the_zeros_of_the_polynomial():
    nodes = unit_nodes(7)
    assert np.all(np.diff(nodes) < 0)
    assert nodes == pytest.approx(chebyshev.chebpts1(7)[::-1], abs=1e-15)


def test_polynomials_are_exact_between_the_nodes_and_on_them():
    polynomial = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0, -1.0])
    x = np.concatenate([np.linspace(-1, 1, 9), unit_nodes(5)])
    found = interpolation(x, 5) @ polynomial(unit_nodes(5))
    assert found == pytest.approx(polynomial(x), abs=1e-14)
