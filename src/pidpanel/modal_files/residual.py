"""Residual vectors: the local compliance of patches that the modes of a file leave out."""

from typing import NamedTuple

import numpy as np
import scipy.linalg

from pidpanel.arrays import Array
from pidpanel.modal_files.quadrature import CellQuadrature

INDEPENDENT = 1e-8  # least eigenvalue of the scaled mass matrix of residual vectors

CONSISTENT = 0.03  # share of a case's work that the geometry of cells may change


class ResidualVectors(NamedTuple):
    """Vectors that continue a basis of modes, orthogonal to each other."""

    frequency: Array  # (n,) [Hz], rising
    modal_mass: Array  # (n,) [kg], all 1
    displacement: Array  # (n_nodes, 3, n) [1]


def residual_vectors(
    quadrature: CellQuadrature,
    frequency: Array,
    modal_mass: Array,
    displacement: Array,
    static: Array,
    pressure: Array,
    areal_mass: float | Array,
) -> ResidualVectors:
    """Return residual vectors of static cases.

    X_r = X − Σ φ(φᵀF)/(ω²m), K_rr = X_rᵀF, M_rr = ∫ m″ X_rᵀX_r dA; vectors are those of
    K_rr v = λ M_rr v. X has the elastic part of the modes exactly, so that X_r has none.

    Parameters
    ----------
    quadrature
        Points of the surface.
    frequency, modal_mass, displacement
        Modes: (n_modes,) [Hz], (n_modes,) [kg], (n_nodes, 3, n_modes).
    static
        Displacements (n_nodes, 3, n_static) [m] of the cases.
    pressure
        Pressures (n_points, n_static) [Pa] of the cases, along the normal or against it.
    areal_mass
        Mass m″ [kg/m²], at the points if it varies.

    Raises
    ------
    ValueError
        If the structure is free, or displacements are not those of the pressures.
    """
    if not (frequency > 0).all():
        raise ValueError("static cases need a structure without rigid motions")
    load = quadrature.weight[:, None] * pressure
    work = quadrature.normal_displacement(static).T @ load
    load, work = (part * np.sign(np.diag(work)) for part in (load, work))  # against the normal
    asymmetry = np.abs(work - work.T).max() / np.diag(work).max()
    if not asymmetry < CONSISTENT:
        message = f"static cases do work on each other that differs by {asymmetry:.0%}"
        raise ValueError(f"{message}; displacements are not those of the pressures")
    forces = quadrature.normal_displacement(displacement).T @ load
    receptance = forces / ((2 * np.pi * frequency) ** 2 * modal_mass)[:, None]
    remainder = static - displacement @ receptance
    stiffness = quadrature.normal_displacement(remainder).T @ load
    share = np.diag(stiffness) / np.diag(work)
    if share.min() < -CONSISTENT:
        case = 1 + int(np.argmin(share))
        raise ValueError(f"static case {case}: modes alone move {1 - share.min():.0%} of it")
    vectors = quadrature.values(remainder)
    mass = np.einsum("q,qim,qin->mn", quadrature.weight * areal_mass, vectors, vectors)
    scale = np.diag(mass) ** -0.5
    values, modes = scipy.linalg.eigh(scale[:, None] * mass * scale)
    chosen = values > INDEPENDENT
    basis = scale[:, None] * modes[:, chosen] / np.sqrt(values[chosen])
    squares, rotation = scipy.linalg.eigh(basis.T @ (stiffness + stiffness.T) @ basis / 2)
    stiff = squares > 0  # others are rounding, or geometry, of cases that the modes have already
    motion = remainder @ (basis @ rotation[:, stiff])
    frequency = np.sqrt(squares[stiff]) / (2 * np.pi)
    return ResidualVectors(frequency, np.ones(len(frequency)), motion)
