"""Plane shapes as polygons: outlines, holes and patches, and whether one lies on another.

Circles and rounded corners are drawn by straight pieces, corners by pieces that turn by at most
7.5 degrees each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index

Position = tuple[float, float]

PIECE_TURN = np.radians(7.5)
# Of the extent of a panel: far above rounding, far below anything meant.
SLACK = 1e-9


class Shape(Protocol):
    """Whatever has corners, in order, the first not repeated; str() shows it."""

    @property
    def corners(self) -> Array:
        """(n, 2) [m]."""


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

    centre: Position
    size: tuple[float, float]

    @property
    def lower(self) -> Position:
        """Corner with the smallest x and y [m]."""
        return (self.centre[0] - self.size[0] / 2, self.centre[1] - self.size[1] / 2)

    @property
    def upper(self) -> Position:
        """Corner with the largest x and y [m]."""
        return (self.centre[0] + self.size[0] / 2, self.centre[1] + self.size[1] / 2)

    @property
    def corners(self) -> Array:
        """Counter-clockwise from the lower left, (4, 2) [m]."""
        (x0, y0), (x1, y1) = self.lower, self.upper
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])

    def __str__(self) -> str:
        """Show the rectangle as a product of intervals in metres."""
        (x0, y0), (x1, y1) = self.lower, self.upper
        return f"[{x0:g}, {x1:g}] x [{y0:g}, {y1:g}] m"


@dataclass(frozen=True)
class Circle:
    """A disc, drawn by a regular polygon with its corners on the circle.

    Attributes
    ----------
    centre : tuple of float
        Centre (x, y) [m].
    radius : float
        [m].
    pieces : int
        Corners of the polygon. The frequencies of a simply supported thin disc are 0.04 % off
        with 48 and 6 % with 24.
    """

    centre: Position
    radius: float
    pieces: int = 48

    @classmethod
    def of_equal_area(cls, centre: Position, radius: float, pieces: int = 24) -> "Circle":
        """The regular polygon with the area of the disc."""
        turn = 2 * np.pi / pieces
        return cls(centre, radius * np.sqrt(turn / np.sin(turn)), pieces)

    @property
    def corners(self) -> Array:
        """Of the regular polygon, (pieces, 2) [m]."""
        angle = 2 * np.pi / self.pieces * np.arange(self.pieces)
        return self.centre + self.radius * np.column_stack([np.cos(angle), np.sin(angle)])

    def __str__(self) -> str:
        """Show centre and radius in metres."""
        return f"circle of radius {self.radius:g} m about {show(self.centre)}"


@dataclass(frozen=True)
class Polygon:
    """A polygon by its corners, which may be rounded.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (x, y) [m], in order, the first not repeated.
    radius : float
        Radius of every corner [m].
    """

    points: tuple[Position, ...]
    radius: float = 0.0

    @property
    def corners(self) -> Array:
        """With the arcs of rounded corners as straight pieces, (n, 2) [m]."""
        return rounded(self.points, self.radius)

    def __str__(self) -> str:
        """Show the corners in metres."""
        rounding = f", rounded by {self.radius:g} m" if self.radius else ""
        return ", ".join(f"({x:g}, {y:g})" for x, y in self.points) + f" m{rounding}"


def show(position: Sequence[float]) -> str:
    """Show a position in metres."""
    return f"({position[0]:g}, {position[1]:g}) m"


def signed_area(corners: ArrayLike) -> float:
    """Area of a polygon [m^2], negative if its corners go round clockwise.

    Examples
    --------
    >>> signed_area([(0, 0), (2, 0), (2, 1), (0, 1)])
    2.0
    """
    x, y = (np.asarray(corners, dtype=float) - np.asarray(corners, dtype=float)[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def centroid(corners: ArrayLike) -> Position:
    """Centre of area of a polygon [m].

    Examples
    --------
    >>> centroid([(0, 0), (2, 0), (2, 1), (0, 1)])
    (1.0, 0.5)
    """
    points = np.asarray(corners, dtype=float)
    origin = points[0]
    x, y = (points - origin).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    around = np.array([np.sum((u + np.roll(u, -1)) * cross) for u in (x, y)])
    middle = origin + around / (3 * np.sum(cross))
    return float(middle[0]), float(middle[1])


def rounded(points: Sequence[Position], radius: float) -> Array:
    """Corners of a polygon with every corner cut by an arc of straight pieces.

    The pieces' ends lie on the arc, which touches both edges.

    Parameters
    ----------
    points : sequence of tuple of float
        [m].
    radius : float
        [m]; 0 leaves the corners.

    Returns
    -------
    ndarray, shape (n, 2)
        [m].

    Raises
    ------
    ValueError
        If two arcs need more than the edge between them.
    """
    corners = np.asarray(points, dtype=float)
    if radius == 0:
        return corners
    step = np.roll(corners, -1, axis=0) - corners
    length = np.linalg.norm(step, axis=1)
    along = step / length[:, None]
    before = np.roll(along, 1, axis=0)
    cross = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    turn = np.arctan2(cross, np.sum(before * along, axis=1))
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
        start = corner - cut[k] * before[k]
        normal = np.sign(turn[k]) * np.array([-before[k, 1], before[k, 0]])
        centre = start + radius * normal
        angle = turn[k] * np.arange(pieces + 1) / pieces
        spoke = start - centre
        c, s = np.cos(angle), np.sin(angle)
        arcs.append(
            centre + np.column_stack([c * spoke[0] - s * spoke[1], s * spoke[0] + c * spoke[1]])
        )
    arc = np.concatenate(arcs)
    apart = np.linalg.norm(arc - np.roll(arc, 1, axis=0), axis=1)
    return arc[apart > SLACK * length.max()]


def check_simple(name: str, shape: Shape) -> None:
    """Refuse a polygon that has no area or crosses or touches itself.

    Raises
    ------
    ValueError
    """
    corners = np.asarray(shape.corners, dtype=float)
    if len(corners) < 3:
        raise ValueError(f"{name} has {len(corners)} corners; it needs at least 3")
    extent = np.ptp(corners, axis=0).max()
    if not np.all(np.isfinite(corners)) or abs(signed_area(corners)) <= 1e-12 * extent**2:
        raise ValueError(f"{name} {shape} encloses no area")
    following = np.roll(corners, -1, axis=0)
    for i in range(len(corners)):
        for j in range(i + 1, len(corners)):
            if crosses(corners[i], following[i], corners[j], following[j]):
                raise ValueError(
                    f"{name} crosses itself: the edge from {show(corners[i])} meets the edge"
                    f" from {show(corners[j])}"
                )
    for i, corner in enumerate(corners):
        others = np.delete(np.arange(len(corners)), [i, i - 1])
        gap = _distance(corner[None], corners[others], following[others])[0]
        if gap.size and gap.min() <= SLACK * extent:
            raise ValueError(f"{name} touches itself at {show(corner)}")


def crosses(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the inside of the segment a–b crosses that of c–d."""
    return _side(a, b, c) * _side(a, b, d) < 0 and _side(c, d, a) * _side(c, d, b) < 0


