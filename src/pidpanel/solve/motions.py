"""Mean motion of every loaded patch as a function of all dampers, on the lines of the search.

With the dampers on, R = (R_uu⁻¹ + S)⁻¹ and S_uu are the receptance and the PSDs of the motions u
that the patches feel (`dampers`). The mean over patch q of S_a and how it follows the damper on
patch p, δS_a,q = −2 Re(δs_p T_qp), are

    S_a,q = (ω⁴/A_q) tr(Δ_q S_uu),      T_qp = (ω⁴/A_q) tr(Δ_q R Δ_p S_uu).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.dampers import PatchMotion, check_stable, patch_stiffness, pulled
from pidpanel.solve.lines import root_mean_square
from pidpanel.solve.modal import BarePanel, chunks_of_lines

Reals = NDArray[np.floating[Any]]


class Motions(ABC):
    """Mean motions of some patches with dampers on all of them."""

    frequency: Array
    area: Array  # (n_patches,) [m²]
    damping_norm: Array  # (n_patches,), see `modal.BarePanel`
    weight: Array  # (n_patches, r, r) Δ

    @abstractmethod
    def subsampled(self, step: int) -> Self:
        """Return the same on every so many lines."""

    def prepare(self) -> None:  # noqa: B027 - in general nothing
        """Compute what all dampers share."""

    @abstractmethod
    def _motion(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        """Return R and S_uu (nf, r, r) with the dampers on."""

    @abstractmethod
    def _moved(self, lines: slice, stiffness: Complexes) -> Reals:
        """Return Re S_uu (nf, r, r) with the dampers on."""

    def _lines(self) -> Sequence[slice]:
        """Return lines to be taken together."""
        return chunks_of_lines(self.frequency.size, 2 * self.weight.shape[1])

    def _weight(self, lines: slice) -> Array:
        """Return Δ (n_patches, r, r) of the motions u that count on some lines."""
        return self.weight

    def _pushed(
        self, receptance: Complexes, weight: Array, patch: int, psd: Complexes
    ) -> Complexes:
        """Return R Δ_p S_uu."""
        return receptance @ (weight[patch] @ psd)

    def acceleration_psd(self, damping: Array, mass: Array) -> Array:
        """Return the mean acceleration PSD of each patch (n_patches, nf) [(m/s²)²/Hz]."""
        check_stable(damping, self.damping_norm, False)
        psd = np.empty(damping.shape)
        for lines in self._lines():
            moved = self._moved(lines, self._stiffness(lines, damping, mass))
            psd[:, lines] = _means(self._weight(lines), moved) * self._scale(lines)
        return psd

    def acceleration_slope(self, damping: Array, mass: Array) -> Complexes:
        """Return T (n_patches, n_patches, nf): the patch that moves, that of the damper, lines.

        Parameters are those of `acceleration_psd`.
        """
        check_stable(damping, self.damping_norm, False)
        slope = np.empty((len(damping), *damping.shape), dtype=np.complex128)
        for lines in self._lines():
            receptance, moved = self._motion(lines, self._stiffness(lines, damping, mass))
            weight = self._weight(lines)
            for patch in range(len(damping)):
                pushed = self._pushed(receptance, weight, patch, moved)
                trace = _means(weight, pushed.real) + 1j * _means(weight, pushed.imag)
                slope[:, patch, lines] = trace * self._scale(lines)
        return slope

    def acceleration_rms(self, damping: Array, mass: Array) -> Array:
        """Return the rms over time and patch of the acceleration (n_patches,) [m/s²].

        Parameters are those of `acceleration_psd`.
        """
        return root_mean_square(self.frequency, self.acceleration_psd(damping, mass).T)

    def bare_acceleration_rms(self) -> Array:
        """Return that rms (n_patches,) without any damper [m/s²]."""
        none = np.zeros((len(self.area), self.frequency.size))
        return self.acceleration_rms(none, none)

    def patch_coordinates(self, columns: Array) -> Array:
        """Return a (r, k) of motions cᵀq = aᵀu, from c (n, k) within what the patches feel."""
        return columns

    def acceleration_covariance(self, damping: Array, mass: Array) -> Array:
        """Return ∫ ω⁴ Re S_uu df (r, r) [m²/s⁴ times the square of the unit of u over w].

        Parameters are those of `acceleration_psd`.
        """
        total = np.zeros(self.weight.shape[1:])
        weight = np.gradient(self.frequency) if self.frequency.size > 1 else np.ones(1)
        weight[[0, -1]] /= 2
        weight = weight * (2 * np.pi * self.frequency) ** 4
        for lines in self._lines():
            moved = self._moved(lines, self._stiffness(lines, damping, mass))
            counts = self._counts(lines)
            total[np.ix_(counts, counts)] += np.tensordot(weight[lines], moved, axes=1)
        return total

    def _counts(self, lines: slice) -> Index:
        """Return which of the motions u count on some lines."""
        return np.arange(self.weight.shape[1])

    def _stiffness(self, lines: slice, damping: Array, mass: Array) -> Complexes:
        return patch_stiffness(self.frequency[lines], damping[:, lines], mass[:, lines])

    def _scale(self, lines: slice) -> Array:
        """(n_patches, nf) ω⁴/A."""
        return (2 * np.pi * self.frequency[lines]) ** 4 / self.area[:, None]


def _means(weight: Array, matrix: Reals) -> Array:
    """(n_patches, nf) tr(Δ_p X) of X (nf, r, r), Δ being symmetric."""
    flat = weight.reshape(len(weight), weight.shape[1] ** 2)
    return flat @ matrix.reshape(len(matrix), flat.shape[1]).T


@dataclass(frozen=True)
class ReducedMotions(Motions):
    """Motions from the few that the patches feel."""

    bare: BarePanel

    def __post_init__(self) -> None:
        object.__setattr__(self, "frequency", self.bare.frequency)
        object.__setattr__(self, "area", self.bare.patches.area)
        object.__setattr__(self, "damping_norm", self.bare.damping_norm)
        object.__setattr__(self, "weight", self.bare.coordinates.weight)

    def subsampled(self, step: int) -> ReducedMotions:
        """Return the same on every so many lines."""
        bare, some = self.bare, slice(None, None, step)
        return ReducedMotions(
            replace(
                bare,
                frequency=bare.frequency[some],
                receptance=bare.receptance[some],
                patch_psd=bare.patch_psd[some],
                point_psd=bare.point_psd[some],
            )
        )

    @cached_property
    def single_patch(self) -> PatchMotion:
        """Decomposition for one patch alone."""
        return PatchMotion.from_panel(self.bare)

    def prepare(self) -> None:
        """Decompose what a single patch feels."""
        if len(self.area) == 1:
            _ = self.single_patch

    def acceleration_psd(self, damping: Array, mass: Array) -> Array:
        """Return the mean acceleration PSD of each patch, see `Motions`."""
        if len(self.area) == 1:
            return self.single_patch.acceleration_psd(damping[0], mass[0])[None]
        return super().acceleration_psd(damping, mass)

    def acceleration_slope(self, damping: Array, mass: Array) -> Complexes:
        """Return T, see `Motions`."""
        if len(self.area) == 1:
            return self.single_patch.acceleration_slope(damping[0], mass[0])[None, None]
        return super().acceleration_slope(damping, mass)

    def bare_acceleration_rms(self) -> Array:
        """Return the rms acceleration of each patch (n_patches,) without any damper [m/s²]."""
        lines = slice(None)
        moved = self.bare.patch_psd[:, : self.weight.shape[1]]
        psd = _means(self.weight, moved.real) * self._scale(lines)
        return root_mean_square(self.frequency, psd.T)

    def patch_coordinates(self, columns: Array) -> Array:
        """Return a (r, k) of motions cᵀq = aᵀu, see `Motions`."""
        return self.bare.coordinates.inverse @ columns

    def _motion(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        follows = self._follows(lines, stiffness)
        width = self.weight.shape[1]
        psd = follows @ self.bare.patch_psd[lines, :width] @ follows.conj().swapaxes(1, 2)
        return follows @ self.bare.receptance[lines, :width], psd

    def _moved(self, lines: slice, stiffness: Complexes) -> Reals:
        follows = self._follows(lines, stiffness)
        pushed = follows @ self.bare.patch_psd[lines, : self.weight.shape[1]]
        return _real_product(pushed, follows.conj().swapaxes(1, 2))

    def _follows(self, lines: slice, stiffness: Complexes) -> Complexes:
        """(I + R_uu S)⁻¹."""
        width = self.weight.shape[1]
        loop = pulled(self.bare, stiffness, self.bare.receptance[lines, :width]).swapaxes(1, 2)
        loop[:, range(width), range(width)] += 1
        return np.linalg.inv(loop)


def _real_product(left: Complexes, right: Complexes) -> Array:
    """Re(left right)."""
    return left.real @ right.real - left.imag @ right.imag
