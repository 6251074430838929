"""The answer of a study in words: a sentence, and what a reader must know before he uses it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.coupled import COUPLED
from pidpanel.report.answer import (
    Candidate,
    PointResponse,
    StudyAnswer,
    are_apart,
    is_gain,
)
from pidpanel.report.inputs import Inputs, ReportedStudy
from pidpanel.report.radiation_section import SIDES, compared
from pidpanel.report.scenario_list import list_scenarios
from pidpanel.report.text import (
    READINGS,
    common_decimals,
    number,
    percent,
    plain,
    value_text,
    with_error,
)
from pidpanel.response.trust import (
    CARRIED,
    EXTRAPOLATED,
    KNOWN_TO,
    LARGEST_ERROR,
    NO_ERROR,
    NOT_LINEAR,
)
from pidpanel.solve.bands import reduction

NOTHING_MOVES = "All response points lie on supports and do not move, so there is no result."

BETWEEN_POINTS = 1.12
"""Times the worst point, 1 dB: more anywhere else on the panel is said."""

CAVEATS = 3
"""Caveats at the head of a page."""


def headline(answer: StudyAnswer) -> str:
    """Return the result in a sentence or two: what, how heavy, from where to where, how sure."""
    return _result(answer) + _untrusted(answer)


def _untrusted(answer: StudyAnswer) -> str:
    """Say why the result is not to be trusted, where none of its numbers is."""
    candidates = answer.best or (answer.bare,)
    # errors stand beside the numbers
    doubts = [[d for d in c.doubts if not d.startswith((NO_ERROR, KNOWN_TO))] for c in candidates]
    return f" Caution: {', '.join(doubts[0])}." if all(doubts) else ""


def _result(answer: StudyAnswer) -> str:
    bare = answer.bare.responses[answer.worst].rms
    if not answer.candidates:
        text = f"Bare panel: {number(bare)} g rms ({number(3 * bare)} g at 3σ) at point "
        text += f"{answer.worst}, the worst response point, under {round(answer.oaspl, 1):g} dB."
        if answer.lost:
            text += " No damper of the study gives a steady response."
        return text
    best = answer.best
    responses = [answer.response(c) for c in best]
    change = f"{number(bare)} → {_range(responses)} g rms at point "
    change += f"{answer.worst}, the worst response point ({_decibels(responses)})"
    result = f"{list_scenarios(best, answer.candidates)}{_mass(best)}: {change}"
    if not answer.has_errors:
        return f"{result}. The damping has no stated error, so scenarios are not ranked."
    gains = [is_gain(response) for response in responses]
    if not any(gains):
        return f"{result}: no reduction beyond its error."
    if len(best) > 1:
        tie = "the difference is within the uncertainty"
        return f"{result}; {tie}.{_new_worst_point(answer, best[0])}"
    if len(answer.candidates) == 1:
        return f"{result}.{_new_worst_point(answer, best[0])}"
    second = answer.candidates[1]
    if not are_apart(responses[0], answer.response(second)):
        return f"{result}.{_new_worst_point(answer, best[0])}"
    return (
        f"{result}. Next is {list_scenarios([second], answer.candidates)}{_mass([second])}, "
        f"{_decibels([answer.response(second)])}.{_new_worst_point(answer, best[0])}"
    )


def _new_worst_point(answer: StudyAnswer, candidate: Candidate) -> str:
    """Say which point moves most with a damper, where it is another one, beyond errors."""
    point = max(candidate.responses, key=lambda point: candidate.responses[point].rms)
    if point == answer.worst:
        return ""
    high, response = candidate.responses[point], answer.response(candidate)
    error = math.hypot(high.rms_error, response.rms_error)
    if not high.rms - response.rms > 2 * error:
        return ""
    return (
        f" The worst response point is then {point}, with "
        f"{with_error(high.rms, high.rms_error)} g rms."
    )


def _range(responses: Sequence[PointResponse]) -> str:
    if len(responses) == 1:
        return value_text(responses[0].rms, responses[0].rms_error)
    low, high = (number(f(r.rms for r in responses)) for f in (min, max))
    return low if low == high else f"{low}–{high}"


def _decibels(responses: Sequence[PointResponse]) -> str:
    """Return changes in dB, negative where the damper takes, with the largest of their errors."""
    if len(responses) == 1:
        response, decimals = responses[0], None if responses[0].reduction_error > 0 else 1
        return f"{value_text(-response.reduction, response.reduction_error, decimals)} dB"
    errors = [r.reduction_error for r in responses if r.reduction_error > 0]
    decimals = common_decimals(errors)
    decimals = 1 if decimals is None else decimals
    low, high = (-f(r.reduction for r in responses) for f in (min, max))
    text = value_text(high, max(errors, default=math.nan), decimals)
    return f"{plain(low, decimals)} to {text} dB"


def _mass(candidates: Sequence[Candidate]) -> str:
    """Return the mass of dampers in kg and in percent of the panel, where it is known."""
    if not all(math.isfinite(c.mass) for c in candidates):
        return ", mass not known"
    masses, shares = (sorted({number(v(c), 2) for c in candidates}, key=_value) for v in _MASS)

    def span(texts: Sequence[str]) -> str:
        return texts[0] if len(texts) == 1 else f"{texts[0]}–{texts[-1]}"

    return f", {span(masses)} kg, {span(shares)} % of the panel"


_MASS = (lambda c: c.mass, lambda c: c.share)


def _value(text: str) -> float:
    return float(text.replace("−", "-"))


def caveats(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Return what a reader must know before he uses the answer, a line each, `CAVEATS` at most."""
    sentences = [*_doubts(inputs, answer), *_omissions(inputs, answer)]
    return [sentence for sentence in sentences if sentence][:CAVEATS]


