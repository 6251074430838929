"""Proposed layouts on the page: where the dampers go, what they take, how good they are."""

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.panel.basis import PanelBasis
from pidpanel.report import html, style
from pidpanel.report.front_drawing import ALTERNATIVES, front_drawing
from pidpanel.report.inputs import ProposalResults
from pidpanel.report.response_figures import PSD_UNIT, psd_picture
from pidpanel.report.text import number, percent, records, with_error

NARROW = 5.2  # width of a picture, two of which make a row [in]


# What the search makes small, where it is no rms acceleration of the points.
OBJECTIVES = {
    "panel": "largest rms acceleration over the panel, at the response points and 24 vertices,",
    "stress": "largest 3σ von Mises stress at the points",
    "oscillators": "largest rms acceleration of oscillators on the points in the band",
}


# What drives the panel, by the name of the excitation.
UNDER = {"sound": "under sound", "base": "on the moving base"}


def _fall(proposal: ProposalResults, best: Any) -> str:
    """Return what falls from where to where, under the excitation that decides."""
    under = UNDER[best["excitation"]]
    if proposal.objective in OBJECTIVES:
        error = best["objective"] * np.log(10) / 20 * best["reduction_error_db"]
        return (
            f"The {OBJECTIVES[proposal.objective]} {under} falls from "
            f"{number(best['bare_objective'])} to {_rms(best['objective'], error)} "
            f"{best['objective_unit']}."
        )
    rows = proposal.summary[proposal.summary["counts"] & (proposal.summary["layout"] == 1)]
    rows = rows[rows["excitation"] == best["excitation"]]
    after = rows.sort_values("acceleration_rms_g").iloc[-1]
    return (
        f"The largest rms acceleration {under} falls from {number(rows['bare_rms_g'].max())} to "
        f"{_rms(after['acceleration_rms_g'], after['acceleration_rms_error_g'])} g."
    )


def _both(proposal: ProposalResults, best: Any) -> str:
    """Return the reduction under each of two excitations; nothing under one."""
    if len(proposal.excitations) == 1:
        return ""
    values = [f"{best[f'{name}_reduction_db']:.1f} dB {UNDER[name]}" for name in UNDER]
    return f" ({' and '.join(values)}; the smaller counts)"


def proposal_headline(proposal: ProposalResults) -> str:
    """Return the answer: where, how full, how heavy, how much less, and the gap."""
    facts, best = proposal.search, proposal.front.iloc[0]
    every = facts["is_exhaustive"]
    by = "Every layout was evaluated:" if every else "By the bound of the search,"
    gap = f"{by} no layout here is better by more than {_gap(proposal):g} dB."
    if not np.isfinite(facts["gap_db"]):
        tried = _count(facts["evaluated_layouts"])
        gap = f"It is the best of {tried} layouts tried, not proved to be the best of all."
    elif facts["submodularity_violations"] and not facts["is_exhaustive"]:
        gap = f"Not proved to be the best; the estimated gap is {_gap(proposal):g} dB."
    x, y = proposal.layouts[["size_x_m", "size_y_m"]].iloc[0]
    return (
        f"Best layout within {facts['budget_kg']:g} kg: {patches_text(proposal.layouts, 1)}, "
        f"{x:g} m × {y:g} m{' each' if best['patches'] > 1 else ''}, {number(best['mass_kg'])} kg. "
        f"{_fall(proposal, best)} The reduction is {_decibels(best)}{_both(proposal, best)}. {gap}"
    )


def proposal_choice(proposal: ProposalResults, basis: PanelBasis) -> html.Choice:
    """Return the front of mass and reduction, with drawing and PSD of each layout."""
    options = []
    for row in records(proposal.front):
        layout = row["layout"]
        label = f"{number(row['mass_kg'])} kg, {_decibels(row)}"
        picture = html.Picture(
            f"layout_drawing_{layout}",
            style.Drawing(layout_figure, proposal, basis, layout),
            f"{patches_text(proposal.layouts, layout)}.",
        )
        title = f"Layout {layout}: {label}"
        psds = [_psd_picture(proposal, layout, name) for name in proposal.excitations]
        options.append((f"layout_{layout}", title, [picture, *psds]))
    return html.Choice(
        front_drawing(proposal.front),
        "Reduction over mass; click a point or a layout below for its drawing and PSD. Filled: "
        "equivalent to the best. Other marks: the same mass used otherwise. ±: one standard "
        "error.",
        options,
    )


