"""Checks of supports and attachments against the panel, before it is meshed or assembled."""

from collections.abc import Callable, Iterable, Mapping
from itertools import combinations

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pidpanel.arrays import Array
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.polygon import Circle, Position, Shape, show, signed_area
from pidpanel.panel.attachments import Attachment
from pidpanel.panel.flat_mesh import FlatMesh
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import NONE_FREE
from pidpanel.panel.point_supports import added_compliance, foot_logarithm, refinement_change
from pidpanel.panel.section import Section, ThinSection
from pidpanel.panel.supports import PointSupport, Supports, boundary_loops, held_vertices

# Tolerance of positions over the extent of the panel, the same as for vertices at supports.
SLACK = 1e-6
# Relative tolerance of the area of a foot on a mesh from a file: 10 % of its radius.
FOOT_TOLERANCE = 0.2
TINY = 1e-300  # compliance of a thin plate under a force [m/N]
# ln(reach/radius) of a regular polygon with twelve edges and the area of the foot.
ROUND = 0.024
HINGE_SHARE = 0.3  # shift of modes with jagged feet that turn, over that with hold-downs
SEPARATION = "feet must lie apart from other supports"


def area_within(outline: Shape, holes: Iterable[Shape]) -> BaseGeometry:
    """Return the area of a panel from its edges."""
    return shapely.Polygon(outline.corners).difference(
        shapely.union_all([shapely.Polygon(hole.corners) for hole in holes])
    )


def area_of(mesh: PanelMesh) -> BaseGeometry:
    """Return the area that a mesh covers."""
    loops = [mesh.vertices[loop] for loop in boundary_loops(mesh.vertices, mesh.cells)]
    pieces, holes = (
        shapely.union_all([shapely.Polygon(loop) for loop in loops if turn * signed_area(loop) > 0])
        for turn in (1, -1)
    )
    return pieces.difference(holes)


def file_remarks(foreign: FlatMesh | None, area: BaseGeometry, kind: str) -> list[str]:
    """Return remarks on a mesh from a file, and its holes, whose edges have a kind of support."""
    if foreign is None:
        return []
    holes = [shapely.Polygon(ring) for part in shapely.get_parts(area) for ring in part.interiors]
    if not holes:
        return list(foreign.remarks)
    smallest = min(holes, key=lambda hole: hole.area)
    count = "a hole" if len(holes) == 1 else f"{len(holes)} holes, the smallest"
    place = show(smallest.representative_point().coords[0])
    return [
        *foreign.remarks,
        f"{count} of {smallest.area:.3g} m² at {place} within the outline, edges"
        f" {kind.replace('_', ' ')}",
    ]


def narrowest(outline: Shape) -> float:
    """Return the shorter side of the smallest rectangle of any direction round a panel [m].

    Examples
    --------
    >>> from pidpanel.geometry.polygon import Polygon
    >>> round(narrowest(Polygon(((0, 0), (4, 3), (3.94, 3.08), (-0.06, 0.08)))), 12)
    0.1
    """
    corners = shapely.get_coordinates(shapely.oriented_envelope(shapely.Polygon(outline.corners)))
    return float(np.linalg.norm(np.diff(corners[:3], axis=0), axis=1).min())


def place_of(name: str, attached: Attachment) -> str:
    """Return the name of an attachment in messages; a spring is a support there."""
    return f"support {name}" if attached.stiffness else name


def geometry_of(attached: Attachment) -> BaseGeometry:
    """Return the point or the line of an attachment."""
    return (shapely.LineString if len(attached.ends) > 1 else shapely.Point)(attached.ends)


def foot_of(point: PointSupport) -> Circle:
    """Return the foot of a support as the polygon that elements follow."""
    return Circle.of_equal_area(point.position, point.radius)


def check_fit(
    area: BaseGeometry,
    supports: Supports,
    attachments: Mapping[str, Attachment],
    points: Mapping[str, Position],
) -> None:
    """Refuse supports not along the boundary, and attachments and points outside the panel."""
    slack = _slack(area)
    boundary = area.boundary.buffer(slack)
    for number, edge in enumerate(supports.edges, 1):
        line = shapely.LineString([edge.start, edge.end])
        if line.length <= slack or not boundary.covers(line):
            raise ValueError(
                f"point 'supports.edges {number} to_m' = {show(edge.end)}: the boundary does not"
                f" lead straight to it from {show(edge.start)}; an edge is a straight part of the"
                " boundary"
            )
    around = area.buffer(slack)
    parts = {name: Attachment((point,)) for name, point in points.items()}
    for name, part in [*parts.items(), *attachments.items()]:
        if around.covers(geometry_of(part)):
            continue
        *starts, end = map(show, part.ends)
        place = f"point {place_of(name, part)!r} = {end}"
        if starts:
            place = f"point '{name} to_m' = {end}: the line to it from {starts[0]}"
        raise ValueError(f"{place} leaves the panel; it must lie on the panel")


