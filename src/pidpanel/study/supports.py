"""Supports of the panel and masses on it, at positions or nodes of a mesh file."""

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pidpanel.study.base import Coordinate, SectionModel
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity

Position = tuple[Coordinate, Coordinate]  # (x, y) [m]
EdgeKind = Literal["simply_supported", "simply_supported_soft", "clamped", "free"]
Number = Annotated[int, Quantity(1, whole=True)]  # number of a node in a mesh file


class Node(SectionModel):
    """A node of a mesh file, by its number there."""

    grid: Number
    """Number of the node in the mesh file."""


# Of a line that resists rotation: moment per length and angle [N m/(m rad)].
RotationalStiffness = Annotated[float, Quantity(0, 1e9)]
TURNING = ("simply_supported", "simply_supported_soft")  # edges that may turn


class PointSupportInput(SectionModel):
    """Support at a point: hinge (w = 0), hold_down (w = 0, no slope), or a spring to ground."""

    kind: Literal["hinge", "hold_down", "spring"]
    """``hinge``: w = 0; ``hold_down``: w = 0 and no slope; ``spring``: a spring to ground."""
    at_m: Position | None = None
    """Position (x, y) [m]."""
    grid: Number | None = None
    """Node of a mesh file, instead of ``at_m``."""
    radius_m: Annotated[float, Quantity(0, 5, unit="metres")] = 0.0
    """Radius of the rigid foot of a hinge or a hold-down [m]; 0 for a point."""
    stiffness_n_m: Annotated[float, Quantity(1e-3, 1e12)] | None = None
    """Stiffness of a spring [N/m]."""

    forms: ClassVar = (("at_m",), ("grid",))

    def mistakes(self) -> Iterator[Mistake]:
        if (self.kind == "spring") != (self.stiffness_n_m is not None):
            yield Mistake(("stiffness_n_m",), "required for kind: spring, not allowed otherwise")
        if self.kind == "spring" and self.radius_m:
            yield Mistake(("radius_m",), "only allowed for kind: hinge or hold_down")


class EdgeSupportInput(SectionModel):
    """A different support on a straight part of the boundary."""

    from_m: Position
    """Start (x, y) of the part [m], on the boundary."""
    to_m: Position
    """End (x, y) of the part [m], on the same straight edge."""
    kind: EdgeKind
    """Its support; kinds are those of ``supports``."""
    rotational_stiffness_n_rad: RotationalStiffness = 0.0
    """Moment per length and angle of a spring along a simply supported edge [N m/(m rad)]."""

    def mistakes(self) -> Iterator[Mistake]:
        yield from mistakes_of_spring(self.kind, self.rotational_stiffness_n_rad)


class SupportsInput(SectionModel):
    """Supports of the panel: outline, rims of holes, parts of edges, points."""

    outline: EdgeKind
    """Support of the outer edge; kinds are those of ``panel.supports``."""
    holes: EdgeKind = "free"
    """Support of the rims of all holes."""
    edges: tuple[EdgeSupportInput, ...] = ()
    """Straight parts of the boundary with another support."""
    points: Mapping[str, PointSupportInput] = {}
    """Supports at points, by name."""
    rotational_stiffness_n_rad: RotationalStiffness = 0.0
    """Moment per length and angle of a spring along a simply supported outer edge
    [N m/(m rad)]: 0 lets it turn, 1000 times the bending stiffness over the length of the panel
    all but clamps it."""

    def mistakes(self) -> Iterator[Mistake]:
        yield from mistakes_of_spring(self.outline, self.rotational_stiffness_n_rad)


def mistakes_of_spring(kind: str, stiffness: float) -> Iterator[Mistake]:
    """Yield a spring along an edge that does not turn, or that is free."""
    if stiffness and kind not in TURNING:
        message = f"only allowed for {' or '.join(TURNING)}"
        yield Mistake(("rotational_stiffness_n_rad",), message)


class Mass(SectionModel):
    """A mass at a point (at_m or grid) or spread along a line (from_m, to_m)."""

    mass_kg: Annotated[float, Quantity(1e-6, 2000, unit="mass")]
    """Mass [kg]."""
    at_m: Position | None = None
    """Position (x, y) of a mass at a point [m]."""
    grid: Number | None = None
    """Node of a mesh file, instead of ``at_m``."""
    from_m: Position | None = None
    """Start (x, y) of a mass along a line [m]."""
    to_m: Position | None = None
    """End (x, y) of a mass along a line [m]."""
    forms: ClassVar = (("at_m",), ("grid",), ("from_m", "to_m"))
