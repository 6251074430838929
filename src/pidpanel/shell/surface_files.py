"""Curved surfaces from gmsh and STEP files, which may come from anybody.

gmsh runs scripts and writes beyond its memory where a file contradicts itself (`panel.gmsh_files`).
So it reads a copy, alone in a folder, with bounded memory and in a process of its own.
"""

import multiprocessing
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path

import gmsh
import numpy as np

from pidpanel.nastran import read_deck
from pidpanel.panel.gmsh_reader import MEMORY, MEMORY_PER_BYTE, SECTION, bounded_memory
from pidpanel.panel.mesh import gmsh_session
from pidpanel.shell.drawing import Tags, mesh_surface, read_surface
from pidpanel.shell.mesh import UPWARD, ShellMesh
from pidpanel.shell.selections import Place, Selection

MOST_FACETS = 4000  # of a deck, which are elements of order 4
STEP = (".step", ".stp")


def read_surface_file(
    path: Path,
    size: float | None = None,
    imprints: Iterable[Selection] = (),
    *,
    unit: float = 1.0,
    outward: Place = UPWARD,
) -> ShellMesh:
    """Read a surface: the triangles of a ``.msh`` file, or a ``.step`` file that is meshed here.

    Parts are the physical surfaces of the mesh, or the faces of the STEP file by number from 1.

    Parameters
    ----------
    size, imprints
        Length of edges [m], and selections whose edges elements follow, in a STEP file.
    unit
        Length unit of a mesh [m]; STEP files state theirs.

    Raises
    ------
    ValueError
        With one line: what is wrong and what is allowed.
    """
    suffix, data = path.suffix.lower(), path.read_bytes()
    if suffix in STEP:
        is_right, noun = data.lstrip().startswith(b"ISO-10303-21"), "a STEP file: ISO-10303-21"
        if size is None:
            raise ValueError(f"{path}: a STEP file needs the size of elements")
    else:
        is_right, noun = data.lstrip().startswith(b"$MeshFormat"), "a gmsh mesh: $MeshFormat"
        data = b"\n".join([*(section[0] for section in SECTION.finditer(data)), b""])
    if not is_right:
        raise ValueError(f"{path}: does not begin like {noun}")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / f"surface{suffix}"
        copy.write_bytes(data)
        context = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            task = pool.submit(_read, copy, size, tuple(imprints), unit, outward)
            try:
                return task.result()
            except BrokenProcessPool:
                raise ValueError(f"{path}: gmsh ended while it read the file") from None
            except Exception as error:
                message = " ".join(str(error).split()) or "it states more than it has"
                raise ValueError(f"{path}: {message}") from None


def read_deck_surface(
    path: Path, unit: float = 1.0, groups: Sequence[str] = (), outward: Place = UPWARD
) -> ShellMesh:
    """Read the shells of a Nastran deck as flat triangles; parts are its properties.

    Quadrilaterals are cut along their shorter diagonal, by their corners.

    Parameters
    ----------
    unit
        Length unit of the file [m].
    groups
        Those that count; all shells without any.

    Raises
    ------
    ValueError
        With one line: what is wrong and what is allowed.
    """
    deck = read_deck(path)
    chosen = deck.chosen(groups)
    corners = deck.corners(chosen)
    position = unit * deck.position
    a, b, c, d = position[corners].transpose(1, 0, 2)
    is_quad = corners[:, 3] != corners[:, 2]
    by_first = np.linalg.norm(a - c, axis=1) <= np.linalg.norm(b - d, axis=1)
    halves = corners[:, [[0, 1, 2], [0, 2, 3]]], corners[:, [[0, 1, 3], [1, 2, 3]]]
    cells = np.where((by_first | ~is_quad)[:, None, None], *halves)
    origin = np.repeat(np.arange(len(chosen)), 2).reshape(-1, 2)
    keep = np.stack([np.full(len(chosen), True), is_quad], axis=1)
    if (count := int(keep.sum())) > MOST_FACETS:
        raise ValueError(f"{path}: {count} triangles; allowed are {MOST_FACETS}: take its modes")
    used, cells = np.unique(cells[keep], return_inverse=True)
    mesh = ShellMesh.from_triangles(position[used], cells.reshape(-1, 3), order=1, outward=outward)
    place = chosen[origin[keep]]
    parts = {
        name: np.flatnonzero(np.isin(place, members))
        for name, members in deck.groups.items()
        if not name.startswith("SET")
    }
    return replace(mesh, part_cells={name: rows for name, rows in parts.items() if rows.size})


def _read(
    path: Path,
    size: float | None,
    imprints: tuple[Selection, ...],
    unit: float,
    outward: Place,
) -> ShellMesh:
    """Read a file in this process."""

    def draw() -> Mapping[str, Tags]:
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        shapes = gmsh.model.occ.importShapes(str(path), highestDimOnly=False)
        faces = [tag for tag in shapes if tag[0] == 2]
        return {str(number): [tag] for number, tag in enumerate(faces, 1)}

    with bounded_memory(MEMORY + MEMORY_PER_BYTE * path.stat().st_size):
        if size is not None and path.suffix in STEP:
            return mesh_surface(draw, size, imprints, outward=outward)
        with gmsh_session():
            gmsh.merge(str(path))
            parts = {
                gmsh.model.getPhysicalName(*group) or str(group[1]): [
                    (2, int(tag)) for tag in gmsh.model.getEntitiesForPhysicalGroup(*group)
                ]
                for group in gmsh.model.getPhysicalGroups(2)
            }
            mesh = read_surface(parts or {"surface": gmsh.model.getEntities(2)}, outward)
    return replace(mesh, vertices=unit * mesh.vertices, geometry=unit * mesh.geometry)
