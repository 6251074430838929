"""Jumps of the pressure over a panel of any outline, with or without holes.

ψ = √u p with Legendre polynomials p on the box round the panel and u of −Δu = 1, u = 0 on outline
and rims (the torsion function): u falls linearly to every edge, so that ψ has the factor √distance.
u is that of quadratic elements on the mesh of the panel.
"""

from dataclasses import dataclass

import numpy as np
import skfem
from skfem.models.poisson import laplace, unit_load

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.sound.face import FoldedFace
from pidpanel.sound.field import DIRECTIONS_AT_ONCE
from pidpanel.sound.rectangle import affordable
from pidpanel.sound.wavenumber_table import (
    FieldError,
    chebyshev_nodes,
    even_interpolation,
    node_count,
)

SPARE_DEGREES = 5  # degrees of the polynomials beyond κa

# Wavenumber integrated to over that of the functions.
FARTHEST = 5.0

MOST_FUNCTIONS = 160

# Largest K times the longest edge of a triangle: longer ones are divided. On an L 6 changes load
# and mass by 0.02 %, 24 by 0.1 %; 48 makes the mass 4.5 and the load 20 times too small.
LONGEST = 12.0

# Order of the quadrature of √u p on a triangle, and of a mesh whose edges are all this short. The
# error at edges goes with the size of the elements to 3/2: 0.2 % of the load on 600 with order 4.
QUADRATURE_ORDER, FINE, FINE_ORDER = 8, 2.5, 4

# What the mean square of a function by its transform up to K may exceed the whole by (Bessel's
# inequality). Of functions that the points resolve it is less than 1e-3; of others 0.43 to 0.9.
LARGEST_EXCESS = 0.1

# Least singular value that counts, of √u p at the points and of the polynomials for shapes.
INDEPENDENT, REGULAR = 1e-8, 1e-5

SHAPE_DEGREES = 1.6  # degrees of the polynomials that stand for shapes over those of jumps


def _triangles(vertices: Array, cells: Index) -> skfem.MeshTri:
    used, numbers = np.unique(cells, return_inverse=True)
    numbers = numbers.reshape(cells.shape)
    if cells.shape[1] == 4:  # along the diagonal that leaves the larger smallest triangle
        ways = [numbers[:, [[0, 1, 2], [0, 2, 3]]], numbers[:, [[0, 1, 3], [1, 2, 3]]]]
        sides = [np.diff(vertices[used][way], axis=2) for way in ways]
        area = [
            side[..., 0, 0] * side[..., 1, 1] - side[..., 0, 1] * side[..., 1, 0] for side in sides
        ]
        area = [a * np.sign(a.sum(axis=1, keepdims=True)) for a in area]  # of either sense
        first = area[0].min(axis=1) >= area[1].min(axis=1)
        numbers = np.where(first[:, None, None], *ways).reshape(-1, 3)
    return skfem.MeshTri(np.ascontiguousarray(vertices[used].T), np.ascontiguousarray(numbers.T))


def _longest_edges(mesh: skfem.MeshTri) -> Array:
    """Return the longest edge (n,) of each triangle [m]."""
    edges = mesh.p[:, mesh.t] - mesh.p[:, np.roll(mesh.t, 1, axis=0)]
    longest: Array = np.hypot(*edges).max(axis=0)
    return longest


@dataclass(frozen=True)
class Polynomials:
    """Products of Legendre polynomials on a box, within an ellipse of degrees."""

    middle: Array  # (2,) [m]
    half: Array  # (2,) half sides of the box [m]
    degree: Index  # (n, 2)

    @classmethod
    def of_degrees(cls, position: Array, degrees: tuple[int, int]) -> "Polynomials":
        """Return those of a box round positions (k, 2) [m]."""
        low, high = position.min(axis=0), position.max(axis=0)
        x, y = np.indices((degrees[0] + 1, degrees[1] + 1)).reshape(2, -1)
        inside = (x / (degrees[0] + 0.5)) ** 2 + (y / (degrees[1] + 0.5)) ** 2 <= 1
        degree = np.stack([x[inside], y[inside]], axis=1)
        return cls((low + high) / 2, (high - low) / 2, degree)

    def values(self, position: Array) -> Array:
        """Return the polynomials (k, n) at positions (k, 2) [m]."""
        legendre = np.polynomial.legendre.legvander
        x, y = ((position - self.middle) / self.half).T
        along_x, along_y = (
            legendre(points, int(top))
            for points, top in zip((x, y), self.degree.max(0), strict=True)
        )
        scale = np.sqrt(np.prod(2 * self.degree + 1, axis=1))
        values: Array = along_x[:, self.degree[:, 0]] * along_y[:, self.degree[:, 1]] * scale
        return values


