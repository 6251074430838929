"""Sections of the panel: mass, stiffness and the stress of the faces, per unit width.

Conventions of all sections: z points the way w does, from the neutral plane; the curvature is
κ = -(w_,xx, w_,yy, 2 w_,xy) of a thin plate and -(b_x,x, b_y,y, b_x,y + b_y,x) where the
normals turn by b; the shear angle is γ = grad w - b; strains are (e_x, e_y, g_xy) with the
engineering shear strain, stresses (s_x, s_y, t_xy).

Every section has ``mass_per_area`` m″ [kg/m²], ``bending`` (3, 3), the moments (m_x, m_y, m_xy) per
curvature [N m], ``layers`` at which strain and stress can be recovered, and ``core_stress`` (2, 2),
the shear stress (t_xz, t_yz) of the core per shear angle [Pa]. Those with transverse shear have
``shear`` (2, 2), the shear force (q_x, q_y) per shear angle [N/m], and ``rotary_inertia``, the mass
moment of the normals [kg].

Sandwiches follow from their plies by classical lamination of the faces and first-order core shear:
the faces carry bending and stretching, the core carries shear. The core has no in-plane stiffness,
the faces have no transverse shear. Depths are counted from the middle of the core.

References
----------
Jones, Mechanics of Composite Materials, ch. 4 (lamination).
Allen, Analysis and Design of Structural Sandwich Panels, ch. 2 (S = G d² / t_c).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class Layer:
    """A depth of the section at which strain and stress are computed."""

    name: str  # such as "top" or "top ply 1"
    strain: Array  # (3, 3) strain = ``strain @ curvature`` [m], in the layer's own axes (1, 2, 12)
    stress: Array  # (3, 3) stress = ``stress @ curvature`` [Pa m], in the same axes


@dataclass(frozen=True)
class ThinSection:
    """Isotropic thin plate of D [N m], m″ [kg/m²], ν and thickness t [m].

    ν has no influence on simply supported polygons, where the Gaussian curvature integrates to
    zero, t none on linear motion. Strains are those at z = ±t/2, stresses those of the homogeneous
    plate with this D, E = 12 (1 − ν²) D / t³. So is the extensional stiffness E t/(1 − ν²) where
    none is given.
    """

    bending_stiffness: float
    mass_per_area: float
    poissons_ratio: float = 0.3
    thickness: float = 0.025
    extensional_stiffness: float | None = None  # E t/(1 − ν²) [N/m]

    @property
    def bending(self) -> Array:
        """D [[1, ν, 0], [ν, 1, 0], [0, 0, (1 - ν)/2]] [N m]."""
        return self.bending_stiffness * self._isotropic

    @property
    def extensional(self) -> Array:
        """A, with 12 D/t² in place of D unless it is given [N/m]."""
        stated = self.extensional_stiffness
        return (stated or 12 * self.bending_stiffness / self.thickness**2) * self._isotropic

    @property
    def _isotropic(self) -> Array:
        nu = self.poissons_ratio
        return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Both surfaces: e = z κ, s = 12 z / t³ m."""
        half = self.thickness / 2
        return tuple(
            Layer(name, z * np.eye(3), 12 * z / self.thickness**3 * self.bending)
            for name, z in (("top", half), ("bottom", -half))
        )

    @property
    def core_stress(self) -> Array:
        """Zero: a thin plate has no shear angle to compute it from."""
        return np.zeros((2, 2))


@dataclass(frozen=True)
class SolidSection:
    """Thick plate of one isotropic material, with transverse shear and rotary inertia.

    S = κ G t with κ = 5/6 (Reissner); Mindlin's π²/12 is close by.
    """

    youngs_modulus: float
    poissons_ratio: float
    density: float
    thickness: float
    shear_correction: float = 5 / 6

    @property
    def _thin(self) -> ThinSection:
        E, nu, t = self.youngs_modulus, self.poissons_ratio, self.thickness
        return ThinSection(E * t**3 / (12 * (1 - nu**2)), self.density * t, nu, t)

    @property
    def mass_per_area(self) -> float:
        """ρ t [kg/m²]."""
        return self.density * self.thickness

    @property
    def rotary_inertia(self) -> float:
        """ρ t³ / 12 [kg]."""
        return self.density * self.thickness**3 / 12

    @property
    def bending(self) -> Array:
        """Bending stiffness of a thin plate [N m]."""
        return self._thin.bending

    @property
    def extensional(self) -> Array:
        """A of a thin plate [N/m]."""
        return self._thin.extensional

    @property
    def shear(self) -> Array:
        """κ G t [N/m]."""
        shear_modulus = self.youngs_modulus / (2 * (1 + self.poissons_ratio))
        return self.shear_correction * shear_modulus * self.thickness * np.eye(2)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Both surfaces."""
        return self._thin.layers

    @property
    def core_stress(self) -> Array:
        """The greatest shear stress, in the middle: 3/2 of the mean, S γ / t."""
        return 1.5 * self.shear / self.thickness


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
    bending_factor: float = 1.0  # on the bending stiffness of the plies
    shear_factor: float = 1.0  # on the shear stiffness of the core

    @cached_property
    def placed(self) -> list[tuple[str, Ply, float, float]]:
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
                for _, ply, outer, inner in self.placed
            )
            for k in (1, 2, 3)
        )

    @cached_property
    def bending(self) -> Array:
        """D - B A⁻¹ B [N m], shape (3, 3)."""
        A, B, D = self.abd
        return self.bending_factor * (D - B @ np.linalg.solve(A, B))

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
        return self.shear_factor * G * self.distance**2 / self.core.thickness

    @property
    def mass_per_area(self) -> float:
        """m″ [kg/m²]."""
        faces = sum(ply.material.density * ply.thickness for ply in (*self.top, *self.bottom))
        return faces + self.core.density * self.core.thickness + self.extra_mass_per_area

    @property
    def density_moments(self) -> tuple[float, float, float]:
        """Moments ∫ρ zᵏ dz of order 0, 1, 2 of faces and core about the middle of the core."""
        half = self.core.thickness / 2
        parts = [(self.core.density, half, -half)]
        parts += [(p.material.density, outer, inner) for _, p, outer, inner in self.placed]
        # a part's surfaces may come in either order
        zeroth, first, second = (
            sum(d * (max(u, v) ** k - min(u, v) ** k) / k for d, u, v in parts) for k in (1, 2, 3)
        )
        return zeroth, first, second

    @property
    def rotary_inertia(self) -> float:
        """Second moment of the density of faces and core about their centre of mass [kg]."""
        zeroth, first, second = self.density_moments
        return second - first**2 / zeroth

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        """The outer surface of every ply, in the axes of its fibre."""
        A, B, _ = self.abd
        neutral = np.linalg.solve(A, B)
        layers = []
        for name, ply, outer, _ in self.placed:
            strain = ply.strain_in_fibre_axes @ (outer * np.eye(3) - neutral)
            layers.append(Layer(name, strain, ply.material.stiffness @ strain))
        return tuple(layers)

    @property
    def core_stress(self) -> Array:
        """t = S γ / d, in the axes of the panel [Pa], shape (2, 2)."""
        return self.shear / self.distance


ShearSection = SolidSection | SandwichSection
Section = ThinSection | ShearSection
