"""From the runs of a case to its row in ``cases.csv``."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import cycles
from pidpanel.coupon.cases import Case
from pidpanel.coupon.liggghts import output
from pidpanel.coupon.runs import FLOOR, estimates, is_steady, read_run
from pidpanel.coupon.window import CLOSURE_LIMIT


def summarise(case: Case, outcomes: list[Path]) -> dict[str, Any]:
    """One row of ``cases.csv``: what was asked, what came out, how sure it is.

    Parameters
    ----------
    case
        The case.
    outcomes
        The files `runs.attempt_shake` left, one a seed, each in the folder of its run.
    """
    point = case.point
    packing = point.packing
    problems: list[tuple[str, str]] = []
    kept = []
    for run, path in zip(case.runs, outcomes, strict=True):
        outcome = json.loads(path.read_text())
        try:
            if outcome["status"] != "ok":
                problems.append((outcome["status"], outcome["message"]))
                continue
            rows = read_run(run, path.parent, outcome["legs"], outcome["cycles"])
        except output.SolverFailure as failure:
            problems.append((type(failure).__name__, str(failure)))
            continue
        found, mass = estimates(run, rows, outcome["mass_kg"])
        kept.append((found, mass, outcome))
        if not is_steady(found, len(rows)):
            problems.append(
                (
                    "NotSteady",
                    f"{path.parent}: transient to cycle {found.start} of {len(rows)}, "
                    f"drift of {found.drift:.2g} standard errors after it",
                )
            )
        balance = outcome["balance"]
        if balance is not None and abs(balance["closure"]) > CLOSURE_LIMIT:
            problems.append(
                (
                    "EnergyNotClosed",
                    f"{path.parent}: {balance['closure']:+.2%} of the work in the energy balance",
                )
            )
    c, c_error, m, m_error, spheres, mass_kg, drift = (math.nan,) * 7
    if kept:
        c, c_error = cycles.combine(*np.array([[e.mean, e.error] for e, _, _ in kept]).T)
        m, m_error = cycles.combine(*np.array([[e.mean, e.error] for _, e, _ in kept]).T)
        spheres = float(np.mean([o["spheres"] for _, _, o in kept])) / packing.count
        mass_kg = float(np.mean([o["mass_kg"] for _, _, o in kept]))
        drift = max((e.drift for e, _, _ in kept), key=abs)
    per_area = mass_kg / packing.area
    bound = cycles.inelastic_bound(per_area, point.frequency)
    w, f = point.amplitude, point.frequency
    bias = case.bias
    total_error = math.hypot(c_error, bias * c)
    return {
        "case": case.label,
        "fill_fraction": point.fill_fraction,
        "frequency_hz": f,
        "acceleration_g": point.acceleration / STANDARD_GRAVITY,
        "displacement_mm": w * 1e3,
        "velocity_m_s": point.speed,
        "diameter_mm": packing.diameter * 1e3,
        **{key: value for key, value in case.varied.items()},
        "youngs_modulus_mpa": point.constants.youngs_modulus / 1e6,
        "seeds": len(kept),
        "cells": packing.count,
        "spheres_per_cell": spheres,
        "bulk_fraction": mass_kg / packing.density / (packing.area * packing.depth),
        "particle_mass_per_area_kg_m2": per_area,
        "dissipated_energy_j_m2": cycles.dissipated_energy(c, w, f),
        "dissipated_energy_error_j_m2": cycles.dissipated_energy(total_error, w, f),
        "equivalent_damping_n_s_m3": c,
        "equivalent_damping_error_n_s_m3": total_error,
        "statistical_error_n_s_m3": c_error,
        "modulus_bias": bias,
        "apparent_mass_kg_m2": m,
        "apparent_mass_error_kg_m2": m_error,
        "loss_factor": cycles.loss_factor(c, per_area, f),
        "loss_factor_error": cycles.loss_factor(total_error, per_area, f),
        "bound_n_s_m3": bound,
        "share_of_bound": c / bound,
        **_energies([outcome["balance"] for _, _, outcome in kept]),
        "cycles_run": sum(o["cycles"] for _, _, o in kept),
        "cycles_used": sum(e.used for e, _, _ in kept),
        "drift": drift,
        "target_met": bool(c_error <= max(case.relative_error * abs(c), FLOOR * bound)),
        "ended_by": "max_cycles"
        if any(o["ended_by"] == "max_cycles" for _, _, o in kept)
        else "accuracy",
        "status": problems[0][0] if problems else "ok",
        "message": problems[0][1] if problems else "",
    }


def _energies(balances: list[dict[str, float] | None]) -> dict[str, float]:
    """Worst closure of the seeds and shares of the loss, all seeds together."""
    known = [balance for balance in balances if balance is not None]
    normal, tangential, rolling, walls = (
        sum(balance[key] for balance in known for key in keys)
        for keys in (
            ("sphere_normal", "wall_normal"),
            ("sphere_tangential", "wall_tangential"),
            ("rolling",),
            ("wall_normal", "wall_tangential"),
        )
    )
    total = normal + tangential + rolling
    share = (lambda part: part / total) if total else (lambda part: math.nan)
    return {
        "closure": max((balance["closure"] for balance in known), key=abs, default=math.nan),
        "normal_share": share(normal),
        "tangential_share": share(tangential),
        "wall_share": share(walls),
    }


def write_cases(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """Rows of `summarise` as ``cases.csv``: seven digits, nothing where a number is unknown."""
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows({key: _cell(value) for key, value in row.items()} for row in rows)


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.7g}"
    return str(value)
