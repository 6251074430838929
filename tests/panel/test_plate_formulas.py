"""Quadrature of the load and means over the cells at a vertex, on meshes counted by hand."""

import numpy as np
import pytest
from skfem import ElementQuad1, ElementTriP1, MeshQuad, MeshTri

from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.plate import at_quadrature, corner_basis, corner_mean
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.polygon import Rectangle


def test_the_load_has_nine_points_on_a_quadrilateral_and_seven_on_a_triangle(tmp_path):
    # red: LOAD_ORDER = 5 → 6
    section = ThinSection(3273.07, 4.0)
    square = mesh_quadrilaterals(tmp_path / "q.msh", (1.0, 1.0), (3, 2), {}, {})
    assert len(assemble_thin_plate(square, section).quadrature_weight) == 9 * 6
    triangles = mesh_triangles(tmp_path / "t.msh", Rectangle((0, 0), (1, 1)), 0.5, {}, {})
    found = assemble_thin_plate(triangles, section).quadrature_weight
    assert len(found) == 7 * len(triangles.cells)


@pytest.mark.parametrize(
    ("mesh", "element"), [(MeshTri(), ElementTriP1()), (MeshQuad(), ElementQuad1())]
)
def test_a_value_at_a_vertex_is_the_mean_of_those_of_its_cells(mesh, element):
    # fewer cells than corners; red: mesh.t.shape[0] → mesh.t.shape[1]; 1 / np.bincount → 1 *, 2 /
    basis = corner_basis(mesh, element)
    corners = np.asarray(basis.global_coordinates())
    np.testing.assert_allclose(corners, mesh.p[:, mesh.t.T])
    mean = corner_mean(mesh)
    values = mean @ at_quadrature(basis, [function[0] for function in basis.basis])
    np.testing.assert_allclose(values.toarray(), np.eye(mesh.p.shape[1]), atol=1e-15)
    of_cells = np.repeat(np.arange(1.0, 1 + mesh.t.shape[1]), mesh.t.shape[0])
    expected = [np.mean(1 + np.flatnonzero((mesh.t == v).any(axis=0))) for v in range(4)]
    np.testing.assert_allclose(mean @ of_cells, expected)
