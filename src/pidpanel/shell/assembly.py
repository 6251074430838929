"""A shell as the matrices of a plate: everything downstream of `panel.plate` runs unchanged.

w is the motion along the normal of the surface; positions have three columns.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from skfem.quadrature import get_quadrature

from pidpanel.arrays import Array, Index
from pidpanel.panel.plate import LOAD_ORDER, NONE_FREE, AssembledPlate
from pidpanel.panel.section import Layer
from pidpanel.panel.supports import free_coordinates
from pidpanel.shell.attachments import (
    Attached,
    Hinge,
    PointMass,
    RigidFoot,
    Stiffener,
    arm_matrix,
    beam_matrices,
    held_blocks,
)
from pidpanel.shell.mesh import LAGRANGE, ShellMesh, reference_nodes
from pidpanel.shell.strains import Frames, Layup, frames

CELLS_AT_ONCE = 64  # so that memory stays bounded
TINY = 1e-30  # [m²]
# Cosine between the normal and that of the plane through the corners; below it elements fold.
FOLDED = 0.3
Components = tuple[sp.csr_array, ...]
NOTHING: Mapping[str, Attached] = {}


@dataclass(frozen=True)
class AssembledShell(AssembledPlate):
    """Matrices of a supported shell; `AssembledPlate` with positions of three columns."""

    # Maps positions (n_positions, 3) [m] to three arrays (n_positions, n): motion along x, y, z.
    displacement: Callable[[Array], Components] | None = None
    # For the six rows of `curvature_at_vertices`, see `Layup.layers`; none of several sections
    layers: tuple[Layer, ...] = ()
    total_mass: float = 0.0  # [kg]


def assemble_shell(
    mesh: ShellMesh,
    layup: Layup | Mapping[str, Layup],
    attached: Mapping[str, Attached] = NOTHING,
    order: int = 4,
) -> AssembledShell:
    """Assemble a shell of one section or several, with what holds it and what it carries.

    Parameters
    ----------
    layup
        Section and axis of the whole surface, or of each of `ShellMesh.part_cells` by name.
    attached
        Supports, feet, masses, hinges and stiffeners by name, for messages and for hinges.
    order
        Order of displacements and rotations, 2 to 4; 2 locks.

    Raises
    ------
    ValueError
        For what is attached where there is no element, and for cells with no section.
    """
    shell = _Shell(mesh, layup, order)
    stiffness, mass = shell.matrices()
    free = free_coordinates(shell.size, held_blocks(mesh, order, attached))
    for name, part in attached.items():
        if isinstance(part, PointMass):
            rows = sp.vstack(shell.displacement(np.array([part.position])))
            mass = mass + part.mass * (rows.T @ rows)
        elif isinstance(part, Stiffener):
            K, M = shell.beam(part, name)
            stiffness, mass = stiffness + K, mass + M
    rigid = sp.csr_array(np.tile(np.eye(6, 3), (len(shell.position), 1)))
    K, M = free.T @ stiffness @ free, free.T @ mass @ free
    participation = (free.T @ (mass @ rigid)).toarray()
    total = float((rigid.T @ mass @ rigid).toarray()[0, 0])
    turns = {}  # (3, n) of feet
    for name, foot in attached.items():
        if isinstance(foot, RigidFoot):
            node = int(mesh.selected_nodes(foot.where, order, name)[0])
            arm = arm_matrix(foot.centre - shell.position[node])
            motion = sp.csr_array(sp.csr_array(arm) @ free[6 * node : 6 * node + 6])
            M = M + motion.T @ sp.diags_array([foot.mass] * 3 + list(foot.inertia)) @ motion
            participation = participation + foot.mass * motion[:3].toarray().T
            total = total + foot.mass
            turns[name] = motion[3:]
    for part in attached.values():
        if isinstance(part, Hinge):
            gap = turns[part.feet[1]] - turns[part.feet[0]]
            row = sp.csr_array(np.array([part.axis]) / np.linalg.norm(part.axis)) @ gap
            K = K + part.stiffness * (row.T @ row)
    return shell.assembled(
        free,
        stiffness=sp.csr_array(K),
        mass=sp.csr_array(M),
        inertia=participation[:, 2],
        participation=participation,
        total_mass=total,
    )


class _Shell:
    """The nodes and cells of a shell of one order, without supports."""

    def __init__(self, mesh: ShellMesh, layup: Layup | Mapping[str, Layup], order: int) -> None:
        self.mesh, self.order, self.cells = mesh, order, np.arange(len(mesh.cells))
        self.numbers, self.position = mesh.nodes(order)
        self.size = 6 * len(self.position)
        if isinstance(layup, Layup):
            self.parts = [(layup, self.cells)]
        else:
            cells_of = mesh.part_cells
            self.parts = [(layup[name], cells_of[name]) for name in cells_of if name in layup]
        count = np.zeros(len(self.cells), dtype=np.int64)
        for _, cells in self.parts:
            count[cells] += 1
        if (count != 1).any():
            cell = int(np.argmax(count != 1))
            where = ", ".join(f"{x:g}" for x in mesh.vertices[mesh.cells[cell]].mean(axis=0))
            raise ValueError(f"the element at ({where}) m has {count[cell]} sections; it needs one")

    def groups(self) -> Iterator[tuple[Layup, Index]]:
        """Yield the sections with some of their cells."""
        for layup, cells in self.parts:
            for start in range(0, len(cells), CELLS_AT_ONCE):
                yield layup, cells[start : start + CELLS_AT_ONCE]

    def matrices(self) -> tuple[sp.csr_array, sp.csr_array]:
        """Return K and M of all coordinates."""
        place, weight = get_quadrature(LAGRANGE[self.order], 2 * self.order)
        stiffness, mass = [], []
        for layup, cells in self.groups():
            frame = frames(self.mesh, self.order, place.T, cells, layup)
            area = weight * frame.area
            stiffness.append(frame.stiffness(layup, area))
            mass.append(frame.mass(layup, area))
        dofs = coordinates(self.numbers[np.concatenate([cells for _, cells in self.groups()])])
        return self.summed(dofs, stiffness), self.summed(dofs, mass)

    def summed(self, dofs: Index, blocks: Sequence[Array]) -> sp.csr_array:
        """Return the sum of matrices (m, k, k) of coordinates (m, k)."""
        row, column = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        entries = np.concatenate(blocks).ravel(), (row.ravel(), column.ravel())
        return sp.csr_array(entries, shape=(self.size, self.size))

    def beam(self, beam: Stiffener, name: str) -> tuple[sp.csr_array, sp.csr_array]:
        """Return K and M of a stiffener."""
        edges = self.mesh.selected_edges(beam.where, self.order)
        if not len(edges):
            raise ValueError(f"{name} at {beam.where}: no edge of an element is in it")
        normals = self.normals(self.order)[edges]
        K, M = beam_matrices(beam, self.position[edges], normals)
        return self.summed(coordinates(edges), [K]), self.summed(coordinates(edges), [M])

    def normals(self, order: int) -> Array:
        """Return normals (n, 3) at the nodes of an order, the mean over cells."""
        numbers, position = self.mesh.nodes(order)
        frame = frames(self.mesh, order, reference_nodes(order), self.cells, None)
        total = np.zeros_like(position)
        np.add.at(total, numbers, frame.axes[:, :, 2] * frame.area[..., None])
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), TINY)

    def motion(self, frame: Frames, cells: Index) -> Components:
        """Return motions (n_cells · n_places, n_dofs) along x, y, z at places in cells."""
        values = np.broadcast_to(frame.value, frame.slope.shape[:3])
        nodes = np.broadcast_to(self.numbers[cells][:, None], values.shape).ravel()
        start = np.arange(0, values.size + 1, values.shape[2])
        shape = len(start) - 1, self.size
        x, y, z = (sp.csr_array((values.ravel(), 6 * nodes + k, start), shape) for k in range(3))
        return x, y, z

    def displacement(self, positions: Array) -> Components:
        """Return motions (n_positions, n_dofs) along x, y, z."""
        return self.motion(*self._located(positions))

    def deflection(self, positions: Array) -> sp.csr_array:
        """Return w (n_positions, n_dofs) along the normal."""
        frame, cells = self._located(positions)
        return component(frame.axes[:, 0, 2], self.motion(frame, cells))

    def _located(self, positions: Array) -> tuple[Frames, Index]:
        cells, place = self.mesh.locate(positions)
        return frames(self.mesh, self.order, place[:, None], cells, None), cells

    def strains(self) -> list[sp.csr_array]:
        """Return ε, κ, γ (n_vertices, n_dofs) at the vertices, the mean over cells."""
        corner = np.sort(self.mesh.cells, axis=1)
        share = 1 / np.bincount(corner.ravel())
        strain = [sp.csr_array((len(share), self.size))] * 8
        for layup, cells in self.groups():
            rows = frames(self.mesh, self.order, reference_nodes(1), cells, layup).strains
            rows = rows * share[corner[cells]][..., None, None]
            vertex = np.broadcast_to(corner[cells][:, :, None], rows[:, :, 0].shape)
            dofs = np.broadcast_to(coordinates(self.numbers[cells])[:, None], vertex.shape)
            place = vertex.ravel(), dofs.ravel()
            for k in range(8):
                entries = rows[:, :, k].ravel(), place
                strain[k] = strain[k] + sp.csr_array(entries, shape=strain[k].shape)
        return strain

    def assembled(self, free: sp.csr_array, **matrices: Any) -> AssembledShell:
        """Return matrices and rows in the free coordinates."""
        mesh, order, (layup, _) = self.mesh, self.order, self.parts[0]

        def reduced(*rows: sp.csr_array) -> tuple[sp.csr_array, ...]:
            return tuple(sp.csr_array(matrix @ free) for matrix in rows)

        def normal_motion(accuracy: int, cells: Index) -> tuple[Frames, Array, sp.csr_array]:
            place, weight = get_quadrature(LAGRANGE[order], accuracy)
            frame = frames(mesh, order, place.T, cells, None)
            normal = frame.axes[:, :, 2].reshape(-1, 3)
            (w,) = reduced(component(normal, self.motion(frame, cells)))
            return frame, (weight * frame.area).ravel(), w

        frame, area, w = normal_motion(LOAD_ORDER, self.cells)
        check_folds(mesh, frame)
        overlap, translation = {}, np.empty((len(mesh.patch_cells), free.shape[1] + 3, 3))
        for k, (name, cells) in enumerate(mesh.patch_cells.items()):
            patch, patch_area, moved = normal_motion(2 * order, cells)
            overlap[name] = sp.csr_array(moved.T @ sp.diags_array(patch_area) @ moved)
            along = patch.axes[:, :, 2].reshape(-1, 3)
            weighted = patch_area[:, None] * along
            translation[k] = np.vstack([moved.T @ weighted, along.T @ weighted])
        normal, strain = self.normals(1), reduced(*self.strains())
        vertex = 6 * np.arange(len(normal))  # vertices are the first nodes
        motion = tuple(free[vertex + k] for k in range(3))
        at_vertices = component(normal, motion)
        if not np.any(at_vertices.data):
            raise ValueError(NONE_FREE)
        points = np.array(list(mesh.points.values()), dtype=float).reshape(-1, 3)
        cells, share = mesh.locate(points)
        weights = np.column_stack([1 - share.sum(axis=1), share]).ravel()
        place = np.repeat(np.arange(len(points)), 3), np.sort(mesh.cells[cells], axis=1).ravel()
        empty = sp.csr_array((0, free.shape[1]))
        return AssembledShell(
            **matrices,
            patch_overlap=overlap,
            patch_translation=translation,
            interpolate=lambda positions: reduced(self.deflection(positions))[0],
            displacement=lambda positions: reduced(*self.displacement(positions)),
            at_vertices=at_vertices,
            at_points=reduced(self.deflection(points))[0],
            point_weight=sp.csr_array((weights, place), shape=(len(points), len(normal))),
            quadrature_position=frame.position.reshape(-1, 3),
            quadrature_weight=area,
            quadrature_normal=frame.axes[:, :, 2].reshape(-1, 3),
            at_quadrature=w,
            curvature_at_vertices=(*strain[3:6], *(part / layup.half for part in strain[:3])),
            layers=layup.layers if all(part == layup for part, _ in self.parts) else (),
            shear_at_vertices=strain[6:],
            motion_at_vertices=motion,
            vertex_normal=normal,
            reactions=(empty, empty),
            section=layup.section,
        )


def coordinates(nodes: Index) -> Index:
    """Return the coordinates (m, 6k) of nodes (m, k)."""
    return (6 * nodes[..., None] + np.arange(6)).reshape(len(nodes), 6 * nodes.shape[1])


def component(direction: Array, motion: Sequence[sp.csr_array]) -> sp.csr_array:
    """Return the motion (n, n_dofs) along directions (n, 3)."""
    parts = (sp.diags_array(direction[:, k]) @ rows for k, rows in enumerate(motion))
    return sp.csr_array(sum(parts, sp.csr_array(motion[0].shape)))


def check_folds(mesh: ShellMesh, frame: Frames) -> None:
    """Refuse elements whose normals leave that of their corners."""
    corners = mesh.vertices[mesh.cells]
    chord = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    chord /= np.linalg.norm(chord, axis=1, keepdims=True)
    is_folded = (frame.axes[:, :, 2] @ chord[:, :, None]).min(axis=(1, 2)) < FOLDED
    if is_folded.any():
        where = ", ".join(f"{x:g}" for x in corners[is_folded][0].mean(axis=0))
        raise ValueError(f"the element at ({where}) m is folded: refine the mesh there")
