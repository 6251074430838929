"""The structured mesh of a rectangle by quadrilaterals."""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import gmsh
import numpy as np
from numpy.typing import ArrayLike

from pidpanel.geometry.polygon import Position, Shape, show
from pidpanel.panel.mesh import PANEL_GROUP, PanelMesh, drawing, read_mesh

SAME = 1e-6  # distance of lines over the size of an element: far above rounding, below any meant
NARROW = 1e-2  # lines nearer than this would make elements too thin

Lines = list[tuple[float, int]]  # positions of lines, and the elements up to the next


def grid_lines(
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Shape],
    anchors: Mapping[str, Position],
) -> tuple[Lines, Lines]:
    """Return the lines along x and y [m] that edges of patches and anchors are on.

    Between them are as many elements as keep them no longer than those of an even grid. Refuses
    what leaves the rectangle, and lines too near each other, before any mesh is made.
    """
    places = {f"patch {name!r} = {patch}": patch.corners[[0, 2]] for name, patch in patches.items()}
    places |= {
        f"point {name!r} = {show(place)}": np.array([place]) for name, place in anchors.items()
    }
    for label, corners in places.items():
        _check_inside_rectangle(label, corners, size)
    columns, rows = (
        _lines(
            length,
            length / count,
            {name: corners[:, axis].tolist() for name, corners in places.items()},
        )
        for axis, (length, count) in enumerate(zip(size, elements, strict=True))
    )
    return columns, rows


def _lines(length: float, spacing: float, places: Mapping[str, list[float]]) -> Lines:
    """Return the lines along one axis."""
    named = [(0.0, "")] + [(value, name) for name, values in places.items() for value in values]
    named = sorted([*named, (length, "")])
    distinct = named[:1]
    for line, name in named[1:]:
        previous, neighbour = distinct[-1]
        if line - previous > SAME * spacing:
            if line - previous < NARROW * spacing:
                label = name or neighbour
                raise ValueError(
                    f"{label}: its line at {line:g} m is {line - previous:.2g} m from another;"
                    f" allowed is the same place or at least {NARROW * spacing:.2g} m"
                )
            distinct.append((line, name))
        elif line >= length:
            distinct[-1] = (length, "")
    ends = [line for line, _ in distinct]
    counts = [int(np.ceil((end - start) / spacing - SAME)) for start, end in pairwise(ends)]
    return list(zip(ends, [*counts, 0], strict=True))


def mesh_quadrilaterals(
    path: Path,
    size: tuple[float, float],
    elements: tuple[int, int],
    patches: Mapping[str, Shape],
    points: Mapping[str, Position],
    anchors: Mapping[str, Position] | None = None,
) -> PanelMesh:
    """Mesh the rectangle [0, a] × [0, b] [m] by a grid of quadrilaterals, even but for patches.

    Patches are rectangles. Anchors are further vertices; points may be anywhere. Raises
    `ValueError` if `grid_lines` refuses them or two of them share a name.
    """
    columns, rows = grid_lines(size, elements, patches, anchors or {})
    with drawing(path, patches, points):
        surfaces = _draw_blocks(columns, rows)
        gmsh.model.addPhysicalGroup(2, list(surfaces), name=PANEL_GROUP)
        for name, patch in patches.items():
            inside = [surface for surface, place in surfaces.items() if _covers(patch, place)]
            gmsh.model.addPhysicalGroup(2, inside, name=name)
    return read_mesh(path, patches, points)


def _draw_blocks(columns: Lines, rows: Lines) -> dict[int, Position]:
    """Draw the blocks between lines, to be meshed by quadrilaterals, and return their centres."""
    draw = gmsh.model.geo
    corners = {
        (i, j): draw.addPoint(x, y, 0.0)
        for j, (y, _) in enumerate(rows)
        for i, (x, _) in enumerate(columns)
    }
    along_x: dict[tuple[int, int], int] = {}
    along_y: dict[tuple[int, int], int] = {}
    for (i, j), corner in corners.items():
        for sides, after, count in (
            (along_x, (i + 1, j), columns[i][1]),
            (along_y, (i, j + 1), rows[j][1]),
        ):
            if count:
                sides[i, j] = draw.addLine(corner, corners[after])
                draw.mesh.setTransfiniteCurve(sides[i, j], count + 1)
    surfaces = {}
    for i, ((x, _), (x_next, _)) in enumerate(pairwise(columns)):
        for j, ((y, _), (y_next, _)) in enumerate(pairwise(rows)):
            loop = [along_x[i, j], along_y[i + 1, j], -along_x[i, j + 1], -along_y[i, j]]
            surface = draw.addPlaneSurface([draw.addCurveLoop(loop)])
            draw.mesh.setTransfiniteSurface(surface)
            draw.mesh.setRecombine(2, surface)
            surfaces[surface] = ((x + x_next) / 2, (y + y_next) / 2)
    draw.synchronize()
    return surfaces


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