def _side(a: Array, b: Array, p: Array) -> float:
    """Which side of a–b a point lies on; 0 within rounding of the line."""
    along, away = b - a, p - a
    cross = along[0] * away[1] - along[1] * away[0]
    return 0.0 if abs(cross) <= SLACK * (along @ along) else float(np.sign(cross))


def _distance(points: Array, start: Array, end: Array) -> Array:
    """Distances (n_points, n_segments) of points from segments."""
    along = end - start
    share = np.einsum("psk,sk->ps", points[:, None] - start, along) / np.sum(along**2, axis=1)
    foot = start + np.clip(share, 0, 1)[..., None] * along
    return np.asarray(np.linalg.norm(points[:, None] - foot, axis=-1))


def location(points: ArrayLike, corners: ArrayLike, slack: float) -> Index:
    """Whether points lie inside a polygon (1), on its edge (0) or outside (-1).

    Examples
    --------
    >>> location([(0.5, 0.5), (1, 0.5), (2, 0.5)], [(0, 0), (1, 0), (1, 1), (0, 1)], 1e-9)
    array([ 1,  0, -1])
    """
    at = np.asarray(points, dtype=float).reshape(-1, 2)
    start = np.asarray(corners, dtype=float)
    end = np.roll(start, -1, axis=0)
    on_edge = _distance(at, start, end).min(axis=1) <= slack
    x, y = at.T[:, :, None]
    spans = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(end[:, 1] == start[:, 1], 1.0, end[:, 1] - start[:, 1])
    left_of = x < start[:, 0] + (y - start[:, 1]) / rise * (end[:, 0] - start[:, 0])
    inside = np.sum(spans & left_of, axis=1) % 2 == 1
    return np.where(on_edge, 0, np.where(inside, 1, -1))


