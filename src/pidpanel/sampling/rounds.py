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
from pidpanel.response.cases import Scenario, plan_cases
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import PanelInSound
from pidpanel.sampling import choice
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.uncertainty import sensitivity
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
    scenarios: Sequence[Scenario],
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
    onward = Round(before.round + 1, before.cases, len(chosen), tones=tones_so_far)
    return _stating(onward, tones, panel, surface, found)


def _stating(
    one: Round,
    tones: Tones,
    panel: PanelInSound,
    surface: DampingSurface,
    found: Mapping[str, choice.Demand],
) -> Round:
    """Return a round with the errors of the rms accelerations before it."""
    error = np.sqrt(choice.variances(surface, list(found.values())))
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