def _doubts(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Lines on scenarios whose response is doubtful."""
    study = inputs.study
    sentences = []
    if answer.lost:
        sentences.append(
            f"{len(answer.lost)} of {len(answer.lost) + len(answer.candidates)} scenarios have no "
            "steady response: their damping is negative."
        )
    doubted = [c for c in (answer.bare, *answer.candidates) if c.doubts]
    linear = [c for c in doubted if NOT_LINEAR in c.doubts]
    if linear:
        good = inputs.summary[inputs.summary["status"] == "ok"]
        rows = good.loc[good["scenario"].isin([c.scenario.label for c in linear])]
        largest = number(rows["displacement_rms_mm"].max(), 2)
        sentences.append(
            f"{_name_scenarios(linear, answer)} move by up to {largest} mm rms, more than a tenth "
            "of the thickness. A real panel stiffens there."
        )
    outside = [c for c in doubted if any(EXTRAPOLATED in doubt for doubt in c.doubts)]
    if outside:
        sentences.append(
            f"{_name_scenarios(outside, answer)}: damping partly extrapolated beyond its data "
            f"({_extrapolated(inputs, outside)})."
        )
    for doubt, text in (
        (CARRIED, "not run; C_e and m_a are interpolated from coupled runs at other levels"),
        (
            KNOWN_TO,
            f"the error of g rms is more than twice the requested {percent(study.coupled_error, 1)}"
            if answer.reading == COUPLED
            else f"the error of g rms is more than {percent(LARGEST_ERROR)}; coupled runs know it "
            "better",
        ),
        (
            "several solutions",
            "damping and motion agree at several accelerations; the highest is shown",
        ),
        ("motion not converged", "the acceleration is not converged"),
        ("basis too small", "the basis is too small for these dampers"),
    ):
        named = [c for c in doubted if any(word.startswith(doubt) for word in c.doubts)]
        if named:
            sentences.append(f"{_name_scenarios(named, answer)}: {text}.")
    return sentences


def _omissions(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Lines on what points, errors, masses, sound and air leave out."""
    sentences = []
    if worst := worst_map(inputs):
        label, rms = worst
        bare = answer.bare.responses[answer.worst].rms
        if label == answer.bare.scenario.label and rms.max() > BETWEEN_POINTS * bare:
            x, y = inputs.basis.vertex_position[int(rms.argmax())]
            sentences.append(
                f"The bare panel moves most at ({x:.2f}, {y:.2f}) m, {number(rms.max())} g "
                "rms. There is no response point there."
            )
    if answer.candidates and not answer.has_errors:
        sentences.append("The damping has no stated error, so neither have the results.")
    if answer.candidates and not all(math.isfinite(c.mass) for c in answer.candidates):
        sentences.append(f"{READINGS[answer.reading]} does not include the mass of the particles.")
    sentences += massless_text(inputs.study)
    if answer.candidates and reads_dem(inputs, answer.reading):
        sentences.append(
            "C_e is measured at single frequencies. Under broadband sound it is lower at high "
            "frequencies, so reductions are overestimated."
        )
    if inputs.radiation is not None and answer.candidates:
        sentences.append(_air(inputs, answer))
    elif inputs.study.radiation == "none" and answer.candidates:
        sentences.append(
            "Radiation damping is not included, so reductions are overestimated "
            "(response.radiation_beside)."
        )
    return sentences


def massless_text(study: ReportedStudy) -> list[str]:
    """Return a sentence for each damper whose particles have no mass in the computation."""
    return [
        f"The particles of {name or 'the table'} have no mass in the computation: its data have no "
        f"apparent mass. With {key} they have their own; resonances are then lower."
        for name, key in study.massless.items()
    ]


def reads_dem(inputs: Inputs, reading: str) -> bool:
    """Return whether a reading rests on coupons that LIGGGHTS shook with single tones."""
    return reading in ("dem", "stated") and bool(inputs.study.surfaces)


def _name_scenarios(some: Sequence[Candidate], answer: StudyAnswer) -> str:
    """Name scenarios, or say how many they are."""
    count = len(answer.candidates) + 1
    if len(some) == count:
        return "All scenarios" if count > 1 else "The bare panel"
    if len(some) == 1:
        return some[0].name[:1].upper() + some[0].name[1:]
    return f"{len(some)} of {count} scenarios"


def _extrapolated(inputs: Inputs, outside: Sequence[Candidate]) -> str:
    """Say of how much of the change in mean square that holds, and how to mend it."""
    labels = [candidate.scenario.label for candidate in outside]
    rows = inputs.summary[inputs.summary["scenario"].isin(labels)]
    worst = rows.iloc[int(rows["extrapolated_share"].argmax())]
    return (
        f"up to {percent(worst['extrapolated_share'])} of the change in mean square; "
        f"extend {worst['data_missing']}"
    )


def _air(inputs: Inputs, answer: StudyAnswer) -> str:
    """Say what the air on one or two sides changes at the worst point."""
    if inputs.radiation is None:
        return ""
    pairs = compared(inputs.summary, inputs.radiation)
    pairs = pairs[(pairs["reading"] == answer.reading) & (pairs["point"] == answer.worst)]
    rows = pairs.set_index("scenario")
    best = answer.candidates[0].scenario.label
    bare = rows.loc[answer.bare.scenario.label]
    if best not in rows.index:
        return ""
    change = float(reduction(bare["acceleration_rms_g_beside"], bare["acceleration_rms_g"]))
    row = rows.loc[best]
    return (
        f"With {SIDES[str(row['radiation'])]} the bare panel changes by {plain(change, 1)} dB "
        f"and {answer.candidates[0].name} reduces it by {row['reduction_db_beside']:.1f} dB "
        f"instead of {row['reduction_db']:.1f} dB."
    )


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


def level_text(inputs: Inputs) -> str:
    """Return the level at which the page answers, where the study has several."""
    levels = {s.oaspl_db for s in inputs.study.scenarios}
    if len(levels) < 2:
        return ""
    level = inputs.study.level
    named = "the level of its spectrum" if level is None else f"{level:g} dB"
    return f" At {named}; other levels are below."
