"""The page of a study on a shaker without sound: which parts it has, in which order."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import pandas as pd

from pidpanel.report.answer_text import massless_text
from pidpanel.report.base_section import base_facts, base_section
from pidpanel.report.facts import damping_facts, panel_facts, software_facts
from pidpanel.report.html import Page
from pidpanel.report.inputs import BaseResults, PanelInputs
from pidpanel.report.panel_section import panel_section
from pidpanel.report.study_page import coupon_sections
from pidpanel.report.text import READINGS, number, percent, value_text
from pidpanel.report.warnings import EQUIVALENT_SINE, SINGLE_TONES, coupon_warnings

SAME_DB = 0.05
"""Reduction below which there is none."""


def shaker_page(inputs: PanelInputs, steps: Sequence[tuple[str, str]]) -> Page:
    """Return the whole page; call it within `style.context`."""
    study, base = inputs.study, inputs.base
    if base is None:
        raise ValueError(f"{study.name}: a page without sound and base motion")
    on_shaker = base_section(base, study.names, study.panel.points, study.panel.thickness_mm)
    answer, *summary = _findings(base, study.names)
    on_panel = panel_section(
        study.panel, inputs.basis, inputs.modes, inputs.section, inputs.printed
    )
    return Page(
        title=study.title,
        answer=answer,
        first=on_shaker.blocks,
        caveats=_caveats(inputs, base),
        facts=[
            *panel_facts(inputs),
            *base_facts(base),
            *damping_facts(inputs),
            *software_facts(inputs),
        ],
        assumptions=study.assumptions,
        summary=summary,
        warnings=[
            line for coupon in inputs.coupons.values() for line in coupon_warnings(coupon.cases)
        ],
        claims=None,
        sections=[
            replace(section, folded=True) for section in (on_panel, *coupon_sections(inputs))
        ],
        steps=steps,
    )


def _findings(base: BaseResults, names: Mapping[str, str]) -> list[str]:
    """Return the result of each motion with each damping model in a sentence."""
    findings = []
    if base.summary is not None:
        rows = base.summary[(base.summary["input"] == "stated") & (base.summary["status"] == "ok")]
        level = f"{rows['input_rms_g'].max():.3g} g rms at the supports"
        findings += _of_motion(rows, ("acceleration_rms_g", "g rms"), level, names)
    if base.peaks is not None and base.sine is not None:
        rows = base.peaks[base.peaks["peak_acceleration_g"].notna()]
        level = f"a sweep of {base.sine.attrs['acceleration_g']:g} g"
        findings += _of_motion(rows, ("peak_acceleration_g", "g"), level, names)
    return findings


def _of_motion(
    rows: pd.DataFrame, quantity: tuple[str, str], level: str, names: Mapping[str, str]
) -> list[str]:
    """Return which layout has the lowest acceleration at the point that is worst on the panel."""
    column, unit = quantity
    error = column.replace("_g", "_error_g")
    findings = []
    for reading, group in rows.groupby("reading", sort=False):
        worst = group.loc[group.groupby("scenario", sort=False)[column].idxmax()]
        worst = worst.set_index("scenario")
        bare, best = worst.iloc[0], worst.loc[worst[column].idxmin()]
        text = f"Under {level}, point {bare['point']} of the bare panel has the largest "
        text += f"acceleration, {number(bare[column])} {unit}"
        others = worst.iloc[1:]
        if len(others):
            gain = 20 * math.log10(bare[column] / best[column])
            value = value_text(best[column], best.get(error, math.nan))
            text += (
                f". {names[str(best.name)]} lowers the largest of any point most, to {value} "
                f"{unit} (−{gain:.1f} dB; {READINGS[str(reading)]})"
                if gain > SAME_DB
                else f", and no layout lowers it ({READINGS[str(reading)]})"
            )
        findings.append(f"{text}.")
    return findings


def _caveats(inputs: PanelInputs, base: BaseResults) -> list[str]:
    """Return what limits the numbers, the most important first."""
    study = inputs.study
    caveats = massless_text(study)
    if base.summary is not None:
        outside = base.summary["outside_run_points_share"].max()
        if outside > 0:
            caveats.append(
                f"Damping is extrapolated on up to {percent(outside)} of the lines of a random "
                "response (‡)."
            )
        unstable = base.summary[base.summary["status"] == "unstable"]
        for row in unstable.drop_duplicates(["reading", "scenario"]).itertuples():
            caveats.append(
                f"{study.names[str(row.scenario)]}: C_e is negative with "
                f"{READINGS[str(row.reading)]}; there is no steady motion."
            )
        if study.surfaces:
            caveats.append(SINGLE_TONES)
        elif study.has_dampers and not study.is_coupled:
            caveats.append(EQUIVALENT_SINE)
    caveats.append("The panel is in vacuum: radiation into the air is not included.")
    return caveats
