"""Quadrature of a surface, with four points in each of its cells."""

from typing import NamedTuple

import numpy as np
import scipy.sparse

from pidpanel.arrays import Array, Index

# Gauss points (4, 2) of the square [-1, 1]², which integrate cubics exactly, and the corners
GAUSS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / np.sqrt(3)
CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
# Nodes of triangles and quadrilaterals of second order, and exponents of their polynomials
NODES = {
    6: np.array([[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]),
    8: np.concatenate([CORNERS, [[0, -1], [1, 0], [0, 1], [-1, 0]]]),
}
POWERS = np.array([[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [2, 1], [1, 2]])


class CellQuadrature(NamedTuple):
    """Points of a surface, four to a cell and in the order of the cells."""

    position: Array  # (n_points, 3) [m]
    normal: Array  # (n_points, 3) by the right-hand rule of the corners
    weight: Array  # (n_points,) [m²]
    cell: Index  # (n_points,)
    interpolation: scipy.sparse.csr_array  # (n_points, n_nodes)

    def values(self, nodal: Array) -> Array:
        """Return values at the points, (n_points, …), of values at the nodes (n_nodes, …)."""
        flat = self.interpolation @ nodal.reshape(len(nodal), np.prod(nodal.shape[1:], dtype=int))
        return flat.reshape(len(self.weight), *nodal.shape[1:])

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


def surface_quadrature(
    position: Array, cells: Index, parents: Index | None = None
) -> CellQuadrature:
    """Return the quadrature of bilinear cells; of triangles it is exact for cubics.

    Parts of elements of second order have the place and the motion of these.

    Parameters
    ----------
    position
        Nodes (n_nodes, 3) [m].
    cells
        Corners (n_cells, 4) in order; triangles repeat the third.
    parents
        Nodes (n_cells, 8) of the elements of second order whose parts they are; −1 where there
        are fewer.
    """
    points, area, columns, values = _points(position, cells, parents, GAUSS)
    area = area.reshape(-1, 3)
    weight = np.linalg.norm(area, axis=1)
    rows = np.repeat(np.arange(len(weight)), 8)
    used = values.ravel() != 0
    entries = values.ravel()[used], (rows[used], columns.ravel()[used])
    interpolation = scipy.sparse.csr_array(entries, (len(weight), len(position)))
    cell = np.repeat(np.arange(len(cells)), 4)
    normal = area / weight[:, None]
    return CellQuadrature(points.reshape(-1, 3), normal, weight, cell, interpolation)


def node_normals(position: Array, cells: Index, parents: Index | None = None) -> Array:
    """Return unit normals (n_nodes, 3), the mean over the cells at a node by area.

    Parameters are those of `surface_quadrature`; nodes without cells have 0.
    """
    # just inside the corners, where a triangle that repeats one has a normal too
    _, area, *_ = _points(position, cells, parents, 0.999 * CORNERS)
    total, size = np.zeros_like(position), np.linalg.norm(area, axis=2, keepdims=True)
    np.add.at(total, cells, area / size * size.mean(axis=1, keepdims=True))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.divide(total, length, out=np.zeros_like(total), where=length > 0)


def _points(
    position: Array, cells: Index, parents: Index | None, places: Array
) -> tuple[Array, Array, Index, Array]:
    """Return points and area vectors (n_cells, 4, 3) at places (4, 2) of the square of a cell.

    Then nodes and values of the interpolation (n_cells, 4, 8).
    """
    # N_k = (1 + s s_k)(1 + t t_k)/4 and its derivatives, (points, corners)
    s, t = (1 + places[:, None, k] * CORNERS[None, :, k] for k in (0, 1))
    shape, by_s, by_t = s * t / 4, CORNERS[:, 0] * t / 4, CORNERS[:, 1] * s / 4
    x = position[cells]
    points, along, across = (part @ x for part in (shape, by_s, by_t))
    columns = np.full((len(cells), 4, 8), -1)
    columns[:, :, :4] = cells[:, None]
    values = np.zeros(columns.shape)
    values[:, :, :4] = shape
    count = np.zeros(len(cells)) if parents is None else (parents >= 0).sum(axis=1)
    for nodes, local in NODES.items():
        curved = np.flatnonzero(count == nodes)
        if parents is None or not curved.size:
            continue
        parent = parents[curved, :nodes]
        corner = local[(cells[curved][:, :, None] == parent[:, None]).argmax(axis=2)]
        value, slopes = _second_order(nodes, shape @ corner)
        columns[curved, :, :nodes] = parent[:, None]
        values[curved, :, :nodes] = value
        points[curved] = value @ position[parent]
        along[curved], across[curved] = (
            np.einsum("cqd,dcqk,cki->cqi", step @ corner, slopes, position[parent])
            for step in (by_s, by_t)
        )
    return points, np.cross(along, across), columns, values


def _second_order(nodes: int, place: Array) -> tuple[Array, Array]:
    """Return shapes (…, nodes) at places (…, 2) and their slopes (2, …, nodes)."""
    powers = POWERS[:nodes]
    inverse = np.linalg.inv(np.prod(NODES[nodes][:, None] ** powers, axis=2))
    slopes = []
    for axis in (0, 1):
        lower = np.maximum(powers - np.eye(2, dtype=int)[axis], 0)
        slopes.append(powers[:, axis] * np.prod(place[..., None, :] ** lower, axis=-1) @ inverse)
    return np.prod(place[..., None, :] ** powers, axis=-1) @ inverse, np.stack(slopes)
