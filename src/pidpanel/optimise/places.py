"""A grid of rectangular patches that dampers may fill, in place of the patches of a study."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array, Flags, Index
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import on_patch
from pidpanel.response.panel import ResponsePanel
from pidpanel.structure.surface import Surface, flattened

SLACK = 1e-6  # of the size of a place: rounding of its edges
FACING = 0.1  # least cosine of a surface that is seen, between its normal and the view
TWICE = 1.5  # of the area of a place: more of the surface lies in it, one part behind another

MOST_PLACES = 4000  # of a grid: two places have a flag whether they overlap


class NoPlace(ValueError):
    """No place of a damper fits on the panel, or more do than can be searched."""


@dataclass(frozen=True)
class Places:
    """Places of dampers, in the plane of a panel or of the view of a curved surface.

    They are rectangles, or patches of the study, of which rectangles are the extents.
    """

    lower: Array  # (n_places, 2) lower left corners [m]
    size: Array  # (n_places, 2) lengths along x and y [m]
    # (n_places,) groups of places that all overlap each other: a layout fills one of a group
    group: Index
    axes: Array | None = None  # (3, 2) of the view of a curved surface
    names: tuple[str, ...] = ()  # of patches
    cells: Flags | None = None  # (n_places, n_cells) those of patches

    @property
    def area(self) -> Array:
        """(n_places,) areas of the rectangles in their plane [m²]."""
        return self.size.prod(axis=1)

    @property
    def centre(self) -> Array:
        """(n_places, 2) [m]."""
        return self.lower + self.size / 2

    @cached_property
    def overlap(self) -> Flags:
        """(n_places, n_places) whether two places have cells in common."""
        if self.cells is not None:
            return self.cells @ self.cells.T
        distance = np.abs(self.lower[:, None] - self.lower)
        return np.asarray(np.all(distance < self.size * (1 - SLACK), axis=2))

    def cosine(self, normal: Array | None) -> Array:
        """Return the cosine (n,) or (1,) of normals (n, 3) with the view; 1 on a panel."""
        if self.axes is None or normal is None:
            return np.ones(1)
        return np.asarray(normal @ np.cross(*self.axes.T))

    def contains(self, position: Array, normal: Array | None = None) -> Flags:
        """Return (n_places, n) whether positions [m] lie within each place, and are seen.

        Of patches, whether cells do, or as many positions in each cell.
        """
        if self.cells is not None:
            return np.repeat(self.cells, len(position) // self.cells.shape[1], axis=1)
        if self.axes is not None:
            position = position @ self.axes
        inside = np.empty((len(self.lower), len(position)), np.bool_)
        for place, (lower, size) in enumerate(zip(self.lower, self.size, strict=True)):
            from_corner = position - lower
            inside[place] = np.all((from_corner > 0) & (from_corner < size), axis=1)
        return inside & (self.cosine(normal) > FACING)

    def subset(self, index: Index) -> Places:
        """Return some of the places."""
        return replace(
            self,
            lower=self.lower[index],
            size=self.size[index],
            group=self.group[index],
            names=tuple(self.names[k] for k in index) if self.names else (),
            cells=None if self.cells is None else self.cells[index],
        )


def listed_places(basis: PanelBasis, names: Sequence[str]) -> Places:
    """Return patches of a basis as places."""
    drawn = flattened(basis)
    cells = np.array([basis.cell_in_patch[basis.patch_names.index(name)] for name in names])
    corners = [drawn.vertex_position[basis.cells[inside]].reshape(-1, 2) for inside in cells]
    lower = np.array([corner.min(axis=0) for corner in corners])
    size = np.array([np.ptp(corner, axis=0) for corner in corners])
    return Places(lower, size, np.arange(len(names)), names=tuple(names), cells=cells)


def places_on(
    area: BaseGeometry,
    size: tuple[float, float],
    spacing: tuple[float, float],
    obstacles: Iterable[BaseGeometry],
    axes: Array | None = None,
) -> Places:
    """Return the places of a grid that lie on a panel and meet no obstacle.

    The grid begins at the lower left corner of the rectangle about the panel. Raises `NoPlace` if
    there is no such place.

    Parameters
    ----------
    area
        Area of the panel without its holes [m].
    size, spacing
        Size and spacing of the places along x and y [m].
    obstacles
        Areas without dampers, which places may touch along an edge [m].
    axes
        Axes (3, 2) of the view of a curved surface; the other arguments are as it is seen.
    """
    x0, y0, x1, y1 = area.bounds
    counts = [
        int(np.floor((extent - length) / step + SLACK)) + 1
        for extent, length, step in zip((x1 - x0, y1 - y0), size, spacing, strict=True)
    ]
    if np.prod(counts) > MOST_PLACES:
        message = f"with optimise.spacing_m makes {np.prod(counts)} places; allowed are "
        raise NoPlace(f"{message}{MOST_PLACES}")
    if min(counts) < 1:
        raise NoPlace(f"larger than the panel, {x1 - x0:g} m × {y1 - y0:g} m")
    column, row = (grid.ravel() for grid in np.meshgrid(*map(np.arange, counts), indexing="ij"))
    lower = np.array([x0, y0]) + np.stack([column, row], axis=1) * np.array(spacing)
    slack = SLACK * min(size)
    inner = shapely.box(*(lower + slack).T, *(lower + np.array(size) - slack).T)
    blocked = shapely.union_all(list(obstacles))
    free = shapely.covers(area, inner) & ~shapely.intersects(blocked, inner)
    if not free.any():
        raise NoPlace("no place on the panel is free of supports, masses and forbidden areas")
    # places less than a length apart overlap: as many columns and rows share a group
    across = [
        max(int(np.ceil(length / step - SLACK)), 1)
        for length, step in zip(size, spacing, strict=True)
    ]
    _, group = np.unique(
        np.stack([column // across[0], row // across[1]])[:, free], axis=1, return_inverse=True
    )
    sizes = np.full((np.count_nonzero(free), 2), size)
    return Places(lower[free], sizes, group.ravel(), axes)


def overlaps_of(
    places: Places,
    position: Array,
    weight: Array,
    at_points: sp.csr_array,
    normal: Array | None = None,
) -> tuple[sp.csr_array, list[sp.csr_array], Array]:
    """Return weights and D of each place on all elements, and how well the mesh follows it.

    An element is weighted by its quadrature points (n, 2) or (n, 3) in the place; the sum, as it is
    seen, is scaled to the area. Weights over the places are (n_places, n) [m²], 0 outside, D
    (n_free, n_free) [m²], and the relative errors of the areas before they are scaled (n_places,).
    """
    inside = sp.csr_array(places.contains(position, normal))
    total = inside @ (weight * places.cosine(normal))
    if not total.all():
        raise NoPlace("smaller than the elements of the mesh")
    if places.axes is not None and (total > TWICE * places.area).any():
        raise NoPlace("one part of the surface lies behind another in the view")
    area = places.area if places.cells is None else total
    scale = sp.diags_array(area / total)
    place_weight = sp.csr_array(scale @ inside @ sp.diags_array(weight))
    overlap = []
    for begin, end in itertools.pairwise(place_weight.indptr.tolist()):
        rows = at_points[place_weight.indices[begin:end]]
        scaled = sp.diags_array(place_weight.data[begin:end])
        overlap.append(sp.csr_array(rows.T @ scaled @ rows))
    return place_weight, overlap, np.abs(total / area - 1)


@dataclass(frozen=True)
class PlacedPanel(ResponsePanel):
    """A panel whose patches are places, which elements need not follow; for rms values and PSDs."""

    place_area: Array | float = 0.0  # of each place on the surface [m²]
    # Whether curvatures at the points are computed in addition to the deflection
    with_strains: bool = False

    @cached_property
    def patch_area(self) -> Array:
        """(n_patches,) [m²]."""
        return np.broadcast_to(self.place_area, len(self.basis.patch_names))

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines for rms values within 1e-3 [Hz]."""
        return self.coarse_frequency

    @cached_property
    def motion_at_points(self) -> Array:
        """(n_points, 1, n): w alone, or (n_points, 6, n) with strains."""
        return super().motion_at_points if self.with_strains else self.deflection_at_points


