"""The balance of power: what the field puts in is what the panel, dampers and air take out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.solve.dampers import attach_dampers, checked_dampers
from pidpanel.solve.excitation import MatrixInput, air_at, matrices_at
from pidpanel.solve.modal import OVERLAP_CUTOFF, bare_panels, chunks_of_lines, dense_stiffness
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.receptances import weighted_sum


@dataclass(frozen=True)
class PowerBalance:
    """Mean power per hertz that the field puts in and where it goes [W/Hz]."""

    frequency: Array  # (nf,) [Hz]
    field: Array  # (nf,) put in by the excitation, Re tr(iωH S_p G)
    structure: Array  # (nf,) lost in the panel's own damping, ω² tr(C S_q)
    patches: Array  # (nf, n_patches) lost in the dampers, ω² C_e tr(D S_q)
    radiation: Array  # (nf,) radiated, ω² tr(R S_q)

    @property
    def error(self) -> Array:
        """(nf,) |put in − lost| / put in [1]."""
        lost = self.structure + self.patches.sum(axis=1) + self.radiation
        return np.abs(self.field - lost) / self.field


def power_balance(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    spectrum: ArrayLike,
    modal_force: MatrixInput,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    air_stiffness: MatrixInput | None = None,
    overlap_cutoff: float = OVERLAP_CUTOFF,
) -> PowerBalance:
    """Return the power that the field puts in and the power that is lost, line by line.

    The two are equal for the exact solution. The loss comes from `bare_panels` and
    `attach_dampers` with every modal coordinate observed; the input comes from a dense solve of
    the whole Z, so the balance checks how the dampers are attached. A dense solve per line is slow:
    use a few lines. The remainder of the balance is the
    eigenvalues of D that were dropped: about 1e-7 with the default cutoff, 1e-11 with 1e-14.

    Parameters and errors are those of `bare_panels` and `attach_dampers`.

    Returns
    -------
    PowerBalance
    """
    frequency, spectrum = np.asarray(frequency, np.float64), np.asarray(spectrum, np.float64)
    n = basis.natural_frequency.size
    s = checked_dampers(patches.count, frequency, equivalent_damping, apparent_mass)
    damping, mass = np.asarray(equivalent_damping), np.asarray(apparent_mass)

    field, structure, radiated = np.zeros((3, frequency.size))
    lost_in_patches = np.empty((frequency.size, patches.count))
    for lines in chunks_of_lines(frequency.size, n):
        omega = 2 * np.pi * frequency[lines]
        force = matrices_at(modal_force, frequency, lines, n)
        air = air_at(air_stiffness, frequency, lines, n)
        (bare,) = bare_panels(
            frequency[lines], basis, [patches], None, spectrum[lines], force, air, overlap_cutoff
        )
        response = attach_dampers(bare, damping[:, lines], mass[:, lines])
        modal_psd = response.cross_psd[:, 0]  # S_q
        on_diagonal = np.diagonal(modal_psd, axis1=1, axis2=2).real
        structure[lines] = omega**2 * (on_diagonal @ basis.damping)
        motion = np.einsum("pij,fji->fp", patches.overlap, modal_psd).real  # tr(D S_q)
        lost_in_patches[lines] = omega[:, None] * s[:, lines].imag.T * motion
        stiffness = dense_stiffness(frequency[lines], basis, air)
        stiffness += weighted_sum(s[:, lines], patches.overlap)
        transfer_times_force = np.linalg.solve(stiffness, np.broadcast_to(force, stiffness.shape))
        trace = np.trace(transfer_times_force, axis1=1, axis2=2)
        field[lines] = spectrum[lines] * (1j * omega * trace).real
        if air is not None:  # ω² tr(R S_q), R = Im(Z_air)/ω
            radiated[lines] = omega * np.sum(air.imag * modal_psd.swapaxes(1, 2), (1, 2)).real
    return PowerBalance(frequency, field, structure, lost_in_patches, radiated)
