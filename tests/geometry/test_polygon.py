"""Truths of plane shapes: areas, arcs, what lies on what, and the one line for what does not."""

import numpy as np
import pytest

from pidpanel.geometry.polygon import (
    Circle,
    Polygon,
    Rectangle,
    check_panel,
    lies_within,
    overlap,
    rounded,
    signed_area,
)

L_SHAPE = Polygon(((0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)))
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]


def test_the_l_has_three_quarters_of_the_square():
    assert signed_area(L_SHAPE.corners) == 0.75


def test_a_disc_of_equal_area_has_it_and_another_lies_on_its_circle():
    assert signed_area(Circle.of_equal_area((1, 2), 0.3).corners) == pytest.approx(np.pi * 0.09)
    away = np.linalg.norm(Circle((1, 2), 0.3).corners - (1, 2), axis=1)
    np.testing.assert_allclose(away, 0.3)


@pytest.mark.parametrize("points", [SQUARE, SQUARE[::-1], L_SHAPE.points])
def test_rounding_cuts_what_arcs_leave_of_corners(points):
    r = 0.1
    arcs = rounded(points, r)
    # a right angle loses (1 - pi/4) r^2, a re-entrant one gains it; the pieces' chords cut less
    lost = abs(signed_area(points)) - abs(signed_area(arcs))
    corners = len(points) - 2 * (len(points) == 6)
    assert lost == pytest.approx(corners * (1 - np.pi / 4) * r**2, rel=0.02)
    # no piece turns by more than 7.5 degrees
    step = np.roll(arcs, -1, axis=0) - arcs
    turn = np.angle(np.exp(1j * np.diff(np.unwrap(np.arctan2(step[:, 1], step[:, 0])))))
    assert np.abs(turn).max() < np.radians(7.5) + 1e-9


def test_arcs_that_need_more_than_their_edge_are_refused():
    with pytest.raises(
        ValueError,
        match=r"corner radius 0.6 m: the edge from .* is 1 m long, its two arcs need 1.2 m",
    ):
        rounded(SQUARE, 0.6)


@pytest.mark.parametrize(
    ("other", "inside", "common"),
    [
        (Rectangle((0.25, 0.25), (0.2, 0.2)), True, True),
        (Rectangle((0.25, 0.25), (0.5, 0.5)), True, True),  # touches two edges and the corner
        (Rectangle((0.5, 0.5), (0.2, 0.2)), False, True),  # over the re-entrant corner
        (Rectangle((0.75, 0.75), (0.5, 0.5)), False, False),  # the missing quarter
        (Rectangle((2.0, 2.0), (0.5, 0.5)), False, False),
        (Rectangle((0.5, 0.5), (3.0, 3.0)), False, True),  # around it
        (L_SHAPE, True, True),
    ],
)
def test_what_lies_within_and_what_overlaps(other, inside, common):
    assert lies_within(other.corners, L_SHAPE.corners, 1e-9) is inside
    assert overlap(other.corners, L_SHAPE.corners, 1e-9) is common
    assert overlap(L_SHAPE.corners, other.corners, 1e-9) is common


HOLE = {"H": Circle((0.25, 0.25), 0.1)}


