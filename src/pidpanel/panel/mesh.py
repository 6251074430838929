"""Panel meshes from gmsh, with damper patches and response points as named groups.

The only module of the package that speaks to gmsh. Each mesh is written to a ``.msh`` file,
where the physical group ``panel`` holds all cells, one surface group per patch holds the cells
of the patch and one point group per response point holds its node; the arrays that are handed
on are read back from that file, so that the file and the arrays cannot differ.

Vertices are numbered by rows: along x first, then up in y. On the structured mesh of the paper
(30 x 20 quadrilaterals) vertex ``i`` is therefore grid point ``i + 1`` of the paper: 31 points
to a row, grid point 326 at (0.75, 0.50) m.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import gmsh
import meshio
import numpy as np
from numpy.typing import NDArray

PANEL_GROUP = "panel"
CELL_KINDS = {"quad": "quadrilaterals", "triangle": "triangles"}


@dataclass(frozen=True)
class Rectangle:
    """An axis-parallel rectangle, such as the area of a damper patch.

    Attributes
    ----------
    centre : tuple of float
        Centre (x, y) [m].
    size : tuple of float
        Edge lengths along x and y [m].
    """

    centre: tuple[float, float]
    size: tuple[float, float]

    @property
    def lower(self) -> tuple[float, float]:
        """Corner with the smallest x and y [m]."""
        return (self.centre[0] - self.size[0] / 2, self.centre[1] - self.size[1] / 2)

    @property
    def upper(self) -> tuple[float, float]:
        """Corner with the largest x and y [m]."""
        return (self.centre[0] + self.size[0] / 2, self.centre[1] + self.size[1] / 2)

    def __str__(self) -> str:
        """Show the rectangle as a product of intervals in metres."""
        (x0, y0), (x1, y1) = self.lower, self.upper
        return f"[{x0:g}, {x1:g}] x [{y0:g}, {y1:g}] m"


@dataclass(frozen=True)
class PanelMesh:
    """A plane mesh of the panel with named patches and points.

    Attributes
    ----------
    vertices : ndarray, shape (n_vertices, 2)
        Vertex positions [m], sorted by y, then by x.
    cells : ndarray of int, shape (n_cells, 4) or (n_cells, 3)
        Vertex numbers of each cell, counter-clockwise; cells sorted by the y, then by the x
        of their centres.
    cell_kind : str
        "quadrilaterals" or "triangles".
    patch_cells : dict of str to ndarray of int
        Cell numbers of each damper patch.
    point_vertices : dict of str to int
        Vertex number of each response point.
    """

    vertices: NDArray[np.float64]
    cells: NDArray[np.int64]
    cell_kind: str
    patch_cells: dict[str, NDArray[np.int64]]
    point_vertices: dict[str, int]


def check_grid(
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Rectangle],
    points: Mapping[str, tuple[float, float]],
) -> tuple[list[int], list[int]]:
    """Refuse what does not fit a regular grid of quadrilaterals, before any mesh is made.

    Parameters are those of `mesh_quadrilaterals`.

    Returns
    -------
    columns, rows : list of int
        Grid lines, by number, at which gmsh must have a line of its own.

    Raises
    ------
    ValueError
        As `mesh_quadrilaterals`.
    """
    _check_names(patches, points)
    _check_panel_size(size)
    for direction, count in zip("xy", elements, strict=True):
        if count < 1:
            raise ValueError(
                f"number of elements along {direction} is {count}; it must be at least 1"
            )
    for name, patch in patches.items():
        _check_patch_size(name, patch)
        _check_inside_rectangle(f"patch {name!r} = {patch}", (patch.lower, patch.upper), size)
    for name, point in points.items():
        _check_inside_rectangle(f"point {name!r} = {_show(point)}", (point,), size)

    columns, rows = (
        _cut_lines(k, size[k] / elements[k], elements[k], patches, points) for k in (0, 1)
    )
    return columns, rows


def mesh_quadrilaterals(
    path: Path,
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Rectangle],
    points: Mapping[str, tuple[float, float]],
) -> PanelMesh:
    """Mesh the rectangle [0, a] x [0, b] by a regular grid of quadrilaterals.

    The rectangle is cut along every patch edge and through every point, so that in gmsh each
    patch is a set of whole surfaces and each point is a corner of one.

    Parameters
    ----------
    path : Path
        The ``.msh`` file to write.
    size : tuple of float
        Edge lengths (a, b) [m] along x and y.
    elements : tuple of int
        Number of elements along x and y.
    patches : mapping of str to Rectangle
        Damper patches; their edges lie on element edges. They may touch or overlap.
    points : mapping of str to tuple of float
        Response points (x, y) [m]; each is a grid point.

    Returns
    -------
    PanelMesh
        The mesh as read back from `path`.

    Raises
    ------
    ValueError
        If a size or a number of elements is not positive, a patch or a point leaves the panel,
        a patch edge is not on an element edge, a point is not at a grid point, or two groups
        share a name.
    """
    columns, rows = check_grid(size, elements, patches, points)
    spacing = (size[0] / elements[0], size[1] / elements[1])
    with _gmsh_session():
        corners, surfaces = _draw_blocks(columns, rows, spacing)
        _add_group(2, list(surfaces), PANEL_GROUP)
        for name, patch in patches.items():
            _add_group(2, [s for s, centre in surfaces.items() if _covers(patch, centre)], name)
        for name, point in points.items():
            at = (round(point[0] / spacing[0]), round(point[1] / spacing[1]))
            _add_group(0, [corners[at]], name)
        gmsh.model.mesh.generate(2)
        _write(path)
    return read_mesh(path, patches, points)


def mesh_triangles(
    path: Path,
    outline: Sequence[tuple[float, float]],
    element_size: float,
    patches: Mapping[str, Rectangle],
    points: Mapping[str, tuple[float, float]],
) -> PanelMesh:
    """Mesh a polygon by unstructured triangles with embedded patches and points.

    Parameters
    ----------
    path : Path
        The ``.msh`` file to write.
    outline : sequence of tuple of float
        Corners (x, y) [m] of the panel, in order, the first not repeated at the end.
    element_size : float
        Target length of the element edges [m].
    patches : mapping of str to Rectangle
        Damper patches; they may touch the outline and each other, or overlap.
    points : mapping of str to tuple of float
        Response points (x, y) [m] anywhere on the panel.

    Returns
    -------
    PanelMesh
        The mesh as read back from `path`.

    Raises
    ------
    ValueError
        If the outline has fewer than three corners, crosses itself or has no area, the element
        size is not positive, a patch or a point leaves the panel, or two groups share a name.
    """
    _check_names(patches, points)
    _check_outline(outline)
    if element_size <= 0:
        raise ValueError(f"element_size is {element_size:g} m; it must be positive")
    for name, patch in patches.items():
        _check_patch_size(name, patch)
    allowed = f"allowed is the inside of the outline {_show_outline(outline)}"

    with _gmsh_session():
        occ = gmsh.model.occ
        corners = [occ.addPoint(x, y, 0.0) for x, y in outline]
        lines = [
            occ.addLine(start, end)
            for start, end in zip(corners, corners[1:] + corners[:1], strict=True)
        ]
        panel = (2, occ.addPlaneSurface([occ.addCurveLoop(lines)]))
        tools = [
            (2, occ.addRectangle(patch.lower[0], patch.lower[1], 0.0, *patch.size))
            for patch in patches.values()
        ]
        tools += [(0, occ.addPoint(x, y, 0.0)) for x, y in points.values()]
        pieces = [[panel]]
        if tools:
            _, pieces = occ.fragment([panel], tools)
        occ.synchronize()

        panel_surfaces = {tag for dim, tag in pieces[0] if dim == 2}
        # combined would leave out the points between two surfaces
        boundary = gmsh.model.getBoundary(pieces[0], combined=False, recursive=True)
        panel_points = {tag for dim, tag in boundary if dim == 0}
        for surface in panel_surfaces:
            panel_points |= {tag for _, tag in gmsh.model.mesh.getEmbedded(2, surface)}

        _add_group(2, sorted(panel_surfaces), PANEL_GROUP)
        pieces_of = iter(pieces[1:])
        for name, patch in patches.items():
            surfaces = {tag for _, tag in next(pieces_of)}
            if not surfaces <= panel_surfaces:
                raise ValueError(f"patch {name!r} = {patch} leaves the panel; {allowed}")
            _add_group(2, sorted(surfaces), name)
        for name, point in points.items():
            tags = {tag for _, tag in next(pieces_of)}
            if not tags <= panel_points:
                raise ValueError(f"point {name!r} = {_show(point)} leaves the panel; {allowed}")
            _add_group(0, sorted(tags), name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", element_size)
        gmsh.model.mesh.generate(2)
        _write(path)
    return read_mesh(path, patches, points)


def read_mesh(
    path: Path, patches: Sequence[str] | Mapping[str, object], points: Sequence[str] | Mapping
) -> PanelMesh:
    """Read a panel mesh from a ``.msh`` file with named physical groups.

    Parameters
    ----------
    path : Path
        A gmsh file (MSH 4.1) of one kind of cell, quadrilaterals or triangles, in the plane
        z = 0, with a surface group "panel" that holds every cell.
    patches, points : sequence of str, or mapping with such keys
        Names of the surface groups that are damper patches and of the point groups that are
        response points.

    Returns
    -------
    PanelMesh

    Raises
    ------
    ValueError
        If the file holds no cells of the panel or two kinds of them, or a named group is absent.
    """
    raw = meshio.gmsh.read(path)
    kinds = sorted({block.type for block in raw.cells} & set(CELL_KINDS))
    if len(kinds) != 1:
        raise ValueError(
            f"{path}: cells of the kinds {kinds} found; allowed is one of {sorted(CELL_KINDS)}"
        )
    kind = kinds[0]
    blocks = [k for k, block in enumerate(raw.cells) if block.type == kind]
    cells = np.concatenate([raw.cells[k].data for k in blocks]).astype(np.int64)

    used = np.unique(cells)
    used = used[_row_order(raw.points[used, :2])]
    number = np.full(len(raw.points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    vertices = raw.points[used, :2]
    cells = number[cells]
    cells = _counter_clockwise(vertices, cells)
    order = _row_order(vertices[cells].mean(axis=1))

    patch_cells = {}
    for name in patches:
        members = _group(raw, path, name, 2)
        inside = np.concatenate(
            [np.isin(np.arange(len(raw.cells[k].data)), members[k]) for k in blocks]
        )
        patch_cells[name] = np.flatnonzero(inside[order])
    point_vertices = {}
    for name in points:
        members = _group(raw, path, name, 0)
        (node,) = {
            int(node)
            for block, chosen in zip(raw.cells, members, strict=True)
            if block.type == "vertex"
            for node in block.data[chosen, 0]
        }
        point_vertices[name] = int(number[node])
    return PanelMesh(vertices, cells[order], CELL_KINDS[kind], patch_cells, point_vertices)


@contextmanager
def _gmsh_session() -> Iterator[None]:
    """Open gmsh without terminal output, configuration files or signal handlers; close it."""
    if gmsh.isInitialized():
        raise RuntimeError("gmsh is already open in this process; call gmsh.finalize() first")
    # interruptible=True would replace the SIGINT handler and fail outside the main thread
    gmsh.initialize(["gmsh", "-v", "0"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add(PANEL_GROUP)
        yield
    finally:
        gmsh.finalize()


def _cut_lines(
    axis: int,
    spacing: float,
    elements: int,
    patches: Mapping[str, Rectangle],
    points: Mapping[str, tuple[float, float]],
) -> list[int]:
    """Numbers of the grid lines across one axis that bound patches or carry points."""
    lines = {0, elements}
    for name, patch in patches.items():
        for edge in (patch.lower[axis], patch.upper[axis]):
            complaint = f"edge {'xy'[axis]} = {edge:g} m is not on an element edge"
            lines.add(_grid_line(edge, spacing, f"patch {name!r} = {patch}: {complaint}"))
    for name, point in points.items():
        complaint = f"{'xy'[axis]} = {point[axis]:g} m is not at a grid point"
        lines.add(_grid_line(point[axis], spacing, f"point {name!r} = {_show(point)}: {complaint}"))
    return sorted(lines)


def _draw_blocks(
    columns: list[int], rows: list[int], spacing: tuple[float, float]
) -> tuple[dict[tuple[int, int], int], dict[int, tuple[float, float]]]:
    """Draw the blocks between grid lines, to be meshed by one quadrilateral a grid cell.

    Returns
    -------
    corners : dict
        gmsh point at each crossing (column, row).
    surfaces : dict
        Centre (x, y) [m] of each gmsh surface.
    """
    draw = gmsh.model.geo
    corners = {
        (i, j): draw.addPoint(i * spacing[0], j * spacing[1], 0.0) for j in rows for i in columns
    }
    along_x, along_y = {}, {}
    for i, i_next in pairwise(columns):
        for j in rows:
            along_x[i, j] = draw.addLine(corners[i, j], corners[i_next, j])
            draw.mesh.setTransfiniteCurve(along_x[i, j], i_next - i + 1)
    for j, j_next in pairwise(rows):
        for i in columns:
            along_y[i, j] = draw.addLine(corners[i, j], corners[i, j_next])
            draw.mesh.setTransfiniteCurve(along_y[i, j], j_next - j + 1)
    surfaces = {}
    for i, i_next in pairwise(columns):
        for j, j_next in pairwise(rows):
            loop = [along_x[i, j], along_y[i_next, j], -along_x[i, j_next], -along_y[i, j]]
            surface = draw.addPlaneSurface([draw.addCurveLoop(loop)])
            draw.mesh.setTransfiniteSurface(surface)
            draw.mesh.setRecombine(2, surface)
            surfaces[surface] = ((i + i_next) / 2 * spacing[0], (j + j_next) / 2 * spacing[1])
    draw.synchronize()
    return corners, surfaces


def _write(path: Path) -> None:
    """Number nodes by rows from 1, as the paper does, and write the mesh."""
    tags, positions, _ = gmsh.model.mesh.getNodes()
    order = _row_order(positions.reshape(-1, 3)[:, :2])
    gmsh.model.mesh.renumberNodes(tags[order], np.arange(1, len(tags) + 1))
    gmsh.write(str(path))


def _add_group(dimension: int, tags: Sequence[int], name: str) -> None:
    """Name a set of model entities."""
    group = gmsh.model.addPhysicalGroup(dimension, tags)
    gmsh.model.setPhysicalName(dimension, group, name)


def _group(raw: meshio.Mesh, path: Path, name: str, dimension: int) -> list[NDArray[np.int64]]:
    """Members of a physical group: for each block of cells, the numbers within the block."""
    if name not in raw.field_data or raw.field_data[name][1] != dimension:
        found = sorted(key for key, (_, dim) in raw.field_data.items() if dim == dimension)
        what = {0: "point", 2: "surface"}[dimension]
        raise ValueError(f"{path}: no {what} group {name!r}; the file has {found}")
    return list(raw.cell_sets[name])


def _row_order(positions: NDArray[np.float64]) -> NDArray[np.int64]:
    """Order of points by rows: by y, then by x; rounding does not split a row."""
    extent = np.ptp(positions, axis=0).max()
    x, y = np.round(positions / extent, 9).T
    return np.lexsort((x, y))


def _counter_clockwise(
    vertices: NDArray[np.float64], cells: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Turn clockwise cells around."""
    x, y = vertices[cells[:, :3]].transpose(2, 1, 0)
    turn = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    return np.where(turn[:, None] > 0, cells, cells[:, ::-1])


