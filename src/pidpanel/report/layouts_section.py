"""Layouts on the page: what they weigh, what they take, and what the same mass takes alone."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.report import response_figures, style
from pidpanel.report.charts import chart_of
from pidpanel.report.html import (
    Block,
    Cell,
    Fold,
    PageSection,
    Paragraph,
    Picture,
    Table,
    table_of,
)
from pidpanel.report.inputs import Inputs
from pidpanel.report.names import ReportedScenario
from pidpanel.report.psds import inside_of, log_error_of
from pidpanel.report.response_figures import FigurePanel, PsdCurve, nested_width
from pidpanel.report.text import (
    DECIBEL_DECIMALS,
    READINGS,
    common_decimals,
    does_not_move,
    number,
    percent,
    records,
    value_text,
)

DRAWN_TOGETHER = 6
"""Layouts in one figure at most: as many as there are colours without an order."""

ROWS_SHOWN = 15
"""Filled patches whose table is shown without being asked for."""

DEAD_WEIGHT = (
    "Dead weight: the same mass in the same places without damping. The difference is the "
    "effect of the damping; it is small where a damper acts as a mass."
)


def layouts_section(inputs: Inputs) -> PageSection:
    """Return the explicit layouts: masses and reductions, PSDs, what the patches do."""
    study = inputs.study
    scenarios = study.layouts
    blocks: list[Block] = [mass_table(inputs, scenarios, layouts=True)]
    points, moving = study.panel.points, inputs.moving_points
    if len(moving) < len(points):
        blocks.append(Paragraph(does_not_move([p for p in points if p not in moving])))
    for point in moving:
        pictures = []
        for reading in study.readings:
            drawn = [s for s in scenarios if _is_steady(inputs, reading, s)]
            for first in range(0, len(drawn), DRAWN_TOGETHER):
                part = drawn[first : first + DRAWN_TOGETHER]
                name = f"psd_layouts_{reading}_{first // DRAWN_TOGETHER + 1}_{point}"
                pictures.append(_psd_picture(inputs, reading, part, point, name))
        if pictures:
            blocks.append(Fold(f"Point {point}", pictures))
    blocks.append(patch_table(inputs, scenarios))
    return PageSection("layouts", "Layouts", blocks)


def mass_table(inputs: Inputs, scenarios: Sequence[ReportedScenario], *, layouts: bool) -> Table:
    """Return mass, rms acceleration and reduction of scenarios, and those of dead weight."""
    points = inputs.study.panel.points
    by_key = {
        (row["reading"], row["scenario"], row["point"]): row for row in records(inputs.summary)
    }
    rows = []
    readings, names = inputs.study.readings, inputs.study.names
    of_table = inputs.summary["scenario"].isin([scenario.label for scenario in scenarios])
    errors = inputs.summary[of_table]
    rms_decimals = common_decimals(errors["acceleration_rms_error_g"])
    decimals = common_decimals(errors["reduction_error_db"])
    decimals = DECIBEL_DECIMALS if decimals is None else decimals
    for scenario in scenarios:
        for reading in readings:
            for index, point in enumerate(points):
                row = by_key[reading, scenario.label, point]
                steady = row["status"] in ("ok", "held")
                cells = [names[scenario.label]] if index == 0 else [""]
                if layouts:
                    cells.append(patches_text(scenario) if index == 0 else "")
                if len(readings) > 1:
                    cells.append(READINGS[reading] if index == 0 else "")
                mass = ["", ""]
                if index == 0:
                    mass = [number(row["added_mass_kg"]), number(row["added_mass_percent"], 2)]
                values = (
                    _reductions(row, rms_decimals, decimals)
                    if steady
                    else [str(row["status"]), *["–"] * 3]
                )
                rows.append([*cells, *(mass if steady else ["–", "–"]), point, *values])
    columns = ["layout", "patches"] if layouts else ["scenario"]
    columns += ["reading"] if len(readings) > 1 else []
    columns += ["added, kg", "of the panel, %", "point", "g rms", "reduction, dB"]
    columns += ["dead weight: reduction, dB", "difference, dB"]
    return Table(
        "Mass of the dampers, in kg and in percent of the panel including attached masses; "
        "rms acceleration, and its reduction against the bare panel under the same sound. "
        f"{DEAD_WEIGHT} ±: one standard error, where known. –: the mass of the damper is "
        "unknown.",
        columns,
        rows,
        folded=not layouts,
        title="Mass, reduction and dead weight",
    )


def _reductions(row: dict[str, Any], rms_decimals: int | None, decimals: int) -> list[str]:
    if row["status"] == "held":
        return ["does not move", "–", "–", "–"]
    difference = row["reduction_db"] - row["dead_weight_reduction_db"]
    return [
        value_text(row["acceleration_rms_g"], row["acceleration_rms_error_g"], rms_decimals),
        value_text(row["reduction_db"], row["reduction_error_db"], decimals),
        value_text(row["dead_weight_reduction_db"], np.nan, decimals),
        value_text(difference, np.nan, decimals),
    ]


def patches_text(scenario: ReportedScenario) -> str:
    """Return the patches of a scenario with what they are filled with.

    Examples
    --------
    >>> from pidpanel.report.names import FilledPatch
    >>> patches_text(ReportedScenario("heavy", (FilledPatch("A", "steel", 0.1),)))
    'A: steel, r = 0.1'
    """
    parts = []
    for filling in scenario.fillings:
        contents = [filling.damper] if filling.damper is not None else []
        contents += [] if filling.fill_fraction is None else [f"r = {filling.fill_fraction:g}"]
        parts.append(f"{filling.patch}: {', '.join(contents)}")
    return "; ".join(parts)


def patch_table(inputs: Inputs, scenarios: Sequence[ReportedScenario]) -> Table:
    """Return every filled patch of scenarios: its mass, its motion, and that of its elements."""
    labels = [scenario.label for scenario in scenarios]
    layouts = inputs.layouts[inputs.layouts["scenario"].isin(labels)]
    unit = inputs.study.read_by
    read = {
        "patch": " C_e uses the mean motion of the patch; damping.level.by: element uses the "
        "motion of each element.",
        "element": " C_e uses the motion of each element (damping.level.by: element); Γ of "
        "C_e is their mean.",
    }[unit]
    if not layouts["damping_read_at_g"].notna().any():
        read = ""
    names = inputs.study.names
    caption = (
        "Motion: amplitude of the sine with the rms acceleration of the patch, averaged over "
        f"its area, with the dampers and on the bare panel. Elements: lowest and highest.{read}"
    )
    cells: dict[str, Cell] = {
        "layout": lambda row: names[row["scenario"]],
        "damping model": lambda row: READINGS[row["reading"]],
        "patch": lambda row: row["patch"],
        "damper": lambda row: str(row["damper"]),
        "r": lambda row: number(row["fill_fraction"], 2),
        "mass, kg": lambda row: number(row["mass_kg"]),
        "Γ of C_e": lambda row: number(row["damping_read_at_g"]),
        "motion Γ": lambda row: number(row["patch_motion_g"]),
        "bare motion Γ": lambda row: number(row["bare_patch_motion_g"]),
        "of its elements Γ": _range,
        "lines outside the range of the data": lambda row: percent(row["outside_run_points_share"]),
    }
    folded = len(layouts) > ROWS_SHOWN
    return table_of(records(layouts), caption, cells, folded=folded, title="Every filled patch")


def _range(row: Mapping[str, Any]) -> str:
    low, high = row["lowest_element_motion_g"], row["highest_element_motion_g"]
    return f"{number(low)} to {number(high)}" if np.isfinite(low) else "–"


def _is_steady(inputs: Inputs, reading: str, scenario: ReportedScenario) -> bool:
    psd = inputs.psd["acceleration_psd"].sel(reading=reading, scenario=scenario.label)
    return bool(np.isfinite(psd).all())


def _psd_picture(
    inputs: Inputs, reading: str, scenarios: Sequence[ReportedScenario], point: str, name: str
) -> Picture:
    """Return PSDs of the bare panel, of layouts and of their dead weights at a point."""
    selected = inputs.psd.sel(reading=reading, point=point)
    bare = dict.fromkeys(s.bare_label for s in scenarios)
    curves = [
        PsdCurve(
            "bare panel" if len(bare) == 1 else label,
            selected["acceleration_psd"].sel(scenario=label).to_numpy(),
            style.BARE,
            width=0.8,
        )
        for label in bare
    ]
    labels = [layout.label for layout in inputs.study.layouts]
    colours = dict(zip(labels, itertools.cycle(style.PLACES), strict=False))
    dead, treated = [], []
    for index, scenario in enumerate(scenarios):
        label, colour = scenario.label, colours[scenario.label]
        weight = selected["dead_weight_acceleration_psd"].sel(scenario=label).to_numpy()
        if np.isfinite(weight).all():
            dead.append(PsdCurve(f"{label}: dead weight", weight, colour, width=0.7, dotted=True))
        treated.append(
            PsdCurve(
                label,
                selected["acceleration_psd"].sel(scenario=label).to_numpy(),
                colour,
                inside_of(inputs.psd, reading, label),
                nested_width(index, len(scenarios)),
                # a band of one curve hides nothing; those of several would
                log_error=log_error_of(inputs.psd, reading, label, point)
                if len(scenarios) == 1
                else None,
            )
        )
    frequency = inputs.psd["frequency"].to_numpy()
    panel = FigurePanel(READINGS[reading], "", [*curves, *dead, *treated])
    caption = (
        f"One-sided acceleration PSD at point {point}: bare panel, layouts, and the same "
        "masses as dead weight (dotted)."
    )
    if len(scenarios) == 1:
        caption += " Shaded: one standard error of the damping, where known."
    if not all(inside_of(inputs.psd, reading, scenario.label).all() for scenario in scenarios):
        caption += " Dashed: damping outside the range of its data."
    figure = response_figures.psd_figure(frequency, [panel])
    return Picture(
        name, style.png(figure), caption, [chart_of(panel.title, frequency, panel.curves)]
    )


def of_layouts(layouts: pd.DataFrame, reading: str, scenario: str) -> list[dict[str, Any]]:
    """Return the rows of a scenario in ``response/layouts.csv``."""
    return records(layouts[(layouts["reading"] == reading) & (layouts["scenario"] == scenario)])
