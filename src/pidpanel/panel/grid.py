"""The structured mesh of a rectangle by quadrilaterals."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import gmsh
import numpy as np
from numpy.typing import ArrayLike

from pidpanel.geometry.polygon import Shape, show
from pidpanel.panel.mesh import PANEL_GROUP, PanelMesh, drawing, read_mesh


def check_grid(
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Shape],
    points: Mapping[str, tuple[float, float]],
) -> tuple[list[int], list[int]]:
    """Refuse what does not fit a regular grid of quadrilaterals, before any mesh is made."""
    for name, patch in patches.items():
        _check_inside_rectangle(f"patch {name!r} = {patch}", patch.corners, size)
    for name, point in points.items():
        _check_inside_rectangle(f"point {name!r} = {show(point)}", point, size)

    columns, rows = ({0, count} for count in elements)
    for axis, lines in enumerate((columns, rows)):
        spacing = size[axis] / elements[axis]
        for name, patch in patches.items():
            for edge in patch.corners[[0, 2], axis].tolist():
                complaint = f"edge {'xy'[axis]} = {edge:g} m is not on an element edge"
                lines.add(_grid_line(edge, spacing, f"patch {name!r} = {patch}: {complaint}"))
        for name, point in points.items():
            complaint = f"{'xy'[axis]} = {point[axis]:g} m is not at a grid point"
            label = f"point {name!r} = {show(point)}"
            lines.add(_grid_line(point[axis], spacing, f"{label}: {complaint}"))
    return sorted(columns), sorted(rows)


def mesh_quadrilaterals(
    path: Path,
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Shape],
    points: Mapping[str, tuple[float, float]],
) -> PanelMesh:
    """Mesh the rectangle [0, a] × [0, b] [m] by a regular grid of quadrilaterals.

    The rectangle is cut along every patch edge and through every point, so that in gmsh each patch
    is a set of whole surfaces and each point is a corner of one. Raises `ValueError` if a patch or
    a point leaves the panel or lies off the grid, or if two groups share a name.
    """
    columns, rows = check_grid(size, elements, patches, points)
    spacing = (size[0] / elements[0], size[1] / elements[1])
    with drawing(path, patches, points):
        corners, surfaces = _draw_blocks(columns, rows, spacing)
        gmsh.model.addPhysicalGroup(2, list(surfaces), name=PANEL_GROUP)
        for name, patch in patches.items():
            inside = [surface for surface, place in surfaces.items() if _covers(patch, place)]
            gmsh.model.addPhysicalGroup(2, inside, name=name)
        for name, point in points.items():
            node = (round(point[0] / spacing[0]), round(point[1] / spacing[1]))
            gmsh.model.addPhysicalGroup(0, [corners[node]], name=name)
    return read_mesh(path, patches, points)


def _draw_blocks(
    columns: list[int], rows: list[int], spacing: tuple[float, float]
) -> tuple[dict[tuple[int, int], int], dict[int, tuple[float, float]]]:
    """Draw the blocks between grid lines, to be meshed by one quadrilateral per grid cell."""
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


def _grid_line(position: float, spacing: float, complaint: str) -> int:
    """Return the number of the grid line at a position, or refuse a position between two."""
    line = round(position / spacing)
    # 1e-6 of an element: far above rounding, far below anything meant
    if abs(position / spacing - line) > 1e-6:
        raise ValueError(f"{complaint}; allowed are multiples of {spacing:g} m")
    return line


def _covers(patch: Shape, position: tuple[float, float]) -> bool:
    """Return whether a position lies in a rectangle."""
    lower, upper = patch.corners[[0, 2]]
    return bool(np.all((lower < position) & (position < upper)))


def _check_inside_rectangle(label: str, corners: ArrayLike, size: tuple[float, float]) -> None:
    """Refuse corners outside [0, a] × [0, b]."""
    slack = 1e-9 * max(size)
    if np.any((np.less(corners, -slack)) | (np.subtract(corners, size) > slack)):
        raise ValueError(
            f"{label} leaves the panel; allowed is [0, {size[0]:g}] x [0, {size[1]:g}] m"
        )
