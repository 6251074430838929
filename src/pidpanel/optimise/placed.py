"""A panel with dampers on places of a grid in place of the patches of its study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.optimise.places import Places, overlaps_of
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.response.panel import ResponsePanel


@dataclass(frozen=True)
class PlacedPanel(ResponsePanel):
    """A panel whose patches are places, which elements need not follow; for rms values and PSDs.

    Parameters
    ----------
    place_area
        Of each place [m²].
    with_strains
        Whether curvatures at the points are looked at beside the deflection.
    """

    place_area: float = 0.0
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


def placed(
    panel: ResponsePanel,
    plate: StoredPlate,
    places: Places,
    names: Sequence[str],
    *,
    with_strains: bool = False,
) -> tuple[PlacedPanel, StoredPlate, float]:
    """Return a panel and its plate with places as patches.

    Returns
    -------
    panel, plate
        In the basis of the panel stage.
    area_error
        Largest relative error of the area of a place on the mesh, before it is scaled.
    """
    overlap, error = overlaps_of(
        places, plate.quadrature_position, plate.quadrature_weight, plate.at_quadrature
    )
    shapes = plate.shapes.astype(np.float64)
    reduced = np.array([shapes.T @ (D @ shapes) for D in overlap])
    basis = panel.basis
    centre = basis.vertex_position[basis.cells].mean(axis=1)
    basis = replace(
        basis,
        patch_overlap=(reduced + reduced.swapaxes(1, 2)) / 2,
        patch_names=tuple(names),
        cell_in_patch=places.contains(centre),
    )
    values = {item.name: getattr(panel, item.name) for item in fields(ResponsePanel)}
    return (
        PlacedPanel(
            **{**values, "basis": basis}, place_area=places.area, with_strains=with_strains
        ),
        replace(plate, patch_overlap=dict(zip(names, overlap, strict=True))),
        float(error.max()),
    )
