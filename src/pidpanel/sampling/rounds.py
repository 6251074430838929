"""The rounds of a target or of tones: which cases to run next, or that there are enough.

Round 0 of a target spreads cases over the sweep, that of tones has all of it. Each further one
computes the responses of the panel with the cases before it, and chooses those that narrow its rms
accelerations most (`sampling.choice`): a target from the sweep, tones at the fills and motions of
the scenarios themselves, where C_e along each of them counts too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.cases import Case
from pidpanel.coupon.round import Round
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES
from pidpanel.response.cases import Scenario, plan_cases
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import PanelInSound
from pidpanel.sampling import choice
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.uncertainty import sensitivity
from pidpanel.study.damping import Target, Tones


def first_round(target: Target, pool: Sequence[Case]) -> Round:
    """Return round 0: cases spread over the sweep."""
    chosen = choice.spread(points_of(pool), target.start)
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
    scenarios: Sequence[Scenario],
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
    panel, scenarios
        The panel in its sound, and the scenarios of the study.
    surface
        Of the cases chosen so far.
    """
    found = _wanted(panel, scenarios, surface)
    wanted = list(found.values())
    run = set(before.cases)
    left = [case for case in pool if case.label not in run]
    room = max(0, min(target.batch, target.max_cases - len(before.cases)))
    chosen = choice.next_cases(
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
    scenarios: Sequence[Scenario],
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
    panel, scenarios
        The panel in its sound, and the scenarios of the study.
    surface
        Of the cases run so far.
    """
    found = _wanted(panel, scenarios, surface)
    pool, wanted = [], []
    scale = tones.relative_error / tones.damping_error
    for one in choice.distinct(list(found.values())):
        points, node = choice.slice_points(surface, one, fastest)
        pool.append(points)
        wanted.append(choice.with_damping_along(one, node, scale))
    points = np.unique(np.concatenate(pool), axis=0)
    run = {*before.tones, *map(tuple, surface.cases[list(AXES)].to_numpy().tolist())}
    left = np.array([p for p in points.tolist() if tuple(p) not in run]).reshape(-1, 3)
    room = max(0, min(tones.batch, tones.most - len(before.tones)))
    chosen = choice.next_cases(surface, wanted, left, case_error, tones.relative_error, room)
    more = tuple((float(r), float(f), float(gamma)) for r, f, gamma in left[chosen])
    tones_so_far = (*before.tones, *more)
    onward = Round(before.round + 1, before.cases, len(chosen), tones=tones_so_far, of="tones")
    return _stating(onward, tones, panel, surface, found)


def _stating(
    one: Round,
    target: Target | Tones,
    panel: PanelInSound,
    surface: DampingSurface,
    found: Mapping[str, choice.Demand],
) -> Round:
    """Return a round with the errors of the rms accelerations before it."""
    error = np.sqrt(choice.variances(surface, list(found.values())))
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


def _wanted(
    panel: PanelInSound, scenarios: Sequence[Scenario], surface: DampingSurface
) -> dict[str, choice.Demand]:
    """Of every scenario with a damper by its label, how its rms values follow the surface."""
    models = DampingModels(["dem"], {"dem": surface}, {})
    plan = plan_cases(panel, scenarios, models, dead_weight=False)
    wanted = {}
    for case in plan.solved(panel.solver(rms_only=True)):
        if not case.dampers or isinstance(case.response, UnstableDamping):
            continue
        derivative = sensitivity(case.solver, case.layout, case.response, surface.nodes).log_rms
        (gamma,) = case.response.acceleration_g
        fill = case.scenario.fill_fraction
        wanted[case.scenario.label] = choice.Demand(fill, float(gamma), derivative)
    return wanted
