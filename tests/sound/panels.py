"""Points and shapes of faces that move."""

import numpy as np
import skfem

from pidpanel.geometry.plane_waves import PanelQuadrature

SIDES = (1.5, 1.0)


def gauss_points(elements, order=3, sides=SIDES):
    """Gauss points on a grid of elements, ``order`` to an edge, and their weights."""
    node, weight = np.polynomial.legendre.leggauss(order)
    axes = []
    for side, count in zip(sides, elements, strict=True):
        edge = side / count
        place = ((np.arange(count)[:, None] + 0.5 + node / 2) * edge).ravel()
        axes.append((place, np.tile(weight * edge / 2, count)))
    x, y = (axis.ravel() for axis in np.meshgrid(axes[0][0], axes[1][0], indexing="ij"))
    return np.stack([x, y], axis=1), np.outer(axes[0][1], axes[1][1]).ravel()


def sine_panel(modes, elements=(30, 20), order=3):
    """Products of sines on the paper's panel; by default on the load quadrature of its mesh."""
    position, weight = gauss_points(elements, order)
    return PanelQuadrature(position, weight, sines(position, modes))


def sines(position, modes):
    """(points, modes) products of sines at points of the paper's panel."""
    x, y = position.T
    return np.stack(
        [np.sin(m * np.pi * x / SIDES[0]) * np.sin(n * np.pi * y / SIDES[1]) for m, n in modes], 1
    )


def l_mesh(refinements=3):
    """Vertices (n, 2) [m] and triangles of an L of 1 m with arms of 0.5 m."""
    mesh = skfem.MeshTri.init_lshaped().refined(refinements)
    return (mesh.p.T + 1) / 2, mesh.t.T
