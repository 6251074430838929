"""Jumps of the pressure over a thin surface of any form: hats on triangles.

With the potential of a double layer in space the operator A of `free_edges` is

    A_ij = ∬ G [curl ψ_i · curl ψ_j − k² n·n′ ψ_i ψ_j] dA dA′,    G = exp(ikR)/(4πR),

curl ψ = n × ∇ψ (Nédélec 1982). A hat is linear on each triangle and zero on free rims, where the
pressure falls as √distance: hats answer as those of a surface without rims that ends `RIM_SHIFT`
rows of triangles further in. The rim of the mesh lies as much further out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.coarsening import remeshed, rims
from pidpanel.geometry.plane_mesh import edge_lengths
from pidpanel.geometry.surface_waves import SurfaceQuadrature
from pidpanel.sound.wavenumber_table import (
    FieldError,
    WavenumberTable,
    chebyshev_nodes,
    node_count,
)

# Share of the last row of triangles by which a strip of many equal hats is too narrow at each edge:
# ∫μ is πa² of its half width a.
RIM_SHIFT = 0.115

# Distance of two triangles, in the sum of their mean edges, up to which 1/R is a closed form.
NEAR = 1.0

# Edges of triangles in the shortest wave, area of a vertex over the square of an edge, number
# of vertices without those that rims add.
EDGES, HEXAGON, LEAST_VERTICES, MOST_VERTICES = 6.5, 0.866, 350, 600

FIT = 0.7, 1.15  # mean edge of a mesh that stays, over the one that is needed

PAIRS_AT_ONCE = 2**18  # pairs of points that are summed together

CANDIDATES = 12  # triangles round a point among which the nearest one is searched

# Barycentric coordinates of three points of equal weight in a triangle: exact for squares.
POINTS = np.full((3, 3), 1 / 6) + np.eye(3) / 2


@dataclass(frozen=True)
class SurfaceJumps:
    """Hats on the vertices of a mesh that lie on no free rim."""

    vertices: Array  # (nv, 3) [m], those of rims moved out
    triangles: Index  # (nt, 3) in one sense
    inner: Index  # (n,) vertices that have a hat
    wavenumber: float = np.inf  # κ [rad/m] of the waves that the hats resolve

    @classmethod
    def of_surface(
        cls, vertices: Array, triangles: Index, wavenumber: float, share: float = 1.0
    ) -> SurfaceJumps:
        """Return hats that resolve waves to κ [rad/m] on a mesh of triangles in one sense.

        Or to a lower one, if that took more than `MOST_VERTICES`. A mesh with edges of about the
        size that is needed stays, so that symmetries of it do; another one is made on it.

        Parameters
        ----------
        share
            Of vertices that are used; less than 1 to see the error of a mesh.

        Raises
        ------
        FieldError
            If the surface closes: the air inside has a stiffness and resonances without damping,
            which no table over k holds. A single k is right (`of_mesh`).
        """
        if not len(rims(triangles, len(vertices))[0]):
            raise FieldError(
                "free edges of a surface that closes: the air inside resonates; allowed is a "
                "surface with an edge, others have independent faces"
            )
        area = np.linalg.norm(_normals(vertices[triangles]), axis=1).sum() / 2
        longest, shortest = (
            np.sqrt(area / count / HEXAGON) for count in (LEAST_VERTICES, MOST_VERTICES)
        )
        wavenumber = min(wavenumber, 2 * np.pi / EDGES / shortest)
        edge = min(2 * np.pi / wavenumber / EDGES, longest) / np.sqrt(share)
        lengths = edge_lengths(vertices, triangles)
        if not (FIT[0] * edge < lengths.mean() < FIT[1] * edge and lengths.max() < 2 * edge):
            vertices, triangles = remeshed(vertices, triangles, edge)
        return replace(cls.of_mesh(vertices, triangles), wavenumber=wavenumber)

    @classmethod
    def of_mesh(cls, vertices: Array, triangles: Index) -> SurfaceJumps:
        """Return the hats of a mesh (nv, 3) [m] of triangles (nt, 3) in one sense."""
        rim, owner = rims(triangles, len(vertices))
        corners = vertices[triangles[owner]]
        normal = _normals(corners)
        side = vertices[rim[:, 1]] - vertices[rim[:, 0]]
        outward = np.cross(side, normal)
        outward /= np.linalg.norm(outward, axis=1, keepdims=True)
        width = np.linalg.norm(normal, axis=1) / np.linalg.norm(side, axis=1)
        total = np.zeros((len(vertices), 5))
        for end in rim.T:
            np.add.at(total, end, np.column_stack([outward, width, np.ones(len(rim))]))
        ends = np.unique(rim)
        outward, width, count = total[ends, :3], total[ends, 3:4], total[ends, 4:]
        square = np.maximum(np.sum(outward**2, axis=1, keepdims=True), count / 2)
        moved = vertices.copy()
        moved[ends] += RIM_SHIFT * width * outward / square  # both edges by their mean
        return cls(moved, triangles, np.setdiff1d(triangles, rim))

    @cached_property
    def corners(self) -> Array:
        """(nt, 3, 3) corners of the triangles [m]."""
        return self.vertices[self.triangles]

    @cached_property
    def normal(self) -> Array:
        """(nt, 3) normals of the length of twice the area [m²]."""
        return _normals(self.corners)

    @cached_property
    def edges(self) -> tuple[Index, Index]:
        """(ne, 2) ends of the edges, and their numbers (nt, 3) from each corner on."""
        sides = np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2)
        ends, number = np.unique(np.sort(sides, axis=2).reshape(-1, 2), axis=0, return_inverse=True)
        return ends, number.reshape(-1, 3)

    @cached_property
    def points(self) -> Array:
        """(ne, 3) middles of edges [m], whose rule is exact for squares."""
        return self.vertices[self.edges[0]].mean(axis=1)

    @cached_property
    def directed_weight(self) -> Array:
        """(ne, 3) weights of the middles times the normals [m²]."""
        total = np.zeros_like(self.points)
        np.add.at(total, self.edges[1], self.normal[:, None] / 6)
        return total

    @cached_property
    def at_points(self) -> Any:
        """(ne, n) hats at the middles of edges, sparse."""
        return self.hats(self.edges[0], np.full(self.edges[0].shape, 0.5))

    @property
    def diameter(self) -> float:
        """L [m]."""
        box = self.vertices.min(axis=0) + self.vertices.max(axis=0)
        return float(2 * np.max(np.linalg.norm(self.vertices - box / 2, axis=1)))

    def hats(self, vertices: Index, values: Array) -> Any:
        """Return sums of hats (k, n), sparse, of vertices (k, m) by their values (k, m)."""
        rows = np.repeat(np.arange(len(values)), values.shape[1])
        shape = (len(values), len(self.vertices))
        return sparse.csr_array((values.ravel(), (rows, vertices.ravel())), shape)[:, self.inner]

    def operator(self, wavenumber_max: float) -> WavenumberTable:
        """Tabulate A (n, n) [m] for 0 ≤ k ≤ k_max [rad/m]."""
        from scipy.spatial.distance import cdist

        nodes = chebyshev_nodes(wavenumber_max, node_count(wavenumber_max, self.diameter))
        count, n = len(self.points), len(self.inner)
        # twice the area times the curl of a hat is the side opposite to its vertex
        opposite = np.roll(self.corners, 1, axis=1) - np.roll(self.corners, -1, axis=1)
        curls = [self.hats(self.triangles, opposite[..., axis] / 2) for axis in range(3)]
        edge_curls = [self._means() @ curl for curl in curls]
        nearby = self._near()
        near = sum(c.T @ nearby @ c for c in curls).toarray()
        directed = [self.hats(self.triangles, self.normal[:, [axis] * 3] / 6) for axis in range(3)]
        near_directed = sum(d.T @ nearby @ d for d in directed).toarray()
        even, odd = np.zeros((2, nodes.size, n, n))
        even += (near - nodes[:, None, None] ** 2 * near_directed) / 2
        step = max(1, PAIRS_AT_ONCE // count)
        for start in range(0, count, step):
            block, first = slice(start, min(start + step, count)), slice(start, None)
            distance = cdist(self.points[first], self.points[block])
            share = np.full(distance.shape, 1 / (4 * np.pi))
            share[: block.stop - start] /= 2  # the block itself is counted twice
            inverse = np.divide(share, distance, out=np.zeros_like(distance), where=distance > 0)
            facing = self.directed_weight[first] @ self.directed_weight[block].T
            same = np.where(distance > 0, 0.0, share)
            left = [m[first].T.tocsr() for m in (*edge_curls, self.at_points)]
            right = [m[block] for m in (*edge_curls, self.at_points)]
            for index, k in enumerate(nodes):
                for total, kernel in (
                    (even, np.cos(k * distance) * inverse),
                    (odd, np.sin(k * distance) * (inverse / k) + same),
                ):
                    kernels = [kernel] * 3 + [-(k**2) * kernel * facing]
                    for rows, inner, columns in zip(left, kernels, right, strict=True):
                        total[index] += (rows @ inner) @ columns
        even += even.swapaxes(1, 2).copy()
        odd += odd.swapaxes(1, 2).copy()
        return WavenumberTable(wavenumber_max, nodes, even, odd)

    def _means(self) -> Any:
        """Return the matrix (ne, nt), sparse, of means over triangles of values at the points."""
        _, number = self.edges
        columns = np.repeat(np.arange(len(number)), 3)
        shape = (len(self.points), len(number))
        return sparse.csr_array((np.full(number.size, 1 / 3), (number.ravel(), columns)), shape)

    def _near(self) -> Any:
        """Return the mean of 1/(4πR) over pairs of near triangles, less that of their points."""
        from scipy.spatial import KDTree

        middle, count = self.corners.mean(axis=1), len(self.triangles)
        edge = np.linalg.norm(self.corners - np.roll(self.corners, 1, axis=1), axis=2).mean(axis=1)
        tree = KDTree(middle)
        pairs = tree.sparse_distance_matrix(tree, 2 * NEAR * edge.max(), output_type="coo_matrix")
        close = pairs.data <= NEAR * (edge[pairs.row] + edge[pairs.col])
        first, second = pairs.row[close], pairs.col[close]
        mean = np.zeros(len(first))
        for inner in POINTS:
            mean += inverse_distance(inner @ self.corners[first], self.corners[second]) / 3
        mean /= np.linalg.norm(self.normal, axis=1)[second] / 2
        points = self.points[self.edges[1]]
        distance = np.linalg.norm(points[first][:, :, None] - points[second][:, None], axis=3)
        inverse = np.divide(1, distance, out=np.zeros_like(distance), where=distance > 0)
        mean = (mean - inverse.mean(axis=(1, 2))) / (4 * np.pi)
        matrix = sparse.csr_array((mean, (first, second)), (count, count))
        return (matrix + matrix.T).tocsr() / 2

    def couplings(self, surface: SurfaceQuadrature) -> list[Array]:
        """Return ∫ ψ φ dA (n, n_shapes) [m²]; points act on the triangle nearest to them."""
        triangle, barycentric = self._nearest(surface.position)
        sense = np.sign(np.sum(self.normal[triangle] * surface.normal, axis=1))
        load = (sense * surface.weight)[:, None] * surface.shape
        return [self.hats(self.triangles[triangle], barycentric).T @ load]

    def _nearest(self, position: Array) -> tuple[Index, Array]:
        """Return the triangles (k,) nearest to points (k, 3) [m], and coordinates (k, 3) there."""
        from scipy.spatial import KDTree

        count = min(CANDIDATES, len(self.triangles))
        _, tried = KDTree(self.corners.mean(axis=1)).query(position, np.arange(1, count + 1))
        corners = self.corners[tried]  # (k, count, 3, 3)
        normal = self.normal[tried]
        square = np.sum(normal**2, axis=-1)
        distance = position[:, None, None] - corners
        sides = np.roll(corners, -2, axis=2) - np.roll(corners, -1, axis=2)
        inside = np.cross(sides, np.roll(distance, -1, axis=2))  # opposite to each vertex
        barycentric = np.einsum("kcvd,kcd->kcv", inside, normal) / square[..., None]
        barycentric = np.maximum(barycentric, 0.0)
        barycentric /= barycentric.sum(axis=2, keepdims=True)
        foot = np.einsum("kcv,kcvd->kcd", barycentric, corners)
        best = np.argmin(np.sum((foot - position[:, None]) ** 2, axis=2), axis=1)
        line = np.arange(len(position))
        return tried[line, best], barycentric[line, best]

    def waves(self, wavevector: Array) -> list[Complexes]:
        """Return ∫ ψ (−i κ·n) exp(−iκ·x) dA (k, n) [m] of waves κ (k, 3) [rad/m]."""
        slope = -1j * wavevector @ self.directed_weight.T
        return [(slope * np.exp(-1j * wavevector @ self.points.T)) @ self.at_points]


def _normals(corners: Array) -> Array:
    """Return the normals (k, 3) of triangles (k, 3, 3), of the length of twice their area."""
    sides = corners[:, 1:] - corners[:, :1]
    normals: Array = np.cross(sides[:, 0], sides[:, 1])
    return normals


def inverse_distance(position: Array, corners: Array) -> Array:
    """Return ∫ 1/R dA (k,) [m] over triangles (k, 3, 3) [m] seen from points (k, 3) [m].

    Wilton et al., IEEE Trans. Antennas Propag. 32 (1984), Eq. 5.
    """
    following = np.roll(corners, -1, axis=1)
    along = following - corners
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    normal = np.cross(along[:, 0], along[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    to_start, to_end = corners - position[:, None], following - position[:, None]
    height = np.abs(np.sum(to_start[:, 0] * normal, axis=1))[:, None]
    start, end = np.sum(to_start * along, axis=2), np.sum(to_end * along, axis=2)
    offset = np.sum(to_start * np.cross(along, normal[:, None]), axis=2)
    near, far = np.linalg.norm(to_start, axis=2), np.linalg.norm(to_end, axis=2)
    square = offset**2 + height**2
    behind = end + start < 0  # of both forms of the logarithm that which does not cancel
    log = np.log(np.where(behind, near - start, far + end))
    log -= np.log(np.where(behind, far - end, near + start))
    turn = np.arctan2(offset * end, square + height * far)
    turn -= np.arctan2(offset * start, square + height * near)
    total: Array = np.sum(offset * log - height * turn, axis=1)
    return total
