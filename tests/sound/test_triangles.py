"""Free edges of curved surfaces: reciprocity, symmetries, sense, and meshes."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.geometry import coarsening
from pidpanel.geometry.coarsening import edge_lengths, remeshed, rims
from pidpanel.sound.free_edges import (
    FreeSurface,
    checked,
    mesh_error,
    tabulate_diffuse_room,
    tabulate_free_plane_waves,
)
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.triangles import SurfaceJumps, inverse_distance
from pidpanel.sound.wavenumber_table import FieldError
from tests.sound.panels import l_mesh
from tests.sound.surfaces import TURN, oriented, paraboloid, paraboloid_mesh, sphere_mesh

K_MAX = 4.0


@pytest.fixture(scope="module")
def surface():
    whole = paraboloid(30, 56)
    outside = np.hypot(*whole.position[:, :2].T) > 0.12
    return replace(
        whole,
        **{
            name: getattr(whole, name)[outside]
            for name in ("position", "normal", "weight", "shape")
        },
    )


@pytest.fixture(scope="module")
def panel():
    return FreeSurface.of_hats(SurfaceJumps.of_mesh(*paraboloid_mesh()), K_MAX)


def impedance(panel, surface, k):
    return panel.impedance(k, panel.jumps.couplings(surface))


def test_the_potential_of_a_triangle_is_that_of_its_parts():
    # at the middle of equal sides a: three times 2 d asinh √3, d = a/(2√3)
    equal = np.array([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]])
    found = inverse_distance(equal.mean(axis=0)[None], equal[None])
    assert found[0] == pytest.approx(np.sqrt(3) * np.arcsinh(np.sqrt(3)), rel=1e-12)
    corners, point = np.array([[0.0, 0, 1], [2, 0.3, 0], [0.4, 1, -0.5]]), np.array([0.7, 0.2, 0.9])
    node, weight = np.polynomial.legendre.leggauss(40)
    u, v = (axis.ravel() for axis in np.meshgrid((1 + node) / 2, (1 + node) / 2, indexing="ij"))
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]))
    place = (
        corners[0] + np.outer(u, corners[1] - corners[0]) + np.outer(u * v, corners[2] - corners[1])
    )
    expected = area * np.sum(
        np.outer(weight, weight).ravel() / 4 * u / np.linalg.norm(place - point, axis=1)
    )
    assert inverse_distance(point[None], corners[None])[0] == pytest.approx(expected, rel=1e-6)


def test_plane_waves_load_a_reflector_as_its_radiation_says(panel, surface):
    k, count = 3.0, 12
    cosine, weight = np.polynomial.legendre.leggauss(count)
    azimuth = np.pi / count * np.arange(2 * count)
    angles = np.repeat(np.arccos(cosine), 2 * count), np.tile(azimuth, count)
    forces = panel.wave_forces(k, *angles, panel.jumps.couplings(surface))
    load = np.repeat(weight / 2, 2 * count) / (2 * count) @ np.abs(forces) ** 2
    expected = 4 * np.pi / k * np.diagonal(impedance(panel, surface, k)).imag
    np.testing.assert_allclose(load, expected, rtol=2e-3)


def test_a_symmetric_reflector_moves_symmetrically(panel, surface):
    for k in (0.5, 4.0):
        Z = impedance(panel, surface, k)
        assert Z[1, 1] == pytest.approx(Z[2, 2], rel=1e-9)
        for i, j in ((0, 1), (0, 2), (1, 2), (0, 3)):
            assert abs(Z[i, j]) < 1e-9 * np.sqrt(abs(Z[i, i] * Z[j, j]))


def test_neither_the_sense_of_triangles_and_normals_nor_the_frame_matters(panel, surface):
    vertices, triangles = paraboloid_mesh()
    expected = impedance(panel, surface, K_MAX)
    for mesh in ((vertices, triangles[:, ::-1]), (vertices @ TURN.T + 1, triangles)):
        jumps = SurfaceJumps.of_mesh(*mesh)
        moved = jumps.vertices.mean(axis=0) - panel.jumps.vertices.mean(axis=0)
        turned = surface
        if np.linalg.norm(moved) > 0.1:
            turned = replace(
                surface, position=surface.position @ TURN.T + 1, normal=surface.normal @ TURN.T
            )
        np.testing.assert_allclose(
            impedance(FreeSurface.of_hats(jumps, K_MAX), turned, K_MAX), expected,
            atol=1e-9 * np.abs(expected).max(),
        )  # fmt: skip
    sense = np.sign(surface.position[:, :1])
    opposite = replace(surface, normal=sense * surface.normal, shape=sense * surface.shape)
    np.testing.assert_allclose(impedance(panel, opposite, K_MAX), expected, rtol=1e-12)


def test_triangles_of_both_senses_are_refused():
    vertices, triangles = paraboloid_mesh()
    triangles[7] = triangles[7, ::-1]
    with pytest.raises(ValueError, match="opposite sense or more than two"):
        SurfaceJumps.of_mesh(vertices, triangles)


def test_a_surface_that_closes_is_refused():
    with pytest.raises(FieldError, match="that closes: the air inside resonates"):
        SurfaceJumps.of_surface(*sphere_mesh(1), 4.0)


def test_tables_are_what_the_surface_does_between_their_nodes(panel, surface):
    force, volume = tabulate_diffuse_room(panel, surface)
    wave = tabulate_free_plane_waves(panel, surface, PlaneWaves.lone(0.6, 0.4))
    couplings = panel.jumps.couplings(surface)
    for k in (0.7, 3.3):
        Z = impedance(panel, surface, k)
        (b,) = panel.wave_forces(k, np.array([0.6]), np.array([0.4]), couplings) / 2
        for table, expected in (
            (force, np.pi / k * Z.imag), (volume, Z.real / 2), (wave, np.outer(b, b.conj())),
        ):  # fmt: skip
            found = table.matrix([k])[0]
            np.testing.assert_allclose(found, expected, atol=2e-3 * np.abs(expected).max())


def test_the_error_of_a_mesh_is_seen_on_a_coarser_one(surface):
    coarse, fine, finest = (
        FreeSurface.of_hats(SurfaceJumps.of_mesh(*paraboloid_mesh(n, 14 * n // 3)), K_MAX)
        for n in (4, 6, 9)
    )
    stated = mesh_error(fine, coarse, surface)
    for row in (2, 6):
        k = checked(K_MAX)[row]
        one, other = (np.diagonal(impedance(p, surface, k)).imag for p in (fine, finest))
        true = np.abs(one / other - 1)
        assert np.all(stated[row] > true / 2)
        assert np.all(stated[row] < 4 * true)


def area(vertices, triangles):
    corners = vertices[triangles]
    sides = corners[:, 1:] - corners[:, :1]
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2


def holes(vertices, triangles):
    """Vertices less edges plus triangles."""
    return len(vertices) - (len(triangles) + len(rims(triangles, len(vertices))[0])) // 2


@pytest.mark.parametrize("name", ["L", "reflector", "fold"])
def test_a_new_mesh_lies_on_the_surface_with_its_size_rims_and_folds(name):
    flat = oriented(*l_mesh())
    folded = flat[0].copy()
    folded[:, 2] = np.maximum(flat[0][:, 1] - 0.5, 0)
    mesh = {"L": flat, "fold": (folded, flat[1]), "reflector": paraboloid_mesh(8, 32)}[name]
    vertices, triangles = remeshed(*mesh, 0.08)
    # chords of the reflector; a fold that is cut off by a row of triangles would take 1 %
    slack = {"L": 1e-12, "fold": 5e-4, "reflector": 0.004}[name]
    assert area(vertices, triangles) == pytest.approx(area(*mesh), rel=slack)
    lengths = edge_lengths(vertices, triangles)
    assert 0.03 < lengths.min() and lengths.max() < 0.16
    assert holes(vertices, triangles) == holes(*mesh)


def test_regions_with_parts_that_are_cut_off_make_a_mesh(monkeypatch):
    for name, value in (("RIM_SIZE", 0.4), ("GROWTH", 0.3), ("ATTEMPTS", 1)):
        monkeypatch.setattr(coarsening, name, value)
    mesh = oriented(*l_mesh())
    assert holes(*remeshed(*mesh, 0.058)) == holes(*mesh)


def test_a_mesh_of_the_right_size_stays():
    vertices, triangles = paraboloid_mesh(12, 60)
    jumps = SurfaceJumps.of_surface(vertices, triangles, 15.0)
    np.testing.assert_array_equal(jumps.triangles, triangles)
    other = SurfaceJumps.of_surface(vertices, triangles, 15.0, 0.5)
    assert len(other.inner) < 0.6 * len(jumps.inner)
    assert SurfaceJumps.of_surface(vertices, triangles, 60.0, 0.3).wavenumber < 25.0
