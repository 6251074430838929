"""One side of a surface: cells that go round alike from neighbour to neighbour."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import connected_components

from pidpanel.arrays import Array, Index

CLEAR = 0.01  # least share of a part's area that must face outward


def oriented(
    position: Array,
    cells: Index,
    outward: ArrayLike | None = None,
    *,
    or_along_axis: bool = False,
) -> Index:
    """Return cells whose normals are on one side of the surface.

    Orientation goes from neighbour to neighbour across edges of two cells, kinks too. Edges of
    more cells, such as T-joints, separate parts, each of which is turned outward; one that closes,
    to its outside.

    Parameters
    ----------
    position, cells
        Nodes (n_nodes, 3) [m] and corners (n_cells, 3) or (n_cells, 4); triangles among the latter
        repeat the third.
    outward
        Direction (3,) that each part faces; away from the centroid of the surface without it.
    or_along_axis
        Whether a part that does so as much as not faces along the axis nearest to its normals.

    Raises
    ------
    ValueError
        If a part has one side only, or faces outward as much as inward.
    """
    size = len(cells)
    step = np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2)
    is_edge = step[:, 0] != step[:, 1]
    step, origin = step[is_edge], np.repeat(np.arange(size), cells.shape[1])[is_edge]
    _, edge, uses = np.unique(
        np.sort(step, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    uses = uses[edge.ravel()]
    order = np.argsort(edge.ravel(), kind="stable")
    a, b = order[uses[order] == 2].reshape(-1, 2).T
    opposite = size * (step[a, 0] == step[b, 0])  # two cells that run along their edge alike
    a, b = origin[a], origin[b]
    # each cell as it is and turned round: a surface with two sides falls apart into both
    start, end = np.concatenate([a, a + size]), np.concatenate([b + opposite, b + size - opposite])
    graph = sp.coo_array((np.ones(len(start)), (start, end)), (2 * size,) * 2)
    _, label = connected_components(graph, directed=False)
    _, part = np.unique(np.minimum(label[:size], label[size:]), return_inverse=True)
    if (torn := label[:size] == label[size:]).any():
        place = _place(position, cells, np.flatnonzero(torn))
        raise ValueError(f"{place}: the surface has one side only")
    sign = np.where(label[:size] < label[size:], 1, -1)
    first, second, third, last = position[cells[:, [0, 1, 2, -1]]].transpose(1, 0, 2)
    area = np.cross(third - first, last - second) / 2 * sign[:, None]
    area_size, centre = np.linalg.norm(area, axis=1), position[cells].mean(axis=1)
    closes = np.bincount(part, np.bincount(origin, uses != 2, size)) == 0
    middle = np.average(centre, axis=0, weights=area_size)
    if outward is None:
        facing = centre - middle
        facing /= np.maximum(np.linalg.norm(facing, axis=1, keepdims=True), np.finfo(float).tiny)
    else:
        direction = np.asarray(outward, dtype=float)
        facing = np.broadcast_to(direction / np.linalg.norm(direction), centre.shape)
    share = np.bincount(part, (area * facing).sum(axis=1)) / np.bincount(part, area_size)
    volume = np.bincount(part, (area * (centre - middle)).sum(axis=1))
    share[closes] = np.sign(volume[closes])
    unclear = np.abs(share) < CLEAR
    if unclear.any() and not or_along_axis:
        place = _place(position, cells, np.flatnonzero(unclear[part]))
        raise ValueError(f"{place}: faces outward as much as inward; state another direction")
    total = np.stack([np.bincount(part, along) for along in area.T], axis=1)
    largest = np.take_along_axis(total, np.abs(total).argmax(axis=1)[:, None], axis=1)[:, 0]
    sign = sign * np.sign(np.where(unclear, largest, share))[part]
    return np.where((sign > 0)[:, None], cells, cells[:, [2, 1, 0, 3][: cells.shape[1]]])


def _place(position: Array, cells: Index, members: Index) -> str:
    """Return a part of a surface in words, by its first cell."""
    x, y, z = position[cells[members[0]]].mean(axis=0)
    return f"surface with {len(members)} cells at ({x:.3g}, {y:.3g}, {z:.3g}) m"
