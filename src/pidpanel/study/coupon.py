"""The coupon's part of a study: cells, spheres, contacts, and what of them is swept."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, ValidationError, model_validator

from pidpanel.coupon.geometry import Sizes
from pidpanel.study.base import Fill, Fraction, Model, Positive


class Cell(Model):
    """One honeycomb cell, and how many of them a run shakes side by side."""

    shape: Literal["hexagon", "square", "circle"] = "hexagon"
    across_flats_mm: Positive = 6.35
    """Width of a hexagon between two sides; side of a square; diameter of a circle."""
    depth_mm: Positive = 25.0
    count: Annotated[int, Field(ge=1, le=200)] = 5

    @property
    def across_flats(self) -> float:
        return self.across_flats_mm * 1e-3

    @property
    def depth(self) -> float:
        return self.depth_mm * 1e-3


class Mono(Model):
    """Spheres of one size."""

    kind: Literal["mono"] = "mono"

    def sizes(self, diameter_mm: float) -> Sizes:
        return Sizes("mono", diameter_mm * 1e-3, diameter_mm * 1e-3)


class Normal(Model):
    """Normal distribution by number round ``diameter_mm``, cut at two deviations."""

    kind: Literal["normal"]
    deviation_mm: Positive

    def sizes(self, diameter_mm: float) -> Sizes:
        reach = 2 * self.deviation_mm
        return Sizes("normal", (diameter_mm - reach) * 1e-3, (diameter_mm + reach) * 1e-3)


class Uniform(Model):
    """Uniform distribution by number over ``diameter_mm`` ± ``half_width_mm``."""

    kind: Literal["uniform"]
    half_width_mm: Positive

    def sizes(self, diameter_mm: float) -> Sizes:
        reach = self.half_width_mm
        return Sizes("uniform", (diameter_mm - reach) * 1e-3, (diameter_mm + reach) * 1e-3)


class Binary(Model):
    """Two sizes: a share by number of ``second_mm`` among spheres of ``diameter_mm``."""

    kind: Literal["binary"]
    second_mm: Positive
    second_share: Annotated[float, Field(gt=0, lt=1)]

    def sizes(self, diameter_mm: float) -> Sizes:
        if self.second_mm < diameter_mm:
            share = 1 - self.second_share
        else:
            share = self.second_share
        small, large = sorted((diameter_mm, self.second_mm))
        return Sizes("binary", small * 1e-3, large * 1e-3, share)


Distribution = Annotated[Mono | Normal | Uniform | Binary, Field(discriminator="kind")]


class Particles(Model):
    """The spheres. ``youngs_modulus_mpa`` is the material's own; see `Stiffness`."""

    diameter_mm: Positive = 2.0
    distribution: Distribution = Mono()
    density_kg_m3: Positive = 1190.0
    shell_mm: Positive | None = None
    """Wall thickness of hollow spheres; their inertia is taken as that of solid ones of
    the same mass."""
    youngs_modulus_mpa: Annotated[float, Field(ge=5, le=1e6)] = 3200.0
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5)] = 0.35
    restitution: Annotated[float, Field(gt=0.05, le=1)] = 0.8
    friction: Annotated[float, Field(ge=0, le=5)] = 0.3
    rolling_friction: Annotated[float, Field(ge=0, le=1)] = 0.0

    def effective_density(self, diameter_mm: float) -> float:
        """Mass over outer volume, kg/m³: ρ (1 − (1 − 2 t/d)³) for a shell of thickness t."""
        if self.shell_mm is None:
            return self.density_kg_m3
        return self.density_kg_m3 * (1 - (1 - 2 * self.shell_mm / diameter_mm) ** 3)

    @property
    def youngs_modulus(self) -> float:
        return self.youngs_modulus_mpa * 1e6

    @model_validator(mode="after")
    def _shell(self) -> Particles:
        if self.shell_mm is not None:
            if not isinstance(self.distribution, Mono):
                raise ValueError("shell_mm: hollow spheres of one size only, distribution mono")
            if 2 * self.shell_mm >= self.diameter_mm:
                raise ValueError(
                    f"shell_mm = {self.shell_mm:g}: below half of diameter_mm = "
                    f"{self.diameter_mm:g}"
                )
        return self


