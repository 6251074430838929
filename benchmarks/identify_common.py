"""How independent are the laboratories of `benchmarks/identify.py` of each other?

    python benchmarks/identify_common.py

An error of the atlas that shifts e of one bed shifts that of its neighbours in the groups too. For
four tones of each bed of identify_truth.csv the errors of ln C_e are projected on e, as a fit of e
alone would: s = aᵀ(y − p), of variance 1, with a ∝ S⁻¹ ∂p/∂e. The covariance of the atlas over all
tones of all beds, and the noise, give the correlation of s between beds, and the standard
deviation of its mean. Printed for each direction of gravity: the mean of s and both. Seconds.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from identify import BED, NOISE, TRUTH

from pidpanel.arrays import Array
from pidpanel.damping.atlas import REGIMES, Atlas
from pidpanel.damping.atlas_files import read_atlas, read_rows
from pidpanel.damping.sides import Mixture
from pidpanel.identify.prediction import Specimen

TONES = 4  # of a bed
STEP = 0.02  # of e, for the derivative


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
        particles = specimen.bed(
            np.full(count, first["restitution"] + shift), np.full(count, first["friction"])
        )
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


def projected(atlas: Atlas, tones: pd.DataFrame) -> tuple[Array, Array]:
    """Return s (b,) of the beds, and its covariance (b, b)."""
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
    covariance += np.diag(NOISE**2 + own**2)
    rows = np.zeros((len(tones) // TONES, len(tones)))
    for bed, row in enumerate(rows):
        part = slice(bed * TONES, (bed + 1) * TONES)
        weight = np.linalg.solve(covariance[part, part], slope[part])
        row[part] = weight / np.sqrt(weight @ slope[part])
    return rows @ away, rows @ covariance @ rows.T


def main() -> None:
    """Print the numbers of docs/identify.md."""
    atlas, table = read_atlas(), read_rows(TRUTH)
    first = table.groupby(BED, sort=False).head(TONES)
    for direction, tones in first.groupby("direction"):
        beds = [part for _, part in tones.groupby(BED, sort=False)]
        values, covariance = projected(atlas, pd.concat(beds))
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
