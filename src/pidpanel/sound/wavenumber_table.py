"""Matrices over the acoustic wavenumber, tabulated at Chebyshev nodes and interpolated.

Integrals over a panel of sin(kR)/(kR), cos(kR)/R and their kind are even and entire in k, so a
polynomial in k² through Chebyshev nodes converges faster than exponentially once there are more
nodes than kL/2, with L the diameter of the panel.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes

SPARE_NODES = 14
"""Nodes beyond kL/4 in cos θ and kL/2 in azimuth and in the table.

The series of Bessel functions behind each sum ends faster than exponentially once its order
exceeds kL. With 14 nodes the modal forces of smooth shapes err by less than 1e-12 of the largest
up to kL = 66. The coherence of two points a diameter apart errs by 6e-12 at kL = 40, 2e-10 at 66
and 3e-7 at 200.
"""


class FieldError(ValueError):
    """Arrays or values that do not describe a panel in a sound field."""


@dataclass(frozen=True)
class WavenumberTable:
    """A matrix at Chebyshev nodes, to be read at any k up to `wavenumber_max`.

    The nodes are the positive ones of a Chebyshev rule on [−k_max, k_max].

    Parameters
    ----------
    wavenumber_max
        k_max [rad/m].
    wavenumber
        (m,) nodes [rad/m], falling from just below k_max.
    even
        (m, n, n) the matrix at the nodes, or its real part, even in k.
    odd_over_wavenumber
        (m, n, n) its imaginary part, odd in k, over k; None for a real matrix.
    """

    wavenumber_max: float
    wavenumber: Array
    even: Array
    odd_over_wavenumber: Array | None = None

    def at(self, wavenumber: ArrayLike) -> Array | Complexes:
        """Return the matrix at the wavenumbers (nf,) [rad/m], (nf, n, n).

        Raises
        ------
        FieldError
            Where a wavenumber lies outside 0 to k_max: polynomials must not be extrapolated.
        """
        k = checked_wavenumber(np.asarray(wavenumber, dtype=np.float64))
        if k.size and k.max() > self.wavenumber_max * (1 + 1e-12):
            raise FieldError(
                f"wavenumber = {k.max():g} rad/m: the table reaches to {self.wavenumber_max:g}"
            )
        weights = even_interpolation(k, self.wavenumber_max, self.wavenumber.size)
        even: Array = np.tensordot(weights, self.even, axes=1)
        if self.odd_over_wavenumber is None:
            return even
        odd = np.tensordot(k[:, None] * weights, self.odd_over_wavenumber, axes=1)
        return even + 1j * odd


def constant_table(wavenumber_max: float, matrix: Array) -> WavenumberTable:
    """Return a table of a matrix (n, n) that is the same at every k up to `wavenumber_max`.

    One node makes the interpolation constant.
    """
    nodes = chebyshev_nodes(wavenumber_max, 1)
    return WavenumberTable(wavenumber_max, nodes, np.asarray(matrix)[None])


def checked_wavenumber(k: Array) -> Array:
    """Return k; raise `FieldError` where it is negative or not finite."""
    bad = ~(np.isfinite(k) & (k >= 0))
    if np.any(bad):
        raise FieldError(f"wavenumber = {k[bad].flat[0]!r} rad/m must be finite and not negative")
    return k


def checked_maximum(wavenumber_max: float) -> float:
    """Return k_max; raise `FieldError` where it is not finite or not positive."""
    k_max = float(wavenumber_max)
    if not (np.isfinite(k_max) and k_max > 0):
        raise FieldError(f"wavenumber_max = {wavenumber_max!r} rad/m must be positive")
    return k_max


def node_count(wavenumber_max: float, diameter: float) -> int:
    """Return the nodes that a table to k_max [rad/m] of a panel of that diameter [m] needs."""
    return int(np.ceil(wavenumber_max * diameter / 2)) + SPARE_NODES


def chebyshev_nodes(k_max: float, count: int) -> Array:
    """Return the positive nodes of the Chebyshev rule with 2·count nodes on [−k_max, k_max]."""
    nodes: Array = k_max * np.cos(np.pi * (2 * np.arange(count) + 1) / (4 * count))
    return nodes


def even_interpolation(k: Array, k_max: float, count: int) -> Array:
    """Return the matrix (k.size, count) from node values to values at k, for even functions.

    With t = 2(k/k_max)² − 1 the nodes are Chebyshev's of the first kind in t, whose barycentric
    weights are (−1)^j sin((2j + 1)π/(2·count)) (Berrut and Trefethen 2004, Eq. 5.3).
    """
    angle = np.pi * (2 * np.arange(count) + 1) / (2 * count)
    distance = (2 * (k / k_max) ** 2 - 1)[:, None] - np.cos(angle)
    at_node = distance == 0
    distance[at_node] = 1.0
    matrix = (-1.0) ** np.arange(count) * np.sin(angle) / distance
    matrix /= matrix.sum(axis=1, keepdims=True)
    on_node = at_node.any(axis=1)
    matrix[on_node] = at_node[on_node]
    return matrix
