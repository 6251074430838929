"""Matrices over the acoustic wavenumber, tabulated at Chebyshev nodes and interpolated.

Integrals over a panel of sin(kR)/(kR), cos(kR)/R and their kind are even and entire in k, so a
polynomial in k² through Chebyshev nodes converges faster than exponentially once there are more
nodes than kL/2, with L the diameter of the panel.
"""

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike, NDArray

from pidpanel.arrays import Array, Complexes, Index

# Nodes beyond kL/4 in cos θ and kL/2 in azimuth and in the table, up to kL = 66.
#
# The series of Bessel functions behind each sum ends faster than exponentially once its order
# exceeds kL, over a width that grows with its cube root (`spare_nodes`). With 14 nodes the modal
# forces of smooth shapes err by less than 1e-12 of the largest up to kL = 66, the coherence of two
# points a diameter apart by 6e-12 at kL = 40, 2e-10 at 66 and 3e-7 at 200.
SPARE_NODES = 14

SPARE_UP_TO = 66.0  # kL up to which `SPARE_NODES` will do

# Relative error of the mean square of the force on a shape by the factors of G: the smallest that
# the rounding of the table allows, for a wing of 4 m × 2.5 m up to 2 kHz the first. Tables of free
# edges, interpolated within 3e-4 (`free_edges.NODE_ERROR`), allow the last ones.
FACTOR_TOLERANCES = (1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)

SLACK = 10.0  # times as much at lower wavenumbers of a band, where the pivots are not the best ones

# Share of the largest mean square of a force below which the table is rounding.
LEAST_FORCE = 1e-10

BAND = 1.1  # ratio of wavenumbers for which the same shapes represent all

# Rows of G that are read together, so that they stay in the processor's own memory.
ROWS_AT_ONCE = 16

TRANSITION = 0.8  # start of a transition between two tables over its end

FACTOR_SHARE = 0.5  # share of the shapes from which on a factor of G is no cheaper than G


class FieldError(ValueError):
    """Arrays or values that do not describe a panel in a sound field."""


class Table(Protocol):
    """A Hermitian matrix over the wavenumber."""

    @property
    def wavenumber_max(self) -> float:
        """k_max [rad/m]."""

    def matrix(self, wavenumber: ArrayLike, shapes: Index | None = None) -> Array | Complexes:
        """Return the matrix, see `WavenumberTable.matrix`."""

    def factors_at(self, wavenumber: ArrayLike) -> Array | Complexes | None:
        """Return L, see `WavenumberTable.factors_at`; None where no short form is known."""


