"""A shell as the matrices of a plate: everything downstream of `panel.plate` runs unchanged.

w is the motion along the normal of the surface; positions have three columns.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from skfem.quadrature import get_quadrature

from pidpanel.arrays import Array, Index
from pidpanel.panel.plate import NONE_FREE, AssembledPlate
from pidpanel.panel.supports import free_coordinates
from pidpanel.shell.attachments import (
    Attached,
    Hinge,
    PointMass,
    RigidFoot,
    Stiffener,
    beam_matrices,
    foot_motion,
    held_blocks,
)
from pidpanel.shell.mesh import LAGRANGE, ShellMesh
from pidpanel.shell.strains import DRILLING_INERTIA, Frames, Layup, frames

CELLS_AT_ONCE = 64  # so that memory stays bounded
Components = tuple[sp.csr_array, sp.csr_array, sp.csr_array]
NOTHING: Mapping[str, Attached] = {}


@dataclass(frozen=True)
class AssembledShell(AssembledPlate):
    """Matrices of a supported shell; `AssembledPlate` with positions of three columns."""

    # Maps positions (n_positions, 3) [m] to three arrays (n_positions, n): motion along x, y, z.
    displacement: Callable[[Array], Components] | None = None
    # three arrays (n_vertices, n): strains ε (see `strains`) at the vertices [1]
    membrane_at_vertices: Components | tuple[()] = ()
    vertex_normal: Array | None = None  # (n_vertices, 3) mean of the cells that meet there
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
        Order of displacements and rotations: 4, or 3 at twice the number of elements.

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
    K, M = sp.csr_array(free.T @ stiffness @ free), sp.csr_array(free.T @ mass @ free)
    participation = (free.T @ (mass @ rigid)).toarray()
    total = float((rigid.T @ mass @ rigid).toarray()[0, 0])
    turns = {}  # (3, n) of feet
    for name, foot in attached.items():
        if isinstance(foot, RigidFoot):
            node = int(mesh.selected_nodes(foot.where, order, name)[0])
            motion = foot_motion(foot.centre, node, shell.position[node], free)
            M = M + motion.T @ sp.diags_array([foot.mass] * 3 + list(foot.inertia)) @ motion
            participation = participation + foot.mass * motion[:3].toarray().T
            total, turns[name] = total + foot.mass, motion[3:]
    for part in attached.values():
        if isinstance(part, Hinge):
            gap = turns[part.feet[1]] - turns[part.feet[0]]
            row = sp.csr_array(np.array([part.axis]) / np.linalg.norm(part.axis)) @ gap
            K = K + part.stiffness * (row.T @ row)
    return shell.assembled(free, sp.csr_array(K), sp.csr_array(M), participation, total)


class _Shell:
    """The nodes and cells of a shell of one order, without supports."""

    def __init__(self, mesh: ShellMesh, layup: Layup | Mapping[str, Layup], order: int) -> None:
        self.mesh, self.order = mesh, order
        self.numbers, self.position = mesh.nodes(order)
        self.size = 6 * len(self.position)
        cells_all = np.arange(len(mesh.cells))
        parts = (
            [(layup, cells_all)]
            if isinstance(layup, Layup)
            else [(layup[name], cells) for name, cells in mesh.part_cells.items() if name in layup]
        )
        self.layup = [part for part, _ in parts]
        count = np.bincount(
            np.concatenate([c for _, c in parts] or [cells_all[:0]]), minlength=len(cells_all)
        )
        if (count != 1).any():
            cell = int(np.argmax(count != 1))
            where = ", ".join(f"{x:g}" for x in mesh.vertices[mesh.cells[cell]].mean(axis=0))
            raise ValueError(f"the element at ({where}) m has {count[cell]} sections; it needs one")
        self.section_number = np.zeros(len(cells_all), dtype=np.int64)
        for number, (_, cells) in enumerate(parts):
            self.section_number[cells] = number

    def groups(self, cells: Index) -> Iterator[tuple[Layup, Index]]:
        """Yield the sections with some of their cells among the given ones."""
        for number, layup in enumerate(self.layup):
            members = cells[self.section_number[cells] == number]
            for start in range(0, len(members), CELLS_AT_ONCE):
                yield layup, members[start : start + CELLS_AT_ONCE]

    def dofs(self, numbers: Index) -> Index:
        """Return the coordinates (…, 6k) of nodes (…, k)."""
        return (6 * numbers[..., None] + np.arange(6)).reshape(
            *numbers.shape[:-1], 6 * numbers.shape[-1]
        )

    def summed(self, blocks: Sequence[tuple[Index, Array]]) -> sp.csr_array:
        """Return the sum of matrices (m, k, k) of coordinates (m, k)."""
        values = [block.ravel() for _, block in blocks]
        rows = [np.repeat(dofs, dofs.shape[1], axis=1).ravel() for dofs, _ in blocks]
        columns = [np.tile(dofs, dofs.shape[1]).ravel() for dofs, _ in blocks]
        if not blocks:
            return sp.csr_array((self.size, self.size))
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return sp.csr_array(entries, shape=(self.size, self.size))

    def matrices(self) -> tuple[sp.csr_array, sp.csr_array]:
        """Return K and M of all coordinates."""
        place, weight = get_quadrature(LAGRANGE[self.order], 2 * self.order)
        stiff, inert = [], []
        for layup, cells in self.groups(np.arange(len(self.mesh.cells))):
            frame = frames(self.mesh, self.order, place.T, cells, layup)
            dofs = self.dofs(self.numbers[cells])
            stiff.append((dofs, _integral(frame.strains, layup.stiffness, weight * frame.area)))
            inert.append((dofs, _integral(frame.motions, _density(layup), weight * frame.area)))
        return self.summed(stiff), self.summed(inert)

    def beam(self, beam: Stiffener, name: str) -> tuple[sp.csr_array, sp.csr_array]:
        """Return K and M of a stiffener."""
        edges = self.mesh.selected_edges(beam.where, self.order)
        if not len(edges):
            raise ValueError(f"{name} at {beam.where}: no edge of an element is in it")
        normals = self.node_normals()
        K, M = beam_matrices(beam, self.position[edges], normals[edges])
        dofs = self.dofs(edges)
        return self.summed([(dofs, K)]), self.summed([(dofs, M)])

    def node_normals(self) -> Array:
        """Return the normals (n, 3) at the nodes, the mean over cells."""
        total = np.zeros_like(self.position)
        place = np.array(LAGRANGE[self.order].doflocs)
        for layup, cells in self.groups(np.arange(len(self.mesh.cells))):
            frame = frames(self.mesh, self.order, place, cells, layup)
            np.add.at(total, self.numbers[cells], frame.axes[:, :, 2] * frame.area[..., None])
        return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)

    def rows(self, values: Array, cells: Index) -> sp.csr_array:
        """Return the matrix (n_cells · n_places, n_dofs) of values (n_cells, n_places, 6k)."""
        dofs = np.broadcast_to(self.dofs(self.numbers[cells])[:, None], values.shape)
        start = np.arange(0, values.size + 1, values.shape[-1])
        shape = (values.shape[0] * values.shape[1], self.size)
        return sp.csr_array((values.ravel(), dofs.ravel(), start), shape=shape)

    def displacement(self, positions: Array) -> Components:
        """Return motions (n_positions, n_dofs) along x, y, z."""
        frame, cells = self._located(positions)
        return tuple(self.rows(frame.motions[:, :, x], cells) for x in range(3))

    def deflection(self, positions: Array) -> sp.csr_array:
        """Return w (n_positions, n_dofs) along the normal."""
        frame, cells = self._located(positions)
        return self.rows(_normal_motion(frame), cells)

    def _located(self, positions: Array) -> tuple[Frames, Index]:
        cells, place = self.mesh.locate(positions)
        return frames(self.mesh, self.order, place[:, None], cells, None), cells

    def vertex_rows(self) -> tuple[Array, list[sp.csr_array]]:
        """Return normals (n_vertices, 3), and ε, κ, γ at the vertices, the mean over cells."""
        corner = np.sort(self.mesh.cells, axis=1)
        count = len(self.mesh.vertices)
        normal, strain = np.zeros((count, 3)), [sp.csr_array((count, self.size))] * 8
        share = 1 / np.bincount(corner.ravel(), minlength=count)
        for layup, cells in self.groups(np.arange(len(corner))):
            place = np.array(LAGRANGE[1].doflocs)
            frame = frames(self.mesh, self.order, place, cells, layup)
            vertex, strains = corner[cells], frame.strains
            np.add.at(normal, vertex, frame.axes[:, :, 2])
            mean = sp.csr_array(
                (share[vertex.ravel()], (vertex.ravel(), np.arange(vertex.size))),
                shape=(count, vertex.size),
            )
            strain = [
                old + mean @ self.rows(strains[:, :, k], cells) for k, old in enumerate(strain)
            ]
        return normal / np.linalg.norm(normal, axis=1, keepdims=True), strain

    def assembled(
        self,
        free: sp.csr_array,
        stiffness: sp.csr_array,
        mass: sp.csr_array,
        participation: Array,
        total_mass: float,
    ) -> AssembledShell:
        """Return matrices and rows in the free coordinates."""
        mesh, cells_all = self.mesh, np.arange(len(self.mesh.cells))

        def reduced(rows: sp.csr_array) -> sp.csr_array:
            return sp.csr_array(rows @ free)

        place, weight = get_quadrature(LAGRANGE[self.order], 2 * self.order)
        frame = frames(mesh, self.order, place.T, cells_all, None)
        at_quadrature = reduced(self.rows(_normal_motion(frame), cells_all))
        area = weight * frame.area
        number = np.arange(area.size).reshape(area.shape)
        overlap = {}
        for name, cells in mesh.patch_cells.items():
            rows = at_quadrature[number[cells].ravel()]
            overlap[name] = sp.csr_array(rows.T @ sp.diags_array(area[cells].ravel()) @ rows)
        normal, strain = self.vertex_rows()
        vertex = np.arange(len(mesh.vertices))  # vertices are the first nodes
        motion = tuple(
            reduced(sp.eye_array(self.size, format="csr")[6 * vertex + x]) for x in range(3)
        )
        at_vertices = sum(sp.diags_array(normal[:, x]) @ motion[x] for x in range(3))
        if not np.any(at_vertices.data):
            raise ValueError(NONE_FREE)
        points = np.array(list(mesh.points.values()), dtype=float).reshape(-1, 3)
        cells, share = mesh.locate(points)
        weights = np.column_stack([1 - share.sum(axis=1), share])
        corner = np.sort(mesh.cells[cells], axis=1)
        row = np.repeat(np.arange(len(points)), 3)
        empty = sp.csr_array((0, free.shape[1]))
        return AssembledShell(
            stiffness=stiffness,
            mass=mass,
            patch_overlap=overlap,
            interpolate=lambda positions: reduced(self.deflection(positions)),
            at_vertices=sp.csr_array(at_vertices),
            at_points=reduced(self.deflection(points)),
            point_weight=sp.csr_array(
                (weights.ravel(), (row, corner.ravel())), shape=(len(points), len(normal))
            ),
            quadrature_position=frame.position.reshape(-1, 3),
            quadrature_weight=area.ravel(),
            at_quadrature=at_quadrature,
            curvature_at_vertices=tuple(map(reduced, strain[3:6])),
            shear_at_vertices=tuple(map(reduced, strain[6:8])),
            reactions=(empty, empty),
            section=self.layup[0].section,
            inertia=participation[:, 2],
            displacement=lambda positions: tuple(map(reduced, self.displacement(positions))),
            motion_at_vertices=motion,
            membrane_at_vertices=tuple(map(reduced, strain[:3])),
            vertex_normal=normal,
            quadrature_normal=frame.axes[:, :, 2].reshape(-1, 3),
            participation=participation,
            total_mass=total_mass,
        )


def _integral(rows: Array, constant: Array, weight: Array) -> Array:
    """Return Σ w Rᵀ C R (n_cells, 6k, 6k) of rows R (n_cells, n_places, r, 6k)."""
    right = (constant @ rows) * weight[:, :, None, None]
    flat = len(rows), -1, rows.shape[-1]
    return np.asarray(rows.reshape(flat).swapaxes(1, 2) @ right.reshape(flat))


def _density(layup: Layup) -> Array:
    """Return (7, 7) of (u, θ × n, θ·n), with the first moment between both."""
    mass, first, second = layup.density
    C = np.diag([mass] * 3 + [second] * 3 + [DRILLING_INERTIA * second])
    C[:3, 3:6] = C[3:6, :3] = first * np.eye(3)
    return C


def _normal_motion(frame: Frames) -> Array:
    """Return w (n_cells, n_places, 6k)."""
    return np.asarray(np.einsum("cqx,cqxd->cqd", frame.axes[:, :, 2], frame.motions[:, :, :3]))
