"""Strains and motions of a degenerated shell with six degrees of freedom a node.

A point at depth ζ along the normal n moves by u + ζ θ × n. With local axes e₁, e₂ and the curvature
W_kj = e_k·∂_j n of the surface, strains are ε + ζκ to first order in ζ:

    ε_ij = e_i·∂_j u,   κ_ij = e_i·∂_j(θ × n) − Σ_k (e_i·∂_k u) W_kj,   γ_j = n·∂_j u + e_j·(θ × n),

with ε and κ made symmetric (ε₁, ε₂, 2ε₁₂). The drilling rotation θ·n has no strain. A penalty makes
it the rotation of the surface, ½ (e₂·∂₁u − e₁·∂₂u), so that parts may meet at any angle (Hughes and
Brezzi 1989).
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.panel.section import Layer, SandwichSection, Section, ThinSection
from pidpanel.shell.mesh import ShellMesh, lagrange
from pidpanel.shell.selections import Place

SHEAR_CORRECTION = 5 / 6  # of a thin section, whose shear hardly matters
# Stiffness of the drilling rotation over A₆₆, and its inertia over that of the normals: small, so
# that modes do not move, but no singular matrices. With A₆₆ itself clamped edges, which hold the
# rotation at their nodes, made the torsion of a reflector 0.6 % too stiff.
DRILLING, DRILLING_INERTIA = 1e-3, 1e-3
PARALLEL = 1e-3  # sine of the angle between an axis and the normal below which it has no direction


@dataclass(frozen=True)
class Layup:
    """A section with its x axis along the projection of an axis onto the surface.

    The middle of the section may lie off the surface, by ``offset`` [m] along the normal.
    """

    section: Section
    axis: Place = (1.0, 0.0, 0.0)
    offset: float = 0.0

    @property
    def stiffness(self) -> Array:
        """(9, 9) of (ε, κ, γ, drilling): A, B, D and S of the section, and the penalty."""
        section = self.section
        C = np.zeros((9, 9))
        if isinstance(section, SandwichSection):
            C[:3, :3], C[:3, 3:6], C[3:6, 3:6] = section.abd
            C[3:6, :3] = C[:3, 3:6].T
        else:
            C[:3, :3], C[3:6, 3:6] = section.extensional, section.bending
        if isinstance(section, ThinSection):
            C[6:8, 6:8] = SHEAR_CORRECTION * C[2, 2] * np.eye(2)
        else:
            C[6:8, 6:8] = section.shear
        C[8, 8] = DRILLING * C[2, 2]
        moved = np.eye(9)
        moved[:3, 3:6] = self.offset * np.eye(3)  # ε of the middle
        return moved.T @ C @ moved

    @property
    def density(self) -> tuple[float, float, float]:
        """Moments ∫ρ ζᵏ dζ of order 0, 1, 2."""
        section, z = self.section, self.offset
        if isinstance(section, SandwichSection):
            mass, first, second = section.density_moments
            mass += section.extra_mass_per_area
        else:  # evenly over its thickness
            mass, first = section.mass_per_area, 0.0
            second = mass * section.thickness**2 / 12
        return mass, first + z * mass, second + 2 * z * first + z**2 * mass

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Outer surfaces as in `section`, but (3, 6) of κ and ε/h, h the largest depth."""
        half = self.half
        if isinstance(self.section, SandwichSection):
            layers = []
            for name, ply, outer, _ in self.section.placed:
                depth = outer + self.offset
                strain = ply.strain_in_fibre_axes @ np.hstack([depth * np.eye(3), half * np.eye(3)])
                layers.append(Layer(name, strain, ply.material.stiffness @ strain))
            return tuple(layers)
        stretch, z = self.section.extensional / self.section.thickness, self.offset
        return tuple(
            Layer(
                layer.name,
                np.hstack([layer.strain + z * np.eye(3), half * np.eye(3)]),
                np.hstack([layer.stress + z * stretch, half * stretch]),
            )
            for layer in self.section.layers
        )

    @property
    def half(self) -> float:
        """Largest depth of a layer [m]."""
        if isinstance(self.section, SandwichSection):
            return max(abs(outer) for _, _, outer, _ in self.section.placed)
        return self.section.thickness / 2

    @property
    def has_direction(self) -> bool:
        """Whether a turn of the axis changes the stiffness."""
        C = self.stiffness
        turn = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, -0.5], [-1.0, 1.0, 0.0]])  # by 45°
        blocks = [C[:3, :3], C[:3, 3:6], C[3:6, 3:6]]
        changes = [np.abs(turn.T @ block @ turn - block).max() for block in blocks]
        scale = [np.abs(C[:3, :3]).max(), np.sqrt(np.abs(C).max() * C[3, 3]), C[3, 3]]
        shear = np.ptp(C[[6, 7], [6, 7]]) + 2 * abs(C[6, 7])
        return bool(np.any(np.array(changes) > 1e-9 * np.array(scale)) or shear > 1e-9 * C[6, 6])


