"""Orientation and quadrature of surfaces: closed forms, folded sheets, one-sided strips."""

import numpy as np
import pytest

from pidpanel.geometry.orientation import oriented
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.modal_files.model import PARTS
from pidpanel.modal_files.quadrature import node_normals, surface_quadrature

RANDOM = np.random.default_rng(3)


def strip(twist, count=24, width=0.2):
    """A band whose cross direction turns by half turns on its way round; cells in any order."""
    angle = 2 * np.pi * np.arange(count) / count
    tilt = twist * angle / 2
    centre = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    across = np.cos(tilt)[:, None] * [0, 0, 1] + np.sin(tilt)[:, None] * centre
    position = np.concatenate([centre - width * across, centre + width * across])
    k = np.arange(count)
    cells = np.stack([k, (k + 1) % count, count + (k + 1) % count, count + k], axis=1)
    if twist % 2:  # the last cell joins top and bottom
        cells[-1, [1, 2]] = count, 0
    return position, cells


def shuffled(cells):
    """Half of the cells turned round, all in another order and from another corner."""
    turned = np.where(RANDOM.random(len(cells))[:, None] < 0.5, cells, cells[:, ::-1])
    return np.roll(turned, 1, axis=1)[RANDOM.permutation(len(cells))]


def sphere(rings=16, sectors=32):
    """Quadrilaterals, with triangles at the poles."""
    polar, angle = np.meshgrid(
        np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(sectors) / sectors, indexing="ij"
    )
    ball = np.stack(
        [np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=-1
    )
    position = np.concatenate([ball.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    k = np.arange((rings - 1) * sectors).reshape(rings - 1, sectors)
    right = np.roll(k, -1, axis=1)
    quads = np.stack([k[:-1], k[1:], right[1:], right[:-1]], axis=-1).reshape(-1, 4)
    north, south = k.size, k.size + 1
    caps = [np.stack([k[row], right[row], np.full(sectors, pole), np.full(sectors, pole)], axis=1)
            for row, pole in ((0, north), (-1, south))]  # fmt: skip
    return position, np.concatenate([quads, *caps])


@pytest.mark.parametrize("outward", [None, [0, 0, 1.0]])
def test_a_closed_surface_faces_its_outside_whatever_the_direction(outward):
    position, cells = sphere()
    turned = shuffled(cells[:-32])  # triangles repeat their third corner
    cells = oriented(position, np.concatenate([turned, cells[-32:]]), outward)
    quadrature = surface_quadrature(position, cells)
    assert ((quadrature.position * quadrature.normal).sum(axis=1) > 0.97).all()


def test_a_band_has_two_sides_and_a_moebius_strip_one():
    position, cells = strip(0)
    cells = oriented(position, shuffled(cells))
    quadrature = surface_quadrature(position, cells)
    radial = (quadrature.position * quadrature.normal).sum(axis=1)
    assert (radial > 0.9).all()
    with pytest.raises(ValueError, match="faces outward as much as inward; state another"):
        oriented(position, cells, [0, 0, 1.0])
    with pytest.raises(
        ValueError, match=r"surface with \d+ cells at .* m: the surface has one side only"
    ):
        oriented(*(lambda position, cells: (position, shuffled(cells)))(*strip(1)))


def test_kinks_are_crossed_and_joints_of_three_are_not():
    """An L of two plates is one part; a T is three, each of which faces the direction."""
    x, y = np.meshgrid(np.arange(4.0), np.arange(3.0))
    sheet = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    place = np.arange(12).reshape(3, 4)
    quads = np.stack(
        [place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    folded = sheet.copy()
    folded[sheet[:, 0] > 1, 0], folded[sheet[:, 0] > 1, 2] = 1.0, sheet[sheet[:, 0] > 1, 0] - 1
    cells = oriented(folded, shuffled(quads), [0.2, 0, 1.0])
    normal = surface_quadrature(folded, cells).normal
    side = np.where(np.abs(normal[:, 2]) > 0.5, normal[:, 2], -normal[:, 0])
    assert (side == side[0]).all()  # the inside of the corner, or the outside
    upright = sheet[:, [2, 0, 1]]
    cells = oriented(upright, shuffled(quads), [0, 0, 1.0], or_along_axis=True)
    assert (surface_quadrature(upright, cells).normal == [1, 0, 0]).all()
    web = np.array([[1.0, 0, 1], [1, 1, 1.5], [1, 2, 1]])
    joined = np.concatenate([quads, [[1, 5, 13, 12], [5, 9, 14, 13]]])
    cells = oriented(np.concatenate([sheet, web]), shuffled(joined), [0.3, 0, 1.0])
    quadrature = surface_quadrature(np.concatenate([sheet, web]), cells)
    assert (quadrature.normal @ [0.3, 0, 1.0] > 0).all()


def test_quadrature_integrates_quadratics_on_triangles_and_quadrilaterals():
    position = np.array([[0, 0, 0], [3, 0, 0], [2, 2, 0], [0, 1, 0], [4, 1, 0.0]])
    cells = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    quadrature = surface_quadrature(position, cells)
    assert (quadrature.normal == [0, 0, 1]).all()
    by_cell = np.bincount(quadrature.cell, quadrature.weight)
    np.testing.assert_allclose(by_cell, [4.0, 1.5])  # shoelace formula
    np.testing.assert_allclose(cell_areas(position, cells), [4.0, 1.5])
    # ∫ x y over a triangle: A/12 (Σ x_i Σ y_i + Σ x_i y_i)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]])
    x, y, _ = position[triangles].transpose(2, 0, 1)
    area = np.array([3.0, 1.0, 1.5])
    exact = area / 12 * (x.sum(1) * y.sum(1) + (x * y).sum(1))
    values = quadrature.position[:, 0] * quadrature.position[:, 1] * quadrature.weight
    np.testing.assert_allclose(np.bincount(quadrature.cell, values), [exact[:2].sum(), exact[2]])


def test_area_and_flux_of_a_sphere_converge():
    errors = []
    for rings in (16, 32):
        quadrature = surface_quadrature(*sphere(rings, 2 * rings))
        errors.append(abs(quadrature.weight.sum() / (4 * np.pi) - 1))
    assert errors[1] < 0.26 * errors[0] < 0.004


def test_normal_displacements_and_overlap_of_a_patch(plate):
    """Along the normal the modes are orthogonal, with ∫ w² dA = ab/4; a tangential motion has none."""
    place = {number: k for k, number in enumerate(plate.node.tolist())}
    cells = np.vectorize(place.get)(plate.corners)
    cells = oriented(plate.position, shuffled(cells), plate.normal)
    quadrature = surface_quadrature(plate.position, cells)
    motion = quadrature.normal_displacement(plate.displacement)
    whole = quadrature.overlap(motion, np.arange(len(cells)))
    parts = [quadrature.overlap(motion, np.arange(*span)) for span in ((0, 40), (40, 96))]
    np.testing.assert_allclose(sum(parts), whole, atol=1e-12)
    # ∫ sin² of m half waves that are linear on n elements is (2 + cos(mπ/n))/6
    modes = np.array([(1, 1), (2, 1), (1, 2), (3, 1)])
    modes = modes[np.argsort((modes[:, 0] / 1.2) ** 2 + (modes[:, 1] / 0.8) ** 2)]
    exact = 1.2 * 0.8 * ((2 + np.cos(np.pi * modes / [12, 8])) / 6).prod(axis=1)
    np.testing.assert_allclose(whole, np.diag(exact), atol=1e-12)
    tangent = np.cross(plate.normal, [1.0, 0, 0])
    slide = np.broadcast_to(tangent[:, None], (len(plate.node), 3, 1))
    assert np.abs(quadrature.normal_displacement(slide)).max() < 1e-12
    np.testing.assert_allclose(
        quadrature.values(slide), np.broadcast_to(tangent[:, None], (384, 3, 1))
    )


def second_order(position):
    """A quadrilateral and a triangle of second order beside it: nodes, parts, elements."""
    x = np.array([[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1],
                  [4, 0], [3, 0], [3, 1]])  # fmt: skip
    quad, triangle = np.arange(8), np.array([1, 8, 2, 9, 10, 5])
    parts = [quad[PARTS[8]], triangle[PARTS[6]]]
    parents = np.full((9, 8), -1)
    parents[:5], parents[5:, :6] = quad, triangle
    return position(*x.T), np.concatenate(parts), parents


def test_parts_of_second_order_integrate_their_polynomials_exactly():
    position, cells, parents = second_order(lambda x, y: np.stack([x, y, 0 * x], axis=1))
    quadrature = surface_quadrature(position, cells[:, [2, 1, 0, 3]], parents)
    x, y, _ = position.T
    values = quadrature.values(np.stack([x**2, x * y], axis=1))
    # 8/3 · 2 + ∫_2^4 x² (4 − x) dx, and 4 + ∫_2^4 x (4 − x)²/2 dx
    np.testing.assert_allclose(quadrature.weight @ values, [16 / 3 + 44 / 3, 4 + 10 / 3])
    np.testing.assert_allclose(quadrature.normal, np.outer(np.ones(36), [0, 0, -1]), atol=1e-12)


def test_parts_of_second_order_follow_a_curved_surface():
    """A cylinder of radius 10 about x, whose chords have 0.5 % less area and other normals."""

    def rolled(x, y):
        return np.stack([x, 10 * np.sin(y / 10 * 3), 10 * np.cos(y / 10 * 3)], axis=1)

    position, cells, parents = second_order(rolled)
    quadrature = surface_quadrature(position, cells, parents)
    assert quadrature.weight.sum() == pytest.approx(3 * 6, rel=1e-3)
    radial = position * [0, 0.1, 0.1]
    cosine = (node_normals(position, cells, parents) * radial).sum(axis=1)
    assert np.degrees(np.arccos(np.abs(cosine))).max() < 1
    straight = (node_normals(position, cells) * radial).sum(axis=1)
    assert np.degrees(np.arccos(np.abs(straight))).max() > 5
