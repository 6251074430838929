"""The membrane energy of deflections, against closed forms and stress functions."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.polynomial import legendre

from pidpanel.geometry.polygon import Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import quadratic_form
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection, ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.stretching import (
    in_plane_basis,
    in_plane_stiffness,
    membrane_tensor,
    panel_stretching,
    rigid_coordinates,
)
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles

A, B = 1.5, 1.0
NU = 0.3
SECTION = ThinSection(100.0, 4.0, NU, 0.01)
RECTANGLE = Polygon(((0.0, 0.0), (A, 0.0), (A, B), (0.0, B)))


@cache
def grid(folder, elements=(12, 8)):
    return mesh_quadrilaterals(folder / "grid.msh", (A, B), elements, {}, {})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("stretching")


def test_a_surface_that_is_developed_does_not_stretch_if_its_edges_are_free(folder):
    # w = sin(πx/a) bends about one axis only
    mesh = grid(folder)
    basis = in_plane_basis(mesh)
    x, _ = basis.global_coordinates().reshape(2, -1)
    slopes = np.stack([np.pi / A * np.cos(np.pi * x / A), 0 * x])[:, :, None]
    moves = np.setdiff1d(np.arange(basis.N), rigid_coordinates(basis))
    edges = np.setdiff1d(np.arange(basis.N), basis.get_dofs().flatten())
    identity = sp.csr_array(sp.identity(basis.N, format="csr"))
    free, held = (
        membrane_tensor(basis, SECTION.extensional, slopes, sp.csr_array(identity[:, dofs])).item()
        for dofs in (moves, edges)
    )
    assert abs(free) < 1e-4 * held
    # a wide strip between walls: the mean strain (π/2a)² q² of every fibre, but for its two ends
    strip = SECTION.extensional[0, 0] * (np.pi / 2 / A) ** 4 * A * B
    assert held == pytest.approx(strip, rel=0.15) and held > (1 - NU**2) * strip


def airy_tensor(mode):
    """A_iiii of w = sin(mπx/a) sin(nπy/b), edges without forces, from its stress function.

    The complementary energy ½ ∫ N·A⁻¹N − N·e of N = (F_yy, F_xx, −F_xy), F = x²(a − x)²y²(b − y)²
    times polynomials, is least where N is that of the plate.
    """
    count, (s, ws) = 12, legendre.leggauss(40)
    x, y = (s + 1) / 2 * A, (s + 1) / 2 * B

    def functions(t, length):
        bubble = np.polynomial.Polynomial([0, 0, 1]) * np.polynomial.Polynomial([length, -1]) ** 2
        parts = [
            bubble
            * legendre.Legendre.basis(k, domain=[0, length]).convert(kind=np.polynomial.Polynomial)
            for k in range(count)
        ]
        return [np.array([part.deriv(order)(t) if order else part(t) for part in parts])
                for order in range(3)]  # fmt: skip

    fx, fy = functions(x, A), functions(y, B)
    tensor = lambda u, v: np.einsum("ip,jq->ijpq", u, v).reshape(count**2, -1)  # noqa: E731
    N = np.stack([tensor(fx[0], fy[2]), tensor(fx[2], fy[0]), -tensor(fx[1], fy[1])])
    weight = np.outer(ws * A / 2, ws * B / 2).ravel()
    m, n = mode
    X, Y = np.meshgrid(x, y, indexing="ij")
    wx = m * np.pi / A * np.cos(m * np.pi * X / A) * np.sin(n * np.pi * Y / B)
    wy = n * np.pi / B * np.sin(m * np.pi * X / A) * np.cos(n * np.pi * Y / B)
    e = np.stack([wx**2 / 2, wy**2 / 2, wx * wy]).reshape(3, -1)
    compliance = np.linalg.inv(SECTION.extensional)
    H = np.einsum("kip,kl,ljp,p->ij", N, compliance, N, weight, optimize=True)
    g = np.einsum("kip,kp,p->i", N, e, weight, optimize=True)
    scale = 1 / np.sqrt(np.diag(H))
    H, g = scale[:, None] * H * scale, scale * g
    return g @ np.linalg.lstsq(H, g, rcond=1e-12)[0]


def test_free_edges_have_the_energy_of_the_stress_function(folder):
    mesh = grid(folder, (24, 16))  # with vertices where the deflection is largest
    plate = assemble_thin_plate(mesh, SECTION)
    found = panel_stretching(mesh, plate, panel_shapes(plate, 100.0), 1.0).tensor
    for number, mode in enumerate(((1, 1), (2, 1))):
        assert found[(number,) * 4] == pytest.approx(airy_tensor(mode), rel=2e-3)


def test_a_tensor_has_the_symmetries_of_an_energy_and_held_edges_are_stiffer(folder):
    mesh = grid(folder)
    plate = assemble_thin_plate(mesh, SECTION)
    shapes = panel_shapes(plate, 100.0)
    free, held = (panel_stretching(mesh, plate, shapes, 1.0, s).tensor for s in (None, Supports()))
    for tensor in (free, held):
        for swapped in ((1, 0, 2, 3), (0, 1, 3, 2), (2, 3, 0, 1)):
            np.testing.assert_allclose(tensor, tensor.transpose(swapped), atol=1e-9 * tensor.max())
    n = len(free)
    energy = (held - free).reshape(n * n, n * n)
    assert np.linalg.eigvalsh(energy)[0] > -1e-9 * np.abs(energy).max()


def test_the_elements_of_thin_and_shear_plates_agree(folder):
    # a solid plate of 10 mm
    solid = SolidSection(70e9, NU, 2700.0, 0.01)
    thin = ThinSection(solid.bending[0, 0], 27.0, NU, 0.01)
    quads = grid(folder, (24, 16))
    triangles = mesh_triangles(folder / "triangles.msh", RECTANGLE, 0.1, {}, {})
    plates = [
        (quads, assemble_thin_plate(quads, thin)),
        (triangles, assemble_thin_plate(triangles, thin)),
        (triangles, assemble_shear_plate(triangles, solid)),
    ]
    for held in (None, Supports()):
        values = []
        for mesh, plate in plates:
            shapes = panel_shapes(plate, 250.0)
            # of the mode with one modal mass: no vertex of the triangles is in the middle
            unit = quadratic_form(plate.mass, shapes.modes[:, :1]).item() ** 2
            tensor = panel_stretching(mesh, plate, shapes, 1.0, held).tensor
            values.append(tensor[0, 0, 0, 0] / unit)
        assert values[1:] == pytest.approx(values[:1] * 2, rel=4e-3)


def test_modes_are_those_of_the_response(folder):
    mesh = grid(folder)
    plate = assemble_thin_plate(mesh, SECTION)
    shapes = panel_shapes(plate, 400.0)
    lowest = shapes.frequency[2] + 1e-6
    modes = panel_stretching(mesh, plate, shapes, lowest / 0.7).modes
    assert modes[0] == 3 and len(modes) == min(12, len(shapes.frequency) - 3)


FACE = Material.isotropic(60e9, NU, 1600.0)
CORE = Core(186e6, 90e6, 32.0, 20e-3)


def test_a_section_has_a_neutral_plane_where_its_faces_are_of_one_material():
    symmetric = SandwichSection((Ply(FACE, 0.3e-3),), (Ply(FACE, 0.3e-3),), CORE)
    np.testing.assert_allclose(in_plane_stiffness(symmetric)[0, 0], 60e9 * 0.6e-3 / (1 - NU**2))
    thick_top = replace(symmetric, top=(Ply(FACE, 0.6e-3),))
    np.testing.assert_allclose(in_plane_stiffness(thick_top), thick_top.abd[0])
    tape = Material(280e9, 6.5e9, 4.5e9, 0.3, 1600.0)
    assert in_plane_stiffness(replace(symmetric, top=(Ply(tape, 0.3e-3),))) is None
    solid = SolidSection(70e9, NU, 2700.0, 2e-3)
    np.testing.assert_allclose(solid.extensional[0, 0], 70e9 * 2e-3 / (1 - NU**2))
