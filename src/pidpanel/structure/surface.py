"""Triangles of a surface in space: its normals, the elements and nodes of patches and points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from shapely import contains_xy, polygons

from pidpanel.arrays import Array, Flags, Index
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.panel.basis import PanelBasis

# Points (3, 3) of the quadrature on a triangle, in its corners: exact for quadratics
BARYCENTRIC = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6


@dataclass(frozen=True)
class Surface:
    """Oriented triangles of a surface."""

    vertices: Array  # (n_vertices, 3) [m]
    cells: Index  # (n_cells, 3) corners; they go round the normal

    @property
    def area(self) -> Array:
        """(n_cells,) [m²]."""
        return cell_areas(self.vertices, self.cells)

    @property
    def cell_normal(self) -> Array:
        """(n_cells, 3) unit normals."""
        a, b, c = (self.vertices[self.cells[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    @property
    def vertex_normal(self) -> Array:
        """(n_vertices, 3) unit normals, the mean over the cells at a vertex by area."""
        weighted = np.repeat(self.cell_normal * self.area[:, None], 3, axis=0)
        total = np.zeros_like(self.vertices)
        np.add.at(total, self.cells.ravel(), weighted)
        length = np.linalg.norm(total, axis=1)[:, None]
        return np.divide(total, length, out=np.zeros_like(total), where=length > 0)

    @property
    def middle(self) -> Array:
        """(n_cells, 3) [m]."""
        return np.asarray(self.vertices[self.cells].mean(axis=1))

    @property
    def size(self) -> float:
        """Largest extent [m]."""
        return float(np.ptp(self.vertices, axis=0).max())

    def in_sphere(self, centre: Array, radius: float) -> Flags:
        """Return (n_cells,) whether the middle of a cell lies in a sphere."""
        return np.asarray(np.linalg.norm(self.middle - centre, axis=1) <= radius)

    def in_box(self, low: Array, high: Array) -> Flags:
        """Return (n_cells,) whether the middle of a cell lies in a box."""
        return np.asarray(((self.middle >= low) & (self.middle <= high)).all(axis=1))

    def in_ring(self, centre: Array, axis: Array, inner: float, outer: float) -> Flags:
        """Return (n_cells,) whether the middle of a cell lies at these distances from an axis."""
        offset, unit = self.middle - centre, axis / np.linalg.norm(axis)
        distance = np.linalg.norm(offset - np.outer(offset @ unit, unit), axis=1)
        return np.asarray((distance >= inner) & (distance <= outer))

    def in_polygon(self, corners: Array, along: Array) -> Flags:
        """Return (n_cells,) whether the middle of a cell lies in a projected polygon."""
        plane = plane_axes(along)
        return np.asarray(contains_xy(polygons(corners @ plane), *(self.middle @ plane).T))

    def nearest(self, position: Array) -> tuple[int, float]:
        """Return the nearest vertex of the surface, and its distance [m]."""
        used = np.unique(self.cells)
        distance = np.linalg.norm(self.vertices[used] - position, axis=1)
        return int(used[distance.argmin()]), float(distance.min())


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


def flattened(basis: PanelBasis) -> PanelBasis:
    """Return a basis as it is drawn: a curved surface projected on `view_axes`."""
    if basis.vertex_position.shape[1] == 2:
        return basis
    axes = view_axes(Surface(basis.vertex_position, basis.cells))
    names = ("vertex_position", "point_position")
    return replace(basis, **{name: getattr(basis, name) @ axes for name in names})


def view_axes(surface: Surface) -> Array:
    """Return the axes (3, 2) of a plane on which most of a surface is seen.

    Against its mean normal; of a closed surface the direction in which it is flattest.
    """
    weight = surface.area[:, None]
    mean = (surface.cell_normal * weight).sum(axis=0) / weight.sum()
    if np.linalg.norm(mean) > 0.2:
        return plane_axes(np.where(np.abs(mean) < 1e-9, 0.0, mean))
    offset = surface.middle - (surface.middle * weight).sum(axis=0) / weight.sum()
    return plane_axes(np.linalg.svd(offset * np.sqrt(weight), full_matrices=False)[2][2])
