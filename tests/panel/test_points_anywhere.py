"""Points and patches anywhere: shape functions know every point, an own mesh follows its patches."""

import numpy as np
import pytest

from pidpanel.geometry.polygon import Polygon, Rectangle
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.navier import thin_plate_frequency
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from tests.panel_basis import panel_basis

A, B = 1.2, 0.8
SECTION = ThinSection(3273.0, 4.0)
POINTS = {"x": (0.5, 0.37), "y": (1.1999, 0.5), "z": (0.013, 0.79)}


@pytest.mark.parametrize("kind", ["quadrilaterals", "file"])
def test_shapes_at_points_between_vertices_are_naviers(tmp_path, kind):
    if kind == "file":  # whose nodes do not follow the points
        outline = Polygon(((0, 0), (A, 0), (A, B), (0, B)))
        mesh = mesh_triangles(tmp_path / "m.msh", outline, 0.1, {}, {})
        mesh.points.update(POINTS)
    else:
        mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (12, 8), {}, POINTS)
    basis = panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 90.0)

    def mode(places):
        return np.prod(np.sin(np.pi * np.asarray(places) / [A, B]), axis=1)

    sine = mode(list(POINTS.values())) / mode(mesh.vertices).max()
    np.testing.assert_allclose(basis.shape_at_points[:, 0], sine, atol=2e-4)
    # means over the elements at a vertex, straight between them: (πh/b)²/12 and that at the mean
    curvature = (np.pi / A) ** 2 * sine
    np.testing.assert_allclose(
        basis.curvature_at_points[:, 0, 0], curvature, atol=0.04 * (np.pi / A) ** 2
    )


def test_a_grid_follows_patches_that_are_on_no_even_grid(tmp_path):
    patches = {"P": Rectangle((0.5, 0.33), (0.21, 0.17)), "Q": Rectangle((0.605, 0.33), (0.4, 0.1))}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (12, 8), patches, {}, {"S": (0.9, 0.7)})
    edges = np.ptp(mesh.vertices[mesh.cells], axis=1)
    assert (edges <= [A / 12 + 1e-9, B / 8 + 1e-9]).all()
    area = edges.prod(axis=1)
    for name, patch in patches.items():
        assert area[mesh.patch_cells[name]].sum() == pytest.approx(np.prod(patch.size), rel=1e-9)
    assert np.linalg.norm(mesh.vertices - [0.9, 0.7], axis=1).min() < 1e-12
    basis = panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 400.0)
    frequency = basis.natural_frequency[:5]
    orders = np.array([(1, 1), (2, 1), (1, 2), (3, 1), (2, 2)])
    expected = np.sort(thin_plate_frequency(*orders.T, (A, B), SECTION))
    np.testing.assert_allclose(frequency, expected, rtol=5e-4)  # (kh)⁴/1440 of the element
