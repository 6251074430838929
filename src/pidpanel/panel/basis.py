"""The basis of a panel: its shapes with their values wherever the stages downstream need them.

Its face is condensed by `pidpanel.geometry.plane_waves`, as the sound needs it.
"""

from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array, Flags
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature, WettedFace, condensed
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.shapes import Shapes, on_patch

# Largest wavenumber of the face over the larger of those of the sound and of the shapes.
#
# The air's mass needs what shapes have beyond their own wavenumber (`pidpanel.sound.radiation`).
REACH = 2.0

Face = TypeVar("Face", bound=MovedFace)


@dataclass(frozen=True)
class PanelBasis(WettedFace):
    """Real shapes that diagonalise M and K, with their values wherever they are needed.

    The modes come first, by frequency, then the residual vectors, by frequency. Every shape φ
    has max |w| = 1 over the vertices and is positive there.
    """

    natural_frequency: Array  # (n,) f_i [Hz], 0 for rigid-body modes; (2πf_i)² m_i = φ_iᵀ K φ_i
    modal_mass: Array  # (n,) m_i = φ_iᵀ M φ_i [kg]
    # (n,) false for modes. The frequency of a residual vector is no resonance that converges.
    is_residual: Flags
    shape_at_points: Array  # (n_points, n) w of each shape at the response points [1]
    patch_overlap: Array  # (n_patches, n, n) ∫_patch φ_i φ_j dA [m²]
    # (n_vertices, 3, n) κ of each shape at the vertices [1/m]; see `pidpanel.panel.section`. Of a
    # shell six rows, κ and its membrane strain over h; see `pidpanel.shell.strains.Layup.layers`
    curvature_at_vertices: Array
    # (n_vertices, 2, n) γ of each shape at the vertices [1/m]: shapes have no unit, w has m
    shear_at_vertices: Array
    curvature_at_points: Array  # (n_points, 3, n) κ at the response points
    shear_at_points: Array  # (n_points, 2, n) γ at the response points
    layer_names: tuple[str, ...]  # layers of the section, see `pidpanel.panel.section.Layer`
    # (n_layers, 3, 3) strain [m] and stress [Pa m] of the layers per curvature
    layer_strain: Array
    layer_stress: Array
    core_stress: Array  # (2, 2) shear stress of the core per shear angle [Pa]
    # (2, n_held + 1, n) reactions at single points (see `point_supports`): those of
    # supports and springs, and those of masses, to be multiplied by ω²
    reactions: Array
    point_position: Array  # (n_points, 2) positions of the response points [m]
    cell_in_patch: Flags  # (n_patches, n_cells) the cells of each patch
    point_names: tuple[str, ...]  # names of the response points, in the order of `shape_at_points`
    patch_names: tuple[str, ...]  # names of the patches, in the order of `patch_overlap`
    # (n,) by how much the mesh raises frequencies at most [1], where it is known mode by mode
    frequency_shift: Array | None = field(default=None, kw_only=True)
    # (n_patches,) of a structure: share of the motion along its surface, by the square [1]
    tangential_share: Array | None = field(default=None, kw_only=True)


def basis_of(mesh: PanelMesh, plate: PlateMatrices, shapes: Shapes) -> PanelBasis:
    """Return the values of shapes wherever they are needed."""
    section = getattr(plate, "section", None)  # none of modes from a file
    layers = getattr(plate, "layers", section.layers if section else ())
    rows = len(plate.curvature_at_vertices)
    cells = np.arange(len(mesh.cells))
    return PanelBasis(
        **values_of(plate, shapes),
        vertex_position=mesh.vertices,
        cells=mesh.cells,
        layer_names=tuple(layer.name for layer in layers),
        layer_strain=np.array([layer.strain for layer in layers]).reshape(-1, 3, rows),
        layer_stress=np.array([layer.stress for layer in layers]).reshape(-1, 3, rows),
        core_stress=section.core_stress if section else np.zeros((2, 2)),
        point_position=np.array(list(mesh.points.values()), dtype=float).reshape(
            -1, mesh.vertices.shape[1]
        ),
        cell_in_patch=np.array(
            [np.isin(cells, mesh.patch_cells[name]) for name in plate.patch_overlap]
        ).reshape(-1, len(cells)),
        point_names=tuple(mesh.points),
        patch_names=tuple(plate.patch_overlap),
    )


