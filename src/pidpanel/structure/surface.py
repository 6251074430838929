"""Cells of a surface in space: their normals, those of patches, and how they are drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import shapely

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import cell_areas, plane_axes
from pidpanel.panel.basis import PanelBasis

# Area of the smallest rectangle about a surface over that of one along the axes: below it they turn
ALIGNED = 0.99
FILLED = 0.86  # share of it that the hull of a surface fills; a disc fills 0.79, an octagon 0.83


@dataclass(frozen=True)
class Surface:
    """Oriented triangles or quadrilaterals of a surface."""

    vertices: Array  # (n_vertices, 3) [m]
    cells: Index  # (n_cells, 3) or (n_cells, 4) corners; they go round the normal

    @property
    def area(self) -> Array:
        """(n_cells,) [m²]."""
        return cell_areas(self.vertices, self.cells)

    @property
    def cell_normal(self) -> Array:
        """(n_cells, 3) unit normals."""
        a, b, c, d = (self.vertices[self.cells[:, k]] for k in (0, 1, 2, -1))
        normal = np.cross(c - a, d - b)
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    @property
    def vertex_normal(self) -> Array:
        """(n_vertices, 3) unit normals, the mean over the cells at a vertex by area."""
        corners = self.cells.shape[1]
        weighted = np.repeat(self.cell_normal * self.area[:, None], corners, axis=0)
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

    @property
    def has_free_edges(self) -> bool:
        """Whether it is one sheet that ends somewhere, so that air goes around it."""
        start, end = self.cells.ravel(), np.roll(self.cells, -1, axis=1).ravel()
        edges = np.stack([start, end], axis=1)[start != end]
        key, reverse = edges @ [len(self.vertices), 1], edges @ [1, len(self.vertices)]
        return np.unique(key).size == key.size and not np.isin(reverse, key).all()

    def nearest(self, position: Array) -> tuple[int, float]:
        """Return the nearest vertex of the surface, and its distance [m]."""
        used = np.unique(self.cells)
        distance = np.linalg.norm(self.vertices[used] - position, axis=1)
        return int(used[distance.argmin()]), float(distance.min())


def tangential_share(surface: Surface, cells: Index, displacement: Array, mass: Array) -> float:
    """Return the share of the motion along a surface in that of some cells, by its square [1].

    Of modes of equal energy, with displacements (n_vertices, 3, n) and modal masses (n,).
    """
    motion = displacement[surface.cells[cells]]
    normal = np.einsum("ckdn,cd->ckn", motion, surface.cell_normal[cells])
    weight = surface.area[cells][:, None, None] / mass
    total = float(np.sum(weight * np.sum(motion**2, axis=2)))
    return 1 - float(np.sum(weight * normal**2)) / total if total else 0.0


def flattened(basis: PanelBasis) -> PanelBasis:
    """Return a basis as it is drawn: a curved surface projected on `view_axes`."""
    if basis.vertex_position.shape[1] == 2:
        return basis
    axes = view_axes(Surface(basis.vertex_position, basis.cells))
    names = ("vertex_position", "point_position")
    return replace(basis, **{name: getattr(basis, name) @ axes for name in names})


def view_axes(surface: Surface) -> Array:
    """Return the axes (3, 2) of a plane on which most of a surface is seen.

    Against its mean normal; of a closed surface the direction in which it is flattest. They are
    along its sides where it is about a rectangle.
    """
    axes, points = _upright_axes(surface), surface.vertices[np.unique(surface.cells)]
    drawn = points @ axes
    hull = shapely.MultiPoint(drawn).convex_hull
    rectangle = shapely.oriented_envelope(hull)
    is_rectangle = hull.area > FILLED * rectangle.area
    if not is_rectangle or rectangle.area > ALIGNED * np.prod(np.ptp(drawn, axis=0)):
        return axes
    side = np.diff(shapely.get_coordinates(rectangle)[:2], axis=0)[0]
    angle = np.arctan2(side[1], side[0])
    angle -= np.pi / 2 * np.round(angle / (np.pi / 2))  # the least turn
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.asarray(axes @ np.array([[cosine, -sine], [sine, cosine]]))


def _upright_axes(surface: Surface) -> Array:
    """Return the axes (3, 2) of the plane, the first nearest to x."""
    weight = surface.area[:, None]
    mean = (surface.cell_normal * weight).sum(axis=0) / weight.sum()
    if np.linalg.norm(mean) > 0.2:
        return plane_axes(np.where(np.abs(mean) < 1e-9, 0.0, mean))
    offset = surface.middle - (surface.middle * weight).sum(axis=0) / weight.sum()
    return plane_axes(np.linalg.svd(offset * np.sqrt(weight), full_matrices=False)[2][2])
