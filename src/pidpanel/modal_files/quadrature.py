"""Quadrature of a surface of linear cells, with four points in each."""

from typing import NamedTuple

import numpy as np
import scipy.sparse

from pidpanel.arrays import Array, Index

# Gauss points (4, 2) of the square [-1, 1]², which integrate cubics exactly, and the corners
GAUSS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / np.sqrt(3)
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


class CellQuadrature(NamedTuple):
    """Points of a surface, four to a cell and in the order of the cells."""

    position: Array  # (n_points, 3) [m]
    normal: Array  # (n_points, 3) by the right-hand rule of the corners
    weight: Array  # (n_points,) [m²]
    cell: Index  # (n_points,)
    interpolation: scipy.sparse.csr_array  # (n_points, n_nodes)

    def values(self, nodal: Array) -> Array:
        """Return values at the points, (n_points, …), of values at the nodes (n_nodes, …)."""
        flat = self.interpolation @ nodal.reshape(len(nodal), -1)
        return flat.reshape(-1, *nodal.shape[1:])

    def normal_displacement(self, displacement: Array) -> Array:
        """Return normal displacements (n_points, n) of displacements (n_nodes, 3, n)."""
        return sum(
            (self.normal[:, k, None] * self.values(displacement[:, k]) for k in range(3)),
            start=np.zeros((len(self.weight), displacement.shape[2])),
        )

    def overlap(self, normal_displacement: Array, cells: Index) -> Array:
        """Return ∫ w_i w_j dA (n, n) [m²] over the cells of a patch."""
        rows = np.isin(self.cell, cells)
        w = normal_displacement[rows]
        return w.T @ (self.weight[rows, None] * w)


def surface_quadrature(position: Array, cells: Index) -> CellQuadrature:
    """Return the quadrature of bilinear cells; of triangles it is exact for cubics.

    Parameters
    ----------
    position
        Nodes (n_nodes, 3) [m].
    cells
        Corners (n_cells, 4) in order; triangles repeat the third.
    """
    # N_k = (1 + s s_k)(1 + t t_k)/4 and its derivatives, (points, corners)
    s, t = (1 + GAUSS[:, None, k] * CORNERS[None, :, k] for k in (0, 1))
    shape, by_s, by_t = s * t / 4, CORNERS[:, 0] * t / 4, CORNERS[:, 1] * s / 4
    x = position[cells]
    points, along, across = ((part @ x).reshape(-1, 3) for part in (shape, by_s, by_t))
    area = np.cross(along, across)
    weight = np.linalg.norm(area, axis=1)
    count = len(weight)
    rows = np.repeat(np.arange(count), 4)
    columns = np.repeat(cells, 4, axis=0).ravel()
    values = np.tile(shape.ravel(), len(cells))
    interpolation = scipy.sparse.csr_array((values, (rows, columns)), (count, len(position)))
    cell = np.repeat(np.arange(len(cells)), 4)
    return CellQuadrature(points, area / weight[:, None], weight, cell, interpolation)
