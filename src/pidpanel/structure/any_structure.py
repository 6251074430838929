"""What structures of all kinds have: a surface with patches and points, drawn in plane or space."""

from __future__ import annotations

import tempfile
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array, Index
from pidpanel.panel.attachments import Attachment
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.mesh import PanelMesh, check_names, write_cells
from pidpanel.panel.supports import Supports
from pidpanel.shell.selections import Place, Selection
from pidpanel.structure.surface import Surface, tangential_share, view_axes

FLAT = 1e-4  # largest distance from a plane over the size of a surface that is flat

WIDE_PATCH = 20.0  # angle of normals to their mean that is reported [°]
MOST_TANGENTIAL = 0.5  # share of the motion of a patch along the surface, above which is a warning


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


class Observation(NamedTuple):
    """A point of the response: a node of a file or a position [m], and the direction there."""

    node: int | None
    position: Place | None
    direction: Place | None  # None for the normal


class SolvedStructure(NamedTuple):
    """Basis and matrices of a structure, and its shapes (n_free, n)."""

    basis: PanelBasis
    plate: PlateMatrices
    vectors: Array
    mass: float  # [kg]


@dataclass(frozen=True)
class AnyStructure(ABC):
    """A structure as a `StudiedPanel`."""

    areas: dict[str, Selection | str]  # patches: parts of space, or groups of a file
    observations: dict[str, Observation]  # points of the response

    supports: ClassVar = Supports(outline="edge")  # as it is drawn
    attachments: ClassVar[dict[str, Attachment]] = {}
    foreign: ClassVar[None] = None

    @property
    @abstractmethod
    def surface(self) -> Surface:
        """The loaded surface."""

    @property
    @abstractmethod
    def patches(self) -> dict[str, Index]:
        """Cells of the patches, by name."""

    @property
    @abstractmethod
    def section(self) -> SurfaceSection:
        """Mass per area."""

    @property
    @abstractmethod
    def first_frequency(self) -> Array:
        """(n,) first natural frequencies [Hz]."""

    @property
    @abstractmethod
    def first_motion(self) -> tuple[Array, Array]:
        """Displacement (n_vertices, 3, n) and mass (n,) of the modes of `first_frequency`."""

    @property
    @abstractmethod
    def remarks(self) -> list[str]:
        """What of files is not used or unusual."""

    @property
    @abstractmethod
    def point_position(self) -> Array:
        """(n_points, 3) [m]."""

    @abstractmethod
    def solve(
        self, mesh: PanelMesh, highest: float, damper_mass: dict[str, float]
    ) -> SolvedStructure:
        """Return the basis for responses up to a frequency [Hz].

        ``damper_mass`` has the heaviest damper of each patch [kg/m²].
        """

    def tangential_shares(self, displacement: Array, mass: Array) -> dict[str, float]:
        """Return `tangential_share` of the patches by name."""
        return {
            name: tangential_share(self.surface, cells, displacement, mass)
            for name, cells in self.patches.items()
        }

    def mean_normal(self, patch: str) -> Array:
        """Return the mean normal (3,) of a patch."""
        cells = self.patches[patch]
        mean = self.surface.area[cells] @ self.surface.cell_normal[cells]
        return np.asarray(mean / np.linalg.norm(mean))

    def normal_spread(self, patch: str) -> float:
        """Return the largest angle of the normals of a patch to their mean [°]."""
        cosine = self.surface.cell_normal[self.patches[patch]] @ self.mean_normal(patch)
        return float(np.degrees(np.arccos(np.clip(cosine.min(), -1.0, 1.0))))

    @property
    def area(self) -> Extent:
        """Area of the loaded surface."""
        return Extent(float(self.surface.area.sum()))

    @cached_property
    def plane(self) -> tuple[Array, Array] | None:
        """Origin (3,) and axes (3, 2) of the plane of a flat surface; None of a curved one."""
        surface = self.surface
        normal = surface.cell_normal[0]
        offset = (surface.vertices - surface.vertices[0]) @ normal
        if np.ptp(offset) > FLAT * surface.size or (surface.cell_normal @ normal).min() < 0:
            return None
        axes = view_axes(surface)
        low = (surface.vertices @ axes).min(axis=0)
        return axes @ low + normal * (surface.vertices[0] @ normal), axes

    @cached_property
    def view(self) -> tuple[Array, Array]:
        """Origin (3,) and axes (3, 2) of the plane on which the surface is drawn."""
        return self.plane or (np.zeros(3), view_axes(self.surface))

    @cached_property
    def outline(self) -> BaseGeometry:
        """Area of the cells that face the view, as they are drawn [m]."""
        surface, (origin, axes) = self.surface, self.view
        facing = surface.cell_normal @ np.cross(*axes.T) > 0
        return drawn_cells((surface.vertices - origin) @ axes, surface.cells[facing])

    @property
    def obstacles(self) -> list[BaseGeometry]:
        """Supports and masses, as they are drawn; none are known of modes."""
        return []

    @property
    def stiffener_lines(self) -> Array:
        """(n, 2, 2) ends of stiffeners, as they are drawn [m]; none are known of modes."""
        return np.zeros((0, 2, 2))

    def placed(self, position: Array) -> Array:
        """Return positions in the plane of a flat surface, or as they are."""
        if self.plane is None:
            return position
        origin, axes = self.plane
        return np.asarray((position - origin) @ axes)

    def mesh(self, path: Path) -> PanelMesh:
        """Write the surface to a ``.msh`` file, and return it with patches and points."""
        try:
            check_names(self.areas, self.observations)
        except ValueError as error:
            raise StructureRefused(("points",), str(error)) from error
        vertices = self.placed(self.surface.vertices)
        places = map(tuple, self.placed(self.point_position).tolist())
        points = dict(zip(self.observations, places, strict=True))
        kind = "triangles" if self.surface.cells.shape[1] == 3 else "quadrilaterals"
        mesh = PanelMesh(vertices, self.surface.cells, kind, self.patches, points)
        write_cells(path, mesh)
        return mesh

    def check(self, highest: float, damper_mass: dict[str, float] | None = None) -> None:
        """Refuse what cannot be computed (`StructureRefused`)."""
        with tempfile.TemporaryDirectory() as folder:
            self.mesh(Path(folder) / "mesh.msh")

    @property
    def fault_of_base_motion(self) -> str:
        """Why a motion of the supports cannot be computed; empty where it can."""
        return ""

    def wave_shift(self, *_: float, strain: object = None) -> float:
        """Return 0: the basis has the shift of each mode, where it is known."""
        return 0.0

    def cause_of_shift(self, _edge: float, _frequency: float) -> str:
        """Return the layers at edges and folds; for structures no other cause is named."""
        return "layers"

    def point_refinement_error(self, _highest: float) -> float:
        """Return 0, likewise."""
        return 0.0


def drawn_cells(vertices: Array, cells: Index) -> BaseGeometry:
    """Return the area of cells with vertices (n, 2) [m]."""
    return shapely.union_all(shapely.polygons(vertices[cells]))


def in_plane(structure: AnyStructure, plate: PlateMatrices) -> PlateMatrices:
    """Return matrices with positions in the plane of a flat structure."""
    if structure.plane is None:
        return plate
    position = structure.placed(plate.quadrature_position)
    return replace(plate, quadrature_position=position)
