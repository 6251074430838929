"""Boundary elements in space for a free rectangle, with no line in common with `pidpanel.sound`.

The jump is bilinear on equal rectangles. With G = exp(ikR)/4πR the operator is ∬ G (∇μ·∇ν − k² μ ν),
and an entry depends on the offset of two hats alone: their correlations are cubic splines.
"""

import itertools

import numpy as np

BY_ELEMENTS = 0.270163 + 0.0093182j
"""Z of mode (1, 1) of 1.5 m × 1 m at 64.90 Hz [m³]: squares of 1/10, 1/20, 1/40 m, extrapolated."""


def spline(x):
    a = np.abs(x)
    return np.where(a < 1, 2 / 3 - a**2 + a**3 / 2, np.where(a < 2, (2 - a) ** 3 / 6, 0))


def curvature(x):
    a = np.abs(x)
    return np.where(a < 1, -2 + 3 * a, np.where(a < 2, 2 - a, 0))


def cell_points(cell, edges):
    """Places (x, y) and weights of a quadrature over a cell, by its number along x and y."""
    near = all(number in (-1, 0) for number in cell)
    node, weight = np.polynomial.legendre.leggauss(12 if near else 6)
    t, w = (1 + node) / 2, np.outer(weight, weight) / 4
    r, s = np.meshgrid(t, t, indexing="ij")
    if near:  # polar in the corner at the pole, where 1/R drops out
        x, y, w = np.concatenate([r, r * s]), np.concatenate([r * s, r]), np.tile(w * r, (2, 1))
        x, y = (np.where(number < 0, -a, a) for number, a in zip(cell, (x, y), strict=True))
    else:
        x, y = cell[0] + r, cell[1] + s
    return x.ravel() * edges[0], y.ravel() * edges[1], w.ravel() * edges[0] * edges[1]


def impedance(sides, counts, k, mode):
    """Z [m³] of a mode of sines."""
    edges = [side / count for side, count in zip(sides, counts, strict=True)]
    table = entries(edges, counts, k)
    apart = [np.abs(np.subtract.outer(np.arange(n), np.arange(n))) for n in table.shape]
    operator = table[apart[0][:, None, :, None], apart[1][None, :, None, :]]
    loads = []
    for side, count, edge, m in zip(sides, counts, edges, mode, strict=True):
        turn = m * np.pi / side
        hat = edge * (np.sin(turn * edge / 2) / (turn * edge / 2)) ** 2
        loads.append(np.sin(turn * edge * np.arange(1, count)) * hat)
    load = np.outer(*loads).ravel()
    return load @ np.linalg.solve(operator.reshape(load.size, -1), load)


def entries(edges, counts, k):
    """Operator over the offset of two hats, cell by cell of their correlations."""
    table = np.zeros([count - 1 for count in counts], complex)
    for cell in itertools.product(*(range(-2, count) for count in counts)):
        x, y, weight = cell_points(cell, edges)
        R = np.hypot(x, y)
        kernel = weight * np.exp(1j * k * R) / (4 * np.pi * R)
        i, j = (
            np.arange(max(c - 1, 0), min(c + 3, n)) for c, n in zip(cell, table.shape, strict=True)
        )
        u, v = x / edges[0] - i[:, None], y / edges[1] - j[:, None]
        flat = spline(u) * kernel
        bent = curvature(u) * kernel / edges[0] ** 2
        form = -(k**2 * flat + bent) @ spline(v).T - flat @ curvature(v).T / edges[1] ** 2
        table[np.ix_(i, j)] += edges[0] * edges[1] * form
    return table


def impedance_without(removed, sides, counts, k, shapes):
    """Z [m³] of shapes (x, y) on a rectangle without a box of cells."""
    edges = [side / count for side, count in zip(sides, counts, strict=True)]
    table = entries(edges, counts, k)
    place = np.indices([n - 1 for n in counts]).reshape(2, -1).T + 1
    low, high = (np.round(np.divide(corner, edges)).astype(int) for corner in removed)
    place = place[~np.all((place >= low) & (place <= high), axis=1)]
    apart = np.abs(place[:, None] - place)
    operator = table[apart[..., 0], apart[..., 1]]
    node, weight = np.polynomial.legendre.leggauss(4)
    offset = np.concatenate([(node - 1) / 2, (node + 1) / 2])
    share = np.tile(weight / 2, 2) * (1 - np.abs(offset))
    x, y = ((place[:, i, None] + offset) * edges[i] for i in (0, 1))
    values = [shape(x[:, :, None], y[:, None, :]) for shape in shapes]
    load = np.array([edges[0] * edges[1] * (share @ value @ share) for value in values])
    return np.diagonal(load @ np.linalg.solve(operator, load.T))


def extrapolated(sides, counts, k, mode):
    """Z of elements of no size: those of one, a half and a quarter, in powers of h and h²."""
    return limit([impedance(sides, [n * c for c in counts], k, mode) for n in (1, 2, 4)])


def limit(found):
    """Value of elements of no size."""
    one, two, four = found
    first, second = 2 * two - one, 2 * four - two
    return second + (second - first) / 3
