"""What a study answers: its scenarios against the bare panel, and which differ significantly.

Two reductions differ significantly where their difference exceeds `SIGNIFICANCE` of its standard
errors. Errors of scenarios are combined as independent. Errors from one surface are correlated, so
the true error of a difference is smaller.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import pandas as pd

from pidpanel.report.names import SAME_LEVEL, Scenario, Study, main_level
from pidpanel.report.rms import moving_points
from pidpanel.report.text import DECIBEL_DECIMALS, common_decimals, records
from pidpanel.response.trust import BETWEEN_SHARE, MAY_CROSS, SIGNIFICANCE, doubts_in, largest

ROWS = 5  # most scenarios in the first table, besides the bare panel
COLUMNS = 4  # points with a column of their own in that table, those of most motion


class PointResponse(NamedTuple):
    """Acceleration of a scenario at a point."""

    rms: float  # [g]
    rms_error: float  # [g]; NaN where no error is known
    reduction: float  # against the bare panel [dB]
    reduction_error: float  # [dB]
    dead_weight: float = math.nan  # reduction by the same mass without damping [dB]; NaN if unknown
    model_error: float = 0.0  # part of reduction_error that all scenarios have in common [dB]


class Candidate(NamedTuple):
    """A scenario that might be chosen."""

    scenario: Scenario
    mass: float  # of its dampers [kg]; NaN if unknown
    share: float  # of the panel, in percent
    responses: dict[str, PointResponse]  # by point; empty without a steady response
    doubts: tuple[str, ...]  # why its numbers are not to be trusted
    note: str = ""  # on numbers that are
    # What other damping models say of it: names of their dampers, and responses at the worst point
    alternatives: tuple[tuple[str, PointResponse], ...] = ()


@dataclass(frozen=True)
class StudyAnswer:
    """The bare panel and all scenarios at one level, each with the model that answers first."""

    models: tuple[str, ...]  # titles of the damping models
    is_coupled: bool  # whether panel and particles are in one time integration
    oaspl: float  # [dB]
    points: tuple[str, ...]  # those that move, the largest motion of the bare panel first
    bare: Candidate
    candidates: tuple[Candidate, ...]  # the largest reduction at the worst point first
    lost: tuple[Scenario, ...]  # without a steady response

    @property
    def worst(self) -> str:
        """The point at which the bare panel moves most."""
        return self.points[0]

    @property
    def has_errors(self) -> bool:
        """Whether any scenario has an error."""
        return any(math.isfinite(self.response(c).reduction_error) for c in self.candidates)

    @property
    def best(self) -> tuple[Candidate, ...]:
        """The scenario of largest reduction, then those within its uncertainty.

        All of them where no errors are known.
        """
        responses = [self.response(candidate) for candidate in self.candidates]
        pairs = zip(self.candidates, responses, strict=True)
        return tuple(c for c, r in pairs if r is responses[0] or not are_distinct(responses[0], r))

    @property
    def decimals(self) -> tuple[int | None, int | None]:
        """Decimals of g rms and of reductions, in the headline and in the first table."""
        listed = (self.bare, *select_candidates(self))
        errors = [c.responses[p].rms_error for c in listed for p in self.points[:COLUMNS]]
        gain_errors = [self.response(c).reduction_error for c in listed]
        return common_decimals(errors), common_decimals(gain_errors, DECIBEL_DECIMALS)

    def response(self, candidate: Candidate) -> PointResponse:
        """Return the acceleration of a scenario at the worst point."""
        return candidate.responses[self.worst]


def are_distinct(a: PointResponse, b: PointResponse) -> bool:
    """Return whether two reductions differ by more than their errors; never without errors.

    The error of the damping model is common to both, so only its difference is included.

    Examples
    --------
    >>> one, other = (PointResponse(20.0, 0.5, db, 0.2) for db in (3.0, 2.9))
    >>> are_distinct(one, other)
    False
    """
    variance = sum(r.reduction_error**2 - r.model_error**2 for r in (a, b))
    error = math.sqrt(max(variance, 0.0) + (a.model_error - b.model_error) ** 2)
    # a comparison with NaN is false
    return abs(a.reduction - b.reduction) > SIGNIFICANCE * error


def is_gain(response: PointResponse) -> bool | None:
    """Return whether a reduction is more than its error; None without an error."""
    if not math.isfinite(response.reduction_error):
        return None
    return response.reduction > SIGNIFICANCE * response.reduction_error


def answer_of(study: Study, summary: pd.DataFrame) -> StudyAnswer | None:
    """Return what a study answers at its `main_level`."""
    level, all_scenarios = main_level(study), study.all_scenarios()
    by_key = {(row["scenario"], row["point"]): row for row in records(summary)}
    points = moving_points(summary, list(study.panel.points))
    if not points:
        return None
    (bare,) = (s for s in all_scenarios if s.oaspl_db == level and s.is_bare)
    points.sort(key=lambda point: -by_key[bare.label, point]["acceleration_rms_g"])
    levels = {s.label: float(by_key[s.label, points[0]]["oaspl_db"]) for s in all_scenarios}
    near = [s for s in all_scenarios if abs(levels[s.label] - levels[bare.label]) < SAME_LEVEL]
    scenarios = [s for s in near if not s.is_bare and study.is_main(s)]
    steady = [s for s in scenarios if by_key[s.label, points[0]]["status"] == "ok"]
    candidates = []
    for scenario in steady:
        rows = [by_key[scenario.label, point] for point in points]
        alternatives = {s.dampers: by_key[s.label, points[0]] for s in study.alternatives(scenario)}
        responses = [
            (n, _response(row)) for n, row in alternatives.items() if row["status"] == "ok"
        ]
        candidates.append(_candidate(scenario, rows)._replace(alternatives=tuple(responses)))
    candidates.sort(key=lambda candidate: -candidate.responses[points[0]].reduction)
    bare_rows = [by_key[bare.label, point] for point in points]
    return StudyAnswer(
        models=tuple(dict.fromkeys(text.title for s in scenarios for text in study.model_texts(s))),
        is_coupled=bool(scenarios) and all(map(study.is_coupled_scenario, scenarios)),
        oaspl=levels[bare.label],
        points=tuple(points),
        bare=_candidate(bare, bare_rows),
        candidates=tuple(candidates),
        lost=tuple(s for s in scenarios if s not in steady),
    )


def _response(row: Mapping[str, Any]) -> PointResponse:
    return PointResponse(
        row["acceleration_rms_g"],
        row.get("acceleration_rms_error_g", math.nan),
        row["reduction_db"],
        row.get("reduction_error_db", math.nan),
        row["dead_weight_reduction_db"],
        row.get("model_error_db", 0.0),
    )


def _candidate(scenario: Scenario, rows: Sequence[dict[str, Any]]) -> Candidate:
    responses = {str(row["point"]): _response(row) for row in rows}
    mass, share = (rows[0][f"added_mass_{unit}"] for unit in ("kg", "percent"))
    note = MAY_CROSS if largest(rows, "between_share") > BETWEEN_SHARE else ""
    return Candidate(scenario, mass, share, responses, doubts_in(rows[0]), note)


def select_candidates(answer: StudyAnswer) -> list[Candidate]:
    """Return the scenarios of the first table: the best of each place and damper, then the rest."""
    groups: dict[object, int] = {}
    order = []
    for rank, candidate in enumerate(answer.candidates):
        key = tuple((p, f.damper) for p, f in candidate.scenario.fillings.items())
        groups[key] = groups.get(key, -1) + 1
        order.append((groups[key], rank))
    chosen = sorted(rank for _, rank in sorted(order)[:ROWS])
    return [answer.candidates[rank] for rank in chosen]
