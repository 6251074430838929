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
from typing import Any

from pidpanel.coupon import bed, contact, deck
from pidpanel.study import STANDARD_GRAVITY, Coupon

POUR_MODULUS = 20e6
"""Pa; softness in the pour only sets how deep a sphere at rest sinks in: 2 µm at the bottom of
25 mm of acrylic, and what that releases when it is shaken stiffer is 1e-3 of m g d."""

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
class Run:
    """One LIGGGHTS process: a case with one seed (SI)."""

    packing: Packing
    fill_fraction: float
    frequency: float
    acceleration: float
    gravity: float
    youngs_modulus: float
    restitution: float
    wall_restitution: float
    time_step: float
    steps_per_cycle: int
    samples_per_cycle: int
    relative_error: float
    min_cycles: int
    max_cycles: int

    @property
    def amplitude(self) -> float:
        """W in m of the motion W sin ωt."""
        return self.acceleration / (2 * math.pi * self.frequency) ** 2

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Run:
        return Run(**{**values, "packing": Packing(**values["packing"])})


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
        identity = {"runs": [r.as_dict() for r in self.runs], "deck": _template_hash(SHAKE_TEMPLATES)}
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
    modulus = contact.softest_modulus(
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
    longest = coupon.time_step_rayleigh * contact.rayleigh_time(
        diameter / 2, spheres.density, modulus, spheres.poissons_ratio
    )
    samples = coupon.samples_per_cycle
    steps = samples * math.ceil(1 / frequency / longest / samples)
    return Run(
        packing=packing,
        fill_fraction=fill,
        frequency=frequency,
        acceleration=acceleration,
        gravity=coupon.gravity_g * STANDARD_GRAVITY,
        youngs_modulus=modulus,
        restitution=spheres.restitution,
        wall_restitution=wall_restitution,
        time_step=1 / frequency / steps,
        steps_per_cycle=steps,
        samples_per_cycle=samples,
        # seeds share the work: each may be √seeds times as uncertain as the case
        relative_error=accuracy.relative_error * math.sqrt(accuracy.seeds),
        min_cycles=accuracy.min_cycles,
        max_cycles=accuracy.max_cycles,
    )


def cell_outline(packing: Packing) -> bed.Array:
    """Corners of one cell round its centre, (k, 2) m."""
    return bed.hexagon(packing.across_flats)
