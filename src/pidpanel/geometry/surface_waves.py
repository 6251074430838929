"""Shapes on a curved surface against plane waves, from the Gauss points of a box.

In the axes of the surface, z across its thinnest extent, exp(iκz) is a short series of Legendre
polynomials P_m(z/c) on |z| ≤ c. Each load P_m φ is condensed on x and y as that of a flat panel.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array
from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature


@dataclass(frozen=True)
class SurfaceQuadrature:
    """Shapes of a thin surface of any form at the points of a quadrature over it."""

    position: Array  # (nq, 3) points [m]
    normal: Array  # (nq, 3) unit vectors, all on one side
    weight: Array  # (nq,) weights [m²]; they sum to the area
    shape: Array  # (nq, n) displacement of the n shapes along the normal [1]

    @classmethod
    def from_face(cls, face: MovedFace) -> "SurfaceQuadrature":
        """Return the quadrature of a curved face."""
        if face.quadrature_normal is None:
            raise ValueError("a plane face has no normals")
        points, weights = face.quadrature_position, face.quadrature_weight
        return cls(points, face.quadrature_normal, weights, face.shape_at_quadrature)

    @cached_property
    def local(self) -> Array:
        """(nq, 3) points in the axes of the surface from the middle of its box [m].

        The first extent is the longest by mean square, the last the shortest.
        """
        offset = self.position - self.position.mean(axis=0)
        points = offset @ np.linalg.eigh(offset.T @ offset)[1][:, ::-1]
        middle: Array = (points.min(axis=0) + points.max(axis=0)) / 2
        return points - middle

    @property
    def diameter(self) -> float:
        """L [m], diameter of a sphere round the middle that holds all points."""
        return float(2 * np.max(np.linalg.norm(self.local, axis=1)))

    @property
    def half_height(self) -> float:
        """c [m], half the extent along the last axis; 0 of a flat surface, but for rounding."""
        return float(np.abs(self.local[:, 2]).max())

    @property
    def projected(self) -> PanelQuadrature:
        """The quadrature without z: that of a flat panel, if the surface is flat."""
        return PanelQuadrature(self.local[:, :2], self.weight, self.shape)
