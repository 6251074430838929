"""The panel of a study: the one place in `panel` that reads the section ``panel``."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.polygon import Position, Shape, check_panel, signed_area
from pidpanel.panel import checks, supports
from pidpanel.panel import section as sections
from pidpanel.panel.attachments import Attachment, with_attachments
from pidpanel.panel.flat_mesh import FlatMesh
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.grid import grid_lines, mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh, check_names, write_cells
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.nastran import read_nastran
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.resolution import ElementKind, Region, element_sizes
from pidpanel.panel.stretching import check_edges
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles, rim_size
from pidpanel.study.panel import EXTENT, MOST_ELEMENTS, Panel
from pidpanel.study.section import (
    MaterialInput,
    SandwichSectionInput,
    SolidSectionInput,
    ThinSectionInput,
)
from pidpanel.study.supports import Node

# Elements across a panel that is narrower than its elements should be long.
ELEMENTS_ACROSS = 2


def _material(spec: MaterialInput) -> sections.Material:
    E, nu = spec.youngs_modulus, spec.poissons_ratio
    if E is not None and nu is not None:
        return sections.Material.isotropic(E, nu, spec.density_kg_m3)
    return sections.Material(spec.e1, spec.e2, spec.g12, spec.nu12 or 0.0, spec.density_kg_m3)


def section_of(
    spec: ThinSectionInput | SolidSectionInput | SandwichSectionInput,
) -> sections.Section:
    """Return a section in SI units."""
    if spec.kind == "thin":
        return sections.ThinSection(*spec.properties)
    if spec.kind == "solid":
        return sections.SolidSection(*spec.properties)
    materials = {name: _material(material) for name, material in spec.all_materials.items()}
    top, bottom = (
        tuple(sections.Ply(materials[ply.material], ply.thickness, ply.angle) for ply in plies)
        for plies in (spec.plies("top"), spec.plies("bottom"))
    )
    core = sections.Core(*spec.core.properties, spec.core.thickness, spec.core.ribbon)
    factors = spec.bending_factor, spec.shear_factor
    return sections.SandwichSection(top, bottom, core, spec.extra_mass_per_area_kg_m2, *factors)


@dataclass(frozen=True)
class StudiedPanel:
    """A panel with the positions of everything on it, before or after it is meshed."""

    panel: Panel  # the section ``panel`` of a study

    @cached_property
    def foreign(self) -> FlatMesh | None:
        """The mesh of a file; None where the panel is meshed here."""
        spec = self.panel.mesh
        if spec.kind != "file":
            return None
        if spec.file.suffix.lower() == ".msh":
            mesh = read_gmsh(spec.file, spec.unit_m)
        else:
            mesh = read_nastran(spec.file, spec.ignore, spec.unit_m, spec.groups)
        if message := EXTENT.refuses(extent := float(np.ptp(mesh.position, axis=0).max())):
            raise ValueError(
                f"{spec.file}: extends over {extent:g} m with unit_m = {spec.unit_m:g}; {message}"
            )
        if (count := len(mesh.triangles) * 4**spec.refine) > MOST_ELEMENTS:
            raise ValueError(
                f"{spec.file}: {count:.3g} elements with mesh.refine = {spec.refine}; allowed are"
                f" {MOST_ELEMENTS}"
            )
        return mesh.refined(spec.refine)

    @cached_property
    def section(self) -> sections.Section:
        """The section of the whole panel, in SI units."""
        return section_of(self.panel.section)

    @cached_property
    def patches(self) -> dict[str, Shape | str]:
        """The patches by name: shapes [m], or groups of the mesh file."""
        return {name: p.shape or str(p.group) for name, p in self.panel.patches.items()}

    @cached_property
    def shapes(self) -> dict[str, Shape]:
        """The patches that have a shape."""
        return {name: shape for name, shape in self.patches.items() if not isinstance(shape, str)}

    @cached_property
    def points(self) -> dict[str, Position]:
        """The response points by name [m]."""
        return {
            name: self._place(None, place.grid) if isinstance(place, Node) else place
            for name, place in self.panel.points.items()
        }

    @cached_property
    def supports(self) -> supports.Supports:
        """The supports of edges, the hinges and the hold-downs."""
        inputs = self.panel.support_input
        return supports.Supports(
            inputs.outline,
            inputs.holes,
            [
                supports.EdgeSupport(
                    edge.from_m, edge.to_m, edge.kind, edge.rotational_stiffness_n_rad
                )
                for edge in inputs.edges
            ],
            {
                name: supports.PointSupport(self._place(p.at_m, p.grid), p.kind, p.radius_m)
                for name, p in inputs.points.items()
                if p.kind != "spring"
            },
            inputs.rotational_stiffness_n_rad,
        )

    @cached_property
    def attachments(self) -> dict[str, Attachment]:
        """The springs and masses by name."""
        attachments = {
            name: Attachment((self._place(p.at_m, p.grid),), stiffness=p.stiffness_n_m)
            for name, p in self.panel.support_input.points.items()
            if p.stiffness_n_m is not None
        }
        for name, mass in self.panel.masses.items():
            if mass.from_m is not None and mass.to_m is not None:
                ends: tuple[Position, ...] = (mass.from_m, mass.to_m)
            else:
                ends = (self._place(mass.at_m, mass.grid),)
            attachments[name] = Attachment(ends, mass.mass_kg)
        return attachments

    @property
    def elements(self) -> ElementKind:
        """The elements by the kind of the section and their shape."""
        shape = self.panel.mesh.kind.replace("file", "triangles")
        return ElementKind(f"{self.panel.section.kind} {shape}", self.section)

    @property
    def navier_size(self) -> tuple[float, float] | None:
        """Edge lengths [m] where Navier's closed form holds; None elsewhere."""
        inputs = self.panel.support_input
        plain = inputs.outline == "simply_supported" and not (inputs.edges or inputs.points)
        held = self.attachments or self.supports.has_springs
        return self.panel.size if plain and not held else None

    @cached_property
    def area(self) -> BaseGeometry:
        """The area of the panel without its holes [m]."""
        if self.foreign is not None:
            return checks.area_of(self.foreign.panel_mesh({}, {}))
        return checks.area_within(self._outline, self._holes.values())

    @property
    def remarks(self) -> list[str]:
        """What of a mesh file is not used or unusual, and the free edges within its outline."""
        return checks.file_remarks(self.foreign, self.area, self.supports.holes)

    @property
    def wave_shift(self) -> Callable[[float, float, float], float]:
        """`ElementKind.frequency_shift` of edges [m], frequencies [Hz] and added masses [kg/m²]."""
        return partial(self.elements.frequency_shift, **self.rough)

    def point_refinement_error(self, highest: float) -> Array:
        """Return `checks.point_refinement_error` of the response points; masses at a frequency."""
        return checks.point_refinement_error(
            float(np.sqrt(self.area.area)) / 2,
            checks.resistances(self.supports, self.attachments, self.section, highest),
            self.section,
            self.points.values(),
            lambda place: self._size_at(place, 0.0) if self.foreign else self._element_size,
        )

    def cause_of_shift(self, edge: float, frequency: float) -> str:
        """Return the largest of `ElementKind.frequency_shifts` on the panel without dampers."""
        shifts = self.elements.frequency_shifts(edge, frequency, strain=None, **self.rough)
        return max(shifts, key=shifts.__getitem__)

    @property
    def obstacles(self) -> list[BaseGeometry]:
        """Outlines of point supports with their feet, springs and masses on the panel [m]."""
        parts = [shapely.Polygon(foot.corners) for foot in self._feet.values()]
        parts += [shapely.Point(point.position) for point in self.supports.points.values()]
        return parts + [checks.geometry_of(part) for part in self.attachments.values()]

    def check(self, frequency: float, damper_mass: Mapping[str, float] | None = None) -> None:
        """Refuse what cannot be meshed or assembled, or is too coarse for a frequency [Hz].

        ``damper_mass`` has the heaviest damper of each patch by name [kg/m²]. Raises `ValueError`
        with one line: what is wrong and what is allowed.
        """
        spec, mesh = self.panel.mesh, None
        check_names(self.patches, self.points)
        if self.foreign is not None:
            mesh = self.foreign.panel_mesh(self.patches, self.points, self._anchors)
        elif spec.kind == "quadrilaterals":
            grid_lines(self._size, spec.elements, self.shapes, self._anchors)
        else:
            places = {**self.points, **self._anchors, **self._attached}
            check_panel(self._outline, self._holes, {**self.shapes, **self._feet}, places)
        checks.check_fit(self.area, self.supports, self.attachments, self.points)
        check_edges(self.section, is_held=self.panel.in_plane_edges == "held")
        if mesh is None:
            checks.check_feet(self.area, self.supports)
        else:
            checks.check_held(mesh, self.supports)
            checks.check_foot_areas(mesh, self.supports)
        ratio = self.panel.modal_damping.smallest(0.0, frequency)
        try:
            self.elements.check(self.regions(frequency, damper_mass or {}), frequency, ratio)
        except ValueError as error:
            if self.foreign is None:
                raise
            raise ValueError(f"{error} (mesh.refine divides the elements of a file)") from error

    def regions(self, frequency: float, damper_mass: Mapping[str, float]) -> list[Region]:
        """Return the panel without dampers, and the patches with theirs; parameters of `check`."""
        if self.foreign is None:
            edge, areas = self._element_size, self._areas
            edges = dict.fromkeys(self.shapes, edge) | self.patch_sizes(frequency, damper_mass)
        else:
            mesh = self.foreign.panel_mesh(self.patches, {})
            length = element_sizes(mesh.vertices, mesh.cells)
            area_of_cell, edge = cell_areas(mesh.vertices, mesh.cells), float(length.max())
            edges = {name: float(length[cells].max()) for name, cells in mesh.patch_cells.items()}
            areas = {name: area_of_cell[cells].sum() for name, cells in mesh.patch_cells.items()}
            areas[""] = area_of_cell.sum()
        mass = {name: value for name, value in damper_mass.items() if value > 0}
        bare_area = max(areas[""] - sum(areas[name] for name in mass), 0.0)
        loaded = (Region(name, areas[name], edges[name], value) for name, value in mass.items())
        return [Region("", bare_area, edge), *loaded]

    def patch_sizes(self, frequency: float, damper_mass: Mapping[str, float]) -> dict[str, float]:
        """Return the element sizes that the dampers of patches need, where they are shorter [m]."""
        if self.panel.mesh.kind != "triangles":
            return {}
        ratio = self.panel.modal_damping.smallest(0.0, frequency)
        sizes = {
            name: self.elements.made_edge(frequency, mass, ratio)
            for name, mass in damper_mass.items()
            if mass > 0
        }
        return {name: size for name, size in sizes.items() if size < self._element_size}

    def mesh(self, path: Path, patch_sizes: Mapping[str, float] | None = None) -> PanelMesh:
        """Mesh the panel, triangles with `patch_sizes`, and write the mesh to a ``.msh`` file."""
        spec, corner_size = self.panel.mesh, self.panel.corner_size
        if spec.kind == "quadrilaterals":
            drawn = spec.elements, self.shapes, self.points, self._anchors
            return mesh_quadrilaterals(path, self._size, *drawn)
        if self.foreign is not None:
            mesh = self.foreign.panel_mesh(self.patches, self.points)
            write_cells(path, mesh)
            return mesh
        return mesh_triangles(
            path,
            self._outline,
            self._element_size,
            self.shapes,
            self.points,
            holes=self._holes,
            imprints=self._feet,
            anchors=self._anchors,
            held=checks.fine_places(self.supports, self.attachments, self.section, corner_size),
            corner_size=corner_size,
            patch_sizes=patch_sizes or {},
        )

    def plate(self, mesh: PanelMesh) -> AssembledPlate:
        """Assemble the supported plate with its springs and masses."""
        if isinstance(self.section, sections.ThinSection):
            plate = assemble_thin_plate(mesh, self.section, self.supports)
        else:
            plate = assemble_shear_plate(mesh, self.section, self.supports)
        return with_attachments(plate, self.attachments.values(), mesh)

    @property
    def _size(self) -> tuple[float, float]:
        return tuple(self._outline.corners[2].tolist())

    @property
    def _outline(self) -> Shape:
        outline = self.panel.outline
        if outline is None:
            raise ValueError("the outline of this panel is in its mesh file")
        return outline

    @property
    def _element_size(self) -> float:
        """Longest edge [m]; a narrow panel has shorter triangles than stated."""
        spec = self.panel.mesh
        if spec.kind == "quadrilaterals":
            return max(np.array(self._size) / spec.elements)
        size = spec.size_m if spec.kind == "triangles" else 0.0
        return min(size, checks.narrowest(self._outline) / ELEMENTS_ACROSS)

    @cached_property
    def rough(self) -> dict[str, float]:
        """Parameters of `ElementKind.frequency_shifts` besides edge, frequency and mass."""
        rough = checks.roughness(self.area, self.supports, self._size_at)
        if self.foreign is not None:
            rough["jagged"] = checks.jaggedness(self.foreign.panel_mesh({}, {}), self.supports)
        return rough

    def _size_at(self, place: Position, radius: float) -> float:
        """Return the size of elements at a place, or at the rim of a foot there [m]."""
        if self.foreign is not None:
            mesh = self.foreign.panel_mesh({}, {})
            distance = np.linalg.norm(mesh.vertices - place, axis=1)
            is_near = (distance <= max(radius, distance.min()))[mesh.cells].any(axis=1)
            return float(element_sizes(mesh.vertices, mesh.cells[is_near]).max())
        if self.panel.mesh.kind == "quadrilaterals":
            return float(self._element_size)
        return rim_size(radius, self.panel.corner_size, self._element_size)

    @property
    def _areas(self) -> dict[str, float]:
        """Areas of the patches, and that of the panel under "" [m²]."""
        areas = {name: abs(signed_area(shape.corners)) for name, shape in self.shapes.items()}
        holes = sum(abs(signed_area(hole.corners)) for hole in self._holes.values())
        return {**areas, "": abs(signed_area(self._outline.corners)) - holes}

    @property
    def _holes(self) -> dict[str, Shape]:
        return {name: hole.shape for name, hole in self.panel.holes.items() if hole.shape}

    @property
    def _feet(self) -> dict[str, Shape]:
        return {
            f"foot of {name}": checks.foot_of(point)
            for name, point in self.supports.points.items()
            if point.radius > 0
        }

    @property
    def _anchors(self) -> dict[str, Position]:
        """Positions of required vertices: point supports, ends of supported edges."""
        anchors = {f"support {name}": p.position for name, p in self.supports.points.items()}
        for number, edge in enumerate(self.supports.edges, 1):
            anchors[f"supports.edges {number} from_m"] = edge.start
            anchors[f"supports.edges {number} to_m"] = edge.end
        return anchors

    @property
    def _attached(self) -> dict[str, Position]:
        positions: dict[str, Position] = {}
        for name, attached in self.attachments.items():
            names = [f"{name} from_m", f"{name} to_m"]
            names = [checks.place_of(name, attached)] if len(attached.ends) == 1 else names
            positions |= zip(names, attached.ends, strict=True)
        return positions

    def _place(self, position: Position | None, grid: int | None) -> Position:
        """Return a position [m] that is stated as such or as a node of the mesh file."""
        if position is not None:
            return position
        if self.foreign is None or grid is None:
            raise ValueError(f"node {grid}: this panel has no mesh file")
        return self.foreign.at_node(grid)
