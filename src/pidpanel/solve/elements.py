"""All elements compared with the shapes of the basis: the part of a response that it lacks.

The motion of the whole panel when a point is pulled, x = Z⁻¹ c, is solved on all elements,

    Z = K − ω²M + iωC + Σ_p s_p D_p,      s = iω C_e − ω² m_a,
    C = (2ζ/ω_c) K + Σ_i 2ζ m_i ω_i (1 − ω_i/ω_c) (M φ_i)(M φ_i)ᵀ/m_i²,

with C the damping of the basis: ζ in every mode φ_i, and above the last mode, at ω_c, proportional
to the stiffness. Z is symmetric, so x is the response of the point to any force. The error of the
basis needs nothing else, so there is no excitation here and no PSD.

The start is the answer x₀ of the basis; the rest is solved by minimal residuals (GCR: Eisenstat,
Elman and Schultz 1983), preconditioned by the basis and, in what it leaves out, by K⁻¹. There
Z differs from K by (ω/ω_i)² of shapes above the range alone, so that a few steps do, and K is
factorised once for all frequencies and dampers.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array, Complexes, Flags, Index
from pidpanel.panel.eigen import factors
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import on_patch
from pidpanel.solve.modal import dense_stiffness
from pidpanel.solve.model import ModalBasis, ResponseError
from pidpanel.solve.receptances import weighted_sum

# Residual over that of the basis, each coordinate weighted by its own stiffness.
#
# The error of a PSD is then known to a tenth of itself: on a wing of 72 510 coordinates, 30 layouts
# and 240 columns, to 0.2 % where it is 0.3 %, the largest, and to 5 % at the worst.
ENOUGH = 1e-2

MOST_STEPS = 40  # steps after which Z itself is factorised, line by line

# Residual of a line that is factorised; 3e-10 on a plate of 23 086 coordinates with and without
# pivoting, which takes six times as long.
EXACT = 1e-6

COLUMNS_AT_ONCE = 24  # columns solved together, so that memory stays at some dozens of columns


@dataclass(frozen=True)
class ElementMotion:
    """Response of a panel with dampers to a force at each point."""

    of_basis: Complexes  # (n, n_points) the answer of the basis for each point, in its shapes [m/N]
    whole: Complexes  # (n_free, n_points) x of all elements
    remainder: Complexes  # (n_free, n_points) x − x₀, with x₀ that of the basis


@dataclass(frozen=True)
class Elements:
    """The panel in all its elements, and the basis that represents it."""

    plate: StoredPlate
    overlap: Sequence[sp.csr_array]  # D of each patch, (n_free, n_free)
    # (n_free, n) of the basis, the modes first; single precision will do, since they make the start
    # and the preconditioner, and of the matrices the damping of the modes alone
    shapes: Array
    basis: ModalBasis  # frequencies, masses and damping of these shapes
    is_residual: Flags  # (n,) false for modes
    damping_ratio: float  # ζ at f_c
    cutoff: float  # ω_c/2π [Hz]: the damping ratio of a residual vector is ζ f/f_c
    points: sp.csr_array  # (n_points, n_free) w at the points

    def motions(self, frequency: float, stiffness: Complexes) -> list[ElementMotion]:
        """Return what happens at a frequency [Hz] when each point is pulled by 1 N.

        For each of several sets of dampers with s (n_sets, n_patches) [N/m³] on the patches.
        """
        at_once = max(1, COLUMNS_AT_ONCE // max(self.points.shape[0], 1))
        motions: list[ElementMotion] = []
        for start in range(0, len(stiffness), at_once):
            motions += self._together(frequency, stiffness[start : start + at_once])
        return motions

    def prepare(self) -> None:
        """Compute what all frequencies share."""
        _ = self._factors, self._pushed, self._overlap_of_basis

    # -------------------------------------------------------------------- matrices

    @cached_property
    def _shift(self) -> float:
        """Shift of that mass over M [rad²/s²]."""
        lowest = self.basis.angular_frequency[~self.is_residual].min(initial=np.inf)
        elastic = self.basis.angular_frequency.max()
        return 0.0 if lowest > 1e-6 * elastic else float(1e-3 * elastic) ** 2

    @cached_property
    def _factors(self) -> spla.SuperLU:
        """K, where the panel can move as a rigid body with a mass that holds it."""
        return factors(self.plate.stiffness + self._shift * self.plate.mass)

    @cached_property
    def _pushed(self) -> Array:
        """(n_free, n) M V/m, so that (M V/m)ᵀ x is what the shapes have of a motion."""
        pushed = np.empty_like(self.shapes)
        for first in range(0, pushed.shape[1], COLUMNS_AT_ONCE):
            part = slice(first, first + COLUMNS_AT_ONCE)
            pushed[:, part] = self.plate.mass @ self.shapes[:, part] / self.basis.modal_mass[part]
        return pushed

    @cached_property
    def _modal_damping(self) -> Array:
        """(n_modes,) of the modes beyond what is proportional to the stiffness [kg/s]."""
        modes = ~self.is_residual
        natural, cutoff = self.basis.angular_frequency[modes], 2 * np.pi * self.cutoff
        beyond = self.basis.damping_ratio[modes] - self.damping_ratio * natural / cutoff
        return 2 * beyond * self.basis.modal_mass[modes] * natural

    @cached_property
    def _on_patches(self) -> list[tuple[Index, sp.csr_array, Array]]:
        """Coordinates that each patch moves, D and the shapes there: a small part of the panel."""
        return [on_patch(D, self.shapes) for D in self.overlap]

    @cached_property
    def _overlap_of_basis(self) -> Array:
        """(n_patches, n, n) VᵀD V."""
        overlap = np.empty((len(self.overlap), *(self.shapes.shape[1],) * 2))
        for patch, (_, D, shapes) in enumerate(self._on_patches):
            overlap[patch] = shapes.T @ (D @ shapes)
        return overlap

    @cached_property
    def _at_points(self) -> Array:
        """(n_points, n) the shapes at the points."""
        columns = np.unique(self.points.nonzero()[1])
        return np.asarray(self.points[:, columns] @ self.shapes[columns])

    def _applied(self, omega: float, s: Complexes, x: Complexes, in_shapes: Complexes) -> Complexes:
        """Return Z x with s (columns, n_patches), from x and its part in the shapes."""
        cutoff = 2 * np.pi * self.cutoff
        result = _times(self.plate.stiffness, x)
        result *= 1 + 2j * self.damping_ratio * omega / cutoff
        result -= _times(self.plate.mass, x) * omega**2
        for index, (rows, D, _) in enumerate(self._on_patches):
            if np.any(s[:, index]):
                result[rows] += _times(D, x[rows]) * s[:, index]
        count = self._modal_damping.size
        lost = in_shapes[:count] * self._modal_damping[:, None] * (1j * omega)
        result += _times(self._pushed[:, :count], lost)
        return result

    def _on_shapes(
        self, omega: float, s: Complexes, x: Complexes, in_shapes: Complexes
    ) -> Complexes:
        """Return VᵀZ x of x = K⁻¹ r, Vᵀr = 0, and (M V/m)ᵀ x, which is 0 for the modes."""
        result = in_shapes * self.basis.modal_mass[:, None]
        # with a mass that holds the panel, K x = r − `_shift` M x
        stiff = 1 + 2j * self.damping_ratio * omega / (2 * np.pi * self.cutoff)
        result *= -(omega**2) - self._shift * stiff
        for index, (rows, D, shapes) in enumerate(self._on_patches):
            if np.any(s[:, index]):
                result += _times(shapes.T, _times(D, x[rows])) * s[:, index]
        return result

    def _of_basis(self, frequency: float, stiffness: Complexes) -> list[tuple[Complexes, Index]]:
        """Return VᵀZ V of each set of dampers, factorised."""
        bare = dense_stiffness(np.array([frequency]), self.basis, None)
        damped = bare + weighted_sum(stiffness.T, self._overlap_of_basis)
        return [la.lu_factor(matrix, overwrite_a=True) for matrix in damped]

    # ------------------------------------------------------------------- solutions

    def _together(self, frequency: float, stiffness: Complexes) -> list[ElementMotion]:
        sets, omega = len(stiffness), 2 * np.pi * frequency
        owner = np.repeat(np.arange(sets), self.points.shape[0])
        s, factorised = stiffness[owner], self._of_basis(frequency, stiffness)

        def solve_basis(right: Complexes) -> Complexes:
            answers = [
                la.lu_solve(factor, right[:, owner == index])
                for index, factor in enumerate(factorised)
            ]
            return np.concatenate(answers, axis=1)

        def preconditioned(right: Complexes) -> tuple[Complexes, Complexes]:
            # a residual has no part in the basis: x₀ is Galerkin's, and Vᵀ Z z = 0 of every step
            rest = self._static(right)
            in_shapes = _times(self._pushed.T, rest)
            part = solve_basis(self._on_shapes(omega, s, rest, in_shapes))
            return rest - _times(self.shapes, part), in_shapes - part

        pull = np.tile(self.points.toarray().T, sets).astype(complex)
        at_points = self._at_points.T.astype(complex)
        of_basis = solve_basis(np.tile(at_points, sets))
        start = _times(self.shapes, of_basis)
        remainder = np.zeros_like(start)
        steps: list[tuple[Complexes, Complexes]] = []
        residual = pull - self._applied(omega, s, start, of_basis)
        size = first = self._size(residual)
        for _ in range(MOST_STEPS):
            if np.all(size <= ENOUGH * first):
                break
            direction, in_shapes = preconditioned(residual)
            image = self._applied(omega, s, direction, in_shapes)
            for earlier, earlier_image in steps:
                share = np.sum(earlier_image.conj() * image, axis=0)
                direction, image = direction - share * earlier, image - share * earlier_image
            length = np.sqrt(np.sum(np.abs(image) ** 2, axis=0))
            length[length == 0] = 1.0
            direction, image = direction / length, image / length
            steps.append((direction, image))
            step = np.sum(image.conj() * residual, axis=0)
            remainder, residual = remainder + step * direction, residual - step * image
            size = self._size(residual)
        for index in np.unique(owner[size > ENOUGH * first]):
            columns = owner == index
            whole = self._direct(omega, stiffness[index], pull[:, columns])
            remainder[:, columns] = whole - start[:, columns]
        if not np.all(np.isfinite(remainder)):
            raise ResponseError("the response of all elements is not finite")
        whole = start + remainder
        return [
            ElementMotion(of_basis[:, columns], whole[:, columns], remainder[:, columns])
            for columns in (owner == index for index in range(sets))
        ]

    def _static(self, right: Complexes) -> Complexes:
        """Return K⁻¹ right."""
        answer = self._factors.solve(_as_real(right))
        return np.ascontiguousarray(answer).view(np.complex128)

    def _size(self, residual: Complexes) -> Array:
        """Return the size (columns,) of a residual, each coordinate over its own stiffness."""
        scale = 1 / self.plate.stiffness.diagonal()
        return np.sqrt(scale @ np.abs(residual) ** 2)

    def _direct(self, omega: float, stiffness: Complexes, right: Complexes) -> Complexes:
        """Return Z⁻¹ right by factorisation, the damping of the modes by Woodbury's identity."""
        cutoff = 2 * np.pi * self.cutoff
        K, M = self.plate.stiffness, self.plate.mass
        Z = K * (1 + 2j * self.damping_ratio * omega / cutoff) - omega**2 * M
        for s, D in zip(stiffness, self.overlap, strict=True):
            Z = Z + s * D
        factor = self._modal_damping
        damped = np.flatnonzero(factor)
        B = self._pushed[:, damped]
        answer = _factorised_solution(Z, np.hstack([right, B]).astype(complex))
        x, Y = answer[:, : right.shape[1]], answer[:, right.shape[1] :]
        small = np.diag(1 / (1j * omega * factor[damped])) + B.T @ Y
        return np.asarray(x - Y @ np.linalg.solve(small, B.T @ x))


def _factorised_solution(matrix: sp.csr_array, right: Complexes) -> Complexes:
    """Solve a symmetric system: without pivoting, and with it where that misses `EXACT`."""
    answer = factors(matrix).solve(right)
    left = np.linalg.norm(matrix @ answer - right, axis=0)
    if np.all(left <= EXACT * np.linalg.norm(right, axis=0)):
        return np.asarray(answer)
    return np.asarray(spla.splu(sp.csc_array(matrix)).solve(right))


def _as_real(x: Complexes) -> Array:
    """Return columns of real and imaginary parts in turn, (n, 2k)."""
    return np.ascontiguousarray(x, dtype=np.complex128).view(np.float64)


def _times(matrix: Array | sp.csr_array, x: Complexes) -> Complexes:
    """Return a real matrix times complex columns, without a complex copy of the matrix.

    A matrix of single precision is not copied to double: x is rounded in its place.
    """
    product = matrix @ _as_real(x).astype(matrix.dtype, copy=False)
    return np.ascontiguousarray(product, dtype=np.float64).view(np.complex128)
