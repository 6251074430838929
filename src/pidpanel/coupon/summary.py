"""From the runs of a case to its row in ``cases.csv``.

No label depends on this module: a change rebuilds the table from stored rows without new runs.
"""

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.coupon import cycles, packings, rows, states
from pidpanel.coupon.attempts import are_apart
from pidpanel.coupon.cases import Case
from pidpanel.coupon.judgement import SeedEstimate, error_of, judged_by, problems_of, read_run
from pidpanel.coupon.liggghts.failures import NotSteady, RunFailed, SolverFailure
from pidpanel.coupon.records import OK, MeasuredBalance

Row = dict[str, Any]  # A row of ``cases.csv``: column and value


class CoverageMissed(RuntimeError):
    """Too few cases are ok; the text names the others."""


def packing_scatter(
    cases: Sequence[Case], seeds_of_cases: Sequence[Sequence[SeedEstimate]]
) -> list[float]:
    """Return the relative scatter of C_e between packings, for each case [1]."""
    groups, means, errors, alike = [], [], [], []
    for case, seeds in zip(cases, seeds_of_cases, strict=True):
        first = case.point
        packing = replace(first.packing, seed=0)
        groups.append((packing, first.fill_fraction))
        means.append(np.array([seed.damping.mean for seed in seeds]))
        errors.append(np.array([error_of(seed) for seed in seeds]))
        alike.append(
            len(seeds) > 1
            and bool(np.isfinite(errors[-1]).all())
            and not are_apart([seed.damping for seed in seeds])
            and len(_states(case, seeds).damping) == 1
        )
    scatters = packings.scatter_by(groups, means, errors, np.array(alike, bool))
    return [scatters[group] for group in groups]


@dataclass(frozen=True)
class States:
    """States of motion of the cells of a case, and the differences between cells."""

    damping: tuple[float, ...]  # C_e of each, the lowest first [N s/m³]
    share: tuple[float, ...]  # share of the cells in each [1]
    # Largest distance of a state from the mean of all cells; 0 with one state [N s/m³].
    damping_error: float
    mass_error: float  # the same for m_a [kg/m²]
    mean: float  # C_e of all settled cells [N s/m³]
    mass_mean: float  # the same for m_a [kg/m²]


NO_STATES = States((), (), 0.0, 0.0, math.nan, math.nan)


@dataclass(frozen=True)
class SeedMean:
    """The seeds of a case together; NaN if none is left."""

    damping: float = math.nan  # C_e [N s/m³]
    damping_error: float = math.nan
    # Standard error of C_e from the seeds alone, without the scatter of packings [N s/m³].
    seed_error: float = math.nan
    apparent_mass: float = math.nan  # m_a [kg/m²]
    apparent_mass_error: float = math.nan
    spheres: float = math.nan  # in all cells
    mass_kg: float = math.nan
    states: States = NO_STATES


def read_seeds(
    case: Case, outcomes: Sequence[Path]
) -> tuple[list[SeedEstimate], list[tuple[str, str]]]:
    """Return the estimates of readable seeds, and name and text of each problem."""
    problems: list[tuple[str, str]] = []
    seeds: list[SeedEstimate] = []
    for run, path in judged_by(case, outcomes):
        try:
            read = read_run(run, path)
        except RunFailed as failure:
            problems.append((failure.status, str(failure)))
        except SolverFailure as failure:
            problems.append((type(failure).__name__, str(failure)))
        else:
            seeds.append(read)
            problems += [(type(p).__name__, str(p)) for p in problems_of(run, read, path.parent)]
    return seeds, problems


