"""What is run: packings, beds, runs and cases, each with a label that says what it rests on.

A label reads as the thing and ends in a hash of all that its numbers depend on, so a study needs
nothing but the labels to share runs with another:

packing
    its values and outline, the constants of the pour (`POURING`), the deck that pours, the
    command that runs it, the version of LIGGGHTS, the versions of the algorithms that place
    spheres and pour (`PLACEMENT_VERSION`, `POUR_VERSION`);
bed
    its packing, its fill fraction, the constants of the loosening (`LOOSENING`), the deck that
    shakes it loose, the command that runs it, the version of LIGGGHTS, the version of the algorithm
    that loosens (`LOOSEN_VERSION`);
run
    its bed, its drive, the deck that shakes it, the command that runs a cycle, the version of
    LIGGGHTS;
case
    its runs.

A deck enters as LIGGGHTS takes it, rendered and without comments. Algorithms enter by version
numbers. Those that read rows and average them (`cycles`, `rows`, `window`, `summary`) do not enter.
``docs/reruns.md`` lists what makes what run again.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from pidpanel.arrays import Array
from pidpanel.cells import SHAPES, ShapeName
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import coding, contact, geometry
from pidpanel.coupon.drive import Drive, Tone
from pidpanel.coupon.liggghts import deck, process, trust
from pidpanel.coupon.liggghts.failures import DeckRefused
from pidpanel.paths import TEMPLATES
from pidpanel.sizes import Sizes

PLACEMENT_VERSION = 1
"""Of the algorithms that draw the spheres, scatter them over the cells, and write spheres and walls
for LIGGGHTS: `sizes`, `geometry`, `start_files`, `preparation.scattered`. Like the two below, it
grows when the bits of what they make change (`tests/coupon/test_versions.py`)."""

POUR_VERSION = 1
"""Of the algorithm that lets the spheres settle and counts a full cell: `preparation.pour`."""

LOOSEN_VERSION = 1
"""Of the algorithm that shakes a bed loose and picks its spheres: `preparation.loosen`."""


def _hash(*parts: Any) -> str:
    text = json.dumps(parts, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


@dataclass(frozen=True)
class Constants:
    """Constants of the contacts of spheres with spheres and with walls.

    Attributes
    ----------
    youngs_modulus, wall_youngs_modulus
        [Pa]. Those of a run, which may be softer than the material; see `contact.softest_modulus`.
    poissons_ratio, wall_poissons_ratio, restitution, wall_restitution
        [1]
    friction, wall_friction, rolling_friction, wall_rolling_friction
        Coefficients [1].
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

    @property
    def has_rolling_friction(self) -> bool:
        """Whether anything resists rolling."""
        return bool(self.rolling_friction or self.wall_rolling_friction)

    @property
    def deck_values(self) -> dict[str, Any]:
        """Variables of ``templates/contacts.j2`` in SI."""
        return {**vars(self), "contact_model": deck.contact_model(self.has_rolling_friction)}


@dataclass(frozen=True)
class Pouring:
    """How a packing is poured.

    Attributes
    ----------
    youngs_modulus
        [Pa]; softness in the pour only sets how deep a sphere at rest sinks in: 2 µm at the bottom
        of 25 mm of acrylic, and what that releases when it is shaken stiffer is 1e-3 of m g d.
    restitution
        [1]
    fall_time
        Duration of the fall from rest whose speed is the terminal speed under drag [s].
    time_step_rayleigh
        Time step over the Rayleigh time of the smallest sphere [1].
    settled
        Kinetic energy per sphere over m g d at which a poured bed is at rest [1].
    """

    youngs_modulus: float = 20e6
    restitution: float = 0.5
    fall_time: float = 0.2
    time_step_rayleigh: float = 0.25
    settled: float = 1e-6


POURING = Pouring()


@dataclass(frozen=True)
class Loosening:
    """How a poured bed is shaken loose.

    A bed settled under drag is denser than any shaken one and takes 0.1 to 0.2 s to loosen,
    whatever the frequency; begun from a bed that was shaken loose at low frequency, where that is
    cheap, a run is steady after 0.03 s (measured at 700 Hz, 3 g: 20 cycles in place of 85, the
    same C_e).

    Attributes
    ----------
    drive
        How it is shaken.
    cycles
        How long.
    frames
        Frames of the last cycle, of which the one with the least overlap is kept.
    time_step_rayleigh
        Time step over the Rayleigh time of the smallest sphere [1].
    samples_per_cycle
        Of the cycle rows, which nobody reads.
    """

    drive: Drive
    cycles: int = 20
    frames: int = 20
    time_step_rayleigh: float = 0.15
    samples_per_cycle: int = 100


