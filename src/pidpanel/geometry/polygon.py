"""Plane shapes as polygons: outlines, holes and patches, and whether one lies on another.

Circles and rounded corners are polygons of short straight pieces; those of a corner turn by at
most 7.5° each. The predicates are shapely's.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
import shapely
from numpy.typing import ArrayLike

from pidpanel.arrays import Array

Position = tuple[float, float]

PIECE_TURN = np.radians(7.5)
# Tolerance over the extent of a panel: far above rounding, far below any detail.
SLACK = 1e-9


class Shape(Protocol):
    """Anything with corners in order, the first not repeated; ``str()`` is for messages."""

    @property
    def corners(self) -> Array:
        """(n, 2) [m]."""


@dataclass(frozen=True)
class Rectangle:
    """An axis-parallel rectangle by its centre and its edge lengths along x and y [m]."""

    centre: Position
    size: tuple[float, float]

    @property
    def corners(self) -> Array:
        """Counter-clockwise from the lower left, (4, 2) [m]."""
        half = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
        return self.centre + half * self.size

    def __str__(self) -> str:
        """Return the rectangle as a product of intervals in metres."""
        (x0, y0), (x1, y1) = self.corners[[0, 2]]
        return f"[{x0:g}, {x1:g}] x [{y0:g}, {y1:g}] m"


@dataclass(frozen=True)
class Circle:
    """A disc as a regular polygon with its corners on the circle.

    The frequencies of a simply supported thin disc are 0.04 % off with 48 pieces and 6 % with 24.
    """

    centre: Position
    radius: float
    pieces: int = 48

    @classmethod
    def of_equal_area(cls, centre: Position, radius: float, pieces: int = 24) -> "Circle":
        """Return the regular polygon with the area of the disc."""
        turn = 2 * np.pi / pieces
        return cls(centre, radius * np.sqrt(turn / np.sin(turn)), pieces)

    @property
    def corners(self) -> Array:
        """Corners of the regular polygon, (pieces, 2) [m]."""
        angle = 2 * np.pi / self.pieces * np.arange(self.pieces)
        return self.centre + self.radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def __str__(self) -> str:
        """Return centre and radius in metres."""
        return f"circle of radius {self.radius:g} m about {show(self.centre)}"


@dataclass(frozen=True)
class Polygon:
    """A polygon by its corners [m], the first not repeated; all rounded by a radius [m]."""

    points: tuple[Position, ...]
    radius: float = 0.0

    @property
    def corners(self) -> Array:
        """Corners, with the arcs of rounded ones as straight pieces, (n, 2) [m]."""
        return rounded(self.points, self.radius)

    def __str__(self) -> str:
        """Return the corners in metres."""
        rounding = f", rounded by {self.radius:g} m" if self.radius else ""
        return ", ".join(f"({x:g}, {y:g})" for x, y in self.points) + f" m{rounding}"


def show(position: Sequence[float]) -> str:
    """Return a position in metres as text."""
    return f"({position[0]:g}, {position[1]:g}) m"


def signed_area(corners: ArrayLike) -> float:
    """Return the area of a polygon [m²], negative if its corners go round clockwise.

    Examples
    --------
    >>> signed_area([(0, 0), (2, 0), (2, 1), (0, 1)])
    2.0
    """
    x, y = (np.asarray(corners, dtype=float) - np.asarray(corners, dtype=float)[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def rounded(points: Sequence[Position], radius: float) -> Array:
    """Return the corners (n, 2) [m] of a polygon, each cut by an arc of straight pieces.

    The pieces' ends lie on the arc, which touches both edges. Raises `ValueError` if two arcs need
    more than the edge between them.
    """
    corners = np.asarray(points, dtype=float)
    if radius == 0 or abs(signed_area(corners)) <= 1e-12 * np.ptp(corners, axis=0).max() ** 2:
        return corners  # `check_simple` refuses what has no area
    step = np.roll(corners, -1, axis=0) - corners
    length = np.linalg.norm(step, axis=1)
    direction = step / length[:, None]
    previous = np.roll(direction, 1, axis=0)
    cross = previous[:, 0] * direction[:, 1] - previous[:, 1] * direction[:, 0]
    turn = np.arctan2(cross, np.sum(previous * direction, axis=1))
    cut = radius * np.tan(np.abs(turn) / 2)
    needed = cut + np.roll(cut, -1)
    worst = int(np.argmax(needed / length))
    if needed[worst] > length[worst] * (1 + SLACK):
        raise ValueError(
            f"corner radius {radius:g} m: the edge from {show(corners[worst])} is"
            f" {length[worst]:g} m long, its two arcs need {needed[worst]:g} m"
        )
    arcs = []
    for k, corner in enumerate(corners):
        pieces = max(1, int(np.ceil(abs(turn[k]) / PIECE_TURN - SLACK)))
        start = corner - cut[k] * previous[k]
        normal = np.sign(turn[k]) * np.array([-previous[k, 1], previous[k, 0]])
        centre = start + radius * normal
        angle = turn[k] * np.arange(pieces + 1) / pieces
        spoke = start - centre
        c, s = np.cos(angle), np.sin(angle)
        arcs.append(
            centre + np.column_stack([c * spoke[0] - s * spoke[1], s * spoke[0] + c * spoke[1]])
        )
    arc = np.concatenate(arcs)
    distance = np.linalg.norm(arc - np.roll(arc, 1, axis=0), axis=1)
    return arc[distance > SLACK * length.max()]


def check_distinct(points: Sequence[Position]) -> None:
    """Refuse corners [m] with one given twice in a row.

    Raises
    ------
    ValueError
    """
    for previous, corner in zip((points[-1], *points), points, strict=False):
        if tuple(previous) == tuple(corner):
            raise ValueError(
                f"the corner {show(corner)} is given twice in a row; each is given once, and the "
                "last edge leads back to the first"
            )


def check_simple(name: str, shape: Shape) -> None:
    """Refuse a polygon that has no area or crosses or touches itself."""
    corners = np.asarray(shape.corners, dtype=float)
    if len(corners) < 3:
        raise ValueError(f"{name} has {len(corners)} corners; it needs at least 3")
    extent = np.ptp(corners, axis=0).max()
    if not np.all(np.isfinite(corners)) or abs(signed_area(corners)) <= 1e-12 * extent**2:
        raise ValueError(f"{name} {shape} encloses no area")
    edges = shapely.linestrings(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    tree = shapely.STRtree(edges)
    crossing = tree.query(edges, predicate="crosses").T.tolist()
    if crossing:
        first_edge, second_edge = min(crossing)
        raise ValueError(
            f"{name} crosses itself: the edge from {show(corners[first_edge])} meets the edge"
            f" from {show(corners[second_edge])}"
        )
    near = tree.query(shapely.points(corners), predicate="dwithin", distance=SLACK * extent)
    for corner, edge in sorted(near.T.tolist()):
        if edge not in (corner, (corner - 1) % len(corners)):
            raise ValueError(f"{name} touches itself at {show(corners[corner])}")


def overlap(first: ArrayLike, second: ArrayLike, slack: float) -> bool:
    """Return whether two simple polygons overlap by more than a depth of `slack` [m].

    With a negative slack, whether they overlap or come closer than that.
    """
    return bool(shapely.Polygon(first).buffer(-slack).intersects(shapely.Polygon(second)))


def lies_within(inner: ArrayLike, outer: ArrayLike, slack: float) -> bool:
    """Return whether a simple polygon lies in another, but for at most `slack` [m].

    With a negative slack, whether it lies in the other at least that far from its edge.
    """
    return bool(shapely.Polygon(outer).buffer(slack).covers(shapely.Polygon(inner)))


def check_panel(
    outline: Shape,
    holes: Mapping[str, Shape],
    patches: Mapping[str, Shape],
    points: Mapping[str, Position],
) -> None:
    """Refuse holes, patches and points that do not lie on the panel.

    Parameters
    ----------
    holes
        Must lie inside the outline, apart from it and from each other.
    patches
        May touch edges and each other, or overlap each other, but no hole.

    Raises
    ------
    ValueError
        One line: name, value, what is allowed.
    """
    check_simple("outline", outline)
    around = np.asarray(outline.corners)
    slack = SLACK * float(np.ptp(around, axis=0).max())
    allowed = f"allowed is the inside of the outline {outline}"
    for name, hole in holes.items():
        check_simple(f"hole {name!r}", hole)
        if not lies_within(hole.corners, around, -slack):
            raise ValueError(f"hole {name!r} = {hole} is not inside the panel; {allowed}")
    for (first_name, hole), (second_name, second_hole) in combinations(holes.items(), 2):
        if overlap(hole.corners, second_hole.corners, -slack):
            raise ValueError(f"holes {first_name!r} and {second_name!r} meet; they must lie apart")
    for name, patch in patches.items():
        check_simple(f"patch {name!r}", patch)
        if not lies_within(patch.corners, around, slack):
            raise ValueError(f"patch {name!r} = {patch} leaves the panel; {allowed}")
        for hole_name, hole in holes.items():
            if overlap(patch.corners, hole.corners, slack):
                raise ValueError(
                    f"patch {name!r} = {patch} lies over hole {hole_name!r}; patches must"
                    " not overlap holes"
                )
    for name, point in points.items():
        if shapely.distance(shapely.Polygon(around), shapely.Point(point)) > slack:
            raise ValueError(f"point {name!r} = {show(point)} leaves the panel; {allowed}")
        for hole_name, hole in holes.items():
            if shapely.Polygon(hole.corners).buffer(-slack).contains(shapely.Point(point)):
                raise ValueError(
                    f"point {name!r} = {show(point)} lies in hole {hole_name!r}; points must lie"
                    " on the panel"
                )
