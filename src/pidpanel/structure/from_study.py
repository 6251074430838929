"""The structure of a study, or its panel: the one place in `structure` that reads the study."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.modal_files import ModalModel, read_modes
from pidpanel.modal_files.orientation import oriented
from pidpanel.modal_files.quadrature import surface_quadrature
from pidpanel.modal_files.residual import ResidualVectors, residual_vectors
from pidpanel.panel.attachments import Attachment
from pidpanel.panel.basis import PanelBasis, basis_of, face_wavenumber, with_condensed_face
from pidpanel.panel.files import read_basis, read_plate
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.from_study import write_panel as write_flat_panel
from pidpanel.panel.matrices import PlateMatrices, StoredPlate
from pidpanel.panel.mesh import PanelMesh, check_names, write_cells
from pidpanel.panel.supports import Supports
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.shell.selections import Box, Ring, Selection, Sphere
from pidpanel.solve.base_motion import UNIT, Translation
from pidpanel.structure.modal_plate import modal_plate, modal_shapes
from pidpanel.structure.surface import Prism, Surface, plane_axes
from pidpanel.study import Study
from pidpanel.study.panel import Panel
from pidpanel.study.structure import Structure, SurfaceArea, SurfacePoint

FLAT = 1e-4  # largest distance from a plane over the size of a surface that is flat
NEAR = 0.02  # largest distance of a point from the surface over its size
# Largest modal mass of a structure over its mass, with max |w| = 1: less or more is another unit.
MODAL_SHARE = (0.01, 1.1)


class StructureRefused(ValueError):
    """What of a structure cannot be computed, with the way to its key."""

    def __init__(self, keys: tuple[str, ...], message: str) -> None:
        super().__init__(message)
        self.keys = keys


class Extent(NamedTuple):
    """Area of a surface [m²]."""

    area: float


class SurfaceSection(NamedTuple):
    """Mass per area [kg/m²] of a structure, the mean."""

    mass_per_area: float


@dataclass(frozen=True)
class StudiedStructure:
    """A structure with the modes of another solver; it serves as a `StudiedPanel`."""

    structure: Structure

    supports = Supports(outline="free")
    foreign = None

    @cached_property
    def model(self) -> ModalModel:
        """Nodes, elements and modes of the files."""
        modes = self.structure.modes
        try:
            return read_modes(
                modes.file, modes.mesh, modes.unit_m, unit_kg=modes.unit_kg,
                normalised=modes.normalised or "", static=modes.static,
            )  # fmt: skip
        except ValueError as error:
            raise StructureRefused(("modes", "file"), str(error)) from error

    @cached_property
    def _cells(self) -> tuple[Index, Index]:
        """Cells of the loaded surface (n_cells, 4), all quadrilaterals or all triangles.

        The second array (n_cells,) has the element of each in the file.
        """
        cells, chosen = self.model.cells, np.arange(len(self.model.cells))
        if names := self.structure.surface:
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
            known = ", ".join(sorted(groups)[:20]) or "none"
            raise StructureRefused(keys, f"no group {name}; the file has {known}")
        return groups[name]

    @cached_property
    def surface(self) -> Surface:
        """The loaded surface, its vertices those of its cells."""
        outward = self.structure.outward
        try:
            cells = oriented(self.model.position, self._cells[0], outward and np.array(outward))
        except ValueError as error:
            raise StructureRefused(("outward",), str(error)) from error
        number = np.searchsorted(self._nodes, cells)
        is_triangle = (self._cells[0][:, 2] == self._cells[0][:, 3]).all()
        return Surface(self.model.position[self._nodes], number[:, :3] if is_triangle else number)

    @cached_property
    def _nodes(self) -> Index:
        """(n_vertices,) nodes of the file that are vertices of the surface."""
        return np.unique(self._cells[0])

    @cached_property
    def plane(self) -> tuple[Array, Array] | None:
        """Origin (3,) and axes (3, 2) of the plane of a flat surface; None of a curved one."""
        surface = self.surface
        normal = surface.cell_normal[0]
        offset = (surface.vertices - surface.vertices[0]) @ normal
        if np.ptp(offset) > FLAT * surface.size or (surface.cell_normal @ normal).min() < 0:
            return None
        axes = plane_axes(normal)
        low = (surface.vertices @ axes).min(axis=0)
        return axes @ low + normal * (surface.vertices[0] @ normal), axes

    def _placed(self, position: Array) -> Array:
        """Return positions in the plane of a flat surface, or as they are."""
        if self.plane is None:
            return position
        origin, axes = self.plane
        return np.asarray((position - origin) @ axes)

    @cached_property
    def patches(self) -> dict[str, Index]:
        """Cells of the patches, by name."""
        patches = {}
        for name, area in self.structure.patches.items():
            cells = np.flatnonzero(self._is_in(area, name))
            if not cells.size:
                message = "no element of the surface has its middle there"
                raise StructureRefused(("patches", name), message)
            patches[name] = cells
        return patches

    def _is_in(self, area: SurfaceArea, name: str) -> Flags:
        if area.group is not None:
            return np.isin(self._cells[1], self._group(area.group, ("patches", name, "group")))
        return selection_of(area).contains(self.surface.middle)

    def _vertex(self, point: SurfacePoint, name: str) -> int:
        if point.node is None:
            vertex, distance = self.surface.nearest(np.array(point.at_m))
            if distance > NEAR * self.surface.size:
                place = self.surface.vertices[vertex].round(4).tolist()
                message = f"{distance:.3g} m off the surface; the nearest node is at {place} m"
                raise StructureRefused(("points", name, "at_m"), message)
            return vertex
        match = np.flatnonzero(self.model.node_number[self._nodes] == point.node)
        if not match.size:
            raise StructureRefused(("points", name, "node"), "no node of the loaded surface")
        return int(match[0])

    @cached_property
    def points(self) -> dict[str, int]:
        """Vertices of the response points, by name."""
        return {name: self._vertex(point, name) for name, point in self.structure.points.items()}

    @cached_property
    def _point_direction(self) -> Array:
        """(n_points, 3) unit vectors of the motion at the points."""
        normals, points = self.surface.vertex_normal, self.structure.points.values()
        directions = [
            normals[vertex] if point.direction is None else np.array(point.direction)
            for point, vertex in zip(points, self.points.values(), strict=True)
        ]
        return np.array([direction / np.linalg.norm(direction) for direction in directions])

    @cached_property
    def _shapes(self) -> ResidualVectors:
        """Modes, then residual vectors of static cases, on the vertices of the surface."""
        model, names = self.model, self.structure.modes.pressures
        modes = model.frequency, model.modal_mass, model.displacement[self._nodes]
        cases = model.static_displacement
        if not names:
            return ResidualVectors(*modes)
        if cases.shape[2] != len(names):
            message = f"{len(names)} groups for the {cases.shape[2]} static cases of the file"
            raise StructureRefused(("modes", "pressures"), message)
        cells = self.surface.cells
        quadrature = surface_quadrature(
            self.surface.vertices, cells if cells.shape[1] == 4 else cells[:, [0, 1, 2, 2]]
        )
        inside = [np.isin(self._cells[1], self._group(n, ("modes", "pressures"))) for n in names]
        pressure = np.array(inside, dtype=float)[:, quadrature.cell].T
        try:
            added = residual_vectors(
                quadrature, *modes, cases[self._nodes], pressure, self.section.mass_per_area
            )
        except ValueError as error:
            raise StructureRefused(("modes", "pressures"), str(error)) from error
        pairs = zip(modes, added, strict=True)
        return ResidualVectors(*(np.concatenate(pair, axis=-1) for pair in pairs))

    def mesh(self, path: Path) -> PanelMesh:
        """Write the surface to a ``.msh`` file, and return it with patches and points."""
        check_names(self.structure.patches, self.structure.points)
        vertices = self._placed(self.surface.vertices)
        points = {name: tuple(vertices[vertex].tolist()) for name, vertex in self.points.items()}
        kind = "triangles" if self.surface.cells.shape[1] == 3 else "quadrilaterals"
        mesh = PanelMesh(vertices, self.surface.cells, kind, self.patches, points)
        write_cells(path, mesh)
        return mesh

    def plate(self) -> PlateMatrices:
        """Return the matrices of the modes and residual vectors."""
        shapes, points = self._shapes, np.array(list(self.points.values()), dtype=np.int64)
        plate = modal_plate(
            self.surface, shapes.displacement, shapes.frequency, shapes.modal_mass,
            self.patches, self._point_direction, points,
        )  # fmt: skip
        if self.plane is None:
            return plate
        position = self._placed(plate.quadrature_position)
        return replace(plate, quadrature_position=position, quadrature_normal=None)

    def basis(self, mesh: PanelMesh) -> tuple[PanelBasis, PlateMatrices, Array]:
        """Return the basis, the matrices and the shapes (n, n) of the modes."""
        self._check_mass()
        plate, (frequency, _, displacement) = self.plate(), self._shapes
        is_residual = np.arange(len(frequency)) >= len(self.model.frequency)
        shapes = modal_shapes(plate, displacement, frequency, is_residual)
        return basis_of(mesh, plate, shapes), plate, shapes.vectors

    def _check_mass(self) -> None:
        mass, (low, high) = self.structure.mass_kg, MODAL_SHARE
        square = (self.model.displacement**2).sum(axis=1).max(axis=0)
        largest = float(np.max(self.model.modal_mass / square))
        if not low * mass <= largest <= high * mass:
            message = f"the largest modal mass is {largest:.3g} kg where the largest motion is 1; "
            message += f"{low * mass:.3g} to {high * mass:.3g} are allowed. Is the unit of mass kg?"
            raise StructureRefused(("mass_kg",), message)

    def check(self, _frequency: float, _damper_mass: object = None) -> None:
        """Refuse what cannot be computed (`StructureRefused`)."""
        try:
            check_names(self.structure.patches, self.structure.points)
        except ValueError as error:
            raise StructureRefused(("points",), str(error)) from error
        _ = self.patches, self.points
        with tempfile.TemporaryDirectory() as folder:
            self.basis(self.mesh(Path(folder) / "mesh.msh"))

    @property
    def section(self) -> SurfaceSection:
        """Mass per area."""
        return SurfaceSection(self.structure.mass_kg / self.area.area)

    @property
    def area(self) -> Extent:
        """Area of the loaded surface."""
        return Extent(float(self.surface.area.sum()))

    @property
    def attachments(self) -> dict[str, Attachment]:
        """None: masses and springs are in the modes."""
        return {}

    @property
    def remarks(self) -> list[str]:
        """What of the files is not used or unusual."""
        model, modes = self.model, self.structure.modes
        remarks = [f"{len(model.frequency)} modes to {model.frequency[-1]:.4g} Hz, {model.source}"]
        if (count := model.static_displacement.shape[2]) and not modes.pressures:
            remarks.append(f"{count} static cases without structure.modes.pressures are not used")
        return remarks

    def wave_shift(self, *_: float, strain: object = None) -> float:
        """Return 0: what the mesh of another solver does to its modes is not known."""
        return 0.0

    def point_refinement_error(self, _highest: float) -> float:
        """Return 0, likewise."""
        return 0.0


def with_normals(section: Structure) -> Structure:
    """Return the structure with the normals of its patches."""
    if not section.patches:
        return section
    structure = StudiedStructure(section)
    vectors = structure.surface.cell_normal * structure.surface.area[:, None]
    patches = {}
    for name, area in section.patches.items():
        mean = vectors[structure.patches[name]].sum(axis=0)
        unit = (mean / np.linalg.norm(mean)).round(3) + 0.0
        normal = area.normal or tuple(unit.tolist())
        patches[name] = area.model_copy(update={"normal": normal})
    return section.model_copy(update={"patches": patches})


AnyPanel = StudiedPanel | StudiedStructure


def studied(section: Panel | Structure) -> AnyPanel:
    """Return the panel or the structure of a study."""
    return StudiedStructure(section) if isinstance(section, Structure) else StudiedPanel(section)


def selection_of(area: SurfaceArea) -> Selection:
    """Return the part of space that an area without a group is."""
    if area.radius_m is not None and area.centre_m is not None:
        return Sphere(area.centre_m, area.radius_m)
    if area.radii_m is not None and area.centre_m is not None and area.along is not None:
        return Ring(*area.radii_m, area.centre_m, area.along)
    if area.corners_m is not None and area.along is not None:
        return Prism(area.corners_m, area.along)
    if area.from_m is not None and area.to_m is not None:
        return Box(area.from_m, area.to_m)
    raise ValueError("an area with a group is no part of space")


def write_panel(study: Study, output: Files) -> None:
    """Write the files of the panel stage: modes, table, shapes, mesh, section and plate.

    Raises
    ------
    ValueError
        If the panel or the structure is refused.
    """
    if isinstance(study.panel, Panel):
        write_flat_panel(study, study.panel, output)
        return
    # a check needs neither pandas nor xarray
    from pidpanel.panel import tables
    from pidpanel.panel.files import write_basis, write_plate, write_shapes

    structure = StudiedStructure(study.panel)
    mesh = structure.mesh(output.mesh)
    basis, plate, vectors = structure.basis(mesh)
    write_plate(output.plate, plate.with_shapes(vectors), stamp(study))
    highest = study.response.frequency_hz[1]
    wavenumber = face_wavenumber(basis, 2 * np.pi * highest / study.wave_speed)
    write_basis(output.modes, with_condensed_face(basis, wavenumber), stamp(study))
    write_shapes(output.shapes, basis)
    modes = tables.mode_table(basis, None, None)
    modes.to_csv(output.table, index=False, float_format="%.8g")
    area = structure.area.area
    section = tables.section_table(structure.section.mass_per_area, area)
    section.to_csv(output.section, index=False, float_format="%.8g")


def read_moved_panel(study: Study, files: Files) -> tuple[PanelBasis, StoredPlate, Translation]:
    """Read basis and plate, and what the translation of the supports moves.

    Raises
    ------
    ValueError
        If nothing is known of the inertia of a structure.
    """
    basis, plate = read_basis(files.modes), read_plate(files.plate)
    if plate.participation is None:
        return basis, plate, UNIT
    direction = np.array((study.base and study.base.direction) or (0.0, 0.0, 1.0))
    direction = direction / np.linalg.norm(direction)
    surface = Surface(basis.vertex_position, basis.cells)
    translation = Translation(
        plate.point_direction @ direction,
        surface.vertex_normal @ direction,
        plate.quadrature_normal @ direction,
    )
    return basis, replace(plate, inertia=plate.participation @ direction), translation
