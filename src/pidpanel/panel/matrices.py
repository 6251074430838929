"""The matrices of a plate: all that its modes and its response need, whatever its elements."""

from dataclasses import dataclass, field, fields

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array, Index


@dataclass(frozen=True)
class PlateMatrices:
    """Matrices of a supported plate in its free coordinates u, w(x, y) = Σ N_i(x, y) u_i."""

    stiffness: sp.csr_array  # (n, n) K, with uᵀ K u / 2 the elastic energy [J]
    mass: sp.csr_array  # (n, n) M, consistent, with u̇ᵀ M u̇ / 2 the kinetic energy [J]
    # (n, n) D = ∫_patch N Nᵀ dA of each damper patch, so that uᵀ D u = ∫_patch w² dA [m⁴]
    patch_overlap: dict[str, sp.csr_array]
    at_vertices: sp.csr_array  # (n_vertices, n) w at the vertices of the mesh
    # Three matrices (n_vertices, n): κ (see `section`) at the vertices, the mean over the cells
    # that meet there [1/m]
    curvature_at_vertices: tuple[sp.csr_array, ...]
    # Two matrices (n_vertices, n): γ (see `section`) likewise [1]; zero in a thin plate
    shear_at_vertices: tuple[sp.csr_array, ...]
    at_points: sp.csr_array  # (n_points, n) w at the response points
    point_weight: sp.csr_array  # (n_points, n_vertices) of values at vertices, linear between them
    # (n_quadrature, 2) points [m] for the integration of a pressure on w
    quadrature_position: Array
    quadrature_weight: Array  # (n_quadrature,) weights [m²]; they sum to the area
    # (n_quadrature, n) w at the quadrature points. The consistent load of a pressure p is
    # ``at_quadrature.T @ (quadrature_weight * p)``.
    at_quadrature: sp.csr_array
    # (n,) ∫ m″ N dA with the attached masses: force per acceleration of all supports [kg]
    inertia: Array
    # Of a structure, three matrices (n_vertices, n): motion along x, y, z at the vertices
    motion_at_vertices: tuple[sp.csr_array, ...] = field(default=(), kw_only=True)
    # Two matrices (n_points, n) of reactions at single points (`point_supports`): those of supports
    # and springs [√J/m], and those of masses, to be multiplied by ω²
    reactions: tuple[sp.csr_array, sp.csr_array]
    # (n_quadrature, 3) normals of a curved surface, whose positions have three columns
    quadrature_normal: Array | None = field(default=None, kw_only=True)
    # (n_vertices, 3) normals of a structure along which w is, means of the cells that meet there
    vertex_normal: Array | None = field(default=None, kw_only=True)
    # (n, 3) ∫ N ρ dV along x, y, z: forces per acceleration of all supports of a structure [kg]
    participation: Array | None = field(default=None, kw_only=True)
    # (n_patches, n + 3, 3) of a shell, ∫_patch N n dA and ∫_patch n nᵀ dA with the normal n, by the
    # quadrature of the overlaps: else no square of a moved patch is sure to be positive [m²]
    patch_translation: Array | None = field(default=None, kw_only=True)
    # (n_points, 3) directions of the motion at the points of a structure
    point_direction: Array | None = field(default=None, kw_only=True)

    def motions(self, vectors: Array) -> Array:
        """Return displacements (n_vertices, 3, k) of vectors (n, k) along x, y, z."""
        return np.stack([rows @ vectors for rows in self.motion_at_vertices], axis=1)

    @property
    def is_of_modes(self) -> bool:
        """Whether the coordinates are the modes of a file, of which K and M are diagonal."""
        diagonal = self.stiffness.nnz <= self.stiffness.shape[0]
        return diagonal and self.mass.nnz <= self.mass.shape[0]

    def with_shapes(self, shapes: Array, stretching: "Stretching | None" = None) -> "StoredPlate":
        """Return the matrices with the shapes (n, n_shapes) of a basis, and their stretching."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(PlateMatrices)}
        return StoredPlate(**values, shapes=shapes, stretching=stretching)


@dataclass(frozen=True)
class Stretching:
    """Membrane energy ½ Σ A_ijkl q_i q_j q_k q_l of some modes; see `panel.stretching`."""

    modes: Index  # (n,) their numbers in the basis
    tensor: Array  # (n, n, n, n) A_ijkl [N/m³]; A_ijkl = A_jikl = A_klij


@dataclass(frozen=True)
class StoredPlate(PlateMatrices):
    """Matrices of a plate with the shapes of the panel's basis."""

    shapes: Array  # (n_free, n) of the basis, in its order and size, in single precision
    # (n_patches, n_quadrature) weights over patches that elements do not follow [m²]; None where a
    # patch is whole elements
    patch_weight: sp.csr_array | None = None
    stretching: Stretching | None = None  # of its lowest modes; None where it is not known
