"""A space-filling design of cases over the groups: the table that ``atlas.yaml`` runs.

``python -m pidpanel.coupon.design 2048 > workflow/studies/atlas_cases.csv``

Points are those of a Sobol sequence, in its order. So any first part of the table fills the space,
and a longer table begins with the shorter one.
"""

import argparse
import csv
import math
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from scipy.stats import qmc

from pidpanel.atlas.groups import GRAVITY, Bead, Direction, Groups, frequency, speed
from pidpanel.coupon import contact
from pidpanel.coupon.estimate import bulk_fraction

# Ranges of the groups, equally likely in the logarithm where it says so.
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

LEAST_SPHERES = 2.0  # of a cell
MOST_SPHERES = 800.0  # of all cells
WISHED_SPHERES = 40.0  # of all cells, where they can have as many
CELLS = (2, 24)  # least and most of small cells; rows of each are listed up to the most
LONGEST_CONTACT = 0.1  # over the period, with the modulus of the material
DEEPEST_OVERLAP = 0.1  # over the radius, likewise
CYCLES, MOST_WORK = 12, 1e8  # steps of all particles in the fewest cycles: ten seconds
CHOICES = (2e7, 5e7, 2e8, 8e8)  # moduli of softened contacts [Pa]
BOUNCING = 10.0  # Γ below which a bed bounces as one body
FEW_SEEDS = (
    5.0  # Γ below which a case has a single seed: its contacts are hard, and its steps short
)
FREQUENCIES = (3.0, 10_000.0)  # [Hz]


def groups_at(point: np.ndarray) -> Groups:
    """Return the groups of a point of the unit cube, (8,)."""
    fill, gamma, stroke, restitution, friction, width, depth, direction = point.tolist()
    return Groups(
        fill_fraction=_between(FILL_FRACTION, fill),
        gamma=_between_logs(GAMMA, gamma),
        stroke_per_gap=float(
            np.exp(np.interp(stroke, STROKE_SHARES, np.log(np.array(STROKE_PER_GAP))))
        ),
        restitution=_between(RESTITUTION, restitution),
        friction=_between_logs(FRICTION, friction),
        width=_between_logs(WIDTH, width),
        depth=_between_logs(DEPTH, depth),
        direction=next(name for name, share in DIRECTIONS.items() if direction <= share),
    )


def _between(ends: tuple[float, float], share: float) -> float:
    return ends[0] + share * (ends[1] - ends[0])


def _between_logs(ends: tuple[float, float], share: float) -> float:
    return float(ends[0] * (ends[1] / ends[0]) ** share)


def spheres_per_cell(groups: Groups) -> float:
    """Return about how many particles a cell holds; lengths are in diameters."""
    area = math.sqrt(3) / 2 * groups.width**2
    bulk = bulk_fraction(1.0, groups.width)
    return groups.fill_fraction * bulk * area * groups.depth / (math.pi / 6)


def cell_count(groups: Groups) -> int:
    """Return how many cells are shaken side by side."""
    count = math.ceil(WISHED_SPHERES / spheres_per_cell(groups))
    return 1 if spheres_per_cell(groups) > MOST_SPHERES / 3 else min(max(count, CELLS[0]), CELLS[1])


def exclusion(groups: Groups, bead: Bead) -> str:
    """Return why a case cannot be; empty if it can."""
    spheres, f = spheres_per_cell(groups), frequency(groups, bead)
    if spheres < LEAST_SPHERES:
        return f"fewer than {LEAST_SPHERES:g} particles in a cell"
    if spheres > MOST_SPHERES:
        return f"more than {MOST_SPHERES:g} particles in a cell"
    if not FREQUENCIES[0] <= f <= FREQUENCIES[1]:
        return f"a frequency outside {FREQUENCIES[0]:g} to {FREQUENCIES[1]:g} Hz"
    material = (bead.diameter / 2, bead.density, bead.youngs_modulus, bead.poissons_ratio)
    v = speed(groups, bead)
    if contact.wall_overlap(*material, v) > DEEPEST_OVERLAP * bead.diameter / 2:
        return f"overlaps of more than {DEEPEST_OVERLAP:g} radii: no hard particles"
    if contact.wall_contact_time(*material, v) * f > LONGEST_CONTACT:
        return f"contacts of more than {LONGEST_CONTACT:g} periods: no hard particles"
    work = CYCLES * steps_per_cycle(groups, bead) * spheres * cell_count(groups)
    if work > MOST_WORK:
        return f"more than {MOST_WORK:.0g} steps of a particle in {CYCLES} cycles"
    return ""


