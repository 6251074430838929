"""Quadrature of linear surface cells: triangles with 3 points, quadrilaterals with 4."""

import numpy as np

from pidpanel.arrays import Array, Index

# Parameters of Gauss points in the square, and of the points of degree 2 in the triangle
GAUSS = np.array([[s, t] for s in (-1, 1) for t in (-1, 1)]) / np.sqrt(3)
SIXTHS = np.array([[1, 1], [4, 1], [1, 4]]) / 6


def cell_areas(position: Array, cells: Index) -> Array:
    """Return the areas of cells (n_cells,) [m²], of the triangle or between the diagonals."""
    a, b, c, d = position[cells].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2
