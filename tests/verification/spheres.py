"""Spheres in LIGGGHTS: free ones, and shaken ones in the deck of the product, ``shake.in.j2``."""

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import cycles, geometry, preparation, rows
from pidpanel.coupon.bed import Bed, run_at
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import Packing
from pidpanel.geometry.sizes import Sizes

POISSONS_RATIO, DENSITY = 0.35, 1190.0  # of acrylic; [1], [kg/m³]


def alike(modulus, restitution, friction, rolling_friction=0.0):
    """Constants of contacts with walls of the spheres' material."""
    return Constants.alike(modulus, POISSONS_RATIO, restitution, friction, rolling_friction)


class FreeSphere(NamedTuple):
    """How a sphere sets off: x, z [m], velocities [m/s], spin about y [rad/s]."""

    x: float
    z: float
    vx: float = 0.0
    vz: float = 0.0
    spin: float = 0.0
    lane: int = 0  # spheres of one lane may meet


def moved(
    folder, bodies, constants, steps, columns, *, time_step, diameter, density,
    gravity=0.0, floor=False, stride=None,
):  # fmt: skip
    """(frames, spheres, columns) of LIGGGHTS' dump, each ``stride`` steps; else start and end.

    Gravity [m/s²] acts towards a floor at z = 0.
    """
    values = {
        **constants.deck_values, "diameter": diameter, "density": density, "time_step": time_step,
        "steps": steps, "gravity": gravity, "floor": floor,
        "lanes": max(body.lane for body in bodies), "spheres": [body._asdict() for body in bodies],
    }  # fmt: skip
    folder.mkdir(exist_ok=True)
    with Liggghts(folder, "spheres") as solver:
        solver.read_deck(deck.render("spheres.in.j2", values, Path(__file__).parent))
        solver.run_and_dump(steps, stride or steps, "frames.dump", columns)
        solver.finish()
    file = folder / "frames.dump"
    return output.read_dump(file.read_text(), str(file), columns)


# ---- shaken

HIGH = 0.1  # depth of a cell whose lid is never met [m]
# A bed of small inelastic spheres in place of the perfectly inelastic body: four layers.
BED_DIAMETER, BED_RESTITUTION, BED_COUNT = 1.25e-3, 0.3, 48
# [Hz], [m], [Pa]. The spheres have to be hard: where their overlaps reach the gaps between them, a
# bed rebounds as one spring, the more the more layers it has, and not like many impacts. Here the
# deepest overlap is 2 % of a diameter and 0.2 % of the amplitude.
SLUG_FREQUENCY, SLUG_AMPLITUDE, SLUG_MODULUS = 20.0, 8 * BED_DIAMETER, 2e8


def packing_of(diameter, depth, constants):
    return Packing(
        shape="hexagon", across_flats=4 * diameter, depth=depth, count=1, diameter=diameter,
        sizes=Sizes("mono", diameter, diameter), density=DENSITY,
        poissons_ratio=constants.poissons_ratio, friction=constants.friction,
        wall_friction=constants.wall_friction, seed=1,
    )  # fmt: skip


def run_of(packing, constants, frequency, amplitude, gravity=STANDARD_GRAVITY, step=0.2):
    """A run of a bed along z; ``step`` is the time step over the Rayleigh time."""
    bed = Bed(packing, 1.0, gravity, (0.0, 0.0, -1.0), constants)
    tone = Tone(frequency, amplitude * (2 * math.pi * frequency) ** 2)
    # with these samples an impact is placed to 0.2 % of a period
    return run_at(bed, tone, constants, time_step_rayleigh=step, samples_per_cycle=500)


def shaken(folder, run, positions, count, velocity=None):
    """Energy [m A²ω²] and apparent mass [m] of each cycle of spheres.

    They start at ``positions`` (n, 3) [m] with a velocity along z in the frame of the cell [m/s];
    at rest in space if left out.
    """
    diameters = np.full(len(positions), run.packing.diameter)
    preparation.write_start(folder, run.packing, np.column_stack([positions, diameters]))
    with Liggghts(folder, "shake") as solver:
        solver.read_deck(run.deck_text())
        if velocity is not None:
            solver.set_velocity(0.0, 0.0, velocity)
        solver.run(count * run.steps_per_cycle)
        solver.finish(count * run.steps_per_cycle, len(positions))
    mass = float(geometry.masses(diameters, run.packing.density).sum())
    damping, inertia = rows.harmonic(run, rows.read_rows(run, folder, [count], count), mass)
    drive, area = run.drive, run.packing.area
    energy = cycles.dissipated_energy(damping, drive.amplitude, drive.frequency) * area
    return np.asarray(energy) / (mass * drive.speed**2), inertia * area / mass


def bed_constants(modulus):
    """Constants of a bed whose walls only guide it and have no friction."""
    return replace(alike(modulus, BED_RESTITUTION, 0.5), wall_friction=0.0)


def poured(folder):
    """Centres of the spheres of a poured bed from the bottom up, (n, 3) [m]."""
    packing = packing_of(BED_DIAMETER, 4.8 * BED_DIAMETER, bed_constants(SLUG_MODULUS))
    preparation.pour(packing, folder)
    _, spheres = preparation.read_packing(folder)
    return spheres[np.argsort(spheres[:, 2]), :3]


def slug_run(positions, gap_over_amplitude):
    """A run of a bed between two walls without gravity.

    The clear gap L is the free path of the bed's centre of mass from where it lies at one wall,
    as poured, to where it lies at the other: the depth of the cell less twice its height.
    """
    depth = 2 * float(positions[:, 2].mean()) + gap_over_amplitude * SLUG_AMPLITUDE
    constants = bed_constants(SLUG_MODULUS)
    packing = packing_of(BED_DIAMETER, depth, constants)
    return run_of(packing, constants, SLUG_FREQUENCY, SLUG_AMPLITUDE, gravity=0.0)


def floor_run(frequency, gamma, modulus):
    """A run of a bed on a floor under gravity [Hz], [1], [Pa]."""
    constants = bed_constants(modulus)
    amplitude = gamma * STANDARD_GRAVITY / (2 * math.pi * frequency) ** 2
    return run_of(packing_of(BED_DIAMETER, HIGH, constants), constants, frequency, amplitude)
