"""The answer of a study in words: a sentence, and what a reader must know before he uses it."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report.answer import Candidate, PointResponse, StudyAnswer, is_gain
from pidpanel.report.inputs import Inputs
from pidpanel.report.templates import sentence
from pidpanel.report.text import number, value_text
from pidpanel.response.trust import NO_ERROR

NOTHING_MOVES = "All response points lie on supports and do not move, so there is no result."


def headline(answer: StudyAnswer) -> str:
    """Return the result in a sentence or two: what, how heavy, from where to where, how sure."""
    weighed = answer.best or (answer.bare,)
    rms_decimals, decimals = answer.decimals
    # the sentence says so itself where there are no errors
    doubts = [[d for d in c.doubts if not d.startswith(NO_ERROR)] for c in weighed]
    values = {
        "answer": answer,
        "bare": answer.bare.responses[answer.worst].rms,
        "rms_decimals": rms_decimals,
        "best": "",
        "doubts": doubts[0] if all(doubts) else [],
    }
    if answer.candidates:
        responses = [answer.response(candidate) for candidate in answer.best]
        runners_up = answer.candidates[1:2]
        values |= {
            "best": f"{list_scenarios(answer.best, answer.candidates)}{_mass(answer.best)}",
            "rms": _range(responses, rms_decimals),
            "change": _decibels(responses, decimals),
            "is_gain": any(map(is_gain, responses)),
            "next": runners_up
            and f"{list_scenarios(runners_up, answer.candidates)}{_mass(runners_up)}, "
            f"{_decibels([answer.response(runners_up[0])], decimals)}",
            "highest": _new_worst_point(answer, answer.best[0]),
        }
    return sentence("headline.html", values)


def _new_worst_point(answer: StudyAnswer, candidate: Candidate) -> tuple[str, float, float] | None:
    """Return the point that moves most with a damper, where it is another one, beyond errors."""
    point, high = max(candidate.responses.items(), key=lambda item: item[1].rms)
    response = answer.response(candidate)
    error = math.hypot(high.rms_error, response.rms_error)
    return (point, high.rms, high.rms_error) if high.rms - response.rms > 2 * error else None


def _range(responses: Sequence[PointResponse], decimals: int | None) -> str:
    if len(responses) == 1:
        return value_text(responses[0].rms, responses[0].rms_error, decimals)
    values = [response.rms for response in responses]
    return _span(value_text(f(values), math.nan, decimals) for f in (min, max))


def _span(texts: Iterable[str]) -> str:
    return "–".join(dict.fromkeys(texts))


def _decibels(responses: Sequence[PointResponse], decimals: int | None) -> str:
    """Return changes in dB, negative where the damper takes, with the largest of their errors."""
    if len(responses) == 1:
        response = responses[0]
        return f"{value_text(-response.reduction, response.reduction_error, decimals)} dB"
    errors = [r.reduction_error for r in responses if r.reduction_error > 0]
    low, high = (-f(r.reduction for r in responses) for f in (min, max))
    text = value_text(high, max(errors, default=math.nan), decimals)
    return f"{value_text(low, math.nan, decimals)} to {text} dB"


def _mass(candidates: Sequence[Candidate]) -> str:
    """Return the mass of dampers in kg and in percent of the panel, where it is known."""
    if not all(math.isfinite(c.mass) for c in candidates):
        return ", mass not known"
    masses, shares = [c.mass for c in candidates], [c.share for c in candidates]
    kg, percent = (_span(number(f(v), 2) for f in (min, max)) for v in (masses, shares))
    return f", {kg} kg, {percent} % of the panel"


def worst_map(inputs: Inputs) -> tuple[str, Array] | None:
    """Return scenario and rms acceleration [g] by vertex of the mapped case of most motion."""
    maps = inputs.maps
    if maps is None or not maps.sizes["case"]:
        return None
    values = maps["acceleration_rms"].to_numpy() / STANDARD_GRAVITY
    if values.shape[1] != len(inputs.basis.vertex_position):
        return None
    worst = int(np.nanmax(values, axis=1).argmax())
    return str(maps["scenario"].to_numpy()[worst]), values[worst]


def list_scenarios(candidates: Sequence[Candidate], among: Sequence[Candidate]) -> str:
    """Return scenarios in few words, the fills of one place and damper as one.

    Three fills of a place and more are written as a range, if no other of ``among`` lies in it.

    Examples
    --------
    >>> from pidpanel.study import Filling, Scenario
    >>> def candidate(patch, fill):
    ...     filling = Filling(patch=patch, damper=None, fill_fraction=fill)
    ...     scenario = Scenario(label=f"{patch}{fill}", fillings=(filling,), oaspl_db=None)
    ...     return Candidate(scenario, 1.0, 1.0, {}, ())
    >>> some = [candidate(*c) for c in (("A", 0.7), ("A", 0.5), ("A", 0.9), ("B", 0.5))]
    >>> list_scenarios(some, some)
    'A at r = 0.5 to 0.9, B at r = 0.5'
    >>> list_scenarios(some, [*some, candidate("A", 0.6)])
    'A at r = 0.5, 0.7 and 0.9, B at r = 0.5'
    >>> list_scenarios([candidate("A", 0.5), candidate("B", 0.5)], some)
    'A and B at r = 0.5'
    """
    rivals = _fills([candidate for candidate in among if candidate not in candidates])
    by_fill: dict[str, list[str]] = {}
    for key, values in _fills(candidates).items():
        texts = [f"{value:g}" for value in sorted(values)]
        overlaps = any(min(values) < rival < max(values) for rival in rivals.get(key, []))
        if len(texts) > 2 and not overlaps:
            texts = [f"{texts[0]} to {texts[-1]}"]
        by_fill.setdefault(_listed(texts), []).append(key)
    return ", ".join(
        _listed(keys) + (f" at r = {fills}" if fills else "") for fills, keys in by_fill.items()
    )


def _listed(texts: Sequence[str]) -> str:
    *first, last = texts or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _fills(candidates: Sequence[Candidate]) -> dict[str, list[float]]:
    """Return fills by place and damper; none for layouts and for dampers without a fill."""
    fills: dict[str, list[float]] = {}
    for candidate in candidates:
        fillings = candidate.scenario.fillings
        if len(fillings) == 1 and fillings[0].fill_fraction is not None:
            patch, *dampers = fillings[0].place
            key = patch + "".join(f" ({damper})" for damper in dampers)
            fills.setdefault(key, []).append(fillings[0].fill_fraction)
        else:
            fills.setdefault(candidate.scenario.label if len(fillings) > 1 else candidate.name, [])
    return fills
