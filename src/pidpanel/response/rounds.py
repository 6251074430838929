"""The rounds of a target or of tones: which cases to run next, or that there are enough.

Round 0 of a target spreads cases over the sweep, that of tones has all of it. Each further one
computes the responses of the panel with the cases before it, and chooses those that narrow its rms
accelerations most (`damping.design`): a target from the sweep, tones at the fills and motions of
the scenarios themselves, where C_e along each of them counts too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
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
from pidpanel.study.damping import Target, Tones


def first_round(target: Target, pool: Sequence[Case]) -> Round:
    """Return round 0: cases spread over the sweep."""
    chosen = design.spread(points_of(pool), target.start)
    return Round(0, tuple(pool[number].label for number in chosen), len(chosen))


def swept_round(pool: Sequence[Case]) -> Round:
    """Return round 0 of tones: the whole sweep."""
    return Round(0, tuple(case.label for case in pool), len(pool), of="tones")


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
    found = dict(_wanted(panel, surface))
    wanted = list(found.values())
    run = set(before.cases)
    left = [case for case in pool if case.label not in run]
    room = max(0, min(target.batch, target.max_cases - len(before.cases)))
    chosen = design.next_cases(
        surface, wanted, points_of(left), case_error, target.relative_error, room
    )
    cases = (*before.cases, *(left[number].label for number in chosen))
    return _stating(Round(before.round + 1, cases, len(chosen)), target, panel, surface, found)


def next_tones(
    before: Round,
    tones: Tones,
    case_error: float,
    fastest: float | None,
    panel: PanelInSound,
    surface: DampingSurface,
) -> Round:
    """Return the round of tones after another.

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
    onward = Round(before.round + 1, before.cases, len(chosen), tones=tones_so_far, of="tones")
    return _stating(onward, tones, panel, surface, found)


def _stating(
    one: Round,
    target: Target | Tones,
    panel: PanelInSound,
    surface: DampingSurface,
    found: Mapping[str, design.Demand],
) -> Round:
    """Return a round with the errors of the rms accelerations before it."""
    error = np.sqrt(design.variances(surface, list(found.values())))
    points = panel.basis.point_names
    return replace(
        one,
        reached=bool(error.max() <= target.relative_error),
        target=target.relative_error,
        largest_relative_error=float(error.max()),
        relative_error={
            label: dict(zip(points, own.round(5).tolist(), strict=True))
            for label, own in zip(found, error, strict=True)
        },
    )


def points_of(cases: Sequence[Case]) -> Array:
    """Return r, f [Hz] and Γ of cases, (n, 3)."""
    rows = [(c.point.fill_fraction, c.point.drive.frequency, c.point.drive.gamma) for c in cases]
    return np.array(rows).reshape(-1, 3)


def _wanted(panel: PanelInSound, surface: DampingSurface) -> Iterator[tuple[str, design.Demand]]:
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
        wanted = design.Demand(case.scenario.fill_fraction, float(gamma), derivative)
        yield case.scenario.label, wanted


def write_round(
    study: Study, files: PanelFiles, before: Path | None, cases: Path | None, output: Path
) -> None:
    """Write the round of a study's target or tones that follows another.

    Parameters
    ----------
    study
        With ``damping.target`` or ``damping.tones``.
    files
        Of the stages upstream.
    before, cases
        The round before and the table of its cases; None for round 0.
    output
        ``design/round<n>.json``.

    Raises
    ------
    StudyError
        For a study without either.
    """
    target, tones, coupon = study.damping.target, study.damping.tones, study.coupon
    if (target is None and tones is None) or coupon is None:
        raise StudyError(f"{study.name}: damping.target or damping.tones: missing")
    pool = cases_of(coupon)
    if before is None or cases is None:
        first = swept_round(pool) if target is None else first_round(target, pool)
        first.write(output)
        return
    surface = surface_of(coupon, read_cases(cases))
    if not study.response.damper_mass:
        surface = surface.without_mass()
    panel = read_panel_in_sound(study, files, study.response.radiation)
    error, last = coupon.accuracy.relative_error, Round.read(before)
    if target is not None:
        found = next_round(last, target, pool, error, panel, surface)
    elif tones is not None:
        found = next_tones(last, tones, error, coupon.sweep.max_velocity_m_s, panel, surface)
    found.write(output)
