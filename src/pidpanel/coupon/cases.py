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
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact, geometry
from pidpanel.coupon.liggghts import deck

if TYPE_CHECKING:  # pydantic is slow to import, and a run needs none of it
    from pidpanel.study.coupon import Coupon

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
    sizes: geometry.Sizes
    density: float
    poissons_ratio: float
    friction: float
    wall_friction: float
    seed: int

    @property
    def outline(self) -> Array:
        """Corners of one cell round its centre, (k, 2) m."""
        return geometry.cell_outline(self.shape, self.across_flats)

    @property
    def area(self) -> float:
        """Of all cells, m²."""
        return self.count * geometry.polygon_area(self.outline)

    @cached_property
    def label(self) -> str:
        identity = asdict(self) | {"deck": _template_hash(POUR_TEMPLATES)}
        return (
            f"{self.shape}{self.across_flats * 1e3:g}x{self.depth * 1e3:g}mm_n{self.count}"
            f"_d{self.diameter * 1e3:g}mm_s{self.seed}_{_digest(identity)}"
        )

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return asdict(self)

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Packing:
        return Packing(**{**values, "sizes": geometry.Sizes(**values["sizes"])})


@dataclass(frozen=True)
class Constants:
    """Constants of the contacts of spheres with spheres and with walls (SI).

    The moduli here are those of a run; see `softest_modulus`.
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


@dataclass(frozen=True)
class Bed:
    """What is left of a packing at a fill fraction, shaken loose once for all runs (SI)."""

    packing: Packing
    fill_fraction: float
    gravity: float
    gravity_direction: tuple[float, float, float]
    constants: Constants

    @cached_property
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
        return Bed(
            packing=Packing.from_dict(values["packing"]),
            fill_fraction=values["fill_fraction"],
            gravity=values["gravity"],
            gravity_direction=tuple(values["gravity_direction"]),
            constants=Constants(**values["constants"]),
        )


@dataclass(frozen=True)
class Run:
    """A bed under one drive: a case with one seed (SI)."""

    bed: Bed
    frequency: float
    acceleration: float
    constants: Constants
    time_step: float
    steps_per_cycle: int
    samples_per_cycle: int
    deck: str | None = None
    """Path of a template of the user's own."""

    @property
    def packing(self) -> Packing:
        return self.bed.packing

    @property
    def fill_fraction(self) -> float:
        return self.bed.fill_fraction

    @property
    def speed(self) -> float:
        """Velocity amplitude ωW, m/s."""
        return self.acceleration / (2 * math.pi * self.frequency)

    @property
    def amplitude(self) -> float:
        """W in m of the motion W sin ωt."""
        return self.acceleration / (2 * math.pi * self.frequency) ** 2

    def contact_time_at(self, youngs_modulus: float) -> float:
        """Duration of a sphere's impact on a wall at the speed of the drive, s."""
        return contact.wall_contact_time(
            self.packing.sizes.smallest / 2,
            self.packing.density,
            youngs_modulus,
            self.constants.poissons_ratio,
            self.speed,
        )

    @cached_property
    def identity(self) -> dict[str, Any]:
        """All that the rows of the run depend on."""
        if self.deck is None:
            text = _template_hash(SHAKE_TEMPLATES)
        else:
            text = hashlib.sha256(Path(self.deck).read_bytes()).hexdigest()
        return self.as_dict() | {"deck": text}

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return asdict(self)

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Run:
        return Run(
            **{
                **values,
                "bed": Bed.from_dict(values["bed"]),
                "constants": Constants(**values["constants"]),
            }
        )


@dataclass(frozen=True)
class Target:
    """How long a run lasts. Not part of what a run is: it goes on where it stopped."""

    relative_error: float
    min_cycles: int
    max_cycles: int

    @property
    def label(self) -> str:
        return f"{100 * self.relative_error:.4g}pc_{self.min_cycles}to{self.max_cycles}"


