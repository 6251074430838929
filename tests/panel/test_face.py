"""The face as the sound needs it: few points, the same forces."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.panel.basis import face_wavenumber, with_condensed_face
from pidpanel.sound.field import diffuse_modal_force


def test_a_condensed_face_takes_the_sound_as_the_mesh_does(paper_basis):
    # 5400 points of the mesh against 2100; of the largest force, as accurate as a table is held
    sound = 2 * np.pi * 1500 / 343
    few = with_condensed_face(paper_basis, face_wavenumber(paper_basis, sound))
    assert few.quadrature_weight.size < paper_basis.quadrature_weight.size / 2
    forces = [
        diffuse_modal_force(
            sound,
            PanelQuadrature(
                basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
            ),
        )
        for basis in (paper_basis, few)
    ]
    np.testing.assert_allclose(forces[1], forces[0], atol=1e-9 * forces[0].max())


def test_the_overlap_of_the_face_is_the_mass_of_a_uniform_panel_over_its_mass_per_area(paper_basis):
    # ∫ φ_i φ_j dA = δ_ij m_i/m″: modes and residual vectors diagonalise M = m″ ∫ φφ; order 5 of
    # the quadrature against the exact mass matrix, 0.6 % for the shortest residual vector
    overlap = paper_basis.face_overlap
    modal_mass = paper_basis.modal_mass
    scale = np.sqrt(np.outer(modal_mass, modal_mass)) / 4.0
    np.testing.assert_allclose(overlap / scale, np.eye(len(overlap)), atol=0.01)


def test_the_modes_alone_count_in_the_waves_of_a_face():
    # four modes on π m² reach to κ = 4 rad/m
    basis = SimpleNamespace(
        is_residual=np.arange(11) >= 4, quadrature_weight=np.full(10, np.pi / 10)
    )
    assert face_wavenumber(basis, 1.0) == pytest.approx(8.0)
