"""The air on a panel, held to the closed forms of a rigid rectangle in a baffle."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
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


def test_one_side_of_a_rigid_piston_has_the_low_frequency_impedance_of_a_baffled_source():
    # iω · ρ₀ω²A²/(2πc₀) of a point source in a baffle (Junger and Feit, 4.2), −ω² ρ₀ V
    # red: + omega**2 * mass; 1j * omega → -1j * omega; omega**2 * mass → omega * mass
    frequency = np.array([5.0, 10.0])
    stiffness = air(1)(frequency)[:, 0, 0]
    omega = 2 * np.pi * frequency
    # sin(kR)/(kR) falls below 1 by (kR)²/6: 7e-4 at 10 Hz between opposite corners
    resistance = DENSITY * omega**2 * (A * B) ** 2 / (2 * np.pi * SPEED)
    np.testing.assert_allclose(stiffness.imag, omega * resistance, rtol=7e-4)
    mass = DENSITY * rectangle_volume(A, B)
    np.testing.assert_allclose(stiffness.real, -(omega**2) * mass, rtol=1e-12)


def test_two_wetted_sides_are_twice_one():
    # red: self.wetted_sides left out of `mass`
    frequency = np.array([5.0, 40.0, 100.0])
    one, two = air(1)(frequency), air(2)(frequency)
    np.testing.assert_allclose(two.real, 2 * one.real, rtol=1e-14)
    np.testing.assert_allclose(two.imag, 2 * one.imag, rtol=1e-14)
    assert np.all(one.real < 0) and np.all(one.imag > 0)


def test_air_without_mass_is_resistance_alone():
    # red: stiffness -= omega**2 * mass outside of the condition (AttributeError of None)
    frequency = np.array([5.0, 40.0, 100.0])
    whole = air(2)
    light = replace(whole, added_volume=None)(frequency)
    np.testing.assert_array_equal(light.real, 0.0)
    np.testing.assert_array_equal(light.imag, whole(frequency).imag)


@pytest.mark.parametrize("sides", [1, 2])
def test_added_mass_lowers_the_frequency_of_a_piston_on_a_spring(sides):
    # a light piston, m = 50 g on a spring of f₀ = 50 Hz: f₀ √(m/(m + n ρ₀V)), 7 % and 13 % lower
    # red: + omega**2 * mass in `Air`; self.wetted_sides left out of `mass`
    mass, rest = 0.05, 50.0
    volume = rectangle_volume(A, B)
    frequency = np.linspace(40.0, 55.0, 7501)
    basis = ModalBasis(np.array([rest]), np.array([mass]), 1e-3)
    (bare,) = bare_panels(
        frequency,
        basis,
        [Patches(np.zeros((0, 1, 1)), np.zeros(0))],
        np.ones((1, 1)),
        np.ones(frequency.size),
        np.array([[(A * B) ** 2]]),
        air(sides),
    )
    peak = frequency[np.argmax(bare.point_psd[:, 0, 0, 0].real)]
    # a damping force that grows with ω³ moves the peak of the deflection by −3ζ², ζ = 0.9 % of
    # two sides; lines are 2 mHz apart
    lowered = rest * np.sqrt(mass / (mass + sides * DENSITY * volume))
    assert peak == pytest.approx(lowered, rel=3e-4)