def with_points(basis: PanelBasis, vertices: Index) -> PanelBasis:
    """Return a basis with some vertices as further points, after the response points."""

    def joined(at_points: Array, at_vertices: Array) -> Array:
        return np.concatenate([at_points, at_vertices[vertices]])

    return replace(
        basis,
        point_names=(*basis.point_names, *(f"vertex {vertex}" for vertex in vertices.tolist())),
        point_position=joined(basis.point_position, basis.vertex_position),
        shape_at_points=joined(basis.shape_at_points, basis.shape_at_vertices),
        curvature_at_points=joined(basis.curvature_at_points, basis.curvature_at_vertices),
        shear_at_points=joined(basis.shear_at_points, basis.shear_at_vertices),
    )


def plate_with_points(plate: StoredPlate, vertices: Index) -> StoredPlate:
    """Return the matrices with the points of `with_points`."""
    at_vertices = plate.at_vertices.tocsr()[vertices]
    weight = sp.eye_array(plate.at_vertices.shape[0], format="csr")[vertices]
    return replace(
        plate,
        at_points=sp.csr_array(sp.vstack([plate.at_points, at_vertices])),
        point_weight=sp.csr_array(sp.vstack([plate.point_weight, weight])),
    )


def place_name(number: int) -> str:
    """Return the name of a place as a patch."""
    return f"place {number}"


