"""Laboratories with hidden particles: does `pidpanel identify` find them?

    python benchmarks/identify.py [--panel]

A laboratory measures one bed that LIGGGHTS shook. Its C_e and m_a get 3 % of noise (m_a of the mass
of the particles), its fill fraction an error of 0.01, and its particles are weighed. The atlas is
made again without all cases in cells and of the friction of the laboratory, with the constants and
calibration that it has. There are five kinds:

- several tones: six tones of one bed among the tones of the atlas (three kinds of particles);
- one tone: a case of the design, each with particles of its own;
- other particles: four tones of each bed of identify_truth.csv, the rows of
  `workflow/studies/identify_truth.yaml`, which are not in the atlas;
- twelve tones: all tones of the beds of that table that have so many;
- spoiled: the twenty laboratories of `identify_spoiled.csv`, the cases of `identify_spoiled.yaml`,
  which hide something: particles of two sizes, cohesion, soft walls, or gravity across the motion
  where it is declared along it. Their errors are those of the runs too; tones with errors above
  half of C_e are not used. Each weighs a hundred of its particles, to 1 %.

Printed are how often 90 % intervals hold the truth, errors, and CPU times, for each direction of
gravity and of the laboratories that pass: p above 10 %, gravity as stated explains more than a
tenth of gravity in the other direction, and what the particles weigh does not contradict their
diameter. Of the spoiled ones also χ² over the measured values: the least of all particles, that of
the true ones, and that of the true ones with the mean diameter. Names of kinds as arguments choose
some.
``--panel`` compares g rms of the launch panel with the true and with the identified
particles, both by the damping model `atlas`. Minutes.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

import pidpanel
from pidpanel.damping.atlas import Atlas
from pidpanel.damping.atlas_files import read_atlas, read_rows
from pidpanel.identify.from_study import SIZE_MARGIN
from pidpanel.identify.posterior import (
    DOUBTFUL_PROBABILITY,
    FillPrior,
    MeasuredDamping,
    Posterior,
    grid_posterior,
    identify,
)
from pidpanel.identify.prediction import Specimen, Tones, predict
from pidpanel.paths import ATLAS_CASES, ATLAS_CONSTANTS, STUDIES
from pidpanel.study.requirements import FILLS, FRICTION, RESTITUTION

NOISE, FILL_ERROR = 0.03, 0.01
TONES = 6  # of a laboratory of several
CELL = ["friction", "width_per_diameter", "depth_per_diameter"]
BED = [*CELL, "restitution", "fill_fraction", "direction", "diameter_mm", "density_kg_m3"]
RANGES = RESTITUTION, (float(np.log(FRICTION[0])), float(np.log(FRICTION[1])))
TRUTH, SPOILED = (Path(__file__).with_name(f"identify_{name}.csv") for name in ("truth", "spoiled"))
WEIGHED, SCALES = 100, 0.01  # particles that a spoiled laboratory weighs, and its error
TURNED = 5  # upright beds of four tones that are declared flat
DESIGN = "Atlas of particle beds"

Laboratory = tuple[pd.DataFrame, Atlas]  # its rows, and the atlas without them


def atlas_without(cell: pd.Series, folder: Path) -> Atlas:
    """Return the atlas without the cases in the cells and of the friction of a laboratory."""
    table = pd.read_csv(ATLAS_CASES, dtype=str, keep_default_na=False)
    close = np.isclose(table[CELL].astype(float), cell[CELL].to_numpy(float), rtol=1e-3)
    file = folder / f"{abs(hash(tuple(cell[CELL])))}.csv"
    table[~close.all(axis=1)].to_csv(file, index=False)
    return read_atlas(file, ATLAS_CONSTANTS)


def laboratories(kind: str, folder: Path, rng: np.random.Generator) -> Iterator[Laboratory]:
    """Yield the laboratories of one kind."""
    if kind in ("other particles", "twelve tones"):
        for _, rows in read_rows(TRUTH).groupby(BED, sort=False):
            if kind == "other particles":
                yield rows.head(4), read_atlas()
            elif len(rows) > 4:
                yield rows, read_atlas()
        return
    if kind == "spoiled":
        yield from ((rows, read_atlas()) for rows in spoiled())
        return
    cases = read_rows(ATLAS_CASES)
    design = cases["source"] == DESIGN
    for _, group in cases[design if kind == "one tone" else ~design].groupby(CELL, sort=False):
        atlas = atlas_without(group.iloc[0], folder)
        for _, rows in group.groupby(BED, sort=False):
            if kind == "one tone":
                yield from ((rows.iloc[[row]], atlas) for row in range(len(rows)))
                continue
            order = rng.permutation(len(rows))
            for start in range(0, len(rows) - TONES + 1, TONES):
                yield rows.iloc[order[start : start + TONES]], atlas


def spoiled() -> Iterator[pd.DataFrame]:
    """Yield the rows of the laboratories that hide something, as declared, with it as ``kind``."""
    beds = [rows for _, rows in read_rows(TRUTH).groupby(BED, sort=False) if len(rows) == 4]
    upright = [rows for rows in beds if rows["direction"].iloc[0] == "upright"]
    hides = {"kind": "gravity", "direction": "flat", "second_mm": 2.0, "second_share": 0.5}
    yield from (rows.assign(**hides) for rows in upright[:TURNED])
    table = pd.read_csv(SPOILED)
    own = table["equivalent_damping_error_n_s_m3"] / table["equivalent_damping_n_s_m3"]
    own_mass = table["apparent_mass_error_kg_m2"] / table["particle_mass_per_area_kg_m2"]
    table = table.assign(own_error=own, own_mass_error=own_mass)[(own > 0) & (own < 0.5)]
    yield from (rows for _, rows in table.groupby("laboratory"))


def weighed(first: pd.Series, rng: np.random.Generator) -> float:
    """Return the mean mass of some particles over that of the declared ones."""
    second = rng.binomial(WEIGHED, first["second_share"]) / WEIGHED
    lighter = 1 - (first["second_mm"] / first["diameter_mm"]) ** 3
    return float((1 - second * lighter) * (1 + SCALES * rng.standard_normal()))


def mean_diameter(first: pd.Series) -> float:
    """Return the mean diameter of particles of two sizes [m]."""
    share = first["second_share"]
    return float(1e-3 * ((1 - share) * first["diameter_mm"] + share * first["second_mm"]))


def specimen_of(first: pd.Series) -> tuple[Specimen, np.ndarray]:
    """Return the damper that a laboratory declares, and the truth: e, ln μ and r."""
    truth = np.array([first["restitution"], np.log(first["friction"]), first["fill_fraction"]])
    mass = float(first["particle_mass_per_area_kg_m2"])
    lengths = (first[f"{name}_mm"] * 1e-3 for name in ("across_flats", "depth", "diameter"))
    return Specimen(*lengths, first["direction"], 1.0, mass / truth[2], mass), truth


Identified = tuple[Posterior, np.ndarray, dict[str, float]]


def identified(laboratory: Laboratory, rng: np.random.Generator) -> Identified:
    """Return what a laboratory identifies, the truth e, ln μ and r, and χ² over the values."""
    rows, atlas = laboratory
    first = rows.iloc[0]
    specimen, truth = specimen_of(first)
    mass = float(first["particle_mass_per_area_kg_m2"])
    noise = 1 + NOISE * rng.standard_normal((2, len(rows)))
    damping = rows["equivalent_damping_n_s_m3"].to_numpy() * noise[0]
    apparent = rows["apparent_mass_kg_m2"].to_numpy() + mass * (noise[1] - 1)
    f, gamma = rows["frequency_hz"].to_numpy(), rows["gamma"].to_numpy()
    tones = Tones(f, gamma, np.zeros(len(rows), bool))
    own, own_mass = (rows.get(f"own_{name}error", 0.0 * f) for name in ("", "mass_"))
    measured = MeasuredDamping(
        tones, damping, np.hypot(NOISE, own) * damping, apparent, np.hypot(NOISE, own_mass) * mass
    )
    stated = float(np.clip(truth[2] + FILL_ERROR * rng.standard_normal(), *FILLS))
    fill, known = FillPrior(*FILLS, stated, FILL_ERROR), tuple(truth[:, None])
    posterior, chi_squares = identify(atlas, specimen, measured, fill, RANGES), {}
    if "second_mm" in first:
        for name, diameter in (("true", specimen.diameter), ("mean", mean_diameter(first))):
            bed = replace(specimen, diameter=diameter)
            at = grid_posterior(atlas, bed, measured, fill, known)
            chi_squares[f"{name}_size"] = at.chi_square.item() / at.count
        chi_squares["least"] = posterior.chi_square.min() / posterior.count
    return posterior, truth, chi_squares


def row_of(
    posterior: Posterior, truth: np.ndarray, chi_squares: dict[str, float]
) -> dict[str, Any]:
    """Return truth, estimate and interval of each parameter, and how well they fit."""
    row: dict[str, Any] = {
        "explained": posterior.is_explained, "p": posterior.probability,
        "gravity_odds": posterior.gravity_odds, **chi_squares,
        "passes": posterior.probability > DOUBTFUL_PROBABILITY and not posterior.is_other_gravity,
    }  # fmt: skip
    for axis, name in enumerate(("e", "log_friction", "fill")):
        known = posterior.estimate(axis)
        row |= {
            f"{name}_true": truth[axis],
            name: posterior.mean[axis],
            f"{name}_within": known.low <= truth[axis] <= known.high,
            f"{name}_width": known.high - known.low,
        }
    return row


def size_distances(rows: pd.DataFrame) -> Iterator[str]:
    """Yield how far a mean diameter is from any e, μ and r of the declared one.

    The atlas predicts the true particles with the mean diameter of two sizes. With g the change, J
    the derivatives by e, ln μ and r, P their prior and Σ all errors, the distance is √(gᵀS⁻¹g) with
    S = Σ + J P Jᵀ. Errors of the atlas and of the measurement are reduced in turn.
    """
    first, count, atlas = rows.iloc[0], len(rows), read_atlas()
    specimen, truth = specimen_of(first)
    tones = Tones(*rows[["frequency_hz", "gamma"]].to_numpy().T, np.zeros(count, bool))
    steps = np.diag([0.02, 0.1, 0.01])
    known = predict(atlas, specimen, np.vstack([truth, truth + steps]), tones)
    slopes = ((known.mean[1:] - known.mean[0]) / np.diag(steps)[:, None]).T
    mean = replace(specimen, diameter=mean_diameter(first))
    change = predict(atlas, mean, truth[None], tones).mean[0] - known.mean[0]
    prior = np.diag([*(np.ptp(ends) ** 2 / 12 for ends in RANGES), FILL_ERROR**2])
    unit = np.repeat([1.0, specimen.particle_mass], count)
    for share, noise in ((1.0, NOISE), (1.0, NOISE / 10), (0.1, NOISE / 3)):
        errors = share**2 * known.student_covariance[0] + np.diag((noise * unit) ** 2)
        distance = np.sqrt(change @ np.linalg.solve(errors + slopes @ prior @ slopes.T, change))
        yield f"{distance:.1f} (errors of the atlas × {share:g}, of the test {noise:.1%})"


def panel_ratios(results: pd.DataFrame) -> np.ndarray:
    """Return g rms of the launch panel with the identified particles over that with the true."""
    launch = yaml.safe_load((STUDIES / "launch.yaml").read_text(encoding="utf-8"))
    dampers, scenarios = {}, {}
    for index, row in enumerate(results.to_dict("records")):
        for kind, suffix in (("true", "_true"), ("identified", "")):
            coupon = {
                "cell": {"across_flats_mm": row["width"], "depth_mm": row["depth"]},
                "particles": {
                    "diameter_mm": row["diameter"],
                    "density_kg_m3": row["density"],
                    "restitution": row[f"e{suffix}"],
                    "friction": float(np.exp(row[f"log_friction{suffix}"])),
                },
                "gravity_direction": [0, 0, -1] if row["direction"] == "flat" else [1, 0, 0],
            }
            fill = float(np.clip(row[f"fill{suffix}"], *FILLS))
            dampers[f"{kind}{index}"] = {**coupon, "model": "atlas"}
            scenarios[f"{kind}{index}"] = {
                "layout": {"PID-1": {"damper": f"{kind}{index}", "fill_fraction": fill}}
            }
    study = {
        "panel": launch["panel"], "sound": launch["sound"] | {"levels": {}}, "dampers": dampers,
        "scenarios": scenarios,
        "response": {"frequency_hz": [30, 500], "maps": []},
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        summary = pidpanel.Model(study, folder).summary()
    point = summary[summary["point"].astype(str) == "326"]
    values = {
        str(label).split("_")[0]: value
        for label, value in zip(point["scenario"], point["acceleration_rms_g"], strict=True)
    }
    count = len(results)
    return np.array([values[f"identified{k}"] / values[f"true{k}"] for k in range(count)])


def describe(kind: str, results: pd.DataFrame) -> None:
    """Print how well laboratories of a kind find their particles."""
    if results.empty:
        print(f"{kind}: none")
        return
    print(
        f"{kind}: {len(results)} laboratories of {results['particles'].nunique()} kinds of "
        f"particles, {results['seconds'].median():.1f} CPU-s each; "
        f"{results['explained'].mean():.0%} explained"
    )
    for name in ("e", "log_friction", "fill"):
        away = (results[name] - results[f"{name}_true"]).abs()
        print(
            f"  {name}: within 90 % {results[f'{name}_within'].mean():.0%}, median error "
            f"{away.median():.3f}, median interval {results[f'{name}_width'].median():.3f}"
        )
    if "--panel" in sys.argv:
        away = np.abs(panel_ratios(results) - 1)
        print(
            f"  g rms: median {np.median(away):.1%}, rms {np.sqrt(np.mean(away**2)):.1%}, ", end=""
        )
        print(f"within 5 % {np.mean(away <= 0.05):.0%}")


def describe_spoiled(results: pd.DataFrame) -> None:
    """Print which laboratories that hide something pass, and how far two sizes are from one."""
    for hidden, part in results.groupby("hides"):
        columns = ["p", "gravity_odds", "mass", "least", "true_size", "mean_size"]
        print(part[columns].round(3).to_string())
        is_full_weight = abs(part["mass"] - 1) <= SIZE_MARGIN
        describe(str(hidden), part)
        describe(f"{hidden}, passing", part[part["passes"]])
        describe(f"{hidden}, passing by weight too", part[part["passes"] & is_full_weight])
    for rows in spoiled():
        if rows["kind"].iloc[0] == "two sizes":
            print("a mean diameter is apart by", "; ".join(size_distances(rows)))


def main() -> None:
    """Print the numbers of docs/identify.md."""
    print(f"atlas of {len(read_rows(ATLAS_CASES))} cases")
    kinds = ("several tones", "one tone", "other particles", "twelve tones", "spoiled")
    for kind in [kind for kind in kinds if kind in sys.argv] or kinds:
        rng, rows = np.random.default_rng(5), []
        with tempfile.TemporaryDirectory() as folder:
            for laboratory in laboratories(kind, Path(folder), rng):
                start = time.process_time()
                row = row_of(*identified(laboratory, rng))
                first = laboratory[0].iloc[0]
                rows.append(
                    {
                        **row, "seconds": time.process_time() - start,
                        "particles": tuple(first[["across_flats_mm", "friction", "restitution"]]),
                        "hides": first.get("kind", ""),
                        "mass": weighed(first, rng) if kind == "spoiled" else 1.0,
                        "width": first["across_flats_mm"], "depth": first["depth_mm"],
                        "diameter": first["diameter_mm"], "density": first["density_kg_m3"],
                        "direction": first["direction"],
                    }
                )  # fmt: skip
        results = pd.DataFrame(rows)
        describe(kind, results)
        for direction, part in results.groupby("direction"):
            describe(f"{kind}, {direction}", part)
        describe(f"{kind}, passing", results[results["passes"]])
        if kind == "spoiled":
            describe_spoiled(results)


if __name__ == "__main__":
    main()
