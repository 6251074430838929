"""Curved surfaces: points, normals and shapes."""

import numpy as np
from scipy.special import eval_legendre

from pidpanel.geometry import coarsening
from pidpanel.geometry.surface_waves import SurfaceQuadrature

# a turn about an axis that is none of the frame
TURN = np.linalg.qr(np.array([[1.0, 2, 3], [0, 1, -2], [2, 0, 1]]))[0]


def paraboloid(rings=16, spokes=40, radius=0.6, focus=0.48):
    """A reflector; shapes rise and tilt about x and y, and fold about x + y = 0."""
    r = radius * np.sqrt((np.arange(rings) + 0.5) / rings)
    angle = 2 * np.pi * (np.arange(spokes) + 0.5) / spokes
    r, angle = (axis.ravel() for axis in np.meshgrid(r, angle, indexing="ij"))
    x, y, slope = r * np.cos(angle), r * np.sin(angle), r / (2 * focus)
    stretch = np.hypot(1, slope)
    normal = np.stack([-slope * np.cos(angle), -slope * np.sin(angle), np.ones_like(r)], axis=1)
    weight = np.pi * radius**2 / r.size * stretch
    shape = np.stack([np.ones_like(r), x, y, np.cos(2 * angle - np.pi / 2) * r**2], axis=1)
    position = np.stack([x, y, r**2 / (4 * focus)], axis=1)
    return SurfaceQuadrature(position, normal / stretch[:, None], weight, shape)


def sphere(radius=0.5, degrees=(0, 1, 2, 3), rings=30):
    """A sphere in Legendre polynomials of the cosine to the axis."""
    cosine, weight = np.polynomial.legendre.leggauss(rings)
    angle = np.pi * np.arange(2 * rings) / rings
    cosine, angle = (axis.ravel() for axis in np.meshgrid(cosine, angle, indexing="ij"))
    sine = np.sqrt(1 - cosine**2)
    normal = np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], axis=1)
    shape = np.stack([eval_legendre(degree, cosine) for degree in degrees], axis=1)
    weight = np.repeat(weight, 2 * rings) * np.pi / rings * radius**2
    return SurfaceQuadrature(radius * normal, normal, weight, shape)


def plate(panel, turn=TURN):
    """A flat panel in a plane that is oblique."""
    points = np.pad(panel.position, ((0, 0), (0, 1)))
    normal = np.broadcast_to(turn[:, 2], points.shape)
    return SurfaceQuadrature(points @ turn.T, normal, panel.weight, panel.shape)


def oriented(vertices, cells):
    """Triangles of a flat mesh (nv, 2), in one sense, in space."""
    (a, b), (c, d) = (vertices[cells[:, end]].T - vertices[cells[:, 0]].T for end in (1, 2))
    cells = np.where((a * d > b * c)[:, None], cells, cells[:, ::-1]).astype(np.int64)
    return np.pad(vertices, ((0, 0), (0, 1))), cells


def paraboloid_mesh(rings=6, spokes=28, hub=0.12, radius=0.6, focus=0.48):
    """Vertices and triangles of a reflector with a hole, equal in each quarter."""
    r, angle = np.linspace(hub, radius, rings + 1), 2 * np.pi * np.arange(spokes) / spokes
    r, angle = (axis.ravel() for axis in np.meshgrid(r, angle, indexing="ij"))
    vertices = np.stack([r * np.cos(angle), r * np.sin(angle), r**2 / (4 * focus)], axis=1)
    i, j = np.indices((rings, spokes)).reshape(2, -1)
    a, b = i * spokes + j, i * spokes + (j + 1) % spokes
    return vertices, np.concatenate(
        [np.stack([a, a + spokes, b + spokes], 1), np.stack([a, b + spokes, b], 1)]
    )


def sphere_mesh(divisions, radius=0.5):
    """Vertices and triangles of an octahedron that is divided and blown up."""
    vertices = np.concatenate([np.eye(3), -np.eye(3)])
    cells = np.array([[0, 1, 2], [3, 2, 1], [0, 2, 4], [0, 5, 1], [3, 4, 2], [3, 1, 5], [0, 4, 5], [3, 5, 4]])  # fmt: skip
    for _ in range(divisions):
        vertices, cells = coarsening._divided(vertices, cells)
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return radius * vertices, cells
