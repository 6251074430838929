"""Curved meshes of shells by gmsh: of shapes by parameters, and of surfaces in files.

Elements follow the edges of the selections given as imprints, such as patches and feet.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace

import gmsh
import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.panel.mesh import gmsh_session
from pidpanel.shell.mesh import UPWARD, ShellMesh
from pidpanel.shell.selections import Box, Line, Place, Prism, Ring, Selection, Sphere

ORDERS = {2: 1, 9: 2, 21: 3, 23: 4}  # order of gmsh's triangles by the number of their kind
MOST = 50_000  # elements
REACH = 100.0  # of what is projected, from the origin or from its centre [m]
ROUND = 8  # least number of elements round a circle
FLAT = 1e-4  # distance of the corners of a panel from its plane, over their extent
Tags = list[tuple[int, int]]
Drawing = Callable[[], Mapping[str, Tags]]  # draws with gmsh's OCC; surfaces of each part by name


def paraboloid(diameter: float, focal_length: float, hub_diameter: float = 0.0) -> Drawing:
    """Return the drawing of z = r²/4F [m] from its hub to its rim, as part ``reflector``."""
    inner, outer = hub_diameter / 2, diameter / 2
    # a parabola is the Bézier curve of its ends and of the point where the tangents there meet
    x = [inner, (inner + outer) / 2, outer]
    z = [inner**2, inner * outer, outer**2]

    def draw() -> Mapping[str, Tags]:
        occ = gmsh.model.occ
        points = [occ.addPoint(r, 0.0, s / (4 * focal_length)) for r, s in zip(x, z, strict=True)]
        # two halves, since a surface that closes on itself has a seam
        curve, copy = occ.addBezier(points), occ.addBezier(points)
        occ.rotate([(1, copy)], 0, 0, 0, 0, 0, 1, np.pi)
        turned = [occ.revolve([(1, c)], 0, 0, 0, 0, 0, 1, np.pi) for c in (curve, copy)]
        return {"reflector": [tag for part in turned for tag in part if tag[0] == 2]}

    return draw


def cylinder_panel(radius: float, length: float, arc: float) -> Drawing:
    """Return the drawing of a panel of an arc length [m] about the x axis, as part ``panel``.

    It lies at 0 ≤ x ≤ length, symmetric about the plane y = 0, with its crown at z = radius.
    """

    def draw() -> Mapping[str, Tags]:
        occ, half = gmsh.model.occ, arc / radius / 2
        centre = occ.addPoint(0.0, 0.0, 0.0)
        ends = [
            occ.addPoint(0.0, radius * np.sin(turn), radius * np.cos(turn))
            for turn in (-half, half)
        ]
        curve = occ.addCircleArc(ends[0], centre, ends[1])
        parts = occ.extrude([(1, curve)], length, 0, 0)
        return {"panel": [tag for tag in parts if tag[0] == 2]}

    return draw


def flat_panels(corners: Mapping[str, Sequence[Place]]) -> Drawing:
    """Return the drawing of plane polygons in space, by name; they are joined where they touch."""

    def draw() -> Mapping[str, Tags]:
        occ = gmsh.model.occ
        surfaces = {}
        for name, places in corners.items():
            _check_plane(name, np.array(places, dtype=float))
            points = [occ.addPoint(*place) for place in places]
            ends = zip(points, points[1:] + points[:1], strict=True)
            loop = occ.addCurveLoop([occ.addLine(*pair) for pair in ends])
            surfaces[name] = [(2, occ.addPlaneSurface([loop]))]
        return surfaces

    return draw


def edge_strips(
    corners: Mapping[str, Sequence[Place]], stiffeners: Sequence[Line], width: float
) -> list[Line]:
    """Return lines in flat panels at a distance [m] from their edges and their stiffeners."""
    lines = []
    for places in corners.values():
        polygon = np.array(places, dtype=float)
        following = np.roll(polygon, -1, axis=0)
        normal = np.cross(polygon, following).sum(axis=0)  # twice the area
        normal /= np.linalg.norm(normal)
        sides = [(*ends, 1.0) for ends in zip(polygon, following, strict=True)]
        ends = [np.array([line.start, line.end]) for line in stiffeners]
        off = FLAT * np.ptp(polygon, axis=0).max()
        flat = [pair for pair in ends if np.abs((pair - polygon[0]) @ normal).max() < off]
        sides += [(*pair, side) for pair in flat for side in (1.0, -1.0)]
        for start, end, side in sides:
            step = side * width * np.cross(normal, end - start) / np.linalg.norm(end - start)
            lines.append(Line(tuple((start + step).tolist()), tuple((end + step).tolist())))
    return lines


def _check_plane(name: str, corners: Array) -> None:
    arm = corners - corners.mean(axis=0)
    extent = np.linalg.svd(arm, compute_uv=False)
    if extent[2] > FLAT * extent[0] or extent[1] < FLAT * extent[0]:
        raise ValueError(f"{name}: its corners must be in one plane, and in no line")


def mesh_surface(
    draw: Drawing,
    size: float,
    imprints: Iterable[Selection] = (),
    *,
    order: int = 4,
    outward: Place = UPWARD,
) -> ShellMesh:
    """Mesh what a function draws by curved triangles; parts that touch share their edges.

    Parameters
    ----------
    size
        Length of the edges of elements [m].
    imprints
        Selections whose edges elements follow.
    """
    with gmsh_session():
        parts = _fragmented(draw(), list(imprints))
        area = sum(gmsh.model.occ.getMass(*tag) for tags in parts.values() for tag in tags)
        if (count := 2 * area / size**2) > MOST:
            raise ValueError(
                f"{area:.3g} m² in edges of {size:g} m need {count:.2g} elements;"
                f" allowed are {MOST}"
            )
        for option in ("FromPoints", "ExtendFromBoundary"):
            gmsh.option.setNumber(f"Mesh.MeshSize{option}", 0)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", ROUND)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(order)
        return read_surface(parts, outward)


def read_surface(parts: Mapping[str, Tags], outward: Place = UPWARD) -> ShellMesh:
    """Return the triangles of the surfaces of gmsh's model; parts are lists of surfaces."""
    tags, positions, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    elements: list[Array] = []
    part_cells: dict[str, Index] = {}
    count, kind = 0, 0
    for name, surfaces in parts.items():
        start = count
        for surface in surfaces:
            kinds, _, nodes = gmsh.model.mesh.getElements(*surface)
            for kind, corners in zip(kinds, nodes, strict=True):
                if kind not in ORDERS:
                    shape = gmsh.model.mesh.getElementProperties(kind)[0]
                    raise ValueError(f"{name}: a {shape}; allowed are triangles of order 1 to 4")
                width = (ORDERS[kind] + 1) * (ORDERS[kind] + 2) // 2
                elements.append(number[corners].reshape(-1, width))
                count += len(elements[-1])
        part_cells[name] = np.arange(start, count)
    if len({block.shape[1] for block in elements}) != 1:
        raise ValueError("no triangles, or triangles of several orders; allowed is one order")
    _, _, _, width, local, _ = gmsh.model.mesh.getElementProperties(kind)
    reference = np.array(local).reshape(width, -1)[:, :2]
    nodes = positions.reshape(-1, 3)
    mesh = ShellMesh.from_nodes(nodes, np.concatenate(elements), reference, outward)
    return replace(mesh, part_cells=part_cells)


