"""The rounds of a target: which cases of the sweep to run next, or that it is reached.

Round 0 spreads cases over the sweep. Each further one computes the responses of the panel with
the cases before it, and chooses those that narrow its rms accelerations most (`damping.design`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.cases import Case
from pidpanel.coupon.from_study import cases_of
from pidpanel.damping import design
from pidpanel.damping.from_study import read_cases, surface_of
from pidpanel.damping.surface import DampingSurface
from pidpanel.response import uncertainty
from pidpanel.response.from_study import (
    PanelFiles,
    PanelInSound,
    Readings,
    read_panel_in_sound,
)
from pidpanel.response.model import UnstableDamping
from pidpanel.round import Round
from pidpanel.study import Study, StudyError
from pidpanel.study.damping import Target


def first_round(target: Target, pool: Sequence[Case]) -> Round:
    """Return round 0: cases spread over the sweep."""
    chosen = design.spread(points_of(pool), target.start)
    return Round(0, tuple(pool[number].label for number in chosen), len(chosen))


def next_round(
    before: Round,
    target: Target,
    pool: Sequence[Case],
    case_error: float,
    panel: PanelInSound,
    surface: DampingSurface,
) -> Round:
    """Return the round after another.

    Parameters
    ----------
    before
        The round before.
    target
        The target of the study.
    pool
        All cases of the sweep.
    case_error
        Relative standard error of C_e to which a case is run [1].
    panel
        The panel in its sound.
    surface
        Of the cases chosen so far.
    """
    labels, wanted = [], []
    for label, one in _wanted(panel, surface):
        labels.append(label)
        wanted.append(one)
    error = np.sqrt(design.variances(surface, wanted))
    run = set(before.cases)
    left = [case for case in pool if case.label not in run]
    room = max(0, min(target.batch, target.max_cases - len(before.cases)))
    chosen = design.next_cases(
        surface, wanted, points_of(left), case_error, target.relative_error, room
    )
    points = panel.basis.point_names
    return Round(
        round=before.round + 1,
        cases=(*before.cases, *(left[number].label for number in chosen)),
        new=len(chosen),
        reached=bool(error.max() <= target.relative_error),
        target=target.relative_error,
        largest_relative_error=float(error.max()),
        relative_error={
            label: dict(zip(points, own.round(5).tolist(), strict=True))
            for label, own in zip(labels, error, strict=True)
        },
    )


def points_of(cases: Sequence[Case]) -> Array:
    """Return r, f [Hz] and Γ of cases, (n, 3)."""
    rows = [(c.point.fill_fraction, c.point.drive.frequency, c.point.drive.gamma) for c in cases]
    return np.array(rows).reshape(-1, 3)


def _wanted(panel: PanelInSound, surface: DampingSurface) -> Iterator[tuple[str, design.Wanted]]:
    """Of every scenario with a damper: its label, and how its rms values follow the surface."""
    readings = Readings(["dem"], {"dem": surface}, {})
    for case in panel.responses(panel.solver(rms_only=True), readings, dead_weight=False):
        if not case.filled or isinstance(case.found, UnstableDamping):
            continue
        derivative = uncertainty.sensitivity(
            case.solver,
            case.layout.loads,
            case.found,
            surface.nodes,
            case.pressure_factor,
            own_acceleration=case.layout.own_acceleration,
        ).log_rms
        (gamma,) = case.found.acceleration_g
        wanted = design.Wanted(case.scenario.fill_fraction, float(gamma), derivative)
        yield case.scenario.label, wanted


def write_round(
    study: Study, files: PanelFiles, before: Path | None, cases: Path | None, output: Path
) -> None:
    """Write the round of a study's target that follows another.

    Parameters
    ----------
    study
        With ``damping.target``.
    files
        Of the stages upstream.
    before, cases
        The round before and the table of its cases; None for round 0.
    output
        ``design/round<n>.json``.

    Raises
    ------
    StudyError
        For a study without a target.
    """
    target, coupon = study.damping.target, study.coupon
    if target is None or coupon is None:
        raise StudyError(f"{study.name}: damping.target: missing")
    pool = cases_of(coupon)
    if before is None or cases is None:
        first_round(target, pool).write(output)
        return
    surface = surface_of(coupon, read_cases(cases))
    if not study.response.damper_mass:
        surface = surface.without_mass()
    panel = read_panel_in_sound(study, files, study.response.radiation)
    error = coupon.accuracy.relative_error
    next_round(Round.read(before), target, pool, error, panel, surface).write(output)
