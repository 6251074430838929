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
"""

from dataclasses import dataclass

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
    zero, t none on the motion. Strains are those at z = ±t/2, stresses those of the homogeneous
    plate with this D, E = 12 (1 − ν²) D / t³.
    """

    bending_stiffness: float
    mass_per_area: float
    poissons_ratio: float = 0.3
    thickness: float = 0.025

    @property
    def bending(self) -> Array:
        """D [[1, ν, 0], [ν, 1, 0], [0, 0, (1 - ν)/2]] [N m]."""
        nu = self.poissons_ratio
        return self.bending_stiffness * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])

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
