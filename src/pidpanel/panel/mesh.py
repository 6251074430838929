"""Panel meshes with damper patches as named groups, read from gmsh files, and response points.

`grid` and `triangles` draw them. Each mesh is written to a ``.msh`` file, where the physical
group ``panel`` holds all cells and one surface group per patch holds the cells of the patch; the
arrays are read back from that file, so that file and arrays cannot differ.

Vertices are numbered by rows: along x first, then up in y. On the structured mesh of the paper
(30 × 20 quadrilaterals) vertex ``i`` is therefore grid point ``i + 1`` of the paper: 31 points
to a row, grid point 326 at (0.75, 0.50) m.
"""

import shutil
import signal
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from ctypes import CDLL, c_int, c_void_p
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np
import shapely
from skfem import Mesh, MeshQuad, MeshTri

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.polygon import Position, Shape, signed_area

PANEL_GROUP = "panel"
CELL_KINDS = {3: "quadrilaterals", 2: "triangles"}  # by gmsh's number of an element


@dataclass(frozen=True)
class PanelMesh:
    """A plane mesh of the panel with named patches and points."""

    vertices: Array  # (n_vertices, 2) vertex positions [m], sorted by y, then by x
    # (n_cells, 4) or (n_cells, 3) vertex numbers of each cell, counter-clockwise; cells sorted by
    # the y, then by the x of their centres
    cells: Index
    cell_kind: str  # "quadrilaterals" or "triangles"
    patch_cells: dict[str, Index]  # cell numbers of each damper patch
    points: dict[str, Position]  # response points, anywhere on the panel [m]

    def patches_at(self, position: Position) -> list[str]:
        """Return the patches with a cell at a position."""
        cells = shapely.polygons(self.vertices[self.cells])
        slack = 1e-6 * float(np.ptp(self.vertices, axis=0).max())
        near = np.flatnonzero(shapely.dwithin(cells, shapely.Point(position), slack))
        return [name for name, inside in self.patch_cells.items() if np.isin(near, inside).any()]

    @property
    def elements(self) -> Mesh:
        """The mesh of scikit-fem."""
        kind = MeshQuad if self.cell_kind == "quadrilaterals" else MeshTri
        return kind(*map(np.ascontiguousarray, (self.vertices.T, self.cells.T)))


def read_mesh(path: Path, patches: Iterable[str], points: Mapping[str, Position]) -> PanelMesh:
    """Read a panel mesh from a ``.msh`` file (MSH 4.1) with named physical groups.

    One kind of cell in the plane z = 0; patches are surface groups.
    """
    with gmsh_session(), tempfile.TemporaryDirectory() as folder:
        # gmsh runs ``mesh.msh.opt`` next to ``mesh.msh``, whoever put it into the results
        gmsh.open(str(shutil.copy(path, folder)))
        model = gmsh.model
        tags, positions, _ = model.mesh.getNodes()
        (kind,), (elements,), (corners,) = model.mesh.getElements(2)
        groups = {model.getPhysicalName(*group): group for group in model.getPhysicalGroups()}
        members = {
            name: [
                model.mesh.getElements(2, entity)[1][0]
                for entity in model.getEntitiesForPhysicalGroup(*groups[name])
            ]
            for name in patches
        }
    cells = corners.reshape(len(elements), -1).astype(np.int64)
    place = np.zeros((int(tags.max()) + 1, 2))
    place[tags] = positions.reshape(-1, 3)[:, :2]
    used = np.unique(cells)
    used = used[row_order(place[used])]
    number = np.full(len(place), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    vertices = place[used]
    cells = number[cells]
    cells = np.where(cell_areas(vertices, cells)[:, None] > 0, cells, cells[:, ::-1])
    order = row_order(vertices[cells].mean(axis=1))
    patch_cells = {
        name: np.flatnonzero(np.isin(elements, np.concatenate(inside))[order])
        for name, inside in members.items()
    }
    return PanelMesh(vertices, cells[order], CELL_KINDS[kind], patch_cells, dict(points))


def write_cells(path: Path, mesh: PanelMesh) -> None:
    """Write a mesh to a ``.msh`` file, without groups, for viewing."""
    import meshio  # slow to import, for files alone

    position = np.pad(mesh.vertices, ((0, 0), (0, 3 - mesh.vertices.shape[1])))
    kind = {3: "triangle", 4: "quad"}[mesh.cells.shape[1]]
    meshio.gmsh.write(path, meshio.Mesh(position, [(kind, mesh.cells)]), "4.1", binary=False)


# C's ``signal``: unlike Python's, it works in any thread and returns handlers of C too.
_set_handler = CDLL(None).signal
_set_handler.argtypes, _set_handler.restype = (c_int, c_void_p), c_void_p


@contextmanager
def gmsh_session() -> Iterator[None]:
    """Open gmsh without terminal output, configuration files or signal handlers; close it."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is already open in this process; call gmsh.finalize() first")
    pipe_handler = _set_handler(signal.SIGPIPE, None)
    # interruptible=True would replace the SIGINT handler and fail outside the main thread
    gmsh.initialize(["gmsh", "-v", "0"], readConfigFiles=False, interruptible=False)
    # gmsh resets SIGPIPE: a closed pipe would then end the process without a word
    _set_handler(signal.SIGPIPE, pipe_handler)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(PANEL_GROUP)
        yield
    finally:
        gmsh.finalize()


@contextmanager
def drawing(
    path: Path, patches: Mapping[str, object], points: Mapping[str, object]
) -> Iterator[None]:
    """Open gmsh to draw a panel; then mesh it and write the mesh.

    Nodes are numbered by rows from 1, as in the paper. Raises `ValueError` if two groups of the
    file would have the same name.
    """
    check_names(patches, points)
    with gmsh_session():
        yield
        gmsh.model.mesh.generate(2)
        tags, positions, _ = gmsh.model.mesh.getNodes()
        order = row_order(positions.reshape(-1, 3)[:, :2])
        gmsh.model.mesh.renumberNodes(tags[order], np.arange(1, len(tags) + 1))
        gmsh.write(str(path))


def row_order(positions: Array) -> Index:
    """Return the order of points by rows, by y, then by x; rounding does not split a row."""
    extent = np.ptp(positions, axis=0).max()
    x, y = np.round(positions / extent, 9).T
    return np.lexsort((x, y))


def check_patch_areas(mesh: PanelMesh, patches: Mapping[str, Shape], tolerance: float) -> None:
    """Refuse cells that do not add up to the area of a patch."""
    area = cell_areas(mesh.vertices, mesh.cells)
    for name, patch in patches.items():
        nominal, meshed = abs(signed_area(patch.corners)), area[mesh.patch_cells[name]].sum()
        if abs(meshed / nominal - 1) > tolerance:
            raise ValueError(
                f"patch {name!r} = {patch}: its elements cover {meshed:.4g} m² of its {nominal:.4g}"
                " m²; it must lie on the panel and the mesh must follow its edges"
            )


def check_names(patches: Mapping[str, object], points: Mapping[str, object]) -> None:
    """Refuse names that would put two groups of the file under one name."""
    for name in patches:
        if name in points:
            raise ValueError(f"{name!r} names both a patch and a point; names must differ")
    if PANEL_GROUP in {*patches, *points}:
        raise ValueError(f"{PANEL_GROUP!r} names the whole panel; no patch or point may have it")
