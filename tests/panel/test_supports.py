"""Supports as conditions at vertices, on meshes that can be counted by hand."""

import numpy as np
import pytest

from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.supports import (
    EdgeSupport,
    PointSupport,
    Supports,
    boundary_loops,
    held_vertices,
)


def grid(columns, rows):
    """Quadrilaterals between lines x = columns and y = rows."""
    x, y = np.meshgrid(columns, rows)
    width = len(columns)
    corner = (np.arange(len(rows) - 1)[:, None] * width + np.arange(width - 1)).ravel()
    cells = np.column_stack([corner, corner + 1, corner + width + 1, corner + width])
    return PanelMesh(np.column_stack([x.ravel(), y.ravel()]) * 1.0, cells, "quadrilaterals", {}, {})


def without(mesh, cell):
    return PanelMesh(mesh.vertices, np.delete(mesh.cells, cell, axis=0), mesh.cell_kind, {}, {})


def fan(angles, radius):
    """Triangles from the middle of a circle to corners on it."""
    rim = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    number = np.arange(1, len(angles) + 1)
    cells = np.column_stack([np.zeros_like(number), number, np.roll(number, -1)])
    return PanelMesh(np.vstack([[0, 0], rim]), cells, "triangles", {}, {})


RING = without(grid([0, 1, 2, 3], [0, 1, 2, 3]), 4)


def test_loops_go_round_the_panel_and_its_hole():
    loops = sorted(map(len, boundary_loops(RING.vertices, RING.cells)))
    assert loops == [4, 12]


def test_uneven_pieces_of_a_curve_share_its_turn():
    # pieces of 24° and 16°: the tangents turn by 20° over half the sum of the two chords
    angle = np.radians(np.cumsum(np.tile([24, 16], 9)))
    held, _ = held_vertices(fan(angle, 1.0), Supports())
    chords = np.sin(np.radians(12)) + np.sin(np.radians(8))
    for one in held:
        ((_, _, turn),) = one.edges
        assert np.linalg.norm(turn) == pytest.approx(2 * np.sin(np.radians(10)) / chords)


def test_a_corner_has_the_edge_that_arrives_and_the_edge_that_leaves():
    held, edges = held_vertices(RING, Supports("clamped", "simply_supported"))
    assert len(held) == 16 and len(edges) == 16
    by_vertex = {one.vertex: one.edges for one in held}
    assert [kind for kind, *_ in by_vertex[0]] == ["clamped"] * 2
    np.testing.assert_array_equal([t for _, t, _ in by_vertex[0]], [[0, -1], [1, 0]])
    assert edges[0, 1][0] == "clamped" and edges[5, 6][0] == "simply_supported"
    np.testing.assert_array_equal(edges[0, 1][1], [1, 0])
    np.testing.assert_array_equal(edges[5, 6][1], [-1, 0])  # clockwise round the hole
    ((kind, tangent, _),) = by_vertex[1]
    assert kind == "clamped" and tangent.tolist() == [1, 0]


def test_a_free_edge_beside_a_held_one_holds_their_common_vertex_along_the_held_one():
    part = [EdgeSupport((3, 0), (1, 0), "clamped")]
    held, edges = held_vertices(RING, Supports("free", edges=part))
    assert sorted(edges) == [(1, 2), (2, 3)]
    assert sorted(one.vertex for one in held) == [1, 2, 3]
    for one in held:
        for kind, tangent, _ in one.edges:
            assert kind == "clamped" and tangent.tolist() == [1, 0]


def test_a_small_panel_has_an_outline_and_a_hole_like_a_large_one():
    small = PanelMesh(0.1 * RING.vertices, RING.cells, RING.cell_kind, {}, {})
    _, edges = held_vertices(small, Supports("clamped", "free"))
    assert len(edges) == 12


