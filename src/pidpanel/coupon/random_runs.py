"""Shake a coupon at random: the force on its cells and their velocity, line by line.

One leg is one period of a multisine after a while to settle into it. A further leg, with other
phases or another PSD, begins from the spheres where the one before left them, at rest.

In the frame of the cells the momentum p of the particles changes by the force F of the cells on
them and by the inertia of the motion, so that in all, gravity aside,

    F = dp/dt + M a,      per area F = (iω P + M A)/A_c on each line.
"""

from __future__ import annotations

import math
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel import durable
from pidpanel.arrays import Array, Complexes
from pidpanel.coupon import contact, geometry
from pidpanel.coupon.cases import Bed, Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts import deck, sphere_dump
from pidpanel.coupon.liggghts.failures import LogTruncated, NotFinite, ParticlesLost, RunStopped
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.multisine import SAMPLES_PER_PERIOD, Multisine, draw_multisine
from pidpanel.coupon.preparation import write_start
from pidpanel.paths import TEMPLATES

TEMPLATE = "random.in.j2"
VALUE_FILE, SLOPE_FILE, RECORD_FILE = "value.txt", "slope.txt", "record.txt"
LAST_FILE = "last.dump"

SETTLING = 0.2
"""Time before the period that counts [s]: a bed takes 0.1 to 0.2 s to a motion, whatever it is."""

FELT = 1e-4
"""Share of its largest value by which the inertia that the particles felt may differ from the one
asked for: rows have six digits."""

ROUNDED = 2e-5
"""Share by which p² may be above 2 M E_kin where all spheres move alike: six digits of each."""

HEADER = ["# Time-averaged data for fix record", "# TimeStep v_p v_inertia c_ke"]


@dataclass(frozen=True)
class RandomRun:
    """One leg of a bed under a random motion.

    Attributes
    ----------
    bed, constants
        The bed and the constants of its contacts.
    band
        Lowest and highest frequency of the motion [Hz].
    period
        T [s] of the multisine: the length of the record, and 1/T from line to line.
    phases
        Seed of the phases.
    time_step, steps_per_sample
        [s], and steps from sample to sample.
    """

    bed: Bed
    constants: Constants
    band: tuple[float, float]
    period: float
    phases: int
    time_step: float
    steps_per_sample: int

    @property
    def deck_values(self) -> dict[str, Any]:
        """Variables of ``templates/random.in.j2`` in SI."""
        bed = self.bed
        return {
            **self.constants.deck_values,
            "data_file": deck.START_FILE,
            "walls_file": deck.WALLS_FILE,
            "value_file": VALUE_FILE,
            "slope_file": SLOPE_FILE,
            "record_file": RECORD_FILE,
            "skin": 0.3 * bed.packing.diameter,
            "gravity": bed.gravity,
            "gravity_direction": " ".join(f"{part:.12g}" for part in bed.gravity_direction),
            "time_step": self.time_step,
            "steps_per_sample": self.steps_per_sample,
        }


def random_run(
    bed: Bed,
    constants: Constants,
    band: tuple[float, float],
    period: float,
    phases: int,
    time_step_rayleigh: float,
) -> RandomRun:
    """Return a leg with a whole number of steps to a sample.

    Parameters
    ----------
    bed, constants, band, period, phases
        As of `RandomRun`.
    time_step_rayleigh
        Longest time step over the Rayleigh time of the smallest sphere [1].
    """
    packing = bed.packing
    longest = time_step_rayleigh * contact.rayleigh_time(
        packing.sizes.smallest / 2,
        packing.density,
        constants.youngs_modulus,
        constants.poissons_ratio,
    )
    sample = period / math.ceil(SAMPLES_PER_PERIOD * band[1] * period)
    steps = math.ceil(sample / longest)
    return RandomRun(bed, constants, band, period, phases, sample / steps, steps)


