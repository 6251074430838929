"""Complex response of a panel to a harmonic acceleration of its supports."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.dampers import weighted_sum
from pidpanel.solve.model import ModalBasis, Patches

CUTOFF = 1e-8  # eigenvalues of D below this share of the largest are dropped


@dataclass(frozen=True)
class Transfer:
    """Motions per acceleration of the supports, on some lines."""

    frequency: Array  # (nf,) [Hz]
    weight: Array  # (n_patches, r, r) Δ of the motions u that the patches feel
    area: Array  # (n_patches,) [m²]
    # (nf, nw, r) of the observed motions w and, from row nw − r, of u [m/N]
    receptance: Complexes
    # (nf, nw) the same motions without dampers, per acceleration of the supports [s²]
    free: Complexes

    @classmethod
    def of_panel(
        cls, frequency: Array, basis: ModalBasis, patches: Patches, force: Array, observed: Array
    ) -> Transfer:
        """Return the transfer of a basis with the translation.

        Parameters
        ----------
        patches
            Patches with dampers.
        force
            (n + 1,) force of `BaseExcitation`.
        observed
            (nw, n + 1) rows of the observed motions.
        """
        coordinates = patches.coordinates(CUTOFF)
        rows = np.concatenate([observed, coordinates.columns.T])
        moved = 1 / basis.dynamic_stiffness(frequency)
        return cls(
            frequency,
            coordinates.weight,
            patches.area,
            (rows * moved[:, None]) @ coordinates.columns,
            (moved * force) @ rows.T,
        )

    @property
    def width(self) -> int:
        """Number r of motions that the patches feel."""
        return self.receptance.shape[2]

    def motions(self, lines: slice, stiffness: Complexes) -> Complexes:
        """Return w and u (nf, nw) per acceleration [s²] with dampers s (n_patches, nf) [N/m³]."""
        free = self.free[lines]
        if not self.width:
            return free
        _, force = self._patch_motions(lines, stiffness)
        return free - (self.receptance[lines] @ force)[..., 0]

    def _patch_motions(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        """Return u and the forces of the dampers on them (nf, r, 1)."""
        pull = weighted_sum(stiffness, self.weight)
        loop = self.receptance[lines, -self.width :] @ pull
        loop[:, range(self.width), range(self.width)] += 1
        u = np.linalg.solve(loop, self.free[lines, -self.width :, None])
        return u, pull @ u

    def patch_acceleration(self, lines: slice, stiffness: Complexes) -> Array:
        """Return the rms over each patch of |acceleration| (nf, n_patches) over that of the base.

        Parameters are those of `motions`.
        """
        u = self._patch_motions(lines, stiffness)[0][..., 0]
        square = np.einsum("fi,pij,fj->fp", u.conj(), self.weight, u).real / self.area
        return (2 * np.pi * self.frequency[lines, None]) ** 2 * np.sqrt(square)
