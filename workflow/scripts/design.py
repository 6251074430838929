"""The next round of cases for a target: which to run, or that it is reached (round.json)."""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scripts.damping import surface_of
from scripts.panel_in_sound import PanelInSound

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon.cases import cases_of
from pidpanel.damping import design
from pidpanel.response import uncertainty
from pidpanel.study import load_study


def wanted_of(panel, solvers, surface):
    """Of every scenario with a damper: its label, rms accelerations and how they move."""
    study = panel.study
    own_acceleration = (
        surface.depends_on_acceleration and study.damping.level.acceleration_g is None
    )
    for case in panel.responses(solvers, {"dem": surface}):
        if case.damping is None:
            continue
        derivative = uncertainty.sensitivity(
            case.solver,
            case.damping,
            case.found,
            surface.nodes,
            case.pressure_factor,
            own_acceleration=own_acceleration,
            damper_mass=study.response.damper_mass,
        ).log_rms
        read_at = case.found.acceleration_g
        wanted = design.Wanted(case.scenario.fill_fraction, read_at, derivative)
        yield case.scenario.label, case.found.response.acceleration_rms, wanted


def for_rms(panel):
    """The panel on few lines and without strains: enough for rms accelerations within 1e-3."""
    panel.frequency = panel.coarse_frequency
    panel.motion_at_points = panel.basis.shape_at_points
    return panel


def points_of(cases):
    """(n, 3) r, f, Γ."""
    return np.array(
        [
            (c.point.fill_fraction, c.point.frequency, c.point.acceleration / STANDARD_GRAVITY)
            for c in cases
        ]
    )


if __name__ == "__main__":
    study_path, modes, modal_force, air, before, table, output = sys.argv[1:]
    study = load_study(study_path)
    target, pool = study.damping.target, cases_of(study.coupon)
    points = points_of(pool)
    if before == "none":
        chosen = design.spread(points, target.start)
        found = {"round": 0, "reached": False, "new": len(chosen),
                 "cases": [pool[i].label for i in chosen]}  # fmt: skip
    else:
        last = json.loads(Path(before).read_text())
        surface = surface_of(study, pd.read_csv(table, keep_default_na=True))
        panel = for_rms(PanelInSound(study, modes, modal_force, air, study.response.radiation))
        patches = dict.fromkeys(s.patch for s in study.all_scenarios() if s.patch is not None)
        scenarios = list(wanted_of(panel, panel.solvers(list(patches)), surface))
        wanted = [one for _, _, one in scenarios]
        error = np.sqrt(design.variances(surface, wanted))
        left = [i for i, case in enumerate(pool) if case.label not in set(last["cases"])]
        room = min(target.batch, target.max_cases - len(last["cases"]))
        chosen = design.next_cases(
            surface, wanted, points[left], study.coupon.accuracy.relative_error,
            target.relative_error, max(room, 0),
        )  # fmt: skip
        found = {
            "round": last["round"] + 1,
            "target": target.relative_error,
            "reached": bool(error.max() <= target.relative_error),
            "largest_relative_error": float(error.max()),
            "relative_error": {
                label: dict(zip(panel.basis.point_names, own.round(5).tolist(), strict=True))
                for (label, _, _), own in zip(scenarios, error, strict=True)
            },
            "cases": last["cases"] + [pool[left[i]].label for i in chosen],
            "new": len(chosen),
        }
    Path(output).write_text(json.dumps(found, indent=1))
