"""Laboratories with hidden particles: does `pidpanel identify` find them?

    python benchmarks/identify.py [--panel]

Each laboratory of benchmarks/identify_truth.csv is one bed that LIGGGHTS shook with four tones
(`identify_design.py`, `identify_truth.yaml`); none of these cases is in the atlas. Its C_e and m_a
get 3 % of noise (m_a of the mass of the particles), its fill fraction an error of 0.01, and the
particles are weighed. Printed are how often 90 % intervals hold the truth, the errors, and CPU
times. ``--panel`` also compares g rms of the launch panel with the true and with the identified
particles, both by the damping model `atlas`: minutes.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml

import pidpanel
from pidpanel.atlas.table import read_atlas as read_table
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.identify.posterior import FillPrior, MeasuredDamping, Posterior, identify
from pidpanel.identify.prediction import Specimen, Tones
from pidpanel.paths import STUDIES
from pidpanel.study.atlas import FILLS, FRICTION, RESTITUTION

NOISE, FILL_ERROR = 0.03, 0.01
KEYS = ["restitution", "friction", "fill_fraction", "width_per_diameter", "depth_per_diameter",
        "direction"]  # fmt: skip
RANGES = RESTITUTION, (float(np.log(FRICTION[0])), float(np.log(FRICTION[1])))
TRUTH = Path(__file__).with_name("identify_truth.csv")


def laboratory(rows: pd.DataFrame, rng: np.random.Generator) -> tuple[Posterior, np.ndarray]:
    """Return what a laboratory identifies, and the truth: e, ln μ and r."""
    first = rows.iloc[0]
    truth = np.array([first["restitution"], np.log(first["friction"]), first["fill_fraction"]])
    diameter, mass = first["diameter_mm"] * 1e-3, float(first["particle_mass_per_area_kg_m2"])
    specimen = Specimen(
        first["across_flats_mm"] * 1e-3, first["depth_mm"] * 1e-3, diameter, first["direction"],
        1.0, mass / truth[2], mass,
    )  # fmt: skip
    noise = 1 + NOISE * rng.standard_normal((2, len(rows)))
    damping = rows["equivalent_damping_n_s_m3"].to_numpy() * noise[0]
    apparent = rows["apparent_mass_kg_m2"].to_numpy() + mass * (noise[1] - 1)
    tones = Tones(
        rows["frequency_hz"].to_numpy(), rows["gamma"].to_numpy(), np.zeros(len(rows), bool)
    )
    measured = MeasuredDamping(
        tones, damping, NOISE * damping, apparent, np.full(len(rows), NOISE * mass)
    )
    stated = float(np.clip(truth[2] + FILL_ERROR * rng.standard_normal(), *FILLS))
    fill = FillPrior(*FILLS, stated, FILL_ERROR)
    return identify(read_atlas(), specimen, measured, fill, RANGES), truth


def row_of(posterior: Posterior, truth: np.ndarray) -> dict[str, Any]:
    """Return truth, estimate and interval of each parameter."""
    row: dict[str, Any] = {"explained": posterior.is_explained}
    for axis, name in enumerate(("e", "log_friction", "fill")):
        known = posterior.estimate(axis)
        row |= {
            f"{name}_true": truth[axis],
            name: known.mean,
            f"{name}_error": known.error,
            f"{name}_within": known.low <= truth[axis] <= known.high,
            f"{name}_width": known.high - known.low,
        }
    return row


def panel_differences(laboratories: pd.DataFrame, cells: pd.DataFrame) -> np.ndarray:
    """Return g rms of the launch panel with the identified particles over that with the true."""
    launch = yaml.safe_load((STUDIES / "launch.yaml").read_text(encoding="utf-8"))
    dampers, scenarios = {}, {}
    for (index, row), cell in zip(laboratories.iterrows(), cells.to_dict("records"), strict=True):
        for kind, suffix in (("true", "_true"), ("identified", "")):
            name = f"{kind}{index}"
            gravity = [0, 0, -1] if cell["direction"] == "flat" else [1, 0, 0]
            size = {"across_flats_mm": cell["across_flats_mm"], "depth_mm": cell["depth_mm"]}
            particles = {
                "restitution": row[f"e{suffix}"],
                "friction": float(np.exp(row[f"log_friction{suffix}"])),
            }
            dampers[name] = {
                "coupon": {"cell": size, "particles": particles, "gravity_direction": gravity}
            }
            fill = {"damper": name, "fill_fraction": float(np.clip(row[f"fill{suffix}"], *FILLS))}
            scenarios[name] = {"layout": {"PID-1": fill}}
    study = {
        **{key: launch[key] for key in ("panel", "sound")},
        "dampers": dampers,
        "damping": {"readings": ["atlas"]},
        "response": {"frequency_hz": [30, 500], "maps": []},
        "scenarios": scenarios,
    }
    with tempfile.TemporaryDirectory() as folder:
        summary = pidpanel.Model(study, folder).summary()
    point = summary[summary["point"].astype(str) == "326"].set_index("scenario")["g_rms"]
    names = [[f"{kind}{index}" for kind in ("identified", "true")] for index in laboratories.index]
    by_name = {name: float(value) for name, value in point.items()}
    pairs = np.array([[_matching(by_name, name) for name in pair] for pair in names])
    return pairs[:, 0] / pairs[:, 1]


def _matching(values: dict[str, float], name: str) -> float:
    return next(value for key, value in values.items() if key.split("_")[0] == name)


def main() -> None:
    """Print the table."""
    rng, rows, cells, times = np.random.default_rng(5), [], [], []
    table = read_table(TRUTH)
    table = table[table["loss_factor"] > table["loss_factor_error"]]
    for _, group in table.groupby(KEYS, sort=False):
        start = time.process_time()
        rows.append(row_of(*laboratory(group, rng)) | {"tones": len(group)})
        times.append(time.process_time() - start)
        cells.append(group.iloc[0])
    results = pd.DataFrame(rows)
    print(results.round(3).to_string())
    print(f"{len(results)} laboratories, {np.median(times):.1f} CPU-s each")
    print(f"explained: {results['explained'].mean():.0%}")
    for name in ("e", "log_friction", "fill"):
        away = (results[name] - results[f"{name}_true"]).abs()
        print(
            f"{name}: within 90 % {results[f'{name}_within'].mean():.0%}, median error "
            f"{away.median():.3f}, median interval {results[f'{name}_width'].median():.3f}"
        )
    if "--panel" in sys.argv:
        ratio = panel_differences(results, pd.DataFrame(cells))
        away = np.abs(ratio - 1)
        print(f"g rms: median {np.median(away):.1%}, rms {np.sqrt(np.mean(away**2)):.1%}, ", end="")
        print(f"within 5 % {np.mean(away <= 0.05):.0%}")


if __name__ == "__main__":
    main()
