"""The mesh of any outline by unstructured triangles."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import gmsh
import numpy as np

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Position, Shape, check_panel, signed_area
from pidpanel.panel.mesh import PANEL_GROUP, PanelMesh, check_patch_areas, drawing, read_mesh
from pidpanel.panel.supports import SMOOTH_TURN

# Element edges grow by this times the distance from a re-entrant corner.
GROWTH = 0.5
# Element size at re-entrant corners over that elsewhere: 0.1 mm for elements of 5 cm. The frequency
# of a simply supported plate then errs by about 0.1 %, as (corner size)^(2/3).
CORNER_SHARE = 2e-3
FOOT_SHARE = 0.1  # size of elements at the rim of a foot over its radius
EMPTY: Mapping[str, Any] = {}


def mesh_triangles(
    path: Path,
    outline: Shape,
    element_size: float,
    patches: Mapping[str, Shape],
    points: Mapping[str, Position],
    *,
    holes: Mapping[str, Shape] = EMPTY,
    imprints: Mapping[str, Shape] = EMPTY,
    anchors: Mapping[str, Position] = EMPTY,
    held: Mapping[Position, float] | None = None,
    corner_size: float | None = None,
    patch_sizes: Mapping[str, float] = EMPTY,
) -> PanelMesh:
    """Mesh a polygon by unstructured triangles with embedded patches and points.

    At re-entrant corners, where the support of an edge changes and at feet the deflection is not
    smooth, and elements shrink towards them.

    Parameters
    ----------
    element_size
        Target length of the element edges [m].
    patches, points
        Patches, which may touch the outline and each other or overlap; points on the panel [m].
    imprints, anchors
        Shapes whose edges elements follow, such as the feet of supports; further vertices [m].
    held
        Anchors to which elements shrink, as to the corners, with the radius of the foot there, to
        whose rim they shrink [m]; 0 without a foot.
    corner_size
        Length of the element edges at re-entrant corners and the rims of feet [m]; if None, 2e-3 of
        `element_size` and a tenth of the radius.
    patch_sizes
        Target length of the element edges on patches, where it is shorter [m].

    Raises
    ------
    ValueError
        If a shape crosses itself or has no area, leaves the panel, or two groups share a name.
    """
    check_panel(outline, holes, {**patches, **imprints}, {**points, **anchors})
    smallest = CORNER_SHARE * element_size if corner_size is None else corner_size

    with drawing(path, patches, points):
        occ = gmsh.model.occ
        loops = [_draw_loop(shape) for shape in (outline, *holes.values())]
        panel = (2, occ.addPlaneSurface(loops))
        tools = [
            (2, occ.addPlaneSurface([_draw_loop(shape)]))
            for shape in (*patches.values(), *imprints.values())
        ]
        tools += [(0, occ.addPoint(x, y, 0.0)) for x, y in (*points.values(), *anchors.values())]
        pieces = [[panel]]
        if tools:
            _, pieces = occ.fragment([panel], tools)
        occ.synchronize()

        faces = sorted({tag for dim, tag in pieces[0] if dim == 2})
        gmsh.model.addPhysicalGroup(2, faces, name=PANEL_GROUP)
        tags = [sorted({tag for _, tag in parts}) for parts in pieces[1:]]
        surfaces = dict(zip(patches, tags, strict=False))
        for name, surface in surfaces.items():
            gmsh.model.addPhysicalGroup(2, surface, name=name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", element_size)
        fields = [
            _size_on(surfaces[name], size, element_size) for name, size in patch_sizes.items()
        ]
        corners = reentrant_corners([outline, *holes.values()]).tolist()
        rims = {**(held or {}), **{(x, y): 0.0 for x, y in corners}}
        fields += _grown(rims, smallest, corner_size)
        if fields:  # elements are as small as the smallest of them
            minimum = gmsh.model.mesh.field.add("Min")
            gmsh.model.mesh.field.setNumbers(minimum, "FieldsList", fields)
            gmsh.model.mesh.field.setAsBackgroundMesh(minimum)
            finest = min([smallest, *patch_sizes.values(), element_size])
            gmsh.option.setNumber("Mesh.MeshSizeMin", finest)
    mesh = read_mesh(path, patches, points)
    check_patch_areas(mesh, patches, 1e-6)
    return mesh


def reentrant_corners(shapes: Iterable[Shape]) -> Array:
    """Return the corners of an outline and its holes at which the panel spans more than 180°."""
    corner_sets = [np.zeros((0, 2))]
    for number, shape in enumerate(shapes):
        corners = np.asarray(shape.corners)
        # the panel to the left of the edges: counter-clockwise outline, clockwise holes
        if (signed_area(corners) > 0) == (number > 0):
            corners = corners[::-1]
        place = corners @ [1, 1j]
        step = np.roll(place, -1) - place
        turn = np.angle(step / np.roll(step, 1))
        corner_sets.append(corners[turn < -SMOOTH_TURN])
    return np.concatenate(corner_sets)


def _draw_loop(shape: Shape) -> int:
    """Draw the edges of a polygon and return the gmsh curve loop."""
    occ = gmsh.model.occ
    corners = [occ.addPoint(x, y, 0.0) for x, y in shape.corners]
    ends = zip(corners, corners[1:] + corners[:1], strict=True)
    return int(occ.addCurveLoop([occ.addLine(*pair) for pair in ends]))


def _size_on(surfaces: Sequence[int], size: float, elsewhere: float) -> int:
    """Return the field of the element size on some surfaces and their edges."""
    field = int(gmsh.model.mesh.field.add("Constant"))
    gmsh.model.mesh.field.setNumber(field, "VIn", size)
    gmsh.model.mesh.field.setNumber(field, "VOut", elsewhere)
    gmsh.model.mesh.field.setNumbers(field, "SurfacesList", surfaces)
    return field


def rim_size(radius: float, corner_size: float | None, element_size: float = 0.0) -> float:
    """Return the size of elements at the rim of a foot, or at an end of a support [m].

    Elements that shrink towards an end leave the error of even ones of twice that size.
    """
    if radius:
        return FOOT_SHARE * radius if corner_size is None else corner_size
    return 2 * (CORNER_SHARE * element_size if corner_size is None else corner_size)


def _grown(
    radii: Mapping[Position, float], smallest: float, corner_size: float | None
) -> list[int]:
    """Return fields of sizes that grow linearly with the distance from points or rims of feet."""
    fields = []
    for (x, y), radius in radii.items():
        fields.append(gmsh.model.mesh.field.add("MathEval"))
        # gmsh reads no exponents here
        distance = f"Sqrt((x - ({x:.12f}))^2 + (y - ({y:.12f}))^2)"
        if radius:
            distance = f"(Abs({distance} - {radius:.12f}) + {distance} - {radius:.12f}) / 2"
        size = rim_size(radius, corner_size) if radius else smallest
        gmsh.model.mesh.field.setString(fields[-1], "F", f"{size:.12f} + {GROWTH:g} * {distance}")
    return fields
