"""Meshes from other programs: read from a file, checked, turned into triangles.

What would silently falsify the modes is refused in one line: positions that are not finite or
off the plane, nodes that no element uses, two nodes at one place (a crack), elements without
area or inverted, several pieces.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from pidpanel.arrays import Array, Index
from pidpanel.columns import ColumnsError
from pidpanel.geometry.plane_mesh import cell_areas, edge_lengths
from pidpanel.geometry.polygon import Position, Shape, show, signed_area
from pidpanel.panel.mesh import PanelMesh, check_patch_areas
from pidpanel.text_files import LARGEST, TextFileError, read_bytes

# Patches of a foreign mesh are whole elements: their area may differ from the patch's by this.
PATCH_AREA_TOLERANCE = 0.02
# Share of the extent: nodes closer than this are one, a node further than this is off the plane.
CLOSE = 1e-7


class MeshFileError(ColumnsError):
    """A mesh file with mistakes, a line each: file, line or element, what is wrong."""


def read_mesh_file(path: Path) -> bytes:
    """Read a file; refuse one with more bytes than a mesh needs, before it is read."""
    try:
        return read_bytes(path, LARGEST)
    except TextFileError as error:
        raise ValueError(f"{path}: {error.message}") from None


@dataclass(frozen=True)
class FlatMesh:
    """A checked plane mesh with the numbers of its file."""

    path: Path
    node: Index  # (n_nodes,) numbers of the nodes in the file
    position: Array  # (n_nodes, 2) [m]
    # (n_triangles, 3) counter-clockwise, by the order of the nodes; quadrilaterals are cut along
    # their shorter diagonal
    triangles: Index
    groups: NDArray[np.str_]  # (n_triangles,) group of the element each triangle comes from

    @classmethod
    def from_elements(
        cls,
        path: Path,
        node: Sequence[int],
        position: Array,
        element: Sequence[int],
        corners: Sequence[Sequence[int]],
        group: NDArray[np.str_],
    ) -> "FlatMesh":
        """Check a mesh and cut it into triangles."""
        numbers = np.asarray(node, dtype=np.int64)
        for noun, tags in (("node", numbers), ("element", np.asarray(element))):
            values, count = np.unique(tags, return_counts=True)
            if count.max(initial=0) > 1:
                raise ValueError(f"{path}: {noun} {values[np.argmax(count)]} appears twice")
        if not np.all(np.isfinite(position)):
            bad = numbers[~np.isfinite(position).all(axis=1)][0]
            raise ValueError(f"{path}: node {bad}: its position is not a number")
        if not len(numbers):
            raise ValueError(f"{path}: no nodes; a mesh needs them")
        extent = float(np.ptp(position, axis=0).max(initial=0.0))
        off_plane = np.abs(position[:, 2] - position[0, 2])
        if off_plane.max() > CLOSE * extent:
            raise ValueError(
                f"{path}: node {numbers[np.argmax(off_plane)]}: z = "
                f"{position[np.argmax(off_plane), 2]:g}, others have {position[0, 2]:g}; the panel"
                " must be plane, in x and y"
            )
        index = {int(number): k for k, number in enumerate(numbers)}
        triangles, origin = [], []
        for k, nodes in enumerate(corners):
            for number in nodes:
                if number not in index:
                    raise ValueError(f"{path}: element {element[k]}: node {number} is missing")
            places = [index[number] for number in nodes]
            triangles += _cut(path, element[k], places, position[places, :2])
            origin += [k] * (len(nodes) - 2)
        cells = np.array(triangles)
        _check_orientation(path, np.asarray(element)[origin], position[:, :2], cells)
        unused = np.setdiff1d(np.arange(len(numbers)), cells)
        if unused.size:
            raise ValueError(f"{path}: node {numbers[unused[0]]} belongs to no element")
        cells = np.where(signed_area(position[cells[0], :2]) > 0, cells, cells[:, ::-1])
        _check_apart(path, numbers, position[:, :2], CLOSE * extent)
        _check_one_piece(path, np.asarray(element)[origin], cells)
        return cls(path, numbers, position[:, :2], cells, group[origin].astype(str))

    def refined(self) -> "FlatMesh":
        """Return the mesh with each triangle divided in four; new nodes have further numbers."""
        a, b, c = self.triangles.T
        sides = np.stack([[b, c], [c, a], [a, b]]).transpose(2, 0, 1)  # opposite to a, b, c
        edges, middle = np.unique(np.sort(sides.reshape(-1, 2)), axis=0, return_inverse=True)
        to_a, to_b, to_c = len(self.node) + middle.reshape(-1, 3).T
        parts = [[a, to_c, to_b], [to_c, b, to_a], [to_b, to_a, c], [to_a, to_b, to_c]]
        return replace(
            self,
            node=np.append(self.node, self.node.max() + 1 + np.arange(len(edges))),
            position=np.append(self.position, self.position[edges].mean(axis=1), axis=0),
            triangles=np.array(parts).transpose(2, 0, 1).reshape(-1, 3),
            groups=np.repeat(self.groups, 4),
        )

    def at_node(self, number: int) -> Position:
        """Return the position of a node [m]."""
        rows = np.flatnonzero(self.node == number)
        if not rows.size:
            raise ValueError(
                f"{self.path}: no node {number}; it has {len(self.node)} nodes from"
                f" {self.node.min()} to {self.node.max()}"
            )
        x, y = self.position[rows[0]]
        return float(x), float(y)

    def panel_mesh(
        self, patches: Mapping[str, Shape | str], points: Mapping[str, Position]
    ) -> PanelMesh:
        """Return the mesh with its patches and points, which are positions of nodes [m].

        A shape has the triangles whose centre lies in it; text names a group of the file. Raises
        `ValueError` if a group is missing, elements do not follow a shape, or a point is at no
        node.
        """
        centre = self.position[self.triangles].mean(axis=1)
        extent = float(np.ptp(self.position, axis=0).max())
        patch_cells = {}
        for name, patch in patches.items():
            if isinstance(patch, str):
                members = self.groups == patch
                if not members.any():
                    groups = ", ".join(sorted(set(self.groups)))
                    raise ValueError(
                        f"patch {name!r}: {self.path} has no group {patch}; it has {groups}"
                    )
            else:
                members = shapely.contains_xy(shapely.Polygon(patch.corners), centre)
            patch_cells[name] = np.flatnonzero(members)
        point_vertices = {}
        for name, point in points.items():
            distance = np.linalg.norm(self.position - point, axis=1)
            nearest = int(np.argmin(distance))
            if distance[nearest] > 1e-6 * extent:
                raise ValueError(
                    f"point {name!r} = {show(point)}: no node is there; the nearest is"
                    f" {self.node[nearest]} at {show(self.position[nearest])}"
                )
            point_vertices[name] = nearest
        mesh = PanelMesh(self.position, self.triangles, "triangles", patch_cells, point_vertices)
        shapes = {name: patch for name, patch in patches.items() if not isinstance(patch, str)}
        check_patch_areas(mesh, shapes, PATCH_AREA_TOLERANCE)
        return mesh


def _cut(path: Path, element: int, places: list[int], corners: Array) -> list[list[int]]:
    """Return the triangles of an element; a quadrilateral is cut along its shorter diagonal."""
    if len(set(places)) < len(places):
        raise ValueError(f"{path}: element {element}: a node appears twice in it")
    if len(places) == 3:
        return [places]
    a, b, c, d = places
    turns = [signed_area(np.roll(corners, -k, axis=0)[:3]) for k in range(4)]
    if min(turns) <= 0 <= max(turns):
        raise ValueError(
            f"{path}: element {element}: its corners do not form a convex quadrilateral"
        )
    if np.linalg.norm(corners[0] - corners[2]) <= np.linalg.norm(corners[1] - corners[3]):
        return [[a, b, c], [a, c, d]]
    return [[a, b, d], [b, c, d]]


def _check_orientation(path: Path, element: Index, vertices: Array, triangles: Index) -> None:
    """Refuse triangles without area, and those that go round the other way than most."""
    area = cell_areas(vertices, triangles)
    longest = edge_lengths(vertices, triangles).max(axis=1)
    flat = np.abs(area) < 1e-6 * longest**2
    if flat.any():
        raise ValueError(f"{path}: element {element[flat][0]} is degenerate: it has no area")
    turned = np.sign(area) != np.sign(np.median(np.sign(area)) or area[0])
    if turned.any():
        raise ValueError(
            f"{path}: element {element[turned][0]} is inverted: its nodes run in the opposite "
            "direction to most others"
        )


def _check_one_piece(path: Path, element: Index, triangles: Index) -> None:
    """Refuse a mesh whose elements are not all joined by edges."""
    edges = np.sort(np.concatenate([np.roll(triangles, -k, axis=1)[:, :2] for k in range(3)]))
    _, edge = np.unique(edges, axis=0, return_inverse=True)
    owner = np.tile(np.arange(len(triangles)), 3)
    owned = sp.csr_array((np.ones(len(owner)), (owner, edge.ravel())))
    count, piece = connected_components(owned @ owned.T, directed=False)
    if count > 1:
        separate = element[np.argmax(piece != piece[0])]
        raise ValueError(
            f"{path}: the mesh has {count} pieces: no edges join element {separate} to element"
            f" {element[0]}; a panel is one piece"
        )


def _check_apart(path: Path, node: Index, position: Array, close: float) -> None:
    """Refuse two nodes at one place."""
    # Two nodes in one square are close. With one node in each, close pairs are few.
    squares = np.floor(position / (0.7 * close))
    _, first = np.unique(squares, axis=0, return_index=True)
    again = np.setdiff1d(np.arange(len(position)), first)
    if again.size:
        pairs = np.flatnonzero((squares == squares[again[0]]).all(axis=1))[None, :2]
    else:
        from scipy.spatial import cKDTree  # slow to import, for files alone

        pairs = cKDTree(position).query_pairs(close, output_type="ndarray")
    if len(pairs):
        first, second = node[pairs[0]]
        raise ValueError(
            f"{path}: nodes {min(first, second)} and {max(first, second)} are at one place"
            f" {show(position[pairs[0, 0]])}: the panel is cracked there; merge them"
        )
