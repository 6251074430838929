"""A structure that is meshed and solved here as a shell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array, Index
from pidpanel.panel.basis import basis_of
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.modes import first_modes
from pidpanel.panel.shapes import MODES_BEYOND, panel_shapes
from pidpanel.shell.assembly import AssembledShell, Attached, assemble_shell
from pidpanel.shell.attachments import Hinge, PointMass, RigidFoot, ShellSupport, Stiffener
from pidpanel.shell.mesh import ShellMesh, reference_nodes
from pidpanel.shell.resolution import (
    MOST_BULGE,
    bending_thickness,
    bulge,
    element_size,
    frequency_shifts,
    smallest_radius,
)
from pidpanel.shell.selections import Selection
from pidpanel.shell.strains import Layup, frames
from pidpanel.structure.any_structure import (
    AnyStructure,
    SolvedStructure,
    StructureRefused,
    SurfaceSection,
    drawn_cells,
    in_plane,
)
from pidpanel.structure.surface import Surface

FIRST, RIGID = 6, 6  # natural frequencies that are listed first, and motions of a body
ROUNDING = 1e-6  # of places, over the size of the surface
ALONG = 0.99  # least share of a stiffener on the surface
RIGID_SHARE = 1e-3  # frequency of a rigid motion, by rounding, over that of a mode
# Elements over the size that keeps frequencies within 0.1 %, above which a study is refused.
LONGEST = 1.5

# Keys of what is attached to a shell
KEYS = {
    ShellSupport: "supports", RigidFoot: "feet", PointMass: "masses", Hinge: "hinges",
    Stiffener: "stiffeners",
}  # fmt: skip


@dataclass(frozen=True)
class ShellStructure(AnyStructure):
    """A shell."""

    drawn: Callable[[], ShellMesh]  # its mesh, without patches
    layup: Layup
    attached: Mapping[str, Attached]
    size: float  # length of the edges of elements [m]
    parts: Mapping[str, Layup] = field(default_factory=dict)  # sections of parts by name

    @cached_property
    def shell(self) -> ShellMesh:
        """The mesh with patches and points."""
        try:
            mesh = self.drawn()
        except ValueError as error:
            raise StructureRefused(("shell", "form"), str(error)) from error
        patches = {}
        for name, area in self.areas.items():
            where = ("patches", name)
            if isinstance(area, str):
                if area not in mesh.part_cells:
                    names_text = ", ".join(mesh.part_cells)
                    raise StructureRefused(where, f"no part {area}; must be one of {names_text}")
                patches[name] = mesh.part_cells[area]
                continue
            try:
                patches[name] = mesh.selected(area, name)
            except ValueError as error:
                message = "no element of the surface has its middle there"
                raise StructureRefused(where, message) from error
        points = {}
        for name, point in self.observations.items():
            if point.position is None:
                raise StructureRefused(("points", name, "node"), "only allowed with modes")
            try:
                mesh.locate(np.array([point.position]))
            except ValueError as error:
                raise StructureRefused(("points", name, "at_m"), str(error)) from error
            points[name] = point.position
        return replace(mesh, patch_cells=patches, points=points)

    @property
    def surface(self) -> Surface:
        """Its surface, of straight triangles."""
        return Surface(self.shell.vertices, self.shell.cells)

    @property
    def patches(self) -> dict[str, Index]:
        """Cells of the patches, by name."""
        return self.shell.patch_cells

    @property
    def point_position(self) -> Array:
        """(n_points, 3) [m]."""
        return np.array(list(self.shell.points.values()), dtype=float).reshape(-1, 3)

    @property
    def layups(self) -> dict[str, Layup]:
        """Section of each part of the mesh."""
        cells = self.shell.part_cells
        if unknown := [name for name in self.parts if name not in cells]:
            message = f"no part; must be one of {', '.join(cells)}"
            raise StructureRefused(("shell", "parts", unknown[0]), message)
        return {name: self.parts.get(name, self.layup) for name in cells}

    @property
    def section(self) -> SurfaceSection:
        """Mass per area of the sections alone, the mean."""
        area, cells = self.surface.area, self.shell.part_cells
        masses = (
            layup.section.mass_per_area * area[cells[name]].sum()
            for name, layup in self.layups.items()
        )
        return SurfaceSection(float(sum(masses) / area.sum()))

    @property
    def obstacles(self) -> list[BaseGeometry]:
        """What holds the shell, its feet and its masses, as they are drawn [m]."""
        surface, (origin, axes) = self.surface, self.view
        vertices, slack = (surface.vertices - origin) @ axes, ROUNDING * surface.size
        parts: list[BaseGeometry] = []
        for part in self.attached.values():
            if isinstance(part, PointMass):
                parts.append(shapely.Point((np.array(part.position) - origin) @ axes))
            elif isinstance(part, ShellSupport | RigidFoot):
                inside = part.where.contains(surface.vertices, slack)
                parts.append(shapely.MultiPoint(vertices[inside]))
                inside = part.where.contains(surface.middle)
                parts.append(drawn_cells(vertices, surface.cells[inside]))
        return parts

    @property
    def stiffener_lines(self) -> Array:
        """(n, 2, 2) ends of stiffeners, as they are drawn [m]."""
        origin, axes = self.view
        lines = [p.where for p in self.attached.values() if isinstance(p, Stiffener)]
        ends = np.array([(line.start, line.end) for line in lines]).reshape(-1, 2, 3)
        return np.asarray((ends - origin) @ axes)

    @cached_property
    def _first(self) -> tuple[Array, Array]:
        """First frequencies but for rigid motions, and displacements, on rougher elements."""
        shell = assemble_shell(self.shell, self.layups, self.attached, order=3)
        _, frequency, shapes = first_modes(shell, FIRST + RIGID)
        elastic = np.flatnonzero(frequency > RIGID_SHARE * frequency.max())[:FIRST]
        return frequency[elastic], shell.motions(shapes[:, elastic])

    @property
    def first_frequency(self) -> Array:
        """First natural frequencies [Hz] but for rigid motions."""
        return self._first[0]

    @property
    def first_motion(self) -> tuple[Array, Array]:
        """Displacement and mass of these modes, whose modal masses are alike."""
        return self._first[1], np.ones(len(self._first[0]))

    @property
    def remarks(self) -> list[str]:
        """None."""
        return []

    def check(self, highest: float, damper_mass: dict[str, float] | None = None) -> None:
        """Refuse what cannot be computed (`StructureRefused`)."""
        radius = smallest_radius(self.shell)
        sizes = [element_size(layup, highest, radius) for layup in self.layups.values()]
        longest = LONGEST * min(sizes)
        if self.size > longest:
            message = f"must be at most {longest:.2g} for responses up to {highest:g} Hz"
            raise StructureRefused(("shell", "size_m"), message)
        corners = self.shell.vertices[self.shell.cells]
        edge = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
        if edge > longest:  # a mesh of a file, which size_m does not change
            message = f"its elements are {edge:.2g} m long, at most {longest:.2g} m is allowed for"
            raise StructureRefused(("shell", "form"), f"{message} responses up to {highest:g} Hz")
        thinnest = min(map(bending_thickness, self.layups.values()))
        if (off := bulge(self.shell)) > MOST_BULGE * thinnest:
            message = f"its flat facets are up to {1e3 * off:.2g} mm off a smooth surface, at most "
            allowed = f"{1e3 * MOST_BULGE * thinnest:.2g} mm is allowed; mesh it finer"
            raise StructureRefused(("shell", "form"), message + allowed)
        super().check(highest, damper_mass)
        try:
            for name, layup in self.layups.items():
                frames(self.shell, 1, reference_nodes(1), self.shell.part_cells[name], layup)
        except ValueError as error:
            raise StructureRefused(("shell", "axis"), str(error)) from error
        for name, part in self.attached.items():
            try:
                self._check_place(part, name)
            except ValueError as error:
                message = str(error).rpartition(": ")[2]
                raise StructureRefused(("shell", KEYS[type(part)], name), message) from error

    def _check_place(self, part: Attached, name: str) -> None:
        """Refuse (`ValueError`) what is attached off the surface."""
        if isinstance(part, ShellSupport | RigidFoot):
            self.shell.selected_nodes(part.where, self.shell.order, name)
        elif isinstance(part, PointMass):
            self.shell.locate(np.array([part.position]))
        elif isinstance(part, Stiffener):
            _, position = self.shell.nodes(self.shell.order)
            nodes = position[self.shell.selected_edges(part.where, self.shell.order)]
            on_it = float(np.linalg.norm(np.diff(nodes, axis=1), axis=2).sum())
            if on_it < ALONG * part.where.length:
                message = f"{on_it:.3g} m of its {part.where.length:.3g} m are on the surface"
                raise ValueError(message)

    def solve(
        self, mesh: PanelMesh, highest: float, damper_mass: dict[str, float]
    ) -> SolvedStructure:
        """Return the basis with modes to twice the frequency, and what the dampers need."""
        try:
            shell = self._with_directions(assemble_shell(self.shell, self.layups, self.attached))
        except ValueError as error:
            raise StructureRefused(("shell",), str(error)) from error
        shapes = panel_shapes(shell, MODES_BEYOND * highest, damper_mass=damper_mass)
        within = shapes.frequency[: max(FIRST + RIGID, np.searchsorted(shapes.frequency, highest))]
        shift = frequency_shifts(self.shell, self.layups, self.attached, frequency=within)
        plate = in_plane(self, shell)
        beyond = shapes.vectors.shape[1] - len(shift)
        shift = np.pad(shift, (0, beyond), constant_values=shift.max())
        basis = replace(basis_of(mesh, plate, shapes), frequency_shift=shift)
        return SolvedStructure(basis, plate, shapes.vectors, shell.total_mass)

    def _with_directions(self, shell: AssembledShell) -> AssembledShell:
        """Return the matrices with motion along the stated directions at the points."""
        cells, place = self.shell.locate(self.point_position)
        normals = frames(self.shell, 1, place[:, None], cells, None).axes[:, 0, 2]
        points = [point.direction for point in self.observations.values()]
        direction = np.array(
            [n if d is None else np.array(d) for d, n in zip(points, normals, strict=True)]
        )
        direction = direction / np.linalg.norm(direction, axis=1)[:, None]
        is_stated = np.array([d is not None for d in points])
        rows = shell.at_points
        if is_stated.any() and shell.displacement is not None:
            motion = shell.displacement(self.point_position)
            stated = sum(sp.diags_array(direction[:, k]) @ motion[k] for k in range(3))
            keep, take = sp.diags_array(1.0 - is_stated), sp.diags_array(1.0 * is_stated)
            rows = sp.csr_array(keep @ rows + take @ stated)
        return replace(shell, at_points=rows, point_direction=direction)


def imprints(
    areas: Mapping[str, Selection | str], attached: Mapping[str, Attached]
) -> list[Selection]:
    """Return the parts of space whose edges the elements follow."""
    places = [area for area in areas.values() if not isinstance(area, str)]
    places += [part.where for part in attached.values() if hasattr(part, "where")]
    return list(dict.fromkeys(places))