def overlap(one: ArrayLike, other: ArrayLike, slack: float) -> bool:
    """Whether the insides of two simple polygons have a point in common."""
    return bool(
        _edges_cross(one, other)
        or np.any(location(_samples(one), other, slack) > 0)
        or np.any(location(_samples(other), one, slack) > 0)
        or location([_inner_point(one)], other, slack)[0] > 0
    )


def within(inner: ArrayLike, outer: ArrayLike, slack: float) -> bool:
    """Whether a simple polygon lies in another, whose edge it may touch."""
    return not (
        _edges_cross(inner, outer)
        or np.any(location(_samples(inner), outer, slack) < 0)
        or np.any(location(_samples(outer), inner, slack) > 0)
    )


def _edges_cross(one: ArrayLike, other: ArrayLike) -> bool:
    a, c = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    b, d = np.roll(a, -1, axis=0), np.roll(c, -1, axis=0)
    return any(crosses(a[i], b[i], c[j], d[j]) for i in range(len(a)) for j in range(len(c)))


def _samples(corners: ArrayLike) -> Array:
    """Corners and middles of the edges."""
    points = np.asarray(corners, dtype=float)
    return np.concatenate([points, (points + np.roll(points, -1, axis=0)) / 2])


def _inner_point(corners: ArrayLike) -> Array:
    """A point inside a simple polygon: between two crossings of a line through its middle."""
    points = np.asarray(corners, dtype=float)
    heights = np.unique(points[:, 1])
    gap = int(np.argmax(np.diff(heights)))
    y = (heights[gap] + heights[gap + 1]) / 2
    end = np.roll(points, -1, axis=0)
    spans = (points[:, 1] > y) != (end[:, 1] > y)
    p, q = points[spans], end[spans]
    x = np.sort(p[:, 0] + (y - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0]))
    return np.array([(x[0] + x[1]) / 2, y])


def check_panel(
    outline: Shape,
    holes: Mapping[str, Shape],
    patches: Mapping[str, Shape],
    points: Mapping[str, Position],
) -> None:
    """Refuse holes, patches and points that do not lie on the panel.

    Parameters
    ----------
    outline : Shape
    holes : mapping of str to Shape
        Must lie inside the outline, apart from it and from each other.
    patches : mapping of str to Shape
        May touch edges and each other, or overlap each other, but no hole.
    points : mapping of str to tuple of float
        May lie on edges.

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
        samples = _samples(hole.corners)
        if not within(hole.corners, around, slack) or np.any(location(samples, around, slack) == 0):
            raise ValueError(f"hole {name!r} = {hole} is not inside the panel; {allowed}")
        for other in holes:
            if other == name:
                break
            if overlap(hole.corners, holes[other].corners, slack) or np.any(
                location(samples, holes[other].corners, slack) == 0
            ):
                raise ValueError(f"holes {other!r} and {name!r} meet; they must lie apart")
    for name, patch in patches.items():
        check_simple(f"patch {name!r}", patch)
        if not within(patch.corners, around, slack):
            raise ValueError(f"patch {name!r} = {patch} leaves the panel; {allowed}")
        for hole_name, hole in holes.items():
            if overlap(patch.corners, hole.corners, slack):
                raise ValueError(
                    f"patch {name!r} = {patch} lies over hole {hole_name!r}; patches must lie"
                    " beside holes"
                )
    for name, point in points.items():
        if location([point], around, slack)[0] < 0:
            raise ValueError(f"point {name!r} = {show(point)} leaves the panel; {allowed}")
        for hole_name, hole in holes.items():
            if location([point], hole.corners, slack)[0] > 0:
                raise ValueError(
                    f"point {name!r} = {show(point)} lies in hole {hole_name!r}; points must lie"
                    " on the panel"
                )
