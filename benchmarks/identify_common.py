"""What errors of the atlas have in common: within a packing, and between laboratories.

    python benchmarks/identify_common.py

**Within a packing.** Packings of the design are predicted by an atlas without them, in ten parts,
with the constants that it has. The errors of ln C_e of the cases of each below W/L = 0.5 are
projected on e as below. Printed is the scale of Student's t of these projections where a packing
has three cases and more: `identify.prediction.JOINT_SCALE`, with its standard error (bootstrap).

**Between laboratories.** How independent are those of `benchmarks/identify.py` of each other?

An error of the atlas that shifts e of one bed shifts that of its neighbours in the groups too. For
four tones of each bed of identify_truth.csv the errors of ln C_e are projected on e, as a fit of e
alone would: s = aᵀ(y − p), of variance 1, with a ∝ S⁻¹ ∂p/∂e. The covariance of the atlas over all
tones of all beds, and the noise, give the correlation of s between beds, and the standard
deviation of its mean. Printed for each direction of gravity: the mean of s and both. Seconds.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
from atlas_fit import fit_student_scale, packings_of
from identify import BED, CELL, DESIGN, NOISE, TRUTH

from pidpanel.arrays import Array
from pidpanel.damping.atlas import REGIMES, Atlas
from pidpanel.damping.atlas_files import read_atlas, read_rows
from pidpanel.damping.sides import Mixture
from pidpanel.identify.prediction import Specimen
from pidpanel.paths import ATLAS_CASES, ATLAS_CONSTANTS

TONES = 4  # of a bed
STEP, HIGHEST = 0.02, 0.99  # of e, for the derivative; its largest value there
PARTS, FEWEST, RIDES = 10, 3, 0.5  # of the packings; cases of each; largest W/L


def mixture(atlas: Atlas, tones: pd.DataFrame, shift: float = 0.0) -> Mixture:
    """Return what the atlas knows of ln C_e of the tones of beds, with e shifted."""
    known = []
    for _, bed in tones.groupby(BED, sort=False):
        first, count = bed.iloc[0], len(bed)
        mass = float(first["particle_mass_per_area_kg_m2"])
        specimen = Specimen(
            first["across_flats_mm"] * 1e-3, first["depth_mm"] * 1e-3,
            first["diameter_mm"] * 1e-3, first["direction"], 1.0, mass / first["fill_fraction"],
        )  # fmt: skip
        restitution = np.minimum(bed["restitution"].to_numpy(float) + shift, HIGHEST)
        particles = specimen.bed(restitution, np.full(count, first["friction"]))
        points = particles.points(
            *bed[["fill_fraction", "frequency_hz", "gamma"]].to_numpy(float).T
        )
        known.append(atlas.damping_of(particles, 1.0).surface.mixtures(points)[0])
    names = ("points", "crossing", "riding", "step", "restless")
    parts = ([getattr(one, name) for one in known] for name in names)
    return Mixture(
        *(
            np.concatenate(part, axis=int(name == "restless"))
            for name, part in zip(names, parts, strict=True)
        )
    )


def projected(
    atlas: Atlas, tones: pd.DataFrame, counts: list[int], noise: float
) -> tuple[Array, Array]:
    """Return s (b,) of beds with some tones each, and its covariance (b, b)."""
    known = mixture(atlas, tones)
    slope = (mixture(atlas, tones, STEP).mean - mixture(atlas, tones, -STEP).mean) / (2 * STEP)
    gamma, flat = tones["gamma"].to_numpy(float), tones["direction"].to_numpy() == "flat"
    h = np.where(flat, 1 - gamma**-2, 1.0)
    # C_e/(m₁ r f h) = 2π η/h
    away = np.log(2 * np.pi * tones["loss_factor"].to_numpy(float) / h) - known.mean
    regime = np.digitize(tones["stroke_per_gap"], REGIMES)
    scale = atlas.calibration[0, regime] * atlas.student_scale[0, regime]
    own = (tones["loss_factor_error"] / tones["loss_factor"]).to_numpy(float)
    covariance = atlas.damping.covariance(known, known) * np.outer(scale, scale)
    covariance += np.diag(noise**2 + own**2)
    rows = np.zeros((len(counts), len(tones)))
    for row, end, count in zip(rows, np.cumsum(counts), counts, strict=True):
        part = slice(end - count, end)
        weight = np.linalg.solve(covariance[part, part], slope[part])
        row[part] = weight / np.sqrt(weight @ slope[part])
    return rows @ away, rows @ covariance @ rows.T


def left_out(cases: pd.DataFrame, folder: Path) -> Iterator[float]:
    """Yield s of each packing of the design with enough cases, from an atlas without it."""
    table = pd.read_csv(ATLAS_CASES, dtype=str, keep_default_na=False)
    packing = packings_of(cases)
    part = np.random.default_rng(0).integers(0, PARTS, packing.max() + 1)[packing]
    for number in range(PARTS):
        rest = cases[part == number]
        unknown = np.zeros(len(table), bool)
        for cell in rest[CELL].drop_duplicates().to_numpy(float):
            unknown |= np.isclose(table[CELL].astype(float), cell, rtol=1e-3).all(axis=1)
        file = folder / f"{number}.csv"
        table[~unknown].to_csv(file, index=False)
        atlas = read_atlas(file, ATLAS_CONSTANTS)
        rest = rest[(rest["stroke_per_gap"] < RIDES) & (rest["direction"] != "none")]
        for _, bed in rest.groupby([*CELL, "direction"], sort=False):
            if len(bed) >= FEWEST:
                yield float(projected(atlas, bed, [len(bed)], 0.0)[0][0])


def main() -> None:
    """Print the numbers of docs/identify.md."""
    cases = read_rows(ATLAS_CASES)
    with tempfile.TemporaryDirectory() as folder:
        values = np.array(list(left_out(cases[cases["source"] == DESIGN], Path(folder))))
    rng, weight = np.random.default_rng(0), np.ones(len(values))
    drawn = [fit_student_scale(np.abs(rng.choice(values, len(values))), weight) for _ in range(300)]
    scale = fit_student_scale(np.abs(values), weight)
    print(f"{len(values)} packings: scale {scale:.2f} ± {np.std(drawn):.2f}")

    atlas, table = read_atlas(), read_rows(TRUTH)
    first = table.groupby(BED, sort=False).head(TONES)
    for direction, tones in first.groupby("direction"):
        beds = [part for _, part in tones.groupby(BED, sort=False)]
        values, covariance = projected(atlas, pd.concat(beds), [TONES] * len(beds), NOISE)
        count = len(values)
        apart = covariance[~np.eye(count, dtype=bool)].mean()
        error = np.sqrt(covariance.sum()) / count
        print(
            f"{direction}: {count} beds, mean of s {values.mean():.2f} ± {error:.2f}, correlation "
            f"{apart:.3f}, {error * np.sqrt(count):.1f} times as far as independent beds: they "
            f"weigh like {1 / error**2:.0f}"
        )


if __name__ == "__main__":
    main()
