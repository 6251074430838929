"""Shaken spheres with a closed form: a ball, a slug in a box, a bed on a floor.

They run the deck of the product, ``templates/shake.in.j2``, and read its rows with `cycles`, so
that the whole way from the drive to the dissipated energy is compared with the closed form.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import cycles, geometry, preparation, rows
from pidpanel.coupon.bed import Bed, Run, run_at
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import Packing
from pidpanel.damping import inelastic
from pidpanel.geometry.sizes import Sizes
from pidpanel.verification.coupon.contacts import DENSITY, alike
from pidpanel.verification.rows import Row, comparison

HIGH = 0.1  # depth of a cell whose lid is never met [m]


def shaken(
    folder: Path, run: Run, positions: Array, count: int, velocity: float | None = None
) -> tuple[Array, Array]:
    """Return energy [m A²ω²] and apparent mass [m] of each cycle of spheres in the usual deck.

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


def _run(
    packing: Packing,
    constants: Constants,
    frequency: float,
    amplitude: float,
    gravity: float = STANDARD_GRAVITY,
    time_step_rayleigh: float = 0.2,
) -> Run:
    bed = Bed(packing, 1.0, gravity, (0.0, 0.0, -1.0), constants)
    tone = Tone(frequency, amplitude * (2 * math.pi * frequency) ** 2)
    # with these samples an impact is placed to 0.2 % of a period
    return run_at(
        bed, tone, constants, time_step_rayleigh=time_step_rayleigh, samples_per_cycle=500
    )


def _packing(diameter: float, depth: float, constants: Constants) -> Packing:
    return Packing(
        shape="hexagon",
        across_flats=4 * diameter,
        depth=depth,
        count=1,
        diameter=diameter,
        sizes=Sizes("mono", diameter, diameter),
        density=DENSITY,
        poissons_ratio=constants.poissons_ratio,
        friction=constants.friction,
        wall_friction=constants.wall_friction,
        seed=1,
    )


def ball(folder: Path, restitution: float = 0.5, gamma: float = 1.25) -> tuple[Run, float]:
    """Return a ball in its period-one orbit on a shaken floor: the run, and E/(m A²ω²) per cycle.

    The orbit is one of several attractors, so the ball begins on it: at phase 0 it is falling,
    and it will land at φ₀, cos φ₀ = π (1 − e)/(Γ (1 + e)), at the speed gT/2.
    """
    diameter, frequency = 2e-3, 50.0
    omega = 2 * math.pi * frequency
    amplitude = gamma * STANDARD_GRAVITY / omega**2
    constants = alike(2e8, restitution, 0.0)
    packing = _packing(diameter, HIGH, constants)
    run = _run(packing, constants, frequency, amplitude, time_step_rayleigh=0.1)
    phase = math.acos(math.pi * (1 - restitution) / (gamma * (1 + restitution)))
    left = phase / omega  # until it lands
    falling = STANDARD_GRAVITY * (0.5 / frequency - left)
    height = amplitude * math.sin(phase) + falling * left + 0.5 * STANDARD_GRAVITY * left**2
    start = np.array([[0.0, 0.0, diameter / 2 + height]])
    energy, _ = shaken(folder, run, start, 20, velocity=-falling - omega * amplitude)
    return run, float(energy[10:].mean())


def ball_rows(folder: Path) -> Iterator[Row]:
    """Compute the ball that lands once a period."""
    restitution, gamma = 0.5, 1.25
    run, energy = ball(folder, restitution, gamma)
    reference = inelastic.ball_energy(gamma, restitution)
    quantity = f"E/(m A²ω²), e = {restitution:g}, Γ = {gamma:g}"
    yield comparison("ball", drive=_drive_text(run)).row(quantity, energy, reference)


# ---- a bed of small inelastic spheres in place of the perfectly inelastic body

BED_DIAMETER = 1.25e-3
BED_RESTITUTION = 0.3
BED_FRICTION = 0.5
# Spheres in place of the body: a single one, one layer, four layers of the cell.
BED_SIZES = (1, 12, 48)

# [Hz], [m], [Pa]. The spheres have to be hard: where their overlaps reach the gaps between them, a
# bed rebounds as one spring, the more the more layers it has, and not like many impacts. Here the
# deepest overlap is 2 % of a diameter and 0.2 % of the amplitude.
SLUG_FREQUENCY, SLUG_AMPLITUDE, SLUG_MODULUS = 20.0, 8 * BED_DIAMETER, 2e8

# [Hz], [Pa]: overlaps over diameter as above, as ρ (ωA)²/E is the same at Γ = 2.5.
FLOOR_FREQUENCY, FLOOR_MODULUS = 8.0, 3.2e7

SLUG_GAPS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.4)
# L/A up to which a bed can be compared with the closed form. Beyond, the body leaves each wall the
# moment it lands, and what little a real bed has spread never comes together again.
SLUG_HELD = math.pi

