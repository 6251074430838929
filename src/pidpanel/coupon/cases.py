"""Which runs a study asks for: cases, their seeds, their packings, each with a stable label.

A label reads as the case and ends in a hash of everything the result depends on, the text of
the deck's template included. Coupon runs know nothing of panels, so the label is all that
two studies need to share a run.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import bed, contact, deck

if TYPE_CHECKING:  # pydantic is slow to import, and a run needs none of it
    from pidpanel.study import Coupon

POUR_MODULUS = 20e6
"""Pa; softness in the pour only sets how deep a sphere at rest sinks in: 2 µm at the bottom of
25 mm of acrylic, and what that releases when it is shaken stiffer is 1e-3 of m g d."""

LOOSEN_FREQUENCY = 100.0
LOOSEN_ACCELERATION = 10 * STANDARD_GRAVITY
LOOSEN_CYCLES = 20
"""How a poured bed is shaken loose (Hz, m/s²). A bed settled under drag is denser than any
shaken one and takes 0.1 to 0.2 s to loosen, whatever the frequency; begun from a bed that was
shaken loose at low frequency, where that is cheap, a run is steady after 0.03 s (measured at
700 Hz, 3 g: 20 cycles in place of 85, the same C_e)."""

POUR_TEMPLATES = ("fill.in.j2", "header.j2", "contacts.j2")
SHAKE_TEMPLATES = ("shake.in.j2", "header.j2", "contacts.j2")


@lru_cache
def _template_hash(names: tuple[str, ...]) -> str:
    return hashlib.sha256(deck.template_text(names).encode()).hexdigest()


def _digest(values: Any) -> str:
    text = json.dumps(values, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


@dataclass(frozen=True)
class Packing:
    """A bed poured higher than the cell is deep (SI)."""

    shape: str
    across_flats: float
    depth: float
    count: int
    diameter: float
    density: float
    poissons_ratio: float
    friction: float
    wall_friction: float
    seed: int

    @property
    def label(self) -> str:
        identity = asdict(self) | {"deck": _template_hash(POUR_TEMPLATES)}
        return (
            f"{self.shape}{self.across_flats * 1e3:g}x{self.depth * 1e3:g}mm_n{self.count}"
            f"_d{self.diameter * 1e3:g}mm_s{self.seed}_{_digest(identity)}"
        )


@dataclass(frozen=True)
class Bed:
    """What is left of a packing at a fill fraction, shaken loose once for all runs (SI)."""

    packing: Packing
    fill_fraction: float
    gravity: float
    restitution: float
    wall_restitution: float
    youngs_modulus: float

    @property
    def label(self) -> str:
        loosen = {
            "frequency": LOOSEN_FREQUENCY,
            "acceleration": LOOSEN_ACCELERATION,
            "cycles": LOOSEN_CYCLES,
        }
        identity = asdict(self) | {"deck": _template_hash(SHAKE_TEMPLATES), "loosen": loosen}
        return f"r{self.fill_fraction:g}_{self.packing.label[:-9]}_{_digest(identity)}"

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return asdict(self)

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Bed:
        return Bed(**{**values, "packing": Packing(**values["packing"])})


@dataclass(frozen=True)
class Run:
    """One LIGGGHTS process: a case with one seed (SI)."""

    bed: Bed
    frequency: float
    acceleration: float
    youngs_modulus: float
    time_step: float
    steps_per_cycle: int
    samples_per_cycle: int
    relative_error: float
    min_cycles: int
    max_cycles: int

    @property
    def packing(self) -> Packing:
        return self.bed.packing

    @property
    def fill_fraction(self) -> float:
        return self.bed.fill_fraction

    @property
    def amplitude(self) -> float:
        """W in m of the motion W sin ωt."""
        return self.acceleration / (2 * math.pi * self.frequency) ** 2

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return asdict(self)

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Run:
        return Run(**{**values, "bed": Bed.from_dict(values["bed"])})


@dataclass(frozen=True)
class Case:
    """One point of the sweep: the runs of all its seeds."""

    runs: tuple[Run, ...]

    @property
    def point(self) -> Run:
        """A run that stands for the case in all but the seed."""
        return self.runs[0]

    @property
    def label(self) -> str:
        first = self.runs[0]
        identity = {
            "runs": [r.as_dict() for r in self.runs],
            "deck": _template_hash(SHAKE_TEMPLATES),
        }
        return (
            f"r{first.fill_fraction:g}_f{first.frequency:g}Hz"
            f"_a{first.acceleration / STANDARD_GRAVITY:.4g}g"
            f"_d{first.packing.diameter * 1e3:g}mm_{_digest(identity)}"
        )


def cases_of(coupon: Coupon) -> tuple[Case, ...]:
    """Every case of a coupon's sweep, in the order fill, frequency, amplitude, diameter."""
    sweep = coupon.sweep
    diameters = sweep.diameter_mm or (coupon.particles.diameter_mm,)
    cases = []
    for fill, frequency, level, diameter_mm in itertools.product(
        sweep.fill_fraction, sweep.frequencies, sweep.acceleration_g, diameters
    ):
        speed = level * STANDARD_GRAVITY / (2 * math.pi * frequency)
        if sweep.max_velocity_m_s is not None and speed > sweep.max_velocity_m_s:
            continue
        runs = tuple(
            _run(coupon, fill, frequency, level * STANDARD_GRAVITY, diameter_mm * 1e-3, seed)
            for seed in range(1, coupon.accuracy.seeds + 1)
        )
        cases.append(Case(runs))
    return tuple(cases)


