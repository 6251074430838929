"""Sandwich sections from a layup: classical lamination of the faces, first-order core shear.

The faces carry bending and stretching, the core carries shear: the core has no in-plane
stiffness, the faces have no transverse shear. Conventions of axes and signs are those of
`section`; depths are counted from the middle of the core.

References
----------
Jones, Mechanics of Composite Materials, ch. 4 (lamination).
Allen, Analysis and Design of Structural Sandwich Panels, ch. 2 (S = G d² / t_c).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array
from pidpanel.panel.section import Layer, SolidSection, ThinSection


@dataclass(frozen=True)
class Material:
    """Orthotropic material in plane stress: moduli along, across and in shear [Pa], ν12, ρ."""

    E1: float
    E2: float
    G12: float
    nu12: float
    density: float

    @classmethod
    def isotropic(cls, youngs_modulus: float, poissons_ratio: float, density: float) -> "Material":
        """Return an isotropic material: E1 = E2 = E, G12 = E / (2 (1 + ν))."""
        shear = youngs_modulus / (2 * (1 + poissons_ratio))
        return cls(youngs_modulus, youngs_modulus, shear, poissons_ratio, density)

    @property
    def stiffness(self) -> Array:
        """Q of plane stress in the axes of the fibre [Pa], shape (3, 3)."""
        share = 1 - self.nu12**2 * self.E2 / self.E1
        coupling = self.nu12 * self.E2 / share
        return np.array(
            [[self.E1 / share, coupling, 0], [coupling, self.E2 / share, 0], [0, 0, self.G12]]
        )


@dataclass(frozen=True)
class Ply:
    """A layer of one material; its fibre is turned from the x axis of the panel towards y [rad]."""

    material: Material
    thickness: float
    angle: float = 0.0

    @property
    def strain_in_fibre_axes(self) -> Array:
        """T with (e_1, e_2, g_12) = T (e_x, e_y, g_xy), shape (3, 3)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array(
            [[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]]
        )

    @property
    def stiffness(self) -> Array:
        """Q in the axes of the panel, Tᵀ Q T [Pa], shape (3, 3)."""
        T = self.strain_in_fibre_axes
        return T.T @ self.material.stiffness @ T


@dataclass(frozen=True)
class Core:
    """A honeycomb core: shear moduli along and across the ribbon [Pa], ρ, thickness [m], turn."""

    shear_modulus_l: float
    shear_modulus_w: float
    density: float
    thickness: float
    ribbon: float = 0.0


@dataclass(frozen=True)
class SandwichSection:
    """Two laminated faces, the outermost ply first, on a core.

    In-plane forces vanish (the panel is free to shrink in its plane), so a face pair that is not
    symmetric bends with the reduced stiffness D - B A⁻¹ B. Extra mass such as adhesive and solar
    cells [kg/m²] has no stiffness; its rotary inertia is neglected.
    """

    top: tuple[Ply, ...]
    bottom: tuple[Ply, ...]
    core: Core
    extra_mass_per_area: float = 0.0

    @cached_property
    def _placed(self) -> list[tuple[str, Ply, float, float]]:
        """Name, ply, depth of its outer and of its inner surface [m]."""
        placed = []
        for name, face, side in (("top", self.top, 1.0), ("bottom", self.bottom, -1.0)):
            outer = self.core.thickness / 2 + sum(ply.thickness for ply in face)
            for number, ply in enumerate(face, 1):
                label = name if len(face) == 1 else f"{name} ply {number}"
                placed.append((label, ply, side * outer, side * (outer - ply.thickness)))
                outer -= ply.thickness
        return placed

    @cached_property
    def abd(self) -> tuple[Array, Array, Array]:
        """A [N/m], B [N], D [N m] about the middle of the core, each of shape (3, 3)."""
        return tuple(
            sum(
                ply.stiffness * abs(outer**k - inner**k) * np.sign(outer) ** (k - 1) / k
                for _, ply, outer, inner in self._placed
            )
            for k in (1, 2, 3)
        )

    @cached_property
    def bending(self) -> Array:
        """D - B A⁻¹ B [N m], shape (3, 3)."""
        A, B, D = self.abd
        return D - B @ np.linalg.solve(A, B)

    @property
    def distance(self) -> float:
        """d between the middles of the faces [m]."""
        faces = sum(ply.thickness for ply in (*self.top, *self.bottom))
        return self.core.thickness + faces / 2

    @property
    def shear(self) -> Array:
        """S = G d² / t_c in the axes of the panel [N/m], shape (2, 2)."""
        c, s = np.cos(self.core.ribbon), np.sin(self.core.ribbon)
        R = np.array([[c, s], [-s, c]])
        G = R.T @ np.diag([self.core.shear_modulus_l, self.core.shear_modulus_w]) @ R
        return G * self.distance**2 / self.core.thickness

    @property
    def mass_per_area(self) -> float:
        """m″ [kg/m²]."""
        faces = sum(ply.material.density * ply.thickness for ply in (*self.top, *self.bottom))
        return faces + self.core.density * self.core.thickness + self.extra_mass_per_area

    @property
    def rotary_inertia(self) -> float:
        """Second moment of the density of faces and core about their centre of mass [kg]."""
        half = self.core.thickness / 2
        parts = [(self.core.density, half, -half)]
        parts += [(p.material.density, outer, inner) for _, p, outer, inner in self._placed]
        # moments of density of order 0, 1, 2; a part's surfaces may come in either order
        zeroth, first, second = (
            sum(d * (max(u, v) ** k - min(u, v) ** k) / k for d, u, v in parts) for k in (1, 2, 3)
        )
        return second - first**2 / zeroth

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        """The outer surface of every ply, in the axes of its fibre."""
        A, B, _ = self.abd
        neutral = np.linalg.solve(A, B)
        layers = []
        for name, ply, outer, _ in self._placed:
            strain = ply.strain_in_fibre_axes @ (outer * np.eye(3) - neutral)
            layers.append(Layer(name, strain, ply.material.stiffness @ strain))
        return tuple(layers)

    @property
    def core_stress(self) -> Array:
        """t = S γ / d, in the axes of the panel [Pa], shape (2, 2)."""
        return self.shear / self.distance


ShearSection = SolidSection | SandwichSection
Section = ThinSection | ShearSection
