"""The section ``coupon`` of a study: cells, particles, contacts, and what of them is varied."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, ValidationInfo, field_validator

from pidpanel.cells import ShapeName
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.paths import TEMPLATES
from pidpanel.sizes import Sizes
from pidpanel.study.base import Fill, Fraction, Model, PoissonsRatio, RelativeError
from pidpanel.study.explaining import mistakes_of
from pidpanel.study.files import file_in, found_file
from pidpanel.study.mistakes import Keys, Mistake, Mistakes, dotted, unknown_key
from pidpanel.study.quantity import (
    DENSITY,
    GRAVITIES,
    KILOHERTZ,
    MEGAPASCAL,
    MILLIMETRES,
    MILLISECONDS,
    PERCENT,
    SMALL_MILLIMETRES,
    VELOCITY,
    Quantity,
    whole,
)

Modulus = Annotated[float, Quantity(5, 1e6, units=MEGAPASCAL)]
"""Young's modulus of a contact [MPa]."""
Restitution = Annotated[float, Quantity(0.05, 1, low_itself=False, units=PERCENT)]
Friction = Annotated[float, Quantity(0, 5, units=PERCENT)]
RollingFriction = Annotated[float, Quantity(0, 1, units=PERCENT)]
Diameter = Annotated[float, Quantity(0.02, 100, units=SMALL_MILLIMETRES)]
"""Of a particle [mm]."""
Spread = Annotated[float, Quantity(5e-4, 100, units=MILLIMETRES)]
"""Of diameters [mm]."""
Frequency = Annotated[float, Quantity(1, 20000, units=KILOHERTZ)]
"""Of a drive [Hz]."""
Share = Annotated[float, Quantity(0, 0.5, low_itself=False, units=PERCENT)]
"""Of a period or a radius [1]."""
MOST_VALUES = 10_000
"""Values that a range may have."""
MOST_VARIANTS = 1000
"""Combinations that ``vary`` may have."""
MOST_RUNS = 200_000
"""Runs that a sweep may have; twice as many as have been run."""
MOST_SPHERES = 1_000_000
"""Spheres that a run may have: a step of them takes a second."""


class Cell(Model):
    """The honeycomb cell, and the number of cells per run."""

    shape: ShapeName = "hexagon"
    """Cross-section of the cell."""
    across_flats_mm: Annotated[float, Quantity(0.5, 500, units=SMALL_MILLIMETRES)] = 6.35
    """Width of a hexagon between two sides; side of a square; diameter of a circle [mm]."""
    depth_mm: Annotated[float, Quantity(0.5, 1000, units=SMALL_MILLIMETRES)] = 25.0
    """Depth of the cell between its two closed ends [mm]."""
    count: Annotated[int, whole(1, 200)] = 5
    """Cells per run, shaken side by side; they share only the drive."""

    @property
    def across_flats(self) -> float:
        """Width of the cell [m]."""
        return self.across_flats_mm * 1e-3

    @property
    def depth(self) -> float:
        """Depth of the cell [m]."""
        return self.depth_mm * 1e-3


class Mono(Model):
    """Particles of one size."""

    kind: Literal["mono"] = "mono"
    """All particles have the diameter ``diameter_mm``."""

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a diameter [m]."""
        return Sizes("mono", diameter, diameter)


class Normal(Model):
    """Normal distribution by number with mean ``diameter_mm``, cut at two deviations."""

    kind: Literal["normal"]
    """Diameters are normally distributed by number."""
    deviation_mm: Spread
    """Standard deviation of the diameter [mm]."""

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a mean diameter [m]."""
        reach = 2 * self.deviation_mm * 1e-3
        return Sizes("normal", diameter - reach, diameter + reach)


