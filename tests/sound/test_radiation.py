"""The air on a panel, held to the closed forms of a rigid rectangle in a baffle."""

from dataclasses import replace

import numpy as np

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.sound.field import tabulate_diffuse
from pidpanel.sound.radiation import Air
from pidpanel.sound.wavenumber_table import constant_table

A, B = 0.3, 0.2
DENSITY, SPEED = 1.2, 343.0


def rectangle_volume(a, b):
    """(1/2π) ∬ dA dA′/R over a rectangle [m³]: V of a rigid piston at k = 0.

    The double integral is that of the potential of a uniformly charged plate with itself
    (closed form by integrating 1/R four times).
    """
    d = np.hypot(a, b)
    double = 2 * a**2 * b * np.log((b + d) / a) + 2 * a * b**2 * np.log((a + d) / b)
    return (double + 2 / 3 * (a**3 + b**3 - d**3)) / (2 * np.pi)


def piston(elements=(12, 8)):
    """One shape, 1 all over the rectangle."""
    node, weight = np.polynomial.legendre.leggauss(3)
    axes = []
    for side, count in zip((A, B), elements, strict=True):
        at = ((np.arange(count)[:, None] + 0.5 + node / 2) * side / count).ravel()
        axes.append((at, np.tile(weight * side / count / 2, count)))
    x, y = (one.ravel() for one in np.meshgrid(axes[0][0], axes[1][0], indexing="ij"))
    area = np.outer(axes[0][1], axes[1][1]).ravel()
    return PanelQuadrature(np.stack([x, y], axis=1), area, np.ones((area.size, 1)))


def air(sides):
    """The air on a rigid rectangle; V is the closed form at k = 0."""
    k_max = 2 * np.pi * 100.0 / SPEED
    volume = constant_table(k_max, np.array([[rectangle_volume(A, B)]]))
    return Air(DENSITY, SPEED, sides, tabulate_diffuse(k_max, piston()), volume)


def test_air_without_mass_is_resistance_alone():
    frequency = np.array([5.0, 40.0, 100.0])
    whole = air(2)
    light = replace(whole, added_volume=None)(frequency)
    np.testing.assert_array_equal(light.real, 0.0)
    np.testing.assert_array_equal(light.imag, whole(frequency).imag)
