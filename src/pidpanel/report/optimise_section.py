"""Proposed layouts on the page: where the dampers go, what they take, how good they are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.panel.basis import PanelBasis
from pidpanel.report import style
from pidpanel.report.html import PageSection, Paragraph, Picture, Table
from pidpanel.report.inputs import ProposalResults
from pidpanel.report.text import counted, number, records, with_error


def optimise_section(proposal: ProposalResults, basis: PanelBasis) -> PageSection:
    """Return the best layout, the front of mass and reduction, and the equivalent layouts."""
    drawing, front = layout_figure(proposal, basis), front_figure(proposal.front)
    return PageSection(
        "optimise",
        "Proposed layouts",
        [
            *[Paragraph(text) for text in sentences(proposal)],
            Picture("optimise_layout", style.png(drawing), "The best layout on the panel."),
            point_table(proposal),
            Picture(
                "optimise_front",
                style.png(front),
                "Mass against reduction. Line: no layout here is lighter and reduces more. "
                "Filled: within the uncertainty of the best. Crosses: the same mass as dead "
                "weight in the same cells. ±: one standard error.",
            ),
            layout_table(proposal),
            variant_table(proposal.front),
        ],
    )


def sentences(proposal: ProposalResults) -> list[str]:
    """Return what was found in words: the best layout, the gap, what cannot be told apart."""
    facts, front = proposal.search, proposal.front
    best = front.iloc[0]
    gained = best["reduction_db"] - best["dead_weight_reduction_db"]
    texts = [
        f"Best layout: {patches_text(proposal.layouts, 1)}. It weighs {best['mass_kg']:.3g} kg and "
        f"reduces the response by {_decibels(best)}, {gained:.1f} dB more than the same mass as "
        "dead weight.",
        gap_text(facts),
        f"{counted(int(facts['equivalent_layouts']), 'layout')} of "
        f"{int(facts['evaluated_layouts'])} evaluated are within "
        f"{facts['equivalent_within_db']:.2g} dB of the best and cannot be told apart.",
    ]
    lightest = front[front["is_equivalent"]].sort_values(["mass_kg", "patches"]).iloc[0]
    if lightest["layout"] != best["layout"]:
        texts.append(
            f"The lightest of those confirmed, layout {lightest['layout']}, weighs "
            f"{lightest['mass_kg']:.3g} kg and reduces by {_decibels(lightest)}."
        )
    steady = front[front["is_equivalent"]].sort_values("largest_regret_db").iloc[0]
    texts.append(
        f"The most robust of them is layout {steady['layout']}: with ±6 dB of sound, half and "
        "twice the damping ratio, and ±10 % of the damper's mass it is never more than "
        f"{steady['largest_regret_db']:.2g} dB behind the best confirmed layout."
    )
    losing = front[front["loses_to_dead_weight"]]
    for row in records(losing):
        damper = ", ".join(sorted(set(_patches(proposal.layouts, row["layout"])["damper"])))
        texts.append(f"Layout {row['layout']} ({damper}) loses to the same mass as dead weight.")
    return texts


def gap_text(facts: pd.Series) -> str:
    """Return how much better another layout can be, and how far that is proved."""
    checks = int(facts["submodularity_checks"])
    gap = max(0.01, np.ceil(100 * facts["gap_db"]) / 100)
    limits = "of these places and fill fractions, at frozen damping,"
    if facts["submodularity_violations"]:
        return (
            f"Not proved: the property behind the bound is violated in "
            f"{int(facts['submodularity_violations'])} of {checks} checks. With the bound enlarged "
            f"by the largest ratio that was found, {facts['bound_factor']:.3g}, no layout {limits} "
            f"is better by more than {gap:.2g} dB."
        )
    return (
        f"No layout {limits} is better by more than {gap:.2g} dB (the property behind the bound "
        f"held in all of {checks} checks)."
    )


def patches_text(layouts: pd.DataFrame, layout: int) -> str:
    """Return the patches of a layout in words."""
    parts = []
    for row in records(_patches(layouts, layout)):
        fill = row["fill_fraction"]
        filled = f" at fill fraction {fill:g}" if np.isfinite(fill) else ""
        parts.append(
            f"{row['damper']}{filled} at ({row['centre_x_m']:.3g}, {row['centre_y_m']:.3g}) m"
        )
    return "; ".join(parts)


def _patches(layouts: pd.DataFrame, layout: int) -> pd.DataFrame:
    return layouts[layouts["layout"] == layout]


def _decibels(row: Any) -> str:
    error = row["reduction_error_db"]
    value = row["reduction_db"]
    return f"{with_error(value, error) if error > 0 else number(value)} dB"


def point_table(proposal: ProposalResults) -> Table:
    """Return g rms before and after with the best layout, a row per point."""
    summary = proposal.summary
    rows = []
    for row in records(summary[summary["layout"] == 1]):
        after, error = row["acceleration_rms_g"], row["acceleration_rms_error_g"]
        rows.append(
            [
                row["point"],
                number(row["bare_rms_g"]),
                with_error(after, error) if error > 0 else number(after),
                number(row["dead_weight_rms_g"]),
                "yes" if row["counts"] else "no",
            ]
        )
    columns = ["point", "bare, g rms", "with dampers, g rms", "dead weight, g rms", "counts"]
    return Table("The best layout at its consistent motion.", columns, rows)


def layout_table(proposal: ProposalResults) -> Table:
    """Return the layouts that cannot be told apart first, by mass and number of patches."""
    order = ["is_equivalent", "mass_kg", "patches"]
    front = proposal.front.sort_values(order, ascending=[False, True, True], kind="stable")
    rows = [
        [
            str(row["layout"]),
            "yes" if row["is_equivalent"] else "no",
            number(row["mass_kg"]),
            patches_text(proposal.layouts, row["layout"]),
            _decibels(row),
            f"{row['dead_weight_reduction_db']:.2f}",
            f"{row['search_reduction_db']:.2f}",
        ]
        for row in records(front)
    ]
    columns = ["layout", "equivalent", "mass, kg", "patches", "reduction"]
    columns += ["dead weight, dB", "in the search, dB"]
    return Table(
        "Confirmed layouts, those within the uncertainty of the best first. Reduction: of what "
        "the search makes small, at the consistent motion; in the search the damping is frozen.",
        columns,
        rows,
        title="Confirmed layouts",
    )


def variant_table(front: pd.DataFrame) -> Table:
    """Return the reductions under other sound levels, damping ratios and masses."""
    suffix = "_reduction_db"
    start = list(front.columns).index("basis_error") + 1
    names = [name for name in front.columns[start:] if name.endswith(suffix)]
    rows = [
        [str(row["layout"]), *(f"{row[name]:.2f}" for name in [*names, "largest_regret_db"])]
        for row in records(front)
    ]
    titles = [name.removesuffix(suffix).replace("_", " ") for name in names]
    return Table(
        "Reduction in dB with changes of the sound level, of the panel's damping ratio and of the "
        "dampers' C_e and m_a. Behind: most that the layout is behind the best confirmed one.",
        ["layout", *titles, "behind"],
        rows,
        folded=True,
        title="Robustness",
    )


def layout_figure(proposal: ProposalResults, basis: PanelBasis) -> Figure:
    """Draw the panel with the patches of the best layout."""
    vertices = basis.vertex_position
    size = np.ptp(vertices, axis=0)
    figure = Figure(figsize=(6.5, 5.9 * size[1] / size[0] + 0.5), layout="constrained")
    axes = figure.subplots()
    edges = vertices[boundary_edges(basis.cells)]
    axes.add_collection(LineCollection(list(edges), colors="black", linewidths=0.9))
    patches = records(_patches(proposal.layouts, 1))
    dampers = sorted(set(proposal.layouts["damper"]))
    for row in patches:
        colour = style.place_colour(row["damper"], dampers)
        corner = (
            row["centre_x_m"] - row["size_x_m"] / 2,
            row["centre_y_m"] - row["size_y_m"] / 2,
        )
        axes.add_patch(
            Rectangle(
                corner, row["size_x_m"], row["size_y_m"], facecolor=colour, edgecolor=colour,
                alpha=0.35,
            )
        )  # fmt: skip
        fill = f"\nr = {row['fill_fraction']:g}" if np.isfinite(row["fill_fraction"]) else ""
        axes.annotate(
            f"{row['damper']}{fill}\n{row['mass_kg']:.3g} kg",
            (row["centre_x_m"], row["centre_y_m"]), ha="center", va="center", fontsize=7,
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


def front_figure(front: pd.DataFrame) -> Figure:
    """Draw reduction over mass, with dead weight."""
    figure = Figure(figsize=(6.5, 3.6), layout="constrained")
    axes = figure.subplots()
    best = front[front["is_on_front"]].sort_values("mass_kg")
    axes.plot(best["mass_kg"], best["reduction_db"], color=style.PLACES[0], zorder=1)
    for is_equivalent, face in ((True, style.PLACES[0]), (False, "white")):
        part = front[front["is_equivalent"] == is_equivalent]
        axes.errorbar(
            part["mass_kg"], part["reduction_db"], part["reduction_error_db"], fmt="o",
            color=style.PLACES[0], mfc=face, ms=5, elinewidth=0.6, capsize=2,
        )  # fmt: skip
    axes.plot(front["mass_kg"], front["dead_weight_reduction_db"], "x", color=style.PLACES[1], ms=5)
    for row in _labelled(records(front)):
        axes.annotate(
            str(row["layout"]), (row["mass_kg"], row["reduction_db"]), xytext=(6, 3),
            textcoords="offset points",
        )  # fmt: skip
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=min(0.0, float(front["dead_weight_reduction_db"].min()) - 0.2))
    axes.set_xlabel("mass of the dampers, kg")
    axes.set_ylabel("reduction, dB")
    return figure


def _labelled(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the layouts whose numbers stand in the figure: of one mass the best."""
    return [row for row in rows if row["is_on_front"]]