def _mean_of_seeds(case: Case, seeds: Sequence[SeedEstimate], scatter: float) -> SeedMean:
    if not seeds:
        return SeedMean()
    means = np.array([seed.damping.mean for seed in seeds])
    errors = np.array([error_of(seed) for seed in seeds])
    c, c_error = float(means.mean()), cycles.packed(means, errors, scatter)
    _, seed_error = cycles.combine(means, errors)
    if scatter == 0 or are_apart([seed.damping for seed in seeds]):
        c_error = max(c_error, seed_error)
    masses = np.array([[seed.apparent_mass.mean, seed.apparent_mass.error] for seed in seeds])
    m, m_error = cycles.combine(*masses.T)
    states = _states(case, seeds)
    if len(states.damping) > 1:
        c, m, m_error = states.mean, states.mass_mean, math.hypot(m_error, states.mass_error)
    of_seeds = [(seed.shaken.spheres, seed.shaken.mass_kg) for seed in seeds]
    spheres, mass = np.mean(of_seeds, axis=0).tolist()
    return SeedMean(c, c_error, seed_error, m, m_error, spheres, mass, states)


def summarise(
    case: Case,
    seeds: Sequence[SeedEstimate],
    problems: Sequence[tuple[str, str]],
    scatter: float = 0.0,
) -> Row:
    """Return the row of a case in ``cases.csv`` from the results of `read_seeds`."""
    point, packing, drive = case.point, case.point.packing, case.point.drive
    mean = _mean_of_seeds(case, seeds, scatter)
    cell_states = mean.states
    if len(cell_states.damping) > 1:
        # a run that changes from one state to another is not steady; its error includes this
        problems = [problem for problem in problems if problem[0] != NotSteady.__name__]
    c, m = mean.damping, mean.apparent_mass
    per_area = mean.mass_kg / packing.area
    w, f = drive.amplitude, drive.frequency
    # if the cycles give no error of m_a, it is the mass of the particles
    m_error = mean.apparent_mass_error if mean.apparent_mass_error < math.inf else per_area
    bound = cycles.inelastic_bound(per_area, f)
    bias = case.bias
    total_error = math.hypot(mean.damping_error, bias * c, cell_states.damping_error)
    return {
        **_first_columns(case),
        "youngs_modulus_mpa": point.constants.youngs_modulus / 1e6,
        "seeds": len(seeds),
        "cells": packing.count,
        "spheres_per_cell": mean.spheres / packing.count,
        "bulk_fraction": mean.mass_kg / packing.density / (packing.area * packing.depth),
        "particle_mass_per_area_kg_m2": per_area,
        "dissipated_energy_j_m2": cycles.dissipated_energy(c, w, f),
        "dissipated_energy_error_j_m2": cycles.dissipated_energy(total_error, w, f),
        "equivalent_damping_n_s_m3": c,
        "equivalent_damping_error_n_s_m3": total_error,
        "statistical_error_n_s_m3": mean.damping_error,
        "modulus_bias": bias,
        "packing_scatter": scatter,
        "states": len(cell_states.damping),
        "state_damping_n_s_m3": _listed(cell_states.damping),
        "state_share": _listed(cell_states.share),
        "state_error_n_s_m3": cell_states.damping_error,
        "apparent_mass_kg_m2": m,
        "apparent_mass_error_kg_m2": m_error,
        "loss_factor": cycles.loss_factor(c, per_area, f),
        "loss_factor_error": cycles.loss_factor(total_error, per_area, f),
        "bound_n_s_m3": bound,
        "share_of_bound": c / bound,
        **_energies([seed.shaken.balance for seed in seeds]),
        "cycles_run": sum(seed.shaken.cycles for seed in seeds),
        "cycles_used": sum(seed.damping.used for seed in seeds),
        "drift": max((seed.damping.drift for seed in seeds), key=abs, default=math.nan),
        "target_met": bool(
            math.hypot(mean.seed_error, cell_states.damping_error)
            <= max(case.relative_error * abs(c), rows.FLOOR * bound)
        ),
        "ended_by": "max_cycles"
        if any(seed.shaken.ended_by == "max_cycles" for seed in seeds)
        else "accuracy",
        "status": problems[0][0] if problems else OK,
        "message": problems[0][1] if problems else "",
    }


