"""Normals, nodes and places on curved triangles."""

import numpy as np
import pytest

from pidpanel.geometry.surface_waves import SurfaceQuadrature
from pidpanel.panel.eigen import factors
from pidpanel.panel.modes import normal_modes, quadratic_form
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import ShellSupport
from pidpanel.shell.mesh import ShellMesh, lagrange, reference_nodes
from pidpanel.shell.selections import Ring, Sphere
from pidpanel.shell.strains import Layup
from pidpanel.sound.surface import surface_force, surface_wave_force
from tests.shells import SANDWICH, grid, on_paraboloid


def octahedron(order=1):
    """Cut into a sphere."""
    vertices = np.array(
        [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float
    )
    cells = [[a, (a + 1) % 4, top] for a in range(4) for top in (4, 5)]
    return vertices, np.array(cells), lambda p: p / np.linalg.norm(p, axis=-1, keepdims=True)


def test_polynomials_have_their_derivatives():
    place, step = np.array([[0.21, 0.33]]), 1e-6
    for order in (1, 2, 3, 4):
        _, slope, second = lagrange(order, place)
        for axis in (0, 1):
            move = step * np.eye(2)[axis]
            (after, bent, _), (before, flat, _) = (
                lagrange(order, place + sign * move) for sign in (1, -1)
            )
            assert np.allclose((after - before) / (2 * step), slope[..., axis], atol=1e-7)
            assert np.allclose((bent - flat) / (2 * step), second[..., axis], atol=1e-6)
        assert np.allclose(lagrange(order, reference_nodes(order))[0], np.eye(slope.shape[1]))


def test_normals_of_a_closed_surface_point_outwards_whatever_the_order_of_corners():
    vertices, cells, on_sphere = octahedron()
    mixed = np.array([np.roll(cell, k)[:: 1 if k % 2 else -1] for k, cell in enumerate(cells)])
    shell = assemble_shell(ShellMesh.from_triangles(vertices, mixed, on_sphere), Layup(SANDWICH))
    outward = np.sum(shell.quadrature_normal * shell.quadrature_position, axis=1)
    assert outward.min() > 0.9


def test_a_moebius_strip_is_refused():
    turn = np.arange(12) * 2 * np.pi / 12
    rim = [
        np.stack([(1 + s * np.cos(turn / 2)) * np.cos(turn),
                  (1 + s * np.cos(turn / 2)) * np.sin(turn), s * np.sin(turn / 2)], 1)
        for s in (-0.2, 0.2)
    ]  # fmt: skip
    a = np.arange(12)
    b = np.where(a < 11, a + 1, 12)  # the far end joins turned over
    c, d = np.where(a < 11, a + 13, 0), a + 12
    cells = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    with pytest.raises(ValueError, match="one side"):
        ShellMesh.from_triangles(np.concatenate(rim), cells)


def bowl():
    """A quarter of a paraboloid and its mirror images, of triangles whose corners go either way."""
    quarter = grid((3, 3), (0.0, 0.0), (0.5, 0.5), order=1)
    parts = [quarter.vertices[:, :2] * sign for sign in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    places, number = np.unique(np.round(np.concatenate(parts), 9), axis=0, return_inverse=True)
    count = len(quarter.vertices)
    cells = np.concatenate([number.ravel()[quarter.cells + k * count] for k in range(4)])
    return ShellMesh.from_triangles(places, cells, on_paraboloid(0.5))


IMAGES = np.array([[x, y, (x**2 + y**2) / 2] for x in (0.4, -0.4) for y in (0.3, -0.3)])
IMAGES = np.concatenate([IMAGES, IMAGES[:, [1, 0, 2]]])


@pytest.mark.parametrize("waves", ["diffuse", "along the axis"])
def test_a_symmetric_structure_in_a_symmetric_field_moves_symmetrically(waves):
    shell = assemble_shell(bowl(), Layup(SANDWICH), {"hub": ShellSupport(Ring(0.0, 0.2))})
    natural, modes = normal_modes(shell, 700.0)
    surface = SurfaceQuadrature(
        shell.quadrature_position, shell.quadrature_normal, shell.quadrature_weight,
        shell.at_quadrature @ modes,
    )  # fmt: skip
    mass = quadratic_form(shell.mass, modes)
    for frequency in (150.0, 420.0):
        k = 2 * np.pi * frequency / 343
        force = surface_wave_force([k], (0, 0, 1), surface)[0]
        load = np.outer(force, force.conj()) if waves != "diffuse" else surface_force(k, surface)
        receptance = 1 / (mass * ((natural**2 * (1 + 0.02j)) - frequency**2))
        rows = (shell.interpolate(IMAGES) @ modes) * receptance
        psd = np.einsum("pi,ij,pj->p", rows, load, rows.conj()).real
        assert np.ptp(psd) < 1e-6 * psd.max()


def test_a_symmetric_structure_under_a_symmetric_load_moves_symmetrically():
    shell = assemble_shell(bowl(), Layup(SANDWICH), {"hub": ShellSupport(Ring(0.0, 0.2))})
    pressed = shell.at_quadrature.T @ shell.quadrature_weight
    motion = factors(shell.stiffness).solve(pressed)
    w = shell.interpolate(IMAGES) @ motion
    assert w.max() > 0
    assert np.ptp(w) < 1e-6 * w.max()


def test_a_place_off_the_surface_is_refused_and_one_on_it_found():
    mesh = grid((2, 2), (-0.5, -0.5), (0.5, 0.5), on_paraboloid(0.5))
    x, y = np.random.default_rng(0).uniform(-0.5, 0.5, (2, 20))
    places = np.stack([x, y, (x**2 + y**2) / 2], 1)
    cells, share = mesh.locate(places)
    value, _, _ = lagrange(4, share)
    assert np.allclose(np.einsum("ck,ckx->cx", value, mesh.geometry[cells]), places, atol=1e-9)
    with pytest.raises(ValueError, match=r"0.1 m off the surface; allowed are 0.02 m"):
        mesh.locate(np.array([[0.0, 0.0, -0.1]]))


def test_a_selection_without_elements_is_named():
    mesh = grid((2, 2), (-0.5, -0.5), (0.5, 0.5))
    with pytest.raises(ValueError, match="patch 'P' = Sphere"):
        mesh.with_names({"P": Sphere((3.0, 0.0, 0.0), 0.1)}, {})
