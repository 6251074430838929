"""The answer on the page: a table of few rows, the panel, one PSD, reductions against mass."""

import itertools
import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.answer import (
    COLUMNS,
    Candidate,
    PointResponse,
    StudyAnswer,
    is_gain,
    select_candidates,
)
from pidpanel.report.answer_figures import WIDTH as ANSWER_WIDTH
from pidpanel.report.answer_figures import group_of, mass_figure, panel_figure
from pidpanel.report.html import Chart, Fragment, Picture, figure_picture
from pidpanel.report.inputs import Inputs, PanelInputs
from pidpanel.report.names import main_level
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.rms import psd_curve
from pidpanel.report.templates import sentence
from pidpanel.report.text import NAMES, number, span, value_text
from pidpanel.response.trust import NO_ERROR
from pidpanel.structure.from_study import studied

LOAD_ERRORS = "the mesh on which sound loads the surface", "the averages of the cross-spectra"


def answer_fragment(inputs: Inputs, answer: StudyAnswer) -> Fragment:
    """Return the part of a page below its first sentence."""
    study, (mapped, rms) = inputs.study, worst_map(inputs) or (None, None)
    points = answer.points[:COLUMNS]
    listed = (answer.bare, *select_candidates(answer))
    rms_decimals, gain_decimals = answer.decimals
    with_mass = [c for c in answer.candidates if math.isfinite(c.mass) and c.mass > 0]
    psd = psd_picture_of(inputs, answer)
    is_measured = study.acoustics.field_name == "measured"
    bare_error = answer.bare.responses[answer.worst].rms_error
    values = {
        "answer": answer,
        "load_error": LOAD_ERRORS[is_measured] if bare_error > 0 else "",
        "has_levels": len({scenario.oaspl_db for scenario in study.all_scenarios()}) > 1,
        "level": None
        if (level := main_level(study)) is None
        else study.acoustics.level_text(level),
        "remaining": len(answer.candidates) - len(listed) + 1,
        "points": points,
        "rows": [_row(answer, candidate, study.massless_dampers) for candidate in listed],
        "has_others": any(candidate.alternatives for candidate in listed),
        "rms_decimals": rms_decimals,
        "gain_decimals": gain_decimals,
        "panel": panel_picture(inputs, rms),
        "mapped": None if mapped is None else _mapped_name(answer, mapped),
        "psd": psd,
        "has_band": any(curve.log_error is not None for curve in psd.charts[0].curves),
        "masses": mass_picture(answer, with_mass, list(study.panel.patches)) if with_mass else None,
    }
    return Fragment("answer.html", values)


def panel_picture(inputs: PanelInputs, rms: Array | None, caption: str = "") -> Picture:
    """Return the drawing of the panel over a map of rms acceleration (n_vertices,) [g]."""
    panel = studied(inputs.study.panel)
    return figure_picture("panel", panel_figure, inputs.basis, panel, rms, caption=caption)


def _row(answer: StudyAnswer, candidate: Candidate, massless: Collection[str]) -> dict[str, Any]:
    response = answer.response(candidate)
    return {
        "candidate": candidate,
        "response": response,
        "is_bare": candidate.scenario.is_bare,
        "is_massless": any(f.damper in massless for f in candidate.scenario.fillings.values()),
        "per_kg": response.reduction / candidate.mass if candidate.mass > 0 else math.nan,
        "is_within_error": not candidate.scenario.is_bare and is_gain(response) is False,
        "trust": trust_text(candidate.doubts, candidate.note),
        "others": "; ".join(
            f"{name}: {value_text(point.reduction, point.reduction_error, answer.decimals[1])}"
            for name, point in candidate.alternatives
        ),
    }


def trust_text(doubts: Sequence[str], note: str = "") -> str:
    """Return whether results can be trusted, with reasons and what to do about them."""
    remedies = NAMES["remedies"]
    texts = [", ".join([doubt, remedies[doubt]] if doubt in remedies else [doubt])
             for doubt in doubts]  # fmt: skip
    if texts:
        return f"no: {'; '.join(texts)}"
    return f"yes; {remedies[note]}" if note else "yes"


def _mapped_name(answer: StudyAnswer, label: str) -> str:
    names = {c.scenario.label: c.scenario.name for c in (answer.bare, *answer.candidates)}
    return names.get(label, "bare panel" if label.startswith("bare") else label)


def psd_picture_of(inputs: Inputs, answer: StudyAnswer) -> Picture:
    """Return the PSD at the worst point, bare against the best scenario with its band."""
    point, (decimals, _) = answer.worst, answer.decimals
    curve_styles = [(answer.bare, style.BARE, 0.7)]
    curve_styles += [(best, style.PLACES[0], 1.8) for best in answer.candidates[:1]]
    curves = []
    for candidate, colour, width in curve_styles:
        place = {"scenario": candidate.scenario.label, "point": point}
        response = answer.response(candidate)
        rms = value_text(response.rms, response.rms_error, decimals)
        label = f"{candidate.scenario.name}: {rms} g rms"
        has_band = candidate is not answer.bare
        curves.append(psd_curve(inputs.psd, place, label, colour, width, has_band=has_band))
    chart = Chart("", inputs.psd["frequency"].to_numpy(), psd_unit(point), curves)
    return chart_picture("answer", [chart], has_svg=True, width=ANSWER_WIDTH, height=3.7)


