"""The section ``panel`` of a study: outline, supports, masses, mesh, patches, points."""

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from pidpanel.damping_ratio import DampingRatio
from pidpanel.geometry.polygon import (
    Circle,
    Polygon,
    Rectangle,
    Shape,
    check_distinct,
    check_panel,
    show,
    signed_area,
)
from pidpanel.study.base import SectionModel, Size, Text
from pidpanel.study.choice import Choice
from pidpanel.study.damping_ratio import DampingRatios, damping_ratio_of, mistakes_of_damping_ratio
from pidpanel.study.mesh import MOST_ELEMENTS, Mesh, MeshFile, Quadrilaterals, Triangles
from pidpanel.study.mistakes import Keys, Mistake, mistakes_of_names
from pidpanel.study.quantity import Quantity
from pidpanel.study.section import Section
from pidpanel.study.supports import EdgeKind, Mass, Node, PointSupportInput, Position, SupportsInput

EXTENT = Quantity(0.01, 30, unit="metres")  # of a panel [m]
Length = Annotated[float, EXTENT]
Radius = Annotated[float, Quantity(0, 15, unit="metres")]  # of corners [m]
MOST_CARRIED = 5  # heaviest mass on a panel, or of all its dampers, over that of the panel


def _mistakes_of_corners(shape: Shape | None, key: str) -> Iterator[Mistake]:
    """Yield corners of a key that are given twice, and a corner radius that does not fit."""
    try:
        if isinstance(shape, Polygon):
            check_distinct(shape.points)
        _ = shape.corners if shape else None
    except ValueError as error:
        is_radius = str(error).startswith("corner radius")
        yield Mistake(("corner_radius_m" if is_radius else key,), str(error))


class Area(SectionModel):
    """A rectangle (centre_m, size_m), a circle (centre_m, diameter_m) or a polygon (corners_m)."""

    centre_m: Position | None = None
    """Centre (x, y) of a rectangle or circle [m]."""
    size_m: tuple[Size, Size] | None = None
    """Lengths along x and y of a rectangle [m]."""
    diameter_m: Size | None = None
    """Diameter of a circle [m]."""
    corners_m: Annotated[tuple[Position, ...], Field(min_length=3)] | None = None
    """Corners (x, y) of a polygon in order [m]."""
    corner_radius_m: Radius = 0.0
    """Radius of all corners of the polygon [m]."""
    forms: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("centre_m", "size_m"),
        ("centre_m", "diameter_m"),
        ("corners_m",),
    )

    def mistakes(self) -> Iterator[Mistake]:
        if self.corner_radius_m and self.corners_m is None:
            yield Mistake(("corner_radius_m",), "only allowed with corners_m")
        else:
            yield from _mistakes_of_corners(self.shape, "corners_m")

    def _circle(self, centre: Position, radius: float) -> Circle:
        return Circle(centre, radius)

    @property
    def shape(self) -> Shape | None:
        """The area [m]; None where a mesh file has it."""
        if self.corners_m is not None:
            return Polygon(self.corners_m, self.corner_radius_m)
        if self.centre_m is None:
            return None
        if self.size_m is not None:
            return Rectangle(self.centre_m, self.size_m)
        return self._circle(self.centre_m, (self.diameter_m or 0.0) / 2)