@dataclass(frozen=True)
class Frames:
    """A surface at places in its cells: positions, local axes and curvature."""

    value: Array  # (n_places, k) shape functions, or (n_cells, n_places, k)
    slope: Array  # (n_cells, n_places, k, 2) their derivatives along e₁, e₂ [1/m]
    position: Array  # (n_cells, n_places, 3) [m]
    axes: Array  # (n_cells, n_places, 3, 3) rows e₁, e₂, n
    curvature: Array  # (n_cells, n_places, 2, 2) W [1/m]
    area: Array  # (n_cells, n_places) [m²] per unit of the reference triangle

    @property
    def strains(self) -> Array:
        """(n_cells, n_places, 9, 6k) of (ε, κ, γ, drilling) per displacement and rotation."""
        e, n = self.axes[:, :, :2], self.axes[:, :, 2]
        N, d = np.broadcast_to(self.value, self.slope.shape[:3]), self.slope
        gradient = np.einsum("cqix,cqaj->cqijax", e, d)
        across = np.cross(n[:, :, None], e)  # e_i·(θ × n) = θ·(n × e_i)
        turned = np.einsum("cqkj,cqkx->cqjx", self.curvature, e)  # ∂_j n
        swing = np.cross(turned[:, :, None], e[:, :, :, None])  # (…, i, j, x)
        rotation = np.einsum("cqix,cqaj->cqijax", across, d)
        rotation += np.einsum("cqijx,cqa->cqijax", swing, N)
        bent = -np.einsum("cqikax,cqkj->cqijax", gradient, self.curvature)
        rows = np.zeros((*self.slope.shape[:2], 9, d.shape[2], 6))
        for i in (0, 1):
            rows[:, :, i, :, :3] = gradient[:, :, i, i]
            rows[:, :, 3 + i, :, :3], rows[:, :, 3 + i, :, 3:] = (
                bent[:, :, i, i],
                rotation[:, :, i, i],
            )
            rows[:, :, 6 + i, :, :3] = np.einsum("cqx,cqa->cqax", n, d[..., i])
            rows[:, :, 6 + i, :, 3:] = np.einsum("cqx,cqa->cqax", across[:, :, i], N)
        rows[:, :, 2, :, :3] = gradient[:, :, 0, 1] + gradient[:, :, 1, 0]
        rows[:, :, 5, :, :3] = bent[:, :, 0, 1] + bent[:, :, 1, 0]
        rows[:, :, 5, :, 3:] = rotation[:, :, 0, 1] + rotation[:, :, 1, 0]
        rows[:, :, 8, :, :3] = (gradient[:, :, 0, 1] - gradient[:, :, 1, 0]) / 2
        rows[:, :, 8, :, 3:] = np.einsum("cqx,cqa->cqax", n, N)
        return rows.reshape(*rows.shape[:3], 6 * rows.shape[3])

    def stiffness(self, layup: Layup, area: Array) -> Array:
        """Return K (n_cells, 6k, 6k), integrated with weights (n_cells, n_places) [m²]."""
        rows = self.strains
        forces = (layup.stiffness @ rows) * area[:, :, None, None]
        flat = len(rows), -1, rows.shape[3]
        return np.asarray(rows.reshape(flat).swapaxes(1, 2) @ forces.reshape(flat))

    def mass(self, layup: Layup, area: Array) -> Array:
        """Return M (n_cells, 6k, 6k), likewise; of u, θ × n, and a little of θ·n."""
        n, (mass, first, second) = self.axes[:, :, 2], layup.density
        kernel = np.zeros((*area.shape, 6, 6))
        kernel[..., :3, :3] = mass * np.eye(3)
        kernel[..., :3, 3:] = first * np.cross(n[:, :, None], np.eye(3))  # u·(θ × n) = θ·(n × u)
        kernel[..., 3:, :3] = kernel[..., :3, 3:].swapaxes(2, 3)
        across = np.eye(3) - (1 - DRILLING_INERTIA) * n[..., None] * n[:, :, None]
        kernel[..., 3:, 3:] = second * across
        pairs = np.einsum("qa,qb->qab", self.value, self.value)
        M = np.einsum("cq,cqij,qab->caibj", area, kernel, pairs, optimize=True)
        return np.asarray(M.reshape(len(area), 6 * self.value.shape[1], -1))


