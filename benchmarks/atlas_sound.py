"""g rms under sound with the atlas, against coupled runs of further scenarios.

    python benchmarks/atlas_sound.py run FOLDER [CPU-s]
    python benchmarks/atlas_sound.py write FOLDER
    python benchmarks/atlas_sound.py

48 scenarios are drawn before any of them is computed: half on the paper's panel, in a baffle and
free in air, half on eight others of `atlas_sound_panels`. `run` makes one coupled run of each, the
cheapest of each third of the fills in turn, and adds a row for each point to FOLDER/cases.csv.
Scenarios that cost more than some CPU-s, by their estimate, are left out. `write` computes the
atlas for the rows of atlas_sound_cases.csv and writes its columns there; without a word the table
of atlas.md is printed. Rows of the panel ``layouts`` are of earlier coupled runs on the paper's
panel that set nothing either, some under a steady acceleration.

Contacts of cells fuller than 0.6 are four times as stiff as those that the product chooses: its
rule states too little there (coupled.md, modulus of the contacts).
"""

from __future__ import annotations

import resource
import shutil
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import yaml
from atlas_panels import answers
from atlas_sound_panels import FULL, drawn_panels

from pidpanel import Model
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.beds import cpu_per_interval
from pidpanel.coupled.from_study import coupled_scenarios, read_excited_panel
from pidpanel.coupled.scenario_runs import INTERVALS_PER_PERIOD, STEP_RAYLEIGH, ScenarioRuns
from pidpanel.coupon.estimate import spheres_in
from pidpanel.paths import WORKFLOW
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import (
    dampers_of_scenarios,
    read_response_panel,
    scenarios_of,
)
from pidpanel.response.trust import LARGEST_OF_ATLAS
from pidpanel.study import Study

CASES = Path(__file__).with_name("atlas_sound_cases.csv")
MOST_CPU_S = 150.0  # of a coupled run, by its estimate
COUPLED = {"runs": 1, "duration_s": 1.0, "settle_s": 0.3}


def coupled_study(values: Mapping[str, Any], folder: Path) -> Study:
    """Return the study of a panel with all beds coupled, one run each."""
    dampers = {name: {**bed, "model": "coupled"} for name, bed in values["dampers"].items()}
    coupled = {**values, "dampers": dampers, "damping": {"coupled": COUPLED}}
    study = Model(coupled, folder).study
    assert isinstance(study, Study)
    return study


def panel_files(values: Mapping[str, Any], folder: Path) -> Files:
    """Return the files of panel and sound of a study, computed where they are not in a folder."""
    stored = folder / "panel"
    if not stored.exists():
        model, draft = Model(values, folder), folder / "draft"
        draft.mkdir(parents=True, exist_ok=True)
        for name in ("panel", "sound"):
            for key, (path,) in model._stages.files(name).all.items():
                if path.exists():
                    shutil.copy(path, draft / f"{key}{path.suffix}")
        draft.rename(stored)
    return Files({path.stem: [path] for path in sorted(stored.iterdir())})


def runs_of(values: Mapping[str, Any], folder: Path) -> dict[str, ScenarioRuns]:
    """Return the coupled runs of the scenarios of a panel."""
    study = coupled_study(values, folder)
    excited = read_excited_panel(study, panel_files(values, folder))
    runs = {}
    for label, scenario in coupled_scenarios(study).items():
        records = folder / "records" / label
        records.mkdir(parents=True, exist_ok=True)
        usual = ScenarioRuns(excited, scenario, folder / "coupon", records)
        runs[label] = usual
        (soft,), (patch,) = usual.softened, scenario.patches
        if patch.beds[0].fill_fraction > FULL:
            modulus = min(4 * soft.modulus, patch.youngs_modulus)
            stiff = replace(excited, settings=replace(excited.settings, youngs_modulus=modulus))
            runs[label] = ScenarioRuns(stiff, scenario, folder / "coupon", records)
    return runs


def cost(runs: ScenarioRuns) -> float:
    """Return about the CPU time of a run [s]."""
    settings, (soft,) = runs.excited.settings, runs.softened
    bed = runs.scenario.patches[0].beds[0]
    step = STEP_RAYLEIGH * bed.packing.smallest(soft.modulus).rayleigh_time
    interval = 1 / (INTERVALS_PER_PERIOD * settings.frequency_range[1])
    substeps = max(1, int(interval / step))
    each = cpu_per_interval(round(spheres_in(bed.packing, bed.fill_fraction)), substeps)
    return (settings.settling + settings.duration) / min(interval, substeps * step) * each


def results_of(runs: ScenarioRuns) -> pd.DataFrame:
    """Return g rms at each point and its standard error [1], of one coupled run."""
    before = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    before += sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    found = runs.estimate([runs.record(1)])
    after = sum(resource.getrusage(resource.RUSAGE_SELF)[:2])
    after += sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
    acceleration = (2 * np.pi * found.frequency[:, None]) ** 4 * found.psd
    g_rms = np.sqrt(np.trapezoid(acceleration, found.frequency, axis=0)) / STANDARD_GRAVITY
    return pd.DataFrame({
        "point": runs.excited.basis.point_names,
        "coupled_g": g_rms,
        "coupled_error": found.log_error / 2,
        "contacts_mpa": runs.softened[0].modulus / 1e6,
        "contacts_bias": runs.bias,
        "cpu_s": round(after - before, 1),
    })  # fmt: skip


def in_turn(plan: pd.DataFrame) -> pd.DataFrame:
    """Return the scenarios by cost, the cheapest of each third of the fills in turn."""
    thirds = pd.qcut(plan["fill_fraction"], 3, labels=False)
    turn = plan.groupby(thirds)["cost_s"].rank(method="first")
    return plan.assign(turn=turn).sort_values(["turn", "cost_s"])


