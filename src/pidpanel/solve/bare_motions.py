"""Motions of the bare panel on some lines, from its dynamic stiffness and the modal forces."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.excitation import Excitation, Matrices
from pidpanel.solve.model import ResponseError

# (n, n) for all frequencies, (nf, n, n), or a function of frequencies that returns (nf, n, n).
MatrixInput = Matrices | Callable[[Array], Matrices]


# Two sets of motions (slices of columns) → leftᵀ Z₀⁻¹ G Z₀⁻ᴴ right, (nf, n_left, n_right).
Psd = Callable[[slice, slice], Complexes]


class MovedPanel(ABC):
    """The bare panel on some lines, seen in the motions W (n, nw)."""

    def __init__(self, observed: Array) -> None:
        self.observed = observed

    @abstractmethod
    def motion(self) -> Complexes:
        """Return Z₀⁻¹ W, (nf, n, nw)."""

    @abstractmethod
    def receptance(self, rows: Index, columns: slice) -> Complexes:
        """Return Wᵀ Z₀⁻¹ W of some columns, (nf, n_seen, n_pulled)."""

    @abstractmethod
    def in_parts(self, factors: Matrices) -> Complexes:
        """Return Wᵀ Z₀⁻¹ L, (nf, nw, r)."""

    def psd(self, force: MatrixInput, frequency: Array, lines: slice) -> Psd:
        """Return the PSDs of the motions under G."""
        factors = force.factors(frequency[lines]) if isinstance(force, Excitation) else None
        if factors is not None:
            parts = self.in_parts(factors)
            return lambda left, right: parts[:, left] @ parts[:, right].conj().swapaxes(1, 2)
        motion = self.motion()
        pushed = _pushed(matrices_at(force, frequency, lines, len(self.observed)), motion)
        return lambda left, right: motion[:, :, left].swapaxes(1, 2) @ pushed[:, :, right]


class InVacuum(MovedPanel):
    """Z₀ is diagonal."""

    def __init__(self, stiffness: Complexes, observed: Array) -> None:
        super().__init__(observed)
        self._transfer = (1 / stiffness)[:, :, None]

    def motion(self) -> Complexes:
        """Return Z₀⁻¹ W."""
        return self._transfer * self.observed

    def receptance(self, rows: Index, columns: slice) -> Complexes:
        """Return Wᵀ Z₀⁻¹ W of some columns."""
        return _seen_by(self.observed[:, rows], self._transfer * self.observed[:, columns])

    def in_parts(self, factors: Matrices) -> Complexes:
        """Return Wᵀ Z₀⁻¹ L."""
        return _seen_by(self.observed, self._transfer * factors)


class ShapesInVacuum(InVacuum):
    """The shapes themselves are the first n motions W, and the last among rows."""

    def psd(self, force: MatrixInput, frequency: Array, lines: slice) -> Psd:
        """Return the PSDs of the motions under G."""
        n, transfer = len(self.observed), self._transfer
        G = matrices_at(force, frequency, lines, n)

        def between_motions(left: slice, right: slice) -> Complexes:
            if right.start == 0:
                moved = transfer * G * transfer.conj().swapaxes(1, 2)
            else:
                moved = transfer * _pushed(G, transfer * self.observed[:, right])
            return moved if left.start == 0 else _seen_by(self.observed[:, left], moved)

        return between_motions

    def receptance(self, rows: Index, columns: slice) -> Complexes:
        """Return Wᵀ Z₀⁻¹ W of some columns."""
        motion, n = self._transfer * self.observed[:, columns], len(self.observed)
        patch_motion = _seen_by(self.observed[:, rows[rows >= n]], motion)
        return np.concatenate([patch_motion, motion[:, rows[rows < n]]], axis=1)


class InAir(MovedPanel):
    """Z₀ is full, and symmetric: Z₀⁻¹ W is known."""

    def __init__(self, motion: Complexes, observed: Array) -> None:
        super().__init__(observed)
        self._motion = motion

    def motion(self) -> Complexes:
        """Return Z₀⁻¹ W."""
        return self._motion

    def receptance(self, rows: Index, columns: slice) -> Complexes:
        """Return Wᵀ Z₀⁻¹ W of some columns."""
        return _seen_by(self.observed[:, rows], self._motion[:, :, columns])

    def in_parts(self, factors: Matrices) -> Complexes:
        """Return Wᵀ Z₀⁻¹ L."""
        turned = self._motion.swapaxes(1, 2)
        if np.iscomplexobj(factors):
            return turned @ factors
        parts = np.empty((*turned.shape[:2], factors.shape[2]), dtype=np.complex128)
        parts.real, parts.imag = turned.real @ factors, turned.imag @ factors
        return parts


def _seen_by(observed: Array, motion: Complexes) -> Complexes:
    """Return observedᵀ motion (nf, nw, k): a real product of twice the columns."""
    columns = np.ascontiguousarray(motion).view(np.float64)
    return (np.ascontiguousarray(observed.T) @ columns).view(np.complex128)


def _pushed(force: Matrices, motion: Complexes) -> Complexes:
    """Return G motion*, (nf, n, k)."""
    if np.iscomplexobj(force):
        return force @ motion.conj()
    # two real products cost half of one complex product
    columns = np.ascontiguousarray(motion.conj()).view(np.float64)
    return (force @ columns).view(np.complex128)


def product(left: Complexes, force: Matrices, right: Complexes) -> Complexes:
    """Return leftᵀ G right*, (nf, n_left, n_right)."""
    return left.swapaxes(1, 2) @ _pushed(force, right)


def air_at(air: MatrixInput | None, frequency: Array, lines: slice, n: int) -> Matrices | None:
    """Return the matrices of the air on some lines, see `matrices_at`; None in vacuum."""
    return None if air is None else matrices_at(air, frequency, lines, n)


def matrices_at(matrix: MatrixInput, frequency: Array, lines: slice, n: int) -> Matrices:
    """Return the matrices of some lines, (n_lines, n, n), or (1, n, n) where all are equal."""
    if callable(matrix):
        values: NDArray[Any] = matrix(frequency[lines])
    else:
        array: NDArray[Any] = np.asarray(matrix)
        values = array[None] if array.ndim == 2 else array
        if values.shape[0] == frequency.size:
            values = values[lines]
    if values.shape not in [(1, n, n), (frequency[lines].size, n, n)]:
        raise ResponseError(
            f"a modal matrix for {frequency.size} lines has shape {values.shape}: "
            f"({n}, {n}) or one such matrix a line is needed"
        )
    if not np.all(np.isfinite(values)):
        raise ResponseError("a modal matrix has values that are not finite")
    return values
