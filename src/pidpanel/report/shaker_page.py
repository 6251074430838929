"""The page of a study on a shaker without sound: which parts it has, in which order."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from pidpanel.report.answer_section import panel_picture
from pidpanel.report.base_section import base_section
from pidpanel.report.coupled_section import coupled_section
from pidpanel.report.facts import study_facts
from pidpanel.report.html import CAVEATS, Page, Picture
from pidpanel.report.inputs import BaseResults, PanelInputs
from pidpanel.report.measurement_section import curves_of, measurement_section
from pidpanel.report.optimise_section import optimise_section, proposal_choice, proposal_headline
from pidpanel.report.panel_section import panel_section
from pidpanel.report.study_page import coupon_sections
from pidpanel.report.templates import lines
from pidpanel.report.text import records
from pidpanel.report.warnings import coarse_mesh, doubted_coupons

SAME_DB = 0.05  # reduction below which there is none


def shaker_page(inputs: PanelInputs, steps: Sequence[tuple[str, str]]) -> Page:
    """Return the whole page."""
    study, base, names = inputs.study, inputs.base, inputs.names
    points = list(study.panel.points)
    if base is None:
        raise ValueError(f"{study.name}: a page without sound and base motion")
    on_shaker = base_section(base, names, points, study.panel.section.thickness_mm)
    answer, *summary = _findings(base, names)
    proposed, designs = [], []
    if inputs.proposal is not None:
        answer, summary = proposal_headline(inputs.proposal), [answer, *summary]
        proposed = [optimise_section(inputs.proposal)]
        designs = [proposal_choice(inputs.proposal, inputs.basis)]
    warnings = _warnings(inputs, base)
    on_panel = panel_section(inputs.basis, inputs.modes, inputs.printed)
    # the drawing and the first curves make a row
    cut = [isinstance(block, Picture) for block in on_shaker.blocks].index(True)
    drawing = panel_picture(inputs, None, "The panel.")
    head, tail = on_shaker.blocks[:cut], on_shaker.blocks[cut:]
    sections = [on_panel, *coupon_sections(inputs)]
    if inputs.coupled is not None:
        sections.append(coupled_section(inputs.coupled, names, points))
    if inputs.measurements is not None:
        curves = {"base": curves_of(base)}
        sections.insert(0, measurement_section(inputs.measurements, curves, names))
    return Page(
        title=study.title or study.name,
        answer=answer,
        first=[*designs, *head, drawing, tail[0]],
        caveats=warnings[:CAVEATS],
        facts=study_facts(inputs),
        assumptions=study.assumptions,
        summary=summary,
        warnings=warnings[CAVEATS:],
        sections=[
            *proposed,
            replace(on_shaker, blocks=tail[1:]),
            *(replace(section, folded=True) for section in sections),
        ],
        steps=steps,
    )


def _findings(base: BaseResults, names: Mapping[str, str]) -> list[str]:
    """Return the result of each motion with each damping model in a sentence."""
    results: list[dict[str, Any]] = []
    if base.summary is not None:
        rows = base.summary[(base.summary["input"] == "stated") & (base.summary["status"] == "ok")]
        level = f"{rows['input_rms_g'].max():.3g} g rms at the supports"
        results += _of_motion(rows, ("acceleration_rms_g", "g rms"), level, names)
    if base.peaks is not None and base.sine is not None:
        rows = base.peaks[base.peaks["peak_acceleration_g"].notna()]
        level = f"a sweep of {base.sine.attrs['acceleration_g']:g} g"
        results += _of_motion(rows, ("peak_acceleration_g", "g"), level, names)
    return lines("shaker.html", {"results": results, "same_db": SAME_DB})


def _of_motion(
    rows: pd.DataFrame, quantity: tuple[str, str], level: str, names: Mapping[str, str]
) -> Iterator[dict[str, Any]]:
    """Yield which layout has the lowest acceleration at the point that is worst on the panel."""
    column, unit = quantity
    for reading, group in rows.groupby("reading", sort=False):
        worst = group.loc[group.groupby("scenario", sort=False)[column].idxmax()]
        bare, best = worst.iloc[0], worst.iloc[int(worst[column].argmin())]
        yield {
            "reading": reading,
            "level": level,
            "column": column,
            "unit": unit,
            "bare": dict(bare),
            "best": dict(best),
            "error": best.get(column.replace("_g", "_error_g"), math.nan),
            "several": len(worst) > 1,
            "gain": 20 * math.log10(bare[column] / best[column]),
            "name": names[best["scenario"]],
        }


def _warnings(inputs: PanelInputs, base: BaseResults) -> list[str]:
    """Return what limits the numbers, the most important first."""
    study = inputs.study
    values: dict[str, Any] = {
        "study": study,
        "names": inputs.names,
        "outside": 0.0,
        "unstable": [],
        "panel_mesh": None,
        "has_tones": False,
        "coupons": doubted_coupons(inputs.coupons),
    }
    if base.summary is not None:
        unstable = base.summary[base.summary["status"] == "unstable"]
        values |= {
            "outside": base.summary["outside_run_points_share"].max(),
            "unstable": records(unstable.drop_duplicates(["reading", "scenario"])),
            "panel_mesh": coarse_mesh(inputs.names, base.summary),
            "has_tones": not study.is_coupled
            and (bool(study.scenarios) or inputs.proposal is not None),
        }
    return lines("shaker_warnings.html", values)
