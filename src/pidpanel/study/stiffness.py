"""How the contacts of a coupon are softened to save time."""

from collections.abc import Iterator
from typing import Annotated

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.study.base import SectionModel
from pidpanel.study.mistakes import Mistake
from pidpanel.study.particles import Modulus
from pidpanel.study.quantity import PERCENT, Quantity

# Of a period or a radius [1].
Share = Annotated[float, Quantity(0, 0.5, low_itself=False, units=PERCENT)]
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
        """Whether W/L is in the range."""
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
    """Contacts are softened from this acceleration amplitude on [g]."""
    crossing: Crossing = Crossing()
    """Stricter limits where a bed may ride or cross its gap."""

    def limits(self, stroke_per_gap: float) -> tuple[float, float]:
        """Longest contact over the period and deepest overlap over the radius that are allowed [1].

        Parameters
        ----------
        stroke_per_gap
            W/L of the drive in the clear gap of the bed.

        Examples
        --------
        >>> Stiffness().limits(0.05), Stiffness().limits(0.3)
        ((0.02, 0.1), (0.01, 0.05))
        """
        allowed = self.contact_time_per_period, self.overlap_per_radius
        if not self.crossing.holds_at(stroke_per_gap):
            return allowed
        crossing = self.crossing.contact_time_per_period, self.crossing.overlap_per_radius
        return min(allowed[0], crossing[0]), min(allowed[1], crossing[1])

    @property
    def choices(self) -> tuple[float, ...]:
        """Moduli to choose from [Pa]."""
        return tuple(choice * 1e6 for choice in self.choices_mpa)

    @property
    def from_acceleration(self) -> float:
        """Least acceleration amplitude at which contacts are softened [m/s²]."""
        return self.from_acceleration_g * STANDARD_GRAVITY