def _psd_picture(proposal: ProposalResults, layout: int, excitation: str) -> html.Picture:
    summary = proposal.summary[(proposal.summary["layout"] == layout) & proposal.summary["counts"]]
    summary = summary[summary["excitation"] == excitation]
    psds = proposal.psd[proposal.psd["excitation"] == excitation]
    row = summary.sort_values("bare_rms_g").iloc[-1]
    curves, frequency = [], np.zeros(0)
    for number_of, name, colour in (
        (layout, "with dampers", style.PLACES[0]),
        (0, "bare", style.BARE),
    ):
        psd = psds[(psds["layout"] == number_of) & (psds["point"] == row["point"])]
        frequency = psd["frequency_hz"].to_numpy()
        values = psd["acceleration_psd_g2_hz"].to_numpy()
        rms = row["acceleration_rms_g" if number_of else "bare_rms_g"]
        curves.append(html.PageCurve(f"{name}: {number(rms)} g rms", values, colour, width=1.4))
    caption = f"Acceleration PSD at point {row['point']} {UNDER[excitation]}, where the bare panel "
    caption += "moves most."
    charts = [html.Chart("", frequency, PSD_UNIT, curves)]
    return psd_picture(
        f"layout_psd_{layout}_{excitation}", charts, caption, width=NARROW, height=3.7
    )


def optimise_section(proposal: ProposalResults) -> html.PageSection:
    """Return what the best layout does, how sure that is, and the equivalent layouts."""
    return html.PageSection(
        "optimise",
        "Proposed layouts",
        [
            *[html.Paragraph(text) for text in sentences(proposal)],
            point_table(proposal),
            layout_table(proposal),
            variant_table(proposal.front),
        ],
    )


def sentences(proposal: ProposalResults) -> list[str]:
    """Return what was found in words: the gap, the same mass used otherwise, equivalents."""
    facts, front = proposal.search, proposal.front
    best = front.iloc[0]
    otherwise = [
        f"{ALTERNATIVES[name][0]} {best[f'{name}_reduction_db']:.1f} dB"
        for name in ALTERNATIVES
        if _is_known(front, name)
    ]
    texts = [
        gap_text(proposal),
        f"The {number(best['mass_kg'])} kg of the best layout reduce by {best['reduction_db']:.1f} "
        f"dB as dampers; used otherwise: {', '.join(otherwise)}.",
    ]
    if _is_known(front, "face_sheets"):
        texts.append(
            "Thicker face sheets: mass and bending stiffness of the whole panel are scaled. Half "
            "of the panel's mass is face sheets: 1 % more mass gives 2 % more stiffness."
        )
    texts.append(
        f"{_count(facts['equivalent_layouts'])} of {_count(facts['evaluated_layouts'])} evaluated "
        f"layouts are within {facts['equivalent_within_db']:.2g} dB of the best, one standard "
        "error: they are equivalent."
    )
    lightest = front[front["is_equivalent"]].sort_values(["mass_kg", "patches"]).iloc[0]
    if lightest["mass_kg"] < 0.999 * best["mass_kg"]:
        texts.append(
            f"The lightest confirmed equivalent is layout {lightest['layout']}: "
            f"{number(lightest['mass_kg'])} kg, {_decibels(lightest)}."
        )
    steady = front[front["is_equivalent"]].sort_values("largest_regret_db").iloc[0]
    texts.append(
        f"Robust choice: layout {steady['layout']}. With ±6 dB of the level, half and twice the "
        f"damping ratio, and ±10 % of the damper mass, it is at most "
        f"{steady['largest_regret_db']:.2f} dB behind the best confirmed layout."
    )
    for damper in dict.fromkeys(name.partition(" of ")[2] for name in facts.index):
        if (
            damper
            and facts[f"reduction_db of {damper}"] < facts[f"dead_weight_reduction_db of {damper}"]
        ):
            texts.append(f"Caution: damper {damper} loses to dead weight of its mass.")
    losing = front.loc[front["loses_to_dead_weight"], "layout"].astype(str)
    if len(losing):
        texts.append(f"Caution: layouts that lose to dead weight: {', '.join(losing)}.")
    return texts


