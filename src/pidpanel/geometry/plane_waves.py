"""Integrals of shapes against plane waves, from far fewer points than the elements have.

What sound does to a panel depends on the shapes through ∫ φ exp(iκ·x) dA alone, for wavenumbers
|κ| up to some largest one, however fine the mesh is. On a box a plane wave is a polynomial of a
degree not far above κ a/2 (its Legendre series has the coefficients (2m + 1) iᵐ j_m(κ a/2),
which vanish beyond), so that a quadrature of any points passes to the Gauss points of the box by
the transpose of interpolation: Σ_q w_q φ_q f(x_q) = Σ_J c_J f(x_J) with c_J = Σ_q ℓ_J(x_q) w_q φ_q
for every polynomial f up to that degree.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Index

# Largest omitted term of a plane wave's series at the largest wavenumber; see `degree`.
TOLERANCE = 1e-5

# The same at half of it: a box that is short compared with the waves needs more terms for this.
HALF_TOLERANCE = 1e-10

# Edge, in shortest wavelengths, of the boxes in which points are gathered first.
WAVES_IN_A_BOX = 2.0

gauss = np.polynomial.legendre.leggauss  # nodes and weights on [−1, 1]


@dataclass(frozen=True)
class MovedFace:
    """A face that moves in n shapes, as the force of a field on them needs it.

    Positions of a curved face have three columns, and w is the motion along its normal.
    """

    # (n_quadrature, 2) points [m] for integrals of a pressure on the shapes
    quadrature_position: Array
    quadrature_weight: Array  # (n_quadrature,) weights [m²]
    # (n_quadrature, n) w of each shape at these points [1]; of a condensed face the values that
    # give its integrals
    shape_at_quadrature: Array
    # κ [rad/m] of the shortest waves whose integrals with the shapes these points give; ∞ for the
    # points of the mesh
    quadrature_wavenumber: float
    vertex_position: Array  # (n_vertices, 2) vertices of the mesh [m]
    cells: Index  # (n_cells, 4) or (n_cells, 3) vertex numbers of the cells
    shape_at_vertices: Array  # (n_vertices, n) w of each shape at the vertices [1]
    # (n_quadrature, 3) normals of a curved face at its points; None of a plane one
    quadrature_normal: Array | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class WettedFace(MovedFace):
    """The same as the air that it moves needs it."""

    face_overlap: Array  # (n, n) ∫ φ_i φ_j dA over the face [m²]


@dataclass(frozen=True)
class PanelQuadrature:
    """Shapes of a panel at the points of a quadrature over its face."""

    position: Array  # (nq, 2) points in the plane of the panel [m]
    weight: Array  # (nq,) weights [m²]; they sum to the area
    shape: Array  # (nq, n) values of the n shapes φ [1] at the points
    # Largest κ [rad/m] for which Σ w φ exp(iκ·x) stands for the integral; ∞ for points of the mesh.
    # Those of a condensed face are not the values there: beyond the outline too they are not zero,
    # and the weights sum to the area of the box.
    wavenumber: float = np.inf
    # (n, n) ∫ φ_i φ_j dA [m²]; from the points where it is not given. A condensed face needs it.
    overlap: Array | None = None

    @classmethod
    def from_face(cls, face: MovedFace, overlap: Array | None = None) -> "PanelQuadrature":
        """Return the quadrature of a face, with ∫ φ_i φ_j dA [m²] where it is known."""
        points, values = face.quadrature_position, face.shape_at_quadrature
        return cls(points, face.quadrature_weight, values, face.quadrature_wavenumber, overlap)

    @property
    def center(self) -> Array:
        """(2,) middle of the box round the panel [m]."""
        return (self.position.min(axis=0) + self.position.max(axis=0)) / 2

    @property
    def diameter(self) -> float:
        """L [m], diameter of a circle round the box's middle that holds all points."""
        return float(2 * np.max(np.linalg.norm(self.position - self.center, axis=1)))

    @cached_property
    def product_integral(self) -> Array:
        """(n, n) ∫ φ_i φ_j dA [m²]."""
        if self.overlap is not None:
            return self.overlap
        root = np.sqrt(self.weight)[:, None] * self.shape
        return root.T @ root

    def of_shapes(self, chosen: Index) -> "PanelQuadrature":
        """Return the panel with these shapes alone."""
        return replace(self, shape=self.shape[:, chosen], overlap=None)


