"""Areas, edges and the boundary of a plane mesh of triangles or quadrilaterals."""

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index


def cell_areas(vertices: ArrayLike, cells: Index) -> Array:
    """Return the signed area of each cell [m²], negative where its vertices go round clockwise.

    Parameters
    ----------
    vertices
        (n_vertices, 2) positions [m].
    cells
        (n_cells, 3) or (n_cells, 4) vertex numbers, in order round each cell.

    Returns
    -------
    (n_cells,) areas by the shoelace formula, positions counted from the first vertex of the cell.

    Examples
    --------
    >>> cell_areas([[0, 0], [2, 0], [2, 1], [0, 1]], np.array([[0, 1, 2], [0, 3, 2]])).tolist()
    [1.0, -1.0]
    """
    corners = np.asarray(vertices, dtype=float)[cells]
    x, y = np.moveaxis(corners - corners[:, :1], -1, 0)
    cross = x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y
    area: Array = 0.5 * np.sum(cross, axis=1)
    return area


def edge_lengths(vertices: Array, cells: Index) -> Array:
    """Return the length of every edge of every cell [m].

    Parameters
    ----------
    vertices
        (n_vertices, 2) positions [m].
    cells
        (n_cells, k) vertex numbers, in order round each cell.

    Returns
    -------
    (n_cells, k); edge j of a cell leads from its vertex j to the next.
    """
    length: Array = np.linalg.norm(vertices[np.roll(cells, -1, axis=1)] - vertices[cells], axis=2)
    return length


def boundary_edges(cells: Index) -> Index:
    """Return the edges with a cell on one side only, in the direction of that cell.

    Parameters
    ----------
    cells
        (n_cells, k) vertex numbers, in order round each cell: counter-clockwise, the cell is to
        the left of its edges.

    Returns
    -------
    (n, 2) vertex numbers, in the order of the cells.

    Examples
    --------
    >>> boundary_edges(np.array([[0, 1, 2], [0, 2, 3]])).tolist()
    [[0, 1], [1, 2], [2, 3], [3, 0]]
    """
    edges = np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    ordered = np.sort(edges, axis=1)
    _, first, count = np.unique(ordered, axis=0, return_index=True, return_counts=True)
    return edges[np.sort(first[count == 1])]
