"""From the runs of a case to its row in ``cases.csv``.

Nothing here enters a label: changed code makes the table anew from the rows that are there.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.coupon import coding, cycles, packings, rows, states
from pidpanel.coupon.attempts import are_apart
from pidpanel.coupon.cases import Case, Run
from pidpanel.coupon.liggghts.failures import (
    EnergyNotClosed,
    LossesApart,
    NotSteady,
    RunFailed,
    SolverFailure,
)
from pidpanel.coupon.records import OK, MeasuredBalance, Shaken, ShakeOutcome
from pidpanel.coupon.window import CLOSURE_LIMIT

Row = dict[str, Any]
"""A row of ``cases.csv``: column and value."""


class CoverageMissed(RuntimeError):
    """Too few cases are ok to build on; the text names the others."""


@dataclass(frozen=True)
class Read:
    """What one seed of a case gives."""

    damping: cycles.Estimate
    """C_e [N s/m³]."""
    apparent_mass: cycles.Estimate
    """m_a [kg/m²]."""
    cells: list[rows.CellEstimate]
    """Of each cell that holds particles, or of all together."""
    work: tuple[float, float]
    """Least and largest work of the shaker in a cycle of the second half [J]."""
    found: Shaken


def read_run(run: Run, file: Path) -> Read:
    """Estimates of one run from the outcome in its folder.

    Raises
    ------
    RunFailed
        If the run ended with a failure.
    SolverFailure
        If the file or the rows cannot be read.
    """
    outcome = coding.read(ShakeOutcome, file)
    outcome.check_run(run, file)
    found = outcome.shaken
    read = rows.read_shaken(run, file.parent, found)
    cells = rows.cell_estimates(run, rows.read_cells(run, file.parent, found), found.mass_kg)
    work = rows.work(run, read)[len(read) // 2 :]
    return Read(
        *rows.estimates(run, read, found.mass_kg),
        cells,
        (float(work.min()), float(work.max())),
        found,
    )


LOSSES_APART = 30.0
"""Largest ratio of what the contacts lose in the window of the energy balance, often one cycle, to
the mean of the rows [1]. In 180 runs of the paper's study it lay between 0.145 and 2.28; a single
cell that lands every third cycle loses next to nothing in the two between (0.01 was seen), so that
less than nothing is the lower limit."""

WORK_APART = 3.0
"""How far the work of the window may lie outside that of the rows, over their range and size [1]: a
bed may do next what it did not do before, but not of another order."""


def problems_of(run: Run, read: Read, folder: Path) -> list[SolverFailure]:
    """What speaks against a run that came to its end."""
    problems: list[SolverFailure] = []
    damping, done = read.damping, read.found.cycles
    if not rows.is_steady(damping, done):
        problems.append(
            NotSteady(
                f"{folder}: transient to cycle {damping.start} of {done}, "
                f"drift of {damping.drift:.2g} standard errors after it"
            )
        )
    balance = read.found.balance
    if balance is not None and not abs(balance.closure) <= CLOSURE_LIMIT:  # nor if it is NaN
        problems.append(
            EnergyNotClosed(
                f"{folder}: {balance.closure:+.2%} of the work is missing in the energy balance"
            )
        )
    if balance is not None and damping.mean > 4 * damping.error:
        drive = run.drive
        energy = cycles.dissipated_energy(damping.mean, drive.amplitude, drive.frequency)
        ratio = balance.energies.dissipated / balance.cycles / (energy * run.packing.area)
        if not -CLOSURE_LIMIT < ratio < LOSSES_APART:
            problems.append(
                LossesApart(
                    f"{folder}: contacts dissipate {ratio:.3g} times the energy in the rows; "
                    f"allowed is 0 to {LOSSES_APART:g}"
                )
            )
        work = balance.energies.work / balance.cycles
        low, high = read.work
        margin = WORK_APART * (high - low + abs(high))
        if not low - margin <= work <= high + margin:
            problems.append(
                LossesApart(
                    f"{folder}: work of {work:.3g} J per cycle in the energy balance, "
                    f"{low:.3g} to {high:.3g} J in the rows"
                )
            )
    return problems


def judged_by(case: Case, outcomes: Sequence[Path]) -> list[tuple[Run, Path]]:
    """Runs by which a case is judged, and their outcomes: with its reserve if that was run."""
    for path in outcomes:
        with suppress(SolverFailure):
            if coding.read(ShakeOutcome, path).seeds > len(case.runs):
                homes = [path.parents[1] / f"s{run.packing.seed}" for run in case.reserve]
                outcomes = [*outcomes, *(home / path.name for home in homes)]
                return list(zip(case.with_reserve.runs, outcomes, strict=True))
    return list(zip(case.runs, outcomes, strict=True))


def error_of(read: Read) -> float:
    """Standard error of C_e of one seed [N s/m³], with what it drifts where it is not steady.

    The halves of the run differ by `drift` of the error of their difference, twice that of the
    mean: half of it is what the mean may be off.
    """
    damping = read.damping
    if rows.is_steady(damping, read.found.cycles):
        return damping.error
    return damping.error * max(1.0, abs(damping.drift))


def packing_scatter(cases: Sequence[Case], folder: Path) -> list[float]:
    """Return of each case how far packings of its bed scatter, over C_e [1]."""
    groups, means, errors, alike = [], [], [], []
    for case in cases:
        kept = []
        for run, path in judged_by(case, case.outcomes(folder)):
            with suppress(SolverFailure, RunFailed):
                kept.append(read_run(run, path))
        first = case.point
        packing = replace(first.packing, seed=0)
        groups.append((packing, first.fill_fraction))
        means.append(np.array([one.damping.mean for one in kept]))
        errors.append(np.array([error_of(one) for one in kept]))
        alike.append(
            len(kept) > 1
            and bool(np.isfinite(errors[-1]).all())
            and not are_apart([one.damping for one in kept])
            and len(_states(case, kept).damping) == 1
        )
    found = packings.scatter_by(groups, means, errors, np.array(alike, bool))
    return [found[group] for group in groups]


def summarise(case: Case, outcomes: Sequence[Path], scatter: float = 0.0) -> Row:
    """One row of ``cases.csv``: what was asked, what came out, how sure it is.

    Parameters
    ----------
    case
        The case.
    outcomes
        The files of `Case.outcomes`, one a seed, each in the folder of its run.
    scatter
        Standard deviation between packings over C_e [1], see `packing_scatter`.
    """
    problems: list[tuple[str, str]] = []
    kept: list[Read] = []
    for run, path in judged_by(case, outcomes):
        try:
            read = read_run(run, path)
        except RunFailed as failure:
            problems.append((failure.status, str(failure)))
        except SolverFailure as failure:
            problems.append((type(failure).__name__, str(failure)))
        else:
            kept.append(read)
            problems += [(type(p).__name__, str(p)) for p in problems_of(run, read, path.parent)]
    point, packing, drive = case.point, case.point.packing, case.point.drive
    c, c_error, own_error, m, m_error, spheres, mass_kg, drift = (math.nan,) * 8
    found = NO_STATES
    if kept:
        means = np.array([one.damping.mean for one in kept])
        errors = np.array([error_of(one) for one in kept])
        c, c_error = float(means.mean()), cycles.packed(means, errors, scatter)
        _, own_error = cycles.combine(means, errors)
        if scatter == 0 or are_apart([one.damping for one in kept]):
            c_error = max(c_error, own_error)
        m, m_error = _combined([one.apparent_mass for one in kept])
        found = _states(case, kept)
        if len(found.damping) > 1:
            c, m, m_error = found.mean, found.mass_mean, math.hypot(m_error, found.mass_error)
            # a run on its way from one state to another is not steady; that is in the error
            problems = [one for one in problems if one[0] != NotSteady.__name__]
        spheres = float(np.mean([one.found.spheres for one in kept])) / packing.count
        mass_kg = float(np.mean([one.found.mass_kg for one in kept]))
        drift = max((one.damping.drift for one in kept), key=abs)
    per_area = mass_kg / packing.area
    w, f = drive.amplitude, drive.frequency
    bound = cycles.inelastic_bound(per_area, f)
    bias = case.bias
    total_error = math.hypot(c_error, bias * c, found.damping_error)
    return {
        "case": case.label,
        "fill_fraction": point.fill_fraction,
        "frequency_hz": f,
        "acceleration_g": drive.gamma,
        "displacement_mm": w * 1e3,
        "velocity_m_s": drive.speed,
        "diameter_mm": packing.diameter * 1e3,
        **case.varied,
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
        "packing_scatter": scatter,
        "states": len(found.damping),
        "state_damping_n_s_m3": _listed(found.damping),
        "state_share": _listed(found.share),
        "state_error_n_s_m3": found.damping_error,
        "apparent_mass_kg_m2": m,
        "apparent_mass_error_kg_m2": m_error,
        "loss_factor": cycles.loss_factor(c, per_area, f),
        "loss_factor_error": cycles.loss_factor(total_error, per_area, f),
        "bound_n_s_m3": bound,
        "share_of_bound": c / bound,
        **_energies([one.found.balance for one in kept]),
        "cycles_run": sum(one.found.cycles for one in kept),
        "cycles_used": sum(one.damping.used for one in kept),
        "drift": drift,
        "target_met": bool(
            math.hypot(own_error, found.damping_error)
            <= max(case.relative_error * abs(c), rows.FLOOR * bound)
        ),
        "ended_by": "max_cycles"
        if any(one.found.ended_by == "max_cycles" for one in kept)
        else "accuracy",
        "status": problems[0][0] if problems else OK,
        "message": problems[0][1] if problems else "",
    }


@dataclass(frozen=True)
class States:
    """States of motion of the cells of a case, and how far its cells differ."""

    damping: tuple[float, ...]
    """C_e of each, the lowest first [N s/m³]."""
    share: tuple[float, ...]
    """Of the cells [1]."""
    damping_error: float
    """Largest distance of a state from the mean of all cells; 0 with one state [N s/m³]."""
    mass_error: float
    """The same of m_a [kg/m²]."""
    mean: float
    """C_e of all cells once they have settled [N s/m³]."""
    mass_mean: float
    """The same of m_a [kg/m²]."""


NO_STATES = States((), (), 0.0, 0.0, math.nan, math.nan)


def _states(case: Case, kept: Sequence[Read]) -> States:
    """States of the cells of all runs; cells are beds of their own, so each is a sample."""
    cells = [cell for one in kept for cell in one.cells]
    means = np.array([cell.damping for cell in cells])
    masses = np.array([cell.apparent_mass for cell in cells])
    errors = np.array([cell.error for cell in cells])
    found = [np.arange(len(cells))]
    if case.state_cycles:
        found = states.states_of(means, errors)
    return States(
        tuple(float(means[state].mean()) for state in found),
        tuple(len(state) / len(cells) for state in found),
        states.farthest(means, found),
        states.farthest(masses, found),
        float(means.mean()),
        float(masses.mean()),
    )


def _combined(seeds: Sequence[cycles.Estimate]) -> tuple[float, float]:
    return cycles.combine(*np.array([[one.mean, one.error] for one in seeds]).T)


def _energies(balances: Sequence[MeasuredBalance | None]) -> dict[str, float]:
    """Worst closure of the seeds and shares of the loss, all seeds together."""
    known = [balance for balance in balances if balance is not None]
    normal, tangential, rolling, walls = (
        sum(getattr(balance.energies, key) for balance in known for key in keys)
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
        "closure": max((balance.closure for balance in known), key=abs, default=math.nan),
        "normal_share": share(normal),
        "tangential_share": share(tangential),
        "wall_share": share(walls),
    }


def write_table(cases: Sequence[Case], folder: Path, file: Path, *, coverage: float) -> None:
    """Write ``cases.csv``.

    Parameters
    ----------
    cases
        Of the study.
    folder
        ``results/coupon``.
    file
        The table.
    coverage
        Share of the cases that must be ok [1].

    Raises
    ------
    CoverageMissed
        After the table was written, with each case that is not ok.
    """
    scatter = packing_scatter(cases, folder)
    table = [
        summarise(case, case.outcomes(folder), own)
        for case, own in zip(cases, scatter, strict=True)
    ]
    write_cases(table, file)
    check_coverage(table, coverage)


def check_coverage(table: Sequence[Row], coverage: float) -> None:
    """Refuse a table of which too few cases are ok.

    Raises
    ------
    CoverageMissed
        With each case that is not ok.
    """
    bad = [row for row in table if row["status"] != OK]
    good = (len(table) - len(bad)) / len(table)
    if good < coverage:
        lines = [f"{row['case']}: {row['status']}: {row['message']}" for row in bad]
        raise CoverageMissed(
            "\n".join(
                [
                    *lines,
                    f"{good:.1%} of the cases are ok; coupon.accuracy.coverage requires "
                    f"{coverage:.1%}",
                ]
            )
        )


def write_cases(table: Sequence[Row], file: Path) -> None:
    """Rows of `summarise` as ``cases.csv``: seven digits, nothing where a number is unknown."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({key: _cell(value) for key, value in row.items()} for row in table)


def _listed(values: Sequence[float]) -> str:
    """Values of the states, nothing of a single one: it is the case itself."""
    return " ".join(f"{value:.4g}" for value in values) if len(values) > 1 else ""


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.7g}"
    return str(value)
