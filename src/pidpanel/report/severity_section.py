"""Severity on the page: oscillator spectra, peaks in a duration, fatigue."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.report import html, style
from pidpanel.report.inputs import Inputs, SeverityResults
from pidpanel.report.maps_section import EXCEEDED_SHARE, case_titles, map_figure
from pidpanel.report.names import main_scenarios, with_names
from pidpanel.report.response_figures import chart_picture
from pidpanel.report.text import NAMES, common_decimals, records

ACROSS = 3
PLACE = ["scenario", "point"]  # columns that identify a row
POINTS = 6  # points drawn at most; the tables have all

INDEX_STYLES = {
    "tsai_wu_index": ("Tsai–Wu index at 3σ", 1.0, "magma"),
    "core_index": ("core shear index at 3σ", 1.0, "magma"),
}


def severity_section(severity: SeverityResults, inputs: Inputs) -> html.PageSection:
    """Return the section of a study with the key ``severity``."""
    names = inputs.names
    main = [scenario.label for scenario in main_scenarios(inputs.study)]
    drawn = drawn_scenarios(inputs.summary[inputs.summary["scenario"].isin(main)])
    strength = severity.strength.assign(
        index=severity.strength[["maximum_stress_index", "tsai_wu_index"]].max(axis=1),
        has_error=np.isfinite(severity.strength["relative_error"]),
    )
    fatigue = severity.fatigue.assign(factor=np.exp(severity.fatigue["damage_log_error"]))
    strongest = _worst(strength, strength["index"], names)
    damaged = _worst(fatigue, fatigue["damage_narrow_band"], names)
    values = {
        "quality": severity.stated.quality,
        "duration": severity.stated.duration_s,
        "best": names[drawn[-1]],
        "oscillators": _oscillators(severity.oscillators, drawn, names),
        "peaks": records(with_names(severity.peaks, names)),
        "peak_decimals": common_decimals(severity.peaks["peak_error_g"], 0),
        "has_kurtosis": bool(severity.peaks["excess_kurtosis_error"].any()),
        "strength": strongest,
        "failed": sum(row["index"] >= 1 for row in strongest),
        "fatigue": damaged,
        "symbols": NAMES["stresses"],
        "worst": max(damaged, key=lambda row: row["damage_narrow_band"], default=None),
        "maps": None,
    }
    if (maps := severity.maps) is not None:
        styles = {name: look for name, look in INDEX_STYLES.items() if name in maps}
        drawn_maps = maps, inputs.basis.cell_in_patch, case_titles(maps, names)
        values |= {
            "maps": html.figure_picture("failure_maps", map_figure, *drawn_maps, styles=styles),
            "largest": [(look[0], float(maps[name].max())) for name, look in styles.items()],
            "exceeded_share": EXCEEDED_SHARE,
        }
    return html.template_section("severity.html", "Peaks, strength and fatigue", values)


def _worst(
    table: pd.DataFrame, severity: pd.Series, names: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Return the row of each place in which a severity is highest."""
    highest = severity.groupby([table[name] for name in PLACE], sort=False).idxmax()
    return records(with_names(table.loc[highest], names))


def drawn_scenarios(summary: pd.DataFrame) -> list[str]:
    """Return the label of the most reduced scenario, and that of its bare panel first."""
    damped = summary[(summary["patch"] != "none") & (summary["status"] == "ok")]
    if damped.empty:
        return [summary.iloc[0]["scenario"]]
    best = damped.groupby("scenario", sort=False)["reduction_db"].mean().idxmax()
    level = damped.loc[damped["scenario"] == best, "oaspl_db"].iloc[0]
    bare = summary[(summary["patch"] == "none") & (summary["oaspl_db"] == level)]
    return [bare.iloc[0]["scenario"], str(best)]


def _oscillators(
    table: pd.DataFrame, drawn: Sequence[str], names: Mapping[str, str]
) -> html.Picture:
    points = list(dict.fromkeys(table["point"]))[:POINTS]
    colours = [style.BARE, style.PLACES[0]][: len(drawn)]
    natural, charts = table["natural_frequency_hz"].unique(), []
    by_place = table.groupby(PLACE)
    for point in points:
        curves = []
        for label, colour in zip(drawn, colours, strict=True):
            rows = by_place.get_group((label, point))
            rms = rows["oscillator_rms_g"].to_numpy()
            error = np.log1p(rows["oscillator_rms_error_g"].to_numpy() / rms)
            curves.append(html.PageCurve(names[label], rms, colour, log_error=error))
        charts.append(html.Chart(f"point {point}", natural, "oscillator, g rms", curves))
    return chart_picture("oscillators", charts, across=ACROSS, height=2.9)
