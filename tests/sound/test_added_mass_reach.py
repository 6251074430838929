"""Added mass of shapes that reach far in wavenumber, held to integrals over the distance."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.wavenumber_table import FieldError
from tests.sound.panels import gauss_points

SQUARE = 2 / (3 * np.pi) * (1 - np.sqrt(2) + 3 * np.log(1 + np.sqrt(2)))
"""(1/2π) ∬∬ dA dA′/R over a square of 1 m, in closed form [m³]."""


def serving(panel, reach):
    """The panel condensed for waves up to a wavenumber."""
    return replace(condensed(panel, reach), overlap=panel.product_integral)


@pytest.fixture(scope="module")
def free():
    """A square of 1 m whose edges are free: it translates, rocks, bends."""
    position, weight = gauss_points((20, 20), sides=(1.0, 1.0))
    x, y = (position - 0.5).T
    return PanelQuadrature(position, weight, np.stack([np.ones_like(x), x, x**2 - 0.3 * y], 1))


@pytest.mark.parametrize(("reach", "error"), [(10.0, 1e-3), (20.0, 1e-4), (60.0, 1e-4)])
def test_a_rigid_piston_with_free_edges_carries_the_air_of_the_closed_form(free, reach, error):
    # of the piston's V 21 % lies beyond 10 rad/m, 10 % beyond 20; the fall of κ⁻³ is exact in the
    # limit, so that the error falls as fast as the reach grows; a promise of 1 % is met tenfold
    table = tabulate_added_mass(reach / 2, serving(free, reach))
    assert table.matrix([0.0])[0, 0, 0] == pytest.approx(SQUARE, rel=error)


def double_integral(k, panel_of):
    """(1/2π) ∬∬ φ φ′ cos(kR)/R for a square of 1 m by polar coordinates of the distance.

    Gauss points of the autocorrelation in distance and angle; `panel_of(d_x, d_y)` is that of the
    shapes, (n, n).
    """
    node, weight = np.polynomial.legendre.leggauss(16)
    total = 0.0
    for quarter in (0.0, np.pi / 2):
        for low in (0.0, np.pi / 4):
            for angle, share in zip(low + np.pi / 8 * (1 + node), weight, strict=True):
                c, s = np.cos(angle + quarter), np.sin(angle + quarter)
                longest = 1 / max(abs(c), abs(s))
                for R, part in zip(longest / 2 * (1 + node), weight, strict=True):
                    both = panel_of(R * c, R * s)
                    step = share * np.pi / 8 * part * longest / 2
                    total = total + step * np.cos(k * R) * (both + both.T)
    return total / (2 * np.pi)


def autocorrelation(d_x, d_y):
    """∫ φ(x) φ(x + d)ᵀ dA over the overlap of the square and itself moved by d."""
    node, weight = np.polynomial.legendre.leggauss(4)

    def overlap(d):
        low, high = max(0.0, -d), min(1.0, 1.0 - d)
        return (low + high) / 2 + (high - low) / 2 * node, (high - low) / 2 * weight

    (x, wx), (y, wy) = overlap(d_x), overlap(d_y)
    x, y = (one.ravel() for one in np.meshgrid(x, y, indexing="ij"))
    load = np.outer(wx, wy).ravel()

    def shapes(x, y):
        x, y = x - 0.5, y - 0.5
        return np.stack([np.ones_like(x), x, x**2 - 0.3 * y])

    return (load * shapes(x, y)) @ shapes(x + d_x, y + d_y).T


@pytest.mark.slow
@pytest.mark.parametrize("k", [0.0, 6.0, 10.0])
def test_the_air_couples_shapes_with_free_edges_as_in_the_double_integral(free, k):
    # the integrand is smooth, its quadrature converged to 1e-6; what is left is the fall of Ā
    # beyond 20 rad/m, where a tenth of V lies, 5e-4; k = 10 is the largest that the reach allows
    found = tabulate_added_mass(10.0, serving(free, 20.0)).matrix([k])[0]
    expected = double_integral(k, autocorrelation)
    scale = np.sqrt(np.outer(*2 * [np.diag(double_integral(0.0, autocorrelation))]))
    assert np.max(np.abs(found - expected) / scale) < 8e-4


def test_a_shape_wholly_beyond_the_reach_errs_by_no_more_than_its_share_over_the_reach():
    # sin 12πx sin πy on a square, 37.8 rad/m, known to 20 rad/m, and to 80; ∫ φ² dA = 1/4 m²
    position, weight = gauss_points((40, 20), sides=(1.0, 1.0))
    shape = np.sin(12 * np.pi * position[:, :1]) * np.sin(np.pi * position[:, 1:])
    panel = PanelQuadrature(position, weight, shape)
    near, far = (
        tabulate_added_mass(5.0, serving(panel, reach)).matrix([0.0])[0, 0, 0] for reach in (20, 80)
    )
    assert far > 0.25 / 80
    assert abs(near - far) < 0.25 / 2 / 20


def test_a_mesh_that_does_not_serve_waves_of_twice_the_sound_is_refused():
    # 243 points on 1.5 m²: 19 rad/m
    position, weight = gauss_points((9, 3))
    panel = PanelQuadrature(position, weight, np.ones((len(weight), 1)))
    tabulate_added_mass(9.0, panel)
    with pytest.raises(FieldError, match="serve waves to 19 rad/m; 22 are needed"):
        tabulate_added_mass(11.0, panel)
