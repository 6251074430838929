"""How far in wavenumber the added mass is integrated, by transforms of sines in closed form."""

import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from pidpanel.sound.added_mass import tabulate_added_mass
from pidpanel.sound.field import PanelQuadrature
from pidpanel.sound.wavenumber_table import FieldError, chebyshev_nodes, node_count

SIDES = (1.5, 1.0)


def sine_panel(elements, modes):
    """Products of sines at 3 × 3 Gauss points of each element."""
    node, weight = np.polynomial.legendre.leggauss(3)
    axes = []
    for side, count in zip(SIDES, elements, strict=True):
        at = ((np.arange(count)[:, None] + 0.5 + node / 2) * side / count).ravel()
        axes.append((at, np.tile(weight * side / count / 2, count)))
    x, y = (one.ravel() for one in np.meshgrid(axes[0][0], axes[1][0], indexing="ij"))
    shape = [np.sin(m * np.pi * x / SIDES[0]) * np.sin(n * np.pi * y / SIDES[1]) for m, n in modes]
    area = np.outer(axes[0][1], axes[1][1]).ravel()
    return PanelQuadrature(np.stack([x, y], axis=1), area, np.stack(shape, axis=1))


def content(kappa, mode):
    """Ā(κ) = (1/2π) ∮ |Φ|² dα, with |∫ sin(mπx/a) e^(iqx) dx|² of each side in closed form."""
    alpha = 2 * np.pi * (np.arange(4000) + 0.5) / 4000
    total = 1.0
    for side, m, q in zip(SIDES, mode, (kappa * np.cos(alpha), kappa * np.sin(alpha)), strict=True):
        p = m * np.pi / side
        total = total * 2 * p**2 * (1 - (-1) ** m * np.cos(q * side)) / (p**2 - q**2) ** 2
    return total.mean()


def static(mode, upto=3000.0):
    """V(0) = (1/2π) ∫ Ā dκ."""
    kappa = np.linspace(1e-3, upto, 60_001)
    values = [content(k, mode) for k in kappa[::20]]
    return np.trapezoid(values, kappa[::20]) / (2 * np.pi)


def test_waves_shorter_than_those_of_the_sound_are_followed_as_far_as_the_shapes_go():
    # a table to 1 rad/m of a shape of 19 rad/m: 1 % may be missing, by the bound of the tail
    # red: np.max → np.min in `tabulate_added_mass`; reach *= 1.5 → /= 1.5
    modes = [(1, 1), (9, 1)]
    table = tabulate_added_mass(1.0, sine_panel((30, 20), modes))
    expected = [static(mode) for mode in modes]
    np.testing.assert_allclose(np.diag(table.at([0.0])[0]), expected, rtol=0.01)


def test_the_share_that_is_left_is_a_quarter_of_kappa_a_over_2_pi_of_the_static_value():
    # the mesh resolves waves up to 3 over the mean distance of its points, 31.2 rad/m: after
    # twice the sound's 16/3, 16 and 24 rad/m, none is left to try
    # red: reach / 4 → reach / 5; content[0] → content[1]; FINEST = 3.3
    mode, elements = (9, 1), (9, 2)
    panel = sine_panel(elements, [mode])
    with pytest.raises(FieldError, match="leave") as refused:
        tabulate_added_mass(16 / 3, panel)
    share, reach = map(
        float, re.findall(r"([\d.]+)% .* beyond ([\d.]+) rad/m", str(refused.value))[0]
    )
    assert reach == 24
    alpha = np.pi * (np.arange(200) + 0.5) / 200
    along = panel.position @ np.stack([np.cos(alpha), np.sin(alpha)])

    def of_points(kappa):
        """Ā(κ) of the points as they are: three to a half wave leave their mark on it."""
        load = panel.weight * panel.shape[:, 0]
        return np.mean(np.abs(load @ np.exp(1j * kappa * along)) ** 2)

    last = chebyshev_nodes(reach, node_count(reach, panel.diameter))[0]
    inside = np.linspace(1e-3, reach, 1001)
    up_to_reach = np.trapezoid([of_points(k) for k in inside], inside) / (2 * np.pi)
    expected = reach / 4 * of_points(last) / (2 * np.pi) / up_to_reach
    # it is told to a tenth of a percent
    assert share / 100 == pytest.approx(expected, abs=6e-4)


def test_the_integral_first_goes_to_twice_the_wavenumber_of_the_sound():
    # a step further, 33 rad/m, is finer than the mesh; red: 2 * k_max → 3 * k_max
    with pytest.raises(FieldError, match="beyond 22 rad/m"):
        tabulate_added_mass(11.0, sine_panel((9, 2), [(9, 1)]))


def test_one_percent_may_lie_beyond_and_no_more():
    # of points as they are, by a spline of Ā; from 26 rad/m the next step is finer than the mesh
    # red: TAIL = 0.011 or 0.009
    panel = sine_panel((9, 3), [(8, 1)])
    alpha = np.pi * (np.arange(200) + 0.5) / 200
    along = panel.position @ np.stack([np.cos(alpha), np.sin(alpha)])
    load = panel.weight * panel.shape[:, 0]
    kappa = np.linspace(0.0, 28.0, 281)
    of_points = CubicSpline(
        kappa, [np.mean(np.abs(load @ np.exp(1j * k * along)) ** 2) for k in kappa]
    )
    whole = of_points.antiderivative()

    def beyond(reach):
        last = chebyshev_nodes(reach, node_count(reach, panel.diameter))[0]
        return reach / 4 * of_points(last) / whole(reach)

    for share, enough in ((0.0095, True), (0.0105, False)):
        reach = brentq(lambda one, share=share: beyond(one) - share, 25.8, 27.2, xtol=1e-4)
        if enough:
            tabulate_added_mass(reach / 2, panel)
        else:
            with pytest.raises(FieldError, match=f"beyond {reach:.0f} rad/m"):
                tabulate_added_mass(reach / 2, panel)
