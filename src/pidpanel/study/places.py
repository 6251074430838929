"""Places of a structure in space: areas of its surface, points, directions."""

import itertools
import math
from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import AfterValidator, Field

from pidpanel.study.base import Coordinate, SectionModel, Size, Text
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity, whole

Place = tuple[Coordinate, Coordinate, Coordinate]
Direction = tuple[float, float, float]
NO_AREA = 1e-6  # area of a polygon over the square of its size, by rounding


def _check_direction(direction: Direction) -> Direction:
    if not any(direction):
        raise ValueError("must not be the zero vector")
    return direction


Along = Annotated[Direction, AfterValidator(_check_direction)]


def _has_area(corners: tuple[Place, ...], along: Direction) -> bool:
    """Return whether a polygon has an area as it is projected along a direction."""
    arms = [[x - x0 for x, x0 in zip(corner, corners[0], strict=True)] for corner in corners[1:]]
    pairs = itertools.pairwise(arms)
    area = math.fsum(
        along[k] * (a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2]) for a, b in pairs for k in range(3)
    )
    size = max(math.hypot(*arm) for arm in arms)
    return abs(area) > NO_AREA * size**2 * math.hypot(*along)


class SurfaceArea(SectionModel):
    """Elements of a surface: a group, or those with a middle in a sphere, box, ring, polygon."""

    group: Text | None = None
    """Group of the file: an element set, a property number, a physical group."""
    centre_m: Place | None = None
    """Centre of a sphere, or a point on the axis of a ring (x, y, z) [m]."""
    radius_m: Size | None = None
    """Radius of a sphere [m]."""
    from_m: Place | None = None
    """Corner of a box with the least coordinates (x, y, z) [m]."""
    to_m: Place | None = None
    """Corner of a box with the greatest coordinates (x, y, z) [m]."""
    radii_m: tuple[Annotated[float, Quantity(0, 30)], Size] | None = None
    """Inner and outer radius of a ring about the axis [m]."""
    corners_m: Annotated[tuple[Place, ...], Field(min_length=3)] | None = None
    """Corners of a polygon (x, y, z) in order [m], projected along a direction."""
    along: Along | None = None
    """Axis of a ring, or direction in which a polygon is projected (x, y, z)."""
    normal: Along | None = None
    """Direction of the motion of the particles (x, y, z); by default the mean normal of the
    elements."""
    forms: ClassVar = (
        ("group",),
        ("centre_m", "radius_m"),
        ("from_m", "to_m"),
        ("centre_m", "radii_m", "along"),
        ("corners_m", "along"),
    )

    def mistakes(self) -> Iterator[Mistake]:
        if self.radii_m is not None and self.radii_m[0] >= self.radii_m[1]:
            yield Mistake(("radii_m",), "must have the smaller radius first")
        if self.corners_m and self.along and not _has_area(self.corners_m, self.along):
            yield Mistake(("corners_m",), "must be no line as seen along the direction of along")
        if self.from_m and self.to_m:
            for axis, (low, high) in enumerate(zip(self.from_m, self.to_m, strict=True)):
                if low >= high:
                    yield Mistake(("to_m", axis), f"must be above from_m, {low:g}")


class SurfacePoint(SectionModel):
    """A point at which the response is computed, and the direction of its motion."""

    node: Annotated[int, whole(1, 10**9)] | None = None
    """Number of a node in the mesh file."""
    at_m: Place | None = None
    """Position (x, y, z) [m]; the nearest node of the surface counts."""
    direction: Along | None = None
    """Direction of the motion (x, y, z); by default that of the normal of the surface."""
    forms: ClassVar = (("node",), ("at_m",))
