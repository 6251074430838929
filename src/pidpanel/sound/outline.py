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
from pidpanel.sound.wavenumber_table import chebyshev_nodes, node_count

SPARE_DEGREES = 5  # degrees of the polynomials beyond κa

# Wavenumber integrated to over that of the functions.
FARTHEST = 5.0

MOST_FUNCTIONS = 160

# Order of the quadrature of √u p on an element, of meshes up to a number of cells and beyond. Its
# error at edges goes with the size of the elements to 3/2: 0.2 % of the load on 600 with order 4.
QUADRATURE_ORDERS, COARSE_CELLS = (8, 4), 3000

# Least singular value that counts, of √u p at the points and of the polynomials for shapes.
INDEPENDENT, REGULAR = 1e-8, 1e-5

COARSEST = 6.0  # largest K times the size of an element, whose points lie about a quarter apart

SHAPE_DEGREES = 1.6  # degrees of the polynomials that stand for shapes over those of jumps


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
        used, numbers = np.unique(cells, return_inverse=True)
        corners = np.ascontiguousarray(vertices[used].T)
        numbers = np.ascontiguousarray(numbers.reshape(cells.shape).T)
        quadratic: skfem.Element
        if cells.shape[1] == 3:
            mesh, quadratic = skfem.MeshTri(corners, numbers), skfem.ElementTriP2()
        else:
            mesh, quadratic = skfem.MeshQuad(corners, numbers), skfem.ElementQuad2()
        half = np.ptp(corners, axis=1) / 2
        # of a rectangle of degrees an ellipse is π/4
        most = affordable(half, SPARE_DEGREES + 1, MOST_FUNCTIONS / (np.pi / 4))
        wavenumber = min(wavenumber, most)
        top = np.ceil(wavenumber * half).astype(int) + SPARE_DEGREES
        reach = FARTHEST * float(np.max(top / half))
        while reach * np.sqrt(np.prod(2 * half) / mesh.nelements) > COARSEST:
            mesh = mesh.refined()  # the points of a coarse mesh do not resolve K
        order = QUADRATURE_ORDERS[mesh.nelements > COARSE_CELLS]
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
        _, singular, turned = np.linalg.svd(root * raw, full_matrices=False)
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
        return [np.array([face.azimuthal_mean(k, self.diameter) for k in nodes])]

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