def steps_per_cycle(groups: Groups, bead: Bead) -> float:
    """Return about the steps of a cycle, with the softening of ``atlas.yaml``."""
    material = {"density": bead.density, "poissons_ratio": bead.poissons_ratio}
    f = frequency(groups, bead)
    modulus = contact.softest_modulus(
        CHOICES,
        bead.youngs_modulus,
        radius=bead.diameter / 2,
        **material,
        speed=speed(groups, bead),
        frequency=f,
        contact_time_per_period=contact_time_per_period(groups.gamma),
        overlap_per_radius=0.1,
    )
    rayleigh = contact.rayleigh_time(bead.diameter / 2, youngs_modulus=modulus, **material)
    return 1 / (f * time_step_rayleigh(groups.restitution) * rayleigh)


def time_step_rayleigh(restitution: float) -> float:
    """Return the time step over the Rayleigh time.

    What the energy balance misses grows with the step and the damping of a contact,
    β = −ln e/√(π² + ln² e).
    """
    log = -math.log(restitution)
    return min(0.2, round(0.027 / (log / math.hypot(math.pi, log)), 3))


def contact_time_per_period(gamma: float) -> float:
    """Return the longest contact of a run over the period: a bed that bounces needs harder ones."""
    return 0.002 if gamma < BOUNCING else 0.02


def row_of(groups: Groups, bead: Bead) -> dict[str, Any]:
    """Return the row of a case: key of the coupon → value."""
    gravity, direction = GRAVITY[groups.direction]
    diameter = bead.diameter * 1e3
    values: Mapping[str, Any] = {
        "sweep.fill_fraction": groups.fill_fraction,
        "sweep.frequency_hz": frequency(groups, bead),
        "sweep.acceleration_g": groups.gamma,
        "particles.restitution": groups.restitution,
        "particles.friction": groups.friction,
        "cell.across_flats_mm": groups.width * diameter,
        "cell.depth_mm": groups.depth * diameter,
        "cell.count": cell_count(groups),
        "gravity_g": gravity,
        "gravity_direction": direction,
        "stiffness.contact_time_per_period": contact_time_per_period(groups.gamma),
        "accuracy.seeds": 1 if groups.gamma < FEW_SEEDS else 2,
        "time_step_rayleigh": time_step_rayleigh(groups.restitution),
    }
    return {key: f"{v:.4g}" if isinstance(v, float) else v for key, v in values.items()}


def points(count: int) -> Iterator[Groups]:
    """Yield the groups of the first points of the sequence."""
    sequence = qmc.Sobol(d=8, scramble=False).fast_forward(1)  # the first is a corner
    for point in sequence.random(count):
        yield groups_at(point)


def main() -> None:
    """Write the table to the standard output, and what is left out to the other."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("points", type=int, help="number of points of the sequence")
    count, bead = parser.parse_args().points, Bead()
    excluded: Counter[str] = Counter()
    rows = []
    for groups in points(count):
        reason = exclusion(groups, bead)
        excluded[reason or "in the table"] += 1
        if not reason:
            rows.append(row_of(groups, bead))
    writer = csv.DictWriter(sys.stdout, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    for reason, number in excluded.most_common():
        print(f"{number:6} {reason}", file=sys.stderr)


if __name__ == "__main__":
    main()
