"""Beds that are shaken loose, and runs of a bed under a drive."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact, geometry
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts import deck, process
from pidpanel.coupon.packing import Packing
from pidpanel.paths import TEMPLATES
from pidpanel.provenance.digests import json_digest

# Version of the algorithm that shakes a bed loose and selects its spheres: `preparation.loosen`;
# see `packing.PLACEMENT_VERSION`.
LOOSEN_VERSION = 1


@dataclass(frozen=True)
class Loosening:
    """How a poured bed is shaken loose; of the last frames that with the least overlap is kept.

    A bed settled under drag is denser than any shaken one and takes 0.1 to 0.2 s to loosen,
    whatever the frequency; begun from a bed that was shaken loose at low frequency, where that is
    cheap, a run is steady after 0.03 s (measured at 700 Hz, 3 g: 20 cycles in place of 85, the same
    C_e). The time step is over the Rayleigh time of the smallest sphere.
    """

    drive: Tone
    cycles: int = 20
    frames: int = 20
    time_step_rayleigh: float = 0.15
    samples_per_cycle: int = 100


# A start from the other side: factor on the acceleration of the drive, and number of cycles. Beds
# of acrylic at r = 0.5, 100 Hz, 80 g reach other states from there than from rest.
HARD, HARD_CYCLES = 2.5, 20

MOST_CELLS = 24  # most cells with rows of their own: LIGGGHTS has 32 groups

LOOSENING = Loosening(drive=Tone(frequency=100.0, acceleration=10 * STANDARD_GRAVITY))


@dataclass(frozen=True)
class Bed:
    """What is left of a packing at a fill fraction r = N/N_full, shaken loose once for all runs.

    Gravity [m/s²] has a unit vector; the constants are those of the contacts while it is loosened.
    """

    packing: Packing
    fill_fraction: float
    gravity: float
    gravity_direction: tuple[float, float, float]
    constants: Constants

    def stroke_per_gap(self, drive: Tone) -> float:
        """Return W/L of a drive, L = (1 − r) depth the clear gap [1]; infinite without one."""
        gap = (1 - self.fill_fraction) * self.packing.depth
        return drive.amplitude / gap if gap > 0 else math.inf

    def deepening(self, drive: Tone) -> float:
        """Return the bias by long contacts over that at half fill [1]; 1 if the bed crosses.

        See `contact.deepening`.
        """
        if self.stroke_per_gap(drive) >= contact.CROSSING:
            return 1.0
        layers = self.fill_fraction * self.packing.depth / self.packing.diameter
        normal = max(self.gravity * abs(self.gravity_direction[2]), STANDARD_GRAVITY)
        return contact.deepening(layers, drive.acceleration / normal)

    @cached_property
    def identity(self) -> str:
        """Hash of all that the bed depends on; gravity and constants are in the deck."""
        return json_digest(
            self.packing.identity,
            self.fill_fraction,
            asdict(LOOSENING),
            loosening(self).deck_digest(),
            process.RUN,
            process.VERSION,
            LOOSEN_VERSION,
        )

    @property
    def label(self) -> str:
        """Folder below ``results/coupon/bed``."""
        return f"r{self.fill_fraction:g}_{self.packing.name}_{self.identity[:8]}"


@dataclass(frozen=True)
class Run:
    """A bed under one drive: a case with one seed.

    A period has a whole number of steps and of samples. ``deck`` is the path of a template of the
    user's own, None for that of the drive. The bed starts at rest, or shaken `HARD` for
    `HARD_CYCLES` before the first row.
    """

    bed: Bed
    drive: Tone
    constants: Constants
    time_step: float
    steps_per_cycle: int
    samples_per_cycle: int
    deck: str | None = None
    start: Literal["rest", "hard"] = "rest"
    deck_constants: tuple[tuple[str, float], ...] = ()  # further variables of a deck of the user's

    @property
    def packing(self) -> Packing:
        """Packing of the bed."""
        return self.bed.packing

    @property
    def fill_fraction(self) -> float:
        """Fill fraction of the bed [1]."""
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
        """Return the duration of a sphere's impact on a wall at the speed of the drive [s]."""
        return self.packing.smallest(youngs_modulus).wall_contact_time(self.drive.speed)

    def overlap_at(self, youngs_modulus: float) -> float:
        """Return the deepest overlap of that impact over the radius [1]."""
        sphere = self.packing.smallest(youngs_modulus)
        return sphere.wall_overlap(self.drive.speed) / sphere.radius

    def deck_values(self, leg: int = 1, restart: str | None = None) -> dict[str, Any]:
        """Return the variables of the template for the run, or a leg of it from a restart."""
        values = {
            **dict(self.deck_constants),
            **self.constants.deck_values,
            "data_file": deck.START_FILE,
            "walls_file": deck.WALLS_FILE,
            "cycles_file": deck.cycles_file(leg),
            "skin": 0.3 * self.packing.diameter,
            "depth": self.packing.depth,
            "gravity": self.bed.gravity,
            "gravity_direction": " ".join(f"{part:.12g}" for part in self.bed.gravity_direction),
            "frequency": self.drive.frequency,
            "amplitude": self.drive.amplitude,
            "acceleration": self.drive.acceleration,
            "speed": self.drive.speed,
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
        """Return the deck of the run, or of a leg of it from a restart: built-in or user's own.

        Raises
        ------
        jinja2.UndefinedError
            If a variable of the user's template is not in `deck_values`.
        DeckRefused
            For a deck of the user's own that is not trusted; see `deck.check_trust`.
        """
        template, values = self._template, self.deck_values(leg, restart)
        return deck.render(template.name, values, template.parent)

    def deck_digest(self, restart: str | None = None) -> str:
        """Return the hash of the deck of the run without comments: what its rows depend on.

        Runs that differ in their beds alone have one deck, which is rendered once in a process.
        """
        template, values = self._template, self.deck_values(restart=restart)
        return deck.digest(template.name, template.parent, tuple(values.items()))

    @property
    def _template(self) -> Path:
        if self.deck is None:
            return TEMPLATES / "shake.in.j2"
        return deck.check_trust(Path(self.deck))

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
        return json_digest(
            self.bed.identity,
            asdict(self.drive),
            [self.deck_digest(restart) for restart in restarts],
            process.CYCLE,
            process.VERSION,
        )


def run_at(
    bed: Bed,
    drive: Tone,
    constants: Constants,
    *,
    time_step_rayleigh: float,
    samples_per_cycle: int,
    own_deck: str | None = None,
    start: Literal["rest", "hard"] = "rest",
    deck_constants: Mapping[str, float] = MappingProxyType({}),
) -> Run:
    """Return a run of a bed, with a period of a whole number of steps and of samples.

    Parameters
    ----------
    bed, drive, constants
        Bed, motion of its cells, and constants of the contacts.
    time_step_rayleigh
        Longest time step over the Rayleigh time of the smallest sphere [1].
    samples_per_cycle
        Number of samples of the momentum in a period.
    own_deck, start
        Template of the user instead of the built-in one; start from rest or from hard shaking.
    deck_constants
        Further variables of that template.
    """
    longest = time_step_rayleigh * bed.packing.smallest(constants.youngs_modulus).rayleigh_time
    steps = samples_per_cycle * math.ceil(drive.period / longest / samples_per_cycle)
    step = drive.period / steps
    own = own_deck, start, tuple(deck_constants.items())
    return Run(bed, drive, constants, step, steps, samples_per_cycle, *own)


def loosening(bed: Bed) -> Run:
    """Return the run that shakes a bed loose."""
    return run_at(
        bed,
        LOOSENING.drive,
        bed.constants,
        time_step_rayleigh=LOOSENING.time_step_rayleigh,
        samples_per_cycle=LOOSENING.samples_per_cycle,
    )
