"""Cells and spheres as arrays: where the walls are, where the spheres start, which stay.

The code of this module enters the label of every packing and bed; see `pidpanel.coupon.packing`.
"""

import math

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.sizes import Sizes

# Distance of neighbouring cells' centres over their width [1]. The cells are closed off from each
# other; the space between takes up the wall triangles that reach past their cell.
CELL_SPACING = 3.0

# Bulk fraction at which spheres start in the chimney [1]; random sequential addition jams at
# 0.38 in bulk, and slows down long before that between walls.
LOOSE_FRACTION = 0.18

# Bulk fraction of random close packing [1]: no poured bed is denser, so pouring this much always
# over-fills.
DENSEST_FRACTION = 0.64


def cell_centres(across_flats: float, count: int) -> Array:
    """Return the centres of ``count`` separate cells on a square grid, (count, 2) [m]."""
    columns = math.ceil(math.sqrt(count))
    pitch = CELL_SPACING * across_flats
    index = np.arange(count)
    return pitch * np.stack([index % columns, index // columns], axis=1).astype(float)


def side_walls(outline: Array, centres: Array, height: float) -> Array:
    """Return the triangles of the side walls of convex cells, one to a side, (c k, 3, 3) [m].

    A triangle holds the rectangle side × ``height`` and reaches past it, twice as wide at the floor
    and twice as high. Past a side of a convex cell there is nothing of the cell, so the spheres
    meet the same planes as with two triangles to a side, at half the cost, and never an edge.
    """
    corners = outline[None] + centres[:, None]
    side = np.roll(corners, -1, axis=1) - corners
    floor = np.zeros((*side.shape[:-1], 1))
    left = np.concatenate([corners - side / 2, floor], axis=-1)
    right = np.concatenate([corners + 1.5 * side, floor], axis=-1)
    apex = np.concatenate([corners + side / 2, floor + 2 * height], axis=-1)
    return np.stack([left, right, apex], axis=-2).reshape(-1, 3, 3)


def caps(outline: Array, centres: Array, depth: float) -> Array:
    """Return the triangles of the floors and then of the lids of cells, (2c, 3, 3) [m].

    A triangle holds the circle round the corners of ``outline`` (k, 2), so the spheres meet
    a plane. In a run of meshes alone every contact can be listed; a primitive plane's cannot.
    """
    reach = 2.02 * np.linalg.norm(outline, axis=1).max()
    angle = np.deg2rad([90, 210, 330])
    corners = reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    flat = centres[:, None] + corners[None]
    return np.concatenate(
        [np.concatenate([flat, np.full((*flat.shape[:-1], 1), z)], axis=-1) for z in (0.0, depth)]
    )


def closed_cells(outline: Array, centres: Array, depth: float) -> Array:
    """Return the triangles of closed cells: sides, floors, lids, (c (k + 2), 3, 3) [m]."""
    sides = side_walls(outline, centres, depth)
    return np.concatenate([sides, caps(outline, centres, depth)])


def simulation_box(across_flats: float, centres: Array, height: float, below: float) -> Array:
    """Return the lower and upper bounds of a box round cells of a ``height``, (3, 2) [m].

    ``below`` is what it reaches below the floor. The wall triangles reach twice as high as the
    walls.
    """
    reach = CELL_SPACING / 2 * across_flats
    low, high = centres.min(axis=0) - reach, centres.max(axis=0) + reach
    return np.array([[low[0], high[0]], [low[1], high[1]], [-below, 2.1 * height]])


def poured_sizes(sizes: Sizes, cell_area: float, depth: float, rng: np.random.Generator) -> Array:
    """Return diameters of enough spheres to fill one cell above ``depth``, (n,) [m]."""
    volume = DENSEST_FRACTION * cell_area * depth
    most = math.ceil(volume / (math.pi / 6 * sizes.smallest**3)) + 1
    diameters = sizes.draw(most, rng)
    enough = int(np.searchsorted(np.cumsum(math.pi / 6 * diameters**3), volume)) + 1
    return diameters[: min(enough + 1, most)]


def chimney_height(outline: Array, diameters: Array) -> float:
    """Return the height for spheres of diameters (n,) [m] at `LOOSE_FRACTION` [m]."""
    inradius = float(_sides(outline)[1].min())
    widest = float(diameters.max())
    reachable = polygon_area(outline) * ((inradius - widest / 2) / inradius) ** 2
    volume = float(math.pi / 6 * (diameters**3).sum())
    return volume / (LOOSE_FRACTION * reachable) + 2 * widest


def polygon_area(outline: Array) -> float:
    """Return the area inside a polygon with corners (k, 2), by the shoelace formula [m²].

    Not `pidpanel.geometry.polygon.signed_area`: its sums are rounded otherwise, and a
    chimney that is higher by a last digit makes another packing.

    Examples
    --------
    >>> polygon_area(np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]))
    2.0
    """
    x, y = outline.T
    return float(0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _sides(outline: Array) -> tuple[Array, Array]:
    """Return outward normals (k, 2) of the sides of a convex outline, and distances (k,) [m]."""
    edge = np.roll(outline, -1, axis=0) - outline
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.linalg.norm(edge, axis=1)[:, None]
    return normal, (normal * outline).sum(axis=1)


def scatter(outline: Array, height: float, diameters: Array, rng: np.random.Generator) -> Array:
    """Place spheres at random in a prism of a convex outline without overlap, (n, 3) [m].

    Random sequential addition, the largest first: positions are drawn uniformly over the part of
    the cell that a centre can reach and kept when 1 % clear of all earlier ones. Raises
    `ValueError` if no room was found after three hundred tries per sphere.
    """
    normal, distance = _sides(outline)
    low, high = outline.min(axis=0), outline.max(axis=0)
    order = np.argsort(-diameters, kind="stable")
    size = diameters[order]
    kept = np.empty((len(size), 3))
    n = 0
    for _ in range(300 * len(size)):
        xy = rng.uniform(low, high)
        z = rng.uniform(0.51 * size[n], height - 0.51 * size[n])
        if (normal @ xy > distance - 0.51 * size[n]).any():
            continue
        point = np.array([*xy, z])
        near = np.abs(kept[:n, 2] - z) < 1.01 * size[0]
        gap = 1.01 * (size[:n][near] + size[n]) / 2
        if (((kept[:n][near] - point) ** 2).sum(axis=1) < gap**2).any():
            continue
        kept[n] = point
        n += 1
        if n == len(size):
            return kept[np.argsort(order)]
    raise ValueError(f"{n} of {len(size)} spheres found room in {height:g} m")


def full_count(cell: Index, z: Array, depth: float, diameters: Array) -> int:
    """Return N_full of r = N/N_full: spheres wholly below the lid in the emptiest cell.

    ``cell`` (n,) is the index of each sphere's cell, ``z`` the height of its centre above the floor
    in a bed poured higher than the cell [m].
    """
    inside = z <= depth - diameters / 2
    return int(np.bincount(cell[inside], minlength=int(cell.max()) + 1).min())


def lowest(cell: Index, z: Array, count: int) -> Index:
    """Return the indices of the ``count`` lowest spheres of every cell, sorted by cell and height.

    What remains of a settled bed when its top is taken off is a settled bed, so one pour
    serves every fill fraction.
    """
    order = np.lexsort((z, cell))
    rank = np.concatenate([np.arange(n) for n in np.bincount(cell) if n])
    return order[rank < count]


def deepest_overlap(positions: Array, diameters: Array) -> float:
    """Return the deepest overlap of spheres, centres (n, 3) and diameters (n,) [m]; 0 for none."""
    # neighbours in height, one further at a time; scipy's tree takes half a second to import
    order = np.argsort(positions[:, 2])
    place, radius = positions[order], diameters[order] / 2
    deepest = 0.0
    for further in range(1, len(place)):
        apart = place[further:] - place[:-further]
        near = apart[:, 2] < 2 * radius.max()
        if not near.any():
            break
        overlap = radius[further:] + radius[:-further] - np.sqrt((apart**2).sum(axis=1))
        deepest = max(deepest, float(overlap.max()))
    return deepest


def masses(diameters: Array, density: float) -> Array:
    """Return the mass of each sphere, (n,) [kg]: ρ π d³/6 of diameters [m] and density [kg/m³]."""
    return density * math.pi / 6 * np.asarray(diameters) ** 3