def check_feet(area: BaseGeometry, supports: Supports) -> None:
    """Refuse feet that touch each other, another support at a point or a supported edge."""
    slack = _slack(area)
    edges = _supported(area, supports, slack)
    places = {
        name: shapely.Polygon(foot_of(p).corners) if p.radius else shapely.Point(p.position)
        for name, p in supports.points.items()
    }
    _check_separate(
        supports,
        lambda name: edges.dwithin(places[name], slack),
        lambda foot, neighbour: places[foot].dwithin(places[neighbour], slack),
    )


def check_held(mesh: PanelMesh, supports: Supports) -> None:
    """Refuse supports that leave no vertex of a given mesh free, or feet that meet on it."""
    edge = {vertex.vertex for vertex in held_vertices(mesh, supports)[0]}
    vertices: dict[str, set[int]] = {}
    for name, point in supports.points.items():
        if point.radius == 0:
            vertices[name] = {point.vertex(mesh, name)}
        else:
            vertices[name] = set(mesh.cells[point.foot_cells(mesh, name)].ravel().tolist())
    _check_separate(
        supports,
        lambda name: bool(vertices[name] & edge),
        lambda foot, neighbour: bool(vertices[foot] & vertices[neighbour]),
    )
    if len(edge.union(*vertices.values())) == len(mesh.vertices):
        raise ValueError(NONE_FREE)


def _check_separate(
    supports: Supports, on_edge: Callable[[str], bool], meet: Callable[[str, str], bool]
) -> None:
    """Refuse feet on a supported edge, and those that meet another support at a point."""
    points = supports.points
    for name, point in points.items():
        if point.radius and on_edge(name):
            raise ValueError(f"patch 'foot of {name}' meets a supported edge; {SEPARATION}")
    for pair in combinations(points, 2):
        first, second = sorted(pair, key=lambda name: not points[name].radius)
        if points[first].radius and meet(first, second):
            raise ValueError(f"patch 'foot of {first}' meets the support {second!r}; {SEPARATION}")


def check_foot_areas(mesh: PanelMesh, supports: Supports) -> None:
    """Refuse feet whose elements on a given mesh differ in area from the foot."""
    for name, point in supports.points.items():
        if point.radius:
            cells = mesh.cells[point.foot_cells(mesh, name)]
            area, nominal = cell_areas(mesh.vertices, cells).sum(), np.pi * point.radius**2
            if abs(area / nominal - 1) > FOOT_TOLERANCE:
                raise ValueError(
                    f"patch 'foot of {name}' of radius {point.radius:g} m: its elements cover"
                    f" {area:.3g} m² of its {nominal:.3g} m², a radius of"
                    f" {np.sqrt(area / np.pi):.3g} m; refine the mesh there, or state that radius"
                )


def fine_places(
    supports: Supports,
    attachments: Mapping[str, Attachment],
    section: Section,
    corner_size: float | None,
) -> dict[Position, float]:
    """Return positions where elements must shrink, with the radius of a foot there [m] or 0.

    The deflection is not smooth at the ends of supported edges. With two clamped parts of free
    edges modes were 4 to 5 % too high at elements of 10 to 19 cm, now 0.02 %. Thin plates also have
    hinges, springs, masses and feet (0.4 to 1.2 % with three of 3 cm), but not hold-downs without a
    foot: their frequencies do not converge. At feet of other sections
    they shrink where their size is stated.
    """
    places = dict.fromkeys([end for e in supports.edges for end in (e.start, e.end)], 0.0)
    if isinstance(section, ThinSection):
        attached = [a.ends[0] for a in attachments.values() if len(a.ends) == 1]
        places |= dict.fromkeys(attached, 0.0)
        points = [p for p in supports.points.values() if p.radius or p.kind != "hold_down"]
        places |= {point.position: point.radius for point in points}
    elif corner_size is not None:
        places |= {p.position: p.radius for p in supports.points.values() if p.radius}
    return places


