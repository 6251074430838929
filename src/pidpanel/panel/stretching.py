"""Stretching of a panel's middle plane by its deflection: quartic membrane energy of its modes.

A deflection w stretches the middle plane by e = ½ ∇w ∇wᵀ (von Kármán). The displacement u in the
plane follows at once and keeps the membrane force N = A (ε(u) + e) in equilibrium: in-plane
resonances lie far above those of bending. With w = Σ q_i φ_i and e_ij of two shapes,

    U = ½ Σ A_ijkl q_i q_j q_k q_l,      A_ijkl = ∫ e_ij·A (e_kl + ε(u_kl)) dA,

so that a mode alone has the force k₃ q³, k₃ = 2 A_iiii. No term of third order appears where the
section has a neutral plane (`in_plane_stiffness`).

References
----------
Chia, Nonlinear Analysis of Plates, McGraw-Hill 1980, ch. 1 and 2.
"""

from collections.abc import Iterable

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from skfem import CellBasis, ElementQuad2, ElementTriP2, ElementVector

from pidpanel.arrays import Array, Index
from pidpanel.panel.matrices import Stretching
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import LOAD_ORDER, AssembledPlate, at_points, facet_numbers
from pidpanel.panel.section import SandwichSection, Section
from pidpanel.panel.shapes import Shapes
from pidpanel.panel.supports import Supports, held_vertices

# Modes with their stretching: the lowest from `LOWEST` of the lowest frequency of the response on.
# With 20 instead of 12 the displacement of the paper's panel changes by 0.02 % at most and its
# g rms by 0.2 %, with 8 by 0.3 and 0.6 %, whether its edges are free or held.
MODES, LOWEST = 12, 0.7

POINTS_AT_ONCE = 20_000  # quadrature points taken together, so that memory does not grow

# Distance between the neutral planes of two strains over the thickness above which there is none.
NEUTRAL = 1e-6


def in_plane_stiffness(section: Section) -> Array | None:
    """Return A (3, 3) of a section about its neutral plane [N/m]; None where it has none.

    Where B = z₀ A, the strain at z₀ does not depend on the curvature, and the section stretches and
    bends like a symmetric one. Otherwise stretching has a term of second order in the deflection.
    """
    if not isinstance(section, SandwichSection):
        return section.extensional
    A, B, _ = section.abd
    shift = np.linalg.solve(A, B)
    off = shift - np.trace(shift) / 3 * np.eye(3)
    return A if np.abs(off).max() <= NEUTRAL * section.distance else None


def check_edges(section: Section, *, is_held: bool) -> None:
    """Refuse edges that are held in the plane of a section that bends when it is stretched."""
    if is_held and in_plane_stiffness(section) is None:
        raise ValueError("in_plane_edges must be free: the section is not symmetric")


def in_plane_basis(mesh: PanelMesh) -> CellBasis:
    """Return quadratic elements of the displacement in the plane, at the points of a pressure."""
    element = ElementQuad2() if mesh.cell_kind == "quadrilaterals" else ElementTriP2()
    return CellBasis(mesh.elements, ElementVector(element), intorder=LOAD_ORDER)


def held_edges(basis: CellBasis, edges: Iterable[tuple[int, int]]) -> Index:
    """Return the in-plane coordinates along edges, each of two vertices, the smaller first."""
    facet = facet_numbers(basis.mesh)
    numbers = [facet[edge] for edge in edges]
    return np.asarray(basis.get_dofs(np.array(numbers, dtype=np.int64)).flatten())


def rigid_coordinates(basis: CellBasis) -> Index:
    """Return three in-plane coordinates without which the panel cannot move as a rigid body."""
    vertices = basis.mesh.p.T
    away = vertices - vertices[0]
    far = int(np.argmax((away**2).sum(axis=1)))
    across = int(np.argmin(np.abs(away[far])))
    return np.array([*basis.nodal_dofs[:, 0], basis.nodal_dofs[across, far]])


def membrane_tensor(
    basis: CellBasis, extensional: Array, slopes: Array, free: sp.csr_array
) -> Array:
    """Return A_ijkl (n, n, n, n) [N/m³].

    Parameters
    ----------
    basis
        Elements of `in_plane_basis`.
    extensional
        (3, 3) A [N/m].
    slopes
        (2, n_quadrature, n) ∂φ/∂x and ∂φ/∂y of the shapes at the points of ``basis`` [1/m].
    free
        (n_dofs, n_free) coordinates of the displacement that are free; no rigid body among them.
    """
    weight = basis.dx.ravel()
    # engineering strains of a basis function that is a vector
    parts = [[f[0].grad[0, 0], f[0].grad[1, 1], f[0].grad[0, 1] + f[0].grad[1, 0]]
             for f in basis.basis]  # fmt: skip
    strain = [
        sp.csr_array(at_points([part[k] for part in parts], basis.element_dofs, basis.N) @ free)
        for k in range(3)
    ]
    n = slopes.shape[2]
    first, second = np.triu_indices(n)
    energy = np.zeros((len(first), len(first)))
    load = np.zeros((free.shape[1], len(first)))
    for start in range(0, len(weight), POINTS_AT_ONCE):
        points = slice(start, start + POINTS_AT_ONCE)
        x, y = slopes[:, points]
        stretched = np.stack([  # engineering strains e_ij at the points, (3, points, pairs)
            x[:, first] * x[:, second] / 2,
            y[:, first] * y[:, second] / 2,
            (x[:, first] * y[:, second] + y[:, first] * x[:, second]) / 2,
        ])  # fmt: skip
        force = weight[points, None] * np.einsum("kl,lpi->kpi", extensional, stretched)
        energy += np.einsum("kpi,kpj->ij", stretched, force, optimize=True)
        for k in range(3):
            load += strain[k][points].T @ force[k]
    stiffness = sum(
        extensional[k, m] * (strain[k].T @ (weight[:, None] * strain[m]))
        for k in range(3)
        for m in range(3)
        if extensional[k, m]
    )
    energy -= load.T @ spla.splu(sp.csc_matrix(stiffness)).solve(load)
    pair = np.zeros((n, n), dtype=np.int64)
    pair[first, second] = pair[second, first] = np.arange(len(first))
    return np.asarray(energy[pair[:, :, None, None], pair[None, None]])


def panel_stretching(
    mesh: PanelMesh,
    plate: AssembledPlate,
    shapes: Shapes,
    lowest_frequency: float,
    held: Supports | None = None,
) -> Stretching | None:
    """Return the stretching of the modes that a response from a frequency on has [Hz].

    Parameters
    ----------
    held
        Supports whose edges are held in the plane too; None where all edges are free in it.

    Returns
    -------
    Stretching; None where the section has no neutral plane, or the panel no such mode.
    """
    extensional = in_plane_stiffness(plate.section)
    if extensional is None:
        return None
    modes = np.flatnonzero(shapes.frequency >= LOWEST * lowest_frequency)[:MODES]
    modes = modes[shapes.frequency[modes] > 0]
    if not modes.size:
        return None
    basis = in_plane_basis(mesh)
    fixed = rigid_coordinates(basis)
    if held is not None:
        fixed = held_edges(basis, held_vertices(mesh, held)[1])
    moves = np.setdiff1d(np.arange(basis.N), fixed)
    free = sp.csr_array(sp.identity(basis.N, format="csr")[:, moves])
    vectors = shapes.vectors[:, modes]
    slopes = np.stack([slope @ vectors for slope in plate.slope_at_quadrature])
    return Stretching(modes, membrane_tensor(basis, extensional, slopes, free))
