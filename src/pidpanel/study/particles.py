"""Particles of a coupon, the constants of their contacts, and how these are softened."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from pidpanel.geometry.sizes import Sizes
from pidpanel.study.base import PoissonsRatio, RelativeError, SectionModel
from pidpanel.study.choice import Choice
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity
from pidpanel.study.stated_number import OrStated, StandardError
from pidpanel.study.units import InSI

# Young's modulus of a contact [MPa].
Modulus = Annotated[float, Quantity(5, 1e6, unit="megapascal")]
Restitution = Annotated[float, Quantity(0.05, 1, low_itself=False, unit="percent")]
Friction = Annotated[float, Quantity(0, 5, unit="percent")]
RollingFriction = Annotated[float, Quantity(0, 1, unit="percent")]
Diameter = Annotated[float, Quantity(0.02, 100, unit="small_millimetres")]  # of a particle [mm]
Spread = Annotated[float, Quantity(5e-4, 100, unit="millimetres")]  # of diameters [mm]


class Mono(SectionModel):
    """Particles of one size."""

    kind: Literal["mono"] = "mono"
    """All particles have the diameter ``diameter_mm``."""

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a diameter [m]."""
        return Sizes("mono", diameter, diameter)


class Normal(SectionModel):
    """Normal distribution by number with mean ``diameter_mm``, cut at two deviations."""

    kind: Literal["normal"]
    """Diameters are normally distributed by number."""
    deviation_mm: Spread
    """Standard deviation of the diameter [mm]."""

    deviation: ClassVar = InSI("deviation_mm")

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a mean diameter [m]."""
        reach = 2 * self.deviation
        return Sizes("normal", diameter - reach, diameter + reach)


class Uniform(SectionModel):
    """Uniform distribution by number over ``diameter_mm`` ± ``half_width_mm``."""

    kind: Literal["uniform"]
    """Diameters are uniformly distributed by number."""
    half_width_mm: Spread
    """Largest difference from ``diameter_mm`` [mm]."""

    half_width: ClassVar = InSI("half_width_mm")

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a mean diameter [m]."""
        return Sizes("uniform", diameter - self.half_width, diameter + self.half_width)