def _fragmented(parts: Mapping[str, Tags], imprints: Sequence[Selection]) -> dict[str, Tags]:
    """Cut the parts along each other and the imprints; return their pieces by name."""
    occ = gmsh.model.occ
    surfaces = [tag for tags in parts.values() for tag in tags]
    tools = [tag for imprint in imprints for tag in _drawn(imprint)]
    pieces = [[tag] for tag in surfaces]
    if len(surfaces) + len(tools) > 1:
        _, pieces = occ.fragment(surfaces, tools)
    cut: dict[str, Tags] = {}
    owner: dict[tuple[int, int], str] = {}
    following = iter(pieces)
    for name, tags in parts.items():
        cut[name] = sorted({tag for _ in tags for tag in next(following) if tag[0] == 2})
        if double := [tag for tag in cut[name] if owner.setdefault(tag, name) != name]:
            raise ValueError(f"{name} and {owner[double[0]]} overlap; each place needs one part")
    occ.remove(occ.getEntities(3))
    occ.remove([tag for tag in occ.getEntities(2) if tag not in owner], recursive=True)
    occ.synchronize()
    return cut


def _drawn(imprint: Selection) -> Tags:
    """Draw the outline of a selection: volumes, or a line. A box without thickness has none."""
    occ = gmsh.model.occ
    if isinstance(imprint, Box):
        low, high = np.clip([imprint.low, imprint.high], -REACH, REACH)
        return [(3, occ.addBox(*low, *(high - low)))] if (high > low).all() else []
    if isinstance(imprint, Sphere):
        return [(3, occ.addSphere(*imprint.centre, imprint.radius))]
    if isinstance(imprint, Line):
        return [(1, occ.addLine(*(occ.addPoint(*end) for end in (imprint.start, imprint.end))))]
    if isinstance(imprint, Ring):
        reach = REACH * np.array(imprint.axis) / np.linalg.norm(imprint.axis)
        ends = *(imprint.centre - reach), *(2 * reach)
        radii = sorted({imprint.inner, imprint.outer} - {0.0})
        return [(3, occ.addCylinder(*ends, radius)) for radius in radii]
    if isinstance(imprint, Prism):
        reach = REACH * np.array(imprint.along) / np.linalg.norm(imprint.along)
        corners = np.array(imprint.corners)
        corners = corners - np.outer(1 + corners @ reach / REACH**2, reach)
        base = flat_panels({"": corners.tolist()})()[""]
        return [tag for tag in occ.extrude(base, *(2 * reach)) if tag[0] == 3]
    return []
