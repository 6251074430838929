"""The balance of power: what the field puts in is what the panel, dampers and air take out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.response.modal import (
    OVERLAP_CUTOFF,
    MatrixInput,
    attach_dampers,
    attached_motion,
    bare_panel,
    checked_frequency,
    chunks_of_lines,
    dense_stiffness,
    matrices_at,
)
from pidpanel.response.model import Floats, ModalBasis, Patches, checked_array


@dataclass(frozen=True)
class PowerBalance:
    """Mean power per hertz that the field puts in and where it goes [W/Hz].

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    field
        (nf,) put in by the sound field, Re tr(iωH S_p G).
    structure
        (nf,) lost in the panel's own damping, ω² tr(C S_q).
    patches
        (nf, n_patches) lost in the dampers, ω² C_e tr(D S_q).
    radiation
        (nf,) radiated, ω² tr(R S_q).
    """

    frequency: Floats
    field: Floats
    structure: Floats
    patches: Floats
    radiation: Floats

    @property
    def error(self) -> Floats:
        """(nf,) |put in − lost| / put in [1]."""
        lost = self.structure + self.patches.sum(axis=1) + self.radiation
        ratio: Floats = np.abs(self.field - lost) / self.field
        return ratio


def power_balance(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    pressure_psd: ArrayLike,
    modal_force: MatrixInput,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    radiation_resistance: MatrixInput | None = None,
    allow_negative_damping: bool = False,
    overlap_cutoff: float = OVERLAP_CUTOFF,
) -> PowerBalance:
    """Return the power that the field puts in and the power that is lost, line by line.

    The two are equal for the exact solution. What is lost comes from `bare_panel` and
    `attach_dampers` with every modal coordinate as a point; what is put in comes from a dense
    solve of the whole Z, so that the balance judges the solver that made the results. A dense
    solve per line is slow: give it a few hundred lines. What is left of the balance is the
    eigenvalues of D that were dropped: about 1e-7 with the default cutoff, 1e-11 with 1e-14.

    Parameters and errors are those of `bare_panel` and `attach_dampers`.

    Returns
    -------
    PowerBalance
    """
    frequency = checked_frequency(frequency)
    pressure_psd = checked_array("pressure_psd", pressure_psd, frequency.shape)
    n = basis.natural_frequency.size
    shape = (patches.area.size, frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    mass = checked_array("apparent_mass", apparent_mass, shape)

    field, structure, radiated = np.zeros((3, frequency.size))
    lost_in_patches = np.empty(shape[::-1])
    for lines in chunks_of_lines(frequency.size):
        omega = 2 * np.pi * frequency[lines]
        force = matrices_at(modal_force, frequency, lines, n)
        resistance = None
        if radiation_resistance is not None:
            resistance = matrices_at(radiation_resistance, frequency, lines, n)
        bare = bare_panel(
            frequency[lines],
            basis,
            patches,
            np.eye(n),
            pressure_psd[lines],
            force,
            resistance,
            overlap_cutoff,
        )
        response = attach_dampers(bare, damping[:, lines], mass[:, lines], allow_negative_damping)
        structure[lines] = (response.acceleration_psd @ basis.damping) / omega**2
        lost_in_patches[lines] = (
            damping[:, lines].T * patches.area * response.patch_acceleration_psd
        ) / omega[:, None] ** 2
        stiffness = dense_stiffness(frequency[lines], basis, resistance)
        patch_stiffness = 1j * omega * damping[:, lines] - omega**2 * mass[:, lines]
        stiffness += np.tensordot(patch_stiffness.T, patches.overlap, axes=1)
        transfer_times_force = np.linalg.solve(stiffness, np.broadcast_to(force, stiffness.shape))
        trace = np.trace(transfer_times_force, axis1=1, axis2=2)
        field[lines] = pressure_psd[lines] * (1j * omega * trace).real
        if resistance is not None:
            motion = attached_motion(bare, damping[:, lines], mass[:, lines], slice(None))
            motion = motion[:, bare.point_columns]
            modal_psd = motion @ bare.displacement_psd @ motion.conj().swapaxes(1, 2)
            radiated[lines] = omega**2 * np.sum(resistance * modal_psd.swapaxes(1, 2), (1, 2)).real
    return PowerBalance(frequency, field, structure, lost_in_patches, radiated)