class Uniform(Model):
    """Uniform distribution by number over ``diameter_mm`` ± ``half_width_mm``."""

    kind: Literal["uniform"]
    """Diameters are uniformly distributed by number."""
    half_width_mm: Spread
    """Largest difference from ``diameter_mm`` [mm]."""

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for a mean diameter [m]."""
        reach = self.half_width_mm * 1e-3
        return Sizes("uniform", diameter - reach, diameter + reach)


class Binary(Model):
    """Two sizes: a share by number of ``second_mm`` among particles of ``diameter_mm``."""

    kind: Literal["binary"]
    """Particles have one of two diameters."""
    second_mm: Diameter
    """The second diameter [mm]."""
    second_share: RelativeError
    """Share of the particles, by number, that have the second diameter."""

    def sizes(self, diameter: float) -> Sizes:
        """Return the sizes for the first diameter [m]."""
        second = self.second_mm * 1e-3
        share = 1 - self.second_share if second < diameter else self.second_share
        return Sizes("binary", min(diameter, second), max(diameter, second), share)


Distribution = Annotated[Mono | Normal | Uniform | Binary, Field(discriminator="kind")]


class Particles(Model):
    """The particles: size, density, and the constants of their contacts with each other."""

    diameter_mm: Diameter = 2.0
    """Diameter [mm]; the mean one of a distribution, the first one of a binary mixture."""
    distribution: Distribution = Mono()
    """How diameters differ from particle to particle."""
    density_kg_m3: Annotated[float, Quantity(10, 25000, units=DENSITY)] = 1190.0
    """Density of the material [kg/m³]."""
    shell_mm: Spread | None = None
    """Wall thickness of hollow particles [mm]; their inertia is taken as that of solid ones of
    the same mass."""
    youngs_modulus_mpa: Modulus = 3200.0
    """Young's modulus of the material [MPa]; a run may use a lower one, see ``stiffness``."""
    poissons_ratio: PoissonsRatio = 0.35
    """Poisson's ratio of the material."""
    restitution: Restitution = 0.8
    """Coefficient of restitution of a collision of two particles."""
    friction: Friction = 0.3
    """Coefficient of sliding friction between two particles."""
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
        if self.shell_mm is None:
            return self.density_kg_m3
        return self.density_kg_m3 * (1 - (1 - 2 * self.shell_mm * 1e-3 / diameter) ** 3)

    @property
    def youngs_modulus(self) -> float:
        """Young's modulus of the material [Pa]."""
        return self.youngs_modulus_mpa * 1e6

    def mistakes(self) -> Iterator[Mistake]:
        """Yield a shell that the particles cannot have."""
        if self.shell_mm is not None:
            if not isinstance(self.distribution, Mono):
                yield Mistake(("shell_mm",), "only allowed for distribution: {kind: mono}")
            if 2 * self.shell_mm >= self.diameter_mm:
                yield Mistake(
                    ("shell_mm",), f"must be below half of diameter_mm = {self.diameter_mm:g}"
                )


class Walls(Model):
    """Contact constants of the cell walls; by default those between two particles.

    A wall that is stiffer than the particles stays stiffer when both are softened.
    """

    youngs_modulus_mpa: Modulus | None = None
    """Young's modulus of the walls [MPa]."""
    poissons_ratio: PoissonsRatio | None = None
    """Poisson's ratio of the walls."""
    restitution: Restitution | None = None
    """Coefficient of restitution of a particle and a wall."""
    friction: Friction | None = None
    """Coefficient of sliding friction between a particle and a wall."""
    rolling_friction: RollingFriction | None = None
    """Coefficient of rolling friction on a wall."""

    @property
    def youngs_modulus(self) -> float | None:
        """Young's modulus of the walls [Pa]; None for that of the particles."""
        return None if self.youngs_modulus_mpa is None else self.youngs_modulus_mpa * 1e6


Stroke = Annotated[float, Quantity(0, 100, low_itself=False)]
"""W/L [1]."""


class Crossing(Model):
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
        """Yield a range whose end is below its start."""
        start, stop = self.stroke_per_gap
        if stop < start:
            yield Mistake(("stroke_per_gap", 1), f"must be at least stroke_per_gap[0] = {start:g}")


