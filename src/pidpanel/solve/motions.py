"""Mean motion of every loaded patch as a function of all dampers, on the lines of the search.

With the dampers on, R = (R_uu⁻¹ + S)⁻¹ and S_uu are the receptance and the PSDs of the motions u
that the patches feel (`dampers`). The mean over patch q of S_a and how it follows the damper on
patch p, δS_a,q = −2 Re(δs_p T_qp), are

    S_a,q = (ω⁴/A_q) tr(Δ_q S_uu),      T_qp = (ω⁴/A_q) tr(Δ_q R Δ_p S_uu).

With R_uu = V Λ V⁻¹ a damper on the only patch acts on each column of V alone, u = V d V⁻¹ u₀ with
d = 1/(1 + sλ), so that any number of dampers costs one decomposition a line:

    S_a = (ω⁴/A) Σ_jk d_j Q_jk d_k*,      Q_jk = (V⁻¹ S_uu V⁻ᴴ)_jk (VᴴV)_kj.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.progress import map_in_forks
from pidpanel.solve.dampers import check_stable, patch_stiffness, pulled
from pidpanel.solve.lines import root_mean_square, trapezoid_weights
from pidpanel.solve.modal import BarePanel, chunks_of_lines

Reals = NDArray[np.floating[Any]]


class Motions(ABC):
    """Mean motions of some patches with dampers on all of them."""

    frequency: Array
    area: Array  # (n_patches,) [m²]
    weight: Array  # (n_patches, r, r) Δ

    @abstractmethod
    def subsampled(self, step: int) -> Self:
        """Return the same on every n-th line."""

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
        """Return Δ (n_patches, r, r) of the motions u used on some lines."""
        return self.weight

    def acceleration_psd(self, damping: Array, mass: Array) -> Array:
        """Return the mean acceleration PSD of each patch (n_patches, nf) [(m/s²)²/Hz]."""
        check_stable(damping)
        psd = np.empty(damping.shape)
        for lines in self._lines():
            moved = self._moved(lines, self._stiffness(lines, damping, mass))
            psd[:, lines] = _means(self._weight(lines), moved) * self._scale(lines)
        return psd

    def acceleration_slope(self, damping: Array, mass: Array) -> Complexes:
        """Return T (n_patches, n_patches, nf): the patch that moves, that of the damper, lines.

        Parameters are those of `acceleration_psd`.
        """
        check_stable(damping)
        slope = np.empty((len(damping), *damping.shape), dtype=np.complex128)
        for lines in self._lines():
            receptance, moved = self._motion(lines, self._stiffness(lines, damping, mass))
            weight = self._weight(lines)
            for patch in range(len(damping)):
                pushed = receptance @ (weight[patch] @ moved)
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
        empty = np.zeros((len(self.area), self.frequency.size))
        return self.acceleration_rms(empty, empty)

    def patch_coordinates(self, columns: Array) -> Array:
        """Return a (r, k) of motions cᵀq = aᵀu, from c (n, k) within what the patches feel."""
        return columns

    def acceleration_covariance(self, damping: Array, mass: Array) -> Array:
        """Return ∫ ω⁴ Re S_uu df (r, r) [m²/s⁴ times the square of the unit of u over w].

        Parameters are those of `acceleration_psd`.
        """
        total = np.zeros(self.weight.shape[1:])
        weight = trapezoid_weights(self.frequency) * (2 * np.pi * self.frequency) ** 4
        for lines in self._lines():
            moved = self._moved(lines, self._stiffness(lines, damping, mass))
            counts = self._counts(lines)
            total[np.ix_(counts, counts)] += np.tensordot(weight[lines], moved, axes=1)
        return total

    def _counts(self, lines: slice) -> Index:
        """Return which of the motions u are used on some lines."""
        return np.arange(self.weight.shape[1])

    def _stiffness(self, lines: slice, damping: Array, mass: Array) -> Complexes:
        return patch_stiffness(self.frequency[lines], damping[:, lines], mass[:, lines])

    def _scale(self, lines: slice) -> Array:
        """Return (n_patches, nf) ω⁴/A."""
        return (2 * np.pi * self.frequency[lines]) ** 4 / self.area[:, None]


def _means(weight: Array, matrix: Reals) -> Array:
    """Return (n_patches, nf) tr(Δ_p X) of X (nf, r, r), Δ being symmetric."""
    flat = weight.reshape(len(weight), weight.shape[1] ** 2)
    return flat @ matrix.reshape(len(matrix), flat.shape[1]).T


class ReducedMotions(Motions):
    """Motions from the few that the patches feel."""

    def __init__(self, bare: BarePanel) -> None:
        self.bare = bare
        self.frequency = bare.frequency
        self.area = bare.patches.area
        self.weight = bare.coordinates.weight

    def subsampled(self, step: int) -> ReducedMotions:
        """Return the same on every n-th line."""
        bare, lines = self.bare, slice(None, None, step)
        coarse = replace(
            bare,
            frequency=bare.frequency[lines],
            receptance=bare.receptance[lines],
            patch_psd=bare.patch_psd[lines],
            point_psd=bare.point_psd[lines],
        )
        return ReducedMotions(coarse)

    @cached_property
    def _decomposed(self) -> tuple[Complexes, Complexes]:
        """λ (nf, r) of R_uu [m³/N] and ω⁴ Q/A (nf, r, r) [(m/s²)²/Hz] of a patch alone."""
        bare, width = self.bare, self.weight.shape[1]

        def at_lines(lines: slice) -> tuple[Complexes, Complexes]:
            eigenvalue, V = np.linalg.eig(bare.receptance[lines, :width])
            inverse = np.linalg.inv(V)
            psd = inverse @ bare.patch_psd[lines, :width] @ inverse.conj().swapaxes(1, 2)
            Q = psd * (V.conj().swapaxes(1, 2) @ V).swapaxes(1, 2)
            omega = 2 * np.pi * bare.frequency[lines, None, None]
            return eigenvalue, omega**4 * Q / self.area[0]

        chunks = chunks_of_lines(self.frequency.size, width)
        eigenvalues, weights = zip(*map_in_forks(at_lines, chunks), strict=True)
        return np.concatenate(eigenvalues), np.concatenate(weights)

    def prepare(self) -> None:
        """Decompose what a single patch feels."""
        if len(self.area) == 1:
            _ = self._decomposed

    def acceleration_psd(self, damping: Array, mass: Array) -> Array:
        """Return the mean acceleration PSD of each patch, see `Motions`."""
        if len(self.area) > 1:
            return super().acceleration_psd(damping, mass)
        _, d, pushed = self._of_one_patch(damping, mass)
        return np.sum(d * pushed, axis=1).real[None]

    def acceleration_slope(self, damping: Array, mass: Array) -> Complexes:
        """Return T, see `Motions`."""
        if len(self.area) > 1:
            return super().acceleration_slope(damping, mass)
        eigenvalue, d, pushed = self._of_one_patch(damping, mass)
        return np.sum(eigenvalue * d**2 * pushed, axis=1)[None, None]

    def _of_one_patch(self, damping: Array, mass: Array) -> tuple[Complexes, Complexes, Complexes]:
        """Return λ_j, d_j and ω⁴/A Σ_k Q_jk d_k*, (nf, r) each."""
        check_stable(damping)
        eigenvalue, weight = self._decomposed
        (s,) = self._stiffness(slice(None), damping, mass)
        d = 1 / (1 + s[:, None] * eigenvalue)
        return eigenvalue, d, (weight @ d.conj()[:, :, None])[:, :, 0]

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
        """Return (I + R_uu S)⁻¹."""
        width = self.weight.shape[1]
        loop = pulled(self.bare, stiffness, self.bare.receptance[lines, :width]).swapaxes(1, 2)
        loop[:, range(width), range(width)] += 1
        return np.linalg.inv(loop)


def _real_product(left: Complexes, right: Complexes) -> Array:
    """Return Re(left right)."""
    return left.real @ right.real - left.imag @ right.imag
