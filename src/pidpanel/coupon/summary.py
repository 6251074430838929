"""From the runs of a case to its row in ``cases.csv``.

No label depends on this module: a change rebuilds the table from stored rows without new runs.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Index
from pidpanel.coupon import cycles, records, rows, states
from pidpanel.coupon.attempts import seeds_disagree
from pidpanel.coupon.bed import Run
from pidpanel.coupon.cases import Case
from pidpanel.coupon.liggghts import failures
from pidpanel.coupon.records import OK, CaseOutcome, MeasuredBalance, Shaken
from pidpanel.coupon.window import CLOSURE_LIMIT


@dataclass(frozen=True)
class SeedEstimate:
    """Estimates from one seed of a case."""

    damping: cycles.Estimate  # C_e [N s/m³]
    apparent_mass: cycles.Estimate  # m_a [kg/m²]
    cells: Array  # (3, n) of `rows.cell_estimates`, of all cells together where it is one
    # Least and largest work of the shaker in a cycle of the second half [J].
    work: tuple[float, float]
    shaken: Shaken


def read_run(run: Run, shaken: Shaken, folder: Path) -> SeedEstimate:
    """Return the estimates of one run from its folder."""
    read = rows.read_shaken(run, folder, shaken)
    cells = rows.cell_estimates(run, rows.read_cells(run, folder, shaken), shaken.mass_kg)
    work = rows.work(run, read)[len(read) // 2 :]
    damping, apparent_mass = rows.estimates(run, read, shaken.mass_kg)
    ends = float(work.min()), float(work.max())
    return SeedEstimate(damping, apparent_mass, cells, ends, shaken)


# Largest ratio of the loss of the contacts in the window of the energy balance, often one cycle, to
# the mean of the rows [1]. In 180 runs of the paper's study it was 0.145 to 2.28. A cell that lands
# every third cycle loses almost nothing in the two between (0.01 was seen): the lower limit is 0.
LOSSES_APART = 30.0

# Largest distance of the work of the window from that of the rows, over their range and size [1]: a
# bed may change its motion, but not by an order of magnitude.
WORK_APART = 3.0


def find_problems(run: Run, read: SeedEstimate, folder: Path) -> Iterator[failures.SolverFailure]:
    """Yield the problems of a finished run."""
    damping, done = read.damping, read.shaken.cycles
    if not rows.is_steady(damping, done):
        yield failures.NotSteady(
            f"{folder}: transient to cycle {damping.start} of {done}, "
            f"drift of {damping.drift:.2g} standard errors after it"
        )
    balance = read.shaken.balance
    if balance is not None and not abs(balance.closure) <= CLOSURE_LIMIT:  # nor if it is NaN
        yield failures.EnergyNotClosed(
            f"{folder}: {balance.closure:+.2%} of the work is missing in the energy balance"
        )
    if balance is not None and damping.mean > 4 * damping.error:
        drive = run.drive
        energy = cycles.dissipated_energy(damping.mean, drive.amplitude, drive.frequency)
        ratio = balance.energies.dissipated / balance.cycles / (energy * run.packing.area)
        if not -CLOSURE_LIMIT < ratio < LOSSES_APART:
            yield failures.LossesApart(
                f"{folder}: contacts dissipate {ratio:.3g} times the energy in the rows; "
                f"allowed is 0 to {LOSSES_APART:g}"
            )
        work = balance.energies.work / balance.cycles
        low, high = read.work
        margin = WORK_APART * (high - low + abs(high))
        if not low - margin <= work <= high + margin:
            yield failures.LossesApart(
                f"{folder}: work of {work:.3g} J per cycle in the energy balance, "
                f"{low:.3g} to {high:.3g} J in the rows"
            )


def total_damping_error(read: SeedEstimate) -> float:
    """Return the standard error of C_e of one seed [N s/m³], with its drift if it is not steady.

    The halves of the run differ by `drift` times the error of their difference, twice that of the
    mean. The mean may be wrong by half of that.
    """
    damping = read.damping
    if rows.is_steady(damping, read.shaken.cycles):
        return damping.error
    return damping.error * max(1.0, abs(damping.drift))


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
        errors.append(np.array([total_damping_error(seed) for seed in seeds]))
        alike.append(
            len(seeds) > 1
            and bool(np.isfinite(errors[-1]).all())
            and not seeds_disagree([seed.damping for seed in seeds])
            and len(_cell_states(case, seeds)[1]) == 1
        )
    scatters = cycles.scatter_by_group(groups, means, errors, np.array(alike, bool))
    return [scatters[group] for group in groups]


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
    # States of motion of the cells, the lowest first: C_e [N s/m³], and share of the cells [1]
    state_damping: Sequence[float] = ()
    state_share: Sequence[float] = ()
    # Largest distance of C_e of a state from that of all cells; 0 with one state [N s/m³].
    state_error: float = 0.0


def read_seeds(case: Case, folder: Path) -> tuple[list[SeedEstimate], list[tuple[str, str]]]:
    """Return the estimates of good seeds, and name and text of each problem.

    Parameters
    ----------
    folder
        ``results/coupon``, with the outcome of the case and the rows of its runs.

    Raises
    ------
    RecordUnreadable
        If the outcome file cannot be read.
    """
    problems: list[tuple[str, str]] = []
    seeds: list[SeedEstimate] = []
    outcomes = records.read(CaseOutcome, case.outcome_file(folder)).runs
    # those of the reserve are there where the cells have several states
    all_runs = case.with_reserve
    for run, home, outcome in zip(all_runs.runs, all_runs.folders(folder), outcomes, strict=False):
        try:
            read = read_run(run, outcome.product, home)
        except failures.SolverFailure as failure:
            status = getattr(failure, "status", type(failure).__name__)
            problems.append((status, str(failure)))
        else:
            seeds.append(read)
            problems += [(type(p).__name__, str(p)) for p in find_problems(run, read, home)]
    return seeds, problems


def _mean_of_seeds(case: Case, seeds: Sequence[SeedEstimate], scatter: float) -> SeedMean:
    if not seeds:
        return SeedMean()
    means = np.array([seed.damping.mean for seed in seeds])
    errors = np.array([total_damping_error(seed) for seed in seeds])
    c, c_error = float(means.mean()), cycles.packed(means, errors, scatter)
    _, seed_error = cycles.combine(means, errors)
    if scatter == 0 or seeds_disagree([seed.damping for seed in seeds]):
        c_error = max(c_error, seed_error)
    masses = np.array([[seed.apparent_mass.mean, seed.apparent_mass.error] for seed in seeds])
    m, m_error = cycles.combine(*masses.T)
    (cell_damping, _, cell_mass), groups = _cell_states(case, seeds)
    if len(groups) > 1:
        c, m = float(cell_damping.mean()), float(cell_mass.mean())
        m_error = math.hypot(m_error, states.farthest(cell_mass, groups))
    seed_values = [(seed.shaken.spheres, seed.shaken.mass_kg) for seed in seeds]
    spheres, mass = np.mean(seed_values, axis=0).tolist()
    state_damping = [float(cell_damping[state].mean()) for state in groups]
    share = [len(state) / len(cell_damping) for state in groups]
    state_error = states.farthest(cell_damping, groups)
    return SeedMean(
        c, c_error, seed_error, m, m_error, spheres, mass, state_damping, share, state_error
    )


def summarise(
    case: Case,
    seeds: Sequence[SeedEstimate],
    problems: Sequence[tuple[str, str]],
    scatter: float = 0.0,
) -> Row:
    """Return the row of a case in ``cases.csv`` from the results of `read_seeds`."""
    point, packing, drive = case.point, case.point.packing, case.point.drive
    mean = _mean_of_seeds(case, seeds, scatter)
    if len(mean.state_damping) > 1:
        # a run that changes from one state to another is not steady; its error includes this
        problems = [problem for problem in problems if problem[0] != failures.NotSteady.__name__]
    c, m = mean.damping, mean.apparent_mass
    per_area = mean.mass_kg / packing.area
    w, f = drive.amplitude, drive.frequency
    # if the cycles give no error of m_a, it is the mass of the particles
    m_error = mean.apparent_mass_error if mean.apparent_mass_error < math.inf else per_area
    bound = cycles.inelastic_bound(per_area, f)
    bias = case.bias
    total_error = math.hypot(mean.damping_error, bias * c, mean.state_error)
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
        "states": len(mean.state_damping),
        "state_damping_n_s_m3": _listed(mean.state_damping),
        "state_share": _listed(mean.state_share),
        "state_error_n_s_m3": mean.state_error,
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
            math.hypot(mean.seed_error, mean.state_error)
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


def _cell_states(case: Case, seeds: Sequence[SeedEstimate]) -> tuple[Array, list[Index]]:
    """Return the cells of all runs, (3, n) as in a run, and those in each state of motion."""
    cells = np.hstack([seed.cells for seed in seeds])
    if case.state_cycles:
        return cells, states.states_of(*cells[:2])
    return cells, [np.arange(cells.shape[1])]


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
    seeds_of_cases = [read_seeds(case, folder) for case in cases]
    scatters = packing_scatter(cases, [seeds for seeds, _ in seeds_of_cases])
    table = [
        summarise(case, seeds, problems, scatter)
        for case, (seeds, problems), scatter in zip(cases, seeds_of_cases, scatters, strict=True)
    ]
    # seven digits, unknown numbers empty
    pd.DataFrame(table).to_csv(file, index=False, float_format="%.7g", lineterminator="\n")
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


def _listed(values: Sequence[float]) -> str:
    """Return the values of the states as text, empty for a single one: it is the case itself."""
    return " ".join(f"{value:.4g}" for value in values) if len(values) > 1 else ""
