"""The results of a study in sentences, beside the answer: every comparison in every reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import pandas as pd

from pidpanel.report.answer import AtPoint, Candidate, alike, candidates_of, is_gain
from pidpanel.report.rms import moving_points
from pidpanel.report.scenario_list import together
from pidpanel.report.text import READINGS, number, value_text
from pidpanel.study import Study


def outcome(study: Study, summary: pd.DataFrame) -> list[str]:
    """Return the results, one sentence for each family and reading, and one for the layouts.

    Parameters
    ----------
    study
        The study.
    summary
        ``response/summary.csv`` (points as text).

    Notes
    -----
    A family without a steady response in a reading is left out; the warnings name it. One scenario
    is called better than another only where their reductions differ by more than their errors.
    """
    sentences = []
    points = moving_points(summary, list(study.panel.points))
    layouts = [study.family_scenarios(name)[0] for name in study.layouts]
    compared = {study.families[name].title or f"Scenarios {name}": name for name in study.families}
    for reading, (title, name) in product(study.readings, compared.items()):
        scenarios = study.family_scenarios(name)
        found = candidates_of(summary, reading, scenarios, points)
        if points and len(found) == len(scenarios):
            rows = _levels if study.families[name].varied == "oaspl_db" else _ranked
            said = "; ".join(rows(found, point) for point in points)
            sentences.append(f"{title} ({READINGS[reading]}): {said}.")
    for reading in study.readings:
        found = candidates_of(summary, reading, layouts, points)
        if found:
            said = "; ".join(_ranked(found, point) for point in points)
            sentences.append(f"Layouts ({READINGS[reading]}): {said}.")
    return sentences


def _ranked(candidates: Sequence[Candidate], point: str) -> str:
    """Return which of some scenarios reduce most at a point, or that it cannot be told."""
    ranked = sorted(candidates, key=lambda one: -one.at[point].reduction)
    at = [one.at[point] for one in ranked]
    if not all(math.isfinite(one.reduction_error) for one in at):
        bare = [replace(one, reduction_error=math.nan) for one in at]
        return f"at {point} reductions of {_span(bare)}, without a stated error"
    if not any(is_gain(one) for one in at):
        return f"at {point} no reduction exceeds its error ({_span(at)})"
    best = alike(ranked, at)
    named = together(best, ranked)
    if len(best) == len(ranked) > 1:
        return f"at {point} {named} agree within the uncertainty ({_span(at)})"
    if len(best) > 1:
        return (
            f"at {point} most with {named}, which agree within the uncertainty "
            f"({_span(at[: len(best)])})"
        )
    return f"at {point} most with {named} ({_one(ranked[0], point)})"


def _levels(candidates: Sequence[Candidate], point: str) -> str:
    """Return the reductions at the lowest and the highest level."""
    ends = sorted(candidates, key=lambda one: one.scenario.oaspl_db or 0.0)
    low, high = ends[0], ends[-1]
    levels = [
        "the level of the spectrum"
        if one.scenario.oaspl_db is None
        else f"{one.scenario.oaspl_db:g} dB"
        for one in (low, high)
    ]
    said = [
        value_text(one.at[point].reduction, one.at[point].reduction_error) for one in (low, high)
    ]
    return f"at {point} {said[0]} dB under {levels[0]}, {said[1]} dB under {levels[1]}"


def _span(at: Sequence[AtPoint]) -> str:
    values = [one.reduction for one in at]
    if len(values) == 1:
        return f"{value_text(values[0], at[0].reduction_error)} dB"
    errors = [one.reduction_error for one in at if math.isfinite(one.reduction_error)]
    error = f" ± {max(errors):.2f}" if errors else ""
    return f"{value_text(min(values), math.nan, decimals=2)} to " + (
        f"{value_text(max(values), math.nan, decimals=2)}{error} dB"
    )


def _one(candidate: Candidate, point: str) -> str:
    at = candidate.at[point]
    said = f"{value_text(at.reduction, at.reduction_error)} dB"
    if math.isfinite(candidate.mass):
        said += f" with {number(candidate.mass, 2)} kg"
    if math.isfinite(at.dead_weight):
        said += f"; {at.dead_weight:.1f} dB as dead weight".replace("-", "−")
    return said