HARD, HARD_CYCLES = 2.5, 20
"""A start from the other side: so many times the acceleration of the drive, for so many cycles.
Beds of acrylic at r = 0.5, 100 Hz, 80 g come to other states from there than from rest."""

MOST_CELLS = 24
"""Most cells of which each has rows of its own: LIGGGHTS has 32 groups."""

LOOSENING = Loosening(drive=Tone(frequency=100.0, acceleration=10 * STANDARD_GRAVITY))


@dataclass(frozen=True)
class Packing:
    """Cells with spheres, poured higher than the cells are deep.

    Attributes
    ----------
    shape
        Of a cell: a key of `cells.SHAPES`.
    across_flats, depth
        Of a cell [m].
    count
        Of cells.
    diameter
        Nominal diameter of the spheres [m].
    sizes
        Distribution of their diameters.
    density
        [kg/m³]
    poissons_ratio, friction, wall_friction
        Of the pour [1].
    seed
        Of the random numbers.
    """

    shape: ShapeName
    across_flats: float
    depth: float
    count: int
    diameter: float
    sizes: Sizes
    density: float
    poissons_ratio: float
    friction: float
    wall_friction: float
    seed: int

    @cached_property
    def outline(self) -> Array:
        """Corners of one cell round its centre, (k, 2) [m]."""
        return SHAPES[self.shape].outline(self.across_flats)

    @cached_property
    def centres(self) -> Array:
        """Centres of the cells, (count, 2) [m]."""
        return geometry.cell_centres(self.across_flats, self.count)

    @cached_property
    def cell_area(self) -> float:
        """Of one cell [m²]."""
        return geometry.polygon_area(self.outline)

    @property
    def area(self) -> float:
        """Of all cells [m²]."""
        return self.count * self.cell_area

    @property
    def pour_constants(self) -> Constants:
        """Constants of the contacts of the pour."""
        return Constants(
            youngs_modulus=POURING.youngs_modulus,
            wall_youngs_modulus=POURING.youngs_modulus,
            poissons_ratio=self.poissons_ratio,
            wall_poissons_ratio=self.poissons_ratio,
            restitution=POURING.restitution,
            wall_restitution=POURING.restitution,
            friction=self.friction,
            wall_friction=self.wall_friction,
            rolling_friction=0.0,
            wall_rolling_friction=0.0,
        )

    @property
    def pour_time_step(self) -> float:
        """Time step of the pour [s]."""
        return POURING.time_step_rayleigh * contact.rayleigh_time(
            self.sizes.smallest / 2, self.density, POURING.youngs_modulus, self.poissons_ratio
        )

    def deck_text(self, *, drag: float, chunk_steps: int) -> str:
        """Deck that pours the packing.

        Parameters
        ----------
        drag
            Force over speed [N s/m].
        chunk_steps
            Steps between two lines of the log.
        """
        values = {
            **self.pour_constants.deck_values,
            "data_file": deck.START_FILE,
            "walls_file": deck.WALLS_FILE,
            "skin": 0.3 * self.diameter,
            "gravity": STANDARD_GRAVITY,
            "drag": drag,
            "time_step": self.pour_time_step,
            "chunk_steps": chunk_steps,
        }
        return deck.render("fill.in.j2", values)

    @cached_property
    def identity(self) -> str:
        """Hash of all that the packing depends on."""
        # drag and the length of a chunk follow from the spheres by the code that pours
        text = self.deck_text(drag=1.0, chunk_steps=1)
        return _hash(
            coding.encode(self),
            # twelve digits, as LIGGGHTS is given them: more may differ between machines
            [f"{x:.12g} {y:.12g}" for x, y in self.outline],
            coding.encode(POURING),
            deck.without_comments(text),
            process.RUN,
            process.VERSION,
            [PLACEMENT_VERSION, POUR_VERSION],
        )

    @property
    def name(self) -> str:
        """The label without its hash."""
        return (
            f"{self.shape}{self.across_flats * 1e3:g}x{self.depth * 1e3:g}mm_n{self.count}"
            f"_d{self.diameter * 1e3:g}mm_s{self.seed}"
        )

    @property
    def label(self) -> str:
        """Folder below ``results/coupon/packing``."""
        return f"{self.name}_{self.identity[:8]}"

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return coding.encode(self)

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Packing:
        """The inverse of `as_dict`."""
        return coding.decode(Packing, values)


