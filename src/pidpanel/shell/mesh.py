"""Curved triangles in space: their nodes, normals and neighbours.

scikit-fem sorts the vertices of its elements, which turns the normals of some. Cells here keep an
orientation of their own: by their neighbours, and as a whole by an outward direction.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.spatial import cKDTree
from skfem import Dofs, Element, MeshTri
from skfem.element import ElementH1
from skfem.refdom import RefTri

from pidpanel.arrays import Array, Index
from pidpanel.geometry.orientation import oriented
from pidpanel.shell.selections import Place, Selection


def _element(order: int) -> type[Element]:
    """Return Lagrange's triangle of an order, for numbers and places of its nodes."""
    step, corners = np.arange(1, order) / order, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    sides = [np.outer(1 - step, corners[a]) + np.outer(step, corners[b]) for a, b in SIDES]
    inner = [(x, y) for x in step for y in step if x + y < 1 - 1 / order / 2]
    numbers = {"nodal_dofs": 1, "facet_dofs": order - 1, "interior_dofs": len(inner)}
    places = np.concatenate([corners, *sides, np.reshape(inner, (-1, 2))])
    return type(f"P{order}", (ElementH1,), {**numbers, "refdom": RefTri, "doflocs": places})


SIDES = (0, 1), (1, 2), (0, 2)  # of skfem
LAGRANGE = {order: _element(order) for order in range(1, 7)}
# Distance over the extent within which a position is on the surface, in the direction of its normal
# and, by rounding, at its edges.
NEAR, ROUNDING = 0.02, 1e-6
ROUGH = 0.05  # see `ShellMesh.selected_edges`
UPWARD = (0.0, 0.0, 1.0)


@lru_cache
def reference_nodes(order: int) -> Array:
    """Return the nodes (k, 2) of Lagrange's triangle of an order, corners first."""
    return np.asarray(LAGRANGE[order].doflocs, dtype=float)


def lagrange(order: int, place: Array) -> tuple[Array, Array, Array]:
    """Return values (n, k), derivatives (n, k, 2), second (n, k, 2, 2) of Lagrange's polynomials.

    Parameters
    ----------
    place
        (n, 2) coordinates in the reference triangle.
    """
    powers = np.array([(i, j) for i in range(order + 1) for j in range(order + 1 - i)])

    def monomials(x: Array, d: tuple[int, int]) -> Array:
        value = np.ones((len(x), len(powers)))
        for axis in (0, 1):
            power = powers[:, axis]
            for step in range(d[axis]):
                value = value * (power - step)
            value = value * x[:, axis, None] ** np.maximum(power - d[axis], 0)
        return value

    inverse = np.linalg.inv(monomials(reference_nodes(order), (0, 0)))
    value, u, v, uu, uv, vv = (
        monomials(np.asarray(place, dtype=float), d) @ inverse
        for d in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    )
    second = np.stack([np.stack([uu, uv], -1), np.stack([uv, vv], -1)], -1)
    return value, np.stack([u, v], -1), second


