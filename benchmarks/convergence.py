"""Where g rms of a coupled scenario stops moving: with modulus, time step, stations and cells.

The panel of launch.yaml with PID-1 filled; every variant has the packings and the sound of the
others. g rms at the point 326 as one run tells it, with its error.

    python benchmarks/convergence.py modulus|step|stations [folder] [level_db] [fill]

Ten CPU-minutes for a level and a fill. coupled.md has the tables.
"""

from __future__ import annotations

import copy
import sys
from pathlib import Path

import numpy as np
import yaml
from coupled_scenarios import made_panel

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled import scenario_runs
from pidpanel.coupled.from_study import coupled_scenarios
from pidpanel.coupled.scenario_runs import ScenarioRuns
from pidpanel.paths import WORKFLOW

VARIANTS = {
    "modulus": [{"youngs_modulus_mpa": value} for value in (50, 200, 800, 3200)],
    "step": [{"step_rayleigh": value} for value in (0.1, 0.2, 0.4)],
    "stations": [
        {"stations": stations, "cells": cells}
        for stations, cells in ((1, 24), (4, 8), (4, 16), (8, 16), (12, 24), (24, 24))
    ],
}
"""What is varied: keys of ``damping.coupled``, and the time step."""


def study_of(level: float, fill: float, keys: dict[str, float]) -> dict[str, object]:
    """Return the study of one scenario."""
    values = yaml.safe_load((WORKFLOW / "studies" / "launch.yaml").read_text())
    values["damping"] = {"coupled": keys}
    values["response"] = {"frequency_hz": [30, 2000], "damper_mass": True}
    values["scenarios"] = {"one": {"layout": {"PID-1": {"fill_fraction": fill}}, "oaspl_db": level}}
    return copy.deepcopy(values)


def main() -> None:
    """Run the variants and print what they tell."""
    kind = sys.argv[1] if len(sys.argv) > 1 else "modulus"
    folder = Path(sys.argv[2] if len(sys.argv) > 2 else "build/convergence").resolve()
    level, fill = (float(sys.argv[k]) if len(sys.argv) > k else v for k, v in ((3, 122), (4, 0.5)))
    for variant in VARIANTS[kind]:
        keys = dict(variant)
        scenario_runs.STEP_RAYLEIGH = keys.pop("step_rayleigh", scenario_runs.STEP_RAYLEIGH)
        name = "_".join(f"{key}{value}" for key, value in variant.items())
        study, panel = made_panel(folder, "convergence", study_of(level, fill, keys))
        coupled = coupled_scenarios(study)["one"]
        records = folder / f"{level:g}dB_r{fill:g}_{name}"
        records.mkdir(exist_ok=True)
        runs = ScenarioRuns(panel, coupled, folder / "results" / "coupon", records)
        found = runs.estimate([runs.record(1)])
        acceleration = (2 * np.pi * found.frequency[:, None]) ** 4 * found.psd
        g_rms = np.sqrt(np.trapezoid(acceleration, found.frequency, axis=0)) / STANDARD_GRAVITY
        print(
            f"{level:g} dB, r = {fill:g}, {name}: {g_rms[0]:.4g} g ± {found.log_error[0] / 2:.1%}"
        )


if __name__ == "__main__":
    main()
