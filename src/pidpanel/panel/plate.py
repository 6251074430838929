"""A supported plate as matrices, whatever its theory and its element.

All matrices act on the free coordinates u of the supported plate, w(x, y) = sum_i N_i(x, y) u_i,
where every N_i already satisfies the supports; whoever uses them needs to know neither the
element nor its supports. Thin plates are assembled in `thin`, plates with shear in `mindlin`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from skfem import (
    BilinearForm,
    CellBasis,
    Element,
    ElementQuad1,
    ElementTriP1,
    FacetBasis,
    Mesh,
)

from pidpanel.arrays import Array, Index
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.section import Section
from pidpanel.panel.supports import Supports, edge_springs

# Quadrature of pressure times deflection: 3 × 3 Gauss points on a quadrilateral, 7 on a triangle.
LOAD_ORDER = 5
EDGE_ORDER = 10  # of products of slopes along an edge: quintics have 8
# Share of the extent of the panel: a position this far off it is on it.
CLOSE = 1e-6
ROUNDING = 1e-12  # of shape functions
NONE_FREE = "mesh: every vertex is on a support; the panel needs vertices that are free to move"


@dataclass(frozen=True)
class AssembledPlate(PlateMatrices):
    """Matrices of a supported plate, and w anywhere on it."""

    # Maps positions (n_positions, 2) [m] to the sparse array (n_positions, n) that gives w there.
    # Positions off the mesh raise ValueError.
    interpolate: Callable[[Array], sp.csr_array]
    section: Section
    # Two matrices (n_quadrature, n): ∂w/∂x and ∂w/∂y at the points of a pressure [1]
    slope_at_quadrature: tuple[sp.csr_array, ...] = ()


@BilinearForm
def overlap_form(w, v, _):  # type: ignore[no-untyped-def]
    """Return ∫ w v dA: times m″ the mass matrix; over a patch, D of the paper's Eq. 7."""
    return w * v


@BilinearForm
def bending_form(b, c, section):  # type: ignore[no-untyped-def]
    """Return the virtual work of bending, ∫ κ(c)·D κ(b) dA."""
    return np.einsum("i...,ij,j...->...", bent(c), section.bending, bent(b))


def assemble_matrix(form: BilinearForm, *bases: CellBasis, **fields: object) -> sp.csr_array:
    """Return the matrix of a form; scikit-fem returns it as a `scipy.sparse.spmatrix`."""
    return sp.csr_array(form.assemble(*bases, **fields))


def bent(field):  # type: ignore[no-untyped-def]
    """Return −κ of a deflection with second derivatives, or of a rotation of the normals."""
    G = field.grad if field.hess is None else field.hess
    return np.array([G[0, 0], G[1, 1], G[0, 1] + G[1, 0]])


@BilinearForm
def turning_form(b, c, w):  # type: ignore[no-untyped-def]
    """Return the virtual work of springs along edges that resist the rotation about them."""
    turns = (np.asarray(field) if field.hess is None else field.grad for field in (b, c))
    first, second = (np.sum(turn * w.n, axis=0) for turn in turns)
    return w.stiffness * first * second


def edge_stiffness(basis: CellBasis, mesh: PanelMesh, supports: Supports) -> sp.csr_array:
    """Return the stiffness of springs along edges in the coordinates of a slope or a rotation."""
    total = sp.csr_array((basis.N, basis.N))
    springs, number = edge_springs(mesh, supports), facet_numbers(basis.mesh)
    for value in set(springs.values()):
        facets = np.array([number[edge] for edge, k in springs.items() if k == value])
        along = FacetBasis(basis.mesh, basis.elem, facets=facets, intorder=EDGE_ORDER)
        total = total + assemble_matrix(turning_form, along, stiffness=value)
    return sp.csr_array(total)