def roughness(
    area: BaseGeometry,
    supports: Supports,
    size_at: Callable[[Position, float], float],
) -> dict[str, float]:
    """Return the arguments of `ElementKind.frequency_shift` for details worse resolved than waves.

    ``size_at(position, radius)`` is the element size there, at the rim of a foot if the radius is
    not 0 [m].
    """
    ends = {end for edge in supports.edges for end in (edge.start, edge.end)}
    slack, points = _slack(area), supports.points.values()
    corners = shapely.MultiPoint(shapely.get_coordinates(area.simplify(slack)))
    inside = [size_at(end, 0.0) for end in ends if shapely.Point(end).distance(corners) > slack]
    feet = [size_at(p.position, p.radius) / p.radius for p in points if p.radius]
    return {
        "free_edges": free_edges(area, supports),
        "feet": max(feet, default=0.0),
        "ends": sum(inside) / float(np.sqrt(area.area)),
    }


def jaggedness(mesh: PanelMesh, supports: Supports) -> float:
    """Return the largest ln(reach/radius) of the feet: how far their elements extend beyond [1].

    Hinges are weighted by `HINGE_SHARE`; a polygon with twelve edges is regarded as round.
    """
    reach = []
    for name, point in supports.points.items():
        if point.radius:
            corners = mesh.vertices[mesh.cells[point.foot_cells(mesh, name)]]
            distance = np.linalg.norm(corners - point.position, axis=-1).max()
            weight = 1.0 if point.kind == "hold_down" else HINGE_SHARE
            reach.append(weight * (np.log(distance / point.radius) - ROUND))
    return max([0.0, *reach])


def resistances(
    supports: Supports, attachments: Mapping[str, Attachment], section: Section, highest: float
) -> dict[Position, float]:
    """Return the dynamic stiffness [N/m] of point supports, springs and masses, by position.

    It is infinite for supports, and m ω² at the highest frequency for masses. Only those that lose
    their effect as the mesh is refined are returned: on thin plates hold-downs without a foot.
    """
    is_thin = isinstance(section, ThinSection)
    resistance = {
        point.position: np.inf
        for point in supports.points.values()
        if not point.radius and (point.kind == "hold_down" or not is_thin)
    }
    for attached in () if is_thin else attachments.values():
        if len(attached.ends) == 1:
            inertia = attached.mass * (2 * np.pi * highest) ** 2
            place = attached.ends[0]
            resistance[place] = resistance.get(place, 0.0) + (attached.stiffness or inertia)
    return resistance


def point_refinement_error(
    extent: float,
    resistance: Mapping[Position, float],
    section: Section,
    points: Iterable[Position],
    size_at: Callable[[Position], float],
) -> Array:
    """Return bounds (n,) on the change of motion at points with elements of half the size [1].

    The change is due to point supports, springs and masses that lose their effect as the mesh is
    refined.

    Parameters
    ----------
    extent
        Distance beyond which such a point has no effect [m].
    resistance
        Dynamic stiffness of point supports, springs and masses [N/m]; see `resistances`.
    size_at
        Function that returns the element size at a position [m].
    """
    places, positions = np.array(list(points)), np.array(list(resistance)).reshape(-1, 2)
    distance = np.linalg.norm(places[:, None] - positions, axis=2)
    size = np.array([size_at(position) for position in resistance])
    yields = added_compliance(section, 1.0)[0] / np.log(2) * foot_logarithm(extent, size)
    stiff = 1 / (1 + 1 / np.array(list(resistance.values())) / np.maximum(yields, TINY))
    return (stiff * refinement_change(distance, size, extent)).max(axis=1, initial=0.0)


def free_edges(area: BaseGeometry, supports: Supports) -> float:
    """Return half the length of the free boundary over the area [1/m]."""
    slack = _slack(area)
    free = area.boundary.difference(_supported(area, supports, slack).buffer(slack))
    return float(free.length / (2 * area.area))


def _supported(area: BaseGeometry, supports: Supports, slack: float) -> BaseGeometry:
    """Return the parts of the boundary that are not free; later edges win."""
    lines: BaseGeometry = shapely.union_all(
        [
            shapely.LineString(ring)
            for polygon in shapely.get_parts(area)
            for ring, kind in [
                (polygon.exterior, supports.outline),
                *((inner, supports.holes) for inner in polygon.interiors),
            ]
            if kind != "free"
        ]
    )
    for edge in supports.edges:
        line = shapely.LineString([edge.start, edge.end])
        lines = lines.difference(line.buffer(slack))
        if edge.kind != "free":
            lines = lines.union(line)
    return lines


def _slack(area: BaseGeometry) -> float:
    bounds: Array = np.asarray(area.bounds)
    return SLACK * float(np.max(bounds[2:] - bounds[:2]))
