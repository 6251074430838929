"""Sound on the faces of curved surfaces: double integrals, flat panels and symmetries."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.sound.field import (
    FieldError,
    tabulate_diffuse,
    tabulate_plane_waves,
    uniform_modal_force,
)
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.surface import (
    surface_wave_force,
    tabulate_diffuse_surface,
    tabulate_surface_mass,
    tabulate_surface_wave,
)
from tests.sound.panels import sine_panel
from tests.sound.surfaces import TURN, paraboloid, plate, sphere


@pytest.fixture(scope="module")
def panel():
    return sine_panel([(1, 1), (2, 1), (3, 2)], (12, 8))


@pytest.mark.parametrize(("surface", "k_max"), [(paraboloid(), 40.0), (sphere(rings=16), 12.0)])
def test_a_diffuse_field_on_a_surface_is_its_double_integral(surface, k_max):
    table = tabulate_diffuse_surface(k_max, surface)
    apart = np.linalg.norm(surface.position[:, None] - surface.position, axis=2)
    load = surface.weight[:, None] * surface.shape
    for k in (0.0, 0.13 * k_max, 0.7 * k_max, k_max):
        expected = load.T @ np.sinc(k * apart / np.pi) @ load
        found = table.matrix([k])[0]
        np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_a_flat_surface_in_any_plane_has_the_forces_of_a_panel(panel):
    surface, k_max, wave = plate(panel), 30.0, (0.7, 2.1)
    direction = np.array([*np.sin(wave[0]) * np.array([np.cos(wave[1]), np.sin(wave[1])]), 0.0])
    direction[2] = np.cos(wave[0])
    for found, expected in (
        (tabulate_diffuse_surface(k_max, surface), tabulate_diffuse(k_max, panel)),
        (tabulate_diffuse(k_max, surface.projected), tabulate_diffuse(k_max, panel)),
        (
            tabulate_surface_wave(k_max, 2 * TURN @ direction, surface),
            tabulate_plane_waves(k_max, PlaneWaves.lone(*wave), panel),
        ),
    ):
        for k in (0.5, 17.0, k_max):
            one, other = (table.matrix([k])[0] for table in (found, expected))
            np.testing.assert_allclose(one, other, atol=1e-10 * np.abs(other).max())


def test_a_long_wave_presses_everywhere_and_a_short_one_sees_the_depth():
    surface = paraboloid(60)
    (force,) = surface_wave_force([1e-6], [0, 0, 1], surface)
    np.testing.assert_allclose(
        np.outer(force, force), uniform_modal_force(surface.projected), atol=1e-5
    )
    # ∫ exp(−ikz) dA of a paraboloid: over t = √(1 + (r/2F)²), z = F (t² − 1)
    radius, focus, k = 0.6, 0.48, 30.0
    t, weight = np.polynomial.legendre.leggauss(40)
    end = np.hypot(1, radius / (2 * focus))
    t, weight = 1 + (end - 1) / 2 * (1 + t), weight * (end - 1) / 2
    expected = 8 * np.pi * focus**2 * np.sum(weight * t**2 * np.exp(-1j * k * focus * (t**2 - 1)))
    (force,) = surface_wave_force([k], [0, 0, 1], surface)
    assert abs(force[0]) == pytest.approx(abs(expected), rel=1e-3)


def test_a_symmetric_reflector_has_equal_forces_about_both_axes():
    surface = paraboloid()
    force = tabulate_diffuse_surface(20.0, surface).matrix([3.0, 20.0])
    np.testing.assert_allclose(force[:, 1, 1], force[:, 2, 2], rtol=1e-9)
    scale = np.sqrt(force[:, 0, 0] * force[:, 1, 1])
    assert np.all(np.abs(force[:, 0, 1]) < 1e-9 * scale)
    turned = replace(surface, position=surface.position @ TURN.T)
    np.testing.assert_allclose(
        tabulate_diffuse_surface(20.0, turned).matrix([20.0])[0], force[1],
        atol=1e-9 * force[1].max(),
    )  # fmt: skip


def test_the_mass_of_air_on_a_flat_surface_is_that_on_a_panel(panel):
    # beyond the reach G of shapes of 9 rad/m is off by (9/30)²/2, 4 % of the least tenth of V
    found = tabulate_surface_mass(10.0, 30.0, plate(panel))
    expected = tabulate_added_mass(10.0, panel)
    for k in (0.1, 3.0, 7.0, 10.0):
        one, other = (table.matrix([k])[0] for table in (found, expected))
        np.testing.assert_allclose(one, other, atol=1e-2 * np.abs(other).max())
    with pytest.raises(FieldError, match="reach = 15 rad/m"):
        tabulate_surface_mass(10.0, 15.0, plate(panel))
