"""A supported plate as matrices, whatever its theory and its element.

All matrices act on the free coordinates u of the supported plate, w(x, y) = sum_i N_i(x, y) u_i,
where every N_i already satisfies the supports; whoever uses them needs to know neither the
element nor its supports. Thin plates are assembled in `thin`, plates with shear in `mindlin`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from skfem import BilinearForm, CellBasis, Element, Mesh

from pidpanel.arrays import Array
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.section import Section

# Of the pressure on the deflection: 3 x 3 Gauss points on a quadrilateral, 7 points on a triangle.
LOAD_ORDER = 5


@dataclass(frozen=True)
class AssembledPlate:
    """Matrices of a supported plate in its free coordinates.

    Whatever the plate theory, this is all that the modes need.

    Attributes
    ----------
    stiffness : sparse array, shape (n, n)
        K, with u^T K u / 2 the elastic energy [J].
    mass : sparse array, shape (n, n)
        M, consistent, with u'^T M u' / 2 the kinetic energy [J].
    patch_overlap : dict of str to sparse array, shape (n, n)
        D = int_patch N N^T dA of each damper patch, so that u^T D u = int_patch w^2 dA [m^4].
    interpolate : callable
        Maps positions (n_positions, 2) [m] to the sparse array (n_positions, n) that gives w
        there. Positions off the mesh raise ValueError.
    at_vertices : sparse array, shape (n_vertices, n)
        w at the vertices of the mesh.
    quadrature_position : ndarray, shape (n_quadrature, 2)
        Points [m] for the integration of a pressure on w.
    quadrature_weight : ndarray, shape (n_quadrature,)
        Weights [m^2]; they sum to the area.
    at_quadrature : sparse array, shape (n_quadrature, n)
        w at the quadrature points. The consistent load of a pressure p is
        ``at_quadrature.T @ (quadrature_weight * p)``.
    curvature_at_vertices : tuple of 3 sparse arrays, shape (n_vertices, n)
        kappa (see `section`) at the vertices, the mean over the cells that meet there [1/m].
    shear_at_vertices : tuple of 2 sparse arrays, shape (n_vertices, n)
        gamma (see `section`) likewise [-]; zero in a thin plate.
    section : Section
    """

    stiffness: sp.csr_array
    mass: sp.csr_array
    patch_overlap: dict[str, sp.csr_array]
    interpolate: Callable[[Array], sp.csr_array]
    at_vertices: sp.csr_array
    quadrature_position: Array
    quadrature_weight: Array
    at_quadrature: sp.csr_array
    curvature_at_vertices: tuple[sp.csr_array, ...]
    shear_at_vertices: tuple[sp.csr_array, ...]
    section: Section


@BilinearForm
def overlap_form(w, v, _):  # type: ignore[no-untyped-def]
    """int w v dA: times m'' the mass matrix; over a patch the D of the paper. (7)."""
    return w * v


def assembled_plate(
    mesh: PanelMesh,
    deflection: CellBasis,
    free: sp.csr_array,
    *,
    stiffness: sp.csr_array,
    mass: sp.csr_array,
    curvature_at_vertices: tuple[sp.csr_array, ...],
    shear_at_vertices: tuple[sp.csr_array, ...],
    section: Section,
) -> AssembledPlate:
    """What all plates have in common: patches, positions and loads of the deflection.

    Parameters
    ----------
    mesh : PanelMesh
    deflection : CellBasis
        Of w, with exact quadrature.
    free : sparse array, shape (deflection.N, n)
        Coordinates of w from the free coordinates.

    The others are attributes of `AssembledPlate`.
    """
    skmesh, element = deflection.mesh, deflection.elem

    def interpolate(positions: Array) -> sp.csr_array:
        return sp.csr_array(sp.csr_array(deflection.probes(np.asarray(positions).T)) @ free)

    patch_overlap = {}
    for name, members in mesh.patch_cells.items():
        patch = CellBasis(skmesh, element, quadrature=deflection.quadrature, elements=members)
        overlap = sp.csr_array(overlap_form.assemble(patch))
        patch_overlap[name] = sp.csr_array(free.T @ overlap @ free)

    load = CellBasis(skmesh, element, intorder=LOAD_ORDER)
    position = np.asarray(load.global_coordinates())
    return AssembledPlate(
        stiffness=stiffness,
        mass=mass,
        patch_overlap=patch_overlap,
        interpolate=interpolate,
        at_vertices=sp.csr_array(free[deflection.nodal_dofs[0]]),
        quadrature_position=position.reshape(2, -1).T,
        quadrature_weight=load.dx.ravel(),
        at_quadrature=sp.csr_array(
            at_quadrature(load, [function[0] for function in load.basis]) @ free
        ),
        curvature_at_vertices=curvature_at_vertices,
        shear_at_vertices=shear_at_vertices,
        section=section,
    )


def at_quadrature(basis: CellBasis, values: Sequence[Array]) -> sp.csr_array:
    """Matrix (n_quadrature, n_dofs) from the values (n_cells, n_points) of each basis function."""
    n_cells, n_points = basis.dx.shape
    point = np.arange(n_cells * n_points)
    columns = [np.repeat(dofs, n_points) for dofs in basis.element_dofs]
    return sp.csr_array(
        (
            np.concatenate([np.asarray(value).ravel() for value in values]),
            (np.tile(point, len(values)), np.concatenate(columns)),
        ),
        shape=(len(point), basis.N),
    )


def corner_basis(mesh: Mesh, element: Element) -> CellBasis:
    """A basis whose quadrature points are the corners of the cells."""
    corners = mesh.elem.doflocs[: mesh.t.shape[0]].T
    return CellBasis(mesh, element, quadrature=(corners, np.ones(corners.shape[1])))


def corner_mean(mesh: Mesh) -> sp.csr_array:
    """Matrix (n_vertices, n_cells * n_corners): mean over the cells that meet at a vertex."""
    vertex = mesh.t.T.ravel()
    share = 1 / np.bincount(vertex)[vertex]
    return sp.csr_array((share, (vertex, np.arange(len(vertex)))))
