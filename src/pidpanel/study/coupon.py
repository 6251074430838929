"""The section ``coupon`` of a study: cells, particles, contacts, and what of them is varied."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.geometry.cells import ShapeName
from pidpanel.paths import TEMPLATES
from pidpanel.study.base import Acceleration, Fraction, RelativeError, SectionModel, Vector, file_in
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.particles import Particles, Stiffness, Walls
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.sweep import USUAL_SWEEP, Sweep
from pidpanel.study.units import InSI

MOST_RUNS = 200_000  # runs that a sweep may have; twice as many as have been run
MOST_SPHERES = 1_000_000  # spheres that a run may have: a step of them takes a second


class Cell(SectionModel):
    """The honeycomb cell, and the number of cells per run."""

    shape: ShapeName = "hexagon"
    """Cross-section of the cell."""
    across_flats_mm: Annotated[float, Quantity(0.5, 500, unit="small_millimetres")] = 6.35
    """Width of a hexagon between two sides; side of a square; diameter of a circle [mm]. On a
    sandwich whose core has a grade, hexagons have its cell size by default."""
    depth_mm: Annotated[float, Quantity(0.5, 1000, unit="small_millimetres")] = 25.0
    """Depth of the cell between its two closed ends [mm]; on a sandwich by default the thickness of
    its core."""
    count: Annotated[int, whole(1, 200)] = 5
    """Cells per run, shaken side by side; they share only the drive."""

    across_flats: ClassVar = InSI("across_flats_mm")
    depth: ClassVar = InSI("depth_mm")


class Accuracy(SectionModel):
    """A case runs until its target error or ``max_cycles``, whichever comes first."""

    relative_error: RelativeError = 0.05
    """Requested relative standard error of C_e; a case stops when it is reached."""
    seeds: Annotated[int, whole(1, 50)] = 2
    """Number of packings per case, with one run each."""
    min_cycles: Annotated[int, whole(8, 100000)] = 12
    """Minimum cycles of a run."""
    min_time_s: Annotated[float, Quantity(0, 10, unit="milliseconds")] = 0.05
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
        if self.max_cycles < self.min_cycles:
            yield Mistake(("max_cycles",), f"must be at least min_cycles = {self.min_cycles}")


Component = Annotated[float, Quantity(-1e6, 1e6)]  # of a direction


class Coupon(SectionModel):
    """The shaken honeycomb coupon."""

    cell: Cell = Cell()
    """The honeycomb cell."""
    particles: Particles = Particles()
    """The particles and their contacts."""
    walls: Walls = Walls()
    """Contacts with the cell walls, where they differ."""
    gravity_g: Annotated[float, Quantity(0, 10, unit="gravities")] = 1.0
    """Acceleration of gravity [g]; 0 for none."""
    gravity_direction: tuple[Component, Component, Component] = (0.0, 0.0, -1.0)
    """Direction of gravity. z is normal to the panel and the direction of the motion, so
    (0, 0, −1) is a horizontal panel and (1, 0, 0) an upright one."""
    steady_acceleration_g: Acceleration | None = None
    """Steady acceleration that the particles feel besides gravity, in the same axes [g]: opposite
    to that of a launcher, so (0, 0, −3) beside gravity along −z is 4 g in all. By default that of
    the section ``sound`` or ``base``; scenarios may have their own."""
    stiffness: Stiffness = Stiffness()
    """Softening of the contacts, to save time."""
    time_step_rayleigh: Annotated[float, Quantity(0, 0.3, low_itself=False, unit="percent")] = 0.15
    """Time step over the Rayleigh time of a particle."""
    samples_per_cycle: Annotated[int, whole(20, 2000)] = 100
    """Samples of the momentum per cycle, from which C_e and m_a are computed."""
    sweep: Sweep = USUAL_SWEEP
    """The drives of single tones: fills, frequencies and amplitudes. The damping models ``coupled``
    and ``atlas`` need none; of theirs only the highest fill counts, up to which the shapes of the
    panel follow the mass of the particles."""
    accuracy: Accuracy = Accuracy()
    """How long each case of single tones runs."""
    deck: Annotated[Path, file_in(TEMPLATES)] | None = None
    """Your own deck template instead of ``templates/shake.in.j2``."""
    deck_values: Mapping[str, Annotated[float, Quantity(-1e30, 1e30)]] = {}
    """Constants of your own deck by the names of its variables, such as ``yield_stress: 1.0e+6``
    [any unit]. ``vary`` may have them as ``deck_values.yield_stress``."""

    @property
    def diameters(self) -> tuple[float, ...]:
        """Diameters of the particles [m]: those of the sweep, or the one of the particles."""
        return self.sweep.diameters or (self.particles.diameter,)

    @property
    def apparent_gravity_g(self) -> Vector:
        """Gravity and steady acceleration together [g]."""
        length = math.hypot(*self.gravity_direction)
        steady = self.steady_acceleration_g or (0.0, 0.0, 0.0)
        parts = zip(self.gravity_direction, steady, strict=True)
        x, y, z = (self.gravity_g * part / length + added for part, added in parts)
        return x, y, z

    @property
    def gravity(self) -> float:
        """Magnitude of `apparent_gravity_g` [m/s²]."""
        return math.hypot(*self.apparent_gravity_g) * STANDARD_GRAVITY

    @property
    def gravity_axis(self) -> Vector:
        """Unit vector of `apparent_gravity_g`; −z without any."""
        x, y, z = self.apparent_gravity_g
        size = math.hypot(x, y, z)
        return (x / size, y / size, z / size) if size else (0.0, 0.0, -1.0)

    @property
    def transverse_share(self) -> float:
        """Share of `apparent_gravity_g` across the motion, sin² of the angle to it; 0 flat [1]."""
        x, y, z = self.apparent_gravity_g
        square = x * x + y * y
        return square / (square + z * z) if square else 0.0

    @property
    def gravity_angle_deg(self) -> float:
        """Angle of `apparent_gravity_g` to the motion, 0 to 90 [°]."""
        return math.degrees(math.asin(math.sqrt(self.transverse_share)))

    @property
    def bed_mass_per_area(self) -> float:
        """Approximate mass per area of the particles at the highest fill [kg/m²].

        Of spheres in random close packing, 0.64, to the height r times the depth.
        """
        fill_fraction = max(self.sweep.fill_fraction)
        density = max(self.particles.effective_density(d) for d in self.diameters)
        return 0.64 * density * self.cell.depth * fill_fraction

    def mistakes(self) -> Iterator[Mistake]:
        if not any(self.gravity_direction):
            message = "must not be zero; for no gravity set gravity_g: 0"
            yield Mistake(("gravity_direction",), message)
        # 9.78 to 9.84 m/s² all over the earth
        if abs(self.gravity_g - STANDARD_GRAVITY) < 0.03:
            message = f"must be from 0 to 10, and {self.gravity_g:g} m/s² would be 1"
            yield Mistake(("gravity_g",), message)
        yield from self._mistakes_of_runs()

    def _mistakes_of_runs(self) -> Iterator[Mistake]:
        yield from self._mistakes_of_sizes()
        yield from self._mistakes_of_amount(1)

    def _mistakes_of_amount(self, variants: int) -> Iterator[Mistake]:
        """Yield a sweep without cases, or with more runs or spheres than can be run."""
        sweep, cell = self.sweep, self.cell
        drives = sweep.drive_count()
        if not drives:
            message = f"leaves out every combination; the slowest moves at {sweep.slowest():.2g} "
            yield Mistake(("sweep", "max_velocity_m_s"), f"{message}m/s")
        cases = drives * len(sweep.fill_fraction) * len(self.diameters) * variants
        runs = cases * self.accuracy.seeds
        if runs > MOST_RUNS:
            message = f"{cases} cases, {runs} runs; allowed are {MOST_RUNS} runs"
            yield Mistake(("sweep",), message)
        volume = cell.count * cell.across_flats**2 * cell.depth * max(sweep.fill_fraction)
        spheres = 0.64 * volume / (math.pi / 6 * min(self.diameters) ** 3)
        if spheres > MOST_SPHERES:
            keys: Keys = ("sweep" if sweep.diameter_mm else "particles", "diameter_mm")
            message = f"about {spheres:.1g} spheres in a run; allowed are {MOST_SPHERES}"
            yield Mistake(keys, message)

    def _mistakes_of_sizes(self) -> Iterator[Mistake]:
        widest = 0.9 * min(self.cell.across_flats, self.cell.depth)
        for index, diameter in enumerate(self.diameters):
            keys: Keys = ("particles", "diameter_mm")
            if self.sweep.diameter_mm:
                keys = ("sweep", "diameter_mm", index)
            sizes = self.particles.distribution.sizes(diameter)
            if sizes.largest > widest:
                message = f"the largest particle, {sizes.largest * 1e3:g} mm, must be at most 0.9 "
                message += f"of the cell's across_flats_mm = {self.cell.across_flats_mm:g} and "
                yield Mistake(keys, f"{message}depth_mm = {self.cell.depth_mm:g}")
            if sizes.smallest < 0.4 * sizes.largest:
                message = (
                    f"the smallest particle, {sizes.smallest * 1e3:g} mm, must be at least 0.4 "
                )
                message += f"of the largest, {sizes.largest * 1e3:g} mm: other mixtures separate "
                yield Mistake(("particles", "distribution"), f"{message}by size")

    def variants(self) -> tuple[tuple[Mapping[str, Any], Coupon], ...]:
        """Return varied keys with their values, and the coupon that they mean; here itself."""
        return (({}, self),)

    @property
    def decks(self) -> tuple[Path, ...]:
        """Deck templates instead of ``templates/shake.in.j2``."""
        return () if self.deck is None else (self.deck,)
