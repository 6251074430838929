"""Coordinate systems of a deck: rectangular, cylindrical and spherical, by points or nodes."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.nastran.cards import BLANKS, Card, real_number, whole_number

BY_POINTS = ("CORD2R", "CORD2C", "CORD2S")
BY_NODES = ("CORD1R", "CORD1C", "CORD1S")


class System(NamedTuple):
    """A coordinate system in the basic frame."""

    kind: str  # R, C or S
    origin: Array  # (3,)
    axes: Array  # (3, 3) in columns


class Systems:
    """The coordinate systems of a deck by number."""

    def __init__(
        self, cards: Mapping[int, Card], grids: Mapping[int, tuple[int, list[float]]]
    ) -> None:
        """Take the cards by number, and system and place of the nodes."""
        self.cards, self.grids = cards, grids
        self.systems = {0: System("R", np.zeros(3), np.eye(3))}

    def system(self, number: int, place: str, depth: int = 0) -> System:
        """Return a system; ``place`` is named where there is none."""
        if number not in self.systems:
            if number not in self.cards or depth > len(self.cards):
                allowed = "CORD1R, CORD1C, CORD1S, CORD2R, CORD2C or CORD2S, and not in itself"
                raise ValueError(f"{place}: coordinate system {number} must be a {allowed}")
            card = self.cards[number]
            points = self._points(number, card, depth + 1)
            origin, top, side = points
            z = top - origin
            y = np.cross(z, side - origin)
            if not np.linalg.norm(y) > 1e-9 * np.linalg.norm(z) * np.linalg.norm(side - origin):
                message = f"coordinate system {number} has its three points on a line"
                raise ValueError(f"{card.place}: {card.name}: {message}")
            z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
            axes = np.stack([np.cross(y, z), y, z], axis=1)
            self.systems[number] = System(card.name[-1], origin, axes)
        return self.systems[number]

    def _points(self, number: int, card: Card, depth: int) -> Array:
        """Return origin, point on z and point in the plane of x and z, (3, 3)."""
        fields = [*card.fields, *BLANKS]
        if card.name in BY_POINTS:
            reference = self.system(int(fields[1] or 0), card.place, depth)
            places = np.array([real_number(text) for text in fields[2:11]]).reshape(3, 3)
            return positions(reference, places)
        start = 0 if fields[0] == str(number) else 4
        points = []
        for node in map(whole_number, fields[start + 1 : start + 4]):
            if node not in self.grids:
                raise ValueError(f"{card.place}: {card.name}: node {node} is missing")
            frame, place = self.grids[node]
            points += [positions(self.system(frame, card.place, depth), np.array([place]))[0]]
        return np.array(points)


def positions(system: System, x: Array) -> Array:
    """Return the positions (n, 3) of points that are given in a system, angles in degrees."""
    kind, origin, axes = system
    if kind == "C":
        angle = np.radians(x[:, 1])
        x = np.stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]], axis=1)
    elif kind == "S":
        polar, angle = np.radians(x[:, 1:]).T
        x = x[:, :1] * np.stack(
            [np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=1
        )
    return np.asarray(origin + x @ axes.T)


def frames(system: System, position: Array) -> Array:
    """Return the axes of displacements (n, 3, 3), in columns, at positions (n, 3)."""
    kind, origin, axes = system
    x, y, z = ((position - origin) @ axes).T
    angle, polar = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
    if kind == "R":
        return np.broadcast_to(axes, (len(position), 3, 3))
    zero, (c, s) = np.zeros_like(angle), (np.cos(angle), np.sin(angle))
    round_, height = np.array([-s, c, zero]), np.array([zero, zero, 1 + zero])
    radial = np.array([c, s, zero])
    local = np.array([radial, round_, height])
    if kind == "S":
        across = np.cos(polar) * radial - np.sin(polar) * height
        local = np.array([np.sin(polar) * radial + np.cos(polar) * height, across, round_])
    return axes @ local.transpose(2, 1, 0)
