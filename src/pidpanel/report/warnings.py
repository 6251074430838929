"""Limitations of the numbers: where the response, the damping and the coupon cannot be trusted.

Every function returns sentences, none where there is nothing to say.
"""

import math
from collections.abc import Iterator, Mapping

import pandas as pd

from pidpanel.constants import ATLAS
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.panel.resolution import ORDER
from pidpanel.paths import SECTION
from pidpanel.report.answer import StudyAnswer, main_reading
from pidpanel.report.answer_text import worst_map
from pidpanel.report.inputs import Inputs, ReportedStudy
from pidpanel.report.text import READINGS, capitalised, number, percent, records
from pidpanel.response import trust
from pidpanel.solve.mesh_error import ALLOWED_DB, ALLOWED_RMS, decibels

NAMED = 3  # scenarios that a warning names

BETWEEN_POINTS = 1.12  # times the worst point, 1 dB: more anywhere else on the panel is said

# What the doubts in ``response/summary.csv`` mean.
DOUBTS = {
    trust.NOT_LINEAR: "the rms displacement, up to {displacement} mm, is more than a tenth of the "
    "panel's thickness. A real panel stiffens there through membrane stress, which is not modelled",
    trust.EXTRAPOLATED: "damping partly extrapolated beyond its data (up to {share} of the change "
    "in mean square; extend {missing})",
    trust.CARRIED: "not run; C_e and m_a are interpolated from coupled runs at other levels",
    trust.KNOWN_TO: "g rms is {known}",
    "several solutions": "damping and motion agree at several accelerations; the highest is shown",
    "motion not converged": "the acceleration for C_e is not converged; the resulting motion "
    "differs from it by up to {residual}",
    "basis too small": "the basis is too small for these dampers; against all elements PSDs are "
    "off by about {basis}",
}

MAY_CROSS = (
    "beds may ride on the floor or cross their gap (W/L from 0.1 to 0.5) at up to {share} of the "
    "change in mean square. The error includes both. damping.readings: [atlas, coupled] simulates "
    "which"
)

SINGLE_TONES = (
    "C_e and m_a are those of single tones with the patch's rms acceleration, Γ = √2 a_rms/g. "
    "Broadband motion is damped less, by 30 % of the effect of the damping on average. The stated "
    "errors contain that."
)

CORRECTED_TONES = (
    "C_e and m_a of the atlas are those of single tones with the patch's rms acceleration, Γ = √2 "
    "a_rms/g; C_e of riding beds is reduced to that under broadband motion. The stated errors "
    "contain what is left of the difference."
)


def study_warnings(inputs: Inputs, answer: StudyAnswer | None) -> list[str]:
    """Return the limitations of a study with a panel, those of the answer first."""
    study, summary = inputs.study, inputs.summary
    main = main_reading(study.readings)
    lines = [*_doubts(study, summary, main)]
    if answer is not None:
        lines += _of_answer(inputs, answer)
    if inputs.base is not None and inputs.base.summary is not None:
        names = {scenario.layout_label: scenario.name for scenario in study.scenarios}
        on_base = inputs.base.summary
        lines += mesh_text(names, on_base[on_base["status"] == "ok"])
    lines += massless_text(study) + support_text(study)
    of_atlas = inputs.layouts["reading"] == ATLAS
    if study.surfaces or inputs.layouts.loc[~of_atlas, "damping_read_at_g"].notna().any():
        lines.append(SINGLE_TONES)
    if of_atlas.any():
        lines.append(CORRECTED_TONES)
    if answer is not None and answer.candidates and study.radiation == "none":
        lines.append(
            "Radiation damping is not included, so reductions are overestimated "
            "(response.radiation)."
        )
    for reading in study.readings:
        if reading != main:
            lines += _doubts(study, summary, reading)
    lines += _of_solution(study, summary)
    for name, coupon in inputs.coupons.items():
        lines += coupon_warnings(coupon.cases, "" if name == SECTION else f" of {name}")
    return lines


def _doubts(study: ReportedStudy, summary: pd.DataFrame, reading: str) -> Iterator[str]:
    rows = summary[summary["reading"] == reading]
    count = rows["scenario"].nunique()

    def names(doubted: pd.DataFrame) -> str:
        labels = list(dict.fromkeys(doubted["scenario"]))
        named = [study.names[label] for label in labels[:NAMED]]
        named += [f"{len(labels) - NAMED} more"] * (len(labels) > NAMED)
        text = "all scenarios" if 1 < count == len(labels) else "; ".join(named)
        if len(study.readings) > 1:
            return f"{READINGS[reading]}, {text}"
        return capitalised(text)

    lost = rows[~rows["status"].isin(["ok", "held"])]
    for status, doubted in lost.groupby("status", sort=False):
        yield f"{names(doubted)}: no steady response ({status})."
    for doubt, text in DOUBTS.items():
        doubted = rows[rows["doubts"].fillna("").str.contains(doubt, regex=False)]
        if doubted.empty:
            continue
        worst = doubted.iloc[int(doubted["extrapolated_share"].argmax())]
        relative = doubted["acceleration_rms_error_g"] / doubted["acceleration_rms_g"]
        known = doubted["doubts"].iloc[int(relative.fillna(0.0).argmax())]
        meaning = text.format(
            displacement=number(doubted["displacement_rms_mm"].max(), 2),
            share=percent(worst["extrapolated_share"]),
            missing=worst["data_missing"],
            known="".join(word for word in known.split(trust.BETWEEN) if doubt in word),
            residual=percent(doubted["motion_residual"].max(), 1),
            basis=percent(doubted["basis_error"].max(), 1),
        )
        yield f"{names(doubted)}: {meaning}."
    between = rows[rows["between_share"] > trust.BETWEEN_SHARE]
    if len(between):
        meaning = MAY_CROSS.format(share=percent(between["between_share"].max()))
        yield f"{names(between)}: {meaning}."


