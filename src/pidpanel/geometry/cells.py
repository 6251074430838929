"""Shapes of the honeycomb cells: the one registry.

The study offers the names, a packing's walls and area come from the outline, the report draws the
same outline and writes the name. The corners enter the label of a packing, the name does not.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from pidpanel.arrays import Array

ShapeName = Literal["hexagon", "square", "circle"]

# Bulk fraction of a poured bed in a wide cell [1], and what diameter over width takes of it: good
# to 3 % in hexagons of 4.8 to 12.7 mm with spheres of 1 to 2.5 mm, to 8 % with wider ones.
BULK_WIDE, BULK_PER_WIDTH = 0.60, 0.45


@dataclass(frozen=True)
class CellShape:
    """A regular prism in place of a cell."""

    corners: int
    word: str  # for "… cells"
    round: bool = False  # whether it is in place of a circle, whose area it then has

    def outline(self, across_flats: float) -> Array:
        """Return the corners of a cell round the origin, (corners, 2) [m], anticlockwise.

        ``across_flats`` is the width between opposite sides, or the diameter of the circle [m], a
        polygon of 24 sides with its area, whose corners are 0.6 % of the radius outside it.
        """
        corners, inradius = self.corners, across_flats / 2
        if self.round:
            inradius *= math.sqrt(math.pi / (corners * math.tan(math.pi / corners)))
        angle = 2 * math.pi * (np.arange(corners) + 0.5) / corners
        reach = inradius / math.cos(math.pi / corners)
        return reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)


# A further regular shape is a name in `ShapeName` and a line here.
SHAPES: Mapping[ShapeName, CellShape] = {
    "hexagon": CellShape(6, "hexagonal"),
    "square": CellShape(4, "square"),
    "circle": CellShape(24, "round", round=True),
}


def bulk_fraction(diameter: float, across_flats: float) -> float:
    """Return about the volume of poured spheres over that of their cell [1].

    Parameters
    ----------
    diameter, across_flats
        Diameter of a sphere and width of the cell across flats [m].

    Examples
    --------
    >>> round(bulk_fraction(2e-3, 6.35e-3), 3)
    0.458
    """
    return max(BULK_WIDE - BULK_PER_WIDTH * diameter / across_flats, 0.3)
