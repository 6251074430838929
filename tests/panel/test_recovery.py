"""Truths of strain and stress: polynomials, Navier's static solution, and where z points."""

import numpy as np
import pytest
import scipy.sparse.linalg as spla

from pidpanel.geometry.polygon import Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from tests.panel_basis import panel_basis

A, B = 1.5, 1.0
OUTLINE = Polygon(((0.0, 0.0), (A, 0.0), (A, B), (0.0, B)))
CENTRE = {"centre": (0.75, 0.5)}
E, NU, T = 200e9, 0.3, 0.005  # Pa, 1, m
STEEL = ThinSection(E * T**3 / 12 / (1 - NU**2), 8000 * T, NU, T)


@pytest.fixture(scope="module", params=["quadrilaterals", "triangles"])
def plate(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("recovery") / "m.msh"
    if request.param == "quadrilaterals":
        mesh = mesh_quadrilaterals(path, (A, B), (12, 8), {}, CENTRE)
    else:
        mesh = mesh_triangles(path, OUTLINE, 0.15, {}, CENTRE)
    return mesh, assemble_thin_plate(mesh, STEEL)


def test_curvatures_of_modes_are_those_of_their_sines(plate):
    basis = panel_basis(*plate, frequency_limit=100.0)
    x, y = basis.vertex_position.T
    # (1, 1) and (2, 1), scaled to the computed shapes where they do not vanish
    vertex = np.argmin(np.hypot(x - 0.4, y - 0.4))
    for mode, m in enumerate((1, 2)):
        kx, ky = m * np.pi / A, np.pi / B
        sine = np.sin(kx * x) * np.sin(ky * y)
        twist = -2 * kx * ky * np.cos(kx * x) * np.cos(ky * y)
        scale = basis.shape_at_vertices[vertex, mode] / sine[vertex]
        expected = scale * np.array([kx**2 * sine, ky**2 * sine, twist]).T
        found = basis.curvature_at_vertices[:, :, mode]
        # second derivatives of a cubic err by (kh)^2 / 12 < 2.3 % of their largest
        np.testing.assert_allclose(found, expected, atol=0.023 * np.abs(expected).max())


def middle_of(mesh):
    return int(np.argmin(np.linalg.norm(mesh.vertices - mesh.points["centre"], axis=1)))


def test_static_stress_under_uniform_pressure_is_naviers(plate):
    mesh, plate = plate
    pressure = 1000.0
    u = spla.spsolve(
        plate.stiffness.tocsc(), plate.at_quadrature.T @ (pressure * plate.quadrature_weight)
    )
    curvature = np.array([k @ u for k in plate.curvature_at_vertices])[:, middle_of(mesh)]
    top, bottom = plate.section.layers
    # Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, Table 8, b/a = 1.5, nu = 0.3:
    # M = 0.0812 and 0.0498 q a^2 with a the shorter side; three printed digits
    expected = 6 / T**2 * pressure * B**2 * np.array([0.0498, 0.0812])
    # 1.5 %: the mean of second derivatives at a vertex of this coarse mesh
    np.testing.assert_allclose((top.stress @ curvature)[:2], expected, rtol=0.015)
    np.testing.assert_allclose(bottom.stress @ curvature, -(top.stress @ curvature))


def test_stress_is_hookes_law_of_strain_and_the_core_of_a_thin_plate_is_quiet(plate):
    mesh, plate = plate
    basis = panel_basis(mesh, plate, frequency_limit=60.0)
    assert basis.layer_names == ("top", "bottom")
    hooke = E / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
    for strain, stress, side in zip(basis.layer_strain, basis.layer_stress, (1, -1), strict=True):
        np.testing.assert_allclose(strain, side * T / 2 * np.eye(3))
        np.testing.assert_allclose(stress, hooke @ strain, rtol=1e-12)
    expected = basis.curvature_at_vertices[middle_of(mesh)]
    np.testing.assert_allclose(basis.curvature_at_points[0], expected, rtol=1e-9, atol=1e-8)
    assert not basis.core_stress.any() and not basis.shear_at_vertices.any()


def test_the_top_of_a_plate_bent_upwards_is_pulled():
    # w > 0 in the middle, w_xx < 0: z points as w does, so the top is on the outside and pulled
    kappa = np.array([1.0, 0.0, 0.0])
    top, bottom = STEEL.layers
    assert (top.strain @ kappa)[0] == T / 2
    assert (bottom.strain @ kappa)[0] == -T / 2
