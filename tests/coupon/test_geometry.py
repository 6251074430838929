"""Cells and spheres as arrays."""

import numpy as np
import pytest

from pidpanel.coupon import geometry
from pidpanel.geometry.cells import SHAPES
from pidpanel.geometry.sizes import Sizes

WIDTH = 6.35e-3


HEXAGON = SHAPES["hexagon"].outline(WIDTH)
MONO = Sizes("mono", 2e-3, 2e-3)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_cap_holds_the_whole_cell(shape):
    outline = SHAPES[shape].outline(WIDTH)
    for a, b, c in geometry.caps(outline, np.zeros((1, 2)), 0.025):
        weights = np.linalg.solve(
            np.vstack([np.stack([a, b, c])[:, :2].T, np.ones(3)]),
            np.vstack([outline.T, np.ones(len(outline))]),
        )
        assert weights.min() > 0
        assert a[2] == b[2] == c[2] in (0.0, 0.025)


@pytest.mark.parametrize(
    ("sizes", "mean", "deviation"),
    [
        (Sizes("mono", 2e-3, 2e-3), 2e-3, 0.0),
        (Sizes("uniform", 1e-3, 3e-3), 2e-3, 2e-3 / np.sqrt(12)),
        # cut at two deviations: σ² (1 − 2·2φ(2)/(2Φ(2) − 1)) = 0.7737 σ²
        (Sizes("normal", 1e-3, 3e-3), 2e-3, 0.5e-3 * np.sqrt(0.77371)),
        (Sizes("binary", 1e-3, 3e-3, 0.25), 1.5e-3, 2e-3 * np.sqrt(0.25 * 0.75)),
    ],
)
def test_sizes_have_the_mean_and_deviation_of_their_distribution(sizes, mean, deviation):
    drawn = sizes.draw(40000, np.random.default_rng(1))
    # five standard errors of the mean and of the deviation of 40000 draws
    assert drawn.mean() == pytest.approx(mean, abs=5 * deviation / 200 + 1e-15)
    assert drawn.std() == pytest.approx(deviation, abs=5 * deviation / 200 + 1e-15)
    assert drawn.min() >= sizes.smallest and drawn.max() <= sizes.largest


def test_enough_is_poured_of_any_mixture():
    rng = np.random.default_rng(1)
    for sizes in (MONO, Sizes("uniform", 1e-3, 2e-3), Sizes("binary", 1e-3, 2e-3, 0.1)):
        diameters = geometry.poured_sizes(sizes, 35e-6, 25e-3, rng)
        # a bed as dense as random close packing would still reach the lid
        assert (np.pi / 6 * diameters**3).sum() >= 0.64 * 35e-6 * 25e-3


def test_a_wall_triangle_holds_its_side_and_nothing_of_the_cell():
    outline = HEXAGON
    height = 0.025
    triangles = geometry.side_walls(outline, np.zeros((1, 2)), height)
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
    outline = HEXAGON
    centres = geometry.cell_centres(WIDTH, 5)
    triangles = geometry.side_walls(outline, centres, 0.025).reshape(5, -1, 3)
    for i, centre in enumerate(centres):
        others = np.delete(triangles, i, axis=0).reshape(-1, 3)
        # farther than the cell's own corners
        assert np.hypot(*(others[:, :2] - centre).T).min() > WIDTH / np.sqrt(3)


def test_scattered_spheres_neither_touch_nor_leave_the_cell():
    rng = np.random.default_rng(1)
    d = rng.uniform(1.5e-3, 2.5e-3, 60)
    points = geometry.scatter(HEXAGON, 0.1, d, rng)
    distance = np.linalg.norm(points[:, None] - points[None], axis=2) + np.eye(60)
    assert (distance >= (d[:, None] + d) / 2).all()
    edge = np.roll(HEXAGON, -1, axis=0) - HEXAGON
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
    clear = (normal * HEXAGON).sum(axis=1)[:, None] - normal @ points[:, :2].T
    assert (clear >= d / 2).all()


def test_too_many_spheres_are_refused_by_number():
    with pytest.raises(ValueError, match=r"of 40 spheres found room in 0\.006 m"):
        geometry.scatter(HEXAGON, 0.006, np.full(40, 2e-3), np.random.default_rng(1))


def test_the_lowest_spheres_of_every_cell_stay():
    cell = np.array([0, 1, 0, 1, 0, 1])
    z = np.array([3.0, 2.0, 1.0, 4.0, 2.0, 1.0])
    assert geometry.lowest(cell, z, 2).tolist() == [2, 4, 5, 1]