@dataclass(frozen=True)
class Bed:
    """What is left of a packing at a fill fraction, shaken loose once for all runs.

    Attributes
    ----------
    packing
        Where it comes from.
    fill_fraction
        r = N/N_full [1].
    gravity
        [m/s²]
    gravity_direction
        Unit vector.
    constants
        Of the contacts while it is shaken loose.
    """

    packing: Packing
    fill_fraction: float
    gravity: float
    gravity_direction: tuple[float, float, float]
    constants: Constants

    def stroke_per_gap(self, drive: Drive) -> float:
        """W/L of a drive, L = (1 − r) depth the clear gap [1]; infinite without one."""
        gap = (1 - self.fill_fraction) * self.packing.depth
        return drive.amplitude / gap if gap > 0 else math.inf

    def deepening(self, drive: Drive) -> float:
        """How much more it is biased by long contacts than at half fill [1]; 1 where it crosses.

        See `contact.deepening`.
        """
        if self.stroke_per_gap(drive) >= contact.CROSSING:
            return 1.0
        layers = self.fill_fraction * self.packing.depth / self.packing.diameter
        return contact.deepening(layers, drive.acceleration / STANDARD_GRAVITY)

    @cached_property
    def identity(self) -> str:
        """Hash of all that the bed depends on; gravity and constants are in the deck."""
        return _hash(
            self.packing.identity,
            self.fill_fraction,
            coding.encode(LOOSENING),
            loosening(self).deck_digest(),
            process.RUN,
            process.VERSION,
            LOOSEN_VERSION,
        )

    @property
    def label(self) -> str:
        """Folder below ``results/coupon/bed``."""
        return f"r{self.fill_fraction:g}_{self.packing.name}_{self.identity[:8]}"

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return coding.encode(self)

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Bed:
        """The inverse of `as_dict`."""
        return coding.decode(Bed, values)


