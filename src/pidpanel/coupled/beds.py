"""The bed of a patch in LIGGGHTS, cell by cell."""

import shutil
from collections.abc import Mapping
from ctypes import CDLL
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.coupon import geometry, preparation
from pidpanel.coupon.attempts import prepared_bed
from pidpanel.coupon.bed import Bed
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.library import Spheres

# CPU time of a call of LIGGGHTS with what the panel does meanwhile, of a step, and of a sphere in
# it [s]: 192 to 1128 spheres on a quiet core.
CALL_S, STEP_S, SPHERE_STEP_S = 70e-6, 5e-6, 75e-9


def cpu_per_interval(spheres: int, substeps: int) -> float:
    """Return the CPU time of an interval of some steps [s]."""
    return CALL_S + substeps * (STEP_S + SPHERE_STEP_S * spheres)


class StartedBed(NamedTuple):
    """A bed of a run, the modulus of its contacts [Pa], its folder, and the number of spheres."""

    bed: Bed
    modulus: float
    folder: Path
    spheres: int


def started(bed: Bed, modulus: float, folder: Path) -> StartedBed:
    """Return a bed in its folder, with a modulus [Pa]; `RunFailed` if it could not be made."""
    loosened = prepared_bed(bed, folder / "bed.json").product
    return StartedBed(bed, modulus, folder, loosened.spheres)


def spheres_of(
    library: CDLL, started: StartedBed, time_step: float, folder: Path, restart: Path | None = None
) -> Spheres:
    """Return the spheres of a bed in LIGGGHTS."""
    bed, packing = started.bed, started.bed.packing
    spheres = preparation.read_bed(started.folder)
    cell = cell_of(spheres[:, :2], packing.centres)
    order = np.argsort(cell, kind="stable")
    spheres, cell = spheres[order], cell[order]
    preparation.write_start(folder, packing, spheres, started.folder)
    start = {"data_file": folder / deck.START_FILE}
    if restart is not None:
        # a name that LIGGGHTS takes, wherever the results are
        start = {"restart_file": Path(shutil.copy(restart, folder / "start.restart"))}
    mass = geometry.masses(spheres[:, 3], packing.density)
    text = deck_of(started, time_step, {**start, "walls_file": folder / deck.WALLS_FILE})
    gravity = bed.gravity * bed.gravity_direction[2]
    return Spheres(library, text, cell, mass, gravity, time_step)


def deck_of(started: StartedBed, time_step: float, files: Mapping[str, Path]) -> str:
    """Return the deck of a bed."""
    bed, constants = started.bed, started.bed.constants
    softer = started.modulus / constants.youngs_modulus
    values = {
        **replace(
            constants,
            youngs_modulus=started.modulus,
            wall_youngs_modulus=constants.wall_youngs_modulus * softer,
        ).deck_values,
        **files,
        "binsize": 3 * bed.packing.diameter,
        "skin": 0.3 * bed.packing.diameter,
        "gravity": bed.gravity,
        "gravity_direction": " ".join(f"{part:.12g}" for part in bed.gravity_direction),
        "time_step": time_step,
    }
    return deck.render("coupled.in.j2", values)


def mass_per_area(bed: Bed, bed_folder: Path) -> float:
    """Return what the spheres of a bed weigh over the area of its cells [kg/m²]."""
    packing = bed.packing
    mass = geometry.masses(preparation.read_bed(bed_folder)[:, 3], packing.density)
    return float(mass.sum() / (packing.count * packing.cell_area))


def cell_of(position: Array, centres: Array) -> Index:
    """Return the cell of each sphere: that with the nearest centre."""
    square = ((position[:, None] - centres[None]) ** 2).sum(axis=2)
    return np.argmin(square, axis=1)
