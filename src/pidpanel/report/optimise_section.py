"""Proposed layouts on the page: where the dampers go, what they take, how good they are."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup
from matplotlib.ticker import MaxNLocator

from pidpanel.report import html, style
from pidpanel.report.answer_figures import panel_figure
from pidpanel.report.inputs import PanelInputs, ProposalResults
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.templates import fill, sentence
from pidpanel.report.text import NAMES, common_decimals, number, records, value_text
from pidpanel.structure.from_study import studied

NARROW = 5.2  # width of a picture, two of which make a row [in]


# Objective of the search, if it is not an rms acceleration of the points.
OBJECTIVES: dict[str, str] = NAMES["objectives"]


# Excitation of the panel in words, by its name.
UNDER = {"sound": "under sound", "base": "on the moving base"}


def proposal_headline(proposal: ProposalResults) -> str:
    """Return the answer: where, how full, how heavy, how much less, and the gap."""
    best = proposal.front.iloc[0]
    rows = proposal.summary[proposal.summary["counts"] & (proposal.summary["layout"] == 1)]
    rows = rows[rows["excitation"] == best["excitation"]]
    values = {
        **_values(proposal),
        "patches": patches_text(proposal.layouts, 1),
        "size": proposal.layouts[["size_x_m", "size_y_m"]].iloc[0].tolist(),
        "is_grid": proposal.layouts["patch"].isna().all(),
        "objective": OBJECTIVES.get(proposal.objective),
        "bare": dict(rows.sort_values("bare_rms_g").iloc[-1]),
        "after": dict(rows.sort_values("acceleration_rms_g").iloc[-1]),
        "gap": _gap(proposal),
    }
    if proposal.objective in OBJECTIVES:
        error = best["objective"] * np.log(10) / 20 * best["reduction_error_db"]
        values["objective_error"] = error
    return sentence("optimise_headline.html", values)


def _values(proposal: ProposalResults) -> dict[str, Any]:
    """Return what all templates of the search need."""
    return {
        "facts": dict(proposal.search),
        "best": dict(proposal.front.iloc[0]),
        "under": UNDER,
        "has_both": len(proposal.excitations) > 1,
        "has_bound": bool(np.isfinite(proposal.search["gap_db"])),
        "has_drifted": bool(np.isnan(proposal.search["gap_db"])),
    }


def proposal_choice(proposal: ProposalResults, inputs: PanelInputs) -> html.Fragment:
    """Return the front of mass and reduction, with drawing and PSD of each layout."""
    layouts, drawn = [], (inputs.basis, studied(inputs.study.panel))
    for row in records(proposal.front):
        layout = row["layout"]
        reduction = value_text(row["reduction_db"], row["reduction_error_db"])
        name = f"layout_drawing_{layout}"
        patches = proposal.layouts[proposal.layouts["layout"] == layout]
        layouts.append(
            {
                "layout": layout,
                "label": f"Layout {layout}: {number(row['mass_kg'])} kg, {reduction} dB",
                "patches": patches_text(proposal.layouts, layout),
                "picture": html.figure_picture(name, panel_figure, *drawn, None, patches),
                "psds": [_psd(proposal, layout, name) for name in proposal.excitations],
            }
        )
    values = {"drawing": front_drawing(proposal.front), "layouts": layouts}
    return html.Fragment("optimise_choice.html", values)


def _psd(proposal: ProposalResults, layout: int, excitation: str) -> dict[str, Any]:
    summary = proposal.summary[(proposal.summary["layout"] == layout) & proposal.summary["counts"]]
    summary = summary[summary["excitation"] == excitation]
    psds = proposal.psd[proposal.psd["excitation"] == excitation]
    row = summary.sort_values("bare_rms_g").iloc[-1]
    curves, frequency = [], np.zeros(0)
    kinds = (layout, "with dampers", style.PLACES[0]), (0, "bare", style.BARE)
    for number_of, name, colour in kinds:
        psd = psds[(psds["layout"] == number_of) & (psds["point"] == row["point"])]
        frequency = psd["frequency_hz"].to_numpy()
        values = psd["acceleration_psd_g2_hz"].to_numpy()
        key = "acceleration_rms" if number_of else "bare_rms"
        text = value_text(row[f"{key}_g"], row.get(f"{key}_error_g", 0.0))
        curves.append(html.PageCurve(f"{name}: {text} g rms", values, colour, width=1.4))
    charts = [html.Chart("", frequency, psd_unit(row["point"]), curves)]
    name = f"layout_psd_{layout}_{excitation}"
    picture = chart_picture(name, charts, has_svg=layout == 1, width=NARROW, height=3.7)
    return {"point": row["point"], "under": UNDER[excitation], "picture": picture}


def optimise_section(proposal: ProposalResults) -> html.PageSection:
    """Return what the best layout does, how sure that is, and the equivalent layouts."""
    facts, front, summary = proposal.search, proposal.front, proposal.summary
    order = ["is_equivalent", "mass_kg", "patches"]
    layouts = front.sort_values(order, ascending=[False, True, True], kind="stable")
    equivalent = front[front["is_equivalent"]]
    suffix = "_reduction_db"
    variants = list(front.columns)[list(front.columns).index("basis_error") + 1 :]
    dampers = dict.fromkeys(name.partition(" of ")[2] for name in facts.index)
    losing = [
        name
        for name in filter(None, dampers)
        if facts[f"reduction_db of {name}"] < facts[f"dead_weight_reduction_db of {name}"]
    ]
    values = {
        **_values(proposal),
        "gap": gap_text(proposal),
        "alternatives": ALTERNATIVES,
        "others": known_alternatives(front),
        "lightest": dict(equivalent.sort_values(["mass_kg", "patches"]).iloc[0]),
        "steady": dict(equivalent.sort_values("largest_regret_db").iloc[0]),
        "losing_dampers": losing,
        "losing": front.loc[front["loses_to_dead_weight"], "layout"].tolist(),
        "points": records(summary[summary["layout"] == 1]),
        "decimals": common_decimals(front["reduction_error_db"]),
        "layouts": [
            {**row, "text": patches_text(proposal.layouts, row["layout"])}
            for row in records(layouts)
        ],
        "front": records(front),
        "variants": [n.removesuffix(suffix) for n in variants if n.endswith(suffix)],
    }
    return html.template_section("optimise.html", "Proposed layouts", values)


def _gap(proposal: ProposalResults) -> float:
    """Return the gap [dB], rounded up."""
    return float(np.ceil(20 * proposal.search["gap_db"]) / 20)


def gap_text(proposal: ProposalResults) -> str:
    """Return how much better another layout can be, and how far that is proved."""
    return sentence("optimise_gap.html", _values(proposal))


def patches_text(layouts: pd.DataFrame, layout: int) -> str:
    """Return the patches of a layout in words, those of one filling together."""
    fillings: dict[str, list[str]] = {}
    for row in records(layouts[layouts["layout"] == layout]):
        fill = row["fill_fraction"]
        name = f"{row['damper']}, {100 * fill:g} % full," if np.isfinite(fill) else row["damper"]
        place = f"({row['centre_x_m']:.3g}, {row['centre_y_m']:.3g})"
        is_named = isinstance(row["patch"], str)
        fillings.setdefault(name, []).append(row["patch"] if is_named else place)
    unit = "" if is_named else " m"
    return "; ".join(f"{name} at {', '.join(places)}{unit}" for name, places in fillings.items())


WIDTH, HEIGHT = 640, 340
LEFT, RIGHT, TOP, BOTTOM = 52, WIDTH - 12, 12, HEIGHT - 44  # edges of the axes [pixel]

# Name, colour and mark of what the same mass does otherwise, by the start of its column.
ALTERNATIVES = {
    "dead_weight": ("dead weight in the same cells", style.PLACES[1], "M-4-4 4 4M-4 4 4-4"),
    "face_sheets": ("thicker face sheets", style.PLACES[2], "M-4 4 0-4 4 4Z"),
    "damping_layer": ("damping layer", style.PLACES[3], "M-4-4H4V4H-4Z"),
}


def known_alternatives(front: pd.DataFrame) -> list[str]:
    """Return the `ALTERNATIVES` of which a front has reductions."""
    return [n for n in ALTERNATIVES if np.isfinite(front[f"{n}_reduction_db"]).any()]


def front_drawing(front: pd.DataFrame) -> Markup:
    """Return reduction over mass as SVG; layouts of the front link to ``#layout_<number>``."""
    rows = front[front["is_on_front"]].sort_values("mass_kg")
    names = known_alternatives(front)
    lowest = min(0.0, *(front[f"{n}_reduction_db"].min() for n in names))
    highest = (front["reduction_db"] + front["reduction_error_db"]).max()
    x, x_ticks = _scale(0.0, 1.08 * front["mass_kg"].max(), LEFT, RIGHT)
    y, y_ticks = _scale(lowest, 1.05 * highest, BOTTOM, TOP)
    across, reduction, error = x(rows["mass_kg"]), rows["reduction_db"], rows["reduction_error_db"]
    alternatives = []
    for name in names:
        is_known = np.isfinite(rows[f"{name}_reduction_db"])
        up = y(rows[f"{name}_reduction_db"])
        places = list(zip(across[is_known], up[is_known], strict=True))
        look = dict(zip(("name", "colour", "mark"), ALTERNATIVES[name], strict=True))
        alternatives.append({**look, "places": places})
    drawn = rows.assign(x=across, y=y(reduction), low=y(reduction - error),
                        high=y(reduction + error))  # fmt: skip
    values = {
        "width": WIDTH, "height": HEIGHT, "left": LEFT, "right": RIGHT, "top": TOP,
        "bottom": BOTTOM, "x_ticks": x_ticks, "y_ticks": y_ticks, "alternatives": alternatives,
        "colour": style.PLACES[0], "rows": records(drawn),
    }  # fmt: skip
    return fill("front.html", values)


def _scale(
    low: float, high: float, start: float, end: float
) -> tuple[Callable[[pd.Series], pd.Series], list[tuple[float, float]]]:
    """Return values → pixels of an axis, and its ticks, each with its pixel."""
    slope = (end - start) / (high - low)
    ticks = np.array(MaxNLocator(6, steps=[1, 2, 5, 10]).tick_values(low, high))
    ticks = ticks[(ticks >= low - 1e-9) & (ticks <= high)]
    pixels = start + (ticks - low) * slope
    placed = list(zip(ticks.tolist(), pixels.tolist(), strict=True))
    return lambda values: start + (values - low) * slope, placed
