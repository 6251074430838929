"""Single contacts of LIGGGHTS compared with closed forms: impacts, sliding, rolling."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.atlas.groups import ElasticSphere
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.liggghts import deck, output
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.verification.rows import Row, comparison

POISSONS_RATIO = 0.35
DENSITY = 1190.0
DIAMETER = 2e-3
MODULUS = 5e7
FRICTION = 0.3
SPHERE = ElasticSphere(DIAMETER / 2, DENSITY, MODULUS, POISSONS_RATIO)
RAYLEIGH = SPHERE.rayleigh_time
STEP = 0.1 * RAYLEIGH
STEP_TEXT = f"step {STEP * 1e6:.2g} µs (0.1 Rayleigh)"

# Pairs of spheres that meet at different moments within a time step: the loss of one collision
# depends on that moment, and only the worst of several falls steadily with the step.
PAIRS = 8

ROLLING_FRICTION = 0.05

# tan θ > (7/2) μ (1 + e), 62°, from the normal; e is off by half a per cent at this step
OBLIQUE_ANGLES = (65.0, 75.0, 85.0)
# The line of centres of a pair turns by 1 % in the contact: at 85° that is 10 % of v_n.
PAIR_ANGLES = (65.0, 75.0)

IMPACT_SPEED = 0.1  # [m/s]


def alike(
    youngs_modulus: float, restitution: float, friction: float, rolling_friction: float = 0.0
) -> Constants:
    """Return the constants of contacts with walls of the spheres' material."""
    return Constants.alike(youngs_modulus, POISSONS_RATIO, restitution, friction, rolling_friction)


class FreeSphere(NamedTuple):
    """How a sphere sets off: x, z [m], velocities [m/s], spin about y [rad/s]."""

    x: float
    z: float
    vx: float = 0.0
    vz: float = 0.0
    spin: float = 0.0
    lane: int = 0  # spheres of one lane may meet


def moved(
    folder: Path,
    spheres: Sequence[FreeSphere],
    constants: Constants,
    time_step: float,
    steps: int,
    columns: tuple[str, ...],
    *,
    diameter: float = DIAMETER,
    density: float = DENSITY,
    gravity: float = 0.0,
    floor: bool = False,
    stride: int | None = None,
) -> Array:
    """Run LIGGGHTS and return what its spheres do.

    Parameters
    ----------
    columns
        Columns of LIGGGHTS' dump, such as ``vx``.
    gravity
        Towards the floor [m/s²].
    floor
        Whether there is a wall at z = 0.
    stride
        Steps between the frames; by default the start and the end.

    Returns
    -------
    (frames, spheres, columns) array
    """
    values = {
        **constants.deck_values,
        "diameter": diameter,
        "density": density,
        "time_step": time_step,
        "steps": steps,
        "gravity": gravity,
        "floor": floor,
        "lanes": max(sphere.lane for sphere in spheres),
        "spheres": [sphere._asdict() for sphere in spheres],
    }
    folder.mkdir(parents=True, exist_ok=True)
    with Liggghts(folder, "spheres") as solver:
        solver.read_deck(deck.render("verification/spheres.in.j2", values))
        solver.run_and_dump(steps, stride or steps, "frames.dump", columns)
        solver.finish()
    file = folder / "frames.dump"
    return output.read_dump(file.read_text(), str(file), columns)


def energy_lost(folder: Path, restitution: float, step: float) -> Array:
    """Return the share of the kinetic energy that head-on collisions take, (`PAIRS`,).

    ``step`` is the time step over the Rayleigh time.
    """
    speed, time_step = IMPACT_SPEED, step * RAYLEIGH
    gaps = 0.01 * DIAMETER + 2 * speed * time_step * np.arange(PAIRS) / PAIRS
    spheres = [
        FreeSphere(side * 0.5 * (DIAMETER + gap), 0.0, vx=-side * speed, lane=lane)
        for side in (-1, 1)
        for lane, gap in enumerate(gaps)
    ]
    # long enough for the slowest rebound to part them again
    steps = math.ceil((gaps[-1] / (2 * speed) + 4 * SPHERE.wall_contact_time(speed)) / time_step)
    constants = alike(MODULUS, restitution, FRICTION)
    ends = moved(folder, spheres, constants, time_step, steps, ("vx",))
    initial, final = (ends[[0, -1], :, 0] ** 2).reshape(2, 2, PAIRS).sum(axis=1)
    return np.asarray(1 - final / initial)


