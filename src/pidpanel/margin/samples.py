"""Sobol' samples of inputs with spreads, in groups that are independent of each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.stats import norm, qmc

from pidpanel.arrays import Array
from pidpanel.constants import REACH

SEED = 50  # of the scrambling: the same study has the same samples
KEPT = 0.98  # share of the variance of a field that its leading directions keep
# Levels and dampers of each panel: its modes, air and receptances, most of the cost, serve all.
DRAWS = 2


class Group(NamedTuple):
    """Inputs that vary together, as a number of independent standard normal scores."""

    name: str
    source: str
    # (n_inputs, n_scores) inputs, as standard normal scores or in their unit, over the scores
    mixing: Array
    changes_panel: bool = False  # whether another panel, or other air, has to be solved

    @property
    def size(self) -> int:
        """Number of scores."""
        return self.mixing.shape[1]


def leading(covariance: Array, share: float = KEPT) -> Array:
    """Return L (n, r) with covariance ≈ L Lᵀ: the directions with most of the variance.

    Examples
    --------
    >>> leading(np.array([[4.0, 2.0], [2.0, 1.0]])).round(12).tolist()
    [[2.0], [1.0]]
    """
    value, vector = np.linalg.eigh(covariance)
    value, vector = np.maximum(value[::-1], 0.0), vector[:, ::-1]
    total = max(value.sum(), 1e-300)
    count = int(np.searchsorted(np.cumsum(value), share * total)) + 1
    mixing = vector[:, :count] * np.sqrt(value[:count])
    return np.asarray(mixing * np.where(mixing.sum(axis=0) < 0, -1.0, 1.0))


def joined_keys(correlation: Array) -> list[list[int]]:
    """Return the sets of inputs (n, n) that are correlated with each other, directly or not.

    Examples
    --------
    >>> joined_keys(np.array([[1.0, 0.0, 0.5], [0.0, 1.0, 0.0], [0.5, 0.0, 1.0]]))
    [[0, 2], [1]]
    """
    from scipy.sparse.csgraph import connected_components

    count, label = connected_components(correlation != 0, directed=False)
    return [np.flatnonzero(label == number).tolist() for number in range(count)]


def scores(groups: Sequence[Group], runs: int) -> Array:
    """Return Sobol' samples of the scores (runs, n), an even number; more runs continue fewer.

    `DRAWS` runs after one another have the same panel.
    """
    panel_scores = np.repeat(
        [group.changes_panel for group in groups], [group.size for group in groups]
    )
    panels, size = runs // DRAWS, int(np.sum(panel_scores))
    sampler = qmc.Sobol(
        size + DRAWS * (panel_scores.size - size), scramble=True, rng=np.random.default_rng(SEED)
    )
    points = np.clip(norm.ppf(sampler.random(panels)), -REACH, REACH)
    samples = np.empty((panels, DRAWS, panel_scores.size))
    samples[:, :, panel_scores] = points[:, None, :size]
    samples[:, :, ~panel_scores] = points[:, size:].reshape(panels, DRAWS, -1)
    return samples.reshape(-1, panel_scores.size)


def columns_of(groups: Sequence[Group]) -> list[slice]:
    """Return the scores of each group."""
    ends = np.cumsum([0, *(group.size for group in groups)]).tolist()
    return [slice(start, end) for start, end in pairwise(ends)]