def mass_picture(
    answer: StudyAnswer, with_mass: Sequence[Candidate], patches: Sequence[str]
) -> Picture:
    """Return the reduction at the worst point against the mass of the dampers."""
    # layouts and other groups take the remaining colours
    groups = dict.fromkeys([*patches, *(group_of(c) for c in with_mass)])
    colours = dict(zip(groups, itertools.cycle(style.PLACES), strict=False))
    return figure_picture("reduction_mass", mass_figure, answer, with_mass, colours)


NOTHING_MOVES = "All response points lie on supports and do not move, so there is no result."


def headline(answer: StudyAnswer) -> str:
    """Return the result in one or two sentences: damper, mass, reduction, uncertainty."""
    best = answer.best or (answer.bare,)
    rms_decimals, decimals = answer.decimals
    # missing errors are mentioned in the sentence itself
    doubts = [[d for d in c.doubts if not d.startswith(NO_ERROR)] for c in best]
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
            "rms": _rms_text(responses, rms_decimals),
            "change": _change_text(responses, decimals),
            "is_gain": any(map(is_gain, responses)),
            "next": runners_up
            and f"{list_scenarios(runners_up, answer.candidates)}{_mass(runners_up)}, "
            f"{_change_text([answer.response(runners_up[0])], decimals)}",
            "highest": _new_worst_point(answer, answer.best[0]),
        }
    return sentence("headline.html", values)


def _new_worst_point(answer: StudyAnswer, candidate: Candidate) -> tuple[str, float, float] | None:
    """Return the point of largest response if it differs significantly from the worst bare one."""
    point, high = max(candidate.responses.items(), key=lambda item: item[1].rms)
    response = answer.response(candidate)
    error = math.hypot(high.rms_error, response.rms_error)
    return (point, high.rms, high.rms_error) if high.rms - response.rms > 2 * error else None


def _rms_text(responses: Sequence[PointResponse], decimals: int | None) -> str:
    if len(responses) == 1:
        return value_text(responses[0].rms, responses[0].rms_error, decimals)
    values = [response.rms for response in responses]
    return span((value_text(f(values), math.nan, decimals) for f in (min, max)), "–")


def _change_text(responses: Sequence[PointResponse], decimals: int | None) -> str:
    """Return changes in dB, negative for a reduction, with the largest of their errors."""
    if len(responses) == 1:
        response = responses[0]
        return f"{_signed(-response.reduction, response.reduction_error, decimals)} dB"
    errors = [r.reduction_error for r in responses if r.reduction_error > 0]
    low, high = (-f(r.reduction for r in responses) for f in (min, max))
    text = _signed(high, max(errors, default=math.nan), decimals)
    return f"{_signed(low, math.nan, decimals)} to {text} dB"


def _signed(change: float, error: float, decimals: int | None) -> str:
    return "+" * (change > 0) + value_text(change, error, decimals)


def _mass(candidates: Sequence[Candidate]) -> str:
    """Return the mass of dampers in kg and in percent of the panel, if it is known."""
    if not all(math.isfinite(c.mass) for c in candidates):
        return ", mass not known"
    masses, shares = [c.mass for c in candidates], [c.share for c in candidates]
    kg, percent = (span((number(f(v), 2) for f in (min, max)), "–") for v in (masses, shares))
    return f", {kg} kg, {percent} % of the panel"


def worst_map(inputs: Inputs) -> tuple[str, Array] | None:
    """Return scenario and rms acceleration [g] by vertex of the map with the largest response."""
    maps = inputs.maps
    if maps is None or not maps.sizes["case"]:
        return None
    values = maps["acceleration_rms"].to_numpy() / STANDARD_GRAVITY
    if values.shape[1] != len(inputs.basis.vertex_position):
        return None
    worst = int(np.nanmax(values, axis=1).argmax())
    return str(maps["scenario"].to_numpy()[worst]), values[worst]


def list_scenarios(candidates: Sequence[Candidate], among: Sequence[Candidate]) -> str:
    """Return scenarios in few words, with the fills of one place and damper together.

    Three or more fills of a place are written as a range, if no other of ``among`` lies in it.

    Examples
    --------
    >>> from pidpanel.study import Filling, Scenario
    >>> def candidate(patch, fill):
    ...     fillings = {patch: Filling(fill_fraction=fill)}
    ...     scenario = Scenario(label=f"{patch}{fill}", fillings=fillings)
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
        fill = candidate.scenario.fill_fraction
        if len(fillings) == 1 and math.isfinite(fill):
            patch, *dampers = candidate.scenario.place(*fillings)
            key = patch + "".join(f" ({damper})" for damper in dampers)
            fills.setdefault(key, []).append(fill)
        else:
            scenario = candidate.scenario
            fills.setdefault(scenario.layout_label if len(fillings) > 1 else scenario.name, [])
    return fills