def _run(
    coupon: Coupon, fill: float, frequency: float, acceleration: float, diameter: float, seed: int
) -> Run:
    spheres, walls, accuracy = coupon.particles, coupon.walls, coupon.accuracy
    wall_friction = spheres.friction if walls.friction is None else walls.friction
    wall_restitution = spheres.restitution if walls.restitution is None else walls.restitution
    packing = Packing(
        shape=coupon.cell.shape,
        across_flats=coupon.cell.across_flats,
        depth=coupon.cell.depth,
        count=coupon.cell.count,
        diameter=diameter,
        density=spheres.density,
        poissons_ratio=spheres.poissons_ratio,
        friction=spheres.friction,
        wall_friction=wall_friction,
        seed=seed,
    )
    bed_ = Bed(
        packing=packing,
        fill_fraction=fill,
        gravity=coupon.gravity_g * STANDARD_GRAVITY,
        restitution=spheres.restitution,
        wall_restitution=wall_restitution,
        youngs_modulus=_modulus(coupon, diameter, LOOSEN_FREQUENCY, LOOSEN_ACCELERATION),
    )
    modulus = _modulus(coupon, diameter, frequency, acceleration)
    return drive(
        bed_,
        frequency,
        acceleration,
        modulus,
        time_step_rayleigh=coupon.time_step_rayleigh,
        samples_per_cycle=coupon.samples_per_cycle,
        # seeds share the work: each may be √seeds times as uncertain as the case
        relative_error=accuracy.relative_error * math.sqrt(accuracy.seeds),
        min_cycles=max(accuracy.min_cycles, math.ceil(accuracy.min_time_s * frequency)),
        max_cycles=max(accuracy.max_cycles, math.ceil(accuracy.min_time_s * frequency)),
    )


def _modulus(coupon: Coupon, diameter: float, frequency: float, acceleration: float) -> float:
    spheres = coupon.particles
    return contact.softest_modulus(
        tuple(choice * 1e6 for choice in coupon.stiffness.choices_mpa),
        spheres.youngs_modulus,
        radius=diameter / 2,
        density=spheres.density,
        poissons_ratio=spheres.poissons_ratio,
        speed=acceleration / (2 * math.pi * frequency),
        frequency=frequency,
        contact_time_per_period=coupon.stiffness.contact_time_per_period,
        overlap_per_radius=coupon.stiffness.overlap_per_radius,
    )


def drive(
    start: Bed,
    frequency: float,
    acceleration: float,
    youngs_modulus: float,
    *,
    time_step_rayleigh: float,
    samples_per_cycle: int,
    relative_error: float,
    min_cycles: int,
    max_cycles: int,
) -> Run:
    """A run of a bed, with a period of a whole number of steps and of samples."""
    packing = start.packing
    longest = time_step_rayleigh * contact.rayleigh_time(
        packing.diameter / 2, packing.density, youngs_modulus, packing.poissons_ratio
    )
    steps = samples_per_cycle * math.ceil(1 / frequency / longest / samples_per_cycle)
    return Run(
        bed=start,
        frequency=frequency,
        acceleration=acceleration,
        youngs_modulus=youngs_modulus,
        time_step=1 / frequency / steps,
        steps_per_cycle=steps,
        samples_per_cycle=samples_per_cycle,
        relative_error=relative_error,
        min_cycles=min_cycles,
        max_cycles=max_cycles,
    )


def loosening(start: Bed) -> Run:
    """The run that shakes a bed loose."""
    return drive(
        start,
        LOOSEN_FREQUENCY,
        LOOSEN_ACCELERATION,
        start.youngs_modulus,
        time_step_rayleigh=0.15,
        samples_per_cycle=100,
        relative_error=1.0,
        min_cycles=LOOSEN_CYCLES,
        max_cycles=LOOSEN_CYCLES,
    )


def cell_outline(packing: Packing) -> bed.Array:
    """Corners of one cell round its centre, (k, 2) m."""
    return bed.hexagon(packing.across_flats)
