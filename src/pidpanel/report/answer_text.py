"""The answer of a study in words: a sentence, and what a reader must know before he uses it."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report.answer import (
    AtPoint,
    Candidate,
    StudyAnswer,
    are_apart,
    is_gain,
    main_level,
)
from pidpanel.report.inputs import Inputs
from pidpanel.report.radiation_section import SIDES, compared
from pidpanel.report.scenario_list import together
from pidpanel.report.text import READINGS, number, percent, plain, value_text, with_error
from pidpanel.response.trust import CARRIED, EXTRAPOLATED, KNOWN_TO, NO_ERROR, NOT_LINEAR
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
    shown = answer.best or (answer.bare,)
    doubts = [[doubt for doubt in one.doubts if doubt != NO_ERROR] for one in shown]
    return f" Caution: {', '.join(doubts[0])}." if all(doubts) else ""


def _result(answer: StudyAnswer) -> str:
    bare = answer.bare.at[answer.worst].rms
    if not answer.candidates:
        said = f"Bare panel: {number(bare)} g rms ({number(3 * bare)} g at 3σ) at point "
        said += f"{answer.worst}, the worst response point, under {round(answer.oaspl, 1):g} dB."
        if answer.lost:
            said += " No damper of the study gives a steady response."
        return said
    best = answer.best
    first = answer.of(best[0])
    at = f"{number(bare)} → {_range([answer.of(one) for one in best])} g rms at point "
    at += (
        f"{answer.worst}, the worst response point ({_decibels([answer.of(one) for one in best])})"
    )
    what = f"{together(best, answer.candidates)}{_mass(best)}: {at}"
    if not answer.has_errors:
        return f"{what}. The damping has no stated error, so scenarios are not ranked."
    gains = [is_gain(answer.of(one)) for one in best]
    if not any(gains):
        return f"{what}: no reduction beyond its error."
    if len(best) > 1:
        others = "the difference is within the uncertainty"
        return f"{what}; {others}.{_then(answer, best[0])}"
    if len(answer.candidates) == 1:
        return f"{what}.{_then(answer, best[0])}"
    second = answer.candidates[1]
    if not are_apart(first, answer.of(second)):
        return f"{what}.{_then(answer, best[0])}"
    return (
        f"{what}. Next is {together([second], answer.candidates)}{_mass([second])}, "
        f"{_decibels([answer.of(second)])}.{_then(answer, best[0])}"
    )


def _then(answer: StudyAnswer, one: Candidate) -> str:
    """Say which point moves most with a damper, where it is another one, beyond errors."""
    now = max(one.at, key=lambda point: one.at[point].rms)
    if now == answer.worst:
        return ""
    high, own = one.at[now], answer.of(one)
    error = math.hypot(high.rms_error, own.rms_error)
    if not high.rms - own.rms > 2 * error:
        return ""
    return (
        f" The worst response point is then {now}, with "
        f"{with_error(high.rms, high.rms_error)} g rms."
    )


def _range(at: Sequence[AtPoint]) -> str:
    if len(at) == 1:
        return value_text(at[0].rms, at[0].rms_error)
    low, high = (number(f(one.rms for one in at)) for f in (min, max))
    return low if low == high else f"{low}–{high}"


def _decibels(at: Sequence[AtPoint]) -> str:
    """Return changes in dB, negative where the damper takes, with the largest of their errors."""
    if len(at) == 1:
        return f"{value_text(-at[0].reduction, at[0].reduction_error, decimals=1)} dB"
    low, high = (plain(-f(one.reduction for one in at), 1) for f in (min, max))
    errors = [one.reduction_error for one in at if math.isfinite(one.reduction_error)]
    error = f" ± {max(errors):.1f}" if errors and max(errors) >= 0.05 else ""
    return f"{low} to {high}{error} dB"


def _mass(candidates: Sequence[Candidate]) -> str:
    """Return the mass of dampers in kg and in percent of the panel, where it is known."""
    if not all(math.isfinite(one.mass) for one in candidates):
        return ", mass not known"
    masses, shares = (sorted({number(v(one), 2) for one in candidates}, key=_value) for v in _MASS)

    def span(texts: Sequence[str]) -> str:
        return texts[0] if len(texts) == 1 else f"{texts[0]}–{texts[-1]}"

    return f", {span(masses)} kg, {span(shares)} % of the panel"


_MASS = (lambda one: one.mass, lambda one: one.share)


def _value(text: str) -> float:
    return float(text.replace("−", "-"))


def caveats(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Return what a reader must know before he uses the answer, a line each, `CAVEATS` at most."""
    said = [*_doubts(inputs, answer), *_omissions(inputs, answer)]
    return [one for one in said if one][:CAVEATS]


