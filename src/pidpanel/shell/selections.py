"""Parts of space that select elements, nodes and edges of a shell."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import shapely

from pidpanel.arrays import Array, Flags
from pidpanel.geometry.plane_mesh import plane_axes

Place = tuple[float, float, float]


class Selection(Protocol):
    """A part of space."""

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) [m] lie within, or nearer than ``slack`` [m]."""


@dataclass(frozen=True)
class Box:
    """A box along the axes, by its lowest and highest corner [m]."""

    low: Place
    high: Place

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) lie between both corners."""
        low, high = np.array(self.low) - slack, np.array(self.high) + slack
        return np.asarray(((position >= low) & (position <= high)).all(axis=-1))


@dataclass(frozen=True)
class Sphere:
    """A ball by its centre and radius [m]."""

    centre: Place
    radius: float

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) are no farther from the centre than the radius."""
        distance = np.linalg.norm(position - np.array(self.centre), axis=-1)
        return np.asarray(distance <= self.radius + slack)


@dataclass(frozen=True)
class Ring:
    """What lies between two radii from an axis [m], at any height along it."""

    inner: float
    outer: float
    centre: Place = (0.0, 0.0, 0.0)
    axis: Place = (0.0, 0.0, 1.0)

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) have such a distance from the axis."""
        arm = position - np.array(self.centre)
        axis = np.array(self.axis) / np.linalg.norm(self.axis)
        radius = np.linalg.norm(arm - (arm @ axis)[..., None] * axis, axis=-1)
        return np.asarray((radius >= self.inner - slack) & (radius <= self.outer + slack))


@dataclass(frozen=True)
class Line:
    """A straight line between two places [m]."""

    start: Place
    end: Place

    @property
    def length(self) -> float:
        """Distance of the ends [m]."""
        return float(np.linalg.norm(np.subtract(self.end, self.start)))

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) are on the line."""
        arm, step = position - np.array(self.start), np.subtract(self.end, self.start)
        share = np.clip(arm @ step / (step @ step), 0.0, 1.0)
        return np.asarray(np.linalg.norm(arm - share[..., None] * step, axis=-1) <= slack)


@dataclass(frozen=True)
class Prism:
    """What lies within a polygon that is projected along a direction."""

    corners: tuple[Place, ...]
    along: Place

    def contains(self, position: Array, slack: float = 0.0) -> Flags:
        """Return whether positions (..., 3) lie within the polygon as they are projected."""
        plane = plane_axes(np.array(self.along))
        outline = shapely.Polygon(np.array(self.corners) @ plane).buffer(slack)
        return np.asarray(shapely.contains_xy(outline, *np.moveaxis(position @ plane, -1, 0)))