@dataclass(frozen=True)
class WavenumberTable:
    """A matrix at Chebyshev nodes, interpolated at any k up to `wavenumber_max`.

    The nodes are the positive ones of a Chebyshev rule on [−k_max, k_max].
    """

    wavenumber_max: float  # k_max [rad/m]
    wavenumber: Array  # (m,) nodes [rad/m], falling from just below k_max
    # (m, n, n) the matrix at the nodes, or its real part, even in k; or some of its rows
    even: Array
    # (m, n, n) its imaginary part, odd in k, over k; None for a real matrix
    odd_over_wavenumber: Array | None = None
    power: int = 0  # the matrix is kᵖ times what is interpolated
    _pivots: dict[int, tuple[Index, float]] = field(default_factory=dict, repr=False, compare=False)
    _rows: dict[int, "WavenumberTable"] = field(default_factory=dict, repr=False, compare=False)

    @property
    def diameter(self) -> float:
        """Largest diameter of a panel [m] for which the table has its nodes (`node_count`)."""
        count = self.wavenumber.size
        reach = 2 * max(count - SPARE_NODES, 0)
        while reach > 0 and node_count(1.0, reach - 1) > count:
            reach -= 1
        return reach / self.wavenumber_max

    @property
    def size_text(self) -> str:
        """Size in words."""
        count, shapes = self.even.shape[:2]
        return f"{shapes} shapes at {count} wavenumbers to {self.wavenumber_max:.3g} rad/m"

    def matrix(self, wavenumber: ArrayLike, shapes: Index | None = None) -> Array | Complexes:
        """Return the matrix at the wavenumbers (nf,) [rad/m], (nf, n, n), or columns (nf, n, k).

        Raises
        ------
        FieldError
            If a wavenumber is above k_max: polynomials must not be extrapolated.
        """
        k = self._checked(wavenumber)
        weights = self._weights(k)
        block = ... if shapes is None else (..., shapes)
        even: Array = np.tensordot(weights, self.even[block], axes=1)
        if self.odd_over_wavenumber is None:
            return even
        odd = np.tensordot(k[:, None] * weights, self.odd_over_wavenumber[block], axes=1)
        return even + 1j * odd

    def factors_at(self, wavenumber: ArrayLike) -> Array | Complexes | None:
        """Return L (nf, n, r) with the matrix equal to L Lᴴ at the wavenumbers (nf,) [rad/m].

        Long waves excite few combinations of shapes: of 371 shapes of a wing of 2.1 m × 1.2 m 19
        represent all at 30 Hz, 130 at 470 Hz. Cholesky's method with pivots selects the shapes P of
        a band at its highest wavenumber; the others follow from them line by line,

            L Lᴴ = G_P (G_PP)⁻¹ G_Pᴴ,

        and the remainder, whose diagonal is not negative, is checked on each line.

        Returns
        -------
        None if the number of shapes makes the matrix as cheap, or if the remainder would exceed
        `SLACK` times the tolerance of the band for the mean square of a force.
        """
        k = self._checked(wavenumber)
        if not k.size or not k.max() > 0:
            return None
        band = max(0, int(np.log(self.wavenumber_max / k.max()) / np.log(BAND)))
        if band not in self._pivots:
            self._pivots[band] = self._stand_for_all(band)
        pivots, tolerance = self._pivots[band]
        if not 0 < pivots.size <= FACTOR_SHARE * self.even.shape[1]:
            return None
        if band not in self._rows:  # lines come in order: one band is enough
            self._rows.clear()
            self._rows[band] = self._rows_up_to(self.wavenumber_max / BAND**band, pivots)
        weights = self._weights(k)
        square = weights @ np.diagonal(self.even, axis1=1, axis2=2)
        return _factors(self._rows[band].matrix(k), pivots, square, tolerance)

    def _rows_up_to(self, k_max: float, rows: Index) -> "WavenumberTable":
        """Return some rows up to a lower wavenumber, for which fewer nodes will do."""
        count = self.wavenumber.size
        needed = min(node_count(k_max, self.diameter), count)
        nodes = chebyshev_nodes(k_max, needed)
        weights = even_interpolation(nodes, self.wavenumber_max, count)

        def read(values: Array) -> Array:
            table = np.empty((needed, rows.size, values.shape[2]))
            for some in range(0, rows.size, ROWS_AT_ONCE):
                block = slice(some, some + ROWS_AT_ONCE)
                table[:, block] = np.tensordot(weights, values[:, rows[block]], axes=1)
            return table

        odd = self.odd_over_wavenumber
        odd = None if odd is None else read(odd)
        return WavenumberTable(k_max, nodes, read(self.even), odd, self.power)

    def _stand_for_all(self, band: int) -> tuple[Index, float]:
        """Return the shapes (r,) whose forces represent all in a band, and the accuracy.

        The array is empty if no tolerance is met.
        """
        empty = np.zeros(0, dtype=np.int64), 0.0
        top = self.wavenumber_max / BAND**band
        lower, matrix = self.matrix([top / BAND, top])
        square = np.diagonal(matrix).real
        scale = np.sqrt(np.maximum(square, LEAST_FORCE * square.max(initial=0.0)))
        if not np.all(scale > 0):
            return empty
        pivoted = la.lapack.zpstrf if np.iscomplexobj(matrix) else la.lapack.dpstrf
        scaled = matrix / scale[:, None] / scale
        for tolerance in FACTOR_TOLERANCES:
            _, order, rank, _ = pivoted(scaled, tol=tolerance, lower=1)
            pivots = np.asarray(order[:rank] - 1, dtype=np.int64)
            holds = (
                _factors(force[None, pivots], pivots, np.diagonal(force).real[None], tolerance)
                is not None
                for force in (matrix, lower)
            )
            if all(holds):
                return pivots, tolerance
        return empty

    def _weights(self, k: Array) -> Array:
        """Return the weights (nf, m) of the values at the nodes."""
        weights = even_interpolation(k, self.wavenumber_max, self.wavenumber.size)
        return k[:, None] ** self.power * weights if self.power else weights

    def _checked(self, wavenumber: ArrayLike) -> Array:
        k = np.asarray(wavenumber, dtype=np.float64)
        if k.size and k.max() > self.wavenumber_max * (1 + 1e-12):
            raise FieldError(
                f"wavenumber = {k.max():g} rad/m: the table reaches to {self.wavenumber_max:g}"
            )
        return k


