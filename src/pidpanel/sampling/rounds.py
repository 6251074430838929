"""The rounds of tones: which cases to run next, or that there are enough.

Round 0 is the whole sweep. Each further one computes the responses of the panel with the cases
before it, and chooses tones at the fills and motions of the scenarios that reduce the errors most
(`sampling.choice`): those of the rms accelerations, and of C_e along each scenario.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pidpanel.coupon.cases import Case
from pidpanel.coupon.round import Round
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES
from pidpanel.response.cases import ResponseScenario, plan_cases
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import ResponsePanel
from pidpanel.sampling import choice
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.uncertainty import sensitivity
from pidpanel.study.damping import Tones


def swept_round(pool: Sequence[Case]) -> Round:
    """Return round 0: the whole sweep."""
    return Round(0, tuple(case.label for case in pool), len(pool))


def next_tones(
    last: Round,
    tones: Tones,
    case_error: float,
    fastest: float | None,
    panel: ResponsePanel,
    scenarios: Sequence[ResponseScenario],
    surface: DampingSurface,
) -> Round:
    """Return the round after another."""
    demands = _demands(panel, scenarios, surface)
    pool, along = [], []
    scale = tones.relative_error / tones.damping_error
    for demand in choice.distinct(list(demands.values())):
        points, node = choice.slice_points(surface, demand, fastest)
        pool.append(points)
        along.append(choice.with_damping_along(demand, node, scale))
    points = np.unique(np.concatenate(pool), axis=0)
    run = {*last.tones, *map(tuple, surface.cases[list(AXES)].to_numpy().tolist())}
    left = np.array([p for p in points.tolist() if tuple(p) not in run]).reshape(-1, 3)
    room = max(0, min(tones.batch, tones.most - len(last.tones)))
    chosen = choice.next_cases(surface, along, left, case_error, tones.relative_error, room)
    added = tuple((float(r), float(f), float(gamma)) for r, f, gamma in left[chosen])
    tones_so_far = (*last.tones, *added)
    onward = Round(last.round + 1, last.cases, len(chosen), tones=tones_so_far)
    return _stating(onward, tones, panel, surface, demands)


def _stating(
    onward: Round,
    tones: Tones,
    panel: ResponsePanel,
    surface: DampingSurface,
    demands: Mapping[str, choice.Demand],
) -> Round:
    """Return a round with the errors of the rms accelerations before it."""
    error = np.sqrt(choice.variances(surface, list(demands.values())))
    points = panel.basis.point_names
    return replace(
        onward,
        reached=bool(error.max() <= tones.relative_error),
        largest_relative_error=float(error.max()),
        relative_error={
            label: dict(zip(points, errors.round(5).tolist(), strict=True))
            for label, errors in zip(demands, error, strict=True)
        },
    )


def _demands(
    panel: ResponsePanel, scenarios: Sequence[ResponseScenario], surface: DampingSurface
) -> dict[str, choice.Demand]:
    """Of every scenario with a damper by its label, how its rms values follow the surface."""
    models = DampingModels(["dem"], {"dem": surface}, {})
    plan = plan_cases(panel, scenarios, models, dead_weight=False)
    demands = {}
    for case in plan.solve(panel.solver(rms_only=True)):
        if not case.dampers or isinstance(case.response, UnstableDamping):
            continue
        derivative = sensitivity(case.solver, case.layout, case.response, surface.nodes).log_rms
        (gamma,) = case.response.acceleration_g
        fill = case.scenario.fill_fraction
        demands[case.scenario.label] = choice.Demand(fill, float(gamma), derivative)
    return demands
