"""Spread subset of very many cases, so that a surface of any sweep takes bounded time.

A Gaussian process takes memory with the square and time with the cube of its cases. Of more than
`MOST_CASES` those enter that are farthest from the ones before (Gonzalez, *Theoretical Computer
Science* 38, 293 (1985)): the ends of the sweep first, then ever finer, so that no case is farther
from one that entered than twice what the best choice of as many could give. A case that enters is
as it was run, with its own error; what a surface states as its error is at no point less than the
scatter of cases, however many there are, so that those left out would narrow it little.
"""

import numpy as np

from pidpanel.arrays import Array, Index

MOST_CASES = 600  # cases of a surface at most: `paper.yaml` has 90 of them, `paper_full.yaml` 2955


def spread_out(points: Array, limit: int) -> Index:
    """Return the numbers, in order, of points that are spread over all of them.

    Examples
    --------
    >>> spread_out(np.array([[0.0], [1.0], [2.1], [3.0], [4.0]]), 3)
    array([0, 2, 4])
    """
    if len(points) <= limit:
        return np.arange(len(points))
    # the farthest from the middle, the first of several: the same on every machine
    chosen = [int(np.argmax(_square(points, points.mean(axis=0)).round(9)))]
    nearest = np.full(len(points), np.inf)
    while len(chosen) < limit:
        nearest = np.minimum(nearest, _square(points, points[chosen[-1]]))
        chosen.append(int(np.argmax(nearest.round(9))))
    return np.sort(np.array(chosen))


def _square(points: Array, point: Array) -> Array:
    return np.asarray(((points - point) ** 2).sum(axis=1))