class Stiffness(Model):
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


class Range(Model):
    """Equally spaced values: ``{from: 5, to: 2000, step: 10}``."""

    start: Frequency = Field(alias="from")
    """First value [Hz]."""
    stop: Frequency = Field(alias="to")
    """Largest value [Hz]; included if it is a whole number of steps away."""
    step: Annotated[float, Quantity(1e-3, 20000)]
    """Step between values [Hz]."""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield an end below the start."""
        if self.stop < self.start:
            yield Mistake(("to",), f"must be at least from = {self.start:g}")
        elif self.count > MOST_VALUES:
            yield Mistake((), f"has {self.count} values; allowed are {MOST_VALUES}")

    @property
    def count(self) -> int:
        """Number of the values."""
        return int((self.stop - self.start) / self.step * (1 + 1e-12)) + 1

    def values(self) -> tuple[float, ...]:
        """Return the values, the end among them if it is a whole number of steps away.

        Examples
        --------
        >>> Range(**{"from": 1, "to": 1.3, "step": 0.1}).values()
        (1.0, 1.1, 1.2, 1.3)
        """
        return tuple(round(self.start + i * self.step, 9) for i in range(self.count))


Gamma = Annotated[float, Quantity(0, 2000, low_itself=False, units=GRAVITIES)]
"""Amplitude of an acceleration [g]."""
Amplitude = Annotated[float, Quantity(0, 1000, low_itself=False, units=MILLIMETRES)]
"""Of a displacement [mm]."""


class Sweep(Model):
    """The points at which the coupon is shaken: every combination of the lists."""

    fill_fraction: Annotated[tuple[Fill, ...], Field(min_length=1)] = (0.1, 0.3, 0.5, 0.7, 0.9)
    """Fill fractions r: number of particles over that of a full cell."""
    frequency_hz: Range | Annotated[tuple[Frequency, ...], Field(min_length=1)]
    """Frequencies of the drive [Hz], as a list or as a range."""
    acceleration_g: tuple[Gamma, ...] = ()
    """Amplitude Γ of the acceleration, in units of standard gravity."""
    displacement_mm: tuple[Amplitude, ...] = ()
    """Amplitude W of the displacement [mm], instead of that of the acceleration."""
    diameter_mm: tuple[Diameter, ...] = ()
    """Diameters of the particles [mm]; by default ``particles.diameter_mm``."""
    max_velocity_m_s: Annotated[float, Quantity(1e-3, 1000, units=VELOCITY)] | None = None
    """Combinations with a larger velocity amplitude a/ω are omitted [m/s]."""

    @property
    def accelerations(self) -> tuple[float, ...]:
        """Amplitudes of the acceleration [m/s²]."""
        return tuple(level * STANDARD_GRAVITY for level in self.acceleration_g)

    @property
    def displacements(self) -> tuple[float, ...]:
        """Amplitudes of the displacement [m]."""
        return tuple(amplitude * 1e-3 for amplitude in self.displacement_mm)

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies [Hz], a range of them written out."""
        if isinstance(self.frequency_hz, Range):
            return self.frequency_hz.values()
        return self.frequency_hz

    def drive_count(self) -> int:
        """Return the number of combinations of frequency and amplitude that are not left out."""
        fastest = self.max_velocity_m_s or math.inf
        W, a = sorted(self.displacements), sorted(self.accelerations)
        return sum(
            bisect.bisect_right(W, fastest / omega) + bisect.bisect_right(a, fastest * omega)
            for omega in (2 * math.pi * frequency for frequency in self.frequencies)
        )

    def slowest(self) -> float:
        """Return the least velocity amplitude of all combinations [m/s]."""
        omega = [2 * math.pi * frequency for frequency in self.frequencies]
        if self.displacements:
            return min(omega) * min(self.displacements)
        return min(self.accelerations) / max(omega)

    def mistakes(self) -> Iterator[Mistake]:
        """Yield amplitudes of two kinds or of none, and duplicate values."""
        given = self.model_fields_set
        if self.acceleration_g and self.displacement_mm:
            yield Mistake(("displacement_mm",), "not allowed together with acceleration_g")
        if not self.acceleration_g and not self.displacement_mm:
            says = "must have at least 1 value" if "acceleration_g" in given else "missing"
            yield Mistake(("acceleration_g",), f"{says}; required unless displacement_mm is given")
        for key in (
            "fill_fraction",
            "frequency_hz",
            "acceleration_g",
            "displacement_mm",
            "diameter_mm",
        ):
            values = getattr(self, key)
            seen: set[str] = set()
            for index, value in enumerate(() if isinstance(values, Range) else values):
                text = f"{value:.6g}"
                if text in seen:
                    yield Mistake(
                        (key, index), "duplicate value; its cases would have the same labels"
                    )
                seen.add(text)


