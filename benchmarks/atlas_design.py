"""A space-filling design of cases over the groups: the table that ``atlas.yaml`` runs.

    python benchmarks/atlas_design.py 2048 > workflow/studies/atlas_cases.csv

Points are those of a Sobol sequence, in its order. So any first part of the table fills the space,
and a longer table begins with the shorter one.
"""

import argparse
import csv
import itertools
import math
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import qmc

from pidpanel.atlas.groups import USUAL, Direction, ElasticSphere
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact
from pidpanel.geometry.cells import bulk_fraction

# Ranges of the groups, with uniform distribution, of the logarithm where noted.
FILL_FRACTION = (0.05, 0.95)
GAMMA = (1.5, 700.0)  # logarithm
RESTITUTION = (0.3, 0.95)
FRICTION = (0.05, 0.8)  # logarithm
WIDTH = (2.0, 10.0)  # logarithm
DEPTH = (4.0, 40.0)  # logarithm
# W/L at the ends of parts that are equally likely in the logarithm, and the share below each: beds
# have several states of motion between 0.05 and 1.
STROKE_PER_GAP = (1e-5, 0.05, 1.0, 20.0)
STROKE_SHARES = (0.0, 0.45, 0.85, 1.0)
DIRECTIONS: dict[Direction, float] = {"flat": 0.6, "upright": 0.85, "none": 1.0}  # share up to it

# Cells with their friction, each poured once for many cases: number of cells for a block of points,
# and number of points in a block.
PACKINGS, BLOCK = 32, 512

FULL_CELL = (8.0, 1000.0)  # particles of a full cell
FULL_COUPON = 140.0  # particles of all cells together when full, with small cells
MOST_CELLS = 24  # most cells with rows of their own
LEAST_SPHERES = 2.0  # of a cell
# Depth · width/(width − 1)², in diameters: up to it the chimney of a pour is less than 224 times as
# high as its sides are wide, and LIGGGHTS takes its triangles.
SLENDEREST = 35.0
TOUCHING = 0.05  # W/L below which a bed without gravity rests in the middle of its cell
LONGEST_CONTACT = 0.1  # over the period, with the modulus of the material
DEEPEST_OVERLAP = 0.1  # over the radius, likewise
CYCLES, MOST_WORK = 12, 6e7  # steps of all particles in the fewest cycles: about six seconds
SOFT_OVERLAP = 0.05  # deepest overlap of softened contacts over the radius
LAST_CYCLES, MOST_STEPS = (32, 240), 4e6  # a noisy run ends after this number of steps
CHOICES_MPA = (20, 50, 200, 800)  # moduli of softened contacts
BOUNCING = 10.0  # Γ below which a bed that is thrown up bounces as one body
BOUNCING_CONTACT = 0.002  # longest contact of such a bed over the period
# Γ below which a case has a single seed: its contacts are hard, and its steps short.
FEW_SEEDS = 5.0
FREQUENCIES = (3.0, 10_000.0)  # [Hz]


# Size [g] and direction of gravity; the motion is along z.
GRAVITY: dict[Direction, tuple[float, str]] = {
    "flat": (1.0, "0 0 -1"),
    "upright": (1.0, "1 0 0"),
    "none": (0.0, "0 0 -1"),
}


@dataclass(frozen=True)
class Groups:
    """Groups of a bed; restitution and friction are also those of the walls."""

    fill_fraction: float  # r
    gamma: float  # Γ = ω²W/g, with standard gravity even where there is none
    stroke_per_gap: float  # W/L with the clear gap L = (1 − r) depth
    restitution: float  # e
    friction: float  # μ
    width: float  # of the cell, over the diameter of a particle
    depth: float  # likewise
    direction: Direction  # of gravity: along the motion, across it, or none


def stroke(groups: Groups, sphere: ElasticSphere) -> float:
    """Return the displacement amplitude W [m]."""
    gap = (1 - groups.fill_fraction) * groups.depth * 2 * sphere.radius
    return groups.stroke_per_gap * gap


def angular_frequency(groups: Groups, sphere: ElasticSphere) -> float:
    """Return ω = √(Γg/W) [rad/s].

    Examples
    --------
    >>> groups = Groups(0.5, 20.0, 0.01, 0.8, 0.3, 3.0, 12.5, "flat")
    >>> round(angular_frequency(groups, USUAL) / (2 * math.pi), 1)
    199.4
    """
    return math.sqrt(groups.gamma * STANDARD_GRAVITY / stroke(groups, sphere))


