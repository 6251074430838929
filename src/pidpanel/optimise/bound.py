"""Largest reduction by further dampers, bounded by the sum of their individual reductions.

For a limited number of dampers on different groups of places with a total mass M, it is bounded
for any price μ ≥ 0 of mass by Lagrange's relaxation:

    Σ gain ≤ μ M + Σ over the best groups of max over their dampers (gain − μ mass)₊.
"""

import numpy as np

from pidpanel.arrays import Array, Flags, Index

PRICES = 12  # prices of mass that are tried, besides 0


def weights_of_points(points: int) -> Array:
    """Return weights (k, n_points) whose means bound the objective from below.

    The largest of some values is at least any mean of them: each alone, pairs, and all.
    """
    every = np.full((1, points), 1 / points)
    if points == 1:
        return every
    single = np.eye(points)
    first, second = np.triu_indices(points, 1)
    mixed = [share * single[first] + (1 - share) * single[second] for share in (0.25, 0.5, 0.75)]
    return np.concatenate([every, single, *mixed])


class PriceOfMass:
    """The relaxation over some prices.

    Each damper removes ``gain`` (n_options, k) for k weights and has a mass (n_options,) [kg]. A
    layout has at most ``count`` dampers, and one of a ``group`` (n_options,), its place.
    """

    def __init__(self, gain: Array, mass: Array, group: Index, count: int) -> None:
        self._order = np.argsort(group, kind="stable")
        sorted_group = group[self._order]
        self._starts = np.flatnonzero(np.r_[True, sorted_group[1:] != sorted_group[:-1]])
        self._count = count
        steepest = float((gain.max(axis=1) / mass).max(initial=0.0))
        self._prices = steepest * np.concatenate([[0.0], np.geomspace(1e-3, 1, PRICES)])
        net = gain[:, :, None] - mass[:, None, None] * self._prices
        self._net = np.maximum(net, 0)[self._order]  # (n_options, k, n_prices)

    def most(self, allowed: Flags, mass: float) -> Array:
        """Return (k,) the most that allowed dampers within a mass [kg] can remove."""
        net = np.where(allowed[self._order, None, None], self._net, 0)
        groups = np.maximum.reduceat(net, self._starts, axis=0)
        count = min(self._count, len(groups))
        largest = np.partition(groups, len(groups) - count, axis=0)[len(groups) - count :]
        return np.asarray((self._prices * mass + largest.sum(axis=0)).min(axis=1))