@dataclass(frozen=True)
class Run:
    """A bed under one drive: a case with one seed.

    Attributes
    ----------
    bed, drive
        What is shaken, and how.
    constants
        Of the contacts.
    time_step
        [s]
    steps_per_cycle, samples_per_cycle
        A whole number of each to a period.
    deck
        Path of a template of the user's own; None for that of the drive.
    start
        The bed at rest, or shaken `HARD` for `HARD_CYCLES` before the first row.
    """

    bed: Bed
    drive: Drive
    constants: Constants
    time_step: float
    steps_per_cycle: int
    samples_per_cycle: int
    deck: str | None = None
    start: Literal["rest", "hard"] = "rest"

    @property
    def packing(self) -> Packing:
        """Of the bed."""
        return self.bed.packing

    @property
    def fill_fraction(self) -> float:
        """Of the bed [1]."""
        return self.bed.fill_fraction

    @property
    def cycles_before(self) -> int:
        """Cycles before the first row."""
        return HARD_CYCLES if self.start == "hard" else 0

    @property
    def cells_listed(self) -> int:
        """Cells that have rows of their own; none of a single cell, or in a deck of the user's."""
        count = self.packing.count
        return count if self.deck is None and 1 < count <= MOST_CELLS else 0

    def contact_time_at(self, youngs_modulus: float) -> float:
        """Duration of a sphere's impact on a wall at the speed of the drive [s].

        Parameters
        ----------
        youngs_modulus
            [Pa]
        """
        return contact.wall_contact_time(
            self.packing.sizes.smallest / 2,
            self.packing.density,
            youngs_modulus,
            self.constants.poissons_ratio,
            self.drive.speed,
        )

    def overlap_at(self, youngs_modulus: float) -> float:
        """Deepest overlap of that impact over the radius [1].

        Parameters
        ----------
        youngs_modulus
            [Pa]
        """
        radius = self.packing.sizes.smallest / 2
        depth = contact.wall_overlap(
            radius,
            self.packing.density,
            youngs_modulus,
            self.constants.poissons_ratio,
            self.drive.speed,
        )
        return depth / radius

    def deck_values(self, leg: int = 1, restart: str | None = None) -> dict[str, Any]:
        """Variables of the template for the run, or a leg of it from a restart."""
        values = {
            **self.constants.deck_values,
            "data_file": deck.START_FILE,
            "walls_file": deck.WALLS_FILE,
            "cycles_file": deck.cycles_file(leg),
            "skin": 0.3 * self.packing.diameter,
            "depth": self.packing.depth,
            "gravity": self.bed.gravity,
            "gravity_direction": " ".join(f"{part:.12g}" for part in self.bed.gravity_direction),
            **self.drive.deck_values,
            "time_step": self.time_step,
            "steps_per_cycle": self.steps_per_cycle,
            "samples_per_cycle": self.samples_per_cycle,
            "steps_per_sample": self.steps_per_cycle // self.samples_per_cycle,
            "first_step": self.cycles_before * self.steps_per_cycle,
            "hard_acceleration": HARD * self.drive.acceleration,
            "cells": tuple(map(tuple, self.packing.centres[: self.cells_listed].tolist())),
            "cells_file": deck.cells_file(leg),
            "reach": geometry.CELL_SPACING / 2 * self.packing.across_flats,
        }
        return values if restart is None else {**values, "restart_file": restart}

    def deck_text(self, leg: int = 1, restart: str | None = None) -> str:
        """Deck of the run, or of a leg of it from a restart: ours, or the user's own.

        Raises
        ------
        jinja2.UndefinedError
            For a variable of the user's template that `deck_values` does not hold.
        DeckRefused
            For a deck of the user's own that is not trusted; see `trust`.
        """
        own, values = self._template, self.deck_values(leg, restart)
        text = deck.render(own.name, values, own.parent)
        if not trust.is_trusted(own):
            for refused in trust.refusals(text, deck.files_in(values)):
                raise DeckRefused(f"{own}: {refused}")
        return text

    def deck_digest(self, restart: str | None = None) -> str:
        """Hash of the deck of the run without comments: what its rows depend on.

        Runs that differ in their beds alone have one deck, which is rendered once in a process.
        """
        own, values = self._template, self.deck_values(restart=restart)
        return deck.digest(own.name, own.parent, tuple(values.items()))

    @property
    def _template(self) -> Path:
        return TEMPLATES / self.drive.template if self.deck is None else Path(self.deck)

    @property
    def lists_contacts(self) -> bool:
        """Whether the deck can list the contacts, without which there is no energy balance."""
        return deck.lists_contacts(self._template)

    @cached_property
    def identity(self) -> str:
        """Hash of all that the rows of the run depend on; time step and constants are in the deck.

        A deck of ours enters as it starts and as it continues from a restart.
        """
        restarts = (None, "restart") if self.deck is None else (None,)
        return _hash(
            self.bed.identity,
            coding.encode(self.drive),
            [self.deck_digest(restart) for restart in restarts],
            process.CYCLE,
            process.VERSION,
        )

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return coding.encode(self)

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Run:
        """The inverse of `as_dict`."""
        return coding.decode(Run, values)


@dataclass(frozen=True)
class Target:
    """How long a run lasts. Not part of what a run is: it continues where it stopped.

    Attributes
    ----------
    relative_error
        Of C_e [1].
    min_cycles, max_cycles
        Bounds of its length.
    """

    relative_error: float
    min_cycles: int
    max_cycles: int

    @property
    def label(self) -> str:
        """A part of the name of the file that says how a run ended."""
        return f"{100 * self.relative_error:.9g}pc_{self.min_cycles}to{self.max_cycles}"

    def as_strict_as(self, other: Target) -> Target:
        """Return the target that satisfies another too.

        Examples
        --------
        >>> Target(0.05, 12, 400).as_strict_as(Target(0.1, 20, 200))
        Target(relative_error=0.05, min_cycles=20, max_cycles=400)
        """
        return Target(
            min(self.relative_error, other.relative_error),
            max(self.min_cycles, other.min_cycles),
            max(self.max_cycles, other.max_cycles),
        )


