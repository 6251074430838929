"""The pages of studies: which parts they have, in which order."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from pidpanel.damping.laws import paper_corrected
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.paths import SECTION
from pidpanel.progress import with_progress
from pidpanel.report.answer import answer_of
from pidpanel.report.answer_section import NOTHING_MOVES, answer_fragment, headline, panel_picture
from pidpanel.report.base_section import base_section
from pidpanel.report.claims import patch_distance, verdict_table, verdicts
from pidpanel.report.coupled_section import atlas_section, coupled_section
from pidpanel.report.coupon_figures import Law, design_figure, loss_factor_tables
from pidpanel.report.coupon_section import coupon_section, coupon_text
from pidpanel.report.damping_section import damping_section, fitted_law
from pidpanel.report.energy_section import energy_section
from pidpanel.report.facts import cases_text, software_text, study_facts
from pidpanel.report.films import film_picture
from pidpanel.report.html import CAVEATS, Block, Fragment, Page, PageSection, figure_picture
from pidpanel.report.inputs import BaseResults, CouponResults, Inputs, PanelInputs
from pidpanel.report.maps_section import maps_section
from pidpanel.report.margin_section import margin_first, margin_headline, margin_section
from pidpanel.report.margins_section import levels_fragment, margin_lines, margins_section
from pidpanel.report.measured_section import measured_section
from pidpanel.report.measurement_section import curves_of, measurement_section
from pidpanel.report.names import (
    CouponStudy,
    family_of,
    model_title,
    motion_of,
    noun_of,
    with_names,
)
from pidpanel.report.optimise_section import optimise_section, proposal_choice, proposal_headline
from pidpanel.report.panel_section import panel_section
from pidpanel.report.response_section import layouts_section, response_section
from pidpanel.report.severity_section import severity_section
from pidpanel.report.sound_section import sound_section, sound_setting
from pidpanel.report.summary_section import stress_section, summary_section
from pidpanel.report.templates import lines
from pidpanel.report.text import records
from pidpanel.report.varied_section import findings, varied_section
from pidpanel.report.verdict_section import verdict_section
from pidpanel.report.warnings import (
    at_points,
    coupon_warnings,
    doubted_coupons,
    mesh_under_base_motion,
    study_warnings,
)
from pidpanel.structure.from_study import studied

Steps = Sequence[tuple[str, str]]  # (text, command) to reproduce the results


def _page(inputs: PanelInputs, warnings: Sequence[str], steps: Steps, **parts: Any) -> Page:
    """Return a page with what all pages of studies with a panel have."""
    return Page(
        title=inputs.study.title or inputs.study.name,
        caveats=warnings[:CAVEATS],
        warnings=warnings[CAVEATS:],
        facts=study_facts(inputs),
        assumptions=inputs.study.assumptions,
        steps=steps,
        noun=noun_of(inputs.study),
        **parts,
    )


def study_page(inputs: Inputs, steps: Steps) -> Page:
    """Return the whole page."""
    study, proposal = inputs.study, inputs.proposal
    answer = answer_of(study, inputs.summary)
    text = headline(answer) if answer else NOTHING_MOVES
    blocks = [answer_fragment(inputs, answer)] if answer else []
    if study.acoustics.levels and answer:
        blocks.append(levels_fragment(study, inputs.summary, inputs.margins))
    proposed = []
    if proposal is not None:
        text, proposed = proposal_headline(proposal), [optimise_section(proposal)]
        # of the bare panel alone the drawing and the PSD are with each layout
        beside = blocks if answer is not None and answer.candidates else []
        blocks = [proposal_choice(proposal, inputs), *beside]
    if inputs.spread is not None:
        text = margin_headline(inputs.spread, inputs.names)
        proposed.append(margin_section(inputs.spread, inputs.names))
        blocks = [margin_first(inputs.spread, inputs.names), *blocks]
    on_limits = [] if inputs.margins is None else margin_lines(study, inputs.margins)
    if inputs.spread is not None:  # nominal inputs are no answer beside their spread
        on_limits = ["", *(f"Nominal inputs alone: {line}" for line in on_limits)]
    claims = None
    if study.claims:
        distance = patch_distance(inputs.basis)
        claims = verdict_table(list(verdicts(study, inputs.summary, inputs.psd, distance)))
    return _page(
        inputs, study_warnings(inputs, answer), steps,
        answer=" ".join([text, *on_limits[:1]]).strip(), summary=on_limits[1:], first=blocks,
        claims=claims, setting=sound_setting(study, inputs.basis),
        sections=[*proposed, *(replace(s, folded=True) for s in _sections(inputs))],
    )  # fmt: skip


def coupon_sections(inputs: PanelInputs) -> list[PageSection]:
    """Return the parts of all coupons, with a law of the paper if a damper has it."""
    study, sections = inputs.study, []
    used = [getattr(study.dampers[name], "law", None) for name in study.used_dampers]
    paper = Law("the paper's law, corrected (|a₁|, f in Hz)", lambda f, r, _: paper_corrected(f, r))
    for name in with_progress(list(inputs.coupons), "coupons of the page"):
        coupon, results = inputs.coupons[name], inputs.damping.get(name)
        law = paper if "paper_corrected" in used else results and fitted_law(results)
        surface = results.surface if results else None
        parts = [coupon_section(coupon, text=coupon_text(coupon), law=law, surface=surface)]
        if results:
            parts.append(damping_section(results))
        sections += parts if name == SECTION else [s.with_suffix(name) for s in parts]
    return sections


def _sections(inputs: PanelInputs) -> Iterator[PageSection]:
    """Yield the parts of the page in order."""
    study, names, points = inputs.study, inputs.names, list(inputs.study.panel.points)
    sound = inputs if isinstance(inputs, Inputs) else None
    layouts = {scenario.layout_label: scenario.name for scenario in study.all_scenarios()}
    if inputs.measurements is not None:
        curves = {"sound": sound.psd if sound else None, "base": curves_of(inputs.base)}
        curves["hammer"] = inputs.measurements.hammer
        yield measurement_section(inputs.measurements, curves, {**layouts, **names})
    if inputs.margins is not None:
        yield margins_section(study, inputs.margins)
    yield panel_section(inputs.basis, inputs.modes, inputs.printed, study, inputs.in_space)
    if sound:
        yield sound_section(study, sound.bands)
    yield from coupon_sections(inputs)
    if inputs.atlas is not None and sound:
        frequency, is_coupled = study.response.frequency_hz, study.is_coupled
        yield atlas_section(inputs.atlas, sound.layouts, names, frequency, is_coupled=is_coupled)
    if inputs.coupled is not None:
        in_air = sound is not None and study.radiation != "none"
        points = sound.moving_points if sound else points
        yield coupled_section(inputs.coupled, names, points, in_air=in_air)
    if sound:
        yield from _under_sound(sound, points, layouts)


def _under_sound(
    inputs: Inputs, points: Sequence[str], layouts: Mapping[str, str]
) -> Iterator[PageSection]:
    """Yield the parts of the responses to sound, then those of base motion."""
    study, names = inputs.study, inputs.names
    if study.layouts:
        yield layouts_section(inputs)
    for name in with_progress(list(study.families), "families of scenarios of the page"):
        yield response_section(inputs, family_of(study, name))
    if inputs.coupled is not None and inputs.coupled.verdict is not None:
        verdict = with_names(inputs.coupled.verdict, names)
        titles = {s.dampers: model_title(study, s) for s in study.all_scenarios()}
        yield verdict_section(verdict, points, titles)
    if inputs.base is not None:
        yield base_section(
            inputs.base, layouts, points, study.panel.section.thickness_mm, motion_of(study)
        )
    if inputs.maps is not None:
        yield maps_section(inputs.maps, inputs.basis.cell_in_patch, names)
    if inputs.energy is not None:
        yield energy_section(inputs.energy, inputs)
    yield summary_section(study, inputs.summary)
    if len(inputs.stress):
        yield stress_section(with_names(inputs.stress, names))
    if inputs.severity is not None:
        yield severity_section(inputs.severity, inputs)


SAME_DB = 0.05  # reduction below which there is none


def shaker_page(inputs: PanelInputs, steps: Steps) -> Page:
    """Return the whole page."""
    study, base, names = inputs.study, inputs.base, inputs.names
    if base is None:
        raise ValueError(f"{study.name}: a page without sound and base motion")
    thickness = study.panel.section.thickness_mm
    on_shaker = base_section(base, names, list(study.panel.points), thickness, motion_of(study))
    answer, *summary = _findings(base, names)
    proposed, designs = [], []
    if inputs.proposal is not None:
        answer, summary = proposal_headline(inputs.proposal), [answer, *summary]
        proposed = [optimise_section(inputs.proposal)]
        designs = [proposal_choice(inputs.proposal, inputs)]
    if inputs.margins is not None:
        answer = " ".join([answer, *margin_lines(study, inputs.margins)])
    # the drawing and the first curves make a row
    head, curves, sweep_blocks = on_shaker.blocks
    drawing = panel_picture(inputs, None, "The panel.")
    sections = [replace(section, folded=True) for section in _sections(inputs)]
    return _page(
        inputs, _warnings(inputs, base), steps, answer=answer, summary=summary,
        first=[*designs, head, drawing, curves],
        sections=[*proposed, replace(on_shaker, blocks=[sweep_blocks]), *sections],
    )  # fmt: skip


def _findings(base: BaseResults, names: Mapping[str, str]) -> list[str]:
    """Return the result of each motion in a sentence."""
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
    if rows.empty:
        return
    worst = rows.loc[rows.groupby("scenario", sort=False)[column].idxmax()]
    bare, best = worst.iloc[0], worst.iloc[int(worst[column].argmin())]
    yield {
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
        "panel_mesh": mesh_under_base_motion(inputs, inputs.names, base),
        "at_points": {"names": study.panel.single_points},
        "remarks": studied(study.panel).remarks,
        "has_tones": False,
        "coupons": doubted_coupons(inputs.coupons),
    }
    if base.summary is not None:
        unstable = base.summary[base.summary["status"] == "unstable"]
        values |= {
            "outside": base.summary["outside_run_points_share"].max(),
            "unstable": records(unstable.drop_duplicates("scenario")),
            "at_points": at_points(inputs, base.summary),
            "has_tones": not study.is_coupled
            and (bool(study.scenarios) or inputs.proposal is not None),
        }
    return lines("shaker_warnings.html", values)


def coupon_page(
    study: CouponStudy, stamp: Mapping[str, str], coupon: CouponResults, steps: Steps
) -> Page:
    """Return the whole page of a study of the coupon alone, with the stamp of its results."""
    good = coupon.cases[coupon.cases["status"].isin(COUNTED)]
    lost = coupon.cases[~coupon.cases["status"].isin(COUNTED)]
    keys = coupon.varied
    one_by_one = [] if coupon.is_design else keys
    results = findings(good, one_by_one)
    first: list[Block] = [varied_section(good, one_by_one)] if one_by_one else []
    values: dict[str, Any] = {"design": None, "maps": [], "text": coupon_text(coupon)}
    if coupon.is_design:
        values["design"] = figure_picture("loss_factor_design", design_figure, good, keys)
    elif not one_by_one and len(good[["frequency_hz", "acceleration_g"]].drop_duplicates()) > 1:
        values["maps"] = loss_factor_tables(good)
    if coupon.shot is not None:
        first.append(film_picture(coupon.shot))
    warnings = coupon_warnings(coupon.cases)
    measured = [] if coupon.measured is None else [measured_section(coupon.measured, keys)]
    sections = [coupon_section(coupon._replace(shot=None), varied=keys)]
    return Page(
        title=study.title or study.name,
        answer=results[0],
        first=[Fragment("coupon_first.html", values), *first],
        caveats=warnings[:CAVEATS],
        facts=[("Coupon", cases_text(coupon.cases)), ("Software", software_text(stamp, dem=True))],
        assumptions=study.assumptions,
        summary=results[1:],
        warnings=[
            *warnings[CAVEATS:],
            *(f"{row['case']}: {row['status']}: {row['message']}" for _, row in lost.iterrows()),
        ],
        sections=[*measured, *(replace(section, folded=True) for section in sections)],
        steps=steps,
    )