def rolling_speed(folder: Path, speed: float, spin: float = 0.0) -> float:
    """Return the final speed [m/s] of a sphere on a floor from a speed and a spin ω_y [rad/s]."""
    # sliding lasts 2 |v − ωR|/(7 μ g); three times that and it rolls
    slip = abs(speed - spin * DIAMETER / 2)
    steps = math.ceil(3 * 2 * slip / (7 * FRICTION * STANDARD_GRAVITY) / STEP)
    return _final_speed(folder, speed, spin, 0.0, steps)


def _final_speed(
    folder: Path, speed: float, spin: float, rolling_friction: float, steps: int
) -> float:
    """Speed [m/s] of a sphere on a floor after some steps.

    It starts at rest on the floor, sunk in by its weight: F = (4/3) E* √R δ^{3/2}.
    """
    weight = DENSITY * math.pi / 6 * DIAMETER**3 * STANDARD_GRAVITY
    sunk = (3 * weight / (4 * _effective_modulus() * math.sqrt(DIAMETER / 2))) ** (2 / 3)
    sphere = FreeSphere(0.0, DIAMETER / 2 - sunk, vx=speed, spin=spin)
    constants = alike(MODULUS, 0.5, FRICTION, rolling_friction)
    ends = moved(
        folder, [sphere], constants, STEP, steps, ("vx",), gravity=STANDARD_GRAVITY, floor=True
    )
    return float(ends[-1, 0, 0])


def _effective_modulus() -> float:
    """Return E* of two bodies of the spheres' material [Pa]."""
    return MODULUS / (2 * (1 - POISSONS_RATIO**2))


def collision_rows(folder: Path) -> Iterator[Row]:
    """Compute head-on collisions over restitution, the worst pair of each."""
    for restitution in (0.3, 0.6, 0.8, 0.95, 1.0):
        reference = 1 - restitution**2
        name = "collision" if reference else "lossless"
        lost = energy_lost(folder / f"e{restitution}", restitution, 0.1)
        worst = lost[np.argmax(np.abs(lost - reference))]
        quantity = f"share of energy lost, e = {restitution:g}"
        collision = comparison(name, pairs=PAIRS, step=STEP_TEXT)
        yield collision.row(quantity, worst, reference, at=restitution)


def sliding_rows(folder: Path) -> Iterator[Row]:
    """Compute two spheres that roll due to friction: one starts sliding, the other spinning."""
    speed = 0.2
    slid = rolling_speed(folder / "slide", speed) / speed
    spun = rolling_speed(folder / "spin", 0.0, spin=speed / (DIAMETER / 2)) / speed
    sliding = comparison("sliding", friction=FRICTION, step=STEP_TEXT)
    yield sliding.row("final speed over the first, without spin", slid, 5 / 7)
    yield sliding.row("final speed over that of the rim, from rest", spun, 2 / 7)


def rolling_rows(folder: Path) -> Iterator[Row]:
    """Compute a sphere that rolls and is slowed by its rolling friction alone."""
    speed = 0.05
    slowing = 5 / 7 * ROLLING_FRICTION * STANDARD_GRAVITY
    steps = math.ceil(0.5 * speed / slowing / STEP)
    lost = speed - _final_speed(folder, speed, speed / (DIAMETER / 2), ROLLING_FRICTION, steps)
    stopped = comparison("rolling", friction=ROLLING_FRICTION, step=STEP_TEXT)
    yield stopped.row("deceleration", lost / (steps * STEP), slowing)