@dataclass(frozen=True)
class Case:
    """One point of the sweep: the runs of all its seeds."""

    runs: tuple[Run, ...]
    youngs_modulus: float
    """The material's own, Pa; a run may be softer."""
    relative_error: float
    target: Target
    """Of each run: seeds share the work, so each may be √seeds times as uncertain."""
    varied: Mapping[str, Any] = field(default_factory=dict)
    """Keys of ``coupon.vary`` with the values at this point."""

    @property
    def point(self) -> Run:
        """A run that stands for the case in all but the seed."""
        return self.runs[0]

    @cached_property
    def label(self) -> str:
        first = self.runs[0]
        return (
            f"r{first.fill_fraction:g}_f{first.frequency:g}Hz"
            f"_a{first.acceleration / STANDARD_GRAVITY:.4g}g"
            f"_d{first.packing.diameter * 1e3:g}mm_{_digest([r.identity for r in self.runs])}"
        )

    @property
    def bias(self) -> float:
        """Share by which softened contacts make C_e too large; see `contact.modulus_bias`."""
        run = self.point
        soft, own = (
            run.contact_time_at(modulus) * run.frequency
            for modulus in (run.constants.youngs_modulus, self.youngs_modulus)
        )
        return contact.modulus_bias(soft, own)

    def outcomes(self, folder: Path) -> list[Path]:
        """Files that say how the runs ended, below ``results/coupon``."""
        return [
            folder / self.label / f"s{run.packing.seed}" / f"{self.target.label}.json"
            for run in self.runs
        ]


def cases_of(coupon: Coupon) -> tuple[Case, ...]:
    """Every case of a coupon's sweep, in the order fill, frequency, amplitude, diameter.

    The combinations of ``vary`` come outermost.
    """
    return tuple(
        case
        for varied, variant in coupon.variants()
        for case in _swept(variant, {key: _plain(value) for key, value in varied.items()})
    )


def _plain(value: Any) -> Any:
    """A value as a table holds it."""
    if isinstance(value, list | tuple):
        return " ".join(f"{item:g}" for item in value)
    return value.name if isinstance(value, Path) else value


def _swept(coupon: Coupon, varied: Mapping[str, Any]) -> list[Case]:
    sweep, accuracy = coupon.sweep, coupon.accuracy
    diameters = sweep.diameter_mm or (coupon.particles.diameter_mm,)
    cases = []
    for fill, frequency, level, diameter_mm in itertools.product(
        sweep.fill_fraction,
        sweep.frequencies,
        sweep.displacement_mm or sweep.acceleration_g,
        diameters,
    ):
        omega = 2 * math.pi * frequency
        acceleration = (
            omega**2 * level * 1e-3 if sweep.displacement_mm else level * STANDARD_GRAVITY
        )
        if sweep.max_velocity_m_s is not None and acceleration / omega > sweep.max_velocity_m_s:
            continue
        runs = tuple(
            _run(coupon, fill, frequency, acceleration, diameter_mm, seed)
            for seed in range(1, accuracy.seeds + 1)
        )
        least = max(accuracy.min_cycles, math.ceil(accuracy.min_time_s * frequency))
        target = Target(
            relative_error=accuracy.relative_error * math.sqrt(accuracy.seeds),
            min_cycles=least,
            max_cycles=max(accuracy.max_cycles, least),
        )
        cases.append(
            Case(runs, coupon.particles.youngs_modulus, accuracy.relative_error, target, varied)
        )
    return cases


def _either(own: float | None, other: float) -> float:
    return other if own is None else own


