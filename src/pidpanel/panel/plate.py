"""Finite elements of the panel (scikit-fem): stiffness, mass and patch overlap of a plate.

The thin plate is Kirchhoff's, with the deflection w in a C1 element: Bogner-Fox-Schmit (bicubic)
on axis-parallel rectangles, Argyris (quintic) on triangles. All matrices act on the free
coordinates u of the supported plate, w(x, y) = sum_i N_i(x, y) u_i, where every N_i already
satisfies the supports; whoever uses them needs to know neither the element nor its supports.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from skfem import (
    BilinearForm,
    CellBasis,
    Element,
    ElementQuadBFS,
    ElementTriArgyris,
    Mesh,
    MeshQuad,
    MeshTri,
)
from skfem.helpers import dd

from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.section import Section, ThinSection

# Exact integration: of products of two bicubics (degree 6 in each of x and y), of two quintics.
EXACT_ORDER = {"quadrilaterals": 6, "triangles": 10}
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
    interpolate: Callable[[NDArray[np.float64]], sp.csr_array]
    at_vertices: sp.csr_array
    quadrature_position: NDArray[np.float64]
    quadrature_weight: NDArray[np.float64]
    at_quadrature: sp.csr_array
    curvature_at_vertices: tuple[sp.csr_array, ...]
    shear_at_vertices: tuple[sp.csr_array, ...]
    section: Section


@BilinearForm
def bending_form(w, v, section):  # type: ignore[no-untyped-def]
    """int kappa(v) . D kappa(w) dA: virtual work of bending."""
    return np.einsum("i...,ij,j...->...", _bent(v), section.bending, _bent(w))


def _bent(w):  # type: ignore[no-untyped-def]
    """-kappa = (w_,xx, w_,yy, 2 w_,xy)."""
    H = dd(w)
    return np.array([H[0, 0], H[1, 1], 2 * H[0, 1]])


@BilinearForm
def overlap_form(w, v, _):  # type: ignore[no-untyped-def]
    """int w v dA: times m'' the mass matrix; over a patch the D of the paper. (7)."""
    return w * v


def assemble_thin_plate(mesh: PanelMesh, section: ThinSection) -> AssembledPlate:
    """Assemble a thin plate, simply supported along its whole outline.

    On a straight edge with tangent t, w = 0 is essential, and with it its derivatives along
    the edge, w_,t = 0 and w_,tt = 0; the bending moment vanishes by itself (natural condition).

    Parameters
    ----------
    mesh : PanelMesh
        Quadrilaterals must be axis-parallel rectangles.
    section : ThinSection

    Returns
    -------
    AssembledPlate

    Raises
    ------
    ValueError
        If a quadrilateral is no axis-parallel rectangle.
    """
    skmesh: Mesh
    element: Element
    vertices, cells = np.ascontiguousarray(mesh.vertices.T), np.ascontiguousarray(mesh.cells.T)
    if mesh.cell_kind == "quadrilaterals":
        _check_rectangles(mesh)
        skmesh, element = MeshQuad(vertices, cells), _CentredBFS()
    else:
        skmesh, element = MeshTri(vertices, cells), _CentredArgyris()
    order = EXACT_ORDER[mesh.cell_kind]
    basis = CellBasis(skmesh, element, intorder=order)
    free = _simply_supported_coordinates(skmesh, basis)

    def reduced(matrix: sp.csr_matrix) -> sp.csr_array:
        return sp.csr_array(free.T @ sp.csr_array(matrix) @ free)

    def interpolate(positions: NDArray[np.float64]) -> sp.csr_array:
        return sp.csr_array(sp.csr_array(basis.probes(np.asarray(positions).T)) @ free)

    patch_overlap = {}
    for name, members in mesh.patch_cells.items():
        patch = CellBasis(skmesh, element, intorder=order, elements=members)
        patch_overlap[name] = reduced(overlap_form.assemble(patch))

    load = CellBasis(skmesh, element, intorder=LOAD_ORDER)
    position = np.asarray(load.global_coordinates())
    return AssembledPlate(
        stiffness=reduced(bending_form.assemble(basis, bending=section.bending)),
        mass=reduced(section.mass_per_area * overlap_form.assemble(basis)),
        patch_overlap=patch_overlap,
        interpolate=interpolate,
        at_vertices=sp.csr_array(free[basis.nodal_dofs[0]]),
        quadrature_position=position.reshape(2, -1).T,
        quadrature_weight=load.dx.ravel(),
        at_quadrature=sp.csr_array(
            at_quadrature(load, [function[0] for function in load.basis]) @ free
        ),
        curvature_at_vertices=_curvature_at_vertices(skmesh, element, free),
        shear_at_vertices=(sp.csr_array((len(mesh.vertices), free.shape[1])),) * 2,
        section=section,
    )


def _curvature_at_vertices(
    mesh: Mesh, element: Element, free: sp.csr_array
) -> tuple[sp.csr_array, ...]:
    """kappa = -(w_,xx, w_,yy, 2 w_,xy) at the vertices."""
    corners = corner_basis(mesh, element)
    mean = corner_mean(mesh)
    return tuple(
        sp.csr_array(
            mean
            @ at_quadrature(
                corners, [-factor * function[0].hess[i, j] for function in corners.basis]
            )
            @ free
        )
        for factor, i, j in ((1, 0, 0), (1, 1, 1), (2, 0, 1))
    )


class _CellCentred:
    """Let scikit-fem build a global C1 element in coordinates centred on each cell.

    scikit-fem inverts, cell by cell, a Vandermonde matrix of monomials in the global x and y.
    Away from the origin the monomials of a small cell are nearly dependent: for cells of 0.1 m
    10 m from the origin the mass of Argyris elements is wrong by 5e-4. Centred on the cell it
    is right to rounding wherever the panel lies.
    """

    def gdof(self, F, w, i):  # type: ignore[no-untyped-def]
        """Degree of freedom i, with vertices v and edge midpoints e seen from the centre."""
        centre = w["v"].mean(axis=0)
        return super().gdof(F, {**w, "v": w["v"] - centre, "e": w["e"] - centre}, i)

    def gbasis(self, mapping, X, i, tind=None):  # type: ignore[no-untyped-def]
        """Basis function i at the local points X, seen from the centre."""
        return super().gbasis(_CentredMapping(mapping), X, i, tind)


class _CentredMapping:
    """A scikit-fem mapping whose positions are seen from the centre of each cell."""

    def __init__(self, mapping) -> None:  # type: ignore[no-untyped-def]
        self.mapping = mapping
        self.mesh = mapping.mesh

    def F(self, X, tind=None):  # type: ignore[no-untyped-def]
        cells = self.mesh.t if tind is None else self.mesh.t[:, tind]
        centre = self.mesh.p[:, cells].mean(axis=1)
        return self.mapping.F(X, tind=tind) - centre[:, :, None]


class _CentredBFS(_CellCentred, ElementQuadBFS):
    """Bogner-Fox-Schmit: w, w_x, w_y, w_xy at the vertices."""


class _CentredArgyris(_CellCentred, ElementTriArgyris):
    """Argyris: w, its gradient and its Hessian at the vertices, w_n at the edge midpoints."""


def _simply_supported_coordinates(mesh: Mesh, basis: CellBasis) -> sp.csr_array:
    """Columns that span all deflections with w = 0 on the outline, shape (n_dofs, n).

    At a vertex of the outline, w = 0, and for each of its outline edges, with tangent t,
    w_,a t_a = 0 and w_,ab t_a t_b = 0. What these rows leave free is their null space, found
    separately for the first and the second derivatives: they have different units.
    """
    dofs = {name: basis.nodal_dofs[k] for k, name in enumerate(basis.elem.dofnames[:6])}
    first = np.array([dofs["u_x"], dofs["u_y"]])
    second_names = [name for name in ("u_xx", "u_xy", "u_yy") if name in dofs]
    second = np.array([dofs[name] for name in second_names])

    start, end = mesh.facets[:, mesh.boundary_facets()]
    tangent = mesh.p[:, end] - mesh.p[:, start]
    tangent = tangent / np.linalg.norm(tangent, axis=0)
    tx, ty = tangent
    along_first = np.array([tx, ty])
    along_second = {"u_xx": tx**2, "u_xy": 2 * tx * ty, "u_yy": ty**2}
    rows_second = np.array([along_second[name] for name in second_names])

    constrained: list[NDArray[np.int64]] = []
    columns: list[tuple[NDArray[np.int64], NDArray[np.float64]]] = []
    for vertex in np.unique(np.concatenate([start, end])):
        edges = (start == vertex) | (end == vertex)
        constrained.append(np.array([dofs["u"][vertex]]))
        for block, rows in ((first, along_first), (second, rows_second)):
            constrained.append(block[:, vertex])
            for direction in _null_space(rows[:, edges].T).T:
                columns.append((block[:, vertex], direction))

    untouched = np.setdiff1d(np.arange(basis.N), np.concatenate(constrained))
    identity = sp.csr_array(sp.identity(basis.N, format="csr")[:, untouched])
    if not columns:
        return identity
    row = np.concatenate([block for block, _ in columns])
    column = np.repeat(np.arange(len(columns)), [len(block) for block, _ in columns])
    value = np.concatenate([direction for _, direction in columns])
    edge_columns = sp.csr_array((value, (row, column)), shape=(basis.N, len(columns)))
    return sp.csr_array(sp.hstack([identity, edge_columns]))


def _null_space(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Orthonormal null space, shape (n_columns, n_free), of a few rows of order one.

    Two edges of the outline count as one straight line if their directions differ by less
    than 1e-6: beyond what a mesh file rounds, below any corner meant.
    """
    _, values, right = np.linalg.svd(rows)
    rank = int(np.sum(values > 1e-6))
    return right[rank:].T


def at_quadrature(basis: CellBasis, values: Sequence[NDArray[np.float64]]) -> sp.csr_array:
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


def _check_rectangles(mesh: PanelMesh) -> None:
    """Refuse quadrilaterals on which the Bogner-Fox-Schmit element is not C1."""
    corners = mesh.vertices[mesh.cells]
    extent = np.ptp(corners, axis=1)
    edges = np.abs(np.roll(corners, -1, axis=1) - corners)
    # each edge runs along x or along y: its smaller component vanishes
    skew = np.min(edges, axis=2).max(axis=1) / extent.min(axis=1)
    worst = int(np.argmax(skew))
    if skew[worst] > 1e-9:
        raise ValueError(
            f"cell {worst} with corners {corners[worst].tolist()} m is no axis-parallel"
            " rectangle; quadrilaterals of a thin plate must be, or use triangles"
        )
