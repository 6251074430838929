"""The results of a study in sentences, beside the answer: every comparison in every reading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import pandas as pd

from pidpanel.report.answer import Candidate, PointResponse, alike, candidates_of, is_gain
from pidpanel.report.inputs import ReportedStudy
from pidpanel.report.rms import moving_points
from pidpanel.report.scenario_list import list_scenarios
from pidpanel.report.text import (
    DECIBEL_DECIMALS,
    READINGS,
    common_decimals,
    number,
    plain,
    value_text,
)


def outcome(study: ReportedStudy, summary: pd.DataFrame) -> list[str]:
    """Return the results, one sentence for each family and reading, and one for the layouts.

    A family without a steady response in a reading is left out; the warnings name it. One scenario
    is called better than another only where their reductions differ by more than their errors.
    """
    sentences = []
    points = moving_points(summary, study.panel.points)
    compared = {f.title or f"Scenarios {name}": f for name, f in study.families.items()}
    for reading, (title, family) in product(study.readings, compared.items()):
        candidates = candidates_of(summary, reading, family.scenarios, points)
        if points and len(candidates) == len(family.scenarios):
            rows = _levels if family.varied == "oaspl_db" else _ranked
            text = "; ".join(rows(candidates, point) for point in points)
            sentences.append(f"{title} ({READINGS[reading]}): {text}.")
    for reading in study.readings:
        candidates = candidates_of(summary, reading, study.layouts, points)
        if candidates:
            text = "; ".join(_ranked(candidates, point) for point in points)
            sentences.append(f"Layouts ({READINGS[reading]}): {text}.")
    return sentences


def _ranked(candidates: Sequence[Candidate], point: str) -> str:
    """Return which of some scenarios reduce most at a point, or that it cannot be told."""
    ranked = sorted(candidates, key=lambda candidate: -candidate.responses[point].reduction)
    responses = [candidate.responses[point] for candidate in ranked]
    if not all(math.isfinite(r.reduction_error) for r in responses):
        bare = [replace(r, reduction_error=math.nan) for r in responses]
        return f"at {point} reductions of {_span(bare)}, without a stated error"
    if not any(is_gain(r) for r in responses):
        return f"at {point} no reduction exceeds its error ({_span(responses)})"
    best = alike(ranked, responses)
    named = list_scenarios(best, ranked)
    if len(best) == len(ranked) > 1:
        return f"at {point} {named} agree within the uncertainty ({_span(responses)})"
    if len(best) > 1:
        return (
            f"at {point} most with {named}, which agree within the uncertainty "
            f"({_span(responses[: len(best)])})"
        )
    return f"at {point} most with {named} ({_reduction_text(ranked[0], point)})"


def _levels(candidates: Sequence[Candidate], point: str) -> str:
    """Return the reductions at the lowest and the highest level."""
    ends = sorted(candidates, key=lambda candidate: candidate.scenario.oaspl_db or 0.0)
    low, high = ends[0], ends[-1]
    levels = [
        "the level of the spectrum"
        if c.scenario.oaspl_db is None
        else f"{c.scenario.oaspl_db:g} dB"
        for c in (low, high)
    ]
    responses = (candidate.responses[point] for candidate in (low, high))
    reductions = [value_text(r.reduction, r.reduction_error) for r in responses]
    return f"at {point} {reductions[0]} dB under {levels[0]}, {reductions[1]} dB under {levels[1]}"


def _span(responses: Sequence[PointResponse]) -> str:
    values = [r.reduction for r in responses]
    if len(values) == 1:
        return f"{value_text(values[0], responses[0].reduction_error)} dB"
    errors = [r.reduction_error for r in responses if math.isfinite(r.reduction_error)]
    decimals = common_decimals(errors)
    decimals = DECIBEL_DECIMALS if decimals is None else decimals
    largest = value_text(max(values), max(errors, default=math.nan), decimals)
    return f"{plain(min(values), decimals)} to {largest} dB"


def _reduction_text(candidate: Candidate, point: str) -> str:
    response = candidate.responses[point]
    text = f"{value_text(response.reduction, response.reduction_error)} dB"
    if math.isfinite(candidate.mass):
        text += f" with {number(candidate.mass, 2)} kg"
    if math.isfinite(response.dead_weight):
        text += f"; {response.dead_weight:.1f} dB as dead weight".replace("-", "−")
    return text