class Walls(Model):
    """The cell walls and their contact with spheres; what is left out is as between two
    spheres. A wall that is stiffer than the spheres stays so when both are softened."""

    youngs_modulus_mpa: Annotated[float, Field(ge=5, le=1e6)] | None = None
    poissons_ratio: Annotated[float, Field(gt=-1, lt=0.5)] | None = None
    restitution: Annotated[float, Field(gt=0.05, le=1)] | None = None
    friction: Annotated[float, Field(ge=0, le=5)] | None = None
    rolling_friction: Annotated[float, Field(ge=0, le=1)] | None = None


class Stiffness(Model):
    """Softening of the contacts: the time step grows as the modulus falls.

    The softest of ``choices_mpa`` is taken that keeps a Hertz contact at the drive's own
    speed shorter than ``contact_time_per_period`` of a period and its overlap below
    ``overlap_per_radius``; the material's own modulus if none does, and below
    ``from_acceleration_g``, where the bed bounces as one body and what it loses hangs on how
    its layers rebound in series (100 Hz, 5 g: 50 MPa dissipates 1.8 times what 3.2 GPa does,
    at 20 g the same; ``coupon_modulus.yaml``).
    """

    choices_mpa: tuple[Annotated[float, Field(ge=5, le=1e6)], ...] = (50.0, 200.0, 800.0)
    contact_time_per_period: Annotated[float, Field(gt=0, le=0.5)] = 0.02
    overlap_per_radius: Annotated[float, Field(gt=0, le=0.5)] = 0.10
    from_acceleration_g: Annotated[float, Field(ge=0)] = 10.0


class Range(Model):
    """Equally spaced values: ``{from: 5, to: 2000, step: 10}``."""

    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)
    start: Positive = Field(alias="from")
    stop: Positive = Field(alias="to")
    step: Positive

    @model_validator(mode="after")
    def _rises(self) -> Range:
        if self.stop < self.start:
            raise ValueError("'to' must not be below 'from'")
        return self

    def values(self) -> tuple[float, ...]:
        count = int((self.stop - self.start) / self.step * (1 + 1e-12)) + 1
        return tuple(round(self.start + i * self.step, 9) for i in range(count))


class Sweep(Model):
    """The points at which the coupon is shaken: every combination of the lists."""

    fill_fraction: Annotated[tuple[Fill, ...], Field(min_length=1)] = (0.1, 0.3, 0.5, 0.7, 0.9)
    frequency_hz: (
        Range | Annotated[tuple[Annotated[float, Field(ge=1, le=20000)], ...], Field(min_length=1)]
    )
    acceleration_g: tuple[Annotated[float, Field(gt=0, le=2000)], ...] = ()
    displacement_mm: tuple[Annotated[float, Field(gt=0, le=1000)], ...] = ()
    """Amplitude W of the motion, in place of its acceleration."""
    diameter_mm: tuple[Positive, ...] = ()
    max_velocity_m_s: Positive | None = None
    """Combinations whose velocity amplitude a/ω is above this are left out."""

    @property
    def frequencies(self) -> tuple[float, ...]:
        if isinstance(self.frequency_hz, Range):
            return self.frequency_hz.values()
        return self.frequency_hz

    @model_validator(mode="after")
    def _one_amplitude(self) -> Sweep:
        if bool(self.acceleration_g) == bool(self.displacement_mm):
            raise ValueError("acceleration_g or displacement_mm: one of them, a list")
        return self

    @model_validator(mode="after")
    def _no_case_twice(self) -> Sweep:
        for key in (
            "fill_fraction",
            "frequency_hz",
            "acceleration_g",
            "displacement_mm",
            "diameter_mm",
        ):
            values = getattr(self, key)
            if isinstance(values, Range):
                continue
            seen: set[str] = set()
            for value in values:
                text = f"{value:.6g}"
                if text in seen:
                    raise ValueError(
                        f"{key} = {value:g} stands twice: two cases would carry one label; "
                        "each value once"
                    )
                seen.add(text)
        return self