class Patch(Area):
    """Cells that may be filled with particles; or a group (property number) of a mesh file."""

    group: Text | None = None
    """Property number (Nastran) or physical group (gmsh) of a mesh file, instead of a shape."""
    forms: ClassVar = (*Area.forms, ("group",))

    def _circle(self, centre: Position, radius: float) -> Circle:
        return Circle.of_equal_area(centre, radius)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """(x_min, x_max, y_min, y_max) [m]."""
        corners = self.shape.corners  # type: ignore[union-attr]
        (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
        return tuple(round(float(v), 12) for v in (x0, x1, y0, y1))  # type: ignore[return-value]


class Panel(SectionModel):
    """The panel, its patches, and the points at which its response is computed."""

    outline_m: (
        Annotated[
            tuple[Length, Length] | Annotated[tuple[Position, ...], Field(min_length=3)], Choice()
        ]
        | None
    ) = None
    """Lengths along x and y of a rectangle, or the corners of a polygon [m]."""
    corner_radius_m: Radius = 0.0
    """Radius of all corners of the outline [m]."""
    holes: Mapping[str, Area] = {}
    """Cut-outs, by name."""
    section: Section
    """Mass and stiffness through the thickness."""
    supports: Annotated[EdgeKind | SupportsInput, Choice()] = "simply_supported"
    """Support of the whole outline, or supports of its parts. ``simply_supported``: w = 0 and
    no rotation along the edge; ``simply_supported_soft``: w = 0; ``clamped``: w = 0 and no
    slope; ``free``."""
    in_plane_edges: Literal["free", "held"] = "free"
    """Whether supported edges can move in the plane of the panel: ``free``, as on hinges or a
    suspension, or ``held``, as in a stiff frame. A deflection of more than a tenth of the thickness
    stretches the panel, far more if its edges are held."""
    masses: Mapping[str, Mass] = {}
    """Masses on the panel, by name."""
    damping_ratio: DampingRatios = 0.01
    """Damping ratio ζ of the modes of the bare panel; 0.01 is 1 %. A list has that of each elastic
    mode in turn, the last for all that follow; a list of [frequency in Hz, ζ], or a CSV file with
    the columns ``frequency_hz`` and ``damping_ratio``, that over frequency: linear in its
    logarithm, constant beyond its ends."""
    mesh: Mesh = Quadrilaterals()
    """Finite elements of the panel."""
    patches: Mapping[str, Patch] = {}
    """Areas whose cells may be filled, by name."""
    points: Annotated[Mapping[str, Annotated[Position | Node, Choice()]], Field(min_length=1)]
    """Points at which the response is computed, by name: (x, y) [m], or a node of a mesh file."""

    modes: ClassVar[None] = None  # from a file, which a structure may have

    @property
    def modal_damping(self) -> DampingRatio:
        """ζ of the modes of the bare panel.

        Raises
        ------
        ColumnsError
            If its file has faults; all are listed.
        """
        return damping_ratio_of(self.damping_ratio)

    @property
    def corner_size(self) -> float | None:
        """Edge length of triangles at corners [m]; None where none is stated."""
        return getattr(self.mesh, "corner_size_m", None)

    @property
    def size(self) -> tuple[float, float] | None:
        """Lengths along x and y of a rectangle without holes and rounded corners [m]."""
        match self.outline_m:
            case (float(a), float(b)) if not self.holes and not self.corner_radius_m:
                return a, b
        return None

    @property
    def outline(self) -> Polygon | None:
        """The outer edge [m]; None where a mesh file has it."""
        match self.outline_m:
            case None:
                return None
            case (float(a), float(b)):
                return Polygon(((0.0, 0.0), (a, 0.0), (a, b), (0.0, b)), self.corner_radius_m)
            case corners:
                return Polygon(tuple((x, y) for x, y in corners), self.corner_radius_m)

    @property
    def support_input(self) -> SupportsInput:
        """The supports, written out."""
        if isinstance(self.supports, str):
            return SupportsInput(outline=self.supports)
        return self.supports

    @property
    def single_points(self) -> tuple[str, ...]:
        """Names of points that make frequencies depend logarithmically on the mesh.

        With transverse shear these are supports without a foot, springs and point masses; on a thin
        plate hold-downs without a foot, since a point support of it cannot prevent rotation.
        """
        points = self.support_input.points.items()
        if self.section.kind == "thin":
            return tuple(n for n, p in points if p.kind == "hold_down" and not p.radius_m)
        supports = (name for name, p in points if not p.radius_m)
        return (*supports, *(name for name, mass in self.masses.items() if mass.from_m is None))

    def places(self) -> Iterator[tuple[Keys, Position | Node | PointSupportInput | Mass]]:
        """Yield everything with a position or a node of a mesh file, with its key path."""
        yield from ((("points", name), point) for name, point in self.points.items())
        for name, support in self.support_input.points.items():
            yield ("supports", "points", name), support
        yield from ((("masses", name), mass) for name, mass in self.masses.items())

    def mistakes(self) -> Iterator[Mistake]:
        for key in ("patches", "points", "holes", "masses"):
            yield from mistakes_of_names(key, getattr(self, key))
        mistakes = mistakes_of_names("points", self.support_input.points)
        yield from (mistake.prefix("supports") for mistake in mistakes)
        first = [
            *_mistakes_of_corners(self.outline, "outline_m"),
            *self._mistakes_of_extent(),
            *self._mistakes_of_mesh(),
            *mistakes_of_damping_ratio(self.damping_ratio),
            *self._mistakes_of_edges(),
        ]
        yield from first or self._mistakes_of_place()

    def _mistakes_of_edges(self) -> Iterator[Mistake]:
        supports = self.support_input
        kinds = {supports.outline, supports.holes, *(edge.kind for edge in supports.edges)}
        if self.in_plane_edges == "held" and kinds == {"free"}:
            yield Mistake(("in_plane_edges",), "must be free; no edge of the panel is supported")

    def _mistakes_of_extent(self) -> Iterator[Mistake]:
        """Yield an outline that is too small, too large or has too many elements."""
        if self.outline is None:
            return
        xs, ys = zip(*self.outline.points, strict=True)
        extent = max(max(xs) - min(xs), max(ys) - min(ys))
        message = EXTENT.refuses(extent)
        if message:
            yield Mistake(("outline_m",), f"extends over {extent:g} m; {message}")
        elif isinstance(self.mesh, Triangles):
            area = abs(signed_area(self.outline.points))
            # equilateral triangles
            count = area / (math.sqrt(3) / 4 * self.mesh.size_m**2)
            if count > MOST_ELEMENTS:
                smallest = self.mesh.size_m * math.sqrt(count / MOST_ELEMENTS)
                smallest = math.ceil(smallest * 1e4) / 1e4
                message = f"about {count:.2g} elements; allowed are {MOST_ELEMENTS}, with size_m "
                yield Mistake(("mesh", "size_m"), f"{message}from {smallest:g}")

    def _mistakes_of_mesh(self) -> Iterator[Mistake]:
        if self.mesh.kind == "file":
            for key in ("outline_m", "corner_radius_m", "holes"):
                if getattr(self, key):
                    yield Mistake((key,), "not allowed with mesh: {kind: file}, which has its own")
            return
        if self.outline_m is None:
            yield Mistake(("outline_m",), "missing; required unless mesh: {kind: file} is given")
        for keys, place in self.places():
            if getattr(place, "grid", None) is not None:
                yield Mistake((*keys, "grid"), "only allowed with mesh: {kind: file}")
        for name, patch in self.patches.items():
            if patch.group is not None:
                yield Mistake(("patches", name, "group"), "only allowed with mesh: {kind: file}")
        if self.mesh.kind == "quadrilaterals" and self.outline_m is not None:
            yield from self._mistakes_of_quadrilaterals()

    def _mistakes_of_quadrilaterals(self) -> Iterator[Mistake]:
        reasons = [] if self.size is not None else ["an outline other than a whole rectangle"]
        for name, patch in self.patches.items():
            if not isinstance(patch.shape, Rectangle):
                reasons.append(f"patches.{name}, which is not a rectangle")
        if self.section.kind != "thin":
            reasons.append(f"section.kind = {self.section.kind}")
        for name, support in self.support_input.points.items():
            if support.radius_m:
                reasons.append(f"supports.points.{name}.radius_m")
        if reasons:
            message = f"quadrilaterals do not allow {'; '.join(reasons)}; "
            yield Mistake(("mesh", "kind"), message + "use mesh: {kind: triangles, size_m: …}")

    def _mistakes_of_place(self) -> Iterator[Mistake]:
        positions = {name: point for name, point in self.points.items() if isinstance(point, tuple)}
        if self.size is not None:
            length, width = self.size
            panel = f"must lie on the panel, x 0…{length:g} m, y 0…{width:g} m"
            for name, patch in self.patches.items():
                x0, x1, y0, y1 = patch.bounds
                if x0 < 0 or y0 < 0 or x1 > length or y1 > width:
                    message = f"{panel}; it covers x {x0:g}…{x1:g} m, y {y0:g}…{y1:g} m"
                    yield Mistake(("patches", name), message)
            for name, (x, y) in positions.items():
                if not (0 <= x <= length and 0 <= y <= width):
                    yield Mistake(("points", name), panel)
        elif self.outline is not None:
            try:
                check_panel(
                    self.outline,
                    {name: hole.shape for name, hole in self.holes.items() if hole.shape},
                    {name: patch.shape for name, patch in self.patches.items() if patch.shape},
                    positions,
                )
            except ValueError as error:
                yield Mistake(key_path(self, str(error)), str(error))


def key_path(panel: Panel, message: str) -> Keys:
    """Return the key path of the place named at the start of a message about the geometry.

    Parameters
    ----------
    message
        Message such as ``point 'support H1' = (3, 0) m leaves the panel``, with the names that
        `StudiedPanel` gives to places.

    Returns
    -------
    tuple of str or int
        Key path such as ``("supports", "points", "H1", "at_m")``; empty if no place is named.
    """
    matching = [entry for entry in _named_places(panel) if message.startswith(entry[0])]
    return max(matching, key=lambda entry: len(entry[0]))[1] if matching else ()


def _named_places(panel: Panel) -> Iterator[tuple[str, Keys]]:
    yield "outline", ("outline_m",)
    yield "mesh: ", ("mesh",)
    yield "in_plane_edges ", ("in_plane_edges",)
    file = panel.mesh.file if isinstance(panel.mesh, MeshFile) else None
    yield f"{file}:", ("mesh", "file")
    for noun, key in (("patch", "patches"), ("hole", "holes"), ("point", "points")):
        yield from ((f"{noun} {name!r}", (key, name)) for name in getattr(panel, key))
    yield from ((f"{name!r} names", ("points", name)) for name in panel.points)
    for index in range(len(panel.support_input.edges)):
        for end in ("from_m", "to_m"):
            name = f"supports.edges {index + 1} {end}"
            yield f"point {name!r}", ("supports", "edges", index, end)
    for keys, place in panel.places():
        name = str(keys[-1])
        if isinstance(place, PointSupportInput):
            yield f"point {f'support {name}'!r}", (*keys, "at_m")
            yield f"patch {f'foot of {name}'!r}", (*keys, "radius_m")
        elif isinstance(place, Mass):
            if place.at_m is not None:  # with its position: a point may have the same name
                yield f"point {name!r} = {show(place.at_m)}", (*keys, "at_m")
            for end in ("from_m", "to_m"):
                yield f"point {f'{name} {end}'!r}", (*keys, end)
        if not isinstance(place, tuple) and place.grid is not None:
            yield f"{file}: no node {place.grid};", (*keys, "grid")
