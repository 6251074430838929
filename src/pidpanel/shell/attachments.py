"""What holds a shell and what is joined to it: supports, rigid feet, masses, hinges, stiffeners."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.panel.supports import Block, null_space
from pidpanel.shell.mesh import ShellMesh
from pidpanel.shell.selections import Line, Place, Selection

AXES = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class ShellSupport:
    """Nodes within a selection that do not move and do not turn along some directions.

    By default they are clamped; with ``rotation=()`` they are pinned.
    """

    where: Selection
    motion: Sequence[Place] = AXES
    rotation: Sequence[Place] = AXES

    @property
    def rows(self) -> Array:
        """(n, 6) on (u, θ), which vanish."""
        rows = np.zeros((len(self.motion) + len(self.rotation), 6))
        rows[: len(self.motion), :3] = np.reshape(self.motion, (-1, 3))
        rows[len(self.motion) :, 3:] = np.reshape(self.rotation, (-1, 3))
        return rows


@dataclass(frozen=True)
class RigidFoot:
    """Nodes within a selection that move as one rigid body, such as a hold-down or a hub."""

    where: Selection
    centre: Place  # of its mass; the support acts there [m]
    support: ShellSupport | None = None  # directions held; its selection has no meaning
    mass: float = 0.0  # [kg]
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)  # about axes through the centre [kg m²]


@dataclass(frozen=True)
class PointMass:
    """A mass at a place on the surface."""

    position: Place  # [m]
    mass: float  # [kg]


@dataclass(frozen=True)
class Hinge:
    """Two feet that turn against each other about an axis alone, with a spring.

    A foot has one hinge at most.
    """

    feet: tuple[str, str]
    position: Place  # on the axis [m]
    axis: Place
    stiffness: float = 0.0  # [N m/rad]


@dataclass(frozen=True)
class Stiffener:
    """A beam along the edges of elements within a selection.

    It resists stretching, bending and shear in its plane with the normal, and torsion. Bending and
    shear along the surface are left out: with them the rotation about the normal, which is the
    surface's, makes twist 3 to 9 % too stiff.
    """

    where: Line
    youngs_modulus: float  # [Pa]
    shear_modulus: float  # [Pa]
    density: float  # [kg/m³]
    area: float  # [m²]
    bending: float  # second moment of area about the axis across the beam in the surface [m⁴]
    torsion: float  # torsion constant [m⁴]
    offset: float = 0.0  # of the centroid along the normal of the surface [m]
    shear_correction: float = 5 / 6


Attached = ShellSupport | RigidFoot | PointMass | Hinge | Stiffener


def arm_matrix(arm: Array) -> Array:
    """Return (…, 6, 6) motions and rotations at an arm (…, 3) [m] of a rigid body, from its own."""
    matrix = np.zeros((*arm.shape[:-1], 6, 6))
    matrix[..., range(6), range(6)] = 1.0
    for axis, unit in enumerate(np.eye(3)):
        matrix[..., :3, 3 + axis] = np.cross(unit, arm)
    return matrix


def held_blocks(mesh: ShellMesh, order: int, parts: Mapping[str, Attached]) -> list[Block]:
    """Return the blocks of coordinates that supports, feet and hinges hold or join."""
    _, nodes = mesh.nodes(order)
    forbidden: dict[int, tuple[str, list[Array]]] = {}
    feet: dict[str, tuple[RigidFoot, Index]] = {}
    for name, part in parts.items():
        if isinstance(part, ShellSupport):
            for node in mesh.selected_nodes(part.where, order, name):
                forbidden.setdefault(int(node), (name, []))[1].append(part.rows)
        elif isinstance(part, RigidFoot):
            feet[name] = part, mesh.selected_nodes(part.where, order, name)
    blocks = [
        Block(name, _dofs(np.array([node])), null_space(np.vstack(rows)))
        for node, (name, rows) in forbidden.items()
    ]
    pairs = {name: part for name, part in parts.items() if isinstance(part, Hinge)}
    hinged = [foot for hinge in pairs.values() for foot in hinge.feet]
    for name, hinge in pairs.items():
        if unknown := [f"{foot!r}" for foot in hinge.feet if foot not in feet]:
            raise ValueError(f"{name}: no foot {unknown[0]}; there are {', '.join(feet) or 'none'}")
        axis = np.append(np.zeros(3), np.array(hinge.axis) / np.linalg.norm(hinge.axis))
        turns = np.zeros((6, 1)), axis[:, None]  # of the second foot about the axis
        joined = [feet[foot] for foot in hinge.feet]
        blocks.append(_foot_block(name, joined, nodes, hinge.position, turns))
    for name, foot in feet.items():
        if name not in hinged:
            blocks.append(_foot_block(name, [foot], nodes, foot[0].centre, [np.zeros((6, 0))]))
    return blocks


def _foot_block(
    name: str,
    feet: Sequence[tuple[RigidFoot, Index]],
    nodes: Array,
    place: Place,
    turns: Sequence[Array],
) -> Block:
    """Return feet that move as a rigid body at a place does, and by turns of their own."""
    motions = [np.hstack([np.eye(6), turn]) for turn in turns]
    columns, rows_held = [], [np.zeros((1, motions[0].shape[1]))]
    for (foot, inside), motion in zip(feet, motions, strict=True):
        columns.append((arm_matrix(nodes[inside] - place) @ motion).reshape(-1, motion.shape[1]))
        if foot.support is not None:
            centre = arm_matrix(np.subtract(foot.centre, place))
            rows_held.append(foot.support.rows @ centre @ motion)
    dofs = np.concatenate([_dofs(inside) for _, inside in feet])
    return Block(name, dofs, np.vstack(columns) @ null_space(np.vstack(rows_held)))


def _dofs(nodes: Index) -> Index:
    return (6 * nodes[:, None] + np.arange(6)).ravel()


def beam_matrices(beam: Stiffener, nodes: Array, normals: Array) -> tuple[Array, Array]:
    """Return stiffness and mass (m, 6k, 6k) of a beam on m edges of k nodes.

    Parameters
    ----------
    nodes, normals
        (m, k, 3) positions [m], and normals of the surface there, from end to end at equal spacing.
    """
    count = nodes.shape[1]
    x, weight = np.polynomial.legendre.leggauss(count)
    inverse = np.linalg.inv(np.vander(np.linspace(-1, 1, count), increasing=True))
    powers = np.vander(x, count, increasing=True)
    value = powers @ inverse
    slope = np.arange(count) * powers[:, [0, *range(count - 1)]] @ inverse
    tangent = np.einsum("qk,mkx->mqx", slope, nodes)
    speed = np.linalg.norm(tangent, axis=-1)
    t = tangent / speed[..., None]
    n = np.einsum("qk,mkx->mqx", value, normals)
    n -= np.sum(n * t, axis=-1, keepdims=True) * t
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    across = np.cross(n, t)
    # motion and rotation of the centroid, and their derivatives along the beam
    arm = arm_matrix(beam.offset * normals)
    shape = *speed.shape, 6, 6 * count
    moved = np.einsum("qk,mkij->mqikj", value, arm).reshape(shape)
    slopes = np.einsum("qk,mq,mkij->mqikj", slope, 1 / speed, arm).reshape(shape)
    # stretch t·∂u, shear n·∂u + t·(θ × n), twist t·∂θ, bending across·∂θ
    form = np.zeros((*speed.shape, 4, 12))
    form[:, :, 0, :3] = form[:, :, 2, 3:6] = t
    form[:, :, 1, :3], form[:, :, 1, 9:], form[:, :, 3, 3:6] = n, across, across
    rows = form @ np.concatenate([slopes, moved], axis=2)
    E, G, A = beam.youngs_modulus, beam.shear_modulus, beam.area
    stiff = np.array([E * A, beam.shear_correction * G * A, G * beam.torsion, E * beam.bending])
    length = weight * speed
    K = np.einsum("mqri,r,mqrj,mq->mij", rows, stiff, rows, length, optimize=True)
    inertia = np.zeros((*speed.shape, 6, 6))
    inertia[..., :3, :3] = A * np.eye(3)
    # the polar second moment of a blade is nearly that of bending
    turned = t[..., None] * t[..., None, :] + across[..., None] * across[..., None, :]
    inertia[..., 3:, 3:] = beam.bending * turned
    M = np.einsum("mqai,mqab,mqbj,mq->mij", moved, inertia, moved, length, optimize=True)
    return K, beam.density * M