def _grid_line(position: float, spacing: float, complaint: str) -> int:
    """Return the number of the grid line at a position, or refuse a position between two."""
    line = round(position / spacing)
    # 1e-6 of an element: far above rounding, far below anything meant
    if abs(position / spacing - line) > 1e-6:
        raise ValueError(f"{complaint}; allowed are multiples of {spacing:g} m")
    return line


def _covers(patch: Rectangle, position: tuple[float, float]) -> bool:
    """Tell if a position lies in a rectangle."""
    return all(patch.lower[k] < position[k] < patch.upper[k] for k in (0, 1))


def _show(position: tuple[float, float]) -> str:
    """Show a position in metres."""
    return f"({position[0]:g}, {position[1]:g}) m"


def _show_outline(outline: Sequence[tuple[float, float]]) -> str:
    """Show the corners of an outline in metres."""
    return ", ".join(f"({x:g}, {y:g})" for x, y in outline) + " m"


def _check_names(patches: Mapping[str, object], points: Mapping[str, object]) -> None:
    """Refuse names that would put two groups of the file under one name."""
    for name in patches:
        if name in points:
            raise ValueError(f"{name!r} names both a patch and a point; names must differ")
    if PANEL_GROUP in {*patches, *points}:
        raise ValueError(f"{PANEL_GROUP!r} names the whole panel; no patch or point may have it")