def _is_known(front: pd.DataFrame, alternative: str) -> bool:
    return bool(np.isfinite(front[f"{alternative}_reduction_db"]).any())


def _count(value: float) -> str:
    return f"{int(value):,}".replace(",", " ")


def _drift(front: pd.DataFrame) -> float:
    """Return by how much the search differs from the consistent motion [dB]."""
    return float((front["search_reduction_db"] - front["reduction_db"]).abs().max())


def _gap(proposal: ProposalResults) -> float:
    """Return the gap [dB] of the search, with its error for two layouts, rounded up."""
    return float(np.ceil(20 * (proposal.search["gap_db"] + 2 * _drift(proposal.front))) / 20)


def _rms(value: float, error: float) -> str:
    return with_error(value, error) if error > 0 else number(value)


def gap_text(proposal: ProposalResults) -> str:
    """Return how much better another layout can be, and how far that is proved."""
    facts = proposal.search
    checks, violations = (int(facts[f"submodularity_{name}"]) for name in ("checks", "violations"))
    assumption = "assumes that a damper removes less beside others, "
    fails = f"which fails in {_count(violations)} of {_count(checks)} checks"
    if facts["is_exhaustive"]:
        return (
            "Every layout of the places and fill fractions of the study was evaluated, with the "
            "damping frozen at the motion of each damper alone. The confirmed layouts, whose "
            f"damping follows their own motion, differ by up to {_drift(proposal.front):.2f} dB; "
            "twice that is the gap."
        )
    if not np.isfinite(facts["gap_db"]):
        text = (
            "Not proved to be the best: single dampers would remove in sum more than the whole "
            "response, so the sum does not limit what a layout removes, and no gap can be stated. "
            "The search added dampers one by one, exchanged them, and expanded "
            f"{_count(facts['nodes'])} layouts by branch and bound. It tried "
            f"{_count(facts['evaluated_layouts'])} layouts, the best of which are confirmed at "
            "their consistent motion. Fewer or smaller patches make the bound tighter."
        )
        return f"{text} The bound also {assumption}{fails}." if violations else text
    text = (
        f"Gap among the places and fill fractions of the study: branch and bound leaves "
        f"{facts['gap_db']:.2f} dB, with the damping frozen at the motion of each damper alone. "
        "The confirmed layouts, whose damping follows their own motion, differ by up to "
        f"{_drift(proposal.front):.2f} dB; twice that is added. The bound {assumption}"
    )
    if violations:
        factor, excess = number(facts["bound_factor"]), percent(facts["bound_excess"], 1)
        return (
            f"{text}{fails}: not proved. It is enlarged by the largest ratio sampled, {factor}, "
            f"and by {excess} of the bare mean square."
        )
    return f"{text}which holds in all of {_count(checks)} checks."


def patches_text(layouts: pd.DataFrame, layout: int) -> str:
    """Return the patches of a layout in words, those of one filling together."""
    fillings: dict[str, list[str]] = {}
    for row in records(_patches(layouts, layout)):
        fill = row["fill_fraction"]
        name = f"{row['damper']}, {100 * fill:g} % full," if np.isfinite(fill) else row["damper"]
        place = f"({row['centre_x_m']:.3g}, {row['centre_y_m']:.3g})"
        fillings.setdefault(name, []).append(place)
    return "; ".join(f"{name} at {', '.join(places)} m" for name, places in fillings.items())


def _patches(layouts: pd.DataFrame, layout: int) -> pd.DataFrame:
    return layouts[layouts["layout"] == layout]


def _decibels(row: Any) -> str:
    return f"{_rms(row['reduction_db'], row['reduction_error_db'])} dB"


