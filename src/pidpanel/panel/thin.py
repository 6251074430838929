"""Thin (Kirchhoff) plate in C1 elements (scikit-fem).

Bogner-Fox-Schmit (bicubic) on axis-parallel rectangles, Argyris (quintic) on triangles.
"""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from skfem import CellBasis, ElementQuadBFS, ElementTriArgyris, LinearForm
from skfem.element import DiscreteField

from pidpanel.arrays import Array
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import (
    AssembledPlate,
    assemble_matrix,
    assembled_plate,
    bending_form,
    bent,
    corner_basis,
    edge_stiffness,
    facet_numbers,
    overlap_form,
    vertex_values,
)
from pidpanel.panel.point_supports import support_reactions
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import (
    Block,
    HeldVertex,
    Supports,
    free_coordinates,
    held_vertices,
    null_space,
    vertex_spacing,
)

# Exact integration: of products of two bicubics (degree 6 in each of x and y), of two quintics.
EXACT_ORDER = {"quadrilaterals": 6, "triangles": 10}
SIMPLY_SUPPORTED = Supports()
# ∫ v, ∫ x v, ∫ y v: loads that find the coordinates of the deflections 1, x and y
RIGID_LOADS = (lambda v, w: v, lambda v, w: w.x[0] * v, lambda v, w: w.x[1] * v)
DERIVATIVES = ("u", "u_x", "u_y", "u_xx", "u_xy", "u_yy")


def assemble_thin_plate(
    mesh: PanelMesh, section: ThinSection, supports: Supports = SIMPLY_SUPPORTED
) -> AssembledPlate:
    """Assemble a thin plate; by default its outline is simply supported.

    Deflections and slopes that a support forbids are essential conditions, with what follows from
    them along the edge; moments and forces vanish by themselves (natural conditions). Hard and soft
    simple supports are the same: a thin plate's normals follow its slope. Quadrilaterals must be
    axis-parallel rectangles. Raises `ValueError` for a support that does not fit the mesh.
    """
    skmesh = mesh.elements
    element = _CentredBFS() if mesh.cell_kind == "quadrilaterals" else _CentredArgyris()
    basis = CellBasis(skmesh, element, intorder=EXACT_ORDER[mesh.cell_kind])
    free = free_coordinates(basis.N, _support_blocks(mesh, basis, supports))
    stiffness = assemble_matrix(bending_form, basis, bending=section.bending)
    stiffness = stiffness + edge_stiffness(basis, mesh, supports)
    mass = section.mass_per_area * assemble_matrix(overlap_form, basis)
    held_dofs = basis.nodal_dofs[0], basis.nodal_dofs[1:3]
    corners = corner_basis(skmesh, element)
    return assembled_plate(
        mesh,
        basis,
        free,
        stiffness=sp.csr_array(free.T @ stiffness @ free),
        mass=sp.csr_array(free.T @ mass @ free),
        curvature_at_vertices=tuple(
            vertex_values(corners, lambda w, k=k: -bent(w)[k], free) for k in range(3)
        ),
        shear_at_vertices=(sp.csr_array((len(mesh.vertices), free.shape[1])),) * 2,
        reactions=support_reactions(mesh, section, supports.points, stiffness, free, *held_dofs),
        section=section,
    )


class _CellCentred:
    """A global C1 element of scikit-fem, built in coordinates centred on each cell.

    scikit-fem inverts, cell by cell, a Vandermonde matrix of monomials in the global x and y.
    Away from the origin the monomials of a small cell are nearly dependent: for cells of 0.1 m
    10 m from the origin the mass of Argyris elements is wrong by 5e-4. Centred on the cell it
    is right to rounding wherever the panel lies.
    """

    def gdof(self, F, w, i):  # type: ignore[no-untyped-def]
        """Return degree of freedom i, with vertices v and edge midpoints e seen from the centre."""
        centre = w["v"].mean(axis=0)
        return super().gdof(F, {**w, "v": w["v"] - centre, "e": w["e"] - centre}, i)

    def gbasis(self, mapping, X, i, tind=None):  # type: ignore[no-untyped-def]
        """Return basis function i at the local points X, seen from the centre."""
        points, previous = (mapping, X, tind), getattr(self, "_points", (None,) * 3)
        if any(new is not old for new, old in zip(points, previous, strict=True)):
            self._points, self._fields = points, self._all_functions(*points)
        return (self._fields[i],)

    def _all_functions(self, mapping, X, tind):  # type: ignore[no-untyped-def]
        """Return all basis functions, each a sum of the same monomials.

        scikit-fem evaluates the monomials again for each of the 21 functions of an Argyris element.
        """
        cells = mapping.mesh.t if tind is None else mapping.mesh.t[:, tind]
        if self.V is None:
            self._pbasis_init(self.maxdeg, self.dim, self.derivatives, self.tensorial_basis)
            self.V = np.linalg.inv(self._eval_dofs(mapping.mesh))
        V = (self.V if tind is None else self.V[tind]).swapaxes(1, 2)
        centre = mapping.mesh.p[:, cells].mean(axis=1)
        x, y = mapping.F(X, tind=tind) - centre[:, :, None]

        def derivative(*along):  # type: ignore[no-untyped-def]
            monomials = np.stack(
                [np.broadcast_to(power(x, y), x.shape) for power in self._pbasis[along]], axis=1
            )
            return np.ascontiguousarray((V @ monomials).swapaxes(0, 1))  # (function, cell, point)

        hessian = derivative(0, 0), derivative(0, 1), derivative(1, 1)
        return [
            DiscreteField(value, grad=np.array(gradient), hess=np.array([[xx, xy], [xy, yy]]))
            for value, *gradient, xx, xy, yy in zip(
                derivative(), derivative(0), derivative(1), *hessian, strict=True
            )
        ]


