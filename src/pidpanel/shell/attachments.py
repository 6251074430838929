"""What holds a shell and what is joined to it: supports, rigid feet, masses, hinges, stiffeners."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array, Index
from pidpanel.panel.supports import Block
from pidpanel.shell.selections import Place, Selection

CLAMPED, PINNED = (0, 1, 2, 3, 4, 5), (0, 1, 2)  # components held: motion along x, y, z; rotation
SLACK = 1e-6  # over the extent: nodes nearer to a selection are in it
HINGE_STIFFNESS = 1e4  # of what a hinge joins, over the largest term of K


@dataclass(frozen=True)
class ShellSupport:
    """Nodes within a selection, of which components 0 to 5 (u, θ) along x, y, z vanish."""

    where: Selection
    held: tuple[int, ...] = CLAMPED


@dataclass(frozen=True)
class RigidFoot:
    """Nodes within a selection that move as one rigid body, such as a hold-down or a hub."""

    where: Selection
    centre: Place  # of its mass, and of what is held [m]
    held: tuple[int, ...] = ()  # components as of a `ShellSupport`
    mass: float = 0.0  # [kg]
    inertia: tuple[float, float, float] = (0.0, 0.0, 0.0)  # about axes through the centre [kg m²]


@dataclass(frozen=True)
class PointMass:
    """A mass at a place on the surface."""

    position: Place  # [m]
    mass: float  # [kg]


@dataclass(frozen=True)
class Hinge:
    """Two feet that turn against each other about an axis alone, with a spring."""

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

    where: Selection
    youngs_modulus: float  # [Pa]
    shear_modulus: float  # [Pa]
    density: float  # [kg/m³]
    area: float  # [m²]
    bending: float  # second moment of area about the axis across the beam in the surface [m⁴]
    torsion: float  # torsion constant [m⁴]
    offset: float = 0.0  # of the centroid along the normal of the surface [m]
    shear_correction: float = 5 / 6


def arm_matrix(arm: Array) -> Array:
    """Return (…, 6, 6) motions and rotations at an arm (…, 3) [m] of a rigid body, from its own."""
    matrix = np.zeros((*arm.shape[:-1], 6, 6))
    matrix[..., range(6), range(6)] = 1.0
    for axis, unit in enumerate(np.eye(3)):
        matrix[..., :3, 3 + axis] = np.cross(unit, arm)
    return matrix


def selected_nodes(
    where: Selection, nodes: Array, vertices: int, extent: float, name: str
) -> Index:
    """Return the nodes within a selection; a corner of an element must be among them."""
    inside = np.flatnonzero(where.contains(nodes, SLACK * extent))
    if not np.any(inside < vertices):
        raise ValueError(f"{name} at {where}: no corner of an element is in it")
    return inside


def held_blocks(
    parts: dict[str, ShellSupport | RigidFoot], nodes: Array, vertices: int, extent: float
) -> list[Block]:
    """Return the blocks of coordinates that supports and feet hold or join."""
    blocks = []
    held = np.zeros((len(nodes), 6), dtype=bool)
    for name, part in parts.items():
        inside = selected_nodes(part.where, nodes, vertices, extent, name)
        if isinstance(part, ShellSupport):
            held[inside[:, None], list(part.held)] = True
        else:
            columns = arm_matrix(nodes[inside] - part.centre).reshape(-1, 6)
            dofs = (6 * inside[:, None] + np.arange(6)).ravel()
            blocks.append(Block(name, dofs, np.delete(columns, part.held, axis=1)))
    dofs = np.flatnonzero(held.ravel())
    if dofs.size:
        blocks.append(Block("a support", dofs, np.zeros((len(dofs), 0))))
    return blocks


def foot_motion(
    foot: RigidFoot, node: int, position: Array, free: sp.csr_array, place: Place
) -> sp.csr_array:
    """Return motion and rotation (6, n) of a foot at a place, from those of one of its nodes."""
    arm = np.asarray(place, dtype=float) - position
    return sp.csr_array(sp.csr_array(arm_matrix(arm)) @ free[6 * node : 6 * node + 6])


def hinge_matrix(hinge: Hinge, ends: Sequence[sp.csr_array], stiffness: float) -> sp.csr_array:
    """Return the stiffness (n, n) between both feet, whose motions (6, n) at its place are given."""
    axis = np.array(hinge.axis, dtype=float) / np.linalg.norm(hinge.axis)
    spring = np.zeros((6, 6))
    spring[:3, :3] = stiffness * np.eye(3)
    spring[3:, 3:] = stiffness * (np.eye(3) - np.outer(axis, axis))
    spring[3:, 3:] += hinge.stiffness * np.outer(axis, axis)
    gap = ends[1] - ends[0]
    return sp.csr_array(gap.T @ sp.csr_array(spring) @ gap)


def beam_matrices(beam: Stiffener, nodes: Array, normals: Array) -> tuple[Array, Array]:
    """Return stiffness and mass (m, 6k, 6k) of a beam on m edges of k nodes.

    Parameters
    ----------
    nodes, normals
        (m, k, 3) positions [m], and normals of the surface there, from end to end at equal spacing.
    """
    count = nodes.shape[1]
    x, weight = np.polynomial.legendre.leggauss(count)
    grid = np.linspace(-1, 1, count)
    inverse = np.linalg.inv(np.vander(grid, count, increasing=True))
    value = np.vander(x, count, increasing=True) @ inverse
    powers = np.arange(count)
    slope = powers * np.vander(x, count, increasing=True)[:, [0, *range(count - 1)]] @ inverse
    tangent = np.einsum("qk,mkx->mqx", slope, nodes)
    speed = np.linalg.norm(tangent, axis=-1)
    t = tangent / speed[..., None]
    slope = slope[None] / speed[..., None]
    # u + θ × (offset n) of the centroid, by node; its columns are (u, θ)
    centroid = arm_matrix(beam.offset * normals)[..., :3, :]  # (m, k, 3, 6)
    n = np.einsum("qk,mkx->mqx", value, normals)
    n -= np.einsum("mqx,mqx->mq", n, t)[..., None] * t
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    across = np.cross(n, t)
    turn = np.zeros((3, 6))
    turn[:, 3:] = np.eye(3)
    motion = np.einsum("qk,mkxd->mqxkd", value, centroid)
    stretch = np.einsum("mqk,mkxd->mqxkd", slope, centroid)
    rotation = np.einsum("qk,xd->qxkd", value, turn)[None]
    twist = np.einsum("mqk,xd->mqxkd", slope, turn)
    rows = np.stack(
        [
            np.einsum("mqx,mqxkd->mqkd", t, stretch),
            # n·∂u + t·(θ × n), the shear angle
            np.einsum("mqx,mqxkd->mqkd", n, stretch)
            + np.einsum("mqx,mqxkd->mqkd", np.cross(n, t), np.broadcast_to(rotation, motion.shape)),
            np.einsum("mqx,mqxkd->mqkd", t, twist),
            np.einsum("mqx,mqxkd->mqkd", across, twist),
        ],
        axis=2,
    )
    E, G, A = beam.youngs_modulus, beam.shear_modulus, beam.area
    stiff = np.array([E * A, beam.shear_correction * G * A, G * beam.torsion, E * beam.bending])
    turned = np.stack(
        [
            np.einsum("mqx,mqxkd->mqkd", axis, np.broadcast_to(rotation, motion.shape))
            for axis in (t, across)
        ],
        axis=2,
    )
    inert = np.concatenate([motion, turned], axis=2)
    # the polar second moment of a blade is about that across; nearly all of it is
    density = beam.density * np.array([A, A, A, beam.bending, beam.bending])

    def summed(parts: Array, constant: Array) -> Array:
        parts = parts.reshape(len(nodes), -1, constant.size, 6 * count)
        factor = constant * (weight * speed)[..., None]
        return np.einsum("mqri,mqr,mqrj->mij", parts, factor, parts, optimize=True)

    return summed(rows, stiff), summed(inert, density)