def point_table(proposal: ProposalResults) -> html.Table:
    """Return g rms before and after with the best layout, a row per point."""
    summary = proposal.summary
    under = {"excitation": lambda row: UNDER[row["excitation"]]}
    return html.table_of(
        records(summary[summary["layout"] == 1]),
        "The best layout at its consistent motion.",
        {
            "point": lambda row: row["point"],
            **(under if len(proposal.excitations) > 1 else {}),
            "bare, g rms": lambda row: number(row["bare_rms_g"]),
            "with dampers, g rms": lambda row: _rms(
                row["acceleration_rms_g"], row["acceleration_rms_error_g"]
            ),
            "dead weight, g rms": lambda row: number(row["dead_weight_rms_g"]),
            "counts": lambda row: "yes" if row["counts"] else "no",
        },
    )


def layout_table(proposal: ProposalResults) -> html.Table:
    """Return all confirmed layouts, equivalents of the best first, by mass and patches."""
    others = [name for name in ALTERNATIVES if _is_known(proposal.front, name)]
    order = ["is_equivalent", "mass_kg", "patches"]
    front = proposal.front.sort_values(order, ascending=[False, True, True], kind="stable")
    rows = [
        [
            str(row["layout"]),
            "yes" if row["is_equivalent"] else "no",
            number(row["mass_kg"]),
            patches_text(proposal.layouts, row["layout"]),
            _decibels(row),
            *(f"{row[f'{name}_reduction_db']:.2f}" for name in (*others, "search")),
        ]
        for row in records(front)
    ]
    columns = ["layout", "equivalent", "mass, kg", "patches", "reduction"]
    columns += [f"{name.replace('_', ' ')}, dB" for name in (*others, "search")]
    return html.Table(
        "Confirmed layouts by mass and number of patches, equivalents of the best first. Dead "
        "weight, face sheets, damping layer: reduction by the same mass. Search: with frozen "
        "damping.",
        columns,
        rows,
        title="Confirmed layouts",
    )


def variant_table(front: pd.DataFrame) -> html.Table:
    """Return the reductions under other sound levels, damping ratios and masses."""
    suffix = "_reduction_db"
    start = list(front.columns).index("basis_error") + 1
    names = [name for name in front.columns[start:] if name.endswith(suffix)]
    rows = [
        [str(row["layout"]), *(f"{row[name]:.2f}" for name in [*names, "largest_regret_db"])]
        for row in records(front)
    ]
    titles = [name.removesuffix(suffix).replace("_", " ") for name in names]
    return html.Table(
        "Reduction in dB with changes of the level, of the panel's damping ratio and of the "
        "dampers' C_e and m_a. Behind: most that the layout is behind the best confirmed one.",
        ["layout", *titles, "behind"],
        rows,
        folded=True,
        title="Robustness",
    )


def layout_figure(proposal: ProposalResults, basis: PanelBasis, layout: int) -> Figure:
    """Draw the panel with the patches of a layout."""
    vertices = basis.vertex_position
    size = np.ptp(vertices, axis=0)
    figure = Figure(figsize=(NARROW, 0.9 * NARROW * size[1] / size[0] + 0.5), layout="constrained")
    axes = figure.subplots()
    edges = vertices[boundary_edges(basis.cells)]
    axes.add_collection(LineCollection(list(edges), colors="black", linewidths=0.9))
    patches = records(_patches(proposal.layouts, layout))
    dampers = sorted(set(proposal.layouts["damper"]))
    for row in patches:
        colour = style.place_colour(row["damper"], dampers)
        corner = (row["centre_x_m"] - row["size_x_m"] / 2, row["centre_y_m"] - row["size_y_m"] / 2)
        axes.add_patch(
            Rectangle(
                corner, row["size_x_m"], row["size_y_m"], facecolor=colour, edgecolor=colour,
                alpha=0.35,
            )
        )  # fmt: skip
        fill = f"\n{100 * row['fill_fraction']:g} %" if np.isfinite(row["fill_fraction"]) else ""
        axes.annotate(
            f"{row['damper']}{fill}\n{number(row['mass_kg'])} kg",
            (row["centre_x_m"], row["centre_y_m"]), ha="center", va="center", fontsize=6,
        )  # fmt: skip
    for name, (x, y) in zip(basis.point_names, basis.point_position, strict=True):
        axes.plot(x, y, "o", color="black", ms=4)
        axes.annotate(name, (x, y), xytext=(5, 12), textcoords="offset points", fontweight="bold")
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.margins(0.03)
    axes.grid(False)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    return figure
