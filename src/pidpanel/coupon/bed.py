"""Cells and spheres as arrays: where the walls stand, where the spheres start, which stay."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CELL_SPACING = 2.5
"""Distance of neighbouring cells' centres over their width. They are closed off from each
other; the space between takes up the wall triangles that reach past their cell."""

LOOSE_FRACTION = 0.18
"""Bulk fraction at which spheres start in the chimney; random sequential addition jams at
0.38 in bulk, and slows down long before that between walls."""

DENSEST_FRACTION = 0.64
"""Random close packing: no poured bed is denser, so pouring this much always over-fills."""


def hexagon(across_flats: float) -> Array:
    """Corners of a regular hexagon round the origin, (6, 2) m, anticlockwise."""
    angle = np.deg2rad(30 + 60 * np.arange(6))
    return across_flats / math.sqrt(3) * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def cell_centres(across_flats: float, count: int) -> Array:
    """Centres of ``count`` separate cells on a square grid, (count, 2) m."""
    columns = math.ceil(math.sqrt(count))
    pitch = CELL_SPACING * across_flats
    index = np.arange(count)
    return pitch * np.stack([index % columns, index // columns], axis=1).astype(float)


def side_walls(outline: Array, centres: Array, height: float) -> Array:
    """Triangles of the cells' side walls, one to a side, (n, 3, 3) m.

    ``outline`` (k, 2) are the corners of one convex cell round its centre. A triangle holds
    the rectangle side × ``height`` and reaches past it, twice as wide at the floor and twice
    as high. Past a side of a convex cell there is nothing of the cell, so the spheres meet
    the same planes as with two triangles to a side, at half the cost, and never an edge.
    """
    corners = outline[None] + centres[:, None]
    side = np.roll(corners, -1, axis=1) - corners
    floor = np.zeros((*side.shape[:-1], 1))
    left = np.concatenate([corners - side / 2, floor], axis=-1)
    right = np.concatenate([corners + 1.5 * side, floor], axis=-1)
    apex = np.concatenate([corners + side / 2, floor + 2 * height], axis=-1)
    return np.stack([left, right, apex], axis=-2).reshape(-1, 3, 3)


def poured_count(cell_area: float, depth: float, diameter: float) -> int:
    """Spheres to pour per cell so that the bed stands above ``depth`` for certain."""
    return math.ceil(DENSEST_FRACTION * cell_area * depth / (math.pi / 6 * diameter**3)) + 1


def chimney_height(outline: Array, diameter: float, count: int) -> float:
    """Height, m, in which ``count`` spheres find room at `LOOSE_FRACTION`."""
    inradius = _inradius(outline)
    reachable = polygon_area(outline) * ((inradius - diameter / 2) / inradius) ** 2
    return count * math.pi / 6 * diameter**3 / (LOOSE_FRACTION * reachable) + 2 * diameter


def polygon_area(outline: Array) -> float:
    """Area inside a closed polygon (k, 2), m² (shoelace)."""
    x, y = outline.T
    return float(0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _inradius(outline: Array) -> float:
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
    return float((normal * outline).sum(axis=1).min())


def scatter(
    outline: Array, height: float, diameter: float, count: int, rng: np.random.Generator
) -> Array:
    """``count`` spheres at random in a prism without overlap, (count, 3) m.

    Random sequential addition: positions are drawn uniformly over the part of the cell that
    a centre can reach and kept when 1 % clear of all earlier ones.

    Raises
    ------
    ValueError
        If no room is found after three hundred tries per sphere.
    """
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
    clear = (normal * outline).sum(axis=1) - 0.51 * diameter
    low, high = outline.min(axis=0), outline.max(axis=0)
    kept = np.empty((count, 3))
    n = 0
    for _ in range(300 * count):
        xy = rng.uniform(low, high)
        z = rng.uniform(0.51 * diameter, height - 0.51 * diameter)
        if (normal @ xy > clear).any():
            continue
        point = np.array([*xy, z])
        near = kept[:n][np.abs(kept[:n, 2] - z) < 1.01 * diameter]
        if near.size and ((near - point) ** 2).sum(axis=1).min() < (1.01 * diameter) ** 2:
            continue
        kept[n] = point
        n += 1
        if n == count:
            return kept
    raise ValueError(f"{n} of {count} spheres of {diameter:g} m found room in {height:g} m")


def full_count(cell: NDArray[np.int64], z: Array, depth: float, diameter: float) -> int:
    """Spheres per cell that stand wholly below the lid in the emptiest cell: N_full.

    The fill fraction is r = N/N_full. ``cell`` (n,) is the index of each sphere's cell and
    ``z`` (n,) the height of its centre above the floor in a bed poured higher than the cell.
    """
    inside = z <= depth - diameter / 2
    return int(np.bincount(cell[inside], minlength=int(cell.max()) + 1).min())


def lowest(cell: NDArray[np.int64], z: Array, count: int) -> NDArray[np.int64]:
    """Indices of the ``count`` lowest spheres of every cell, sorted by cell and height.

    What remains of a settled bed when its top is taken off is a settled bed, so one pour
    serves every fill fraction.
    """
    order = np.lexsort((z, cell))
    rank = np.concatenate([np.arange(n) for n in np.bincount(cell) if n])
    return order[rank < count]


def deepest_overlap(positions: Array, diameter: float) -> float:
    """Deepest overlap of two spheres, m; 0 if none touch.

    Parameters
    ----------
    positions
        (n, 3) centres, m.
    diameter
        m.
    """
    from scipy.spatial import cKDTree  # half a second that every other run would pay for

    pairs = cKDTree(positions).query_pairs(diameter, output_type="ndarray")
    if not len(pairs):
        return 0.0
    distance = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    return float(diameter - distance.min())
