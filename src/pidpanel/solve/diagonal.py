"""The paper's form of the panel with dampers: the modes stay uncoupled.

The paper keeps only the diagonal of D and takes C_e(ω) through a Laplace transform as a constant
(Eq. 9-15); here C_e is that of each line.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.dampers import check_stable, checked_dampers, patch_stiffness
from pidpanel.solve.modal import (
    MatrixInput,
    check_patches,
    checked_frequency,
    checked_motions,
    checked_pressure_psd,
    chunks_of_lines,
    matrices_at,
)
from pidpanel.solve.model import ModalBasis, Patches, Response
from pidpanel.solve.motions import Motions, Reals


def diagonal_norm(basis: ModalBasis, patches: Patches) -> Array:
    """Return (n_patches,) what a negative C_e takes of the damping, largest D_ii/C_ii."""
    with np.errstate(divide="ignore"):  # infinite of a rigid body's mode
        return np.max(patches.diagonal / basis.damping, axis=1, initial=0.0)


def diagonal_response(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    motion_at_points: ArrayLike,
    pressure_psd: ArrayLike,
    modal_force: MatrixInput,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    allow_negative_damping: bool = False,
) -> Response:
    """Return the response with modes uncoupled by the dampers, as the paper has it (Eq. 9-15).

    Only the diagonal of D_p enters the equations of motion,

        H_i = 1/(m_i (ω_i² − ω² + 2iζ_i ω_i ω) + (iω C_e − ω² m_a) D_ii),

    though a patch couples all modes: beside a strong patch the full matrix differs by several dB
    above 1 kHz. The modal forces stay correlated. It is here to repeat the paper, whose m_a is 0.

    Parameters, returns and errors are those of `bare_panels` and `attach_dampers`.
    """
    frequency = checked_frequency(frequency)
    pressure_psd = checked_pressure_psd(pressure_psd, frequency)
    n = basis.natural_frequency.size
    points = checked_motions(motion_at_points, n)
    check_patches(patches, n)
    damping, mass = checked_dampers(patches.count, frequency, equivalent_damping, apparent_mass)
    overlap = patches.diagonal
    check_stable(damping, diagonal_norm(basis, patches), allow_negative_damping)

    transfer = _diagonal_transfer(frequency, basis, overlap, damping, mass)
    cross_psd = np.empty((frequency.size, points.shape[0], *points.shape[1:2] * 2), complex)
    for lines in chunks_of_lines(frequency.size):
        force = matrices_at(modal_force, frequency, lines, n)
        sound = pressure_psd[lines, None, None]
        for index, point in enumerate(points):
            motion = point * transfer[lines, None, :]
            cross_psd[lines, index] = sound * (motion @ force @ motion.conj().swapaxes(1, 2))
    return Response(frequency, cross_psd)


def diagonal_slope(
    frequency: Array,
    basis: ModalBasis,
    patches: Patches,
    motion_at_points: ArrayLike,
    pressure_psd: Array,
    modal_force: MatrixInput,
    equivalent_damping: Array,
    apparent_mass: Array,
) -> Complexes:
    """Return t (n_patches, nf, n_points) of `dampers.acceleration_slope`: δH_i = −H_i² D_ii δs.

    Parameters are those of `diagonal_response`.
    """
    n = basis.natural_frequency.size
    deflection = checked_motions(motion_at_points, n)[:, 0]
    overlap = patches.diagonal
    transfer = _diagonal_transfer(frequency, basis, overlap, equivalent_damping, apparent_mass)
    slope = np.empty((len(overlap), frequency.size, len(deflection)), complex)
    for lines in chunks_of_lines(frequency.size):
        force = matrices_at(modal_force, frequency, lines, n)
        motion = deflection * transfer[lines, None, :]
        sound = (2 * np.pi * frequency[lines]) ** 4 * pressure_psd[lines]
        moved = transfer[lines, None, :] * motion * (motion.conj() @ force.swapaxes(1, 2))
        slope[:, lines] = sound[:, None] * np.einsum("pn,fan->pfa", overlap, moved, optimize=True)
    return slope


@dataclass(frozen=True)
class DiagonalMotions(Motions):
    """Mean motions of patches in the paper's form.

    A damper acts through the diagonal of D_p, the mean over a patch sees the whole of it:
    R = diag H_i, S_uu = H_i S_p G_ij H_j*.

    Parameters are those of `diagonal_response`.
    """

    frequency: Array
    basis: ModalBasis
    patches: Patches
    pressure_psd: Array
    modal_force: MatrixInput

    def __post_init__(self) -> None:
        object.__setattr__(self, "area", self.patches.area)
        object.__setattr__(self, "weight", self.patches.overlap)
        object.__setattr__(self, "damping_norm", diagonal_norm(self.basis, self.patches))

    def every(self, step: int) -> DiagonalMotions:
        """Return the same on every so many lines."""
        some = slice(None, None, step)
        force = matrices_at(self.modal_force, self.frequency, some, self.weight.shape[1])
        return replace(
            self,
            frequency=self.frequency[some],
            pressure_psd=self.pressure_psd[some],
            modal_force=force,
        )

    def _motion(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        transfer = 1 / (
            self.basis.dynamic_stiffness(self.frequency[lines])
            + stiffness.T @ self.patches.diagonal
        )
        force = matrices_at(self.modal_force, self.frequency, lines, transfer.shape[1])
        left = self.pressure_psd[lines, None, None] * transfer[:, :, None]
        return transfer, left * force * transfer[:, None, :].conj()

    def _moved(self, lines: slice, stiffness: Complexes) -> Reals:
        return self._motion(lines, stiffness)[1].real

    def _pushed(
        self, receptance: Complexes, weight: Array, patch: int, psd: Complexes
    ) -> Complexes:
        pushed: Complexes = (receptance * self.patches.diagonal[patch])[:, :, None] * psd
        return pushed


def _diagonal_transfer(
    frequency: Array, basis: ModalBasis, overlap: Array, damping: Array, mass: Array
) -> Complexes:
    """(nf, n) H_i, with the diagonals (n_patches, n) of D."""
    added = patch_stiffness(frequency, damping, mass).T @ overlap
    transfer: Complexes = 1 / (basis.dynamic_stiffness(frequency) + added)
    return transfer