def _doubts(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Lines on scenarios whose response is doubtful."""
    study = inputs.study
    said = []
    if answer.lost:
        said.append(
            f"{len(answer.lost)} of {len(answer.lost) + len(answer.candidates)} scenarios have no "
            "steady response: their damping is negative."
        )
    doubted = [one for one in (answer.bare, *answer.candidates) if one.doubts]
    linear = [one for one in doubted if NOT_LINEAR in one.doubts]
    if linear:
        good = inputs.summary[inputs.summary["status"] == "ok"]
        of = good.loc[good["scenario"].isin([one.scenario.label for one in linear])]
        largest = number(of["displacement_rms_mm"].max(), 2)
        said.append(
            f"{_of(linear, answer)} move by up to {largest} mm rms, more than a tenth of the "
            "thickness. A real panel stiffens there."
        )
    outside = [one for one in doubted if any(EXTRAPOLATED in doubt for doubt in one.doubts)]
    if outside:
        said.append(
            f"{_of(outside, answer)}: damping partly extrapolated beyond its data "
            f"({_extrapolated(inputs, answer)} of the lines)."
        )
    for doubt, text in (
        (CARRIED, "not run; C_e and m_a are interpolated from coupled runs at other levels"),
        (
            KNOWN_TO,
            "the error of g rms is more than twice the requested "
            f"{percent(study.damping.coupled.relative_error, 1)}",
        ),
        (
            "several solutions",
            "damping and motion agree at several accelerations; the highest is shown",
        ),
        ("motion not converged", "the acceleration is not converged"),
        ("basis too small", "the basis is too small for these dampers"),
    ):
        named = [one for one in doubted if any(own.startswith(doubt) for own in one.doubts)]
        if named:
            said.append(f"{_of(named, answer)}: {text}.")
    return said


def _omissions(inputs: Inputs, answer: StudyAnswer) -> list[str]:
    """Lines on what points, errors, masses, sound and air leave out."""
    said = []
    if found := worst_map(inputs):
        label, rms = found
        bare = answer.bare.at[answer.worst].rms
        if label == answer.bare.scenario.label and rms.max() > BETWEEN_POINTS * bare:
            x, y = inputs.basis.vertex_position[int(rms.argmax())]
            said.append(
                f"The bare panel moves most at ({x:.2f}, {y:.2f}) m, {number(rms.max())} g "
                "rms. There is no response point there."
            )
    if answer.candidates and not answer.has_errors:
        said.append("The damping has no stated error, so neither have the results.")
    if answer.candidates and not all(math.isfinite(one.mass) for one in answer.candidates):
        said.append(f"{READINGS[answer.reading]} does not include the mass of the particles.")
    if answer.candidates and reads_dem(inputs, answer.reading):
        said.append(
            "C_e is measured at single frequencies. Under broadband sound it is lower at high "
            "frequencies, so reductions are overestimated."
        )
    if inputs.radiation is not None and answer.candidates:
        said.append(_air(inputs, answer))
    elif inputs.study.response.radiation == "none" and answer.candidates:
        said.append(
            "Radiation damping is not included, so reductions are overestimated "
            "(response.radiation_beside)."
        )
    return said


def reads_dem(inputs: Inputs, reading: str) -> bool:
    """Return whether a reading rests on coupons that LIGGGHTS shook with single tones."""
    return reading in ("dem", "stated") and bool(inputs.study.surfaces)


def _of(some: Sequence[Candidate], answer: StudyAnswer) -> str:
    """Name scenarios, or say how many they are."""
    count = len(answer.candidates) + 1
    if len(some) == count:
        return "All scenarios" if count > 1 else "The bare panel"
    if len(some) == 1:
        return some[0].name[:1].upper() + some[0].name[1:]
    return f"{len(some)} of {count} scenarios"


def _extrapolated(inputs: Inputs, answer: StudyAnswer) -> str:
    of = inputs.summary[inputs.summary["reading"] == answer.reading]
    labels = [one.scenario.label for one in answer.candidates]
    share = of.loc[of["scenario"].isin(labels), "outside_run_points_share"]
    beyond = np.maximum(share[share > 0].to_numpy(), 0.01)
    low, high = percent(beyond.min()), percent(beyond.max())
    return low if low == high else f"{low.removesuffix(' %')} to {high}"


def _air(inputs: Inputs, answer: StudyAnswer) -> str:
    """Say what the air on one or two sides changes at the worst point."""
    if inputs.radiation is None:
        return ""
    both = compared(inputs.summary, inputs.radiation)
    both = both[(both["reading"] == answer.reading) & (both["point"] == answer.worst)]
    by = both.set_index("scenario")
    best = answer.candidates[0].scenario.label
    bare = by.loc[answer.bare.scenario.label]
    if best not in by.index:
        return ""
    change = float(reduction(bare["acceleration_rms_g_beside"], bare["acceleration_rms_g"]))
    one = by.loc[best]
    return (
        f"With {SIDES[str(one['radiation'])]} the bare panel changes by {plain(change, 1)} dB "
        f"and {answer.candidates[0].name} reduces it by {one['reduction_db_beside']:.1f} dB "
        f"instead of {one['reduction_db']:.1f} dB."
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
    levels = {s.oaspl_db for s in inputs.study.all_scenarios()}
    if len(levels) < 2:
        return ""
    level = main_level(inputs.study)
    named = "the level of its spectrum" if level is None else f"{level:g} dB"
    return f" At {named}; other levels are below."
