"""A panel on moving supports: its translation, its limit at rest, its effective masses."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from moving import APPARENT, MASS, POINT_MASS, solved

from pidpanel.solve.base_motion import inertia_of


def test_the_translation_moves_all_points_alike_and_bends_nothing(panel):
    basis = panel.basis
    for name in ("shape_at_points", "shape_at_quadrature", "shape_at_vertices"):
        np.testing.assert_array_equal(getattr(basis, name)[..., -1], 1)
    for name in ("curvature", "shear"):
        for place in ("points", "vertices"):
            np.testing.assert_array_equal(getattr(basis, f"{name}_at_{place}")[..., -1], 0)
    # two motions of each of two points; the momentum of the interface and the integral of one patch
    assert panel.observed.shape == (3, 2, panel.modal.natural_frequency.size)
    # what it has in common with the other shapes are their integrals over patch and face
    weight, shape = basis.quadrature_weight, basis.shape_at_quadrature
    np.testing.assert_allclose(basis.face_overlap[-1], weight @ shape, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(basis.patch_overlap[0, -1], panel.observed[-1, 1], rtol=1e-9)


def test_the_integrals_over_all_patches_come_before_that_of_the_face(panel):
    # the patch and the rest of the face
    basis, whole = panel.supported.basis, panel.supported.basis.cell_in_patch[0]
    two = replace(basis, cell_in_patch=np.array([whole, ~whole]))
    inertia = inertia_of(two, panel.plate, panel.supported.vectors, MASS)
    of_panel = panel.inertia
    np.testing.assert_allclose(inertia.patch_integral[0], of_panel.patch_integral[0])
    # those of antisymmetric shapes are 0 to rounding
    close = partial(np.testing.assert_allclose, atol=1e-12)
    close(inertia.patch_integral.sum(axis=0), of_panel.face_integral)
    close(inertia.face_integral, of_panel.face_integral)


def test_at_rest_all_moves_with_the_supports(loaded_panel):
    frequency = np.array([0.02, 0.05])
    motion, force, _ = solved(loaded_panel, frequency, 0.0, APPARENT)
    ratio = -((2 * np.pi * frequency[:, None]) ** 2) * motion[:, :-1, 0]
    np.testing.assert_allclose(np.abs(ratio), 1, rtol=3e-6)
    np.testing.assert_allclose(motion[:, :-1, 1] / motion[:, :-1, 0], 0, atol=3e-4)
    np.testing.assert_allclose(force, MASS + POINT_MASS + APPARENT * 0.08, rtol=3e-6)


def test_effective_masses_are_those_of_sines_and_point_masses_add_to_them(panel, loaded_panel):
    basis, inertia = panel.supported.basis, panel.inertia
    modes = inertia.effective_mass(basis.modal_mass)[~basis.is_residual]
    exact = 64 / np.pi**4 * MASS / np.array([1.0, 9.0])  # of (1, 1) and (3, 1)
    np.testing.assert_allclose(np.sort(modes)[::-1][:2], exact, rtol=2e-4)
    # all modes of all elements: what is missing is the mass of the elements at the supports
    plate, whole = loaded_panel.plate, loaded_panel.inertia.mass
    assert 0.97 * whole < plate.inertia @ spla.spsolve(plate.mass.tocsc(), plate.inertia) < whole
    assert whole == pytest.approx(MASS + POINT_MASS)
