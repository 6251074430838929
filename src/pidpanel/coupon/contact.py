"""The contact laws, Hertz and Mindlin with damping: LIGGGHTS' words, constants and closed forms.

``templates/contacts.j2`` states the constants in decks.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.atlas.groups import ElasticSphere
from pidpanel.coupon.impacts import ViscoelasticImpacts


@dataclass(frozen=True)
class Constants:
    """Constants of the contacts of spheres with spheres and with walls: moduli [Pa], others [1].

    The moduli are those of a run, which may be softer than the material
    (`contact.softest_modulus`). Without ``impacts`` e is the same at any speed.
    """

    youngs_modulus: float
    wall_youngs_modulus: float
    poissons_ratio: float
    wall_poissons_ratio: float
    restitution: float
    wall_restitution: float
    friction: float
    wall_friction: float
    rolling_friction: float
    wall_rolling_friction: float
    impacts: ViscoelasticImpacts | None = field(default=None, kw_only=True)

    @classmethod
    def alike(
        cls,
        youngs_modulus: float,
        poissons_ratio: float,
        restitution: float,
        friction: float,
        rolling_friction: float = 0.0,
    ) -> "Constants":
        """Return the constants of spheres and walls of one material."""
        values = (youngs_modulus, poissons_ratio, restitution, friction, rolling_friction)
        return cls(*chain.from_iterable(zip(values, values, strict=True)))

    @property
    def has_rolling_friction(self) -> bool:
        """Whether anything resists rolling."""
        return bool(self.rolling_friction or self.wall_rolling_friction)

    @property
    def contact_model(self) -> str:
        """Return the words of LIGGGHTS for the contact law."""
        words = "hertz/stiffness" if self.impacts else "hertz"
        words += " tangential history"
        return words + " rolling_friction cdt" if self.has_rolling_friction else words

    @property
    def deck_values(self) -> dict[str, Any]:
        """Variables of ``templates/contacts.j2`` in SI."""
        properties = tuple(self._viscoelastic_properties())
        return {**vars(self), "contact_model": self.contact_model, "impacts": properties}

    @property
    def materials(self) -> "tuple[ContactMaterial, ContactMaterial]":
        """Contacts of sphere on sphere and of sphere on wall."""
        sphere = self.youngs_modulus, self.poissons_ratio
        wall = self.wall_youngs_modulus, self.wall_poissons_ratio
        pair = contact_material(sphere, sphere, self.friction, self.restitution)
        touch = contact_material(sphere, wall, self.wall_friction, self.wall_restitution)
        if self.impacts is None:
            return pair, touch
        moduli = pair.effective_modulus, touch.effective_modulus
        pair_viscosity = self.impacts.viscosity(moduli[0], self.restitution, at_wall=False)
        wall_viscosity = self.impacts.viscosity(moduli[1], self.wall_restitution, at_wall=True)
        return replace(pair, viscosity=pair_viscosity), replace(touch, viscosity=wall_viscosity)

    def _viscoelastic_properties(self) -> Iterator[tuple[str, float, float]]:
        """Yield constants of ``hertz/stiffness`` by name, of two spheres and of one at a wall."""
        if self.impacts is None:
            return
        pair, touch = self.materials
        moduli = pair.effective_modulus, touch.effective_modulus
        shear_moduli = pair.effective_shear_modulus, touch.effective_shear_modulus
        yield "kn", 4 / 3 * moduli[0], 4 / 3 * moduli[1]
        yield "kt", 8 * shear_moduli[0], 8 * shear_moduli[1]
        # LIGGGHTS multiplies the viscous constants by m*
        damping = pair.viscosity / self.impacts.effective_mass(at_wall=False)
        wall_damping = touch.viscosity / self.impacts.effective_mass(at_wall=True)
        yield "gamman", damping, wall_damping
        yield "gammat", damping * pair.across, wall_damping * touch.across


def damping_ratio(restitution: float) -> float:
    """Return the damping β of a contact that rebounds at e of its speed [1]: −ln e/√(π² + ln² e).

    Tsuji, Tanaka & Ishida, Powder Technology 71, 239 (1992), as in LIGGGHTS.

    Examples
    --------
    >>> round(damping_ratio(0.5), 4)
    0.2155
    """
    log = -math.log(restitution)
    return log / math.hypot(math.pi, log)


@dataclass(frozen=True)
class ContactMaterial:
    """One kind of contact: E* and G* [Pa], μ, β of `damping_ratio` [1].

    A viscosity [Pa s] other than 0, 2 E* A of `impacts`, replaces β.
    """

    effective_modulus: float
    effective_shear_modulus: float
    friction: float
    damping: float
    viscosity: float = 0.0

    @property
    def across(self) -> float:
        """Viscous force across over that along at one speed [1]: √(S_t/S_n)."""
        return math.sqrt(4 * self.effective_shear_modulus / self.effective_modulus)


def contact_material(
    first: tuple[float, float], second: tuple[float, float], friction: float, restitution: float
) -> ContactMaterial:
    """Return the contact of two materials with moduli [Pa] and Poisson's ratios.

    1/E* = Σ (1 − ν²)/E, 1/G* = Σ 2(2 − ν)(1 + ν)/E.

    Examples
    --------
    >>> material = contact_material((2e9, 0.0), (2e9, 0.0), 0.3, 0.8)
    >>> round(material.effective_modulus), round(material.effective_shear_modulus)
    (1000000000, 250000000)
    """
    sides = (first, second)
    return ContactMaterial(
        1 / sum((1 - n**2) / e for e, n in sides),
        1 / sum(2 * (2 - n) * (1 + n) / e for e, n in sides),
        friction,
        damping_ratio(restitution),
    )


def contact_forces(
    material: ContactMaterial, depth: Array, curvature: Array, mobility: Array
) -> tuple[Array, Array, Array]:
    """Return elastic forces [N], and viscous ones over the speed along and across [N s/m].

    F = 4/3 E* √(R* δ) δ, and 2 √(5/6) β √(S m*) with S_n = 2 E* √(R* δ), S_t = 8 G* √(R* δ). A
    viscosity η has η √(R* δ) instead, and across √(S_t/S_n) times that.

    Parameters
    ----------
    depth, curvature, mobility
        (n,) overlaps δ [m], 1/R* [1/m] and 1/m* [1/kg], sums over both sides of a contact.
    """
    contact_radius = np.sqrt(depth / curvature)
    elastic = 4 / 3 * material.effective_modulus * contact_radius * depth
    if material.viscosity:
        along = material.viscosity * contact_radius
    else:
        inertia = 2 * material.effective_modulus * contact_radius / mobility
        along = 2 * math.sqrt(5 / 6) * material.damping * np.sqrt(inertia)
    return elastic, along, along * material.across


CROSSING = 0.1  # stroke over clear gap W/L from which a bed can cross its gap [1]; below, it rides


# Height of a bed over the diameter of its spheres up to which its rebound in series takes no
# longer than was measured at half fill [1].
DEEP = 6.25

# Γ from which on a bed is agitated whatever its height, and no more thrown as one body.
AGITATED = 80.0


def deepening(layers: float, acceleration_g: float) -> float:
    """Return the bias of a deep bed by long contacts over that at half fill [1].

    A bed of many layers that is thrown as one body rebounds layer by layer. Excess of η over
    that of the material's own modulus, of 2 mm acrylic spheres in 25 mm (one or two packings), over
    the difference in t_c f: at r = 0.5 (6.25 layers), 20 g, 500 Hz 4.4; at r = 0.7, 20 g, 250 Hz 5;
    at r = 0.9 (11.25 layers), 20 g, 250 and 500 Hz 11 to 21, at 40 g 12. At 80 g (steel) and 120 g
    there is no excess up to t_c f = 0.07, whatever the height.

    Examples
    --------
    >>> deepening(12.5, 20.0), deepening(6.25, 20.0), deepening(12.5, 120.0)
    (8.0, 1.0, 1.0)
    """
    return 1.0 if acceleration_g >= AGITATED else max(1.0, (layers / DEEP) ** 3)


LEAST_GAP = 0.05  # clear gap over the depth of the cell from which on it makes no difference [1]


def narrowing(fill_fraction: float) -> float:
    """Return the height of a bed over twice its gap, r/2(1 − r), at least 1.

    A bed of N layers is shorter by N times their overlap, which is compared with its gap.

    Examples
    --------
    >>> narrowing(0.5), round(narrowing(0.9), 9)
    (1.0, 4.5)
    """
    return max(1.0, fill_fraction / (2 * max(1 - fill_fraction, LEAST_GAP)))


def modulus_bias(
    contact_per_period: float,
    material_contact_per_period: float,
    overlap: float = 0.0,
    material_overlap: float = 0.0,
    deepening: float = 1.0,
    narrowing: float = 1.0,
) -> float:
    """Return the bias of C_e by softened spheres [1]: 2.5 (t_c f − t_c0 f), 1.5 (δ − δ₀)/R.

    The larger of the two; the first times that of `deepening`, where the bed rides; the second
    times that of `narrowing`, where it crosses its gap (W/L from `CROSSING` on).

    Notes
    -----
    The second is that of beds that cross: overlaps make the bed shorter and its gap longer. At
    W/L = 0.41 (r = 0.7, 80 Hz, 80 g) acrylic spheres of 50, 200 and 800 MPa give η = 1.333, 1.289,
    1.254, which is 1.85 and 1.65 of the difference in δ/R, steel of 200 and 800 MPa 1.359 and
    1.305 (1.8); at W/L = 0.48 (steel, r = 0.5, 50 Hz, 60 g) 0.6, at 0.62 (acrylic, 120 g) 0.8. Beds
    that fill their cells to 0.79, 0.9, 0.91 and 0.95 have 2, 3 to 6, 7 and 24, of either sign.

    The first was measured with 2 mm spheres at half fill and Γ = 20 against the material's 3.2 GPa
    (``coupon_modulus.yaml``): 1.2 ± 2.2 %, 5.2 ± 1.7 % and 12.0 ± 1.1 % at differences of 0.009,
    0.016 and 0.064; earlier 1.6, 7.5 and 23 % at 0.011, 0.019 and 0.073. Both go into the error,
    not into the value, and hold where the bed is thrown: see `Stiffness`.
    """
    time_bias = 2.5 * deepening * (contact_per_period - material_contact_per_period)
    depth_bias = 1.5 * narrowing * (overlap - material_overlap)
    return max(time_bias, depth_bias, 0.0)


def softest_modulus(
    choices: tuple[float, ...],
    material: ElasticSphere,
    *,
    speed: float,
    frequency: float,
    contact_time_per_period: float,
    overlap_per_radius: float,
) -> float:
    """Return the softest modulus [Pa] with short and shallow contacts at a drive's speed.

    A soft sphere allows a long time step but dissipates too much if its contacts last a noticeable
    part of a period: `modulus_bias`. If no choice is stiff enough, the material's own modulus is
    returned, however long its contacts.

    Parameters
    ----------
    choices
        Allowed moduli [Pa].
    material
        Sphere with its own modulus.
    speed, frequency
        Velocity amplitude [m/s] and frequency [Hz] of the drive.
    contact_time_per_period, overlap_per_radius
        Largest allowed ratios [1].
    """
    for modulus in sorted(choices):
        if modulus >= material.youngs_modulus:
            break
        sphere = replace(material, youngs_modulus=modulus)
        is_short = sphere.wall_contact_time(speed) * frequency <= contact_time_per_period
        if is_short and sphere.wall_overlap(speed) <= overlap_per_radius * sphere.radius:
            return modulus
    return material.youngs_modulus