def condensed(panel: PanelQuadrature, wavenumber_max: float) -> PanelQuadrature:
    """Return a quadrature on Gauss points of the box that serves every plane wave to κ_max.

    Points are gathered in small boxes first, and then all at once.

    Parameters
    ----------
    wavenumber_max
        κ_max [rad/m]: sums with exp(iκ·x) agree within 1e-6 Σ w|φ| up to κ_max, within 1e-10 up to
        half of it.

    Returns
    -------
    PanelQuadrature
        Quadrature of (n_x n_y) points, y fastest.

    Examples
    --------
    A thousand points of 1 m × 0.5 m, under a wave of 2 m along the longer side:

    >>> x = np.random.default_rng(0).uniform(size=(1000, 2)) * [1.0, 0.5]
    >>> few = condensed(PanelQuadrature(x, np.full(1000, 0.0005), x[:, :1]), 2 * np.pi)
    >>> len(few.weight)
    143
    >>> found = (few.weight * np.exp(1j * np.pi * few.position[:, 0])) @ few.shape
    >>> expected = np.full(1000, 0.0005) * np.exp(1j * np.pi * x[:, 0]) @ x[:, :1]
    >>> bool(np.abs(found - expected)[0] < 1e-10)
    True
    """
    position = panel.position
    low, high = position.min(axis=0), position.max(axis=0)
    load = panel.weight[:, None] * panel.shape
    side = np.maximum(high - low, 1e-9)
    boxes = np.ceil(side * wavenumber_max / (2 * np.pi * WAVES_IN_A_BOX)).astype(int)
    step = side / boxes
    local = [gauss(degree(wavenumber_max * edge / 2)) for edge in step]
    rules = [gauss(degree(wavenumber_max * edge / 2)) for edge in side]

    # Lagrange polynomials of the whole box at the points of each small box, along x and along y
    spread = [
        lagrange(
            2 * (np.arange(count)[:, None] + (1 + node) / 2) / count - 1, whole_node, whole_weight
        )
        for count, (node, _), (whole_node, whole_weight) in zip(boxes, local, rules, strict=True)
    ]
    place = np.minimum(((position - low) / step).astype(int), boxes - 1)
    box = place @ [boxes[1], 1]
    members = np.split(
        np.argsort(box, kind="stable"), np.cumsum(np.bincount(box, minlength=boxes.prod()))[:-1]
    )
    inside = 2 * ((position - low) / step - place) - 1
    along_x, along_y = (
        lagrange(inside[:, axis], *local[axis]) for axis in range(2)
    )  # (nq, n_local) each

    count = load.shape[1]
    n_x, n_y = (len(node) for node, _ in rules)
    total = np.zeros((n_x, n_y * count))
    for column in range(boxes[0]):
        strip = np.zeros((along_x.shape[1], n_y, count))
        for row in range(boxes[1]):
            inside_box = members[column * boxes[1] + row]
            if inside_box.size:
                strip += _gathered(inside_box, along_x, along_y, load, spread[1][row])
        total += spread[0][column].T @ strip.reshape(len(strip), -1)

    x, y = (
        start + (1 + node) / 2 * edge
        for start, edge, (node, _) in zip(low, side, rules, strict=True)
    )
    weights = np.outer(rules[0][1], rules[1][1]).ravel() * side.prod() / 4
    return PanelQuadrature(
        position=np.stack([g.ravel() for g in np.meshgrid(x, y, indexing="ij")], axis=1),
        weight=weights,
        shape=total.reshape(-1, count) / weights[:, None],
        wavenumber=wavenumber_max,
        overlap=panel.overlap,
    )


def _gathered(members: Index, along_x: Array, along_y: Array, load: Array, spread: Array) -> Array:
    """Return the load of some points on the nodes (x of their box, y of the whole, shapes)."""
    products = along_x[members, :, None] * along_y[members, None, :]
    local = products.reshape(len(members), -1).T @ load[members]
    nodes = (along_x.shape[1], along_y.shape[1], load.shape[1])
    return np.einsum("xyi,yY->xYi", local.reshape(nodes), spread, optimize=True)


def degree(reach: float) -> int:
    """Return how many terms the Legendre series of exp(iκx) on |x| ≤ a/2 has, reach = κ a/2.

    Terms (2m + 1) j_m(reach) beyond are below `TOLERANCE`, and below `HALF_TOLERANCE` at half the
    reach.

    Examples
    --------
    >>> degree(0.0), degree(10.0), degree(100.0)
    (1, 22, 125)
    """
    from scipy.special import spherical_jn  # slow to import, and a check needs none

    order = np.arange(int(2 * reach) + 40)
    return max(
        int(np.flatnonzero((2 * order + 1) * np.abs(spherical_jn(order, at)) > allowed)[-1]) + 1
        for at, allowed in ((reach, TOLERANCE), (reach / 2, HALF_TOLERANCE))
    )


def lagrange(x: Array, node: Array, weight: Array) -> Array:
    """Return the Lagrange polynomials of Gauss nodes at x, (*x.shape, n_nodes).

    ℓ_J(x) = w_J Σ_m (m + 1/2) P_m(x_J) P_m(x): the sum over degrees is exact for Gauss nodes.
    """
    top = len(node) - 1
    factor = np.arange(top + 1) + 0.5
    at_node = np.polynomial.legendre.legvander(node, top)
    return np.polynomial.legendre.legvander(x, top) @ ((factor * at_node) * weight[:, None]).T
