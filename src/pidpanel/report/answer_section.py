"""The answer on the page: a table of few rows, the panel, one PSD, reductions against mass."""

import itertools
import math
from collections.abc import Collection, Sequence
from typing import Any

from pidpanel.arrays import Array
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.report import style
from pidpanel.report.answer import COLUMNS, Candidate, StudyAnswer, select_candidates
from pidpanel.report.answer_figures import WIDTH as NARROW
from pidpanel.report.answer_figures import group_of, mass_figure, panel_figure
from pidpanel.report.answer_text import worst_map
from pidpanel.report.html import Chart, Fragment, Picture, figure_picture
from pidpanel.report.inputs import Inputs, PanelInputs
from pidpanel.report.names import main_level
from pidpanel.report.response_figures import PSD_UNIT, chart_picture
from pidpanel.report.rms import psd_curve
from pidpanel.report.text import value_text


def answer_fragment(inputs: Inputs, answer: StudyAnswer) -> Fragment:
    """Return what a page shows below its first sentence."""
    study, (mapped, rms) = inputs.study, worst_map(inputs) or (None, None)
    points = answer.points[:COLUMNS]
    shown = (answer.bare, *select_candidates(answer))
    rms_decimals, gain_decimals = answer.decimals
    weighed = [c for c in answer.candidates if math.isfinite(c.mass) and c.mass > 0]
    psd = psd_picture_of(inputs, answer)
    values = {
        "answer": answer,
        "has_levels": len({scenario.oaspl_db for scenario in study.all_scenarios()}) > 1,
        "level": main_level(study),
        "remaining": len(answer.candidates) - len(shown) + 1,
        "points": points,
        "rows": [_row(answer, candidate, study.massless_dampers) for candidate in shown],
        "rms_decimals": rms_decimals,
        "gain_decimals": gain_decimals,
        "panel": panel_picture(inputs, rms),
        "mapped": None if mapped is None else _mapped_name(answer, mapped),
        "psd": psd,
        "has_band": any(curve.log_error is not None for curve in psd.charts[0].curves),
        "masses": mass_picture(answer, weighed, list(study.panel.patches)) if weighed else None,
    }
    return Fragment("answer.html", values)


def panel_picture(inputs: PanelInputs, rms: Array | None, caption: str = "") -> Picture:
    """Return the drawing of the panel over a map of rms acceleration (n_vertices,) [g]."""
    panel = StudiedPanel(inputs.study.panel)
    return figure_picture("panel", panel_figure, inputs.basis, panel, rms, caption=caption)


def _row(
    answer: StudyAnswer, candidate: Candidate, massless: Collection[str | None]
) -> dict[str, Any]:
    response = answer.response(candidate)
    return {
        "candidate": candidate,
        "response": response,
        "is_bare": candidate.scenario.is_bare,
        "is_massless": any(f.damper in massless for f in candidate.scenario.fillings),
        "per_kg": response.reduction / candidate.mass if candidate.mass > 0 else math.nan,
        "trust": trust(candidate),
    }


def trust(candidate: Candidate) -> str:
    """Return whether the numbers of a scenario are to be trusted, why not, or with which note."""
    if candidate.doubts:
        return f"no: {', '.join(candidate.doubts)}"
    return f"yes; {candidate.note}" if candidate.note else "yes"


def _mapped_name(answer: StudyAnswer, label: str) -> str:
    names = {c.scenario.label: c.name for c in (answer.bare, *answer.candidates)}
    return names.get(label, "bare panel" if label.startswith("bare") else label)


def psd_picture_of(inputs: Inputs, answer: StudyAnswer) -> Picture:
    """Return the PSD at the worst point, bare against the best scenario with its band."""
    point, reading, (decimals, _) = answer.worst, answer.reading, answer.decimals
    drawn = [(answer.bare, style.BARE, 0.7)]
    drawn += [(best, style.PLACES[0], 1.8) for best in answer.candidates[:1]]
    curves = []
    for candidate, colour, width in drawn:
        place = {"reading": reading, "scenario": candidate.scenario.label, "point": point}
        response = answer.response(candidate)
        label = f"{candidate.name}: {value_text(response.rms, response.rms_error, decimals)} g rms"
        has_band = candidate is not answer.bare
        curves.append(psd_curve(inputs.psd, place, label, colour, width, has_band=has_band))
    chart = Chart("", inputs.psd["frequency"].to_numpy(), PSD_UNIT, curves)
    return chart_picture("answer", [chart], width=NARROW, height=3.7)


def mass_picture(
    answer: StudyAnswer, weighed: Sequence[Candidate], patches: Sequence[str]
) -> Picture:
    """Return the reduction at the worst point against the mass of the dampers."""
    # what is no patch alone takes the colours that are left
    groups = dict.fromkeys([*patches, *(group_of(c) for c in weighed)])
    colours = dict(zip(groups, itertools.cycle(style.PLACES), strict=False))
    return figure_picture("reduction_mass", mass_figure, answer, weighed, colours)
