"""A panel with dampers on places of a grid in place of the patches of its study."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.optimise.places import Places, overlaps_of
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import StoredPlate
from pidpanel.response.panel import ResponsePanel


@dataclass(frozen=True)
class PlacedPanel(ResponsePanel):
    """A panel whose patches are places, which elements need not follow; for rms values and PSDs."""

    place_area: float = 0.0  # of each place [m²]
    # Whether curvatures at the points are computed in addition to the deflection
    with_strains: bool = False

    @cached_property
    def patch_area(self) -> Array:
        """(n_patches,) [m²]."""
        return np.full(len(self.basis.patch_names), self.place_area)

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines for rms values within 1e-3 [Hz]."""
        return self.coarse_frequency

    @cached_property
    def motion_at_points(self) -> Array:
        """(n_points, 1, n): w alone, or (n_points, 6, n) with strains."""
        if not self.with_strains:
            return self.deflection_at_points
        basis, w = self.basis, self.deflection_at_points
        return np.concatenate([w, basis.curvature_at_points, basis.shear_at_points], axis=1)


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
        places, plate.quadrature_position, plate.quadrature_weight, plate.at_quadrature
    )
    patches = dict(zip(map(place_name, numbers), overlap, strict=True))
    return replace(plate, patch_overlap=patches, patch_weight=weight), float(error.max())


def place_basis(basis: PanelBasis, plate: StoredPlate, places: Places) -> PanelBasis:
    """Return the basis of the panel stage with the places of a plate of `place_plate`."""
    shapes = plate.shapes.astype(np.float64)
    reduced = np.array([shapes.T @ (D @ shapes) for D in plate.patch_overlap.values()])
    centre = basis.vertex_position[basis.cells].mean(axis=1)
    return replace(
        basis,
        patch_overlap=(reduced + reduced.swapaxes(1, 2)) / 2,
        patch_names=tuple(plate.patch_overlap),
        cell_in_patch=places.contains(centre),
    )


def place_panel(panel: ResponsePanel, place_area: float, *, with_strains: bool) -> PlacedPanel:
    """Return a panel whose basis has places as patches."""
    values = {item.name: getattr(panel, item.name) for item in fields(ResponsePanel)}
    return PlacedPanel(**values, place_area=place_area, with_strains=with_strains)
