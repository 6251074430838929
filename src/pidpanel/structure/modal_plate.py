"""Modes from a file as matrices: the modes are the coordinates, so that K and M are diagonal.

Everything downstream takes them as those of a panel: w is the motion along the normal of the
surface. Rotations, curvatures and reactions are not in such files.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array, Flags, Index
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.shapes import Shapes
from pidpanel.structure.surface import BARYCENTRIC, Surface

TANGENTIAL = 1e-3  # largest w over the largest displacement of a shape along the surface


def modal_plate(
    surface: Surface,
    displacement: Array,
    frequency: Array,
    modal_mass: Array,
    patches: Mapping[str, Index],
    at_points: Array,
) -> PlateMatrices:
    """Return the matrices of modes.

    Parameters
    ----------
    surface
        Triangles with n_vertices.
    displacement
        (n_vertices, 3, n) motion of the vertices in each shape [1].
    frequency, modal_mass
        (n,) [Hz] and [kg], of residual vectors their own.
    patches
        Cells of each patch.
    at_points
        (n_points, n) motion of the points in their directions [1].
    """
    n, count = len(frequency), len(surface.cells)
    corners = displacement[surface.cells]  # (n_cells, 3, 3, n)
    along = np.einsum("ckdn,cd->ckn", corners, surface.cell_normal)
    at_quadrature = np.einsum("qk,ckn->cqn", BARYCENTRIC, along)
    position = np.einsum("qk,ckd->cqd", BARYCENTRIC, surface.vertices[surface.cells])
    weight = np.repeat(surface.area / 3, 3)
    rows = np.sqrt(weight).reshape(count, 3, 1) * at_quadrature

    def overlap(cells: Index) -> sp.csr_array:
        part = rows[cells].reshape(-1, n)
        return sp.csr_array(part.T @ part)

    none = sp.csr_array((len(surface.vertices), n))
    unheld = sp.csr_array((0, n))
    at_vertices = np.einsum("vdn,vd->vn", displacement, surface.vertex_normal)
    return PlateMatrices(
        stiffness=sp.csr_array(sp.diags_array(modal_mass * (2 * np.pi * frequency) ** 2)),
        mass=sp.csr_array(sp.diags_array(modal_mass)),
        patch_overlap={name: overlap(cells) for name, cells in patches.items()},
        at_vertices=sp.csr_array(at_vertices),
        curvature_at_vertices=(none,) * 3,
        shear_at_vertices=(none,) * 2,
        at_points=sp.csr_array(at_points),
        point_weight=sp.csr_array((len(at_points), len(surface.vertices))),
        quadrature_position=position.reshape(-1, 3),
        quadrature_weight=weight,
        at_quadrature=sp.csr_array(at_quadrature.reshape(-1, n)),
        inertia=np.zeros(n),
        reactions=(unheld, unheld),
        quadrature_normal=np.repeat(surface.cell_normal, 3, axis=0),
    )


def modal_shapes(
    plate: PlateMatrices, displacement: Array, frequency: Array, is_residual: Flags
) -> Shapes:
    """Return the coordinates as shapes with max |w| = 1 over the vertices, positive there.

    One that moves along the surface has a largest displacement (n_vertices, 3, n) of 1.
    """
    normal = plate.at_vertices.toarray()
    peak = normal[np.abs(normal).argmax(axis=0), np.arange(normal.shape[1])]
    whole = np.sqrt((displacement**2).sum(axis=1).max(axis=0))
    peak = np.where(np.abs(peak) < TANGENTIAL * whole, whole, peak)
    order = np.lexsort((frequency, is_residual))
    count = int(np.count_nonzero(~is_residual))
    return Shapes(frequency[order][:count], frequency[order][count:], np.diag(1 / peak)[:, order])
