"""The rounds of tones: which cases to run next, or that there are enough.

Round 0 is the whole sweep. Each further one computes the responses of the panel with the cases
before it, and chooses tones at the fills and motions of the scenarios that reduce the errors most
(`damping.design`): those of the rms accelerations, and of C_e along each scenario.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.coupon.cases import Case
from pidpanel.coupon.from_study import cases_of
from pidpanel.damping import design
from pidpanel.damping.from_study import read_cases, surface_of
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES
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
from pidpanel.study.damping import Tones


def swept_round(pool: Sequence[Case]) -> Round:
    """Return round 0: the whole sweep."""
    return Round(0, tuple(case.label for case in pool), len(pool))


def next_tones(
    before: Round,
    tones: Tones,
    case_error: float,
    fastest: float | None,
    panel: PanelInSound,
    surface: DampingSurface,
) -> Round:
    """Return the round after another.

    Parameters
    ----------
    before
        The round before.
    tones
        Of the study.
    case_error
        Relative standard error of C_e to which a case is run [1].
    fastest
        Largest speed of a case [m/s]; None for any.
    panel
        The panel in its sound.
    surface
        Of the cases run so far.
    """
    found = dict(_wanted(panel, surface))
    pool, wanted = [], []
    scale = tones.relative_error / tones.damping_error
    for one in design.distinct(list(found.values())):
        points, node = design.slice_points(surface, one, fastest)
        pool.append(points)
        wanted.append(design.with_damping_along(one, node, scale))
    points = np.unique(np.concatenate(pool), axis=0)
    run = {*before.tones, *map(tuple, surface.cases[list(AXES)].to_numpy().tolist())}
    left = np.array([p for p in points.tolist() if tuple(p) not in run]).reshape(-1, 3)
    room = max(0, min(tones.batch, tones.most - len(before.tones)))
    chosen = design.next_cases(surface, wanted, left, case_error, tones.relative_error, room)
    more = tuple((float(r), float(f), float(gamma)) for r, f, gamma in left[chosen])
    tones_so_far = (*before.tones, *more)
    onward = Round(before.round + 1, before.cases, len(chosen), tones=tones_so_far)
    return _stating(onward, tones, panel, surface, found)


def _stating(
    one: Round,
    tones: Tones,
    panel: PanelInSound,
    surface: DampingSurface,
    found: Mapping[str, design.Wanted],
) -> Round:
    """Return a round with the errors of the rms accelerations before it."""
    error = np.sqrt(design.variances(surface, list(found.values())))
    points = panel.basis.point_names
    return replace(
        one,
        reached=bool(error.max() <= tones.relative_error),
        largest_relative_error=float(error.max()),
        relative_error={
            label: dict(zip(points, own.round(5).tolist(), strict=True))
            for label, own in zip(found, error, strict=True)
        },
    )


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
    """Write the round of a study's tones that follows another.

    Parameters
    ----------
    study
        With ``damping.tones``.
    files
        Of the stages upstream.
    before, cases
        The round before and the table of its cases; None for round 0.
    output
        ``design/round<n>.json``.

    Raises
    ------
    StudyError
        For a study without tones.
    """
    tones, coupon = study.damping.tones, study.coupon
    if tones is None or coupon is None:
        raise StudyError(f"{study.name}: damping.tones: missing")
    if before is None or cases is None:
        swept_round(cases_of(coupon)).write(output)
        return
    surface = surface_of(coupon, read_cases(cases))
    if not study.response.damper_mass:
        surface = surface.without_mass()
    panel = read_panel_in_sound(study, files, study.response.radiation)
    error, fastest = coupon.accuracy.relative_error, coupon.sweep.max_velocity_m_s
    next_tones(Round.read(before), tones, error, fastest, panel, surface).write(output)
