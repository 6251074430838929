"""The answer on the page: a table of few rows, the panel, one PSD, reductions against mass."""

import itertools
import math
from collections.abc import Sequence

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.answer import Candidate, PointResponse, StudyAnswer, select_candidates
from pidpanel.report.answer_figures import WIDTH as NARROW
from pidpanel.report.answer_figures import group_of, mass_figure, panel_figure
from pidpanel.report.answer_text import level_text, worst_map
from pidpanel.report.html import Block, Chart, PageCurve, Picture, Table
from pidpanel.report.inputs import Inputs
from pidpanel.report.response_figures import PSD_UNIT, psd_picture
from pidpanel.report.rms import inside_of, log_error_of
from pidpanel.report.text import DECIBEL_DECIMALS, READINGS, common_decimals, number, value_text

POINTS_SHOWN = 4  # points with a column of their own in the first table, those of most motion


def answer_blocks(inputs: Inputs, answer: StudyAnswer) -> list[Block]:
    """Return what a page shows below its first sentence."""
    blocks: list[Block] = [answer_table(inputs, answer)]
    blocks.append(drawing_block(inputs, answer))
    blocks.append(psd_block(inputs, answer))
    weighed = [c for c in answer.candidates if math.isfinite(c.mass) and c.mass > 0]
    if weighed:
        blocks.append(mass_block(answer, weighed, inputs.study.panel.patches))
    return blocks


def answer_table(inputs: Inputs, answer: StudyAnswer) -> Table:
    """Return the bare panel and the scenarios of `select_candidates`, with their numbers."""
    points = answer.points[:POINTS_SHOWN]
    rows, shown = [], (answer.bare, *select_candidates(answer))
    rms_decimals = common_decimals(c.responses[p].rms_error for c in shown for p in points)
    gain_errors = (answer.response(c).reduction_error for c in shown)
    gain_decimals = common_decimals(gain_errors, DECIBEL_DECIMALS)
    for candidate in shown:
        response = answer.response(candidate)
        bare = candidate.scenario.is_bare
        mass = ["0", "0"] if bare else [number(candidate.mass, 2), number(candidate.share, 2)]
        dampers = {filling.damper for filling in candidate.scenario.fillings}
        if dampers & set(inputs.study.massless):
            mass[0] += " (not in the computation)"
        rms = [_rms(candidate.responses[point], rms_decimals) for point in points]
        gain = ["", ""]
        if not bare:
            per_kg = response.reduction / candidate.mass if candidate.mass > 0 else math.nan
            gain = [
                value_text(response.reduction, response.reduction_error, gain_decimals),
                number(per_kg, 2),
            ]
        rows.append([candidate.name, *mass, *rms, *gain, trust(candidate)])
    remaining = len(answer.candidates) - len(rows) + 1
    left = f" {remaining} more below, under All scenarios." if remaining else ""
    lost = f" {len(answer.lost)} without a steady response." if answer.lost else ""
    how, source = "", "due to the damping"
    if answer.is_coupled:
        how, source = ", in one time integration", "of the coupled runs"
    reading = f"Damping: {READINGS[answer.reading]}{how}. " if answer.candidates else ""
    error = f"±: one standard error, {source}. " if answer.has_errors else ""
    return Table(
        f"{reading}Acceleration in g rms, 3σ in brackets. Reduction of the rms at point "
        f"{answer.worst}, where the bare panel moves most. {error}"
        f"{level_text(inputs).strip()}{left}{lost}".strip(),
        [
            "scenario", "added, kg", "of the panel, %",
            *(f"{point}, g rms (3σ)" for point in points),
            "reduction, dB", "dB per kg", "trusted",
        ],
        rows,
        cards=True,
    )  # fmt: skip


def _rms(response: PointResponse, decimals: int | None) -> str:
    rms = value_text(response.rms, response.rms_error, decimals)
    return f"{rms} ({number(3 * response.rms)})"


def trust(candidate: Candidate) -> str:
    """Return whether the numbers of a scenario are to be trusted, why not, or with which note."""
    if candidate.doubts:
        return f"no: {', '.join(candidate.doubts)}"
    return f"yes; {candidate.note}" if candidate.note else "yes"


def drawing_block(inputs: Inputs, answer: StudyAnswer) -> Picture:
    """Return the panel with supports, masses, patches and points over the worst map."""
    mapped = worst_map(inputs)
    figure = style.Drawing(
        panel_figure, inputs.basis, inputs.study.panel, None if mapped is None else mapped[1]
    )
    caption = "The panel"
    if mapped is not None:
        names = {c.scenario.label: c.name for c in (answer.bare, *answer.candidates)}
        label = mapped[0]
        title = names.get(label, "bare panel" if label.startswith("bare") else label)
        preposition = "of the" if title == "bare panel" else "with"
        caption += f"; colour: rms acceleration {preposition} {title}"
    return Picture("panel", figure, f"{caption}.")


def psd_block(inputs: Inputs, answer: StudyAnswer) -> Picture:
    """Return the PSD at the worst point, bare against the best scenario with its band."""
    point, reading = answer.worst, answer.reading
    psd = inputs.psd["acceleration_psd"].sel(reading=reading, point=point) / STANDARD_GRAVITY**2
    frequency = inputs.psd["frequency"].to_numpy()
    bare = answer.bare

    def label(candidate: Candidate) -> str:
        response = answer.response(candidate)
        return f"{candidate.name}: {value_text(response.rms, response.rms_error)} g rms"

    values = psd.sel(scenario=bare.scenario.label).to_numpy()
    curves = [PageCurve(label(bare), values, style.BARE, width=0.7)]
    for best in answer.candidates[:1]:
        name = best.scenario.label
        curves.append(
            PageCurve(
                label(best),
                psd.sel(scenario=name).to_numpy(),
                style.PLACES[0],
                width=1.8,
                log_error=log_error_of(inputs.psd, reading, name, point),
                inside=inside_of(inputs.psd, reading, name),
            )
        )
    banded = any(curve.log_error is not None for curve in curves)
    curves_text = "bare panel and largest reduction" if len(curves) > 1 else "bare panel"
    caption = f"Acceleration PSD at point {point}, one-sided: {curves_text}."
    caption += " Band: one standard error." if banded else ""
    chart = Chart("", frequency, PSD_UNIT, curves)
    return psd_picture("answer", [chart], caption, width=NARROW, height=3.7)


def mass_block(
    answer: StudyAnswer, weighed: Sequence[Candidate], patches: Sequence[str] = ()
) -> Picture:
    """Return the reduction at the worst point against the mass of the dampers."""
    # what is no patch alone takes the colours that are left
    groups = dict.fromkeys([*patches, *(group_of(c) for c in weighed)])
    colours = dict(zip(groups, itertools.cycle(style.PLACES), strict=False))
    caption = f"Reduction of the rms acceleration at point {answer.worst} against mass."
    figure = style.Drawing(mass_figure, answer, weighed, colours)
    return Picture("reduction_mass", figure, caption)