@dataclass(frozen=True)
class JoinedTable:
    """Two tables: one up to the end of a transition, one from its start on."""

    lower: WavenumberTable  # up to the end of the transition, its k_max
    upper: WavenumberTable

    @property
    def wavenumber_max(self) -> float:
        """k_max [rad/m]."""
        return self.upper.wavenumber_max

    def matrix(self, wavenumber: ArrayLike, shapes: Index | None = None) -> Array | Complexes:
        """Return `WavenumberTable.matrix`."""
        k = np.asarray(wavenumber, dtype=np.float64)
        share = upper_share(k, self.lower.wavenumber_max)[:, None, None]
        if k.size and np.all(share == 0):
            return self.lower.matrix(k, shapes)
        if np.all(share == 1):
            return self.upper.matrix(k, shapes)
        lower = self.lower.matrix(np.minimum(k, self.lower.wavenumber_max), shapes)
        return (1 - share) * lower + share * self.upper.matrix(k, shapes)

    def factors_at(self, wavenumber: ArrayLike) -> Array | Complexes | None:
        """Return `WavenumberTable.factors_at`; None in the transition."""
        k = np.asarray(wavenumber, dtype=np.float64)
        share = upper_share(k, self.lower.wavenumber_max)
        if k.size and np.all(share == 0):
            return self.lower.factors_at(k)
        return self.upper.factors_at(k) if np.all(share == 1) else None


def upper_share(wavenumber: ArrayLike, end: float) -> Array:
    """Return the share of the upper of two tables, 0 to 1 in the transition, without a kink."""
    place = np.clip((np.asarray(wavenumber) / end - TRANSITION) / (1 - TRANSITION), 0, 1)
    share: Array = place**2 * (3 - 2 * place)
    return share


def _factors(
    rows: NDArray[Any], pivots: Index, square: Array, tolerance: float
) -> NDArray[Any] | None:
    """Return L (nf, n, r) of rows (nf, r, n) of G and its diagonal (nf, n); see `factors_at`."""
    floor = LEAST_FORCE * square.max(axis=1, keepdims=True)
    scale = np.sqrt(np.maximum(square, floor))[:, pivots]
    factors = np.empty((len(rows), rows.shape[2], rows.shape[1]), rows.dtype)
    for line, row in enumerate(rows):
        scaled = row / scale[line][:, None]
        try:
            triangle = la.cholesky(scaled[:, pivots] / scale[line], lower=True)
        except la.LinAlgError:  # of rounding of the table
            return None
        turned = la.solve_triangular(triangle, scaled, lower=True, check_finite=False)
        factors[line] = turned.conj().T
    left = square - np.sum(np.abs(factors) ** 2, axis=2)
    if np.any(np.abs(left) > SLACK * tolerance * np.maximum(square, floor)):
        return None
    return factors


def constant_table(wavenumber_max: float, matrix: Array) -> WavenumberTable:
    """Return a table of a matrix (n, n) that is the same at every k up to `wavenumber_max`.

    One node makes the interpolation constant.
    """
    nodes = chebyshev_nodes(wavenumber_max, 1)
    return WavenumberTable(wavenumber_max, nodes, np.asarray(matrix)[None])


def node_count(wavenumber_max: float, diameter: float) -> int:
    """Return the nodes that a table to k_max [rad/m] of a panel of that diameter [m] needs."""
    reach = wavenumber_max * diameter
    return int(np.ceil(reach / 2)) + spare_nodes(reach)


def spare_nodes(reach: float) -> int:
    """Return the nodes that are needed beyond those that grow with kL, of a kL."""
    return int(np.ceil(SPARE_NODES * max(reach / SPARE_UP_TO, 1.0) ** (1 / 3)))


def chebyshev_nodes(k_max: float, count: int) -> Array:
    """Return the positive nodes of the Chebyshev rule with 2·count nodes on [−k_max, k_max]."""
    return k_max * unit_nodes(2 * count)[:count]


def even_interpolation(k: Array, k_max: float, count: int) -> Array:
    """Return the matrix (k.size, count) from node values to values at k, for even functions.

    The nodes are Chebyshev's of the first kind in 2(k/k_max)² − 1.
    """
    return interpolation(2 * (k / k_max) ** 2 - 1, count)


def unit_nodes(count: int) -> Array:
    """Return the Chebyshev nodes of the first kind on [−1, 1], (count,) falling."""
    return np.cos(_angles(count))


def interpolation(x: Array, count: int) -> Array:
    """Return the matrix (x.size, count) from values at the nodes to values at x in [−1, 1].

    Barycentric, with weights (−1)^j sin((2j + 1)π/(2·count)) (Berrut and Trefethen 2004, Eq. 5.3).
    """
    distance = x[:, None] - unit_nodes(count)
    at_node = distance == 0
    distance[at_node] = 1.0
    matrix: Array = (-1.0) ** np.arange(count) * np.sin(_angles(count)) / distance
    matrix /= matrix.sum(axis=1, keepdims=True)
    on_node = at_node.any(axis=1)
    matrix[on_node] = at_node[on_node]
    return matrix


def _angles(count: int) -> Array:
    return np.pi * (2 * np.arange(count) + 1) / (2 * count)
