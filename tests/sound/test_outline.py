"""Free edges of outlines that are no rectangles: any mesh, and boundary elements in space."""

import numpy as np
import pytest
import skfem

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound import outline
from pidpanel.sound.free_edges import FreePanel, _check_signs
from pidpanel.sound.outline import OutlineJumps
from pidpanel.sound.wavenumber_table import FieldError
from tests.sound.hats import impedance_without, limit

SHAPES = [
    lambda x, y: np.ones_like(x * y),
    lambda x, y: np.sin(3 * x + y),
    lambda x, y: np.cos(5 * x - 4 * y),
]
PANELS = {
    "L": ((1.0, 1.0), ((0.5, 0.5), (1.0, 1.0))),
    "hole": ((1.5, 1.0), ((0.5, 0.25), (1.0, 0.75))),
    # arms a quarter of the box: polynomials of the box that are small on them become fine ones
    "slender": ((1.2, 1.2), ((0.3, 0.3), (1.2, 1.2))),
}


def cells_of(name, lines):
    """Rectangles of a panel between lines along x and y, without its box."""
    sides, (low, high) = PANELS[name]
    grid = skfem.MeshQuad.init_tensor(
        *(side * line for side, line in zip(sides, lines, strict=True))
    )
    middle = grid.p[:, grid.t].mean(axis=1).T
    kept = ~np.all((middle > low) & (middle < high), axis=1)
    return grid.p.T, grid.t[:, kept].T


def impedance(mesh, k, resolved):
    panel = FreePanel.of_jumps(OutlineJumps.of_mesh(*mesh, resolved), max(10.0, *k))
    vertices, cells = mesh
    basis = skfem.Basis(
        skfem.MeshQuad(vertices.T.copy(), cells.T.copy()).refined(2),
        skfem.ElementQuad1(),
        intorder=8,
    )
    position = np.asarray(basis.global_coordinates()).reshape(2, -1).T
    shape = np.stack([f(*position.T) for f in SHAPES], axis=1)
    face = condensed(PanelQuadrature(position, basis.dx.ravel(), shape), 60.0)
    couplings = panel.jumps.couplings(face)
    return np.array([np.diagonal(panel.impedance(one, couplings)) for one in k])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "k", "per_metre"),
    [
        ("L", (0.5, 6.0), 8),
        ("hole", (0.5, 6.0), 8),
        ("L", (15.0,), 16),
        ("slender", (8.0,), 20),
    ],
)
def test_an_outline_is_that_of_boundary_elements_in_space(name, k, per_metre):
    # the extrapolation leaves 0.1 % of shapes one and two, 0.4 % of the third, whose load is small
    # at long waves; 0.3 % of all at 15 rad/m, where the finest elements are off by 1.3 %
    sides, removed = PANELS[name]
    even = np.linspace(0, 1, 13)
    found = impedance(cells_of(name, (even, even)), k, max(12.0, *k))
    for one, row in zip(k, found, strict=True):
        counts = [int(per_metre * side) for side in sides]
        expected = limit(
            [
                impedance_without(removed, sides, [m * n for n in counts], one, SHAPES)
                for m in (1, 2, 4)
            ]
        )
        np.testing.assert_allclose(row.real, expected.real, rtol=0.005)
        np.testing.assert_allclose(row.imag, expected.imag, rtol=0.01)


def test_the_mesh_does_not_matter():
    # four cells a side, and graded from a half to 1/128
    even = np.linspace(0, 1, 5)
    near = np.array([0.5, 0.25, 1 / 8, 1 / 32, 1 / 128])
    graded = np.unique(np.concatenate([[0.5], 0.5 - near, 0.5 + near]))
    k = [0.5, 9.0]
    coarse, fine = (impedance(cells_of("L", (x, x)), k, 12.0) for x in (even, graded))
    np.testing.assert_allclose(coarse.real, fine.real, rtol=2e-3)
    np.testing.assert_allclose(coarse.imag, fine.imag, rtol=5e-3)


def test_points_that_do_not_resolve_the_functions_are_refused(monkeypatch):
    monkeypatch.setattr(outline, "LONGEST", np.inf)
    jumps = OutlineJumps.of_mesh(*cells_of("L", (np.linspace(0, 1, 9),) * 2), 40.0)
    with pytest.raises(FieldError, match="does not resolve the pressure at free edges"):
        jumps.means()


@pytest.mark.parametrize("mass, odd", [(-1e-3, -1.0), (1.0, 1e-3)])
def test_air_of_negative_mass_or_resistance_is_refused(mass, odd):
    _check_signs(np.eye(2), -np.array([np.eye(2)]))
    with pytest.raises(FieldError, match="negative mass or resistance"):
        _check_signs(np.diag([1.0, mass]), np.array([np.diag([-1.0, odd])]))


def test_a_quadrilateral_with_a_straight_corner_has_two_triangles():
    corners = np.array([[0.0, 0], [1, 0], [2, 0], [1, 1]])
    for turn in range(4):
        for sense in (1, -1):
            mesh = outline._triangles(corners, np.roll(np.arange(4), turn)[None, ::sense])
            sides = np.diff(mesh.p[:, mesh.t], axis=1)
            area = np.abs(sides[0, 0] * sides[1, 1] - sides[0, 1] * sides[1, 0]) / 2
            np.testing.assert_allclose(area, 0.5)