def run(folder: Path, most: float) -> None:
    """Run the scenarios that cost at most so many CPU-s, and append their rows to cases.csv."""
    runs: dict[str, ScenarioRuns] = {}
    rows = []
    for name, (values, beds) in drawn_panels().items():
        of_panel = runs_of(values, folder / name)
        runs.update(of_panel)
        rows += [{**bed, "cost_s": round(cost(of_panel[bed["scenario"]]), 1)} for bed in beds]
        print(name, time.strftime("%X"), flush=True)
    plan = in_turn(pd.DataFrame(rows))
    plan.to_csv(folder / "plan.csv", index=False)
    path = folder / "cases.csv"
    for row in plan[plan["cost_s"] <= most].drop(columns=["turn"]).to_dict("records"):
        try:
            table = results_of(runs[row["scenario"]])
        except Exception as error:  # the others go on
            print(row["scenario"], repr(error), flush=True)
            continue
        table = pd.DataFrame([row]).merge(table, "cross")
        table.to_csv(path, mode="a", header=not path.exists(), index=False, float_format="%.5g")
        print(row["scenario"], time.strftime("%X"), flush=True)


def earlier_study(cases: pd.DataFrame) -> dict[str, Any]:
    """Return the study of cases on the paper's panel, with its patches, in a baffle."""
    path = WORKFLOW / "studies" / "layouts.yaml"
    study: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    for bed in study["dampers"].values():
        del bed["sweep"], bed["accuracy"]
        bed["model"] = "atlas"
    study["panel"]["mesh"]["elements"] = [48, 32]  # for the mass of steel
    study["response"] = {"frequency_hz": [30, 2000]}
    study["scenarios"] = {}
    for row in cases.drop_duplicates("scenario").to_dict("records"):
        filling = {"damper": row["material"], "fill_fraction": row["fill_fraction"]}
        scenario = {"layout": {row["patch"]: filling}, "oaspl_db": row["oaspl_db"]}
        if isinstance(row["steady_acceleration_g"], str):
            vector = [float(part) for part in row["steady_acceleration_g"].split()]
            scenario["steady_acceleration_g"] = vector
        study["scenarios"][row["scenario"]] = scenario
    return study


def with_atlas(cases: pd.DataFrame, folder: Path) -> pd.DataFrame:
    """Return the cases with g rms of the atlas, and its stated errors [1]: of C_e, and in all."""
    parts = []
    for name, rows in cases.groupby("panel", sort=False):
        labels = set(rows["scenario"])
        if name == "layouts":
            values = earlier_study(rows)
        else:
            values, _ = drawn_panels()[str(name)]
            values["scenarios"] = {k: v for k, v in values["scenarios"].items() if k in labels}
        study = Model(values, folder).study
        assert isinstance(study, Study)
        files = panel_files(values, folder / str(name))
        scenarios = scenarios_of(study, dampers_of_scenarios(study, None, None))
        panel = read_response_panel(study, files)
        drawn = [scenario for scenario in scenarios if not scenario.is_bare]
        for scenario, rms in zip(drawn, answers(panel, scenarios), strict=True):
            parts.append(pd.DataFrame({
                "scenario": scenario.label, "point": panel.basis.point_names,
                "atlas_g": rms.values, "atlas_error": rms.log_error,
            }))  # fmt: skip
    found = pd.concat(parts)
    kept = [key for key in cases if key not in ("atlas_g", "atlas_error")]
    return cases[kept].merge(found, "left", ["scenario", "point"])


def print_counts(cases: pd.DataFrame) -> None:
    """Print how far the atlas is from coupled runs, by what differs between the scenarios."""
    away = np.log(cases["atlas_g"] / cases["coupled_g"])
    z = away / np.hypot(cases["atlas_error"], cases["coupled_error"])
    largest = cases.groupby("scenario")["atlas_error"].transform("max")
    fills = pd.cut(cases["fill_fraction"], [0, 0.2, 0.4, 0.65, 1]).astype(str)
    levels = pd.cut(cases["oaspl_db"], [0, 130, 140, 170]).astype(str)
    loads = cases["gravity"].where(cases["steady_acceleration_g"].isna(), "steady acceleration")
    panels = cases["panel"].where(cases["panel"].isin(["layouts", "paper_free"]), "others")
    trust = pd.Series(np.where(largest <= LARGEST_OF_ATLAS, "up to 8 %", "above"), cases.index)
    everything = pd.Series("all", cases.index)
    print(
        "| group | scenarios | values | rms | mean | within 1.96 errors | rms z |\n|" + 7 * "---|"
    )
    for groups in (fills, levels, loads, panels, trust, everything):
        for name, rows in cases.groupby(groups):
            a, score = away[rows.index], z[rows.index]
            print(f"| {name} | {rows['scenario'].nunique()} | {len(rows)} | "
                  f"{np.sqrt((a**2).mean()):.1%} | {a.mean():+.1%} | "
                  f"{(score.abs() < 1.96).mean():.0%} | "
                  f"{np.sqrt((score**2).mean()):.2f} |")  # fmt: skip


def main() -> None:
    """Run the scenarios, or count the atlas on them."""
    folder = Path(sys.argv[2] if len(sys.argv) > 2 else "build/atlas_sound").resolve()
    if sys.argv[1:2] == ["run"]:
        run(folder, float(sys.argv[3]) if len(sys.argv) > 3 else MOST_CPU_S)
        return
    cases = pd.read_csv(CASES, dtype={"point": str})
    if sys.argv[1:2] == ["write"]:
        cases = with_atlas(cases, folder)
        cases.to_csv(CASES, index=False, float_format="%.5g")
    print_counts(cases)


if __name__ == "__main__":
    main()