@pytest.mark.parametrize(
    ("outline", "holes", "patches", "points", "message"),
    [
        (Polygon(((0, 0), (1, 1), (1, 0), (0, 1))), {}, {}, {}, "encloses no area"),
        (Polygon(((0, 0), (1, 1), (1, 0), (0, 2))), {}, {}, {}, "outline crosses itself: the edge from (0, 0) m meets"),
        (Polygon(((0, 0), (2, 0), (2, 2), (1, 0), (0, 2))), {}, {}, {}, "outline touches itself at (1, 0) m"),
        (Polygon(((0, 0), (2, 0), (2, 2), (1, 1e-10), (0, 2))), {}, {}, {}, "outline touches itself at (1, 1e-10) m"),
        (L_SHAPE, {"H": Circle((0.75, 0.75), 0.1)}, {}, {}, "hole 'H' = circle of radius 0.1 m about (0.75, 0.75) m is not inside"),
        (L_SHAPE, {"H": Rectangle((0.25, 0.1), (0.2, 0.2))}, {}, {}, "hole 'H' = [0.15, 0.35] x [0, 0.2] m is not inside"),
        # touches the re-entrant corner with the inside of an edge
        (L_SHAPE, {"H": Polygon(((0.1, 0.2), (0.8, 0.2), (0.1, 0.9)))}, {}, {}, "is not inside the panel"),
        (L_SHAPE, HOLE | {"I": Circle((0.3, 0.3), 0.1)}, {}, {}, "holes 'H' and 'I' meet"),
        (L_SHAPE, HOLE, {"P": Rectangle((0.5, 0.5), (0.2, 0.2))}, {}, "patch 'P' = [0.4, 0.6] x [0.4, 0.6] m leaves the panel"),
        (L_SHAPE, HOLE, {"P": Rectangle((0.35, 0.25), (0.2, 0.2))}, {}, "patch 'P' = [0.25, 0.45] x [0.15, 0.35] m lies over hole 'H'"),
        (L_SHAPE, HOLE, {"P": Rectangle((0.25, 0.25), (0.4, 0.4))}, {}, "lies over hole 'H'; patches must not overlap"),
        (L_SHAPE, HOLE, {}, {"7": (0.25, 0.2)}, "point '7' = (0.25, 0.2) m lies in hole 'H'"),
        (L_SHAPE, HOLE, {}, {"7": (0.75, 0.75)}, "point '7' = (0.75, 0.75) m leaves the panel"),
    ],
)  # fmt: skip
def test_what_does_not_lie_on_the_panel_is_named(outline, holes, patches, points, message):
    with pytest.raises(ValueError) as caught:
        check_panel(outline, holes, patches, points)
    assert message in str(caught.value)


def test_an_area_keeps_its_digits_far_from_the_origin():
    far = np.array(L_SHAPE.points) + 2.0**40
    assert signed_area(far) == 0.75
    assert signed_area(far[::-1]) == -0.75


def test_an_equilateral_triangle_loses_what_the_chords_of_its_arcs_leave():
    r, side = 0.1, 1.0
    triangle = [(0, 0), (side, 0), (side / 2, side * np.sqrt(3) / 2)]
    left = np.sqrt(3) / 4 * side**2 - 3 * r**2 * (np.sqrt(3) - 8 * np.sin(np.radians(7.5)))
    assert signed_area(rounded(triangle, r)) == pytest.approx(left, rel=1e-12)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 10.0, 1e6])
def test_arcs_scale_with_their_polygon_and_a_circle_remains_of_a_square(scale):
    square = scale * np.array(SQUARE)
    arcs = rounded(square, 0.1 * scale)
    assert len(arcs) == 4 * 13  # the ends of twelve pieces of 7.5° at each corner
    np.testing.assert_allclose(arcs, scale * rounded(SQUARE, 0.1), rtol=1e-12, atol=1e-15 * scale)
    circle = rounded(square, 0.5 * scale)
    assert len(circle) == 48  # nothing is left of the edges, and no corner is there twice
    np.testing.assert_allclose(np.linalg.norm(circle - scale / 2, axis=1), scale / 2)


def test_the_edge_that_its_two_arcs_fill_first_is_named():
    # a right trapezium with corners of 90°, 45°, 135°, 90°: its arcs take r (1, 1 + √2, √2 - 1, 1)
    # of the edges beside them, which first fills the upper edge, at r = 1/√2
    points = [(0, 0), (2.5, 0), (1, 1.5), (0, 1.5)]
    assert len(rounded(points, 0.70)) > 4
    with pytest.raises(
        ValueError, match=r"edge from \(1, 1.5\) m is 1 m long, its two arcs need 1.01823 m"
    ):
        rounded(points, 0.72)


@pytest.mark.parametrize("scale", [1e-5, 1e5])
def test_checks_are_the_same_at_every_scale(scale):
    outline = Polygon(tuple((scale * x, scale * y) for x, y in L_SHAPE.points))
    hole = {"H": Circle((0.25 * scale, 0.25 * scale), 0.1 * scale)}
    check_panel(outline, hole, {}, {"7": (0.5 * scale, 0.0)})
    touching = Polygon(tuple((scale * x, scale * y) for x, y in
                             [(0, 0), (2, 0), (2, 2), (1, 1e-10), (0, 2)]))  # fmt: skip
    with pytest.raises(ValueError, match="touches itself"):
        check_panel(touching, {}, {}, {})


def test_what_lies_on_the_panel_passes():
    check_panel(L_SHAPE, HOLE, {"P": Rectangle((0.75, 0.25), (0.5, 0.5))}, {"7": (0.5, 0.5)})
