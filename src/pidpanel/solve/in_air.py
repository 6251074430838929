"""The panel in air solved on many lines from few factorisations.

In air Z₀ is full, and a solve a line is most of what a response costs. But only modes whose
frequencies are near make it vary fast. On a band of lines let w be the shapes that resonate within
a window about it and o all others:

    X = Z₀⁻¹ W:    X_w = (Z_ww − Z_wo Y_w)⁻¹ (W_w − Z_wo Y_W),    X_o = Y_W − Y_w X_w,
    Y_w = Z_oo⁻¹ Z_ow,    Y_W = Z_oo⁻¹ W_o.

Z_oo has no pole within the window, so Y and what follows from it are polynomials of the frequency
to any accuracy: they are solved at Chebyshev nodes and interpolated, and a line costs a solve of
the few shapes w. How well is read from the last coefficients of the polynomials; a band where they
do not fall below `TAIL` is halved, and one of few lines is solved line by line.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags, Index
from pidpanel.chebyshev import interpolation, last_coefficients, unit_nodes
from pidpanel.solve.model import ModalBasis

NODES = 12
"""Chebyshev nodes of a band over which the phase of the air hardly turns."""

NODES_PER_RADIAN = 1.6
"""Nodes more for each radian by which sound across the panel turns from the middle of a band to its
end: the coefficients of exp(iτx) fall as Bessel functions J_n(τ) of rising order."""

WINDOW = 4.0
"""Width of the window about a band, in widths of the band: with the poles beyond it the
interpolation errs by (4 + √15)⁻¹² = 2·10⁻¹¹ of what they contribute."""

TAIL = 1e-7
"""Most of the last two coefficients of a polynomial, as a share of the largest value: of each row
of Y, and of the damping of the shapes in the window. On the wing of `wing.yaml` motions then err by
less than 1e-9."""

BANDS = (32, 64, 128, 256)
"""Lines that a band may have: the number that costs least is taken."""

AT_ONCE = 50e6
"""Bytes of the matrices of the air that are read together."""

SAMPLES = 12
"""Frequencies at which the added mass of each shape is looked at, to find where it resonates."""


@runtime_checkable
class SmoothStiffness(Protocol):
    """The stiffness of the air over frequency, with what tells how smooth it is."""

    @property
    def travel_time(self) -> float:
        """Longest time that sound takes across the panel [s]."""
        ...

    def __call__(self, frequency: Array) -> Complexes:
        """Return −ω²M_air + iωR (nf, n, n) [N/m]."""
        ...


@dataclass(frozen=True)
class _Band:
    """Polynomials of a band, by their values at the nodes."""

    # Of its lines [Hz]
    middle: float
    half_width: float
    near: Index
    far: Index
    stiffness: Complexes  # (m, n_w, n_w) Z_ww − Z_wo Y_w without the panel's own diagonal
    pushed: Complexes  # (m, n_w, nw) W_w − Z_wo Y_W
    # (m, n_o, n_w) Y_w and (m, n_o, nw) Y_W
    coupled: Complexes
    moved: Complexes


class PanelInAir:
    """Z₀⁻¹ on given lines, asked for a few lines at a time, in order.

    Parameters
    ----------
    frequency
        (nf,) rising [Hz].
    """

    def __init__(self, frequency: Array, basis: ModalBasis, air_stiffness: SmoothStiffness) -> None:
        self.frequency = frequency
        self.basis = basis
        self.air_stiffness = air_stiffness
        self._width = -1
        self._ends: list[tuple[int, int]] = []
        self._made: tuple[tuple[int, int], Array, list[tuple[int, int, _Band | None]]] | None = None

    def motion(self, frequency: Array, observed: Array) -> Complexes:
        """Return X = Z₀⁻¹ W on lines that follow one another among those of the class."""
        first = int(np.searchsorted(self.frequency, frequency[0]))
        last = first + frequency.size
        result = np.empty((frequency.size, *observed.shape), dtype=np.complex128)
        for start, stop in self._bands(observed.shape[1]):
            if start >= last or stop <= first:
                continue
            for low, high, band in self._polynomials((start, stop), observed):
                begin, end = max(low, first), min(high, last)
                if begin < end:
                    lines = self.frequency[begin:end]
                    result[begin - first : end - first] = (
                        self._solved(lines, observed)
                        if band is None
                        else self._read(band, lines, observed)
                    )
        return result

    def _solved(self, lines: Array, observed: Array) -> Complexes:
        """X line by line."""
        motion = np.empty((lines.size, *observed.shape), dtype=np.complex128)
        for line, stiffness in enumerate(self._stiffnesses(lines)):
            motion[line] = np.linalg.solve(stiffness, observed)
        return motion

    def _stiffnesses(self, frequency: Array) -> Iterator[Complexes]:
        """Z₀ (n, n) at one frequency [Hz] after the other."""
        index = np.arange(self.basis.natural_frequency.size)
        count = max(1, int(AT_ONCE / (16 * index.size**2)))
        for start in range(0, frequency.size, count):
            some = frequency[start : start + count]
            stiffness = self.air_stiffness(some)
            stiffness[:, index, index] += self.basis.dynamic_stiffness(some)
            yield from stiffness

    def _read(self, band: _Band, lines: Array, observed: Array) -> Complexes:
        """X from the polynomials of a band."""
        weights = interpolation((lines - band.middle) / band.half_width, band.pushed.shape[0])
        stiffness, pushed, coupled, moved = (
            _weighted(weights, values)
            for values in (band.stiffness, band.pushed, band.coupled, band.moved)
        )
        index = np.arange(band.near.size)
        stiffness[:, index, index] += self.basis.dynamic_stiffness(lines)[:, band.near]
        resonant = np.linalg.solve(stiffness, pushed)
        motion = np.empty((lines.size, *observed.shape), dtype=np.complex128)
        motion[:, band.near] = resonant
        motion[:, band.far] = moved - coupled @ resonant
        return motion

    def _polynomials(
        self, ends: tuple[int, int], observed: Array
    ) -> list[tuple[int, int, _Band | None]]:
        """Return the parts of a band with their polynomials; None where lines are solved."""
        if self._made is not None:
            last_ends, last_observed, parts = self._made
            if last_ends == ends and (
                last_observed is observed or np.array_equal(last_observed, observed)
            ):
                return parts
        parts = list(self._in_parts(*ends, observed))
        self._made = ends, observed, parts  # lines come in order: one band is enough
        return parts

    def _in_parts(
        self, start: int, stop: int, observed: Array
    ) -> list[tuple[int, int, _Band | None]]:
        if stop - start <= 2 * self._nodes(start, stop):
            return [(start, stop, None)]
        band = self._interpolated(start, stop, observed)
        if band is not None:
            return [(start, stop, band)]
        middle = (start + stop) // 2
        return [
            *self._in_parts(start, middle, observed),
            *self._in_parts(middle, stop, observed),
        ]

    def _interpolated(self, start: int, stop: int, observed: Array) -> _Band | None:
        """Return the polynomials of a band; None where they do not hold."""
        low, high = self.frequency[start], self.frequency[stop - 1]
        middle, half = (low + high) / 2, (high - low) / 2
        nodes = middle + half * unit_nodes(self._nodes(start, stop))
        inside = self._resonates(start, stop)
        near, far = np.flatnonzero(inside), np.flatnonzero(~inside)
        if 2 * far.size < inside.size:  # little is eliminated: halved, or line by line
            return None
        n_w, n_o, width = near.size, far.size, observed.shape[1]
        stiffness = np.empty((nodes.size, n_w, n_w), dtype=np.complex128)
        pushed = np.empty((nodes.size, n_w, width), dtype=np.complex128)
        eliminated = np.empty((nodes.size, n_o, n_w + width), dtype=np.complex128)
        diagonal = self.basis.dynamic_stiffness(nodes)[:, near]
        for node, whole in enumerate(self._stiffnesses(nodes)):
            across = whole[np.ix_(far, near)]
            right = np.concatenate([across, observed[far]], axis=1)
            eliminated[node] = np.linalg.solve(whole[np.ix_(far, far)], right)
            back = across.T @ eliminated[node]
            stiffness[node] = whole[np.ix_(near, near)] - np.diag(diagonal[node]) - back[:, :n_w]
            pushed[node] = observed[near] - back[:, n_w:]
        coupled, moved = eliminated[:, :, :n_w], eliminated[:, :, n_w:]
        column = np.max(np.abs(observed), axis=0, initial=0.0)
        unit = np.where(column > 0, column, 1.0)
        friction = np.abs(stiffness[nodes.size // 2].imag.diagonal()) + (
            2 * np.pi * nodes[nodes.size // 2] * self.basis.damping[near]
        )
        lost = np.sqrt(friction[:, None] * friction)
        holds = (
            np.all(np.abs(_tail(stiffness)) <= TAIL * lost)
            and _rows_hold(pushed / unit)
            and _rows_hold(moved / unit)
            and _rows_hold(coupled)
        )
        if not holds:
            return None
        return _Band(middle, half, near, far, stiffness, pushed, coupled, moved)

    def _bands(self, width: int) -> list[tuple[int, int]]:
        """Return the first line of each band and that after its last."""
        if width != self._width:
            self._width, self._ends, start = width, [], 0
            while start < self.frequency.size:
                stops = [min(start + lines, self.frequency.size) for lines in BANDS]
                stop = min(stops, key=lambda end: self._cost(start, end, width))
                self._ends.append((start, stop))
                start = stop
        return self._ends

    def _cost(self, start: int, stop: int, width: int) -> float:
        """Multiplications that a line of a band takes."""
        count, n = stop - start, self.basis.natural_frequency.size
        near = int(np.count_nonzero(self._resonates(start, stop)))
        far = n - near
        node = far**3 / 3 + far**2 * (near + width)
        line = near**3 / 3 + near**2 * width + far * near * width
        return self._nodes(start, stop) * node / count + line

    def _nodes(self, start: int, stop: int) -> int:
        """Chebyshev nodes of the band of some lines."""
        width = self.frequency[stop - 1] - self.frequency[start]
        turned = np.pi * width * self.air_stiffness.travel_time
        return NODES + int(np.ceil(NODES_PER_RADIAN * turned))

    def _resonates(self, start: int, stop: int) -> Flags:
        """Which shapes resonate within the window about some lines, (n,)."""
        low, high = self.frequency[start], self.frequency[stop - 1]
        margin = (WINDOW - 1) / 2 * (high - low)
        loaded = np.array(
            [
                np.interp(np.sqrt(low * high), self._sampled[0], masses)
                for masses in self._sampled[1].T
            ]
        )
        resonance = self.basis.natural_frequency / np.sqrt(np.maximum(loaded, 1e-3))
        return (resonance > low - margin) & (resonance < high + margin)

    @cached_property
    def _sampled(self) -> tuple[Array, Array]:
        """Frequencies (s,) [Hz] and the mass with air over the mass without it (s, n)."""
        lines = np.geomspace(self.frequency[0], self.frequency[-1], SAMPLES)
        mass = self.basis.modal_mass
        ratio = []
        for frequency in lines:
            (air,) = self.air_stiffness(np.array([frequency]))
            ratio.append(1 - air.diagonal().real / (2 * np.pi * frequency) ** 2 / mass)
        return lines, np.array(ratio)


def _rows_hold(values: Array | Complexes) -> bool:
    """Whether the last coefficients of values (m, rows, k) are small beside each row."""
    largest = np.max(np.abs(values), axis=(0, 2), initial=0.0)
    left = np.max(np.abs(_tail(values)), axis=(0, 2), initial=0.0)
    return bool(np.all(left <= TAIL * largest))


def _tail(values: Array | Complexes) -> Complexes:
    """Last two Chebyshev coefficients (2, …) of values (m, …) at the nodes."""
    return _weighted(last_coefficients(len(values)), values)


def _weighted(weights: Array, values: Array | Complexes) -> Complexes:
    """Return Σ_j weights_ij values_j, (k, …) of values (m, …): real products."""
    flat = (
        np.ascontiguousarray(values, dtype=np.complex128).reshape(len(values), -1).view(np.float64)
    )
    summed: Complexes = (weights @ flat).view(np.complex128)
    return summed.reshape(len(weights), *values.shape[1:])
