"""Polynomials through Chebyshev nodes of the first kind."""

import numpy as np

from pidpanel.arrays import Array


def unit_nodes(count: int) -> Array:
    """Return the Chebyshev nodes of the first kind on [−1, 1], (count,) falling."""
    nodes: Array = np.cos(_angles(count))
    return nodes


def interpolation(x: Array, count: int) -> Array:
    """Return the matrix (x.size, count) from values at the nodes to values at x in [−1, 1].

    Barycentric, with weights (−1)^j sin((2j + 1)π/(2·count)) (Berrut and Trefethen 2004, Eq. 5.3).
    """
    distance = x[:, None] - unit_nodes(count)
    at_node = distance == 0
    distance[at_node] = 1.0
    matrix: Array = (-1.0) ** np.arange(count) * np.sin(_angles(count)) / distance
    matrix /= matrix.sum(axis=1, keepdims=True)
    on_node = at_node.any(axis=1)
    matrix[on_node] = at_node[on_node]
    return matrix


def _angles(count: int) -> Array:
    return np.pi * (2 * np.arange(count) + 1) / (2 * count)
