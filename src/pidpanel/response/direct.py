"""Dampers that the panel feels with nearly all its shapes: one dense solve a line.

Twenty patches together have as many columns (`modal.PatchCoordinates`) as there are shapes. Then
nothing is gained by the bare panel's solution, and

    H = (Z₀ + Σ_p s_p D_p)⁻¹,      S_w = cᵀ H (S_p G) Hᴴ c

is taken as it stands: x = H c for the motions c at the points, since H is symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.response.dampers import (
    check_stable,
    checked_dampers,
    weighted_sum,
)
from pidpanel.response.modal import (
    Matrices,
    MatrixInput,
    chunks_of_lines,
    dense_stiffness,
    matrices_at,
    product,
)
from pidpanel.response.model import ModalBasis, Patches, Response
from pidpanel.response.motions import Motions


@dataclass(frozen=True)
class DirectPanel(Motions):
    """The panel with all its shapes, on some lines.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    basis
        Its shapes.
    patches
        That carry dampers.
    pressure_psd
        (nf,) S_p [Pa²/Hz].
    modal_force, air_stiffness
        As of `modal.bare_panels`.
    """

    frequency: Array
    basis: ModalBasis
    patches: Patches
    pressure_psd: Array
    modal_force: MatrixInput
    air_stiffness: MatrixInput | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "area", self.patches.area)
        object.__setattr__(self, "weight", self.patches.overlap)

    @cached_property
    def damping_norm(self) -> Array:  # type: ignore[override]
        """(n_patches,), see `modal.BarePanel`."""
        return self.patches.damping_norm(self.basis.damping)

    def on(self, lines: slice) -> DirectPanel:
        """Return the same on some of the lines, with the matrices of those."""
        n = self.basis.natural_frequency.size
        air = None
        if self.air_stiffness is not None:
            air = matrices_at(self.air_stiffness, self.frequency, lines, n)
        return replace(
            self,
            frequency=self.frequency[lines],
            pressure_psd=self.pressure_psd[lines],
            modal_force=matrices_at(self.modal_force, self.frequency, lines, n),
            air_stiffness=air,
        )

    def every(self, step: int) -> DirectPanel:
        """Return the same on every so many lines."""
        return self.on(slice(None, None, step))

    def response(
        self, motion_at_points: Array, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
    ) -> Response:
        """Return the response with dampers.

        Parameters
        ----------
        motion_at_points
            (n_points, m, n) as of `modal.bare_panels`.
        equivalent_damping, apparent_mass
            (n_patches, nf) as of `dampers.attach_dampers`.
        """
        damping, mass = checked_dampers(
            self.patches.count, self.frequency, equivalent_damping, apparent_mass
        )
        check_stable(damping, self.damping_norm, False)
        n_points, m, n = motion_at_points.shape
        cross_psd = np.empty((self.frequency.size, n_points, m, m), dtype=np.complex128)
        columns = motion_at_points.reshape(-1, n).T
        for lines in chunks_of_lines(self.frequency.size):
            stiffness, force = self._dynamic(lines, self._stiffness(lines, damping, mass))
            moved = np.linalg.solve(stiffness, columns[None].astype(complex))
            moved = moved.reshape(len(moved), n, n_points, m)
            sound = self.pressure_psd[lines, None, None]
            for point in range(n_points):
                own = moved[:, :, point]
                cross_psd[lines, point] = sound * product(own, force, own)
        return Response(self.frequency, cross_psd)

    def slope(
        self, motion_at_points: Array, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
    ) -> Complexes:
        """Return t (n_patches, nf, n_points) of `dampers.acceleration_slope`.

        Parameters are those of `response`.
        """
        damping, mass = checked_dampers(
            self.patches.count, self.frequency, equivalent_damping, apparent_mass
        )
        deflection = motion_at_points[:, 0].T.astype(complex)
        slope = np.empty((len(damping), self.frequency.size, deflection.shape[1]), complex)
        for lines in chunks_of_lines(self.frequency.size):
            stiffness, force = self._dynamic(lines, self._stiffness(lines, damping, mass))
            receptance = np.linalg.solve(stiffness, deflection[None])
            psd = np.linalg.solve(stiffness, force @ receptance.conj())
            scale = (2 * np.pi * self.frequency[lines]) ** 4 * self.pressure_psd[lines]
            for patch, weight in enumerate(self.weight):
                slope[patch, lines] = scale[:, None] * np.sum(receptance * (weight @ psd), axis=1)
        return slope

    def _motion(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        whole, force = self._dynamic(lines, stiffness)
        receptance = np.linalg.inv(whole)
        sound = self.pressure_psd[lines, None, None]
        return receptance, sound * product(receptance, force, receptance)

    def _dynamic(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Matrices]:
        """Z (nf, n, n) with the dampers, and G."""
        own = self.on(lines)
        air = None if own.air_stiffness is None else np.asarray(own.air_stiffness)
        whole = dense_stiffness(own.frequency, self.basis, air)
        whole += weighted_sum(stiffness, self.weight)
        return whole, np.asarray(own.modal_force)
