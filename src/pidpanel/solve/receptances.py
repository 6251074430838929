"""Receptances between the motions that dampers feel and those that are observed, with dampers on.

Dampers pull with −S u, S symmetric, at the motions u = Eᵀq that they feel; w = Wᵀq are observed.
All dampers act together (Woodbury's identity), with R of the panel without them:

    u = (I + R_uu S)⁻¹ u₀,      R'_uw = (I + R_uu S)⁻¹ R_uw,      w = w₀ − B u₀,      B = R'_wu S,
    S'_ww = S_ww − (Y Bᴴ + B Yᴴ),      Y = S_wu − B S_uu/2.

Dampers are those of patches, cells or places of a search, and the air or stretched modes alike.
Where a matrix is diagonal, its diagonal is stored: (nf, r) in place of (nf, r, r).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg as la
from numpy.typing import NDArray

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.excitation import Matrices

NONE: Complexes = np.zeros((1, 1, 1), complex)


class Reaction(NamedTuple):
    """What dampers do to the observed motions."""

    solve: Callable[[Complexes], Complexes]  # x (nf, r, k) → (I + R_uu S)⁻¹ x
    receptance: Complexes  # (nf, r, nw) R'_uw
    # (nf, nw, r)
    B: Complexes
    Y: Complexes

    @property
    def taken(self) -> Array:
        """(nf, nw) diagonal of `drop`."""
        return np.asarray(2 * np.sum(self.Y * self.B.conj(), axis=2).real)

    @property
    def drop(self) -> Complexes:
        """(nf, nw, nw) Y Bᴴ + B Yᴴ."""
        half = self.Y @ self.B.conj().swapaxes(1, 2)
        return half + half.conj().swapaxes(1, 2)


@dataclass(frozen=True)
class Receptances:
    """A panel on some lines."""

    felt: Complexes  # (nf, r, r) R_uu [m/N]
    across: Complexes = field(default_factory=lambda: NONE)  # (nf, nw, r) R_wu
    # (nf, r, r) S_uu and (nf, nw, r) S_wu
    felt_psd: Complexes = field(default_factory=lambda: NONE)
    across_psd: Complexes = field(default_factory=lambda: NONE)
    # (nf, r, r) the real S_p G where u are the shapes: S'_uu = R'_uu S_p G R'_uuᴴ costs less
    force: Matrices | None = None

    def on_lines(self, lines: slice) -> Receptances:
        """Return the same on some lines."""

        def part(values: Complexes) -> Complexes:
            return values if values is NONE else values[lines]

        across, felt_psd, across_psd = map(part, (self.across, self.felt_psd, self.across_psd))
        force = None if self.force is None else self.force[lines]
        return Receptances(self.felt[lines], across, felt_psd, across_psd, force)

    def solution(self, pull: Matrices, *, reuse: bool = False) -> Callable[[Complexes], Complexes]:
        """Return what solves with I + R_uu S, factorised once where it is called again."""
        loop = times(self.felt, pull)
        if loop.ndim == 2:
            return lambda force: force / (1 + loop)[:, :, None]
        width = loop.shape[1]
        loop[:, range(width), range(width)] += 1
        if not reuse:
            return lambda force: np.asarray(np.linalg.solve(loop, force))
        factors = la.lu_factor(loop, check_finite=False)
        return lambda force: np.asarray(la.lu_solve(factors, force, check_finite=False))

    def motions(self, pull: Matrices, felt: Complexes, observed: Complexes) -> Complexes:
        """Return w (nf, nw) from u₀ (nf, r) and w₀ (nf, nw)."""
        u = self.solution(pull)(felt[:, :, None])
        return observed - (self.across @ times(pull, u))[:, :, 0]

    def reaction(self, pull: Matrices, *, reuse: bool = False) -> Reaction:
        """Return what dampers do to the observed motions."""
        solve = self.solution(pull, reuse=reuse)
        receptance = solve(self.across.swapaxes(1, 2))
        B = times(pull, receptance).swapaxes(1, 2)
        return Reaction(solve, receptance, B, self.across_psd - B @ self.felt_psd / 2)

    def felt_with(self, pull: Matrices) -> tuple[Complexes, Complexes]:
        """Return R'_uu and S'_uu (nf, r, r) with dampers on."""
        follows = self._follows(pull)
        moved = follows @ self.felt_psd @ follows.conj().swapaxes(1, 2)
        return times(follows, self.felt), moved

    def felt_psd_with(self, pull: Matrices) -> Array:
        """Return Re S'_uu."""
        follows = self._follows(pull)
        if self.force is not None:
            receptance = times(follows, self.felt)  # symmetric
            real, imaginary = receptance.real.copy(), receptance.imag.copy()
            return np.asarray(real @ (self.force @ real) + imaginary @ (self.force @ imaginary))
        left, right = follows @ self.felt_psd, follows.conj().swapaxes(1, 2)
        return np.asarray(left.real @ right.real - left.imag @ right.imag)

    def _follows(self, pull: Matrices) -> Complexes:
        """Return (I + R_uu S)⁻¹."""
        width = self.felt_psd.shape[1]
        return self.solution(pull)(np.eye(width, dtype=complex)[None])

    def damped(self, pull: Matrices) -> tuple[Receptances, Complexes]:
        """Return the panel with dampers on, in the same motions, and Y Bᴴ + B Yᴴ."""
        reaction = self.reaction(pull, reuse=True)
        felt, felt_psd = self.felt_with(pull)
        covariance = 2 * reaction.Y - self.across_psd  # S_wu − B S_uu
        psd = reaction.solve(covariance.conj().swapaxes(1, 2)).conj().swapaxes(1, 2)
        damped = Receptances(felt, reaction.receptance.swapaxes(1, 2), felt_psd, psd)
        return damped, reaction.drop


def times(left: Matrices, right: Matrices) -> Complexes:
    """Return the product of matrices, some of which are given by their diagonals."""
    if left.ndim == 2:
        return np.asarray(left[:, :, None] * right if right.ndim == 3 else left * right)
    return np.asarray(left * right[:, None] if right.ndim == 2 else left @ right)


def patch_stiffness(frequency: Array, damping: Array, mass: Array) -> Complexes:
    """Return s = iω C_e − ω² m_a (n_patches, nf) [N/m³] from C_e and m_a (n_patches, nf)."""
    omega = 2 * np.pi * frequency
    return 1j * omega * damping - omega**2 * mass


def weighted_sum(stiffness: Complexes, weight: Array) -> Complexes:
    """Return S = Σ_p s_p Δ_p (nf, r, r) from s (n_patches, nf) and Δ (n_patches, r, r)."""
    flat = weight.reshape(len(weight), math.prod(weight.shape[1:]))
    total = np.empty((stiffness.shape[1], flat.shape[1]), dtype=np.complex128)
    total.real = np.ascontiguousarray(stiffness.real.T) @ flat
    total.imag = np.ascontiguousarray(stiffness.imag.T) @ flat
    return total.reshape(len(total), *weight.shape[1:])


def traces(weight: Array, matrix: NDArray[Any]) -> NDArray[Any]:
    """Return tr(Δ_p X) (n_patches, nf) of X (nf, r, r), Δ being symmetric."""
    if weight.ndim == 2:
        return weight @ np.einsum("fii->if", matrix)
    size = math.prod(matrix.shape[1:])
    return weight.reshape(len(weight), size) @ matrix.reshape(len(matrix), size).T
