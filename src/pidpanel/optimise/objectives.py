"""Objectives of a search: mean squares of motions at points, summed in groups.

The search bounds mean squares of anything linear in the motion. `accelerations` are those of w,
`oscillators` weigh them with the gain of an oscillator on the point, and `stresses` are the three
parts of the von Mises stress σᵀV σ = |Cᵀσ|², V = C Cᵀ, in each layer.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.optimise.reduced_panel import Outputs
from pidpanel.severity.oscillators import gain
from pidpanel.solve.lines import trapezoid_weights
from pidpanel.solve.model import PanelResponse
from pidpanel.solve.stress import VON_MISES, Layers

PLACES = 24  # vertices that represent the panel, besides the response points


@dataclass(frozen=True)
class Objective:
    """Groups of outputs, the largest of which is minimised; an output is a row with a weight."""

    # (n_rows,) point of each row, and (n_rows, m) shares of the m motions there
    point: Index
    motion: Array
    # (n_outputs,) row and group of each output
    row: Index
    group: Index
    factor: Callable[[Array], Array]  # frequency (nf,) → (nf, n_outputs) on the PSDs of the rows
    # Factor from the root of a mean square to the stated value, and its unit
    scale: float = 1 / STANDARD_GRAVITY
    unit: str = "g rms"

    def outputs(self, frequency: Array) -> Outputs:
        """Return rows, weights and groups on some lines."""
        weight = trapezoid_weights(frequency)[:, None] * self.factor(frequency)
        groups = self.group[:, None] == np.arange(self.group.max() + 1)
        return Outputs(self.row, weight, groups.astype(float))

    def rows(self, motion_at_points: Array) -> Array:
        """Return (n_rows, n) from the motions of the shapes at all points (n_points, m, n)."""
        return np.einsum("rm,rmn->rn", self.motion, motion_at_points[self.point])

    def mean_square(self, response: PanelResponse) -> Array:
        """Return (n_groups,) of a response at all points."""
        return self.outputs(response.frequency).mean_square(self._psd(response))

    def _psd(self, response: PanelResponse) -> Array:
        """Return the PSDs (nf, n_rows)."""
        cross = response.cross_psd[:, self.point]
        return np.einsum("ra,frab,rb->fr", self.motion, cross.real, self.motion)

    def log_error(self, response: PanelResponse, log_rms_error: Array) -> float:
        """Return the standard error of ln of the root of the largest group.

        Parameters
        ----------
        log_rms_error
            (n_points,) standard error of ln of the rms acceleration, common to all points.
        """
        outputs, psd = self.outputs(response.frequency), self._psd(response)
        parts = np.sum(psd[:, self.row] * outputs.weight, axis=0)[:, None] * outputs.groups
        largest = parts[:, np.argmax(parts.sum(axis=0))]
        return float(largest @ log_rms_error[self.point[self.row]] / largest.sum())


def accelerations(points: Index, *, is_largest: bool = True) -> Objective:
    """Return the mean squares of the acceleration at points, or the mean of these."""
    index, ones = np.arange(points.size), np.ones((points.size, 1))
    group, share = (index, 1.0) if is_largest else (np.zeros_like(index), 1 / points.size)

    def factor(frequency: Array) -> Array:
        return np.repeat((share * (2 * np.pi * frequency) ** 4)[:, None], points.size, axis=1)

    return Objective(points, ones, index, group, factor)


def oscillators(points: Index, natural: Array, quality: float) -> Objective:
    """Return the mean squares of oscillators on points, of natural frequencies [Hz] and a Q."""

    def factor(frequency: Array) -> Array:
        gains = np.stack([gain(frequency / f_n, quality) for f_n in natural], axis=1)
        return np.tile((2 * np.pi * frequency[:, None]) ** 4 * gains, points.size)

    row = np.repeat(np.arange(points.size), natural.size)
    return Objective(points, np.ones((points.size, 1)), row, np.arange(row.size), factor)


def stresses(points: Index, layers: Layers, motions: int) -> Objective:
    """Return the mean squares of the von Mises stress at points, in each layer; stated as 3σ."""
    parts = np.linalg.cholesky(VON_MISES).T @ layers.stress  # (n_layers, 3, 3)
    count = parts.shape[0] * 3
    motion = np.zeros((points.size * count, motions))
    # of the motions w, κ_xx, κ_yy, κ_xy, …, γ_xz, γ_yz at a point
    columns = slice(1, 1 + parts.shape[2])
    motion[:, columns] = np.tile(parts.reshape(count, -1), (points.size, 1))
    rows = np.arange(points.size * count)

    def factor(frequency: Array) -> Array:
        return np.ones((frequency.size, rows.size))

    point = np.repeat(points, count)
    return Objective(point, motion, rows, rows // 3, factor, scale=3e-6, unit="MPa")


def spread_vertices(position: Array, count: int = PLACES) -> Index:
    """Return vertices (count,), each as far as possible from those before it.

    Examples
    --------
    >>> spread_vertices(np.array([[0.0, 0], [0.1, 0], [1, 0], [0.5, 0]]), 3).tolist()
    [0, 2, 3]
    """
    chosen = [0]
    distance = np.full(len(position), np.inf)
    while len(chosen) < min(count, len(position)):
        distance = np.minimum(distance, np.linalg.norm(position - position[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(distance)))
    return np.array(chosen)