def _first_columns(case: Case) -> Row:
    """Return the columns of the point of a case."""
    point, drive = case.point, case.point.drive
    return {
        "case": case.label,
        "fill_fraction": point.fill_fraction,
        "frequency_hz": drive.frequency,
        "acceleration_g": drive.gamma,
        "displacement_mm": drive.amplitude * 1e3,
        "velocity_m_s": drive.speed,
        "diameter_mm": point.packing.diameter * 1e3,
        **case.varied,
    }


def _states(case: Case, seeds: Sequence[SeedEstimate]) -> States:
    """Return the states of the cells of all runs; each cell is an independent sample."""
    cells = [cell for seed in seeds for cell in seed.cells]
    means = np.array([cell.damping for cell in cells])
    masses = np.array([cell.apparent_mass for cell in cells])
    errors = np.array([cell.error for cell in cells])
    groups = [np.arange(len(cells))]
    if case.state_cycles:
        groups = states.states_of(means, errors)
    damping = tuple(float(means[state].mean()) for state in groups)
    share = tuple(len(state) / len(cells) for state in groups)
    error, mass_error = states.farthest(means, groups), states.farthest(masses, groups)
    return States(damping, share, error, mass_error, float(means.mean()), float(masses.mean()))


def _energies(balances: Sequence[MeasuredBalance | None]) -> dict[str, float]:
    """Return the worst closure of the seeds, and shares of the loss of all seeds together."""
    measured = [balance for balance in balances if balance is not None]

    def loss(*kinds: str) -> float:
        return sum(getattr(balance.energies, kind) for balance in measured for kind in kinds)

    normal = loss("sphere_normal", "wall_normal")
    tangential = loss("sphere_tangential", "wall_tangential")
    total = normal + tangential + loss("rolling")
    share = (lambda part: part / total) if total else (lambda part: math.nan)
    return {
        "closure": max((balance.closure for balance in measured), key=abs, default=math.nan),
        "normal_share": share(normal),
        "tangential_share": share(tangential),
        "wall_share": share(loss("wall_normal", "wall_tangential")),
    }


def write_table(cases: Sequence[Case], folder: Path, file: Path, *, coverage: float) -> None:
    """Write ``cases.csv`` from the runs in ``results/coupon``.

    `CoverageMissed` is raised after that and names the cases that are not ok, if their share
    exceeds 1 − coverage.
    """
    evidence = [read_seeds(case, case.outcomes(folder)) for case in cases]
    scatters = packing_scatter(cases, [seeds for seeds, _ in evidence])
    table = [
        summarise(case, seeds, problems, scatter)
        for case, (seeds, problems), scatter in zip(cases, evidence, scatters, strict=True)
    ]
    write_cases(table, file)
    check_coverage(table, coverage)


def check_coverage(table: Sequence[Row], coverage: float) -> None:
    """Refuse a table with too few cases that are ok."""
    bad = [row for row in table if row["status"] != OK]
    good = (len(table) - len(bad)) / len(table)
    if good < coverage:
        lines = [f"{row['case']}: {row['status']}: {row['message']}" for row in bad]
        lines.append(
            f"{good:.1%} of the cases are ok; coupon.accuracy.coverage requires {coverage:.1%}; "
            "raise coupon.accuracy.max_cycles, or lower the coverage"
        )
        raise CoverageMissed("\n".join(lines))


def write_cases(table: Sequence[Row], file: Path) -> None:
    """Write rows of `summarise` as ``cases.csv``: seven digits, unknown numbers empty."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: _cell(value) for key, value in row.items()} for row in table)


def _listed(values: Sequence[float]) -> str:
    """Return the values of the states as text, empty for a single one: it is the case itself."""
    return " ".join(f"{value:.4g}" for value in values) if len(values) > 1 else ""


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.7g}"
    return str(value)
