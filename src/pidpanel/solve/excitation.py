"""Excitation of a panel: random forces on its modes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.model import ResponseError

Matrices = Array | Complexes

# (n, n) for all frequencies, (nf, n, n), or a function of frequencies that returns (nf, n, n).
MatrixInput = Matrices | Callable[[Array], Matrices]


@runtime_checkable
class Excitation(Protocol):
    """Random forces on a panel: the cross-PSD of the modal forces is S(f) G(f).

    Splitting it in two lets G be tabulated, and S jump from band to band. Under sound S is the PSD
    of the pressure [Pa²/Hz] and G has the unit m⁴; on a shaker S is the PSD of the acceleration of
    the supports, and G has the unit kg² (`solve.base_motion`).
    """

    def spectrum(self, frequency: Array) -> Array:
        """Return the level S (nf,), one-sided per Hz, at the frequencies (nf,) [Hz]."""

    def __call__(self, frequency: Array) -> Matrices:
        """Return G, Hermitian, (nf, n, n) or (1, n, n) where all are equal."""

    def factors(self, frequency: Array) -> Matrices | None:
        """Return L (nf, n, r) with G = L Lᴴ; None where r is not small."""


@runtime_checkable
class AirOfShapes(Protocol):
    """The air on a panel, known also of some of its shapes."""

    def columns(self, frequency: Array, shapes: Index) -> Complexes:
        """Return columns of −ω²M_air + iωR (nf, n, k) [N/m] of shapes at frequencies (nf,) [Hz]."""


@dataclass(frozen=True)
class ModalForce:
    """An excitation from arrays."""

    spectrum: Callable[[Array], Array]  # S (nf,) over frequencies (nf,) [Hz]
    # G (n, n) at all frequencies, or a function of frequencies that returns (nf, n, n)
    matrix: Matrices | Callable[[Array], Matrices]
    # L (nf, n, r) over frequencies; None where no short form is known
    columns: Callable[[Array], Matrices] | None = None

    def __call__(self, frequency: Array) -> Matrices:
        """Return G."""
        return self.matrix(frequency) if callable(self.matrix) else self.matrix[None]

    def factors(self, frequency: Array) -> Matrices | None:
        """Return L."""
        return None if self.columns is None else self.columns(frequency)


@dataclass(frozen=True)
class Superposition:
    """Two independent excitations."""

    # The excitations. S is that of the first.
    first: Excitation
    second: Excitation
    share: float = 1.0  # factor on the cross-PSD of the second

    def spectrum(self, frequency: Array) -> Array:
        """Return S of the first."""
        return self.first.spectrum(frequency)

    def __call__(self, frequency: Array) -> Matrices:
        """Return G₁ + share S₂ G₂/S₁."""
        level = self.first.spectrum(frequency)
        inverse = np.divide(1.0, level, out=np.zeros_like(level), where=level > 0)
        share = self.share * inverse * self.second.spectrum(frequency)
        return self.first(frequency) + share[:, None, None] * self.second(frequency)

    def factors(self, frequency: Array) -> Matrices | None:
        """Return None: no short form is known."""
        return None


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


def air_at(air: MatrixInput | None, frequency: Array, lines: slice, n: int) -> Matrices | None:
    """Return the matrices of the air on some lines, see `matrices_at`; None in vacuum."""
    return None if air is None else matrices_at(air, frequency, lines, n)


def mixed_product(left: NDArray[Any], right: NDArray[Any]) -> Complexes:
    """Return left @ right (nf, n, k): two real products cost half of a complex one."""
    if np.iscomplexobj(left) == np.iscomplexobj(right):
        return np.asarray(left @ right)
    if np.iscomplexobj(right):
        columns = np.ascontiguousarray(right).view(right.real.dtype)
        return np.asarray((np.ascontiguousarray(left) @ columns).view(right.dtype))
    product = np.empty((*left.shape[:-1], right.shape[-1]), left.dtype)
    product.real, product.imag = left.real @ right, left.imag @ right
    return product
