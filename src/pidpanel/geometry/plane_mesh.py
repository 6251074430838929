"""Areas, edges and the boundary of a mesh of triangles or quadrilaterals."""

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index


def cell_areas(vertices: ArrayLike, cells: Index) -> Array:
    """Return the signed area (n_cells,) [m²], negative where the vertices go round clockwise.

    By the shoelace formula, positions counted from the first vertex of each cell. In space the area
    of cells that are flat, which has no sign.

    Examples
    --------
    >>> cell_areas([[0, 0], [2, 0], [2, 1], [0, 1]], np.array([[0, 1, 2], [0, 3, 2]])).tolist()
    [1.0, -1.0]
    """
    corners = np.asarray(vertices, dtype=float)[cells]
    offset = corners - corners[:, :1]
    if offset.shape[-1] == 3:
        vector = np.cross(offset, np.roll(offset, -1, axis=1)).sum(axis=1)
        return 0.5 * np.linalg.norm(vector, axis=1)
    x, y = np.moveaxis(offset, -1, 0)
    cross = x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y
    return 0.5 * np.sum(cross, axis=1)


def edge_lengths(vertices: Array, cells: Index) -> Array:
    """Return the length (n_cells, k) of every edge of every cell [m], from vertex j to the next."""
    return np.linalg.norm(vertices[np.roll(cells, -1, axis=1)] - vertices[cells], axis=2)


def boundary_edges(cells: Index) -> Index:
    """Return the edges (n, 2) with a cell on one side only, in the direction of that cell.

    Examples
    --------
    >>> boundary_edges(np.array([[0, 1, 2], [0, 2, 3]])).tolist()
    [[0, 1], [1, 2], [2, 3], [3, 0]]
    """
    edges = np.stack([cells, np.roll(cells, -1, axis=1)], axis=-1).reshape(-1, 2)
    ordered = np.sort(edges, axis=1)
    _, first, count = np.unique(ordered, axis=0, return_index=True, return_counts=True)
    return edges[np.sort(first[count == 1])]


def rectangle_corners(
    vertices: Array, cells: Index
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Return two corners [m] of a mesh that fills a rectangle along x and y; None if it does not.

    Examples
    --------
    >>> corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    >>> rectangle_corners(corners, np.array([[0, 1, 2, 3]]))
    ((0.0, 0.0), (2.0, 1.0))
    >>> rectangle_corners(corners, np.array([[0, 1, 2]]))
    """
    used = vertices[np.unique(cells)]
    low, high = used.min(axis=0), used.max(axis=0)
    area = np.abs(cell_areas(vertices, cells)).sum()
    if not np.isclose(area, np.prod(high - low), rtol=1e-6):
        return None
    return (float(low[0]), float(low[1])), (float(high[0]), float(high[1]))


def plane_axes(normal: Array) -> Array:
    """Return two unit vectors across a direction as columns (3, 2).

    The first is nearest to x, or to y where the direction is near x; both and the direction are
    right-handed.

    Examples
    --------
    >>> plane_axes(np.array([0.0, 0.0, 2.0])).T.tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    """
    unit = np.asarray(normal, np.float64) / np.linalg.norm(normal)
    start = np.eye(3)[1 if abs(unit[0]) > 0.9 else 0]
    first = start - (start @ unit) * unit
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(unit, first)], axis=1)
