"""Modes from a file as matrices: the modes are the coordinates, so that K and M are diagonal.

Everything downstream takes them as those of a panel: w is the motion along the normal of the
surface. Rotations, curvatures and reactions are not in such files.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sp

from pidpanel.arrays import Array, Flags, Index
from pidpanel.modal_files.quadrature import CellQuadrature
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.shapes import Shapes


def modal_plate(
    vertex_normal: Array,
    quadrature: CellQuadrature,
    displacement: Array,
    frequency: Array,
    modal_mass: Array,
    patches: Mapping[str, Index],
    point_direction: Array,
    points: Index,
) -> PlateMatrices:
    """Return the matrices of modes.

    Parameters
    ----------
    vertex_normal, quadrature
        (n_vertices, 3) unit normals, and points of the surface.
    displacement
        (n_vertices, 3, n) motion of the vertices of the surface in each shape [1].
    frequency, modal_mass
        (n,) [Hz] and [kg], of residual vectors their own.
    patches
        Cells of each patch.
    point_direction, points
        (n_points, 3) directions of the motion at the points, and their vertices (n_points,).
    """
    n = len(frequency)
    normal = quadrature.normal_displacement(displacement)
    no_motion = sp.csr_array((len(vertex_normal), n))
    unheld = sp.csr_array((0, n))
    return PlateMatrices(
        stiffness=sp.csr_array(sp.diags_array(modal_mass * (2 * np.pi * frequency) ** 2)),
        mass=sp.csr_array(sp.diags_array(modal_mass)),
        patch_overlap={
            name: sp.csr_array(quadrature.overlap(normal, cells)) for name, cells in patches.items()
        },
        at_vertices=sp.csr_array(np.einsum("vdn,vd->vn", displacement, vertex_normal)),
        curvature_at_vertices=(no_motion,) * 3,
        shear_at_vertices=(no_motion,) * 2,
        at_points=sp.csr_array(np.einsum("pdn,pd->pn", displacement[points], point_direction)),
        point_weight=sp.csr_array((len(points), len(vertex_normal))),
        quadrature_position=quadrature.position,
        quadrature_weight=quadrature.weight,
        at_quadrature=sp.csr_array(normal),
        motion_at_vertices=tuple(sp.csr_array(displacement[:, axis]) for axis in range(3)),
        inertia=np.zeros(n),
        reactions=(unheld, unheld),
        quadrature_normal=quadrature.normal,
        vertex_normal=vertex_normal,
        point_direction=point_direction,
    )


def modal_shapes(
    plate: PlateMatrices, displacement: Array, frequency: Array, is_residual: Flags
) -> Shapes:
    """Return the coordinates as shapes with a largest displacement (n_vertices, 3, n) of 1.

    w is positive where it is largest.
    """
    normal = plate.at_vertices.toarray()
    peak = normal[np.abs(normal).argmax(axis=0), np.arange(normal.shape[1])]
    size = np.sqrt((displacement**2).sum(axis=1).max(axis=0)) * np.where(peak < 0, -1, 1)
    order = np.lexsort((frequency, is_residual))
    count = int(np.count_nonzero(~is_residual))
    return Shapes(frequency[order][:count], frequency[order][count:], np.diag(1 / size)[:, order])
