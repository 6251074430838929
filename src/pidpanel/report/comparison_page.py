"""The page of two studies against each other: table, PSDs and maps side by side."""

from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import comparison, html
from pidpanel.report.maps_section import map_figure, scale_ends
from pidpanel.report.response_figures import PSD_UNIT, chart_picture
from pidpanel.report.text import READINGS

# Of the two studies, distinct for the common kinds of colour blindness.
COLOURS = ("#0072B2", "#D55E00")


def write_comparison(first: comparison.Side, second: comparison.Side, file: Path) -> None:
    """Write the page of two studies against each other."""
    page = comparison_page(first, second)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(html.render(page), encoding="utf-8")


def comparison_page(first: comparison.Side, second: comparison.Side) -> html.Page:
    """Return the page."""
    shared = comparison.differences(first, second)
    certain = [d for d in shared if d.verdict in ("lower", "higher")]
    caption = f"Where {second.name} and {first.name} differ by more than the stated errors"
    tables = [_table(caption, first, second, certain, is_first=True)] if certain else []
    values = _table("Rms accelerations of both", first, second, shared)
    return html.Page(
        title=f"{first.name} and {second.name}",
        answer=comparison.outcome(shared),
        first=tables,
        facts=_facts(first, second),
        sections=[
            html.PageSection("psd", "Acceleration PSDs", _psds(first, second, shared)),
            *_maps(first, second),
            html.PageSection("values", "All values", [values]),
        ],
    )


def _table(
    caption: str,
    first: comparison.Side,
    second: comparison.Side,
    differences: list[comparison.Difference],
    *,
    is_first: bool = False,
) -> html.Fragment:
    """Return differences as a table; all of them with the scenarios that only one study has."""
    values = {
        "caption": caption,
        "columns": comparison.columns_of(first, second),
        "rows": comparison.rows_of(differences),
        "cards": is_first,
        "missing": [] if is_first else list(comparison.missing_scenarios(first, second)),
    }
    return html.Fragment("comparison.html", values)


def _facts(first: comparison.Side, second: comparison.Side) -> list[tuple[str, str]]:
    facts = []
    for side in (first, second):
        names = "study", "study_hash", "pidpanel_version"
        study, digest, version = (side.psd.attrs.get(name, "–") for name in names)
        facts.append((side.name, f"study {study}, hash {digest}, pidpanel {version}"))
    return facts


def _psds(
    first: comparison.Side, second: comparison.Side, shared: list[comparison.Difference]
) -> list[html.Picture]:
    """Return the PSDs of each point: both bare panels, and the best of both where there is one."""
    pictures: list[html.Picture] = []
    lines = np.union1d(first.psd["frequency"], second.psd["frequency"])
    for point in dict.fromkeys(d.key[2] for d in shared):
        for reading in dict.fromkeys(d.key[0] for d in shared):
            rows = [d for d in shared if d.key[0] == reading and d.key[2] == point]
            drawn = [d for d in rows if d.key[1] == comparison.BEST]
            drawn += [d for d in rows if _is_bare(first, d)][:1]
            curves = [
                html.PageCurve(
                    f"{side.name}, {value.scenario}",
                    _resample(side, value.reading, value.scenario, point, lines),
                    colour,
                    "solid" if difference.key[1] == comparison.BEST else "dotted",
                    width=0.9,
                )
                for difference in drawn
                for side, value, colour in zip(
                    (first, second), (difference.first, difference.second), COLOURS, strict=True
                )
            ]
            if curves:
                title = READINGS.get(reading, reading)
                chart = html.Chart(title, lines, PSD_UNIT, curves, f"point {point}")
                caption = f"Acceleration PSD at point {point}; bare panels dotted."
                pictures.append(chart_picture(f"psd_{len(pictures)}", [chart], caption))
    return pictures


def _is_bare(side: comparison.Side, difference: comparison.Difference) -> bool:
    rows: pd.DataFrame = side.summary[side.summary["scenario"] == difference.key[1]]
    return bool(len(rows)) and bool((rows["patch"] == "none").all())


def _resample(
    side: comparison.Side, reading: str, scenario: str, point: str, frequency: Array
) -> Array:
    """Return a PSD [g²/Hz] on other lines; NaN beyond its own."""
    psd = side.psd["acceleration_psd"].sel(reading=reading, scenario=scenario, point=point)
    side_lines = side.psd["frequency"].to_numpy()
    values = np.interp(frequency, side_lines, psd.to_numpy(), left=np.nan, right=np.nan)
    return values / STANDARD_GRAVITY**2


def _maps(first: comparison.Side, second: comparison.Side) -> list[html.PageSection]:
    """Return the maps of both with the same colours for the same values."""
    if first.maps is None or second.maps is None:
        return []
    ends = [scale_ends(maps) for maps in (first.maps, second.maps)]
    tops = {name: max(side_tops[name] for side_tops in ends) for name in ends[0]}
    blocks = []
    for number, side in enumerate((first, second)):
        if side.maps is None or side.cell_in_patch is None:
            continue
        titles = [f"{side.name}: {scenario}" for scenario in side.maps["scenario"].to_numpy()]
        shown = side.maps, side.cell_in_patch, titles, tops
        caption = f"Rms acceleration and stress of {side.name}; colours as in the other map."
        blocks.append(html.figure_picture(f"maps_{number}", map_figure, *shown, caption=caption))
    return [html.PageSection("maps", "Maps", blocks)]
