"""The panel seen from its points and from a few motions of each place.

Any layout is attached as in `solve.receptances`, with the motions of each place cut to those with
the most energy. With the dampers of a layout T on, motions and PSDs of all others are

    R' = R − A R_T·,    S' = S − A Yᴴ − Y Aᴴ,    A = R_·T s (I + R_TT s)⁻¹,    Y = S_·T − A S_TT/2,

and a further damper costs a solve of a few motions a line: all additions to T are had at once.
Under several excitations such panels stand side by side (`JointPanel`).
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.excitation import Excitation, MatrixInput, mixed_product
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.modal import chunks_of_lines
from pidpanel.solve.model import ModalBasis, Patches, ResponseError
from pidpanel.solve.moved_panel import MovedPanel, coupled_shapes
from pidpanel.solve.receptances import Receptances

THREADS = 2
LINES_AT_ONCE = 16
LARGEST = 1e9  # bytes of receptances and PSDs of the bare panel
CACHE = 4e8  # bytes of those between all motions and places that were used last


@dataclass(frozen=True)
class Additions:
    """A layout with each of several further dampers."""

    mean_square: Array  # (n_options, n_points) of the acceleration [m²/s⁴]
    patch_mean_square: Array  # (n_options,) mean over the patch of the further damper


class Outputs(NamedTuple):
    """Outputs of the objective from the PSDs of some rows, on some lines."""

    row: Index  # (n_outputs,) row of each output
    weight: Array  # (nf, n_outputs) with which PSDs of the rows sum to mean squares
    groups: Array  # (n_outputs, n_groups) 1 where an output belongs to a group

    def mean_square(self, psd: Array) -> Array:
        """Return (…, n_groups) from the PSDs (nf, …, n_rows) of the rows."""
        rows = np.einsum("f...o,fo->...o", psd[..., self.row], self.weight)
        return np.asarray(rows @ self.groups)


class ReducedPanel:
    """Receptances and PSDs between the points and the motions of all places.

    Columns of both are computed as a place is first used. On the lines ``frequency`` (nf,) [Hz],
    PSDs of w times ``weight`` sum to mean squares of the acceleration at ``points``.
    The places are the patches of the panel.

    Parameters
    ----------
    points
        (n_rows, n) w of the shapes at the points, or other motions of the objective.
    outputs
        Outputs of the objective from these motions; None for the acceleration at each.
    rank
        Motions of each place, those with the most energy on the bare panel; None for all.
    precision
        Type of the stored numbers.

    Raises
    ------
    ResponseError
        If it takes more than `LARGEST` bytes.
    """

    def __init__(
        self,
        frequency: Array,
        basis: ModalBasis,
        patches: Patches,
        points: Array,
        excitation: Excitation,
        air: MatrixInput | None = None,
        *,
        outputs: Outputs | None = None,
        rank: int | None = None,
        precision: type = np.complex64,
    ) -> None:
        rows = len(points)
        self.frequency, self.weight = frequency, acceleration_weight(frequency)
        self.area = patches.area
        factors = patches.factors(1e-12)
        largest = max(factor.shape[1] for factor in factors)
        self.rank = min(rank or largest, largest)
        width = rows + self.rank * patches.count
        self._is_direct = width <= patches.shapes
        self._capacity = self._allocate(width, patches, in_air=air is not None, precision=precision)
        chunks = chunks_of_lines(frequency.size, patches.shapes)
        energy = np.zeros(2 * (patches.shapes,))
        for lines in chunks:
            _, psd = bare_psd(frequency[lines], basis, excitation, air)
            energy += np.einsum("f,fij->ij", self.weight[lines], psd.real)
        leading = [_leading(factor, energy, self.rank) for factor in factors]
        observed = np.hstack([points.T, *leading])
        for lines in chunks:
            receptance, psd = bare_psd(frequency[lines], basis, excitation, air)
            if self._is_direct:
                pulled = receptance * observed if air is None else receptance @ observed
                receptance = mixed_product(observed.T, pulled)
                psd = mixed_product(observed.T, mixed_product(psd, observed))
            self._receptance[lines], self._psd[lines] = receptance, psd
        self._observed = observed.astype(self._psd.real.dtype)
        self._outputs = outputs or Outputs(
            np.arange(rows), np.repeat(self.weight[:, None], rows, axis=1), np.eye(rows)
        )
        self.points, self._rows = self._outputs.groups.shape[1], rows
        self._index = np.arange(rows, width).reshape(patches.count, self.rank)
        self._columns: dict[int, tuple[Complexes, Complexes]] = {}
        self._bare = self._without_dampers()

    def _allocate(self, width: int, patches: Patches, *, in_air: bool, precision: type) -> int:
        """Allocate R and S, and return how many places have their columns kept."""
        count, n, rows = self.frequency.size, patches.shapes, width - self.rank * patches.count
        item = np.dtype(precision).itemsize
        # among all motions, or those of the shapes where they are fewer: in vacuum R is diagonal
        side = min(width, n)
        in_full = self._is_direct or in_air
        square = side**2 * (2 if in_full else 1)
        size = float(count * item * (square + 2 * (width - rows) * (self.rank + rows)))
        if size > LARGEST:
            raise ResponseError(
                f"{patches.count} places and {n} shapes take {size / 1e9:.1f} GB on {count} lines; "
                f"allowed are {LARGEST / 1e9:g} GB: a larger optimise.spacing_m, or a narrower "
                "response.frequency_hz"
            )
        self._receptance: Complexes = np.empty((count, side, side if in_full else 1), precision)
        self._psd: Complexes = np.empty((count, side, side), precision)
        return max(2, int(CACHE / (2 * count * width * self.rank * item)))

    def _without_dampers(self) -> _State:
        """Return the points and the motions of each place without dampers."""
        rows, (n, r) = self._rows, self._index.shape
        blocks = [self._block(index, index) for index in self._index]
        receptance, psd = (np.stack(part, axis=1) for part in zip(*blocks, strict=True))
        R, S = self._block(slice(None), np.arange(rows))
        points = S[:, np.arange(rows), np.arange(rows)].real.astype(np.float64)
        R, S = (part[:, rows:].reshape(-1, n, r, rows) for part in (R, S))
        return _State(receptance, psd, R, S.conj().swapaxes(2, 3), points)

    def _block(self, rows: Index | slice, columns: Index) -> tuple[Complexes, Complexes]:
        """Return R and S between some motions."""
        if self._is_direct:
            return self._receptance[:, :, columns][:, rows], self._psd[:, :, columns][:, rows]
        observed, pulled = self._observed[:, rows].T, self._observed[:, columns]
        is_diagonal = self._receptance.shape[2] == 1
        motion = self._receptance * pulled if is_diagonal else self._receptance @ pulled
        return mixed_product(observed, motion), mixed_product(observed, self._psd @ pulled)

    def _of_places(self, places: Sequence[int]) -> tuple[Complexes, Complexes]:
        """Return R and S (nf, nw, k rank) of all motions with those of some places."""
        columns = []
        for place in places:
            column = self._columns.pop(place, None)  # the last used come last
            if column is None:
                if len(self._columns) >= self._capacity:
                    self._columns.pop(next(iter(self._columns)))
                column = self._block(slice(None), self._index[place])
            self._columns[place] = column
            columns.append(column)
        receptance, psd = zip(*columns, strict=True)
        return np.concatenate(receptance, axis=2), np.concatenate(psd, axis=2)

    def clear(self) -> None:
        """Drop the columns of the places used last; they are computed again once needed."""
        self._columns.clear()

    @property
    def bare(self) -> Array:
        """(n_points,) mean squares of the objective without dampers, such as [m²/s⁴]."""
        return self._outputs.mean_square(self._bare.points)

    def additions(
        self, places: Sequence[int], stiffness: Complexes, further: Index, added: Complexes
    ) -> Additions:
        """Return a layout on places (k,) with each of several further dampers, on (n_options,).

        Dampers have s = iω C_e − ω² m_a [N/m³], (k, nf) and (n_options, nf).
        """
        columns = self._of_places(places) if len(places) else None
        motions = self._index[list(places)].ravel()
        repeated = np.repeat(stiffness, self.rank, axis=0)

        def part(lines: slice) -> tuple[Array, Array]:
            state = self._bare.on_lines(lines)
            if columns is not None:
                R, S = (values[lines] for values in columns)
                panel = Receptances(R[:, motions], R, S[:, motions], S)
                state = self._loaded(state, panel, repeated[:, lines].T)
            outputs = self._outputs._replace(weight=self._outputs.weight[lines])
            return _added(state, further, added[:, lines].T, self.weight[lines], outputs)

        count = self.frequency.size
        chunks = [slice(i, min(i + LINES_AT_ONCE, count)) for i in range(0, count, LINES_AT_ONCE)]
        with ThreadPoolExecutor(THREADS) as pool:
            parts = list(pool.map(part, chunks))
        square = sum(square for square, _ in parts)
        patch = sum(patch for _, patch in parts) / self.area[further]
        return Additions(np.asarray(square), np.asarray(patch))

    def _loaded(self, bare: _State, panel: Receptances, stiffness: Complexes) -> _State:
        """Return the same with dampers s (nl, t) on the motions that a panel feels."""
        m, (n, r) = self._rows, self._index.shape
        _, _, A, Y = panel.reaction(stiffness)
        A_place, Y_place, R_place = (
            x[:, m:].reshape(len(x), n, r, -1) for x in (A, Y, panel.across)
        )
        drop = A_place @ Y_place.conj().swapaxes(2, 3)
        to_points = A_place @ panel.across[:, None, :m].swapaxes(2, 3)  # R is symmetric
        with_points = A[:, None, :m] @ Y_place.conj().swapaxes(2, 3) + Y[
            :, None, :m
        ] @ A_place.conj().swapaxes(2, 3)
        return _State(
            bare.receptance - A_place @ R_place.swapaxes(2, 3),
            bare.psd - drop - drop.conj().swapaxes(2, 3),
            bare.to_points - to_points,
            bare.with_points - with_points,
            bare.points - 2 * np.sum(A[:, :m] * Y[:, :m].conj(), axis=2).real,
        )


class _State(NamedTuple):
    """A layout on some lines.

    R and S (nl, n_places, r, r) of each place, R (nl, n_places, r, m) and S (nl, n_places, m, r)
    between it and the points, S (nl, m) of the points.
    """

    receptance: Complexes
    psd: Complexes
    to_points: Complexes
    with_points: Complexes
    points: Any

    def on_lines(self, lines: slice) -> _State:
        """Return the same on some lines."""
        return _State(*(part[lines] for part in self))


def _added(
    state: _State, further: Index, stiffness: Complexes, weight: Array, outputs: Outputs
) -> tuple[Array, Array]:
    """Return mean squares (n_options, n_points) of the points and (n_options,) of the patches."""
    r = state.receptance.shape[2]
    s = stiffness[:, :, None, None]
    loop = s * state.receptance[:, further]
    loop[:, :, range(r), range(r)] += 1
    follows = np.linalg.inv(loop)  # (I + s R)⁻¹, symmetric as R is
    B = s * (follows @ state.to_points[:, further]).swapaxes(2, 3)
    S = state.psd[:, further]
    half = state.with_points[:, further] - B @ S / 2
    psd = state.points[:, None] - 2 * np.sum(B * half.conj(), axis=3).real
    # Σ_ij (F S)_ij F*_ij: the mean square of u over the patch
    moved = np.sum((follows @ S) * follows.conj(), axis=(2, 3)).real
    return outputs.mean_square(psd), weight @ moved


def bare_psd(
    frequency: Array, basis: ModalBasis, excitation: Excitation, air: MatrixInput | None
) -> tuple[Complexes, Complexes]:
    """Return Z₀⁻¹ of the bare panel (nf, n, n), in vacuum its diagonal (nf, n, 1), and S_q."""
    moved = MovedPanel(frequency, basis, coupled_shapes(air, frequency, basis), [None])
    force = excitation.spectrum(frequency)[:, None, None] * excitation(frequency)
    receptance = moved.transfer if air is None else moved.motion(0)
    return receptance, moved.psds(0, [0], force)[0]


def acceleration_weight(frequency: Array) -> Array:
    """Return weights (nf,) with which PSDs of w sum to mean squares of the acceleration."""
    return trapezoid_weights(frequency) * (2 * np.pi * frequency) ** 4


def _leading(factor: Array, energy: Array, rank: int) -> Array:
    """Return E (n, rank) of U with D = U Uᵀ, the motions with the most energy; padded with none."""
    _, vector = np.linalg.eigh(factor.T @ energy @ factor)
    columns = factor @ vector[:, ::-1][:, :rank]
    return np.pad(columns, ((0, 0), (0, rank - columns.shape[1])))


@dataclass(frozen=True)
class JointPanel:
    """A panel under one excitation or several.

    The stiffness s of a damper has a column for each line of all parts: its damping follows the
    motion under each excitation. Of several parts mean squares are shares of the largest of the
    bare panel under the same excitation. The largest share is then that of the smallest reduction.
    """

    parts: tuple[ReducedPanel, ...]  # the panel under each excitation, with the same places

    @cached_property
    def frequency(self) -> Array:
        """(nf,) lines of all parts [Hz]."""
        return np.concatenate([part.frequency for part in self.parts])

    @property
    def area(self) -> Array:
        """(n_places,) [m²]."""
        return self.parts[0].area

    @property
    def points(self) -> int:
        """Number of mean squares of the objective."""
        return sum(part.points for part in self.parts)

    @cached_property
    def _scale(self) -> list[float]:
        if len(self.parts) == 1:
            return [1.0]
        return [1 / float(part.bare.max()) for part in self.parts]

    @cached_property
    def bare(self) -> Array:
        """(n_points,) mean squares without dampers."""
        scaled = zip(self.parts, self._scale, strict=True)
        return np.concatenate([scale * part.bare for part, scale in scaled])

    def mean_square(
        self, places: Sequence[int], stiffness: Complexes, further: Index, added: Complexes
    ) -> Array:
        """Return mean squares (n_options, n_points) of a layout with each of further dampers.

        Parameters are those of `ReducedPanel.additions`, on the lines of all parts.
        """
        edges = np.cumsum([part.frequency.size for part in self.parts])[:-1]
        on_parts = (np.split(values, edges, axis=1) for values in (stiffness, added))
        squares = [
            scale * part.additions(places, s, further, s_added).mean_square
            for part, scale, s, s_added in zip(self.parts, self._scale, *on_parts, strict=True)
        ]
        return np.concatenate(squares, axis=1)
