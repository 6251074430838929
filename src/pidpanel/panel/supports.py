"""Supports of the panel along edges and at points, as conditions at the vertices of a mesh.

Nothing here depends on the element: a support becomes directions at the vertices of the outline,
which the elements turn into constraints on their coordinates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from pidpanel.arrays import Array, Index
from pidpanel.geometry.plane_mesh import boundary_edges, edge_lengths
from pidpanel.geometry.polygon import Position, show, signed_area
from pidpanel.panel.mesh import PanelMesh

# Edges that turn by less are read as a smooth curve drawn by straight pieces.
SMOOTH_TURN = np.radians(30.0)


@dataclass(frozen=True)
class EdgeSupport:
    """Support between two points of a straight edge of the outline [m]."""

    start: Position
    end: Position
    kind: str  # "simply_supported", "simply_supported_soft", "clamped" or "free"
    stiffness: float = 0.0  # moment per length and angle of a spring along it [N]


@dataclass(frozen=True)
class PointSupport:
    """A hinge (w = 0) or a hold-down (w = 0 and no slope)."""

    position: Position  # (x, y) [m], a vertex of the mesh
    kind: str  # "hinge" or "hold_down"
    # Radius of a stiff foot [m]: within it the panel moves as a rigid body (in thin plates its rim
    # is slightly too stiff: 0.5 % in frequency for a foot of 0.1 m). 0 is a point support, at which
    # the deflection of a panel with core shear depends logarithmically on the mesh.
    radius: float = 0.0

    def vertex(self, mesh: PanelMesh, name: str) -> int:
        """Return the number of the vertex where the support is; the name is for messages."""
        distance = np.linalg.norm(mesh.vertices - np.array(self.position), axis=1)
        nearest = int(np.argmin(distance))
        if distance[nearest] > 1e-6 * np.ptp(mesh.vertices, axis=0).max():
            x, y = mesh.vertices[nearest]
            raise ValueError(
                f"{name} at {show(self.position)}: no vertex of the mesh is there, the nearest is"
                f" ({x:g}, {y:g}) m"
            )
        return nearest

    def foot_cells(self, mesh: PanelMesh, name: str) -> Index:
        """Return the cells whose centre lies within the foot."""
        centre = mesh.vertices[mesh.cells].mean(axis=1)
        cells = np.flatnonzero(np.linalg.norm(centre - self.position, axis=1) < self.radius)
        if not cells.size:
            raise ValueError(
                f"patch 'foot of {name}' of radius {self.radius:g} m about {show(self.position)}:"
                " no element has its centre in it; refine the mesh there"
            )
        return cells

    def foot_motion(self, rigid: Array) -> Array:
        """Return the rigid motions that a foot allows: rotation about its centre, or none."""
        if self.kind == "hold_down":
            return rigid[:, :0]
        return rigid[:, 1:] - rigid[:, :1] * np.array(self.position)


@dataclass(frozen=True)
class Supports:
    """All supports of a panel."""

    outline: str = "simply_supported"  # kind of the outer boundary, as of an `EdgeSupport`
    holes: str = "free"
    edges: Sequence[EdgeSupport] = ()  # straight parts of the boundary that differ; later ones win
    points: Mapping[str, PointSupport] = field(default_factory=dict)
    stiffness: float = 0.0  # of a spring along the outer boundary, as of an `EdgeSupport` [N]

    @property
    def has_springs(self) -> bool:
        """Whether an edge turns against a spring."""
        return any([self.stiffness, *(edge.stiffness for edge in self.edges)])


@dataclass(frozen=True)
class HeldVertex:
    """The supported edges that meet at a vertex of the boundary."""

    vertex: int
    # One or two supported edges: kind, unit tangent t, and the rate dt/ds at which it turns [1/m]
    # (zero but on a curve)
    edges: list[tuple[str, Array, Array]]


def boundary_loops(vertices: Array, cells: Index) -> list[Index]:
    """Return the closed chains of vertices round a set of cells, the first vertex not repeated.

    Counter-clockwise round the set, clockwise round a hole. Raises `ValueError` where the boundary
    touches itself at a vertex.
    """
    edges = boundary_edges(cells)
    following = dict(edges.tolist())
    if len(following) < len(edges):
        start, count = np.unique(edges[:, 0], return_counts=True)
        x, y = vertices[start[np.argmax(count)]]
        raise ValueError(f"the boundary touches itself at ({x:g}, {y:g}) m; it must not")
    loops = []
    while following:
        loop = [next(iter(following))]
        while (vertex := following.pop(loop[-1])) != loop[0]:
            loop.append(vertex)
        loops.append(np.array(loop))
    return loops


def held_vertices(mesh: PanelMesh, supports: Supports) -> tuple[list[HeldVertex], dict]:
    """Return the supported vertices of the boundary, and kind and unit tangent of supported edges.

    The edges are those of two vertices, the smaller first. Raises `ValueError` if no boundary of
    the mesh lies along an `EdgeSupport`.
    """
    vertices, edges = [], {}
    boundary = []
    for loop in boundary_loops(mesh.vertices, mesh.cells):
        kind = supports.outline if signed_area(mesh.vertices[loop]) > 0 else supports.holes
        boundary.append((loop, np.full(len(loop), kind, dtype=object)))
    for support in supports.edges:
        _mark(mesh, boundary, support, support.kind)
    for loop, kind_of in boundary:
        step = np.roll(mesh.vertices[loop], -1, axis=0) - mesh.vertices[loop]
        length = np.linalg.norm(step, axis=1)
        tangent = step / length[:, None]
        for k, vertex in enumerate(loop):
            # edge k leaves the vertex, edge k - 1 arrives
            if kind_of[k] != "free":
                edges[tuple(sorted((vertex, loop[(k + 1) % len(loop)])))] = kind_of[k], tangent[k]
            cosine = float(tangent[k] @ tangent[k - 1])
            if kind_of[k] == kind_of[k - 1] and cosine > np.cos(SMOOTH_TURN):
                mean = tangent[k] + tangent[k - 1]
                turn = (tangent[k] - tangent[k - 1]) / (0.5 * (length[k] + length[k - 1]))
                vertex_edges = [(kind_of[k], mean / np.linalg.norm(mean), turn)]
            else:
                vertex_edges = [(kind_of[j], tangent[j], np.zeros(2)) for j in (k - 1, k)]
            vertex_edges = [edge for edge in vertex_edges if edge[0] != "free"]
            if vertex_edges:
                vertices.append(HeldVertex(int(vertex), vertex_edges))
    return vertices, edges


def edge_springs(mesh: PanelMesh, supports: Supports) -> dict[tuple[int, int], float]:
    """Return the stiffness [N] of edges with a spring, by their vertices, the smaller first."""
    boundary = []
    for loop in boundary_loops(mesh.vertices, mesh.cells) if supports.has_springs else ():
        stiffness = supports.stiffness if signed_area(mesh.vertices[loop]) > 0 else 0.0
        boundary.append((loop, np.full(len(loop), stiffness, dtype=object)))
    for support in supports.edges if boundary else ():
        _mark(mesh, boundary, support, support.stiffness)
    return {
        (min(pair), max(pair)): float(value)
        for loop, values in boundary
        for *pair, value in zip(loop.tolist(), np.roll(loop, -1).tolist(), values, strict=True)
        if value
    }


def _mark(
    mesh: PanelMesh,
    boundary: list[tuple[Index, NDArray[np.object_]]],
    support: EdgeSupport,
    value: object,
) -> None:
    """Mark the edges of the boundary, loops and values, between the ends of a support."""
    start, end = np.array(support.start), np.array(support.end)
    length = float(np.linalg.norm(end - start))
    covered = 0.0
    slack = 1e-6 * float(np.ptp(mesh.vertices, axis=0).max())
    if length > slack:
        direction = (end - start) / length
        for loop, kind in boundary:
            offset = mesh.vertices[loop] - start
            s = offset @ direction
            aside = offset @ np.array([-direction[1], direction[0]])
            is_near = (np.abs(aside) < slack) & (s > -slack) & (s < length + slack)
            is_covered = is_near & np.roll(is_near, -1)
            kind[is_covered] = value
            covered += float(np.abs(np.roll(s, -1) - s)[is_covered].sum())
    if abs(covered - length) > 2 * slack or length <= slack:
        raise ValueError(
            f"support from ({start[0]:g}, {start[1]:g}) to ({end[0]:g}, {end[1]:g}) m: edges of"
            f" the panel's boundary cover {covered:g} of its {length:g} m; both ends must lie on"
            " one straight edge, at vertices of the mesh"
        )


def vertex_spacing(mesh: PanelMesh) -> Array:
    """Return the mean length of the cell edges at each vertex [m]."""
    following = np.roll(mesh.cells, -1, axis=1)
    ends = np.concatenate([mesh.cells.ravel(), following.ravel()])
    lengths = np.concatenate([edge_lengths(mesh.vertices, mesh.cells).ravel()] * 2)
    return np.bincount(ends, lengths) / np.bincount(ends)


@dataclass(frozen=True)
class Block:
    """Coordinates of the elements that move together: they span `columns` only."""

    name: str
    dofs: Index  # (n,) numbers of the coordinates
    columns: Array  # (n, m) what they may do: any combination of these columns


def free_coordinates(n_dofs: int, blocks: Sequence[Block]) -> sp.csr_array:
    """Return the matrix (n_dofs, n) from the free coordinates to those of the elements.

    Raises
    ------
    ValueError
        If two supports hold the same coordinate.
    """
    dofs = np.concatenate([np.zeros(0, dtype=np.int64), *(block.dofs for block in blocks)])
    owner: dict[int, str] = {}
    for block in blocks:
        for dof in block.dofs.tolist():
            if dof in owner:
                raise ValueError(f"{block.name} and {owner[dof]} hold the same coordinate")
            owner[dof] = block.name
    untouched = np.setdiff1d(np.arange(n_dofs), dofs)
    identity = sp.csr_array(sp.eye_array(n_dofs, format="csr")[:, untouched])
    if not blocks:
        return identity
    local = sp.block_diag([sp.coo_array(block.columns) for block in blocks])
    columns = sp.csr_array((local.data, (dofs[local.row], local.col)), (n_dofs, local.shape[1]))
    return sp.csr_array(sp.hstack([identity, columns]))


def null_space(rows: Array) -> Array:
    """Return the orthonormal null space (n_columns, n_free) of a few rows of order one.

    Two edges of the outline are one straight line if their directions differ by less
    than 1e-6: beyond what a mesh file rounds, below any corner meant.
    """
    _, values, right = np.linalg.svd(rows)
    rank = int(np.sum(values > 1e-6))
    return right[rank:].T
