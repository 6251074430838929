"""What a study answers: its scenarios against the bare panel, and which of them can be told apart.

Two reductions are told apart where they differ by more than `APART` standard errors of their
difference. Errors of scenarios are combined as independent ones; those read from one surface rise
and fall together, so that the error of their difference is smaller than taken here.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from pidpanel.report.inputs import CoupledResults
from pidpanel.report.limits import BASIS_ERROR, MOTION_RESIDUAL
from pidpanel.report.names import scenario_name
from pidpanel.report.rms import moving_points
from pidpanel.report.text import percent, records
from pidpanel.sound.from_study import spectrum_of
from pidpanel.study import Scenario, Study
from pidpanel.study.damping import COUPLED, RANDOM

APART = 2.0
"""Standard errors of a difference beyond which it counts (95 % of a normal distribution)."""

ROWS = 5
"""Scenarios in the first table at most, beside the bare panel."""

SAME_LEVEL = 0.05
"""Difference of two levels below which they are written alike [dB]."""

NOT_LINEAR, EXTRAPOLATED, NO_ERROR = "not linear", "extrapolated", "no stated error"
NOT_AGREED = "motion and damping not agreed"
NEAR_GAP = "particles near to cross their gap"
HEAVY = "particles heavy beside the panel"
CARRIED = "carried from another level"

PREFERRED = (
    "coupled", "random", "random_with_source", "stated", "dem", "table", "paper_corrected",
    "paper_printed", "bare",
)  # fmt: skip
"""Readings of the damping, the one that answers first: what is measured before a law."""


@dataclass(frozen=True)
class AtPoint:
    """Acceleration of a scenario at a point.

    Attributes
    ----------
    rms, rms_error
        Rms acceleration and its standard error [g]; NaN where no error is known.
    reduction, reduction_error
        Reduction against the bare panel and its standard error [dB].
    dead_weight
        Reduction by the same mass without damping [dB]; NaN where the mass is not known.
    """

    rms: float
    rms_error: float
    reduction: float
    reduction_error: float
    dead_weight: float = math.nan


@dataclass(frozen=True)
class Candidate:
    """A scenario that might be chosen.

    Attributes
    ----------
    scenario
        The scenario.
    mass, share
        Mass of its dampers [kg], and in percent of the panel; NaN where it is not known.
    at
        Its acceleration by point; none without a steady response.
    doubts
        Why its numbers are not to be trusted, in a few words each.
    is_coupled
        Whether they are of panel and particles in one time integration.
    """

    scenario: Scenario
    mass: float
    share: float
    at: dict[str, AtPoint]
    doubts: tuple[str, ...]
    is_coupled: bool = False

    @property
    def name(self) -> str:
        """The scenario as a reader knows it."""
        return scenario_name(self.scenario)


@dataclass(frozen=True)
class Answer:
    """The bare panel and all scenarios at one level in one reading.

    Attributes
    ----------
    reading
        The reading.
    oaspl
        Overall level [dB].
    points
        Names of the moving points, that of the largest motion of the bare panel first.
    bare
        The bare panel.
    candidates
        Scenarios with a steady response, the largest reduction at the worst point first.
    lost
        Scenarios without one.
    """

    reading: str
    oaspl: float
    points: tuple[str, ...]
    bare: Candidate
    candidates: tuple[Candidate, ...]
    lost: tuple[Scenario, ...]

    @property
    def worst(self) -> str:
        """The point at which the bare panel moves most."""
        return self.points[0]

    @property
    def is_coupled(self) -> bool:
        """Whether all scenarios are of panel and particles in one time integration."""
        return bool(self.candidates) and all(one.is_coupled for one in self.candidates)

    @property
    def has_errors(self) -> bool:
        """Whether any scenario has an error."""
        return any(math.isfinite(self.of(one).reduction_error) for one in self.candidates)

    @property
    def best(self) -> tuple[Candidate, ...]:
        """The scenarios that cannot be told from the one of largest reduction, itself first.

        All of them where no errors are known: nothing can be told apart then.
        """
        return alike(self.candidates, [self.of(one) for one in self.candidates])

    def of(self, one: Candidate) -> AtPoint:
        """Return the acceleration of a scenario at the worst point."""
        return one.at[self.worst]


def are_apart(a: AtPoint, b: AtPoint) -> bool:
    """Return whether two reductions differ by more than their errors; never without errors.

    Examples
    --------
    >>> one, other = (AtPoint(20.0, 0.5, db, 0.2) for db in (3.0, 2.9))
    >>> are_apart(one, other)
    False
    """
    error = math.hypot(a.reduction_error, b.reduction_error)
    # a comparison with NaN is false
    return abs(a.reduction - b.reduction) > APART * error


def alike(candidates: Sequence[Candidate], at: Sequence[AtPoint]) -> tuple[Candidate, ...]:
    """Return the first of ranked scenarios and all that cannot be told from it."""
    return tuple(
        one
        for one, own in zip(candidates, at, strict=True)
        if own is at[0] or not are_apart(at[0], own)
    )


def is_gain(at: AtPoint) -> bool | None:
    """Return whether a reduction is more than its error; None without an error."""
    if not math.isfinite(at.reduction_error):
        return None
    return at.reduction > APART * at.reduction_error


def answer_of(
    study: Study,
    summary: pd.DataFrame,
    coupled: CoupledResults | None = None,
    not_agreed: Collection[str] = (),
    near_gap: Collection[str] = (),
    heavy: Collection[str] = (),
) -> Answer | None:
    """Return what a study answers in its `main_reading` at its `main_level`.

    Parameters
    ----------
    study
        The study.
    summary
        ``response/summary.csv`` (points as text).
    coupled
        Of the study, where it has coupled runs: they answer for their scenarios.
    not_agreed
        Labels of the scenarios whose rounds at random ended early.
    near_gap
        Labels of those whose particles, driven at random, come near to cross their gap.
    heavy
        Labels of those whose particles, driven at random, are heavy beside the panel.

    Returns
    -------
    Answer or None
        None where no point moves.
    """
    reading = main_reading(study.readings)
    level = main_level(study)
    of = summary[summary["reading"] == reading]
    by_key = {(row["scenario"], row["point"]): row for row in records(of)}
    points = moving_points(of, list(study.panel.points))
    bare = Scenario.bare_at(level)
    if not points:
        return None
    points.sort(key=lambda point: -by_key[bare.label, point]["acceleration_rms_g"])
    scenarios = [s for s in study.all_scenarios() if s.oaspl_db == level and not s.is_bare]
    steady = [s for s in scenarios if by_key[s.label, points[0]]["status"] == "ok"]
    known = candidates_of(of, reading, steady, points)
    doubted = {NOT_AGREED: not_agreed, NEAR_GAP: near_gap, HEAVY: heavy}
    doubted = doubted if reading in RANDOM else {}
    found = [_doubted(one, doubted) for one in known]
    if coupled is not None:
        still = {point: by_key[bare.label, point]["acceleration_rms_g"] for point in points}
        found = [_as_coupled(one, still, coupled.summary) for one in found]
    if reading == COUPLED:
        found = [
            one if one.is_coupled else replace(one, doubts=(*one.doubts, CARRIED)) for one in found
        ]
    found.sort(key=lambda one: -one.at[points[0]].reduction)
    own = [by_key[bare.label, point] for point in points]
    return Answer(
        reading=reading,
        oaspl=float(own[0]["oaspl_db"]),
        points=tuple(points),
        bare=_candidate(bare, own),
        candidates=tuple(found),
        lost=tuple(s for s in scenarios if s not in steady),
    )


def _doubted(one: Candidate, doubted: Mapping[str, Collection[str]]) -> Candidate:
    """Return a scenario with the doubts among whose scenarios it is."""
    own = tuple(doubt for doubt, labels in doubted.items() if one.scenario.label in labels)
    return replace(one, doubts=(*one.doubts, *own))


def _as_coupled(one: Candidate, bare: Mapping[str, float], summary: pd.DataFrame) -> Candidate:
    """Return a scenario as its coupled runs have it, if there are any.

    Parameters
    ----------
    one
        The scenario.
    bare
        Rms acceleration of the bare panel at the points [g].
    summary
        ``coupled/summary.csv`` (points as text).
    """
    of = summary[summary["scenario"] == one.scenario.label].set_index("point")
    if not set(bare) <= set(of.index):
        return one
    at = {}
    for point, bare_rms in bare.items():
        rms, error = float(of["g_rms"][point]), float(of["g_rms_error"][point])
        at[point] = replace(
            one.at[point],
            rms=rms,
            rms_error=error,
            reduction=20 * math.log10(bare_rms / rms),
            reduction_error=20 / math.log(10) * error / rms,
        )
    # what is left of the doubts is of the panel, not of a reading of the damping
    doubts = tuple(doubt for doubt in one.doubts if doubt == NOT_LINEAR)
    return replace(one, at=at, doubts=doubts, is_coupled=True)


def candidates_of(
    summary: pd.DataFrame, reading: str, scenarios: Sequence[Scenario], points: Sequence[str]
) -> list[Candidate]:
    """Return those of some scenarios that have a steady response, in their order.

    Parameters
    ----------
    summary
        ``response/summary.csv`` (points as text).
    reading
        One of its readings.
    scenarios, points
        Scenarios, and moving points.
    """
    of = summary[summary["reading"] == reading]
    by_key = {(row["scenario"], row["point"]): row for row in records(of)}
    rows = [(one, [by_key[one.label, point] for point in points]) for one in scenarios]
    return [_candidate(one, own) for one, own in rows if own and own[0]["status"] == "ok"]


def main_reading(readings: Sequence[str]) -> str:
    """Return the reading that answers: the first of `PREFERRED` that there is."""
    known = [reading for reading in PREFERRED if reading in readings]
    return known[0] if known else readings[0]


def main_level(study: Study) -> float | None:
    """Return the level at which a study answers: its own if dampers are tried there.

    Otherwise that of most scenarios, the highest of several.
    """
    own = study.sound.oaspl_db
    levels = [s.oaspl_db for s in study.all_scenarios() if not s.is_bare] or [own]
    if own in levels:
        return own
    table = spectrum_of(study.sound).oaspl
    for level in levels:
        if level is not None and abs(level - table) < SAME_LEVEL:
            return level
    return max(
        levels, key=lambda level: (levels.count(level), -math.inf if level is None else level)
    )


def _candidate(scenario: Scenario, rows: Sequence[dict[str, Any]]) -> Candidate:
    at = {
        str(row["point"]): AtPoint(
            row["acceleration_rms_g"],
            row.get("acceleration_rms_error_g", math.nan),
            row["reduction_db"],
            row.get("reduction_error_db", math.nan),
            row["dead_weight_reduction_db"],
        )
        for row in rows
    }
    return Candidate(
        scenario,
        rows[0]["added_mass_kg"],
        rows[0]["added_mass_percent"],
        at,
        tuple(doubts(rows, is_bare=scenario.is_bare)),
    )


def doubts(rows: Sequence[dict[str, Any]], *, is_bare: bool) -> list[str]:
    """Return why the numbers of a scenario are not to be trusted; nothing where they are.

    Parameters
    ----------
    rows
        Its rows in ``response/summary.csv``, a moving point each.
    is_bare
        Whether it is the bare panel, whose damping has no error.
    """
    first, said = rows[0], []
    if any(row["beyond_linear_plate"] is True or row["beyond_linear_plate"] == 1 for row in rows):
        said.append(NOT_LINEAR)
    if first["outside_run_points_share"] > 0:
        share = max(first["outside_run_points_share"], 0.01)
        said.append(f"{percent(share)} of lines {EXTRAPOLATED}")
    if first["levels"] > 1:
        said.append("several solutions")
    if first["motion_residual"] > MOTION_RESIDUAL:
        said.append("motion not converged")
    if first.get("basis_error", 0.0) > BASIS_ERROR:
        said.append("basis too small")
    if not is_bare and not math.isfinite(first.get("reduction_error_db", math.nan)):
        said.append(NO_ERROR)
    return said


def shown(answer: Answer, count: int = ROWS) -> list[Candidate]:
    """Return the scenarios of the first table: the best of each place and damper, then the rest.

    Parameters
    ----------
    answer
        The answer.
    count
        How many at most.
    """
    groups: dict[object, int] = {}
    order = []
    for rank, one in enumerate(answer.candidates):
        key = tuple((f.patch, f.damper) for f in one.scenario.fillings)
        groups[key] = groups.get(key, -1) + 1
        order.append((groups[key], rank))
    chosen = sorted(rank for _, rank in sorted(order)[:count])
    return [answer.candidates[rank] for rank in chosen]


def together(candidates: Sequence[Candidate], among: Sequence[Candidate]) -> str:
    """Return scenarios in few words, the fills of one place and damper as one.

    Three fills of a place and more are written as a range, if no other of ``among`` lies in it.

    Examples
    --------
    >>> from pidpanel.study import Filling
    >>> def one(patch, fill):
    ...     filling = Filling(patch=patch, damper=None, fill_fraction=fill)
    ...     return Candidate(Scenario(label=f"{patch}{fill}", fillings=(filling,), oaspl_db=None),
    ...                      1.0, 1.0, {}, ())
    >>> some = [one("A", 0.7), one("A", 0.5), one("A", 0.9), one("B", 0.5)]
    >>> together(some, some)
    'A at r = 0.5 to 0.9, B at r = 0.5'
    >>> together(some, [*some, one("A", 0.6)])
    'A at r = 0.5, 0.7 and 0.9, B at r = 0.5'
    >>> together([one("A", 0.5), one("B", 0.5)], some)
    'A and B at r = 0.5'
    """
    others = _fills([one for one in among if one not in candidates])
    by_fill: dict[str, list[str]] = {}
    for key, values in _fills(candidates).items():
        texts = [f"{value:g}" for value in sorted(values)]
        between = any(min(values) < other < max(values) for other in others.get(key, []))
        if len(texts) > 2 and not between:
            texts = [f"{texts[0]} to {texts[-1]}"]
        by_fill.setdefault(_listed(texts), []).append(key)
    return ", ".join(
        _listed(keys) + (f" at r = {fills}" if fills else "") for fills, keys in by_fill.items()
    )


def _listed(texts: Sequence[str]) -> str:
    """Return some texts with an "and" before the last."""
    *first, last = texts or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _fills(candidates: Sequence[Candidate]) -> dict[str, list[float]]:
    """Return fills by place and damper; none for layouts and for dampers without a fill."""
    fills: dict[str, list[float]] = {}
    for one in candidates:
        fillings = one.scenario.fillings
        if len(fillings) == 1 and fillings[0].fill_fraction is not None:
            damper = fillings[0].damper
            key = fillings[0].patch + ("" if damper in (None, "coupon") else f" ({damper})")
            fills.setdefault(key, []).append(fillings[0].fill_fraction)
        else:
            fills.setdefault(one.scenario.label if len(fillings) > 1 else one.name, [])
    return fills