def _run(
    coupon: Coupon,
    fill: float,
    frequency: float,
    acceleration: float,
    diameter_mm: float,
    seed: int,
) -> Run:
    spheres, walls = coupon.particles, coupon.walls
    packing = Packing(
        shape=coupon.cell.shape,
        across_flats=coupon.cell.across_flats,
        depth=coupon.cell.depth,
        count=coupon.cell.count,
        diameter=diameter_mm * 1e-3,
        sizes=spheres.distribution.sizes(diameter_mm),
        density=spheres.effective_density(diameter_mm),
        poissons_ratio=spheres.poissons_ratio,
        friction=spheres.friction,
        wall_friction=_either(walls.friction, spheres.friction),
        seed=seed,
    )
    length = math.hypot(*coupon.gravity_direction)
    x, y, z = (part / length for part in coupon.gravity_direction)
    return drive(
        Bed(
            packing=packing,
            fill_fraction=fill,
            gravity=coupon.gravity_g * STANDARD_GRAVITY,
            gravity_direction=(x, y, z),
            constants=_constants(coupon, packing, LOOSEN_FREQUENCY, LOOSEN_ACCELERATION),
        ),
        frequency,
        acceleration,
        _constants(coupon, packing, frequency, acceleration),
        time_step_rayleigh=coupon.time_step_rayleigh,
        samples_per_cycle=coupon.samples_per_cycle,
        deck_=None if coupon.deck is None else str(coupon.deck),
    )


def _constants(
    coupon: Coupon, packing: Packing, frequency: float, acceleration: float
) -> Constants:
    """The constants with both moduli softened alike, as the drive allows."""
    spheres, walls, stiffness = coupon.particles, coupon.walls, coupon.stiffness
    thrown = acceleration >= stiffness.from_acceleration_g * STANDARD_GRAVITY
    modulus = contact.softest_modulus(
        tuple(choice * 1e6 for choice in stiffness.choices_mpa) if thrown else (),
        spheres.youngs_modulus,
        radius=packing.sizes.largest / 2,
        density=packing.density,
        poissons_ratio=spheres.poissons_ratio,
        speed=acceleration / (2 * math.pi * frequency),
        frequency=frequency,
        contact_time_per_period=stiffness.contact_time_per_period,
        overlap_per_radius=stiffness.overlap_per_radius,
    )
    stiffer = _either(walls.youngs_modulus_mpa, spheres.youngs_modulus_mpa)
    return Constants(
        youngs_modulus=modulus,
        wall_youngs_modulus=modulus * stiffer / spheres.youngs_modulus_mpa,
        poissons_ratio=spheres.poissons_ratio,
        wall_poissons_ratio=_either(walls.poissons_ratio, spheres.poissons_ratio),
        restitution=spheres.restitution,
        wall_restitution=_either(walls.restitution, spheres.restitution),
        friction=spheres.friction,
        wall_friction=_either(walls.friction, spheres.friction),
        rolling_friction=spheres.rolling_friction,
        wall_rolling_friction=_either(walls.rolling_friction, spheres.rolling_friction),
    )


def drive(
    start: Bed,
    frequency: float,
    acceleration: float,
    constants: Constants,
    *,
    time_step_rayleigh: float,
    samples_per_cycle: int,
    deck_: str | None = None,
) -> Run:
    """A run of a bed, with a period of a whole number of steps and of samples."""
    packing = start.packing
    longest = time_step_rayleigh * contact.rayleigh_time(
        packing.sizes.smallest / 2,
        packing.density,
        constants.youngs_modulus,
        constants.poissons_ratio,
    )
    steps = samples_per_cycle * math.ceil(1 / frequency / longest / samples_per_cycle)
    return Run(
        bed=start,
        frequency=frequency,
        acceleration=acceleration,
        constants=constants,
        time_step=1 / frequency / steps,
        steps_per_cycle=steps,
        samples_per_cycle=samples_per_cycle,
        deck=deck_,
    )


def loosening(start: Bed) -> Run:
    """The run that shakes a bed loose."""
    return drive(
        start,
        LOOSEN_FREQUENCY,
        LOOSEN_ACCELERATION,
        start.constants,
        time_step_rayleigh=0.15,
        samples_per_cycle=100,
    )