def place_plate(
    plate: StoredPlate, places: Places, numbers: Iterable[int]
) -> tuple[StoredPlate, float]:
    """Return a plate with numbered places as patches, and the largest error of their areas.

    That error is relative, and before the areas are scaled.
    """
    weight, overlap, error = overlaps_of(
        places, plate.quadrature_position, plate.quadrature_weight, plate.at_quadrature,
        plate.quadrature_normal,
    )  # fmt: skip
    patches = dict(zip(map(place_name, numbers), overlap, strict=True))
    placed = replace(plate, patch_overlap=patches, patch_weight=weight, patch_translation=None)
    return placed, float(error.max())


def place_basis(basis: PanelBasis, plate: StoredPlate, places: Places) -> PanelBasis:
    """Return the basis of the panel stage with the places of a plate of `place_plate`."""
    n = plate.shapes.shape[1]
    reduced = np.empty((len(plate.patch_overlap), n, n))
    for matrix, overlap in zip(reduced, plate.patch_overlap.values(), strict=True):
        _, D, shapes = on_patch(overlap, plate.shapes)
        square = shapes.T @ (D @ shapes)
        matrix[:] = (square + square.T) / 2
    centre = basis.vertex_position[basis.cells].mean(axis=1)
    curved = places.axes is not None
    normal = Surface(basis.vertex_position, basis.cells).cell_normal if curved else None
    return replace(
        basis,
        patch_overlap=reduced,
        patch_names=tuple(plate.patch_overlap),
        cell_in_patch=places.contains(centre, normal),
    )


def place_panel(panel: ResponsePanel, plate: StoredPlate, *, with_strains: bool) -> PlacedPanel:
    """Return a panel whose basis has the places of a plate of `place_plate` as patches."""
    values = {item.name: getattr(panel, item.name) for item in fields(ResponsePanel)}
    return PlacedPanel(**values, place_area=place_areas(plate), with_strains=with_strains)


def place_areas(plate: StoredPlate) -> Array:
    """Return the areas (n_places,) [m²] of the places of a plate of `place_plate`."""
    if plate.patch_weight is None:
        raise ValueError("a plate without places")
    return np.asarray(plate.patch_weight.sum(axis=1))
