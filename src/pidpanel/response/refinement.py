"""The basis of a study's responses: checked in every scenario, and widened until it is right."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.response.cases import (
    CasePlan,
    Scenario,
    SolvedCase,
    plan_cases,
    resolving,
)
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import PanelInSound, widened
from pidpanel.solve.basis_error import (
    ALLOWED,
    BasisCheck,
    PatchDampers,
    check_basis,
    joined_shapes,
    lines_to_try,
)
from pidpanel.solve.layout import LayoutResponse
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.sharpness import flanks
from pidpanel.solve.solvers import PanelSolver

ATTEMPTS = 4
"""Bases that are tried: each further one holds what the one before left out."""

SHARP = 5e-3
"""Damping ratio of the sharpest resonance below which lines are tried on flanks too: between
resonances that far apart a shifted one is not seen."""


@dataclass(frozen=True)
class CheckedResponses:
    """Responses with the error of the basis in which they were computed.

    Attributes
    ----------
    panel, solver
        With the basis that was right.
    cases
        Every scenario in every reading.
    basis_error
        (n_cases,) largest relative error of the PSD of a point at the lines tried, of the
        scenario, its bare panel and its dead weight; NaN where there is no response.
    left_out
        (n_free, k) what was added to the basis of the panel stage.
    """

    panel: PanelInSound
    solver: PanelSolver
    cases: Sequence[SolvedCase]
    basis_error: Array
    left_out: Array


def checked_responses(
    panel: PanelInSound,
    plate: StoredPlate,
    scenarios: Sequence[Scenario],
    models: DampingModels,
) -> CheckedResponses:
    """Return every scenario, in a basis whose error is within `basis_error.ALLOWED`.

    Parameters
    ----------
    panel
        With the basis of the panel stage.
    plate
        Its elements.
    scenarios, models
        Of the study.

    Notes
    -----
    After `ATTEMPTS` bases the last is taken as it is; its error says so.
    """
    panel = resolving(panel, plan_cases(panel, scenarios, models, dead_weight=False))
    left_out = np.zeros((plate.shapes.shape[0], 0))
    for attempt in range(ATTEMPTS):
        wider = widened(panel, plate, left_out)
        plan = plan_cases(wider, scenarios, models)
        columns = len(plan.layouts) * len(panel.basis.point_names)
        lines = lines_to_try(
            panel.settings.frequency_range, plate.stiffness.shape[0], columns, attempt
        )
        # the search for the motions is done here, once for all lines
        solver, alone = wider.solver(rms_only=True), plan.response_alone()
        if wider.resolved_ratio < SHARP:
            lines = _with_flanks(lines, wider, solver, alone)
        few = solver.on(lines, wider.deflection_at_points)
        tried = alone.solved(few)
        check, of_case = _check(panel, wider, plate, left_out, tried, lines)
        if not check.left_out.shape[1] or attempt == ATTEMPTS - 1:
            break
        print(
            f"the basis misses up to {check.error.max():.1%} of a PSD; it is widened",
            file=sys.stderr,
        )
        left_out = np.hstack([left_out, check.left_out])
    worst = np.array([check.largest[rows].max() if rows else np.nan for rows in of_case])
    if np.nanmax(worst, initial=0.0) > ALLOWED:
        print(
            f"the basis misses up to {np.nanmax(worst):.1%} of a PSD, more than {ALLOWED:.1%}",
            file=sys.stderr,
        )
    solver = few.on(wider.frequency, wider.motion_at_points)
    return CheckedResponses(wider, solver, plan.solved(solver), worst, left_out)


def _with_flanks(lines: Array, panel: PanelInSound, solver: PanelSolver, plan: CasePlan) -> Array:
    """Return the lines with as many on the flanks of resonances."""
    answers = [
        answer.response.acceleration_psd
        for case in plan.solved(solver)
        for answer in (case.response, case.bare, case.dead_weight)
        if isinstance(answer, LayoutResponse)
    ]
    beside = flanks(solver.panel.frequency, answers, panel.resolved_ratio, len(lines))
    return np.unique(np.concatenate([lines, beside]))


def write_left_out(path: Path, left_out: Array, attributes: dict[str, str]) -> None:
    """Write what was added to the basis of the panel stage (n_free, k)."""
    # NetCDF 3 has no dimension of length 0: the first column is empty
    stored = np.pad(left_out, ((0, 0), (1, 0)))
    variable = (("coordinate", "shape"), stored, {"units": "1"})
    xr.Dataset({"left_out": variable}, attrs=attributes).to_netcdf(path, engine="scipy")


def read_left_out(path: Path) -> Array:
    """Read what `write_left_out` wrote."""
    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset["left_out"].to_numpy().astype(np.float64)[:, 1:]


def _check(
    panel: PanelInSound,
    wider: PanelInSound,
    plate: StoredPlate,
    left_out: Array,
    cases: Sequence[SolvedCase],
    lines: Array,
) -> tuple[BasisCheck, list[list[int]]]:
    """Return the check of all that was solved, and of each case the rows that count for it."""
    rows: dict[int, int] = {}
    answers: list[LayoutResponse] = []

    def row(answer: LayoutResponse | UnstableDamping | None) -> list[int]:
        if answer is None or isinstance(answer, UnstableDamping):
            return []
        if id(answer) not in rows:
            rows[id(answer)] = len(answers)
            answers.append(answer)
        return [rows[id(answer)]]

    of_case = [
        row(case.response) + row(case.bare) + row(case.dead_weight) if row(case.response) else []
        for case in cases
    ]
    shapes = plate.shapes
    if left_out.shape[1]:
        shapes = joined_shapes(panel.basis, plate, left_out).vectors.astype(np.float32)
    check = check_basis(
        wider.basis,
        plate,
        shapes,
        wider.modal,
        wider.excitation,
        panel.sound.force_at,
        panel.settings.damping_ratio,
        panel.cutoff,
        lines,
        [_on_patches(wider, answer) for answer in answers],
    )
    return check, of_case


def _on_patches(panel: PanelInSound, response: LayoutResponse) -> PatchDampers:
    """C_e and m_a of every patch on the lines: of its loads the mean over their areas."""
    area, count = panel.load_area(response), response.response.frequency.size
    values = np.zeros((2, len(panel.basis.patch_names), count))
    patches = panel.carriers[response.loads]
    for load, patch in enumerate(patches.tolist()):
        share = area[load] / area[patches == patch].sum()
        values[0, patch] += share * response.equivalent_damping[load]
        values[1, patch] += share * response.apparent_mass[load]
    return PatchDampers(*values)
