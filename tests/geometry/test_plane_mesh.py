"""Areas, edges and boundaries of plane meshes that can be counted by hand."""

import numpy as np

from pidpanel.geometry.plane_mesh import boundary_edges, cell_areas, edge_lengths

# a ring of eight squares of 2 m × 3 m round a hole
COLUMNS = np.arange(4)
VERTICES = np.array([(2.0 * i + 5, 3.0 * j - 7) for j in COLUMNS for i in COLUMNS])
RING = np.array(
    [
        (4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4)
        for j in range(3)
        for i in range(3)
        if (i, j) != (1, 1)
    ]
)


def test_areas_are_signed_and_independent_of_where_the_mesh_lies():
    np.testing.assert_array_equal(cell_areas(VERTICES, RING), np.full(8, 6.0))
    np.testing.assert_array_equal(cell_areas(VERTICES, RING[:, ::-1]), np.full(8, -6.0))
    halves = RING[:, [0, 1, 2]]
    np.testing.assert_array_equal(cell_areas(VERTICES + 2.0**40, halves), np.full(8, 3.0))


def test_edges_of_a_cell_start_at_its_first_vertex():
    np.testing.assert_array_equal(
        edge_lengths(VERTICES, RING), np.tile([2.0, 3.0, 2.0, 3.0], (8, 1))
    )
    triangle = np.array([[0, 1, 6]])
    np.testing.assert_allclose(edge_lengths(VERTICES, triangle), [[2.0, np.hypot(2, 3), 5.0]])


def test_boundary_goes_round_the_ring_and_clockwise_round_its_hole():
    edges = boundary_edges(RING)
    assert len(edges) == 12 + 4
    # the area by Green's theorem, ½ ∮ x dy − y dx: the hole counts negative
    (x, y), (u, v) = VERTICES[edges[:, 0]].T, VERTICES[edges[:, 1]].T
    assert 0.5 * np.sum(x * v - u * y) == 8 * 6.0