class _CentredBFS(_CellCentred, ElementQuadBFS):
    """Bogner-Fox-Schmit: w, w_x, w_y, w_xy at the vertices."""


class _CentredArgyris(_CellCentred, ElementTriArgyris):
    """Argyris: w, its gradient and its Hessian at the vertices, w_n at the edge midpoints."""


def _support_blocks(mesh: PanelMesh, basis: CellBasis, supports: Supports) -> list[Block]:
    """Return the blocks of coordinates that the supports hold."""
    at_vertex = {name: basis.nodal_dofs[k] for k, name in enumerate(basis.elem.dofnames[:6])}
    names = [name for name in DERIVATIVES if name in at_vertex]
    columns = [DERIVATIVES.index(name) for name in names]
    order = np.array([name.count("x") + name.count("y") for name in names])
    vertices, edges = held_vertices(mesh, supports)
    spacing = vertex_spacing(mesh)
    rows = {vertex.vertex: _forbidden(vertex, spacing[vertex.vertex]) for vertex in vertices}
    owner = dict.fromkeys(rows, "a supported edge")
    for name, point in supports.points.items():
        if point.radius == 0:
            vertex = point.vertex(mesh, name)
            forbidden = np.eye(6)[: 1 if point.kind == "hinge" else 3]
            rows[vertex] = np.vstack([rows.get(vertex, np.zeros((0, 6))), forbidden])
            owner[vertex] = name
    blocks = []
    for vertex, forbidden in rows.items():
        dofs = np.array([at_vertex[name][vertex] for name in names])
        # rows are for h^k times the k-th derivatives, which have one unit
        span = null_space(forbidden[:, columns]) / spacing[vertex] ** order[:, None]
        blocks.append(Block(owner[vertex], dofs, span))

    clamped = [edge for edge, (kind, _) in edges.items() if kind == "clamped"]
    if clamped and basis.facet_dofs.size:
        facet = facet_numbers(basis.mesh)
        slopes = basis.facet_dofs[0, [facet[edge] for edge in clamped]]
        blocks.append(Block("a clamped edge", slopes, np.zeros((len(slopes), 0))))

    feet = {name: point for name, point in supports.points.items() if point.radius > 0}
    if feet:
        loads = [LinearForm(load).assemble(basis) for load in RIGID_LOADS]
        mass = sp.csc_array(assemble_matrix(overlap_form, basis))
        rigid = spla.splu(mass).solve(np.column_stack(loads))
        for name, foot in feet.items():
            dofs = np.unique(basis.element_dofs[:, foot.foot_cells(mesh, name)])
            blocks.append(Block(name, dofs, foot.foot_motion(rigid[dofs])))
    return blocks


def _forbidden(vertex: HeldVertex, h: float) -> Array:
    """Return the rows on (w, h w_x, h w_y, h² w_xx, h² w_xy, h² w_yy) that vanish at a vertex.

    With t along the edge and s the length along it: w = 0, so w_,t = 0 and
    d² w/ds² = w_,ab t_a t_b + w_,a dt_a/ds = 0. Clamped, grad w = 0, so w_,ab t_b = 0.
    """
    rows = [[1.0, 0, 0, 0, 0, 0]]
    for kind, (tx, ty), turn in vertex.edges:
        if kind == "clamped":
            rows += [[0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0]]
            rows += [[0, 0, 0, tx, ty, 0], [0, 0, 0, 0, tx, ty]]
        else:
            rows += [[0, tx, ty, 0, 0, 0], [0, *(h * turn), tx * tx, 2 * tx * ty, ty * ty]]
    return np.array(rows)