def _check_panel_size(size: tuple[float, float]) -> None:
    """Refuse a panel without area."""
    if min(size) <= 0:
        raise ValueError(f"panel size is {size[0]:g} x {size[1]:g} m; both must be positive")


def _check_patch_size(name: str, patch: Rectangle) -> None:
    """Refuse a patch without area."""
    if min(patch.size) <= 0:
        raise ValueError(
            f"patch {name!r} has size {patch.size[0]:g} x {patch.size[1]:g} m;"
            " both must be positive"
        )


def _check_inside_rectangle(
    what: str, corners: Sequence[tuple[float, float]], size: tuple[float, float]
) -> None:
    """Refuse corners outside [0, a] x [0, b]."""
    slack = 1e-9 * max(size)
    for corner in corners:
        if not all(-slack <= corner[k] <= size[k] + slack for k in (0, 1)):
            raise ValueError(
                f"{what} leaves the panel; allowed is [0, {size[0]:g}] x [0, {size[1]:g}] m"
            )


def _check_outline(outline: Sequence[tuple[float, float]]) -> None:
    """Refuse a polygon that is no simple one, or has no area."""
    if len(outline) < 3:
        raise ValueError(f"outline has {len(outline)} corners; it needs at least 3")
    corners = np.asarray(outline, dtype=float)
    following = np.roll(corners, -1, axis=0)
    edge = following - corners
    area = 0.5 * np.sum(corners[:, 0] * following[:, 1] - following[:, 0] * corners[:, 1])
    if abs(area) <= 1e-12 * np.ptp(corners, axis=0).max() ** 2:
        raise ValueError(f"outline {_show_outline(outline)} encloses no area")

    def side(k: int, point: NDArray[np.float64]) -> float:
        offset = point - corners[k]
        return float(np.sign(edge[k, 0] * offset[1] - edge[k, 1] * offset[0]))

    n = len(corners)
    for i in range(n):
        for j in range(i + 1, n):
            apart = side(i, corners[j]) * side(i, following[j])
            astride = side(j, corners[i]) * side(j, following[i])
            if apart < 0 and astride < 0:
                raise ValueError(
                    f"outline crosses itself: the edge from {_show(outline[i])} meets the edge"
                    f" from {_show(outline[j])}"
                )
