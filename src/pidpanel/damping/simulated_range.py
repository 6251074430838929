"""Range of simulated cases: their convex hull in r, ln f and ln Γ."""

import numpy as np
from scipy.spatial import ConvexHull

from pidpanel.arrays import Array, Flags


class SimulatedRange:
    """The convex hull of cases, (n, 3) of r, f [Hz] and Γ, and their extreme values (3,)."""

    def __init__(self, cases: Array) -> None:
        self.low, self.high = cases.min(axis=0), cases.max(axis=0)
        points = _logarithmic(cases)
        # axes along which the cases spread
        self._spread: Flags = np.ptp(points, axis=0) > 1e-9
        spread = points[:, self._spread]
        dimensions = spread.shape[1]
        if dimensions < 2:  # the lowest and highest value are all there is to a hull
            self._normals, self._offsets = np.zeros((1, dimensions)), np.full(1, -1.0)
            return
        # joggled, so that cases in one plane have a hull (of no volume) and no error
        flat = np.linalg.matrix_rank(spread - spread[0], tol=1e-6) < dimensions
        hull = ConvexHull(spread, qhull_options="QJ" if flat else "")
        self._normals, self._offsets = hull.equations[:, :-1], hull.equations[:, -1]

    def contains(self, points: Array) -> Flags:
        """Return (n,) whether points (n, 3) of r, f, Γ are in the hull."""
        in_bounds = np.all(
            (points >= self.low * (1 - 1e-9)) & (points <= self.high * (1 + 1e-9)), axis=1
        )
        away = _logarithmic(points)[:, self._spread] @ self._normals.T + self._offsets
        return in_bounds & (away <= 1e-6).all(axis=1)


def _logarithmic(points: Array) -> Array:
    """Return (n, 3) r, f, Γ → r, ln f, ln Γ."""
    return np.stack([points[:, 0], np.log(points[:, 1]), np.log(points[:, 2])], axis=1)