def sine_of(motion: tuple[Array, Array]) -> Tone:
    """Return the sine with the rms acceleration and the rms velocity of a random motion.

    Parameters
    ----------
    motion
        (m,) frequencies [Hz] and the PSD of the acceleration there [(m/s²)²/Hz].
    """
    frequency, psd = motion
    acceleration = math.sqrt(float(np.trapezoid(psd, frequency)))
    velocity = math.sqrt(float(np.trapezoid(psd / (2 * np.pi * frequency) ** 2, frequency)))
    return Tone(acceleration / velocity / (2 * math.pi), math.sqrt(2) * acceleration)


@dataclass(frozen=True)
class Record:
    """What a leg left: spectra on the lines, normalised as in `multisine`.

    Attributes
    ----------
    frequency
        (n,) lines [Hz].
    velocity
        (n,) of the cells [m/s/√Hz].
    force
        (n,) of the cells on the particles, over their area [Pa/√Hz].
    period
        T [s].
    cells
        Number of cells.
    area
        Of the cells [m²].
    mass_per_area
        Of the particles [kg/m²].
    spheres
        (n_spheres, 4) where they were left: x, y, z and diameter [m].
    """

    frequency: Array
    velocity: Complexes
    force: Complexes
    period: float
    cells: int
    area: float
    mass_per_area: float
    spheres: Array

    def write(self, path: Path) -> None:
        """Write it as NPZ."""
        with durable.replacing(path) as draft:
            np.savez(draft, **vars(self))

    @staticmethod
    def read(path: Path) -> Record:
        """Read what `write` left.

        Raises
        ------
        LogTruncated
            If it is not all there.
        """
        try:
            with np.load(path) as stored:
                found = {name: stored[name] for name in Record.__dataclass_fields__}
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            says = f"{path}: not a record of a random motion; delete it to run it again"
            raise LogTruncated(f"{says} ({error})") from None
        scalars = {"period": float, "cells": int, "area": float, "mass_per_area": float}
        return Record(**{k: scalars[k](v) if k in scalars else v for k, v in found.items()})


def shake_at_random(
    run: RandomRun,
    motion: tuple[Array, Array],
    spheres: Array,
    folder: Path,
    template: Path = TEMPLATES / TEMPLATE,
) -> Record:
    """Shake one leg in a folder, which is emptied and keeps its deck and log.

    Parameters
    ----------
    run
        The leg.
    motion
        (m,) frequencies [Hz] and the PSD of the acceleration there [(m/s²)²/Hz].
    spheres
        (n_spheres, 4) of the bed, or of the leg before: x, y, z and diameter [m].
    folder
        Of the leg.
    template
        Of the deck.

    Raises
    ------
    SolverFailure
        Named after what went wrong.
    """
    packing = run.bed.packing
    mass = float(geometry.masses(spheres[:, 3], packing.density).sum())
    write_start(folder, packing, spheres)
    sine = draw_multisine(*motion, run.band, run.period, np.random.default_rng(run.phases))
    values, settling = _settled(sine)
    _write_drive(folder, -values, run.steps_per_sample)
    count = len(values) - 1
    steps = count * run.steps_per_sample
    with Liggghts(folder, "random") as solver:
        solver.read_deck(deck.render(template.name, run.deck_values, template.parent))
        reached = solver.run_from_files(steps, run.steps_per_sample, ("value", "slope"))
        if reached.step != steps:
            raise RunStopped(f"{folder}: at step {reached.step}, not {steps}")
        if reached.spheres != len(spheres):
            raise ParticlesLost(f"{folder}: {reached.spheres} spheres of {len(spheres)}")
        solver.dump(LAST_FILE)
        solver.finish()
    rows = read_rows(folder / RECORD_FILE, run.steps_per_sample, count)
    check_rows(rows, -values, mass, str(folder / RECORD_FILE))
    last = sphere_dump.read_dump((folder / LAST_FILE).read_text(), str(folder / LAST_FILE))[-1]
    for name in (VALUE_FILE, SLOPE_FILE, RECORD_FILE, LAST_FILE, deck.START_FILE, deck.WALLS_FILE):
        (folder / name).unlink()
    force, velocity = spectra(sine, sine.spectrum_of(rows[settling:count, 1]), mass, packing.area)
    return Record(
        frequency=sine.frequency,
        velocity=velocity,
        force=force,
        period=sine.period,
        cells=packing.count,
        area=packing.area,
        mass_per_area=mass / packing.area,
        spheres=np.column_stack([last, spheres[:, 3]]),
    )


