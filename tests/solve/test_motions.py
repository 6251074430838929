"""Motions of patches: their covariance, the shapes that count, and what a negative C_e takes."""

import numpy as np
import pytest
from solving import panel_solver

from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.motions import SHAPES_TO, Motions, ShapeMotions


def white(frequency):
    return np.ones(frequency.size)


def direct(frequency, basis, patches, kept, shapes_to=SHAPES_TO, force=None):
    force = np.eye(basis.natural_frequency.size) if force is None else force
    excitation = ModalForce(white, force)
    return ShapeMotions(frequency, basis, patches, excitation, None, kept, shapes_to)


@pytest.mark.parametrize("form", ["reduced", "direct"])
@pytest.mark.parametrize("frequency", [[60.0, 70.0], [40.0, 44.0, 65.0, 120.0, 121.0]])
def test_the_covariance_over_a_patch_is_the_mean_square_of_its_acceleration(panel, frequency, form):
    f = np.array(frequency)
    points = panel.points[:, None]
    if form == "reduced":
        force = np.eye(len(panel.modes))
        motions = panel_solver(panel.basis, panel.patches, f, points, force).motions((0, 1))
    else:
        motions = direct(f, panel.basis, panel.patches, 1e9)
    damping, mass = np.full((2, f.size), 500.0), np.full((2, f.size), 2.0)
    covariance = motions.acceleration_covariance(damping, mass)
    square = np.einsum("pij,ji->p", motions.coordinates.weight, covariance) / motions.area
    psd = motions.acceleration_psd(damping, mass)
    np.testing.assert_allclose(square, np.trapezoid(psd, f, axis=1), rtol=1e-10)


@pytest.mark.parametrize("loaded", [[0], [0, 1]])
@pytest.mark.parametrize("kind", ["real", "complex"])
def test_patches_move_and_follow_their_dampers_alike_in_few_motions_and_in_all_shapes(
    panel, loaded, kind
):
    f, n = np.array([60.0, 150.0, 700.0]), len(panel.modes)
    root = np.random.default_rng(1).normal(size=(2, n, 3))
    root = root[0] + (1j * root[1] if kind == "complex" else 0)
    force, patches = root @ root.conj().T, panel.patches.subset(loaded)
    none = np.zeros((0, 1, n))
    (bare,) = bare_panels(
        f, panel.basis, [patches], none, np.ones(3), force, overlap_cutoff=1e-14
    )  # fmt: skip
    few = Motions(bare, patches.area)
    whole = direct(f, panel.basis, patches, 1e9, 1e3, force)
    dampers = np.array([[300.0, 500.0, 900.0], [800.0, 400.0, 100.0]])[loaded]
    dampers = dampers, dampers / 200
    np.testing.assert_allclose(
        few.acceleration_psd(*dampers), whole.acceleration_psd(*dampers), rtol=1e-8
    )
    slope = whole.acceleration_slope(*dampers)
    np.testing.assert_allclose(
        few.acceleration_slope(*dampers), slope, rtol=0, atol=1e-8 * np.abs(slope).max()
    )