class Accuracy(Model):
    """A case runs until its target error or ``max_cycles``, whichever comes first."""

    relative_error: RelativeError = 0.05
    """Requested relative standard error of C_e; a case stops when it is reached."""
    seeds: Annotated[int, whole(1, 50)] = 2
    """Number of packings per case, with one run each."""
    min_cycles: Annotated[int, whole(8, 100000)] = 12
    """Minimum cycles of a run."""
    min_time_s: Annotated[float, Quantity(0, 10, units=MILLISECONDS)] = 0.05
    """Minimum simulated time [s]. A bed adapts to its drive in tens of milliseconds at any
    frequency, so slowly that a few cycles look steady."""
    max_cycles: Annotated[int, whole(8, 100000)] = 400
    """Maximum cycles of a run."""
    state_seeds: Annotated[int, whole(1, 50)] = 4
    """Number of seeds if the cells of a bed near the jump (``stiffness.crossing``) end in several
    states of motion."""
    state_cycles: Annotated[int, whole(0, 100000)] = 150
    """Minimum cycles of these seeds, up to ``max_cycles``; 0 switches the search for states off."""
    coverage: Fraction = 1.0
    """Required share of successful cases; below it the study stops."""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield a largest number of cycles below the least."""
        if self.max_cycles < self.min_cycles:
            yield Mistake(("max_cycles",), f"must be at least min_cycles = {self.min_cycles}")


Component = Annotated[float, Quantity(-1e6, 1e6)]
"""Of a direction."""


class Coupon(Model):
    """The shaken honeycomb coupon."""

    cell: Cell = Cell()
    """The honeycomb cell."""
    particles: Particles = Particles()
    """The particles and their contacts."""
    walls: Walls = Walls()
    """Contacts with the cell walls, where they differ."""
    gravity_g: Annotated[float, Quantity(0, 10, units=GRAVITIES)] = 1.0
    """Acceleration of gravity [g]; 0 for none."""
    gravity_direction: tuple[Component, Component, Component] = (0.0, 0.0, -1.0)
    """Direction of gravity. z is normal to the panel and the direction of the motion, so
    (0, 0, −1) is a horizontal panel and (1, 0, 0) an upright one."""
    stiffness: Stiffness = Stiffness()
    """Softening of the contacts, to save time."""
    time_step_rayleigh: Annotated[float, Quantity(0, 0.3, low_itself=False, units=PERCENT)] = 0.15
    """Time step over the Rayleigh time of a particle."""
    samples_per_cycle: Annotated[int, whole(20, 2000)] = 100
    """Samples of the momentum per cycle, from which C_e and m_a are computed."""
    sweep: Sweep
    """The drives: fills, frequencies and amplitudes."""
    vary: Mapping[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = {}
    """Values of any other key of the coupon, such as ``particles.friction: [0.1, 0.3, 0.6]``. The
    whole sweep is run for each value, and for every combination of several keys."""
    accuracy: Accuracy = Accuracy()
    """How long each case runs."""
    deck: Annotated[Path, file_in(TEMPLATES)] | None = None
    """Your own deck template instead of ``templates/shake.in.j2``."""

    @field_validator("vary")
    @classmethod
    def _find_decks(
        cls, vary: Mapping[str, tuple[Any, ...]], info: ValidationInfo
    ) -> Mapping[str, tuple[Any, ...]]:
        folder = (info.context or {}).get("folder")
        if folder is None or "deck" not in vary:
            return vary
        decks: list[Path | None] = []
        for index, name in enumerate(vary["deck"]):
            try:
                decks.append(name and found_file(Path(name), folder, TEMPLATES))
            except ValueError as error:
                raise Mistakes([Mistake(("deck", index), str(error))]) from None
        return {**vary, "deck": tuple(decks)}

    @property
    def diameters(self) -> tuple[float, ...]:
        """Diameters of the particles [m]: those of the sweep, or the one of the particles."""
        return tuple(d * 1e-3 for d in self.sweep.diameter_mm or (self.particles.diameter_mm,))

    @property
    def gravity(self) -> float:
        """Acceleration of gravity [m/s²]."""
        return self.gravity_g * STANDARD_GRAVITY

    @property
    def largest_mass_per_area(self) -> float:
        """About the mass of the particles over the area of the patch at the highest fill [kg/m²].

        Of spheres in random close packing, 0.64, to the height r times the depth.
        """
        fill_fraction = max(self.sweep.fill_fraction)
        density = max(self.particles.effective_density(d) for d in self.diameters)
        return 0.64 * density * self.cell.depth * fill_fraction

    def mistakes(self) -> Iterator[Mistake]:
        """Yield what of the coupon cannot be built or varied, and what is too much."""
        if not any(self.gravity_direction):
            yield Mistake(
                ("gravity_direction",), "must not be zero; for no gravity set gravity_g: 0"
            )
        # 9.78 to 9.84 m/s² all over the earth
        if abs(self.gravity_g - STANDARD_GRAVITY) < 0.03:
            says = f"must be from 0 to 10, and {self.gravity_g:g} m/s² would be 1"
            yield Mistake(("gravity_g",), says)
        yield from self._mistakes_of_sizes()
        count = math.prod(len(values) for values in self.vary.values())
        if count > MOST_VARIANTS:
            yield Mistake(("vary",), f"{count} combinations; allowed are {MOST_VARIANTS}")
            return
        yield from self._mistakes_of_variants()
        yield from self._mistakes_of_amount(count)

    def _mistakes_of_amount(self, variants: int) -> Iterator[Mistake]:
        """Yield a sweep without cases, or with more runs or spheres than can be run."""
        sweep, cell = self.sweep, self.cell
        drives = sweep.drive_count()
        if not drives:
            says = f"leaves out every combination; the slowest moves at {sweep.slowest():.2g} m/s"
            yield Mistake(("sweep", "max_velocity_m_s"), says)
        cases = drives * len(sweep.fill_fraction) * len(self.diameters) * variants
        runs = cases * self.accuracy.seeds
        if runs > MOST_RUNS:
            says = f"{cases} cases, {runs} runs; allowed are {MOST_RUNS} runs"
            yield Mistake(("sweep",), says)
        volume = cell.count * cell.across_flats**2 * cell.depth * max(sweep.fill_fraction)
        spheres = 0.64 * volume / (math.pi / 6 * min(self.diameters) ** 3)
        if spheres > MOST_SPHERES:
            keys: Keys = ("sweep" if sweep.diameter_mm else "particles", "diameter_mm")
            says = f"about {spheres:.1g} spheres in a run; allowed are {MOST_SPHERES}"
            yield Mistake(keys, says)

    def _mistakes_of_sizes(self) -> Iterator[Mistake]:
        widest = 0.9 * min(self.cell.across_flats, self.cell.depth)
        for index, diameter in enumerate(self.diameters):
            keys: Keys = ("particles", "diameter_mm")
            if self.sweep.diameter_mm:
                keys = ("sweep", "diameter_mm", index)
            sizes = self.particles.distribution.sizes(diameter)
            if sizes.largest > widest:
                yield Mistake(
                    keys,
                    f"the largest particle, {sizes.largest * 1e3:g} mm, must be at most 0.9 of "
                    f"the cell's across_flats_mm = {self.cell.across_flats_mm:g} and "
                    f"depth_mm = {self.cell.depth_mm:g}",
                )
            if sizes.smallest < 0.4 * sizes.largest:
                yield Mistake(
                    ("particles", "distribution"),
                    f"the smallest particle, {sizes.smallest * 1e3:g} mm, must be at least 0.4 of "
                    f"the largest, {sizes.largest * 1e3:g} mm: other mixtures separate by size",
                )

    def _mistakes_of_variants(self) -> Iterator[Mistake]:
        known = list(_dotted_keys(self._values()))
        for key, values in self.vary.items():
            if key not in known:
                yield Mistake(("vary", key), _unknown_in(key, known))
            for index, value in enumerate(values):
                if value in values[:index]:
                    yield Mistake(("vary", key, index), "duplicate value")
        # a mistake of many combinations is told of the first
        found: dict[Mistake, Mapping[str, Any]] = {}
        for chosen in self._combinations() if set(self.vary) <= set(known) else ():
            try:
                self._variant(chosen)
            except ValidationError as error:
                for mistake in mistakes_of(error, Coupon):
                    found.setdefault(mistake, chosen)
        yield from (self._in_vary(mistake, chosen) for mistake, chosen in found.items())

    def _in_vary(self, mistake: Mistake, chosen: Mapping[str, Any]) -> Mistake:
        """Return the mistake of a variant at the value of ``vary`` that causes it."""
        for key, value in chosen.items():
            path = tuple(key.split("."))
            if mistake.keys[: len(path)] == path:
                index = self.vary[key].index(value)
                return Mistake(("vary", key, index, *mistake.keys[len(path) :]), mistake.says)
        values = ", ".join(f"{name} = {value}" for name, value in chosen.items())
        return Mistake(("vary",), f"with {values}: {dotted(mistake.keys)}: {mistake.says}")

    def variants(self) -> tuple[tuple[Mapping[str, Any], Coupon], ...]:
        """Return every combination of ``vary`` and the coupon that it means.

        Returns
        -------
        tuple of (dict, Coupon)
            Varied keys with their values, and the coupon with these; without ``vary`` no keys
            and the coupon itself.
        """
        if not self.vary:
            return (({}, self),)
        return tuple((chosen, self._variant(chosen)) for chosen in self._combinations())

    def _combinations(self) -> Iterator[dict[str, Any]]:
        if self.vary:
            for values in itertools.product(*self.vary.values()):
                yield dict(zip(self.vary, values, strict=True))

    def _variant(self, chosen: Mapping[str, Any]) -> Coupon:
        values = self._values()
        for key, value in chosen.items():
            *path, last = key.split(".")
            section = values
            for part in path:
                section = section[part]
            section[last] = value
        return Coupon.model_validate({**values, "sweep": self.sweep, "accuracy": self.accuracy})

    def _values(self) -> dict[str, Any]:
        """Values of the keys that may be varied."""
        return self.model_dump(by_alias=True, exclude={"vary", "sweep", "accuracy"})


def _unknown_in(key: str, known: Sequence[str]) -> str:
    """Return what to say of a key that cannot be varied."""
    section, _, last = key.rpartition(".")
    if key.split(".")[0] in ("sweep", "accuracy", "vary"):
        return "cannot be varied"
    beside = [one.rpartition(".")[2] for one in known if one.rpartition(".")[0] == section]
    return unknown_key(last, beside) if beside else unknown_key(key, known)


def _dotted_keys(values: Mapping[str, Any], before: str = "") -> Iterator[str]:
    """Yield the keys of nested sections, ``particles`` and ``particles.friction``."""
    for key, value in values.items():
        yield before + key
        if isinstance(value, dict):
            yield from _dotted_keys(value, f"{before}{key}.")
