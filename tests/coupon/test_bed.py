"""Cells and spheres as arrays."""

import numpy as np
import pytest

from pidpanel.coupon import bed

WIDTH = 6.35e-3


def test_the_hexagon_is_as_wide_as_it_says_and_has_the_closed_form_area():
    outline = bed.hexagon(WIDTH)
    assert np.ptp(outline[:, 0]) == pytest.approx(WIDTH)  # across the flats, x
    assert bed.polygon_area(outline) == pytest.approx(np.sqrt(3) / 2 * WIDTH**2)


def test_a_wall_triangle_holds_its_side_and_nothing_of_the_cell():
    outline = bed.hexagon(WIDTH)
    height = 0.025
    triangles = bed.side_walls(outline, np.zeros((1, 2)), height)
    assert len(triangles) == 6
    for corner, nxt, (a, b, c) in zip(
        outline, np.roll(outline, -1, axis=0), triangles, strict=True
    ):
        # the four corners of the side have barycentric coordinates within the triangle
        for xy, z in ((corner, 0.0), (nxt, 0.0), (corner, height), (nxt, height)):
            point = np.array([*xy, z])
            weights = np.linalg.lstsq(
                np.vstack([np.stack([a, b, c]).T, np.ones(3)]), np.array([*point, 1.0]), rcond=None
            )[0]
            assert weights.min() > -1e-9
        normal = np.cross(b - a, c - a)
        inner = 0.5 * outline  # points well inside the cell, all on one side of the plane
        side = (np.column_stack([inner, np.full(6, height / 2)]) - a) @ normal
        assert (side < 0).all() or (side > 0).all()


def test_cells_are_farther_apart_than_their_wall_triangles_reach():
    outline = bed.hexagon(WIDTH)
    centres = bed.cell_centres(WIDTH, 5)
    triangles = bed.side_walls(outline, centres, 0.025).reshape(5, -1, 3)
    for i, centre in enumerate(centres):
        others = np.delete(triangles, i, axis=0).reshape(-1, 3)
        # farther than the cell's own corners
        assert np.hypot(*(others[:, :2] - centre).T).min() > WIDTH / np.sqrt(3)


def test_scattered_spheres_neither_touch_nor_leave_the_cell():
    outline = bed.hexagon(WIDTH)
    d = 2e-3
    points = bed.scatter(outline, 0.1, d, 60, np.random.default_rng(1))
    distance = np.linalg.norm(points[:, None] - points[None], axis=2) + np.eye(60)
    assert distance.min() >= d
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
    clear = (normal * outline).sum(axis=1)[:, None] - normal @ points[:, :2].T
    assert clear.min() >= d / 2


def test_too_many_spheres_are_refused_by_number():
    with pytest.raises(ValueError, match=r"of 40 spheres of 0.002 m found room"):
        bed.scatter(bed.hexagon(WIDTH), 0.006, 2e-3, 40, np.random.default_rng(1))


def test_the_full_count_is_that_of_the_emptiest_cell():
    cell = np.array([0, 0, 0, 1, 1, 1])
    z = np.array([1, 3, 5, 1, 3, 9.5]) * 1e-3
    # depth 10 mm, diameter 2 mm: centres up to 9 mm lie below the lid
    assert bed.full_count(cell, z, 10e-3, 2e-3) == 2


def test_the_lowest_spheres_of_every_cell_stay():
    cell = np.array([0, 1, 0, 1, 0, 1])
    z = np.array([3.0, 2.0, 1.0, 4.0, 2.0, 1.0])
    assert bed.lowest(cell, z, 2).tolist() == [2, 4, 5, 1]