def frequency(groups: Groups, sphere: ElasticSphere) -> float:
    """Return the frequency of the drive [Hz]."""
    return angular_frequency(groups, sphere) / (2 * math.pi)


def speed(groups: Groups, sphere: ElasticSphere) -> float:
    """Return the velocity amplitude ωW [m/s]."""
    return angular_frequency(groups, sphere) * stroke(groups, sphere)


def points(count: int) -> Iterator[Groups]:
    """Yield the groups of the first points of the sequence."""
    cells = packings(PACKINGS * math.ceil(count / BLOCK))
    sequence = qmc.Sobol(d=6, scramble=False).fast_forward(1)  # the first is a corner
    for number, point in enumerate(sequence.random(count)):
        fill, gamma, stroke, restitution, direction, packing = point.tolist()
        width, depth, friction = cells[PACKINGS * (number // BLOCK) + int(PACKINGS * packing)]
        part = np.interp(stroke, STROKE_SHARES, np.log(np.array(STROKE_PER_GAP)))
        yield Groups(
            fill_fraction=_between(FILL_FRACTION, fill),
            gamma=_between_logs(GAMMA, gamma),
            stroke_per_gap=float(np.exp(part)),
            restitution=_between(RESTITUTION, restitution),
            friction=friction,
            width=width,
            depth=depth,
            direction=next(name for name, share in DIRECTIONS.items() if direction <= share),
        )


def packings(count: int) -> list[tuple[float, float, float]]:
    """Return width, depth and friction of cells, in the order of a sequence of their own."""
    sequence = qmc.Sobol(d=3, scramble=False).fast_forward(1)
    cells = (
        (_between_logs(WIDTH, w), _between_logs(DEPTH, d), _between_logs(FRICTION, mu))
        for w, d, mu in sequence.random(4 * count).tolist()
    )
    low, high = FULL_CELL
    return [cell for cell in cells if low <= full_cell(*cell[:2]) <= high][:count]


def _between(ends: tuple[float, float], share: float) -> float:
    return ends[0] + share * (ends[1] - ends[0])


def _between_logs(ends: tuple[float, float], share: float) -> float:
    return float(ends[0] * (ends[1] / ends[0]) ** share)


def full_cell(width: float, depth: float) -> float:
    """Return about how many particles a full cell holds; lengths are in diameters."""
    return bulk_fraction(1.0, width) * math.sqrt(3) / 2 * width**2 * depth / (math.pi / 6)


def cell_count(groups: Groups) -> int:
    """Return how many cells are shaken side by side; a cell of hundreds of particles is alone."""
    return min(math.ceil(FULL_COUPON / full_cell(groups.width, groups.depth)), MOST_CELLS)


def exclusion(groups: Groups, sphere: ElasticSphere) -> str:
    """Return why a case cannot be; empty if it can."""
    spheres = groups.fill_fraction * full_cell(groups.width, groups.depth)
    f, v = frequency(groups, sphere), speed(groups, sphere)
    if spheres < LEAST_SPHERES:
        return f"fewer than {LEAST_SPHERES:g} particles in a cell"
    if groups.depth * groups.width / (groups.width - 1) ** 2 > SLENDEREST:
        return "a cell too narrow and deep to be poured"
    if groups.direction == "none" and groups.stroke_per_gap < TOUCHING:
        return "no gravity, and a stroke with which the bed hardly touches its walls"
    if not FREQUENCIES[0] <= f <= FREQUENCIES[1]:
        return f"a frequency outside {FREQUENCIES[0]:g} to {FREQUENCIES[1]:g} Hz"
    if sphere.wall_overlap(v) > DEEPEST_OVERLAP * sphere.radius:
        return f"overlaps of more than {DEEPEST_OVERLAP:g} radii: no hard particles"
    if sphere.wall_contact_time(v) * f > LONGEST_CONTACT:
        return f"contacts of more than {LONGEST_CONTACT:g} periods: no hard particles"
    work = CYCLES * steps_per_cycle(groups, sphere) * spheres * cell_count(groups)
    if work > MOST_WORK:
        return f"more than {MOST_WORK:.0g} steps of a particle in {CYCLES} cycles"
    return ""


def bounces(groups: Groups) -> bool:
    """Return whether gravity throws a bed back as one body: soft contacts change where it lands."""
    return groups.gamma < BOUNCING and groups.direction == "flat"


def modulus(groups: Groups, sphere: ElasticSphere) -> float:
    """Return about the modulus of a run [Pa], by the rules of ``atlas.yaml``."""
    gamma, layers = groups.gamma, groups.fill_fraction * groups.depth
    crosses = groups.stroke_per_gap >= contact.CROSSING
    longest = 0.02 / (1.0 if crosses else contact.deepening(layers, gamma))
    return contact.softest_modulus(
        tuple(1e6 * choice for choice in CHOICES_MPA),
        sphere,
        speed=speed(groups, sphere),
        frequency=frequency(groups, sphere),
        contact_time_per_period=min(longest, BOUNCING_CONTACT) if bounces(groups) else longest,
        overlap_per_radius=SOFT_OVERLAP,
    )


def steps_per_cycle(groups: Groups, sphere: ElasticSphere) -> float:
    """Return about the time steps of a cycle."""
    softened = replace(sphere, youngs_modulus=modulus(groups, sphere))
    step = time_step_rayleigh(groups.restitution) * softened.rayleigh_time
    return 1 / (frequency(groups, sphere) * step)


def time_step_rayleigh(restitution: float) -> float:
    """Return the time step over the Rayleigh time.

    What the energy balance misses grows with the step and the damping of a contact,
    β = −ln e/√(π² + ln² e).
    """
    return min(0.2, round(0.027 / contact.damping_ratio(restitution), 3))


def max_cycles(groups: Groups, sphere: ElasticSphere) -> int:
    """Return after how many cycles a run ends at the latest, fewer where a cycle is long."""
    low, high = LAST_CYCLES
    return round(min(max(MOST_STEPS / steps_per_cycle(groups, sphere), low), high))


def row_of(groups: Groups, sphere: ElasticSphere) -> dict[str, Any]:
    """Return the row of a case: key of the coupon → value.

    A bed that bounces as one body is softened less than `Stiffness` allows, so the softest modulus
    that may be taken is the only choice. Where that is the material's own, only the bed is softened
    while it is shaken loose.
    """
    gravity, direction = GRAVITY[groups.direction]
    diameter, softest = 2e3 * sphere.radius, modulus(groups, sphere)
    is_stiff = bounces(groups) and softest == sphere.youngs_modulus
    values: Mapping[str, Any] = {
        "sweep.fill_fraction": groups.fill_fraction,
        "sweep.frequency_hz": frequency(groups, sphere),
        "sweep.acceleration_g": groups.gamma,
        "particles.restitution": groups.restitution,
        "particles.friction": groups.friction,
        "cell.across_flats_mm": groups.width * diameter,
        "cell.depth_mm": groups.depth * diameter,
        "cell.count": cell_count(groups),
        "gravity_g": gravity,
        "gravity_direction": direction,
        "stiffness.from_acceleration_g": BOUNCING if is_stiff else 0,
        "stiffness.choices_mpa": softest / 1e6
        if bounces(groups) and not is_stiff
        else " ".join(map(str, CHOICES_MPA)),
        "time_step_rayleigh": time_step_rayleigh(groups.restitution),
        "accuracy.seeds": 1 if groups.gamma < FEW_SEEDS else 2,
        "accuracy.max_cycles": max_cycles(groups, sphere),
    }
    return {key: f"{v:.4g}" if isinstance(v, float) else v for key, v in values.items()}


def main() -> None:
    """Write the table to the standard output, and what is left out to the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("points", type=int, help="number of points of the sequence")
    parser.add_argument("--skip", type=int, default=0, help="points left out at its beginning")
    parser.add_argument("--upright", action="store_true", help="gravity across the motion alone")
    options, sphere = parser.parse_args(), USUAL
    excluded: Counter[str] = Counter()
    rows = []
    for groups in itertools.islice(points(options.points), options.skip, None):
        if options.upright and groups.direction != "upright":
            continue
        reason = exclusion(groups, sphere)
        excluded[reason or "in the table"] += 1
        if not reason:
            rows.append(row_of(groups, sphere))
    writer = csv.DictWriter(sys.stdout, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    for reason, number in excluded.most_common():
        print(f"{number:6} {reason}", file=sys.stderr)


if __name__ == "__main__":
    main()