def spectra(
    motion: Multisine, momentum: Complexes, mass: float, area: float
) -> tuple[Complexes, Complexes]:
    """Return F = (iω P + M A)/A_c and V = A/(iω) on the lines (n,).

    Parameters
    ----------
    motion
        Of the cells.
    momentum
        (n,) spectrum of that of the particles as seen from the cells [kg m/s/√Hz].
    mass, area
        Of the particles [kg], and of the cells [m²].
    """
    rate = 2j * np.pi * motion.frequency
    force = (rate * momentum + mass * motion.acceleration) / area
    velocity = motion.acceleration / rate
    return np.asarray(force, np.complex128), np.asarray(velocity, np.complex128)


def _settled(motion: Multisine) -> tuple[Array, int]:
    """Samples of the settling, of the period and of its end; and the number of the first."""
    period = motion.values()
    settling = min(round(SETTLING * motion.rate), len(period))
    # the last sample ends the last line of the drive
    return np.concatenate([period[len(period) - settling :], period, period[:1]]), settling


def _write_drive(folder: Path, inertia: Array, steps: int) -> None:
    """Write the lines c + s n between samples, n the step; one more than is used."""
    slope = np.append(np.diff(inertia), 0.0) / steps
    value = inertia - slope * steps * np.arange(len(inertia))
    for name, column in ((VALUE_FILE, value), (SLOPE_FILE, slope)):
        (folder / name).write_text("".join(f"{x:.15g}\n" for x in column.tolist()))


def read_rows(path: Path, steps: int, count: int) -> Array:
    """Read the rows (count + 1, 4) of a leg: step, momentum, inertia per mass, kinetic energy.

    Raises
    ------
    LogTruncated, NotFinite
        With the file and what is wrong.
    """
    try:
        text = path.read_text()
    except FileNotFoundError:
        raise LogTruncated(f"{path}: no such file") from None
    lines = text.splitlines()
    if lines[:2] != HEADER or not text.endswith("\n"):
        raise LogTruncated(f"{path}: no header {HEADER[1]!r}, or cut in its last line")
    try:
        rows = np.array([[float(x) for x in line.split()] for line in lines[2:]])
    except ValueError as error:
        raise NotFinite(f"{path}: {error}") from None
    if rows.shape != (count + 1, 4) or (rows[:, 0] != steps * np.arange(count + 1)).any():
        raise LogTruncated(f"{path}: not {count + 1} rows of 4 columns, {steps} steps apart")
    if not np.isfinite(rows).all():
        raise NotFinite(f"{path}: {int((~np.isfinite(rows)).sum())} numbers are not finite")
    return rows


def check_rows(rows: Array, inertia: Array, mass: float, source: str) -> None:
    """Hold rows to physics: the inertia felt is the one asked for, and p² ≤ 2 M E_kin.

    Parameters
    ----------
    rows
        (n, 4) of `read_rows`.
    inertia
        (n,) per mass, asked for [m/s²].
    mass
        Of all particles [kg].
    source
        For the message.

    Raises
    ------
    NotFinite
        Where they break either.
    """
    off = np.abs(rows[:, 2] - inertia).max() / np.abs(inertia).max()
    if off > FELT:
        raise NotFinite(f"{source}: the particles felt another motion, {off:.2g} of its largest")
    energy = 2 * mass * rows[:, 3]
    square = rows[:, 1] ** 2
    if (square > energy * (1 + ROUNDED)).any():
        raise NotFinite(f"{source}: p² above 2 M E_kin")
