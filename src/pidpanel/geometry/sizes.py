"""Diameters of particles: their distribution in a study, and samples for a packing.

The code of this module enters the label of every packing and bed; see `pidpanel.coupon.packing`.
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class Sizes:
    """Distribution of the diameters of the spheres by number."""

    # ``mono``, ``normal``, ``uniform`` or ``binary``. ``normal`` has its mean in the middle and its
    # standard deviation a quarter of the range, at whose ends it is cut.
    kind: str
    # Diameters [m]
    smallest: float
    largest: float
    # Share by number of the larger spheres among the two sizes of ``binary`` [1]
    large_share: float = 0.0

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        """Draw diameters, (count,) [m]."""
        low, high = self.smallest, self.largest
        if self.kind == "mono":
            return np.full(count, low)
        if self.kind == "uniform":
            return rng.uniform(low, high, count)
        if self.kind == "binary":
            return np.where(rng.random(count) < self.large_share, high, low)
        accepted = np.empty(0)
        while len(accepted) < count:
            drawn = rng.normal((low + high) / 2, (high - low) / 4, count)
            accepted = np.concatenate([accepted, drawn[(drawn >= low) & (drawn <= high)]])
        return accepted[:count]
