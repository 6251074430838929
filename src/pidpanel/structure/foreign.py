"""A structure with the modes of another solver."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.geometry.orientation import oriented
from pidpanel.modal_files import ModalModel
from pidpanel.modal_files.quadrature import CellQuadrature, node_normals, surface_quadrature
from pidpanel.modal_files.residual import ResidualVectors, residual_vectors
from pidpanel.panel.basis import basis_of
from pidpanel.panel.mesh import PanelMesh
from pidpanel.shell.selections import Place
from pidpanel.structure.any_structure import (
    AnyStructure,
    Observation,
    SolvedStructure,
    StructureRefused,
    SurfaceSection,
    in_plane,
)
from pidpanel.structure.modal_plate import modal_plate, modal_shapes
from pidpanel.structure.surface import Surface

NEAR = 0.02  # largest distance of a point from a node of the surface over its size
MOVED = 1e-3  # such a distance that is stated
# Largest modal mass of a structure over its mass, with max |u| = 1: less or more is another unit.
MODAL_SHARE = (0.01, 1.1)
EFFECTIVE = 1.02  # largest sum of effective masses over the mass


@dataclass(frozen=True)
class ForeignStructure(AnyStructure):
    """A structure with the modes of another solver."""

    model: ModalModel
    mass: float  # [kg]
    groups: tuple[str, ...] = ()  # those that the sound loads; all without any
    outward: Place | None = None  # direction of the normals
    pressures: tuple[str, ...] = ()  # groups under pressure in the static cases

    @cached_property
    def _cells(self) -> tuple[Index, Index]:
        """Cells of the loaded surface (n_cells, 4), all quadrilaterals or all triangles.

        The second array (n_cells,) has the element of each in the file.
        """
        cells, chosen = self.model.cells, np.arange(len(self.model.cells))
        if names := self.groups:
            groups = [self._group(name, ("surface",)) for name in names]
            chosen = np.unique(np.concatenate(groups))
        cells = cells[chosen]
        is_quad = cells[:, 2] != cells[:, 3]
        if not is_quad.all():  # a quadrilateral is divided, a triangle repeats its third corner
            halves = cells[is_quad][:, [0, 2, 3, 3]]
            chosen = np.concatenate([chosen, chosen[is_quad]])
            cells = np.concatenate([cells[:, [0, 1, 2, 2]], halves])
        return cells, chosen

    def _group(self, name: str, keys: tuple[str, ...]) -> Index:
        groups = self.model.groups
        if name not in groups:
            names_text = ", ".join(sorted(groups)[:20]) or "none"
            raise StructureRefused(keys, f"no group {name}; the file has {names_text}")
        return groups[name]

    @cached_property
    def surface(self) -> Surface:
        """The loaded surface, its vertices those of its cells."""
        outward, (cells, _) = self.outward, self._cells
        try:
            cells = oriented(self.model.position, cells, outward)
        except ValueError as error:
            raise StructureRefused(("outward",), str(error)) from error
        number = np.searchsorted(self.nodes, cells)
        is_triangle = (self._cells[0][:, 2] == self._cells[0][:, 3]).all()
        return Surface(self.model.position[self.nodes], number[:, :3] if is_triangle else number)

    @property
    def loaded_cells(self) -> Index:
        """Cells of the loaded surface (n_cells, 4), nodes of the file, as they are numbered."""
        return self._cells[0]

    @cached_property
    def nodes(self) -> Index:
        """(n_vertices,) nodes of the file that are vertices of the surface."""
        return np.unique(self._cells[0])

    @cached_property
    def patches(self) -> dict[str, Index]:
        """Cells of the patches, by name."""
        patches = {}
        for name, area in self.areas.items():
            if isinstance(area, str):
                inside = np.isin(self._cells[1], self._group(area, ("patches", name, "group")))
            else:
                inside = area.contains(self.surface.middle)
            if not inside.any():
                message = "no element of the surface has its middle there"
                raise StructureRefused(("patches", name), message)
            patches[name] = np.flatnonzero(inside)
        return patches

    def _vertex(self, point: Observation, name: str) -> int:
        if point.position is not None:
            vertex, distance = self.surface.nearest(np.array(point.position))
            if distance > NEAR * self.surface.size:
                place = self.surface.vertices[vertex].round(4).tolist()
                message = f"the nearest node of the surface is {distance:.3g} m away, at {place} m"
                raise StructureRefused(("points", name, "at_m"), message)
            return vertex
        match = np.flatnonzero(self.model.node_number[self.nodes] == point.node)
        if not match.size:
            raise StructureRefused(("points", name, "node"), "no node of the loaded surface")
        return int(match[0])

    @cached_property
    def _vertices(self) -> Index:
        """Vertices of the points."""
        return np.array([self._vertex(point, name) for name, point in self.observations.items()])

    @property
    def point_position(self) -> Array:
        """(n_points, 3) [m]."""
        return self.surface.vertices[self._vertices]

    @cached_property
    def _point_direction(self) -> Array:
        """(n_points, 3) unit vectors of the motion at the points."""
        normals = self.vertex_normal[self._vertices]
        directions = [
            normal if point.direction is None else np.array(point.direction)
            for point, normal in zip(self.observations.values(), normals, strict=True)
        ]
        return np.array([direction / np.linalg.norm(direction) for direction in directions])

    @cached_property
    def _curved(self) -> tuple[Array, Index, Index | None]:
        """Vertices, corners (n_cells, 4) and parents of the surface; see `surface_quadrature`."""
        cells, parents = self.surface.cells, self.model.parents
        if parents is not None:
            parents = parents[self._cells[1]]
            parents = np.where(parents < 0, -1, np.searchsorted(self.nodes, parents))
        cells = cells if cells.shape[1] == 4 else cells[:, [0, 1, 2, 2]]
        return self.surface.vertices, cells, parents

    @cached_property
    def _quadrature(self) -> CellQuadrature:
        """Points of the surface."""
        return surface_quadrature(*self._curved)

    @cached_property
    def vertex_normal(self) -> Array:
        """(n_vertices, 3) unit normals."""
        return node_normals(*self._curved)

    @cached_property
    def _shapes(self) -> ResidualVectors:
        """Modes, then residual vectors of static cases, on the vertices of the surface."""
        model, names = self.model, self.pressures
        modes = model.frequency, model.modal_mass, model.displacement[self.nodes]
        cases = model.static_displacement
        if not names:
            return ResidualVectors(*modes)
        if cases.shape[2] != len(names):
            message = f"{len(names)} groups for the {cases.shape[2]} static cases of the file"
            raise StructureRefused(("modes", "pressures"), message)
        quadrature = self._quadrature
        inside = [np.isin(self._cells[1], self._group(n, ("modes", "pressures"))) for n in names]
        pressure = np.array(inside, dtype=float)[:, quadrature.cell].T
        try:
            added = residual_vectors(
                quadrature, *modes, cases[self.nodes], pressure, self.section.mass_per_area
            )
        except ValueError as error:
            raise StructureRefused(("modes", "pressures"), str(error)) from error
        pairs = zip(modes, added, strict=True)
        return ResidualVectors(*(np.concatenate(pair, axis=-1) for pair in pairs))

    def solve(
        self, mesh: PanelMesh, highest: float, damper_mass: dict[str, float]
    ) -> SolvedStructure:
        """Return the basis: all modes of the file, whatever the frequency and the dampers."""
        self._check_mass()
        frequency, mass, displacement = self._shapes
        plate = in_plane(self, modal_plate(
            self.vertex_normal, self._quadrature, displacement, frequency, mass, self.patches,
            self._point_direction, self._vertices,
        ))  # fmt: skip
        is_residual = np.arange(len(frequency)) >= len(self.model.frequency)
        if self.model.participation is not None:
            motion = self._quadrature.values(displacement[..., is_residual])
            added = self.section.mass_per_area * np.tensordot(self._quadrature.weight, motion, 1).T
            values = np.concatenate([self.model.participation, added])
            plate = replace(plate, participation=values, inertia=values[:, 2])
        shapes = modal_shapes(plate, displacement, frequency, is_residual)
        return SolvedStructure(basis_of(mesh, plate, shapes), plate, shapes.vectors, self.mass)

    def check(self, highest: float, damper_mass: dict[str, float] | None = None) -> None:
        """Refuse what cannot be computed (`StructureRefused`)."""
        super().check(highest, damper_mass)
        self._check_mass()
        _ = self._shapes
        if (last := self.model.frequency[-1]) < highest:
            message = f"the modes end at {last:.4g} Hz, below {highest:g} Hz of the response"
            raise StructureRefused(("modes", "file"), message)

    def _check_mass(self) -> None:
        mass, (low, high) = self.mass, MODAL_SHARE
        square = (self.model.displacement**2).sum(axis=1).max(axis=0)
        largest = float(np.max(self.model.modal_mass / square))
        if not low * mass <= largest <= high * mass:
            message = f"the largest modal mass is {largest:.3g} kg where the largest motion is 1; "
            message += f"{low * mass:.3g} to {high * mass:.3g} are allowed. Is the unit of mass kg?"
            raise StructureRefused(("mass_kg",), message)
        if self.model.participation is not None:
            moved = (self.model.participation**2 / self.model.modal_mass[:, None]).sum(axis=0)
            if moved.max() > EFFECTIVE * mass:
                message = f"modes have effective masses of {moved.max():.3g} kg along "
                message += f"{'xyz'[moved.argmax()]}, more than the structure"
                raise StructureRefused(("mass_kg",), message)

    @property
    def fault_of_base_motion(self) -> str:
        """Why a motion of the supports cannot be computed; empty where it can."""
        if self.model.participation is None:
            return "the inertia of its modes is not known; participation in a VTU, or uniform_mass"
        return "a free structure has no supports" if (self.model.frequency == 0).any() else ""

    @property
    def section(self) -> SurfaceSection:
        """Mass per area."""
        return SurfaceSection(self.mass / self.area.area)

    @property
    def first_frequency(self) -> Array:
        """Natural frequencies [Hz]."""
        return self.model.frequency

    @property
    def first_motion(self) -> tuple[Array, Array]:
        """Displacement and mass of the elastic modes."""
        elastic = self.model.frequency > 0
        motion = self.model.displacement[self.nodes][..., elastic]
        return motion, self.model.modal_mass[elastic]

    @property
    def remarks(self) -> list[str]:
        """What of the files is not used or unusual."""
        model = self.model
        remarks = [f"{len(model.frequency)} modes to {model.frequency[-1]:.4g} Hz, {model.source}"]
        remarks += model.remarks
        for name, point, place in zip(
            self.observations, self.observations.values(), self.point_position, strict=True
        ):
            moved = 0.0 if point.position is None else np.linalg.norm(place - point.position)
            if moved > MOVED * self.surface.size:
                remarks.append(f"point {name} is at the nearest node, {1e3 * moved:.2g} mm away")
        if (count := model.static_displacement.shape[2]) and not self.pressures:
            remarks.append(f"{count} static cases without structure.modes.pressures are not used")
        return remarks
