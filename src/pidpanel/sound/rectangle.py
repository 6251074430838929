"""Jumps of the pressure over a rectangle: Chebyshev functions with the factor √distance of an edge.

On |x| ≤ a, |y| ≤ b, with ξ = x/a and η = y/b,

    ψ_mn = √(1 − ξ²) U_m(ξ) √(1 − η²) U_n(η),    ψ̂ = X_m(κ_x) X_n(κ_y),
    X_m(κ) = ∫ √(1 − ξ²) U_m(ξ) exp(−iκx) dx = aπ (−i)^m (m + 1) J_{m+1}(κa)/(κa)

(Gradshteyn and Ryzhik 7.321 with λ = 1). Functions of other parity along x or y do not interact, so
that the matrices fall into four blocks.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.sound.face import quarter_circle
from pidpanel.sound.wavenumber_table import chebyshev_nodes, node_count

# Functions along a side beyond κa, of its shortest waves. Of sines with κa = 14 on 1.5 m × 1 m
# four give the impedance within 0.4 %, six within 1e-5.
SPARE_FUNCTIONS = 5

# Wavenumber integrated to over the largest of a function, (m + 1)/a: from there on the functions
# fall as behind an edge.
FARTHEST = 4.0


MOST_FUNCTIONS = 400


def affordable(half: Array, spare: float, most: float) -> float:
    """Return κ [rad/m] for which the product of κa + spare over both half sides is that many.

    Examples
    --------
    >>> round(affordable(np.array([0.75, 0.5]), 5.0, 400.0), 3)
    24.369
    """
    product, total = float(np.prod(half)), spare * float(np.sum(half))
    return float((np.sqrt(total**2 + 4 * product * (most - spare**2)) - total) / (2 * product))


@dataclass(frozen=True)
class SideFunctions:
    """The functions of a side, in the order of their degree m."""

    middle: float  # [m]
    half: float  # a [m]
    degree: Index  # (n,) m

    def of_parity(self, parity: int) -> "SideFunctions":
        """Return the functions that are even (0) or odd (1)."""
        return SideFunctions(self.middle, self.half, self.degree[self.degree % 2 == parity])

    def transform(self, wavenumber: Array) -> Array:
        """Return i^p X_m (k, n) [m] with p = 0 of even and 1 of odd functions, which is real."""
        from scipy.special import jv  # slow to import, and a check needs none

        reach = wavenumber[:, None] * self.half
        order = self.degree + 1
        safe = np.where(reach == 0, 1e-12, reach)
        sign = (-1.0) ** (self.degree // 2)
        return self.half * np.pi * sign * order * jv(order, safe) / safe

    def values(self, position: Array, degrees: int) -> Array:
        """Return the functions (nq, n) at positions [m], as polynomials of some degrees.

        Their Legendre series: sums over the points of a condensed face are integrals of
        polynomials alone.
        """
        order, count = self.degree + 1, degrees + int(self.degree[-1]) + 2
        angle = np.pi * np.arange(1, count + 1) / (count + 1)  # Gauss with the weight √(1 − ξ²)
        weighted = np.sin(np.outer(order, angle)) * np.sin(angle) * np.pi / (count + 1)
        legendre = np.polynomial.legendre.legvander
        series = weighted @ legendre(np.cos(angle), degrees - 1) * (np.arange(degrees) + 0.5)
        return legendre((position - self.middle) / self.half, degrees - 1) @ series.T

    def products(self) -> Array:
        """Return ∫ (1 − ξ²) U_m U_p dx (n, n) [m]."""
        order = self.degree + 1
        node, weight = np.polynomial.legendre.leggauss(2 * int(order[-1]) + 30)
        angle = np.pi / 2 * (1 + node)
        sines = np.sin(np.outer(order, angle))
        return self.half * np.pi / 2 * (sines * (weight * np.sin(angle))) @ sines.T

    def edge_tail(self, wavenumber: float) -> Array:
        """Return ∫_K^∞ κ X_m X_p* dκ (n, n), of functions of one parity.

        ∫_S^∞ J_μ J_ν ds/s in closed form (Watson, 5.11).
        """
        from scipy.special import jv

        order, reach = self.degree + 1, wavenumber * self.half
        bessel = jv(np.arange(int(order[-1]) + 2), reach)
        value, slope = bessel[order], (bessel[order - 1] - bessel[order + 1]) / 2
        apart = (order[:, None] ** 2 - order**2).astype(np.float64)
        np.fill_diagonal(apart, 1.0)
        wronskian = reach * (np.outer(value, slope) - np.outer(slope, value)) / apart
        squares = np.cumsum(np.append(bessel[0] ** 2, 2 * bessel[1:] ** 2))
        np.fill_diagonal(wronskian, (squares[order] - value**2) / (2 * order))
        sign = (-1.0) ** (self.degree // 2)
        return np.pi**2 * np.outer(sign * order, sign * order) * wronskian


@dataclass(frozen=True)
class RectangleJumps:
    """Functions of the jump over a rectangle."""

    x: SideFunctions
    y: SideFunctions

    wavenumber: float = np.inf  # κ [rad/m] of the waves that the functions resolve

    @classmethod
    def of_box(cls, low: ArrayLike, high: ArrayLike, wavenumber: float) -> "RectangleJumps":
        """Return functions on a rectangle of two corners [m] that resolve waves to κ [rad/m].

        Or to a lower one, if that took more than `MOST_FUNCTIONS`.
        """
        low, high = np.asarray(low), np.asarray(high)
        wavenumber = min(wavenumber, affordable((high - low) / 2, SPARE_FUNCTIONS, MOST_FUNCTIONS))
        sides = []
        for start, end in zip(low, high, strict=True):
            half = float(end - start) / 2
            count = int(np.ceil(wavenumber * half)) + SPARE_FUNCTIONS
            sides.append(SideFunctions(float(start + end) / 2, half, np.arange(count)))
        return cls(sides[0], sides[1], wavenumber)

    @property
    def diameter(self) -> float:
        """Diagonal [m]."""
        return 2 * float(np.hypot(self.x.half, self.y.half))

    @property
    def reach(self) -> float:
        """K [rad/m], from which on the functions fall as behind an edge."""
        return FARTHEST * max(side.degree.size / side.half for side in (self.x, self.y))

    @property
    def _pairs(self) -> list[tuple[SideFunctions, SideFunctions]]:
        return [(self.x.of_parity(p), self.y.of_parity(q)) for p in (0, 1) for q in (0, 1)]

    def means(self) -> list[Array]:
        """Return P(κ) = (1/2π) ∮ ψ̂ ψ̂* dα of each block, (count, n, n) [m⁴].

        At the Chebyshev nodes of `node_count` up to `reach`.
        """
        nodes = chebyshev_nodes(self.reach, node_count(self.reach, self.diameter))
        pairs = self._pairs
        sizes = [x.degree.size * y.degree.size for x, y in pairs]
        means = [np.empty((nodes.size, size, size)) for size in sizes]
        for index, wavenumber in enumerate(nodes):
            azimuth = quarter_circle(wavenumber * self.diameter)
            along_x = self.x.transform(wavenumber * np.cos(azimuth))
            along_y = self.y.transform(wavenumber * np.sin(azimuth))
            for mean, (x, y) in zip(means, pairs, strict=True):
                part = along_x[:, x.degree, None] * along_y[:, None, y.degree]
                part = part.reshape(azimuth.size, -1)
                mean[index] = part.T @ part / azimuth.size
        return means

    def tails(self) -> list[Array]:
        """Return ∫_K^∞ P κ² dκ of each block, (n, n) [m].

        Far out only waves across an edge count: P → (2/κ) (X_m X_p* ∫ψ_n ψ_q dy and the same of y).
        """
        tails = []
        for x, y in self._pairs:
            across_x = np.kron(x.edge_tail(self.reach), y.products())
            tails.append(2 * (across_x + np.kron(x.products(), y.edge_tail(self.reach))))
        return tails

    def couplings(self, panel: PanelQuadrature) -> list[Array]:
        """Return ∫ ψ φ dA of each block and the shapes of a condensed face, (n, n_shapes) [m²]."""
        x, x_place = np.unique(panel.position[:, 0], return_inverse=True)
        y, y_place = np.unique(panel.position[:, 1], return_inverse=True)
        load = np.zeros((x.size, y.size, panel.shape.shape[1]))
        load[x_place, y_place] = panel.weight[:, None] * panel.shape
        along_x, along_y = self.x.values(x, x.size), self.y.values(y, y.size)
        coupling = np.einsum("xm,xyi,yn->mni", along_x, load, along_y, optimize=True)
        return [
            coupling[x.degree[:, None], y.degree].reshape(-1, load.shape[2]) for x, y in self._pairs
        ]

    def waves(self, wavevector: Array) -> list[Complexes]:
        """Return ∫ ψ exp(−iκ·x) dA of each block, (k, n) [m²], at wavevectors (k, 2) [rad/m].

        x is measured from the middle of the rectangle.
        """
        waves = []
        for number, (x, y) in enumerate(self._pairs):
            along_x, along_y = x.transform(wavevector[:, 0]), y.transform(wavevector[:, 1])
            part = along_x[:, :, None] * along_y[:, None, :]
            waves.append((-1j) ** (number // 2 + number % 2) * part.reshape(len(wavevector), -1))
        return waves