def impacts(
    folder: Path, angles: Sequence[float], constants: Constants, *, pairs: bool = False
) -> tuple[Array, Array]:
    """Return v_x, v_z [m/s] and spin [rad/s] before and after oblique impacts, (angles, 3) each.

    The angles [°] are from the normal. With ``pairs`` two spheres meet with opposite velocities.
    """
    theta = np.radians(angles)
    vx, vz = IMPACT_SPEED * np.sin(theta), -IMPACT_SPEED * np.cos(theta)
    start = DIAMETER / 2 + 0.001 * DIAMETER
    # with x such that the lines of centres of pairs are vertical when they touch
    early = 0.001 * DIAMETER / -vz * vx
    spheres = [
        FreeSphere(-side * float(ahead), side * start, side * float(u), side * float(w), lane=lane)
        for side in ((1, -1) if pairs else (1,))
        for lane, (ahead, u, w) in enumerate(zip(early, vx, vz, strict=True))
    ]
    lasting = 0.001 * DIAMETER / float(-vz.max()) + 4 * SPHERE.wall_contact_time(float(-vz.max()))
    columns = ("vx", "vz", "omegay")
    steps = math.ceil(lasting / STEP)
    ends = moved(folder, spheres, constants, STEP, steps, columns, floor=not pairs)
    return ends[0, : len(angles)], ends[-1, : len(angles)]


def oblique_rows(folder: Path) -> Iterator[Row]:
    """Compute sliding impacts on a wall and of pairs, with μ times the normal force."""
    restitution = 0.8
    impulse = FRICTION * (1 + restitution)  # over m v_n
    ratio = comparison("oblique", restitution=restitution, friction=FRICTION, step=STEP_TEXT)
    rate = replace(ratio, unit="rad/s")
    constants = alike(MODULUS, restitution, FRICTION)
    for partner, angles in (("wall", OBLIQUE_ANGLES), ("second sphere", PAIR_ANGLES)):
        initial, final = impacts(
            folder / partner[:4], angles, constants, pairs=partner == "second sphere"
        )
        for angle, first, last in zip(angles, initial, final, strict=True):
            tangential = 1 - impulse / math.tan(math.radians(angle))
            spin = 5 / 2 * impulse * -first[1] / (DIAMETER / 2)
            place = f"on a {partner}, {angle:g}° from the normal"
            kept = last[0] / first[0]
            yield ratio.row(f"tangential restitution, {place}", kept, tangential, angle)
            yield rate.row(f"spin after it, {place}", last[2], spin, angle)


def peak_rows(folder: Path) -> Iterator[Row]:
    """Compute the largest force of an elastic impact on a wall."""
    speed, radius = IMPACT_SPEED, DIAMETER / 2
    deepest = SPHERE.wall_overlap(speed)
    sphere = FreeSphere(0.0, radius + 0.001 * DIAMETER, vz=-speed)
    steps = math.ceil((0.001 * DIAMETER / speed + 1.5 * SPHERE.wall_contact_time(speed)) / STEP)
    frames = moved(
        folder, [sphere], alike(MODULUS, 1.0, 0.0), STEP, steps, ("fz",), floor=True, stride=1
    )
    peak = comparison("peak", speed=speed, step=STEP_TEXT)
    reference = 4 / 3 * _effective_modulus() * math.sqrt(radius) * deepest**1.5
    yield peak.row("largest force", frames.max(), reference)


def growth_rows(folder: Path) -> Iterator[Row]:
    """Compute the largest growth of energy in impacts on a wall at all angles."""
    angles = [float(angle) for angle in range(90)]
    growth = comparison("growth", step=STEP_TEXT)
    for restitution, friction in ((1.0, FRICTION), (0.8, FRICTION), (0.8, 1.0)):
        constants = alike(MODULUS, restitution, friction)
        ends = impacts(folder / f"{restitution}_{friction}", angles, constants)
        weights = np.array([1.0, 1.0, 2 / 5 * (DIAMETER / 2) ** 2])
        first, last = (end**2 @ weights for end in ends)
        quantity = f"largest growth, e = {restitution:g}, μ = {friction:g}"
        yield growth.row(quantity, max(0.0, float((last / first).max()) - 1), 0.0)