@dataclass(frozen=True)
class Case:
    """One point of the sweep: the runs of all its seeds.

    Attributes
    ----------
    runs
        One a seed.
    youngs_modulus
        The material's own [Pa]; a run may be softer.
    relative_error
        Asked of C_e, all seeds together [1].
    target
        Of each run: seeds share the work, so each may be √seeds times as uncertain.
    varied
        Keys of ``coupon.vary`` with the values at this point.
    reserve
        Runs of further seeds, for a case whose cells end in several states of motion; see
        `states`.
    state_cycles
        Cycles that all runs of such a case last at least; 0 where the stroke is too short or too
        long for several states to be looked for.
    """

    runs: tuple[Run, ...]
    youngs_modulus: float
    relative_error: float
    target: Target
    varied: Mapping[str, Any] = field(default_factory=dict)
    reserve: tuple[Run, ...] = ()
    state_cycles: int = 0

    @property
    def point(self) -> Run:
        """A run that is the case in all but the seed."""
        return self.runs[0]

    @cached_property
    def label(self) -> str:
        """Folder below ``results/coupon``."""
        first = self.runs[0]
        return (
            f"r{first.fill_fraction:g}_{first.drive.label}"
            f"_d{first.packing.diameter * 1e3:g}mm_{_hash(*(r.identity for r in self.runs))[:8]}"
        )

    def as_strict_as(self, other: Case) -> Case:
        """Return the case with a target that satisfies that of another, of the same runs, too."""
        target = self.target.as_strict_as(other.target)
        error = min(self.relative_error, other.relative_error)
        return replace(self, target=target, relative_error=error)

    @property
    def bias(self) -> float:
        """Share by which softened contacts make C_e too large [1]; see `contact.modulus_bias`."""
        run = self.point
        moduli = (run.constants.youngs_modulus, self.youngs_modulus)
        soft, own = (run.contact_time_at(modulus) * run.drive.frequency for modulus in moduli)
        deep, own_depth = (run.overlap_at(modulus) for modulus in moduli)
        if run.bed.stroke_per_gap(run.drive) < contact.CROSSING:
            deep = own_depth
        return contact.modulus_bias(soft, own, deep, own_depth, run.bed.deepening(run.drive))

    def folders(self, folder: Path) -> list[Path]:
        """Folders of the runs below ``results/coupon``, one a seed."""
        return [folder / self.label / f"s{run.packing.seed}" for run in self.runs]

    @property
    def least_cycles(self) -> int:
        """Cycles of a run at least: a third of `state_cycles` where several states are possible."""
        target = self.target
        return max(target.min_cycles, min(target.max_cycles, math.ceil(self.state_cycles / 3)))

    @property
    def with_reserve(self) -> Case:
        """The case with its reserve among its runs, in the folder of the same label."""
        whole = replace(self, runs=(*self.runs, *self.reserve), reserve=())
        whole.__dict__["label"] = self.label
        return whole

    @property
    def outcome(self) -> str:
        """Name of the files that say how its runs ended: all that the end depends on."""
        return self.target.label + (f"_states{self.state_cycles}" if self.state_cycles else "")

    def outcomes(self, folder: Path) -> list[Path]:
        """Files that say how the runs ended, below ``results/coupon``, one a seed."""
        return [own / f"{self.outcome}.json" for own in self.folders(folder)]

    def as_dict(self) -> dict[str, Any]:
        """As JSON holds it; `from_dict` is the inverse."""
        return coding.encode(self)

    @staticmethod
    def from_dict(values: Mapping[str, Any]) -> Case:
        """The inverse of `as_dict`."""
        return coding.decode(Case, values)


def run_at(
    bed: Bed,
    drive: Drive,
    constants: Constants,
    *,
    time_step_rayleigh: float,
    samples_per_cycle: int,
    own_deck: str | None = None,
    start: Literal["rest", "hard"] = "rest",
) -> Run:
    """A run of a bed, with a period of a whole number of steps and of samples.

    Parameters
    ----------
    bed, drive, constants
        As of `Run`.
    time_step_rayleigh
        Longest time step over the Rayleigh time of the smallest sphere [1].
    samples_per_cycle
        As of `Run`.
    own_deck
        Path of a template of the user's own.
    start
        As of `Run`.
    """
    packing = bed.packing
    longest = time_step_rayleigh * contact.rayleigh_time(
        packing.sizes.smallest / 2,
        packing.density,
        constants.youngs_modulus,
        constants.poissons_ratio,
    )
    steps = samples_per_cycle * math.ceil(drive.period / longest / samples_per_cycle)
    return Run(
        bed=bed,
        drive=drive,
        constants=constants,
        time_step=drive.period / steps,
        steps_per_cycle=steps,
        samples_per_cycle=samples_per_cycle,
        deck=own_deck,
        start=start,
    )


def loosening(bed: Bed) -> Run:
    """The run that shakes a bed loose."""
    return run_at(
        bed,
        LOOSENING.drive,
        bed.constants,
        time_step_rayleigh=LOOSENING.time_step_rayleigh,
        samples_per_cycle=LOOSENING.samples_per_cycle,
    )