@dataclass(frozen=True)
class OutlineJumps:
    """Functions of the jump on a mesh, at the points of its quadrature and on its boundary."""

    functions: PanelQuadrature  # ψ [1]
    boundary_square: Array  # (n, n) ∮ ψ ψᵀ/distance ds [1]
    reach: float
    for_shapes: Polynomials
    to_shapes: Array  # (n_polynomials, n) that give the part of ψ which shapes see
    wavenumber: float  # κ [rad/m] of the waves that the functions resolve

    @classmethod
    def of_mesh(cls, vertices: Array, cells: Index, wavenumber: float) -> "OutlineJumps":
        """Return functions that resolve waves to κ [rad/m] on a mesh of 3- or 4-sided cells.

        Or to a lower one, if that took more than `MOST_FUNCTIONS`.
        """
        mesh = _triangles(vertices, cells)
        corners = mesh.p
        half = np.ptp(corners, axis=1) / 2
        # of a rectangle of degrees an ellipse is π/4
        most = affordable(half, SPARE_DEGREES + 1, MOST_FUNCTIONS / (np.pi / 4))
        wavenumber = min(wavenumber, most)
        top = np.ceil(wavenumber * half).astype(int) + SPARE_DEGREES
        reach = FARTHEST * float(np.max(top / half))
        while np.any(coarse := reach * _longest_edges(mesh) > LONGEST):
            mesh = mesh.refined(np.flatnonzero(coarse))
        fine = reach * np.max(_longest_edges(mesh)) < FINE
        order, quadratic = FINE_ORDER if fine else QUADRATURE_ORDER, skfem.ElementTriP2()
        basis = skfem.Basis(mesh, quadratic, intorder=order)
        held = basis.get_dofs()  # on outline and rims
        torsion = skfem.solve(
            *skfem.condense(laplace.assemble(basis), unit_load.assemble(basis), D=held)
        )
        position = np.asarray(basis.global_coordinates()).reshape(2, -1).T
        factor = np.sqrt(np.maximum(np.asarray(basis.interpolate(torsion)).ravel(), 0.0))
        weight = basis.dx.ravel()
        rim = skfem.FacetBasis(mesh, quadratic, intorder=order)
        slope = -np.sum(rim.interpolate(torsion).grad * np.asarray(rim.normals), axis=0).ravel()
        rim_position = np.asarray(rim.global_coordinates()).reshape(2, -1).T

        polynomials = Polynomials.of_degrees(corners.T, (int(top[0]), int(top[1])))
        root = np.sqrt(weight)[:, None]
        raw = factor[:, None] * polynomials.values(position)
        _, singular, turned = np.linalg.svd(np.linalg.qr(root * raw, mode="r"))
        kept = singular > INDEPENDENT * singular[0]
        combined = turned[kept].T / singular[kept]
        values = raw @ combined
        at_rim = np.sqrt(np.maximum(slope * rim.dx.ravel(), 0.0))[:, None] * (
            polynomials.values(rim_position) @ combined
        )
        degrees = np.ceil(SHAPE_DEGREES * top).astype(int)
        for_shapes = Polynomials.of_degrees(corners.T, (int(degrees[0]), int(degrees[1])))
        matrix = root * for_shapes.values(position)
        to_shapes = np.linalg.lstsq(matrix, root * values, rcond=REGULAR)[0]
        return cls(
            PanelQuadrature(position, weight, values),
            at_rim.T @ at_rim,
            reach,
            for_shapes,
            to_shapes,
            wavenumber,
        )

    @property
    def diameter(self) -> float:
        """L [m]."""
        return self.functions.diameter

    def means(self) -> list[Array]:
        """Return P(κ) = (1/2π) ∮ ψ̂ ψ̂* dα, (count, n, n) [m⁴], at nodes up to `reach`."""
        face = FoldedFace.from_panel(self.functions, self.reach)
        nodes = chebyshev_nodes(self.reach, node_count(self.reach, self.diameter))
        mean = np.array([face.azimuthal_mean(k, self.diameter) for k in nodes])
        self._check(mean)
        return [mean]

    def _check(self, mean: Array) -> None:
        """Compare (1/2π) ∫ P κ dκ up to K with ∫ ψψᵀ dA, which is 1 and more than that."""
        node, weight = np.polynomial.legendre.leggauss(2 * len(mean))
        kappa = self.reach / 2 * (1 + node)
        inside = (weight * kappa) @ even_interpolation(kappa, self.reach, len(mean))
        square = np.tensordot(self.reach / 2 * inside, mean, axes=1)
        excess = float(np.max(np.linalg.eigvalsh(square / (2 * np.pi)))) - 1
        if not excess < LARGEST_EXCESS:
            raise FieldError(
                f"the mesh does not resolve the pressure at free edges (error {excess:.0%}, "
                f"allowed {LARGEST_EXCESS:.0%}): use a mesh with elements of one size"
            )

    def tails(self) -> list[Array]:
        """Return ∫_K^∞ P κ² dκ (n, n) [m]: behind an edge P → (π/2κ⁴) ∮ ψψᵀ/distance ds."""
        return [np.pi / 2 / self.reach * self.boundary_square]

    def couplings(self, panel: PanelQuadrature) -> list[Array]:
        """Return ∫ ψ φ dA (n, n_shapes) [m²] of the shapes of a condensed face.

        ψ is replaced by its projection on polynomials, whose integrals the face gives.
        """
        load = panel.weight[:, None] * panel.shape
        return [self.to_shapes.T @ (self.for_shapes.values(panel.position).T @ load)]

    def waves(self, wavevector: Array) -> list[Complexes]:
        """Return ∫ ψ exp(−iκ·x) dA (k, n) [m²]; x is measured from the middle."""
        load = self.functions.weight[:, None] * self.functions.shape
        position = (self.functions.position - self.functions.center).T
        parts = np.array_split(wavevector, 1 + len(wavevector) // DIRECTIONS_AT_ONCE)
        return [np.concatenate([np.exp(-1j * part @ position) @ load for part in parts])]