@pytest.mark.parametrize("start", range(4))
def test_an_oblique_edge_is_found_and_so_are_the_kinds_at_its_ends(start):
    # a square turned by 30°, one edge of which is clamped, whichever the loop begins with
    angle = np.radians(30) + np.pi / 2 * np.arange(4)
    mesh = fan(angle, 2.0)
    ends = [tuple(mesh.vertices[1 + (start + k) % 4]) for k in (0, 1)]
    held, edges = held_vertices(mesh, Supports(edges=[EdgeSupport(*ends, "clamped")]))
    clamped = [edge for edge, (kind, _) in edges.items() if kind == "clamped"]
    assert clamped == [tuple(sorted((1 + start, 1 + (start + 1) % 4)))]
    kinds = {one.vertex: [kind for kind, *_ in one.edges] for one in held}
    assert kinds[1 + start] == ["simply_supported", "clamped"]
    assert kinds[1 + (start + 1) % 4] == ["clamped", "simply_supported"]


def test_the_end_of_a_support_within_a_curve_is_no_smooth_turn():
    # one of 20 pieces is clamped: at its ends both kinds hold, each along its own piece
    mesh = fan(2 * np.pi * np.arange(20) / 20, 1.0)
    ends = [tuple(mesh.vertices[k]) for k in (7, 8)]
    held, _ = held_vertices(mesh, Supports(edges=[EdgeSupport(*ends, "clamped")]))
    assert [len(one.edges) for one in sorted(held, key=lambda one: one.vertex)] == [
        1 if vertex not in (7, 8) else 2 for vertex in range(1, 21)
    ]


def test_a_later_edge_wins_and_the_rim_of_a_hole_can_be_one():
    part = [EdgeSupport((1, 1), (2, 1), "clamped"), EdgeSupport((0, 3), (0, 0), "clamped"),
            EdgeSupport((0, 1), (0, 2), "simply_supported")]  # fmt: skip
    _, edges = held_vertices(RING, Supports("free", edges=part))
    kinds = {edge: kind for edge, (kind, _) in edges.items()}
    assert kinds == {(5, 6): "clamped", (0, 4): "clamped", (8, 12): "clamped",
                     (4, 8): "simply_supported"}  # fmt: skip


@pytest.mark.parametrize(
    ("start", "end", "covered"),
    [
        ((0, 0), (2.5, 0), "cover 2 of its 2.5 m"),  # the end between two vertices
        ((0, 1.5), (3, 1.5), "cover 0 of its 3 m"),  # through the inside
        ((-1, 0), (3, 0), "cover 3 of its 4 m"),
        ((1, 0), (1, 0), "cover 0 of its 0 m"),
        ((0, 1), (3, 1), "cover 1 of its 3 m"),  # along the hole only
        ((0, 0), (3, 3), "cover 0 of"),
    ],
)
def test_an_edge_that_the_boundary_does_not_cover_says_how_much_it_does(start, end, covered):
    with pytest.raises(ValueError, match=covered):
        held_vertices(RING, Supports(edges=[EdgeSupport(start, end, "clamped")]))


def test_a_foot_holds_the_cells_whose_centres_it_covers():
    # centres at (0.5, 0.5), (1.5, 0.5), …
    mesh = grid([0, 1, 2, 3], [0, 1, 2, 3])
    foot = PointSupport((1.5, 1.4), "hinge", 1.0)
    assert foot.foot_cells(mesh, "F").tolist() == [1, 4]
    assert PointSupport((1.5, 1.5), "hinge", 1.1).foot_cells(mesh, "F").tolist() == [1, 3, 4, 5, 7]


def test_a_hinged_foot_turns_about_its_middle_and_a_hold_down_does_not_move():
    x, y = np.array([0.3, 1.2, -0.5]), np.array([0.7, 0.1, 2.0])
    rigid = np.column_stack([np.ones(3), x, y])
    motion = PointSupport((0.3, 2.0), "hinge", 0.1).foot_motion(rigid)
    np.testing.assert_array_equal(motion, np.column_stack([x - 0.3, y - 2.0]))
    assert PointSupport((0.3, 2.0), "hold_down", 0.1).foot_motion(rigid).shape == (3, 0)