@dataclass(frozen=True)
class ShellMesh:
    """A mesh of curved triangles with named patches, parts and points."""

    vertices: Array  # (n_vertices, 3) corners of the cells [m]
    cells: Index  # (n_cells, 3) corners, counter-clockwise about the normal
    # (n_cells, k, 3) Lagrange nodes of each cell [m], its corners in ascending order of number
    geometry: Array
    patch_cells: dict[str, Index] = field(default_factory=dict)  # cell numbers of each patch
    part_cells: dict[str, Index] = field(default_factory=dict)  # cell numbers of each part
    points: dict[str, Place] = field(default_factory=dict)  # response points [m]

    @classmethod
    def from_triangles(
        cls,
        vertices: Array,
        cells: Index,
        surface: Callable[[Array], Array] = np.asarray,
        order: int = 4,
        outward: Place = UPWARD,
    ) -> "ShellMesh":
        """Return straight triangles mapped to a surface.

        Parameters
        ----------
        vertices, cells
            (n, 2) or (n, 3) and (m, 3).
        surface
            Function from positions (..., 2) or (..., 3) to those on the surface (..., 3) [m].
        """
        cells = np.asarray(cells)
        corners = np.asarray(vertices, dtype=float)[np.sort(cells, axis=1)]
        share, _, _ = lagrange(1, reference_nodes(order))
        geometry = surface(np.einsum("kj,cjx->ckx", share, corners))
        position = surface(np.asarray(vertices, float))
        cells = oriented(position, cells, outward, or_along_axis=True)
        return cls(position, cells, geometry)

    @classmethod
    def from_nodes(
        cls, position: Array, elements: Index, reference: Array, outward: Place = UPWARD
    ) -> "ShellMesh":
        """Return the triangles of a file or of gmsh.

        Parameters
        ----------
        position, elements
            Nodes (n, 3) [m] and their numbers in each triangle (m, k), corners first.
        reference
            (k, 2) places of these nodes in the reference triangle.
        """
        used, cells = np.unique(elements[:, :3], return_inverse=True)
        cells = cells.reshape(-1, 3)
        order = {3: 1, 6: 2, 10: 3, 15: 4}[elements.shape[1]]
        weights = np.column_stack([1 - reference.sum(axis=1), reference])
        target = np.column_stack([1 - reference_nodes(order).sum(axis=1), reference_nodes(order)])
        geometry = np.empty((*elements.shape, 3))
        corner = np.argsort(cells, axis=1)
        for turn in np.unique(corner, axis=0):
            place = np.empty_like(target)
            place[:, turn] = target
            node = np.abs(place[:, None] - weights).sum(axis=2).argmin(axis=1)
            same = (corner == turn).all(axis=1)
            geometry[same] = position[elements[same][:, node]]
        cells = oriented(position[used], cells, outward, or_along_axis=True)
        return cls(position[used], cells, geometry)

    @property
    def order(self) -> int:
        """Order of the polynomials of the surface."""
        return int(np.sqrt(2 * self.geometry.shape[1])) - 1

    @property
    def extent(self) -> float:
        """Largest dimension along an axis [m]."""
        return float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def topology(self) -> MeshTri:
        """The mesh of scikit-fem, for numbers of nodes alone: its positions have no meaning."""
        plane = np.ascontiguousarray(self.vertices[:, :2].T)
        return MeshTri(plane, np.ascontiguousarray(np.sort(self.cells, axis=1).T))

    @cached_property
    def side(self) -> Array:
        """(n_cells,) −1 where the sorted corners are clockwise."""
        a, b, c = self.cells.T
        return np.where((a < b) ^ (b < c) ^ (a < c), 1.0, -1.0)

    def nodes(self, order: int) -> tuple[Index, Array]:
        """Return node numbers (n_cells, k) of displacements of an order, and positions (n, 3)."""
        numbers = np.asarray(Dofs(self.topology, LAGRANGE[order]()).element_dofs, dtype=np.int64).T
        position = np.empty((numbers.max() + 1, 3))
        value, _, _ = lagrange(self.order, reference_nodes(order))
        position[numbers] = np.einsum("nk,ckx->cnx", value, self.geometry)
        return numbers, position

    def selected_edges(self, selection: Selection, order: int) -> Index:
        """Return the nodes (m, order + 1) of the edges within a selection, from end to end.

        Nodes between the ends may be off by `ROUGH` of the length, as on straight edges.
        """
        numbers, position = self.nodes(order)
        inner = 3 + np.arange(3 * (order - 1)).reshape(3, -1)
        chains = [[a, *nodes, b] for (a, b), nodes in zip(SIDES, inner, strict=True)]
        edges = np.unique(np.concatenate([numbers[:, chain] for chain in chains]), axis=0)
        place = position[edges]
        length = np.linalg.norm(place[:, -1] - place[:, 0], axis=1)
        ends = selection.contains(place[:, [0, -1]], ROUNDING * self.extent)
        near = [selection.contains(x, ROUGH * h).all() for x, h in zip(place, length, strict=True)]
        return edges[np.all(ends, axis=1) & np.array(near)]

    def selected_nodes(self, selection: Selection, order: int, name: str) -> Index:
        """Return the nodes within a selection; the name is for messages."""
        _, position = self.nodes(order)
        inside = np.flatnonzero(selection.contains(position, ROUNDING * self.extent))
        if not np.any(inside < len(self.vertices)):
            raise ValueError(f"{name} = {selection}: no corner of an element is in it")
        return np.union1d(inside, self.selected_edges(selection, order).ravel())

    def selected(self, selection: Selection, name: str) -> Index:
        """Return the cells whose centre is in a selection; the name is for messages."""
        value, _, _ = lagrange(self.order, np.full((1, 2), 1 / 3))
        centre = np.einsum("k,ckx->cx", value[0], self.geometry)
        cells = np.flatnonzero(selection.contains(centre))
        if not cells.size:
            raise ValueError(f"{name} = {selection}: no element has its centre in it")
        return cells

    def locate(self, positions: Array) -> tuple[Index, Array]:
        """Return the cells (n,) and places in the reference triangle (n, 2) nearest to positions.

        Raises `ValueError` for a position that is farther than `NEAR` of the extent.
        """
        owner = np.repeat(np.arange(len(self.cells)), self.geometry.shape[1])
        tree = cKDTree(self.geometry.reshape(-1, 3))
        cells, places = [], []
        for position in np.asarray(positions, dtype=float).reshape(-1, 3):
            _, near = tree.query(position, k=min(48, len(owner)))
            candidates = np.unique(owner[near])
            place = np.full((len(candidates), 2), 1 / 3)
            for _ in range(30):
                value, slope, _ = lagrange(self.order, place)
                gap = position - np.einsum("ck,ckx->cx", value, self.geometry[candidates])
                tangent = np.einsum("ckd,ckx->cxd", slope, self.geometry[candidates])
                move = np.einsum("cdx,cx->cd", np.linalg.pinv(tangent), gap)
                place = np.maximum(place + move, 0.0)
                place /= np.maximum(place.sum(axis=1, keepdims=True), 1.0)
            distance = np.linalg.norm(gap, axis=1)
            best = int(np.argmin(distance))
            if distance[best] > NEAR * self.extent:
                where = ", ".join(f"{value:g}" for value in position)
                raise ValueError(
                    f"({where}) m is {distance[best]:.2g} m off the surface; allowed are"
                    f" {NEAR * self.extent:.2g} m"
                )
            cells.append(candidates[best])
            places.append(place[best])
        return np.array(cells, dtype=np.int64), np.array(places).reshape(-1, 2)

    def with_names(
        self, patches: Mapping[str, Selection], points: Mapping[str, Place]
    ) -> "ShellMesh":
        """Return the mesh with patches and response points by name."""
        cells = {name: self.selected(where, f"patch {name!r}") for name, where in patches.items()}
        return replace(self, patch_cells=cells, points=dict(points))