def test_a_chimney_holds_the_spheres_at_the_loose_fraction_where_centres_can_reach():
    # a square of 10 mm and spheres of 2 mm at most: centres reach (1 − 1/5)² of its area; two
    # of the widest on top
    square = SHAPES["square"].outline(10e-3)
    diameters = np.array([2e-3] * 3 + [1e-3] * 5)
    volume = np.pi / 6 * (3 * 8e-9 + 5 * 1e-9)
    expected = volume / (0.18 * 0.64 * 1e-4) + 4e-3
    assert geometry.chimney_height(square, diameters) == pytest.approx(expected)


def test_a_chimney_of_an_uneven_cell_is_as_narrow_as_its_narrow_side_and_turns_either_way():
    # a box of 10 by 20 mm, its corners in either order: 4 of 5 mm are left of the inradius
    box = np.array([[-5, -10], [5, -10], [5, 10], [-5, 10]]) * 1e-3
    diameters = np.full(7, 2e-3)
    expected = 7 * np.pi / 6 * 8e-9 / (0.18 * 2e-4 * 0.64) + 4e-3
    assert geometry.chimney_height(box, diameters) == pytest.approx(expected)
    assert geometry.polygon_area(box[::-1]) == pytest.approx(2e-4)


def test_a_sphere_counts_where_its_top_is_below_the_lid_and_an_empty_cell_counts_too():
    cell, d = np.array([0, 0, 1, 1, 2]), np.full(5, 2e-3)
    z = np.array([1.0, 8.9, 1.0, 9.2, 2.0]) * 1e-3
    assert geometry.full_count(cell, z, 10e-3, d) == 1
    assert geometry.full_count(cell[:4], z[:4] - [0, 0, 0, 0.3e-3], 10e-3, d[:4]) == 2
    assert geometry.full_count(cell, np.add(z, [0, 0, 0, 0, 7.5e-3]), 10e-3, d) == 0


def test_spheres_fill_a_low_prism_up_to_both_ends_and_keep_one_percent_clear():
    # 1000 tries of one sphere at a time reach the ends of z: 0.51 of the diameter from either
    rng = np.random.default_rng(3)
    d, height = 2e-3, 10e-3
    points = np.concatenate(
        [geometry.scatter(HEXAGON, height, np.array([d]), rng) for _ in range(1000)]
    )
    z, inradius = points[:, 2], 6.35e-3 / 2
    # the nearest of 1000 to the sides: a thousandth of the area along them, six times that
    normal = HEXAGON + np.roll(HEXAGON, -1, axis=0)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    clear = inradius - (points[:, :2] @ normal.T).max()
    assert 0 <= clear - 0.51 * d < 6e-3 * (inradius - 0.51 * d) / 2
    # the extremes of 1000 uniform draws lie a thousandth of the range from its ends; six of those
    room = height - 1.02 * d
    assert 0 <= min(z) - 0.51 * d < 6e-3 * room
    assert 0 <= height - 0.51 * d - max(z) < 6e-3 * room
    pairs = [geometry.scatter(HEXAGON, 2.1 * d, np.full(2, d), rng) for _ in range(300)]
    apart = [np.linalg.norm(a - b) for a, b in pairs]
    assert 1.01 * d <= min(apart) < 1.06 * d


def test_spheres_come_back_in_the_order_of_their_sizes_as_given():
    # the largest is placed first, and returned where it was; walls are as far as each asks
    d = np.array([1e-3, 3e-3, 2e-3, 1.5e-3])
    rng = np.random.default_rng(1)
    nearest = np.full(4, np.inf)
    for _ in range(200):
        points = geometry.scatter(HEXAGON, 12e-3, d, rng)
        nearest = np.minimum(nearest, np.minimum(points[:, 2], 12e-3 - points[:, 2]))
    assert (nearest >= 0.51 * d).all()
    assert (nearest < 0.51 * d + 2e-4).all()


def test_the_deepest_overlap_is_found_whatever_lies_between_in_height():
    # a hundred spheres by hand, every pair
    rng = np.random.default_rng(2)
    for _ in range(20):
        places, d = rng.uniform(0, 12e-3, (100, 3)), rng.uniform(1e-3, 3e-3, 100)
        apart = np.linalg.norm(places[:, None] - places, axis=2) + np.eye(100)
        expected = ((d[:, None] + d) / 2 - apart).max()
        assert geometry.deepest_overlap(places, d) == pytest.approx(max(expected, 0.0))
        assert geometry.deepest_overlap(3 * places, d) == pytest.approx(
            max(((d[:, None] + d) / 2 - 3 * (apart - np.eye(100)) - np.eye(100)).max(), 0.0)
        )
