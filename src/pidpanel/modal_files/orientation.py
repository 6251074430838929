"""One side of a surface: cells that go round alike from neighbour to neighbour."""

import numpy as np
import scipy.sparse
from scipy.sparse.csgraph import breadth_first_order, connected_components

from pidpanel.arrays import Array, Index

CLEAR = 0.01  # least share of a part's area that must face outward


def oriented(position: Array, cells: Index, outward: Array | None = None) -> Index:
    """Return cells whose normals are on one side of the surface.

    Orientation goes from neighbour to neighbour across edges of two cells, kinks too. Edges of
    more cells, such as T-joints, separate parts, each of which is turned outward.

    Parameters
    ----------
    position, cells
        Nodes (n_nodes, 3) [m] and corners (n_cells, 4); triangles repeat the third.
    outward
        Direction (3,) that each part faces; away from the centroid of the surface without it.

    Raises
    ------
    ValueError
        If a part has one side only, or faces outward as much as inward.
    """
    size = len(cells)
    start, end = cells.ravel(), np.roll(cells, -1, axis=1).ravel()
    origin = np.repeat(np.arange(size), 4)
    is_edge = start != end
    start, end, origin = start[is_edge], end[is_edge], origin[is_edge]
    pairs = np.sort(np.stack([start, end], axis=1), axis=1)
    _, edge, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(edge, kind="stable")
    order = order[count[edge[order]] == 2].reshape(-1, 2)
    first, second = origin[order].T
    turn = np.where(start[order[:, 0]] == start[order[:, 1]], -1, 1)  # -1: one must be turned
    graph = scipy.sparse.coo_array((np.ones(len(first)), (first, second)), (size, size)).tocsr()
    parts, part = connected_components(graph, directed=False)
    sign = np.ones(size, dtype=int)
    relation = dict(zip(zip(first.tolist(), second.tolist(), strict=True), turn, strict=True))
    for root in np.unique(part, return_index=True)[1].tolist():
        tree, parents = breadth_first_order(graph, root, directed=False)
        for cell in tree[1:].tolist():
            parent = int(parents[cell])
            pair = (parent, cell) if (parent, cell) in relation else (cell, parent)
            sign[cell] = sign[parent] * relation[pair]
    if (torn := sign[first] * sign[second] != turn).any():
        raise ValueError(f"{_place(position, cells, first[torn])}: the surface has one side only")
    a, b, c, d = position[cells].transpose(1, 0, 2)
    area = np.cross(c - a, d - b) / 2 * sign[:, None]
    area_size = np.linalg.norm(area, axis=1)
    centre = position[cells].mean(axis=1)
    if outward is None:
        facing = centre - np.average(centre, axis=0, weights=area_size)
        facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), np.finfo(float).tiny)
    else:
        facing = np.asarray(outward, dtype=float) / np.linalg.norm(outward)
    share = np.bincount(part, (area * facing).sum(axis=1), parts) / np.bincount(
        part, area_size, parts
    )
    if (unclear := np.abs(share) < CLEAR).any():
        place = _place(position, cells, np.flatnonzero(unclear[part]))
        raise ValueError(f"{place}: faces outward as much as inward; state another direction")
    return np.where((sign * np.sign(share[part]) > 0)[:, None], cells, cells[:, [2, 1, 0, 3]])


def _place(position: Array, cells: Index, members: Index) -> str:
    """Return a part of a surface in words, by its first cell."""
    x, y, z = position[cells[members[0]]].mean(axis=0)
    return f"surface with {len(members)} cells at ({x:.3g}, {y:.3g}, {z:.3g}) m"