def frames(mesh: ShellMesh, order: int, place: Array, cells: Index, layup: Layup | None) -> Frames:
    """Return the surface at places in cells.

    Parameters
    ----------
    order
        Order of the displacements.
    place
        (n_places, 2) in the reference triangle, the same in all cells; (n_cells, n_places, 2) if
        each has its cell_axis.
    layup
        Section whose axis is e₁; None where any axes will do.
    """
    shape = place.shape[:-1]
    flat = place.reshape(-1, 2)
    form, first, second = (
        part.reshape(*shape, *part.shape[1:]) for part in lagrange(mesh.order, flat)
    )
    value, slope, _ = (part.reshape(*shape, *part.shape[1:]) for part in lagrange(order, flat))
    cell_axis = "c" if place.ndim == 3 else ""
    nodes = mesh.geometry[cells]
    position = np.einsum(f"{cell_axis}qk,ckx->cqx", form, nodes)
    tangent = np.einsum(f"{cell_axis}qkd,ckx->cqdx", first, nodes)
    bend = np.einsum(f"{cell_axis}qkde,ckx->cqdex", second, nodes)
    cross = np.cross(tangent[:, :, 0], tangent[:, :, 1])
    area = np.linalg.norm(cross, axis=-1)
    change = np.cross(bend[:, :, 0], tangent[:, :, 1, None]) + np.cross(
        tangent[:, :, 0, None], bend[:, :, 1]
    )  # (c, q, e, x)
    side = mesh.side[cells][:, None, None]
    n = side * cross / area[..., None]
    normal_slope = side[..., None] * change / area[..., None, None]
    normal_slope -= np.einsum("cqex,cqx->cqe", normal_slope, n)[..., None] * n[:, :, None]
    e = _axes(n, layup)
    metric = np.linalg.inv(np.einsum("cqdx,cqex->cqde", tangent, tangent))
    # ∂ along e_i = Σ_α (e_i·a^α) ∂_α
    along = np.einsum("cqix,cqdx,cqde->cqie", e, tangent, metric)
    return Frames(
        value=value,
        slope=np.einsum(f"cqie,{cell_axis}qae->cqai", along, slope),
        position=position,
        axes=np.concatenate([e, n[:, :, None]], axis=2),
        curvature=np.einsum("cqix,cqje,cqex->cqij", e, along, normal_slope),
        area=area,
    )


def _axes(n: Array, layup: Layup | None) -> Array:
    """Return e₁ along the projection of a section's axis, and e₂ (n_cells, n_places, 2, 3)."""
    axis = np.array(layup.axis if layup else (1, 0, 0), dtype=float)
    axis /= np.linalg.norm(axis)
    first = axis - (n @ axis)[..., None] * n
    length = np.linalg.norm(first, axis=-1, keepdims=True)
    if (lost := length < PARALLEL).any():
        if layup and layup.has_direction:
            raise ValueError(
                f"axis {layup.axis} is along the normal of a part of the surface; the x axis of an"
                " orthotropic section must have a direction in the surface everywhere"
            )
        other = np.roll(axis, 1) if abs(axis @ np.roll(axis, 1)) < 0.9 else np.eye(3)[0]
        first = np.where(lost, other - (n @ other)[..., None] * n, first)
        length = np.linalg.norm(first, axis=-1, keepdims=True)
    first = first / length
    return np.stack([first, np.cross(n, first)], axis=2)
