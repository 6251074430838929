"""Sections of the panel: what a width of it weighs, how it resists, how its faces are stressed.

Conventions of all sections: z points the way w does, from the neutral plane; the curvature is
kappa = -(w_,xx, w_,yy, 2 w_,xy) of a thin plate and -(b_x,x, b_y,y, b_x,y + b_y,x) where the
normals turn by b; the shear angle is gamma = grad w - b; strains are (e_x, e_y, g_xy) with the
engineering shear strain, stresses (s_x, s_y, t_xy).
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pidpanel.arrays import Array


@dataclass(frozen=True)
class Layer:
    """A depth of the section at which strain and stress are wanted.

    Attributes
    ----------
    name : str
        Such as "top" or "top ply 1".
    strain : ndarray, shape (3, 3)
        Strain = ``strain @ curvature`` [m], in the layer's own axes (1, 2, 12).
    stress : ndarray, shape (3, 3)
        Stress = ``stress @ curvature`` [Pa m], in the same axes.
    """

    name: str
    strain: Array
    stress: Array


class Section(Protocol):
    """What the panel stage asks of a section."""

    @property
    def mass_per_area(self) -> float:
        """m'' [kg/m^2]."""

    @property
    def bending(self) -> Array:
        """Moments (m_x, m_y, m_xy) per curvature [N m], shape (3, 3)."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Depths at which strain and stress can be recovered."""

    @property
    def core_stress(self) -> Array:
        """Shear stress (t_xz, t_yz) of the core per shear angle [Pa], shape (2, 2)."""


@dataclass(frozen=True)
class ThinSection:
    """Isotropic thin plate.

    Attributes
    ----------
    bending_stiffness : float
        D [N m], per unit width.
    mass_per_area : float
        m'' [kg/m^2].
    poissons_ratio : float
        nu [-]. Of no influence on simply supported polygons, where the Gaussian curvature
        integrates to zero.
    thickness : float
        t [m]; of no influence on the motion. Strains are those at z = +-t/2, stresses those of
        the homogeneous plate with this D, E = 12 (1 - nu^2) D / t^3.

    Raises
    ------
    ValueError
        If D, m'' or t is not positive, or nu is not in (-1, 0.5].
    """

    bending_stiffness: float
    mass_per_area: float
    poissons_ratio: float = 0.3
    thickness: float = 0.025

    def __post_init__(self) -> None:
        """Refuse what is no plate."""
        for name in ("bending_stiffness", "mass_per_area", "thickness"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name):g}; it must be positive")
        if not -1 < self.poissons_ratio <= 0.5:
            raise ValueError(
                f"poissons_ratio is {self.poissons_ratio:g}; allowed is -1 < nu <= 0.5"
            )

    @property
    def bending(self) -> Array:
        """D [[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu)/2]] [N m]."""
        nu = self.poissons_ratio
        return self.bending_stiffness * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Both surfaces: e = z kappa, s = 12 z / t^3 m."""
        half = self.thickness / 2
        return tuple(
            Layer(name, z * np.eye(3), 12 * z / self.thickness**3 * self.bending)
            for name, z in (("top", half), ("bottom", -half))
        )

    @property
    def core_stress(self) -> Array:
        """None: a thin plate has no shear angle to tell it from."""
        return np.zeros((2, 2))


@dataclass(frozen=True)
class SolidSection:
    """Thick plate of one isotropic material, with transverse shear and rotary inertia.

    Attributes
    ----------
    youngs_modulus : float
        E [Pa].
    poissons_ratio : float
        nu [-].
    density : float
        [kg/m^3].
    thickness : float
        t [m].
    shear_correction : float
        kappa in S = kappa G t [-]: 5/6 (Reissner); Mindlin's pi^2/12 is close by.
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
        """rho t [kg/m^2]."""
        return self.density * self.thickness

    @property
    def rotary_inertia(self) -> float:
        """rho t^3 / 12 [kg]."""
        return self.density * self.thickness**3 / 12

    @property
    def bending(self) -> Array:
        """As of a thin plate [N m]."""
        return self._thin.bending

    @property
    def shear(self) -> Array:
        """kappa G t [N/m]."""
        shear_modulus = self.youngs_modulus / (2 * (1 + self.poissons_ratio))
        return self.shear_correction * shear_modulus * self.thickness * np.eye(2)

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Both surfaces."""
        return self._thin.layers

    @property
    def core_stress(self) -> Array:
        """The greatest shear stress, in the middle: 3/2 of the mean, S gamma / t."""
        return 1.5 * self.shear / self.thickness