def values_of(plate: PlateMatrices, shapes: Shapes) -> dict[str, Any]:
    """Return the attributes of a `PanelBasis` that follow from its shapes."""
    vectors = shapes.vectors
    at_vertices = plate.at_vertices @ vectors
    curvature, shear = (
        np.stack([component @ vectors for component in components], axis=1)
        for components in (plate.curvature_at_vertices, plate.shear_at_vertices)
    )
    at_quadrature = plate.at_quadrature @ vectors
    curvature_at_points, shear_at_points = (
        np.stack([plate.point_weight @ component for component in values.swapaxes(0, 1)], axis=1)
        for values in (curvature, shear)
    )
    reactions = np.array([matrix @ vectors for matrix in plate.reactions])
    root = np.sqrt(plate.quadrature_weight)[:, None] * at_quadrature
    return {
        "natural_frequency": np.concatenate([shapes.frequency, shapes.residual_frequency]),
        "modal_mass": np.einsum("ki,ki->i", vectors, plate.mass @ vectors),
        "is_residual": np.arange(vectors.shape[1]) >= len(shapes.frequency),
        "shape_at_points": plate.at_points @ vectors,
        "patch_overlap": np.array(
            [_overlap_of(vectors, overlap) for overlap in plate.patch_overlap.values()]
        ).reshape(-1, vectors.shape[1], vectors.shape[1]),
        "quadrature_position": plate.quadrature_position,
        "quadrature_weight": plate.quadrature_weight,
        "shape_at_quadrature": at_quadrature,
        "quadrature_wavenumber": np.inf,
        "quadrature_normal": plate.quadrature_normal
        if plate.quadrature_position.shape[1] == 3
        else None,
        "face_overlap": root.T @ root,
        "shape_at_vertices": at_vertices,
        "curvature_at_vertices": curvature,
        "shear_at_vertices": shear,
        "curvature_at_points": curvature_at_points,
        "shear_at_points": shear_at_points,
        # NetCDF 3 has no dimension of length 0: the last row is zero
        "reactions": np.pad(reactions, ((0, 0), (0, 1), (0, 0))),
    }


def _overlap_of(vectors: Array, overlap: sp.csr_array) -> Array:
    """Return VᵀD V (n, n) of a patch."""
    _, D, rows = on_patch(overlap, vectors)
    return rows.T @ (D @ rows)


def patch_areas(basis: PanelBasis) -> Array:
    """Return the area of each patch [m²], (n_patches,)."""
    return basis.cell_in_patch @ cell_areas(basis.vertex_position, basis.cells)


def face_wavenumber(basis: PanelBasis, sound: float) -> float:
    """Return the wavenumber to which the face of a panel has to be known [rad/m].

    The modes of a plate are N = κ² A/4π up to the wavenumber κ of its bending (Weyl's law),
    whatever its stiffness.
    """
    modes, area = np.sum(~basis.is_residual), basis.quadrature_weight.sum()
    return REACH * max(sound, float(np.sqrt(4 * np.pi * modes / area)))


def with_condensed_face(moved: Face, wavenumber: float) -> Face:
    """Return a basis, or other motions of a face, condensed for waves to a wavenumber [rad/m].

    A curved face is returned as it is.
    """
    if moved.quadrature_normal is not None:
        return moved
    face = condensed(PanelQuadrature.from_face(moved), wavenumber)
    return replace(
        moved,
        quadrature_position=face.position,
        quadrature_weight=face.weight,
        shape_at_quadrature=face.shape,
        quadrature_wavenumber=wavenumber,
    )
