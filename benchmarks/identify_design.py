"""Hidden particles of the laboratories of `benchmarks/identify.py`, and the tones they measure.

    python benchmarks/identify_design.py > workflow/studies/identify_truth_cases.csv
    python benchmarks/identify_design.py --spoiled > benchmarks/identify_spoiled_cases.csv

A laboratory has one cell, one fill fraction and particles whose e and μ it does not know, and
measures `STROKES` tones. Points are those of a Sobol sequence; a laboratory stays whole only if
all of its tones can be simulated in a few seconds. The second half of the laboratories measure
`ROUNDS` times as many.

Spoiled laboratories hide particles of two sizes, cohesion, soft walls or gravity across the motion:
four of each twelve of sixty. The others are drawn, and not in the table.
"""

import csv
import sys
from typing import Any

import numpy as np
from atlas_design import Groups, cell_count, exclusion, full_cell, row_of, steps_per_cycle
from scipy.stats import qmc

from pidpanel.atlas.groups import USUAL, ElasticSphere

LABORATORIES, OF_FOUR_TONES = 100, 50  # all, and the first ones, which have no further rounds
ROUNDS = 3
# e, ln μ, r, ln of width and depth over the diameter, and whether gravity is across the motion
LOW = np.array([0.4, np.log(0.08), 0.2, np.log(2.5), np.log(5.0), -0.75])
HIGH = np.array([0.93, np.log(0.7), 0.9, np.log(6.0), np.log(20.0), 0.25])
# W/L of the tones: riding, between and crossing; and Γ, both log-uniform
STROKES = ((0.001, 0.01), (0.01, 0.05), (0.05, 0.2), (0.6, 2.0))
GAMMA = (3.0, 60.0)
LARGEST_CELL = 160.0  # particles of a full cell
MOST_WORK = 8e6  # steps of all particles in twelve cycles
SPOILED = ("two sizes", "cohesion", "soft walls", "gravity")


def laboratory(point: np.ndarray) -> list[Groups]:
    """Return a round of tones of a point (6 + 2 strokes,) of the unit cube."""
    restitution, friction, fill, width, depth, across = LOW + point[:6] * (HIGH - LOW)
    tones = []
    for (low, high), stroke, gamma in zip(STROKES, point[6::2], point[7::2], strict=True):
        tones.append(
            Groups(
                fill_fraction=float(fill),
                gamma=float(GAMMA[0] * (GAMMA[1] / GAMMA[0]) ** gamma),
                stroke_per_gap=float(low * (high / low) ** stroke),
                restitution=float(restitution),
                friction=float(np.exp(friction)),
                width=float(np.exp(width)),
                depth=float(np.exp(depth)),
                direction="upright" if across > 0 else "flat",
            )
        )
    return tones


def is_quick(groups: Groups, sphere: ElasticSphere) -> bool:
    """Whether a tone can be simulated, in a few seconds."""
    full = full_cell(groups.width, groups.depth)
    spheres = groups.fill_fraction * full * cell_count(groups)
    work = 12 * steps_per_cycle(groups, sphere) * spheres
    return full <= LARGEST_CELL and work <= MOST_WORK and not exclusion(groups, sphere)


def further_tones(
    point: np.ndarray, sphere: ElasticSphere, rng: np.random.Generator
) -> list[Groups]:
    """Return the further rounds of the laboratory of a point."""
    tones: list[Groups] = []
    while len(tones) < (ROUNDS - 1) * len(STROKES):
        drawn = np.concatenate([point[:6], rng.random(2 * len(STROKES))])
        further = laboratory(drawn)
        tones += further if all(is_quick(groups, sphere) for groups in further) else []
    return tones


def spoiled(kind: str, draw: np.ndarray) -> dict[str, float]:
    """Return what a laboratory hides, as keys of the coupon, from a point (4,) of the unit cube.

    A share by number of smaller spheres; cohesion (SJKR) at which spheres of 100 MPa stick below
    0.05 to 0.3 m/s; walls of 0.5 to 3 MPa for spheres of 50 MPa.
    """
    second, share, sticking, walls = 1 + 0.4 * draw[0], 0.3 + 0.4 * draw[1], *6 ** draw[2:]
    modulus = {"cohesion": 100.0, "soft walls": 50.0}.get(kind, 3200)
    # well of Hertz and cohesion, of energy 0.2π (1.5π)⁴ Ω⁵ R*³/E*⁴, R* half of the radius
    effective, energy = modulus * 1e6 / (2 * (1 - 0.35**2)), 0.25 * (0.05 * sticking) ** 2
    energy *= USUAL.density * np.pi / 6 * 8e-9
    cohesion = (energy * effective**4 / (0.2 * np.pi * (1.5 * np.pi) ** 4 * 0.5e-3**3)) ** 0.2
    sizes = kind == "two sizes"
    return {
        "particles.distribution.second_mm": round(second, 3) if sizes else 2.0,
        "particles.distribution.second_share": round(share, 3) if sizes else 0.5,
        "deck_values.cohesion": float(f"{cohesion:.4g}") if kind == "cohesion" else 0.0,
        "deck_values.wall_softness": round(0.5 * walls / modulus, 5) if kind[0] == "s" else 1.0,
        "particles.youngs_modulus_mpa": modulus,
    }


def write_spoiled() -> None:
    """Write the table of cases of the laboratories that hide something."""
    rows: list[dict[str, Any]] = []
    rng = np.random.default_rng(49)
    count, hidden = 0, [*SPOILED, *["honest"] * 8] * 5
    for point in qmc.Sobol(d=6 + 2 * len(STROKES), scramble=True, rng=48).random(1024):
        if count == len(hidden):
            break
        point[5] = 1.0 if hidden[count] == "gravity" else point[5]
        tones = laboratory(point)
        if not all(is_quick(groups, USUAL) for groups in tones):
            continue
        tones += further_tones(point, USUAL, rng)[:2]
        hides = spoiled(hidden[count], rng.random(4))
        usual: dict[str, Any] = {"accuracy.seeds": 1, "accuracy.max_cycles": 120}
        if hides["particles.youngs_modulus_mpa"] < USUAL.youngs_modulus / 1e6:
            usual["stiffness.choices_mpa"] = hides["particles.youngs_modulus_mpa"]
        if hidden[count] in SPOILED:
            rows += [row_of(groups, USUAL) | hides | usual for groups in tones]
        count += 1
    writer = csv.DictWriter(sys.stdout, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)


def main() -> None:
    """Write the table of cases."""
    if "--spoiled" in sys.argv:
        write_spoiled()
        return
    sphere, rows, count = USUAL, [], 0
    further: dict[str, list[Groups]] = {"flat": [], "upright": []}
    draws = {"flat": np.random.default_rng(8), "upright": np.random.default_rng(9)}
    sequence = qmc.Sobol(d=6 + 2 * len(STROKES), scramble=True, rng=7)
    for point in sequence.random(1024):
        tones = laboratory(point)
        if count < LABORATORIES and all(is_quick(groups, sphere) for groups in tones):
            rows += [row_of(groups, sphere) for groups in tones]
            count += 1
            if count > OF_FOUR_TONES:
                direction = tones[0].direction
                further[direction] += further_tones(point, sphere, draws[direction])
    rows += [row_of(groups, sphere) for tones in further.values() for groups in tones]
    writer = csv.DictWriter(sys.stdout, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    work = sum(float(row["accuracy.seeds"]) for row in rows)
    print(count, len(rows), work, file=sys.stderr)


if __name__ == "__main__":
    main()