def _of_answer(inputs: Inputs, answer: StudyAnswer) -> Iterator[str]:
    """Yield what the points, the errors and the masses of the answer leave out."""
    if worst := worst_map(inputs):
        label, rms = worst
        bare = answer.bare.responses[answer.worst].rms
        if label == answer.bare.scenario.label and rms.max() > BETWEEN_POINTS * bare:
            x, y = inputs.basis.vertex_position[int(rms.argmax())]
            yield (
                f"The bare panel moves most at ({x:.2f}, {y:.2f}) m, {number(rms.max())} g "
                "rms. There is no response point there."
            )
    if answer.candidates and not answer.has_errors:
        yield "The damping has no stated error, so neither have the results."
    if not all(math.isfinite(c.mass) for c in answer.candidates):
        yield f"{READINGS[answer.reading]} does not include the mass of the particles."


def massless_text(study: ReportedStudy) -> list[str]:
    """Return a sentence for each damper whose particles have no mass in the computation."""
    return [
        f"The particles of {name or 'the table'} have no mass in the computation: its data have no "
        f"apparent mass. With {key} they have their own; resonances are then lower."
        for name, key in study.massless.items()
    ]


def support_text(study: ReportedStudy) -> list[str]:
    """Return a sentence about supports at single points of a panel with core shear."""
    if not study.single_points:
        return []
    names = ", ".join(study.single_points)
    return [
        f"Supports at single points ({names}): frequencies depend on the mesh. State the radius of "
        "their feet (radius_m)."
    ]


def _of_solution(study: ReportedStudy, summary: pd.DataFrame) -> Iterator[str]:
    """Yield where the power or the mesh says that a solution is not right."""
    good = summary[summary["status"] == "ok"]
    balance = good["power_balance_error"].max()
    if balance > trust.POWER_BALANCE:
        yield f"Power input and power loss differ by up to {number(balance, 2)} of the power input."
    yield from mesh_text(study.names, good)


def mesh_text(names: Mapping[str, str], good: pd.DataFrame) -> Iterator[str]:
    """Yield by how much shorter the elements of a mesh must be, where they are too long.

    Parameters
    ----------
    names
        Of the scenarios by label.
    good
        Rows of ``response/summary.csv`` or ``base/summary.csv`` with a response.
    """
    if good["mesh_error"].max() > trust.MESH_ERROR or good["mesh_error_rms"].max() > trust.MESH_RMS:
        largest = records(good.sort_values("mesh_error"))[-1]
        beyond = max(
            decibels(largest["mesh_error"]) / ALLOWED_DB, good["mesh_error_rms"].max() / ALLOWED_RMS
        )
        shorter = math.ceil(10 * beyond ** (1 / ORDER)) / 10
        yield (
            f"The mesh is too coarse: it shifts resonances of {names[largest['scenario']]} "
            f"({READINGS[largest['reading']]}), which changes PSDs by up to "
            f"{number(decibels(largest['mesh_error']), 2)} dB and rms accelerations by up to "
            f"{percent(good['mesh_error_rms'].max(), 1)}. Use element edges {number(shorter, 2)} "
            "times shorter."
        )


def coupon_warnings(cases: pd.DataFrame, suffix: str = "") -> list[str]:
    """Return the cases that are excluded, not steady or less accurate than requested."""
    warnings = []

    def warn(rows: pd.DataFrame, text: str, *, named: bool = True) -> None:
        if len(rows):
            names = f": {', '.join(rows['case'])}" if named else ""
            warnings.append(f"{len(rows)} of {len(cases)} coupon cases{suffix} {text}{names}.")

    for status, rows in cases[cases["status"] != "ok"].groupby("status", sort=True):
        drifts = "did not reach steady state; included with enlarged errors"
        warn(rows, drifts if status in COUNTED else f"excluded ({status})")
    good = cases[cases["status"] == "ok"]
    value, error = good["equivalent_damping_n_s_m3"], good["equivalent_damping_error_n_s_m3"]
    missed = ~good["target_met"].astype(bool)
    largest = (error / value).abs()[missed].max()
    warn(
        good[missed],
        "stopped at max_cycles before reaching the requested accuracy; their relative standard "
        f"errors reach {percent(largest)}",
        named=False,
    )
    excessive = good[good["share_of_bound"] > 1]
    warn(
        excessive,
        "above the bound of a perfectly inelastic bed (up to "
        f"{excessive['share_of_bound'].max():.2f} times the bound)",
    )
    warn(good[value <= error], "with C_e no larger than its own standard error")
    return warnings