class Accuracy(Model):
    """How long a case runs: to its error target or ``max_cycles``, whichever is first."""

    relative_error: Annotated[float, Field(gt=0, lt=1)] = 0.05
    seeds: Annotated[int, Field(ge=1, le=50)] = 2
    min_cycles: Annotated[int, Field(ge=8)] = 12
    min_time_s: Annotated[float, Field(ge=0, le=10)] = 0.05
    """Least simulated time: a bed adapts to its drive in tens of milliseconds, however many
    cycles these are, and so slowly that a few cycles look steady."""
    max_cycles: Annotated[int, Field(ge=8, le=100000)] = 400
    coverage: Fraction = 1.0
    """Share of the cases that must stand before anything is built on them."""

    @model_validator(mode="after")
    def _ordered(self) -> Accuracy:
        if self.max_cycles < self.min_cycles:
            raise ValueError(
                f"max_cycles = {self.max_cycles}: at least min_cycles = {self.min_cycles}"
            )
        return self


class Coupon(Model):
    """The shaken honeycomb coupon."""

    cell: Cell = Cell()
    particles: Particles = Particles()
    walls: Walls = Walls()
    gravity_g: Annotated[float, Field(ge=0, le=10)] = 1.0
    gravity_direction: tuple[float, float, float] = (0.0, 0.0, -1.0)
    """Where gravity points: z is normal to the panel and the direction of the motion, so
    (0, 0, −1) is a panel that lies flat and (1, 0, 0) one that stands upright."""
    stiffness: Stiffness = Stiffness()
    time_step_rayleigh: Annotated[float, Field(gt=0, le=0.3)] = 0.15
    """Time step over the Rayleigh time of a sphere."""
    samples_per_cycle: Annotated[int, Field(ge=20, le=2000)] = 100
    sweep: Sweep
    vary: Mapping[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = {}
    """Any other key of the coupon and its values, ``particles.friction: [0.1, 0.3, 0.6]``:
    the whole sweep is run at each of them, and at every combination of several."""
    accuracy: Accuracy = Accuracy()
    deck: Path | None = None
    """A template of the user's own in place of ``templates/shake.in.j2``."""

    @model_validator(mode="after")
    def _direction(self) -> Coupon:
        if not any(self.gravity_direction):
            raise ValueError("gravity_direction = [0, 0, 0]: a direction; no gravity: gravity_g: 0")
        return self

    @model_validator(mode="after")
    def _spheres_fit(self) -> Coupon:
        widest = 0.9 * min(self.cell.across_flats_mm, self.cell.depth_mm)
        for diameter in self.sweep.diameter_mm or (self.particles.diameter_mm,):
            sizes = self.particles.distribution.sizes(diameter)
            if sizes.largest * 1e3 > widest:
                raise ValueError(
                    f"particles.diameter_mm = {diameter:g}: at most 0.9 of the cell's "
                    f"across_flats_mm and depth_mm ({self.cell.across_flats_mm:g}, "
                    f"{self.cell.depth_mm:g})"
                )
            if sizes.smallest < 0.4 * sizes.largest:
                raise ValueError(
                    f"particles.distribution: the smallest sphere, {sizes.smallest * 1e3:g} mm, is "
                    f"below 0.4 of the largest, {sizes.largest * 1e3:g} mm: a bed so mixed "
                    "separates by size, and one time step fits ill"
                )
        return self

    @model_validator(mode="after")
    def _variants(self) -> Coupon:
        for key in self.vary:
            if key.split(".")[0] in ("sweep", "accuracy", "vary"):
                raise ValueError(f"vary.{key}: not this one; the lists of sweep are varied as such")
        self.variants()
        return self

    def variants(self) -> tuple[tuple[Mapping[str, Any], Coupon], ...]:
        """Every combination of ``vary`` with the coupon that it means; itself without any."""
        if not self.vary:
            return (({}, self),)
        found = []
        for values in itertools.product(*self.vary.values()):
            chosen = dict(zip(self.vary, values, strict=True))
            data = self.model_dump(mode="python", by_alias=True, exclude={"vary"})
            for key, value in chosen.items():
                *path, last = key.split(".")
                place: Any = data
                for part in path:
                    place = place.get(part) if isinstance(place, dict) else None
                if not isinstance(place, dict) or last not in place:
                    known = place if isinstance(place, dict) else data
                    raise ValueError(
                        f"vary.{key}: no such key of the coupon; there are {', '.join(known)}"
                    )
                place[last] = value
            try:
                found.append((chosen, Coupon.model_validate(data)))
            except ValidationError as error:
                item = error.errors()[0]
                where = ", ".join(f"{key} = {value}" for key, value in chosen.items())
                message = item["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
                raise ValueError(f"vary: {where}: {message}") from None
        return tuple(found)