def assembled_plate(
    mesh: PanelMesh,
    deflection: CellBasis,
    free: sp.csr_array,
    *,
    stiffness: sp.csr_array,
    mass: sp.csr_array,
    curvature_at_vertices: tuple[sp.csr_array, ...],
    shear_at_vertices: tuple[sp.csr_array, ...],
    reactions: sp.csr_array,
    section: Section,
) -> AssembledPlate:
    """Assemble what all plate theories share: patches, positions and loads of the deflection."""
    skmesh, element = deflection.mesh, deflection.elem

    def interpolate(positions: Array) -> sp.csr_array:
        return sp.csr_array(values_at(deflection, np.asarray(positions, dtype=float)) @ free)

    patch_overlap = {}
    for name, members in mesh.patch_cells.items():
        patch = CellBasis(skmesh, element, quadrature=deflection.quadrature, elements=members)
        overlap = assemble_matrix(overlap_form, patch)
        patch_overlap[name] = sp.csr_array(free.T @ overlap @ free)

    at_vertices = sp.csr_array(free[deflection.nodal_dofs[0]])
    if not np.any(at_vertices.data):
        raise ValueError(NONE_FREE)
    points = np.array(list(mesh.points.values()), dtype=float).reshape(-1, 2)
    rows = interpolate(points)
    rows.data[np.abs(rows.data) < ROUNDING] = 0.0  # on a support nothing moves
    rows.eliminate_zeros()
    linear = ElementTriP1() if mesh.cell_kind == "triangles" else ElementQuad1()
    load = CellBasis(skmesh, element, intorder=LOAD_ORDER)
    position = np.asarray(load.global_coordinates())
    values = [function[0] for function in load.basis]
    at_quadrature = sp.csr_array(at_points(values, load.element_dofs, load.N) @ free)
    slopes = ([function[0].grad[k] for function in load.basis] for k in range(2))
    return AssembledPlate(
        stiffness=stiffness,
        mass=mass,
        patch_overlap=patch_overlap,
        interpolate=interpolate,
        at_vertices=at_vertices,
        at_points=rows,
        point_weight=values_at(CellBasis(skmesh, linear), points),
        quadrature_position=position.reshape(2, -1).T,
        quadrature_weight=load.dx.ravel(),
        at_quadrature=at_quadrature,
        curvature_at_vertices=curvature_at_vertices,
        shear_at_vertices=shear_at_vertices,
        reactions=(reactions, sp.csr_array(reactions.shape)),
        section=section,
        slope_at_quadrature=tuple(
            sp.csr_array(at_points(slope, load.element_dofs, load.N) @ free) for slope in slopes
        ),
        inertia=section.mass_per_area * (at_quadrature.T @ load.dx.ravel()),
    )


def values_at(basis: CellBasis, positions: Array) -> sp.csr_array:
    """Return the matrix (n_positions, n_dofs) of a field from its coordinates.

    A position off the mesh by rounding, as on an oblique edge, takes the value of its cell there.
    """
    corners = basis.mesh.p[:, basis.mesh.t].transpose(2, 1, 0)  # (n_cells, k, 2)
    step = np.roll(corners, -1, axis=1) - corners
    step /= np.linalg.norm(step, axis=2, keepdims=True)
    centre = corners.mean(axis=1, keepdims=True)

    def aside(place: Array) -> Array:
        """Return the distance from each edge, positive to its left, (n_cells, k)."""
        x, y = np.moveaxis(place - corners, 2, 0)
        return np.asarray(step[..., 0] * y - step[..., 1] * x)

    turn = np.sign(aside(centre))
    cells = np.zeros(len(positions), dtype=np.int64)
    for number, position in enumerate(positions):
        depth = (turn * aside(position)).min(axis=1)
        cells[number] = np.argmax(depth)
        if depth.max() < -CLOSE * np.ptp(basis.mesh.p, axis=1).max():
            raise ValueError(f"({position[0]:g}, {position[1]:g}) m is not on the panel")
    local = basis.mapping.invF(positions.T[:, :, None], tind=cells)
    values = [basis.elem.gbasis(basis.mapping, local, k, tind=cells)[0] for k in range(basis.Nbfun)]
    return at_points(values, basis.element_dofs[:, cells], basis.N)


def at_points(values: Sequence[Array], element_dofs: Index, n_dofs: int) -> sp.csr_array:
    """Return the matrix (n_cells · n_points, n_dofs) of basis functions from their values.

    Parameters
    ----------
    values
        (n_cells, n_points) values of each basis function of a cell.
    element_dofs
        (n_functions, n_cells) coordinates of the functions of each cell.
    """
    data = np.asarray([np.asarray(value) for value in values])
    _, n_cells, n_points = data.shape
    row = np.tile(np.arange(n_cells * n_points), len(data))
    column = np.repeat(element_dofs, n_points, axis=1).ravel()
    return sp.csr_array((data.ravel(), (row, column)), shape=(n_cells * n_points, n_dofs))


def facet_numbers(mesh: Mesh) -> dict[tuple[int, int], int]:
    """Return the number of each edge by its vertices, the smaller first."""
    pairs = np.sort(mesh.facets, axis=0).T.tolist()
    return {(start, end): number for number, (start, end) in enumerate(pairs)}


def corner_basis(mesh: Mesh, element: Element) -> CellBasis:
    """Return a basis whose quadrature points are the corners of the cells."""
    corners = mesh.elem.doflocs[: mesh.t.shape[0]].T
    return CellBasis(mesh, element, quadrature=(corners, np.ones(corners.shape[1])))


def vertex_values(
    corners: CellBasis, value: Callable[..., Array], free: sp.csr_array
) -> sp.csr_array:
    """Return the matrix (n_vertices, n) of a value of the field, the mean over cells at a vertex.

    Parameters
    ----------
    corners
        A `corner_basis`.
    value
        Value of a basis function, such as `bent`.
    free
        Matrix from the free coordinates to those of the elements.
    """
    vertex = corners.mesh.t.T.ravel()
    share = 1 / np.bincount(vertex)[vertex]
    mean = sp.csr_array((share, (vertex, np.arange(len(vertex)))))
    values = [value(function[0]) for function in corners.basis]
    return sp.csr_array(mean @ at_points(values, corners.element_dofs, corners.N) @ free)
