"""Meshes from other programs: read from a file, checked, turned into triangles.

What would silently falsify the modes is refused in one line: positions that are not finite or
off the plane, elements without area, and what `connectivity` refuses. What is without effect is
omitted and counted: nodes that no element uses, elements that are upside down.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from pidpanel.arrays import Array, Index
from pidpanel.columns import ColumnsError
from pidpanel.geometry.plane_mesh import cell_areas, edge_lengths, plane_axes
from pidpanel.geometry.polygon import Position, Shape, show
from pidpanel.panel.connectivity import check_connectivity
from pidpanel.panel.mesh import PanelMesh, check_patch_areas
from pidpanel.text_files import LARGEST, TextFileError, read_bytes

# Patches of a foreign mesh are whole elements: their area may differ from the patch's by this.
PATCH_AREA_TOLERANCE = 0.02
# Share of the extent: a node further than this from the others is off the plane.
FLAT = 1e-4
CLOSE = 1e-3  # shortest over longest edge of a triangle up to which its nodes are reported
LARGEST_NUMBER = 2**63 - 1  # of a node or an element


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
    groups: dict[str, Index]  # triangles of each group; an element may be in several
    numbers: Mapping[str, str] = field(default_factory=dict)  # names of groups by their numbers
    remarks: tuple[str, ...] = ()  # what of the file is not used, read otherwise, or unusual
    # (3, 2) of x and y in the frame of the file, in columns
    axes: Array = field(default_factory=lambda: np.eye(3)[:, :2])

    @classmethod
    def from_elements(
        cls,
        path: Path,
        node: Sequence[int],
        position: Array,
        element: Sequence[int],
        corners: Sequence[Sequence[int]],
        groups: Mapping[str, Sequence[int]],
        remarks: Sequence[str] = (),
    ) -> "FlatMesh":
        """Check a mesh and cut it into triangles.

        Parameters
        ----------
        node, position
            Numbers (n,) and positions (n, 3) of the nodes [m]. x and y of the mesh are along the
            axes of its plane, from the foot of the origin on it; see `plane_axes`.
        element, corners
            Numbers of the elements, and the numbers of their nodes in order.
        groups
            Places of the elements of each group in `element`.
        remarks
            What of the file is not used.

        Raises
        ------
        ValueError
            In one line: node or element, what is wrong.
        """
        try:
            numbers, elements = _numbers("node", node), _numbers("element", element)
            if not np.all(np.isfinite(position)):
                bad = numbers[~np.isfinite(position).all(axis=1)][0]
                raise ValueError(f"node {bad}: its position is not a number")
            index = {number: k for k, number in enumerate(numbers.tolist())}
            for tag, nodes in zip(element, corners, strict=True):
                if missing := [number for number in nodes if number not in index]:
                    raise ValueError(f"element {tag}: node {missing[0]} is missing")
            used = np.unique([index[number] for nodes in corners for number in nodes])
            remarks = [*remarks, *_unused_nodes(np.delete(numbers, used))]
            numbers, position = numbers[used], position[used]
            rows = [[index[number] for number in (*nodes[:3], nodes[-1])] for nodes in corners]
            axes, level = _plane(numbers, position, np.searchsorted(used, rows))
            remarks += _plane_in_words(axes, level)
            position = position @ axes
            cells, origin = _cut(elements, corners, numbers, position)
            turned = _inverted(elements[origin], position, cells)
            if 0 < turned.sum() < len(cells):
                fewer = turned if 2 * turned.sum() <= len(cells) else ~turned
                count = len(np.unique(origin[fewer]))
                remarks.append(f"{counted(count, 'element')} upside down, which has no effect")
            cells = np.where(turned[:, None], cells[:, ::-1], cells)
            check_connectivity(numbers, elements[origin], position, cells)
            remarks += _short_edges(numbers, position, cells)
            members = {name: np.flatnonzero(np.isin(origin, rows)) for name, rows in groups.items()}
            checked = numbers, position, cells, members
            return cls(path, *checked, remarks=tuple(remarks), axes=axes)
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from None

    def refined(self, times: int = 1) -> "FlatMesh":
        """Return the mesh with each triangle divided in four; new nodes have further numbers."""
        if not times:
            return self
        a, b, c = self.triangles.T
        sides = np.stack([[b, c], [c, a], [a, b]]).transpose(2, 0, 1)  # opposite to a, b, c
        edges, middle = np.unique(np.sort(sides.reshape(-1, 2)), axis=0, return_inverse=True)
        to_a, to_b, to_c = len(self.node) + middle.reshape(-1, 3).T
        parts = [[a, to_c, to_b], [to_c, b, to_a], [to_b, to_a, c], [to_a, to_b, to_c]]
        fine = replace(
            self,
            node=np.append(self.node, self.node.max() + 1 + np.arange(len(edges))),
            position=np.append(self.position, self.position[edges].mean(axis=1), axis=0),
            triangles=np.array(parts).transpose(2, 0, 1).reshape(-1, 3),
            groups={
                name: (4 * cells[:, None] + np.arange(4)).ravel()
                for name, cells in self.groups.items()
            },
        )
        return fine.refined(times - 1)

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
        self,
        patches: Mapping[str, Shape | str],
        points: Mapping[str, Position],
        anchors: Mapping[str, Position] = {},
    ) -> PanelMesh:
        """Return the mesh with its patches and points; anchors are positions of nodes [m].

        A shape has the triangles whose centre lies in it; text names a group of the file. Raises
        `ValueError` if a group is missing, elements do not follow a shape, or an anchor is at no
        node.
        """
        centre = self.position[self.triangles].mean(axis=1)
        extent = float(np.ptp(self.position, axis=0).max())
        patch_cells = {}
        for name, patch in patches.items():
            if isinstance(patch, str):
                group = patch if patch in self.groups else self.numbers.get(patch, patch)
                if group not in self.groups:
                    groups = ", ".join(sorted(self.groups)) or "none"
                    raise ValueError(
                        f"patch {name!r}: {self.path} has no group {patch}; it has {groups}"
                    )
                patch_cells[name] = self.groups[group]
            else:
                inside = shapely.contains_xy(shapely.Polygon(patch.corners), centre)
                patch_cells[name] = np.flatnonzero(inside)
        for name, point in anchors.items():
            distance = np.linalg.norm(self.position - point, axis=1)
            nearest = int(np.argmin(distance))
            if distance[nearest] > 1e-6 * extent:
                raise ValueError(
                    f"point {name!r} = {show(point)}: no node is there; the nearest is"
                    f" {self.node[nearest]} at {show(self.position[nearest])}"
                )
        mesh = PanelMesh(self.position, self.triangles, "triangles", patch_cells, dict(points))
        shapes = {name: patch for name, patch in patches.items() if not isinstance(patch, str)}
        check_patch_areas(mesh, shapes, PATCH_AREA_TOLERANCE)
        return mesh


def _numbers(noun: str, tags: Sequence[int]) -> Index:
    """Return numbers as an array; refuse those that are too large or appear twice."""
    if max(tags, default=0) > LARGEST_NUMBER:
        raise ValueError(f"{noun} {max(tags)}: numbers up to {LARGEST_NUMBER} are allowed")
    values, count = np.unique(np.asarray(tags, dtype=np.int64), return_counts=True)
    if count.max(initial=0) > 1:
        raise ValueError(f"{noun} {values[np.argmax(count)]} appears twice")
    return np.asarray(tags, dtype=np.int64)


def _plane(node: Index, position: Array, corners: Index) -> tuple[Array, float]:
    """Return axes (3, 2) and level [m] of the plane of elements; refuse nodes that are off it."""
    extent = float(np.ptp(position, axis=0).max())
    a, b, c, d = position[corners].transpose(1, 0, 2)
    area = np.cross(c - a, np.where((d == c).all(axis=1)[:, None], a, d) - b)
    size = np.linalg.norm(area, axis=1)[:, None]
    if not size.any():
        return np.eye(3)[:, :2], 0.0  # refused as degenerate
    area *= np.where(area @ area[size.argmax()] < 0, -1, 1)[:, None]
    # the mean is exact, the median is that of most elements where some are off
    for normal in (
        area.sum(axis=0),
        np.median(area[size[:, 0] > 0] / size[size > 0, None], axis=0),
    ):
        normal = normal / np.linalg.norm(normal)
        if np.ptp(position[:, 2]) <= FLAT * extent:  # x and y are those of the file
            normal = np.array([0.0, 0.0, 1.0])
        normal *= np.sign(normal[np.abs(normal).argmax()])
        height = position @ normal
        level = float(np.sort(height)[len(height) // 2])
        off_plane = np.abs(height - level)
        if off_plane.max() <= FLAT * extent:
            return plane_axes(normal), level
    worst = np.argmax(off_plane)
    raise ValueError(
        f"node {node[worst]} is {off_plane[worst]:g} m off the plane of most others, with normal"
        f" {_direction(normal)}; the panel must be plane"
    )


def _plane_in_words(axes: Array, level: float) -> list[str]:
    """Return how a plane other than that of x and y lies."""
    if (axes == np.eye(3)[:, :2]).all():
        return []
    x, y, z = map(_direction, (*axes.T, np.cross(*axes.T)))
    return [f"a plane {level:.4g} m from the origin, with x along {x}, y along {y}, z along {z}"]


def _direction(vector: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(vector, 4) + 0.0) + ")"


def _cut(
    element: Index, corners: Sequence[Sequence[int]], node: Index, position: Array
) -> tuple[Index, Index]:
    """Return the triangles of all elements in order, and the place of the element of each.

    A quadrilateral is cut along its shorter diagonal.
    """
    order = np.argsort(node)
    parts, origins = [], []
    for count in (3, 4):
        rows = np.array([k for k, nodes in enumerate(corners) if len(nodes) == count], dtype=int)
        if not rows.size:
            continue
        cells = order[np.searchsorted(node, [corners[k] for k in rows.tolist()], sorter=order)]
        if (twice := (np.diff(np.sort(cells)) == 0).any(axis=1)).any():
            raise ValueError(f"element {element[rows[twice][0]]}: a node appears twice in it")
        if count == 4:
            turns = [cell_areas(position, np.roll(cells, -k, axis=1)[:, :3]) for k in range(4)]
            if (concave := (np.min(turns, axis=0) <= 0) & (np.max(turns, axis=0) >= 0)).any():
                raise ValueError(
                    f"element {element[rows[concave][0]]}: its corners do not form a convex"
                    " quadrilateral"
                )
            a, b, c, d = position[cells].transpose(1, 0, 2)
            by_first = np.linalg.norm(a - c, axis=1) <= np.linalg.norm(b - d, axis=1)
            halves = cells[:, [[0, 1, 2], [0, 2, 3]]], cells[:, [[0, 1, 3], [1, 2, 3]]]
            cells = np.where(by_first[:, None, None], *halves).reshape(-1, 3)
        parts.append(cells)
        origins.append(np.repeat(rows, count - 2))
    origin = np.concatenate(origins)
    by_element = np.argsort(origin, kind="stable")
    return np.concatenate(parts)[by_element], origin[by_element]


def _inverted(element: Index, vertices: Array, triangles: Index) -> NDArray[np.bool_]:
    """Return which triangles go round clockwise; refuse those without area."""
    area = cell_areas(vertices, triangles)
    longest = edge_lengths(vertices, triangles).max(axis=1)
    flat = np.abs(area) < 1e-6 * longest**2
    if flat.any():
        raise ValueError(f"element {element[flat][0]} is degenerate: it has no area")
    return area < 0


def _unused_nodes(numbers: Index) -> list[str]:
    if not numbers.size:
        return []
    return [f"{counted(len(numbers), 'node')} without an element ({numbers[0]})"]


def _short_edges(node: Index, vertices: Array, triangles: Index) -> list[str]:
    """Return that nodes are much closer than others of their element, as before a merge."""
    edges = edge_lengths(vertices, triangles)
    share = edges.min(axis=1) / edges.max(axis=1)
    worst = int(np.argmin(share))
    if share[worst] > CLOSE:
        return []
    side = int(np.argmin(edges[worst]))
    a, b = sorted(node[triangles[worst, [side, (side + 1) % 3]]].tolist())
    return [
        f"{counted(int(np.sum(share <= CLOSE)), 'triangle')} with nodes closer than {CLOSE:g} of"
        f" their longest edge ({a} and {b})"
    ]


def counted(count: int, noun: str) -> str:
    """Return a number of things in words."""
    return f"{count} {noun}{'s' * (count > 1)}"