FLOOR_GAMMAS = (0.9, 1.25, 1.5, 2.0, 2.5, 2.75, 3.0)
# Γ up to which a bed can be compared with the closed form. Beyond, the body lies on the floor for
# less than a tenth of a period, and a bed that rebounds a little is not yet at rest when it is
# thrown again: it is late, and misses the orbit every few cycles.
FLOOR_HELD = 2.8


def _bed_constants(youngs_modulus: float) -> Constants:
    """Return the constants of a bed whose walls only guide it and have no friction."""
    return replace(alike(youngs_modulus, BED_RESTITUTION, BED_FRICTION), wall_friction=0.0)


def poured(folder: Path) -> Array:
    """Return the centres of the spheres of a poured bed from the bottom up, (n, 3) [m]."""
    packing = _packing(BED_DIAMETER, 4.8 * BED_DIAMETER, _bed_constants(SLUG_MODULUS))
    preparation.pour(packing, folder)
    _, spheres = preparation.read_packing(folder)
    return spheres[np.argsort(spheres[:, 2]), :3]


def _lowest(settled: Array, spheres: int) -> Array:
    """Return the lowest spheres of a bed; a lone one on the axis of the cell."""
    if spheres == 1:
        return np.array([[0.0, 0.0, BED_DIAMETER / 2]])
    return settled[:spheres]


def slug(
    folder: Path, settled: Array, spheres: int, gap_over_amplitude: float, *, count: int = 8
) -> tuple[Run, float]:
    """Return a bed between two shaken walls without gravity: the run, and E/(m A²ω²) per cycle.

    The clear gap L is the free path of the bed's centre of mass from where it lies at one wall,
    as poured, to where it lies at the other: the depth of the cell less twice its height.
    """
    positions = _lowest(settled, spheres)
    gap = gap_over_amplitude * SLUG_AMPLITUDE
    depth = 2 * float(positions[:, 2].mean()) + gap
    constants = _bed_constants(SLUG_MODULUS)
    packing = _packing(BED_DIAMETER, depth, constants)
    run = _run(packing, constants, SLUG_FREQUENCY, SLUG_AMPLITUDE, gravity=0.0)
    energy, _ = shaken(folder, run, positions, count)
    return run, float(energy[2:].mean())


def floor_bed(
    folder: Path, settled: Array, spheres: int, gamma: float, *, count: int = 14
) -> tuple[Run, float]:
    """Return a bed on a shaken floor under gravity: the run, and E/(m A²ω²) per cycle."""
    run = open_bed(FLOOR_FREQUENCY, gamma, FLOOR_MODULUS)
    energy, _ = shaken(folder, run, _lowest(settled, spheres), count)
    return run, float(energy[4:].mean())


def open_bed(frequency: float, gamma: float, youngs_modulus: float) -> Run:
    """Return a bed on a shaken floor that never meets its lid [Hz], [1], [Pa]."""
    constants = _bed_constants(youngs_modulus)
    packing = _packing(BED_DIAMETER, HIGH, constants)
    amplitude = gamma * STANDARD_GRAVITY / (2 * math.pi * frequency) ** 2
    return _run(packing, constants, frequency, amplitude)


def _drive_text(run: Run) -> str:
    return (
        f"{run.steps_per_cycle} steps of {run.time_step * 1e6:.2g} µs a cycle, "
        f"{run.constants.youngs_modulus / 1e6:g} MPa"
    )


def _bed_rows(
    folder: Path,
    variable: str,
    energy_of: Callable[[Path, Array, int, float], tuple[Run, float]],
    points: Mapping[float, tuple[str, bool]],
    closed_form: Callable[[float], float],
) -> Iterator[Row]:
    """Compare beds with a closed form.

    ``points`` have the name of their comparison, and whether the largest bed has to meet it.
    """
    settled = poured(folder / "pour")
    for spheres in BED_SIZES:
        for point, (name, is_met) in points.items():
            run, energy = energy_of(folder / f"n{spheres}_{point:g}", settled, spheres, point)
            count = f"{spheres} sphere{'s' * (spheres > 1)}"
            bed = comparison(name, spheres=count, drive=_drive_text(run))
            if not (is_met and spheres == BED_SIZES[-1]):
                bed = replace(bed, tolerance=math.nan)
            quantity = f"E/(m A²ω²), {variable} = {point:g}"
            yield bed.row(quantity, energy, closed_form(point), point, spheres)


def slug_rows(folder: Path) -> Iterator[Row]:
    """Compute the inelastic slug, over the gap and the number of spheres."""
    points = {gap: ("slug", gap <= SLUG_HELD) for gap in SLUG_GAPS}
    return _bed_rows(folder, "L/A", slug, points, inelastic.slug_energy)


def floor_rows(folder: Path) -> Iterator[Row]:
    """Compute the inelastic bed on a floor, over Γ and the number of spheres."""
    points = {
        gamma: ("floor" if gamma > 1 else "onset", gamma <= FLOOR_HELD) for gamma in FLOOR_GAMMAS
    }
    return _bed_rows(folder, "Γ", floor_bed, points, inelastic.floor_energy)
