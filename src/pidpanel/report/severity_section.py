"""Severity on the page: oscillator spectra, peaks in a duration, fatigue."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from pidpanel.arrays import Flags
from pidpanel.report import html, style
from pidpanel.report.inputs import SeverityResults
from pidpanel.report.layout import WIDTH, draw_curve, frequency_axis
from pidpanel.report.maps_section import EXCEEDED_SHARE, case_titles, map_figure
from pidpanel.report.names import with_names
from pidpanel.report.text import READINGS, number, percent, records, with_error

ACROSS = 3
PLACE = ["reading", "scenario", "point"]  # columns of a row's place
# First columns of the tables.
PLACE_CELLS: Mapping[str, html.Cell] = {
    "damping model": lambda row: READINGS[row["reading"]],
    "scenario": lambda row: row["scenario"],
    "point": lambda row: row["point"],
}
POINTS = 6  # points drawn at most; the tables have all


def severity_section(
    severity: SeverityResults, summary: pd.DataFrame, names: Mapping[str, str], cell_in_patch: Flags
) -> html.PageSection:
    """Return the section of a study with the key ``severity``.

    Parameters
    ----------
    severity
        What the stage left.
    summary
        ``response/summary.csv``: it says which scenario reduces most.
    names
        Of the scenarios by label.
    cell_in_patch
        (n_patches, n_cells) for the edges of the patches in maps.
    """
    peaks, margins, strength, fatigue = (
        with_names(table, names)
        for table in (severity.peaks, severity.margins, severity.strength, severity.fatigue)
    )
    blocks: list[html.Block] = [
        _oscillators(severity, summary, names),
        _peaks(peaks, severity.duration),
        *_margins(margins),
        *_strength(strength),
    ]
    if severity.maps is not None:
        blocks.append(_index_maps(severity.maps, names, cell_in_patch))
    blocks += _fatigue(fatigue, severity.duration)
    return html.PageSection("severity", "Peaks, margins and fatigue", blocks)


def drawn_scenarios(summary: pd.DataFrame) -> list[tuple[str, str]]:
    """Return damping model and label of the most reduced scenario, and its bare panel first."""
    damped = summary[(summary["patch"] != "none") & (summary["status"] == "ok")]
    if damped.empty:
        first = summary.iloc[0]
        return [(first["reading"], first["scenario"])]
    of_model = damped[damped["reading"] == damped["reading"].iloc[0]]
    mean = of_model.groupby("scenario", sort=False)["reduction_db"].mean()
    best = of_model[of_model["scenario"] == mean.idxmax()].iloc[0]
    bare = summary[(summary["patch"] == "none") & (summary["oaspl_db"] == best["oaspl_db"])]
    return [(best["reading"], label) for label in (bare.iloc[0]["scenario"], best["scenario"])]


def _oscillators(
    severity: SeverityResults, summary: pd.DataFrame, names: Mapping[str, str]
) -> html.Picture:
    table = severity.oscillators
    drawn = drawn_scenarios(summary)
    points = list(dict.fromkeys(table["point"]))[:POINTS]
    colours = [style.BARE, style.PLACES[0]][: len(drawn)]
    natural, charts = table["natural_frequency_hz"].unique(), []
    for point in points:
        curves = []
        for (reading, label), colour in zip(drawn, colours, strict=True):
            rows = table[
                (table["reading"] == reading)
                & (table["scenario"] == label)
                & (table["point"] == point)
            ]
            rms = rows["oscillator_rms_g"].to_numpy()
            error = np.log1p(rows["oscillator_rms_error_g"].to_numpy() / rms)
            curves.append(html.PageCurve(names[label], rms, colour, log_error=error))
        charts.append(html.Chart(f"point {point}", natural, "oscillator, g rms", curves))
    caption = (
        f"Vibration response spectrum at Q = {number(severity.quality)}: rms acceleration of an "
        "oscillator on the point, over its natural frequency, for the bare panel and the scenario "
        f"with the largest mean reduction ({names[drawn[-1][1]]}). Bands: one standard error of "
        "the response. severity/oscillators.csv has all scenarios, with the values of Miles' "
        "equation."
    )
    return html.Picture("oscillators", style.Drawing(_figure, charts), caption, charts)


def _figure(charts: Sequence[html.Chart]) -> Figure:
    across = min(ACROSS, len(charts))
    rows = math.ceil(len(charts) / across)
    figure = Figure(figsize=(WIDTH, 0.5 + 2.4 * rows), layout="constrained")
    grid = figure.subplots(rows, across, sharex=True, sharey=True, squeeze=False)
    for axes in grid.ravel()[len(charts) :]:
        axes.remove()
    for axes, chart in zip(grid.ravel(), charts, strict=False):
        for curve in chart.curves:
            draw_curve(axes, chart.frequency, curve, 2.0, 1.3)
        axes.set_yscale("log")
        frequency_axis(axes, chart.frequency[0], chart.frequency[-1])
        axes.set_xlabel("natural frequency, Hz")
        axes.set_title(chart.title, loc="left", fontweight="bold")
    for axes in grid[:, 0]:
        axes.set_ylabel("oscillator, g rms")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def _peaks(table: pd.DataFrame, duration: float) -> html.Table:
    caption = (
        f"Accelerations in {number(duration)} s at each point. The peak is the mean of "
        "the largest peak of a Gaussian process with the same PSD (Davenport); ν₀ is its upward "
        "zero crossings per second. 3σ is three times the rms value."
    )
    return html.table_of(
        records(table),
        caption,
        {
            **PLACE_CELLS,
            "rms, g": lambda row: number(row["acceleration_rms_g"]),
            "3σ, g": lambda row: number(row["three_sigma_g"]),
            "ν₀, Hz": lambda row: number(row["zero_crossings_hz"]),
            "peak, g": lambda row: with_error(row["peak_g"], row["peak_error_g"]),
        },
        folded=True,
        title="Peak accelerations",
    )


def _margins(table: pd.DataFrame) -> list[html.Paragraph | html.Table]:
    """Return the third octave with the smallest margin at each point with a limit."""
    if table.empty:
        return []
    smallest = table.loc[table.groupby(PLACE, sort=False)["margin_db"].idxmin()]
    rows = records(smallest)
    over = [row for row in rows if row["margin_db"] < 0]
    text = f"Limits of the acceleration PSD are exceeded in {len(over)} of {len(rows)} cases."
    cells = html.table_of(
        rows,
        "Third octave with the smallest margin between the mean PSD and the mean limit. A "
        "negative margin exceeds the limit. severity/margins.csv has all bands.",
        {
            **PLACE_CELLS,
            "band, Hz": lambda row: number(row["center_hz"]),
            "PSD, g²/Hz": lambda row: number(row["acceleration_psd_g2_hz"]),
            "limit, g²/Hz": lambda row: number(row["limit_g2_hz"]),
            "margin, dB": lambda row: with_error(row["margin_db"], row["margin_error_db"]),
        },
        folded=True,
        title="Margins to the limits",
    )
    return [html.Paragraph(text), cells]


def _strength(table: pd.DataFrame) -> list[html.Paragraph | html.Table]:
    """Return the layer with the highest failure index at each point."""
    if table.empty:
        return []
    index = table[["maximum_stress_index", "tsai_wu_index"]].max(axis=1)
    worst = table.assign(index=index).loc[lambda t: t.groupby(PLACE, sort=False)["index"].idxmax()]
    rows = records(worst)
    failed = [row for row in rows if row["index"] >= 1]
    text = (
        f"At 3σ the strength is exceeded in {len(failed)} of {len(rows)} cases."
        if failed
        else "At 3σ no strength is exceeded at the response points."
    )
    cells = html.table_of(
        rows,
        "Layer with the highest failure index at each point, for stresses of 3σ with the worst "
        "signs; 1 is failure. The margin of safety is 1/index − 1.",
        {
            **PLACE_CELLS,
            "layer": lambda row: row["layer"],
            "maximum stress": lambda row: number(row["maximum_stress_index"]),
            "Tsai–Wu": lambda row: number(row["tsai_wu_index"]),
            "margin of safety": lambda row: number(1 / row["index"] - 1),
            "error": lambda row: (
                f"±{percent(row['relative_error'])}"
                if math.isfinite(row["relative_error"])
                else "–"
            ),
        },
        folded=True,
        title="Failure indices at 3σ",
    )
    return [html.Paragraph(text), cells]


INDEX_STYLES = {
    "tsai_wu_index": ("Tsai–Wu index at 3σ", 1.0, "magma"),
    "core_index": ("core shear index at 3σ", 1.0, "magma"),
}


def _index_maps(maps: xr.Dataset, names: Mapping[str, str], cell_in_patch: Flags) -> html.Picture:
    """Return maps of the failure indices that the study has strengths for."""
    styles = {name: look for name, look in INDEX_STYLES.items() if name in maps}
    figure = style.Drawing(map_figure, maps, cell_in_patch, case_titles(maps, names), styles=styles)
    largest = [f"{styles[name][0]}: {number(float(maps[name].max()))}" for name in styles]
    caption = (
        "Failure indices all over the panel, of layers the highest, for the scenarios of "
        "response.maps; 1 is failure, the margin of safety is 1/index − 1. White: edges of the "
        f"patches. Largest of all: {'; '.join(largest)}. The colour scale ends at the value that "
        f"{percent(EXCEEDED_SHARE)} of the area exceeds: at re-entrant corners and point supports "
        "the stress of a plate has no limit. Numbers are in severity/maps.nc."
    )
    return html.Picture("failure_maps", figure, caption)


def _fatigue(table: pd.DataFrame, duration: float) -> list[html.Paragraph | html.Table]:
    if table.empty:
        text = "No fatigue damage: the study states no S-N line (severity.fatigue)."
        return [html.Paragraph(text)]
    worst = table.loc[table.groupby(PLACE, sort=False)["damage_narrow_band"].idxmax()]
    highest = max(records(worst), key=lambda row: row["damage_narrow_band"])
    verdict = (
        "No point fails."
        if highest["damage_narrow_band"] < 1
        else "A damage of 1 is failure: at least one point may fail."
    )
    text = (
        f"Largest damage in {number(duration)} s: "
        f"{number(highest['damage_dirlik'], 2)} by Dirlik's count and "
        f"{number(highest['damage_narrow_band'], 2)} by the narrow-band count "
        f"(point {highest['point']}, {highest['scenario']}). {verdict} Only the response "
        "points are looked at; the highest stress of the panel may lie elsewhere."
    )
    caption = (
        "Layer and stress with the most damage at each point, Miner's sum over the duration. Of "
        "one resonance the two counts agree; of several, Dirlik's is up to 30 % low and the "
        "narrow-band one up to 50 % high. The factor is one standard error of the damage, from "
        "that of the response."
    )
    cells = html.table_of(
        records(worst),
        caption,
        {
            **PLACE_CELLS,
            "layer": lambda row: row["layer"],
            "stress": lambda row: row["quantity"].replace("_", " "),
            "rms, MPa": lambda row: number(row["stress_rms_mpa"]),
            "damage, Dirlik": lambda row: number(row["damage_dirlik"], 2),
            "damage, narrow band": lambda row: number(row["damage_narrow_band"], 2),
            "factor": lambda row: f"×/÷ {number(math.exp(row['damage_log_error']))}",
        },
        folded=True,
        title="Fatigue damage",
    )
    return [html.Paragraph(text), cells]
