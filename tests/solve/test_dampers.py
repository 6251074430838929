"""Slopes, stability and factors of the overlap: what scales with what."""

import numpy as np

from pidpanel.solve import dampers
from pidpanel.solve.modal import bare_panels, panel_in_shapes
from pidpanel.solve.model import ModalBasis, Patches

FREQUENCY = np.linspace(50.0, 200.0, 7)
BASIS = ModalBasis([65.0, 180.0], [1.5, 2.5], [0.02, 0.03])
PATCH = Patches(0.04 * np.array([[[1.0, 0.6], [0.6, 0.5]]]), np.array([0.04]))
POINTS = np.array([[1.0, -0.4], [0.3, 1.0]])
FORCE = np.array([[0.3, 0.1], [0.1, 0.2]])
SOUND = np.linspace(2.0, 9.0, 7)


def test_the_slope_of_the_papers_form_is_that_of_its_response_under_any_sound():
    # central differences over 1e-4 of the damper, their error 1e-8 of the slope
    panel = panel_in_shapes(FREQUENCY, BASIS, PATCH.diagonal, POINTS[:, None], SOUND, FORCE)
    damping, mass, step = np.full(7, 900.0), np.full(7, 2.0), 1e-4
    slope = dampers.attach_dampers(panel, damping[None], mass[None], with_slope=True).slope[0]
    up, down = (
        dampers.attach_dampers(panel, sign * damping[None], mass[None]).acceleration_psd
        for sign in (1 + step, 1 - step)
    )
    change = 2j * np.pi * FREQUENCY[:, None] * damping[:, None]
    got = -2 * (change * slope).real
    np.testing.assert_allclose(got, (up - down) / (2 * step), rtol=1e-6)


def test_a_patch_in_other_units_keeps_as_many_columns():
    # D in mm² in place of m²: the same shares of the largest eigenvalue
    overlap = np.diag([1.0, 1e-3, 1e-7, 1e-9])[None]
    for unit in (1.0, 1e-6, 1e6):
        (factor,) = Patches(unit * overlap, np.ones(1)).factors(1e-8)
        assert factor.shape == (4, 3)
        np.testing.assert_allclose(factor @ factor.T, unit * overlap[0], atol=1e-8 * unit)


def test_the_slope_is_that_of_the_first_motion_where_a_point_has_several():
    damping, mass = np.full(7, 900.0), np.full(7, 2.0)
    several = np.stack([POINTS, 5 * POINTS[::-1], POINTS + 3], axis=1)
    found = [
        dampers.attach_dampers(
            bare_panels(FREQUENCY, BASIS, [PATCH], points, SOUND, FORCE)[0],
            damping[None],
            mass[None],
            with_slope=True,
        ).slope[0]
        for points in (POINTS, several)
    ]
    np.testing.assert_allclose(found[1], found[0], rtol=1e-10)
    assert found[0].shape == (7, 2)