class Binary(SectionModel):
    """Two sizes: a share by number of ``second_mm`` among particles of ``diameter_mm``."""

    kind: Literal["binary"]
    """Particles have one of two diameters."""
    second_mm: Diameter
    """The second diameter [mm]."""
    second_share: RelativeError
    """Share of the particles, by number, that have the second diameter."""

    second: ClassVar = InSI("second_mm")

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for the first diameter [m]."""
        share = 1 - self.second_share if self.second < diameter else self.second_share
        return Sizes("binary", min(diameter, self.second), max(diameter, self.second), share)


Distribution = Annotated[Mono | Normal | Uniform | Binary, Field(discriminator="kind")]


class ImpactRestitution(SectionModel):
    """Coefficient of restitution and how it depends on the speed of impact."""

    value: Restitution
    """Coefficient of restitution of a head-on impact at the speed ``at_m_s``."""
    at_m_s: Annotated[float, Quantity(0.001, 100)] | None = None
    """Speed of impact at which ``value`` is measured [m/s]; a constant one needs none."""
    law: Literal["constant", "viscoelastic"] = "constant"
    """``constant``: the same at any speed. ``viscoelastic``: 1 − e rises about with the fifth root
    of the speed of impact ([theory](../theory/coupon.md#restitution-and-speed-of-impact)); needs
    spheres of one size."""
    error: StandardError = 0.0
    """Standard error of ``value``, which enters the uncertainty of the results."""

    @field_validator("law", mode="before")
    @classmethod
    def _refuse_plastic(cls, law: Any) -> Any:
        if law == "plastic":
            message = "must be constant or viscoelastic; LIGGGHTS has no plastic contact that "
            raise PydanticCustomError("plastic", message + "keeps the energy of slow impacts")
        return law

    def mistakes(self) -> Iterator[Mistake]:
        if self.law == "viscoelastic" and self.at_m_s is None:
            yield Mistake(("at_m_s",), "missing; required for law: viscoelastic")


class Particles(SectionModel):
    """The particles: size, density, and the constants of their contacts with each other."""

    diameter_mm: Diameter = 2.0
    """Diameter [mm]; the mean one of a distribution, the first one of a binary mixture."""
    distribution: Distribution = Mono()
    """Distribution of the diameters of particles."""
    density_kg_m3: Annotated[float, Quantity(10, 25000, unit="density")] = 1190.0
    """Density of the material [kg/m³]."""
    shell_mm: Spread | None = None
    """Wall thickness of hollow particles [mm]; their inertia is taken as that of solid ones of
    the same mass."""
    youngs_modulus_mpa: Modulus = 3200.0
    """Young's modulus of the material [MPa]; a run may use a lower one, see ``stiffness``."""
    poissons_ratio: PoissonsRatio = 0.35
    """Poisson's ratio of the material."""
    restitution: Annotated[Restitution | ImpactRestitution, Choice()] = 0.8
    """Coefficient of restitution of a collision of two particles: a number, the same at any speed
    of impact, or a mapping with its standard error, or with a speed and a law."""
    friction: Annotated[float, OrStated(Friction)] = 0.3
    """Coefficient of sliding friction between two particles: a number, or a mapping with its
    standard error."""
    rolling_friction: RollingFriction = 0.0
    """Coefficient of rolling friction: a constant torque against rolling."""

    def effective_density(self, diameter: float) -> float:
        """Return mass over outer volume [kg/m³], for an outer diameter [m].

        Notes
        -----
        ρ (1 − (1 − 2 t/d)³) for a shell of thickness t.

        Examples
        --------
        >>> Particles(diameter_mm=2, shell_mm=0.5, density_kg_m3=800).effective_density(2e-3)
        700.0
        """
        if self.shell is None:
            return self.density_kg_m3
        return self.density_kg_m3 * (1 - (1 - 2 * self.shell / diameter) ** 3)

    @property
    def impacts(self) -> ImpactRestitution:
        """Restitution with its law."""
        stated = self.restitution
        return stated if isinstance(stated, ImpactRestitution) else ImpactRestitution(value=stated)

    def constant(self, name: str) -> float:
        """Return a constant of the contacts by its key; of restitution the stated value."""
        return float(self.impacts.value if name == "restitution" else getattr(self, name))

    diameter: ClassVar = InSI("diameter_mm")
    shell: ClassVar = InSI("shell_mm")
    youngs_modulus: ClassVar = InSI("youngs_modulus_mpa")

    def mistakes(self) -> Iterator[Mistake]:
        if self.impacts.law == "viscoelastic" and not isinstance(self.distribution, Mono):
            message = "only allowed for distribution: {kind: mono}"
            yield Mistake(("restitution", "law"), message)
        if self.shell_mm is not None:
            if not isinstance(self.distribution, Mono):
                yield Mistake(("shell_mm",), "only allowed for distribution: {kind: mono}")
            if 2 * self.shell_mm >= self.diameter_mm:
                message = f"must be below half of diameter_mm = {self.diameter_mm:g}"
                yield Mistake(("shell_mm",), message)


class Walls(SectionModel):
    """Contact constants of the cell walls; by default those between two particles.

    A wall that is stiffer than the particles stays stiffer when both are softened.
    """

    youngs_modulus_mpa: Modulus | None = None
    """Young's modulus of the walls [MPa]."""
    poissons_ratio: PoissonsRatio | None = None
    """Poisson's ratio of the walls."""
    restitution: Restitution | None = None
    """Coefficient of restitution of a particle and a wall, at the speed and with the law of that of
    two particles."""
    friction: Friction | None = None
    """Coefficient of sliding friction between a particle and a wall."""
    rolling_friction: RollingFriction | None = None
    """Coefficient of rolling friction on a wall."""

    youngs_modulus: ClassVar = InSI("youngs_modulus_mpa")


# Share of a period or a radius [1].
Share = Annotated[float, Quantity(0, 0.5, low_itself=False, unit="percent")]
Stroke = Annotated[float, Quantity(0, 100, low_itself=False)]  # W/L [1]


class Crossing(SectionModel):
    """Limits near the jump from beds that ride to beds that cross: soft contacts move it.

    Steel at r = 0.7, 80 Hz, 80 g (W/L = 0.41, contacts of 0.014 periods and 0.094 radii at 50 MPa)
    rides with η = 0.12 at 50 MPa. It crosses with η = 1.37, 1.36, 1.31 at 100, 200 and 800 MPa.
    """

    stroke_per_gap: tuple[Stroke, Stroke] = (0.1, 0.5)
    """Range of the ratio of the displacement amplitude W to the clear gap L = (1 − r) depth in
    which these limits apply."""
    contact_time_per_period: Share = 0.01
    """Longest contact there, over the period of the drive."""
    overlap_per_radius: Share = 0.05
    """Deepest overlap there, over the radius of a particle."""

    def holds_at(self, stroke_per_gap: float) -> bool:
        """Return whether W/L is in the range."""
        start, stop = self.stroke_per_gap
        return start <= stroke_per_gap <= stop

    def mistakes(self) -> Iterator[Mistake]:
        start, stop = self.stroke_per_gap
        if stop < start:
            yield Mistake(("stroke_per_gap", 1), f"must be at least stroke_per_gap[0] = {start:g}")


class Stiffness(SectionModel):
    """Softening of the contacts: the time step increases as the modulus falls.

    A run uses the softest of ``choices_mpa`` for which a Hertz contact at the velocity amplitude
    of the drive is short (``contact_time_per_period``) and shallow (``overlap_per_radius``). Where
    the bed may cross its gap, the limits are those of ``crossing``. If no choice meets them, the
    run uses the modulus of the material. Below ``from_acceleration_g`` it always does,
    because the bed bounces as one body and its losses depend on how its layers rebound in series.
    At 100 Hz and 5 g, 50 MPa dissipates 1.8 times as much as 3.2 GPa; at 20 g they are equal
    (``coupon_modulus.yaml``). For beds of more than 6.25 layers that ride below 80 g,
    ``contact_time_per_period`` is divided by (layers/6.25)³.
    """

    choices_mpa: tuple[Modulus, ...] = (50.0, 200.0, 800.0)
    """Young's moduli to choose from, the softest first [MPa]."""
    contact_time_per_period: Share = 0.02
    """Longest allowed contact over the period of the drive."""
    overlap_per_radius: Share = 0.10
    """Deepest allowed overlap over the radius of a particle."""
    from_acceleration_g: Annotated[float, Quantity(0, 2000)] = 10.0
    """Contacts are softened from this acceleration amplitude on [g]; times what the bed feels along
    the motion where that is more than 1 g."""
    crossing: Crossing = Crossing()
    """Stricter limits where a bed may ride or cross its gap."""

    def limits(self, stroke_per_gap: float) -> tuple[float, float]:
        """Return the allowed contact time over the period and overlap over the radius [1].

        Parameters
        ----------
        stroke_per_gap
            W/L of the drive in the clear gap of the bed.

        Examples
        --------
        >>> Stiffness().limits(0.05), Stiffness().limits(0.3)
        ((0.02, 0.1), (0.01, 0.05))
        """
        time, overlap = self.contact_time_per_period, self.overlap_per_radius
        if self.crossing.holds_at(stroke_per_gap):
            time = min(time, self.crossing.contact_time_per_period)
            overlap = min(overlap, self.crossing.overlap_per_radius)
        return time, overlap

    choices: ClassVar = InSI("choices_mpa")
