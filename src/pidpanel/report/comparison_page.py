"""The page of two studies against each other: table, PSDs and maps side by side."""

from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.report import style
from pidpanel.report.comparison import (
    BEST,
    Difference,
    Side,
    columns_of,
    differences,
    only_in,
    outcome,
    rows_of,
)
from pidpanel.report.html import Page, PageSection, Paragraph, Picture, Table, render
from pidpanel.report.maps_figures import map_figure, scale_ends
from pidpanel.report.response_figures import FigurePanel, PsdCurve, chart_of, psd_figure
from pidpanel.report.text import READINGS

# Of the two studies, distinct for the common kinds of colour blindness.
COLOURS = ("#0072B2", "#D55E00")


def write_comparison(first: Side, second: Side, file: Path) -> None:
    """Write the page of two studies against each other."""
    with style.context():
        page = comparison_page(first, second)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(render(page), encoding="utf-8")


def comparison_page(first: Side, second: Side) -> Page:
    """Return the page; call it within `style.context`."""
    shared = differences(first, second)
    certain = [d for d in shared if d.verdict in ("lower", "higher")]
    columns = columns_of(first, second)
    caption = f"Where {second.name} and {first.name} differ by more than the stated errors"
    tables = [Table(caption, columns, rows_of(certain), cards=True)] if certain else []
    missing = [
        Paragraph(f"Only in {side.name}: {', '.join(names)}.")
        for side, names in ((first, only_in(first, second)), (second, only_in(second, first)))
        if names
    ]
    return Page(
        title=f"{first.name} and {second.name}",
        answer=outcome(shared),
        first=tables,
        facts=_facts(first, second),
        sections=[
            PageSection("psd", "Acceleration PSDs", _psds(first, second, shared)),
            *_maps(first, second),
            PageSection("values", "All values", [Table("Rms accelerations of both", columns,
                                                   rows_of(shared)), *missing]),
        ],
    )  # fmt: skip


def _facts(first: Side, second: Side) -> list[tuple[str, str]]:
    return [
        (
            side.name,
            f"study {side.psd.attrs.get('study', '–')}, hash "
            f"{side.psd.attrs.get('study_hash', '–')}, pidpanel "
            f"{side.psd.attrs.get('pidpanel_version', '–')}",
        )
        for side in (first, second)
    ]


def _psds(first: Side, second: Side, shared: list[Difference]) -> list[Picture]:
    """Return the PSDs of each point: both bare panels, and the best of both where there is one."""
    pictures: list[Picture] = []
    lines = np.union1d(first.psd["frequency"], second.psd["frequency"])
    for point in dict.fromkeys(d.key[2] for d in shared):
        for reading in dict.fromkeys(d.key[0] for d in shared):
            rows = [d for d in shared if d.key[0] == reading and d.key[2] == point]
            drawn = [d for d in rows if d.key[1] == BEST]
            drawn += [d for d in rows if _is_bare(first, d)][:1]
            curves = [
                PsdCurve(
                    f"{side.name}, {value.scenario}",
                    _resample(side, value.reading, value.scenario, point, lines),
                    colour,
                    dotted=difference.key[1] != BEST,
                )
                for difference in drawn
                for side, value, colour in zip(
                    (first, second), (difference.first, difference.second), COLOURS, strict=True
                )
            ]
            if curves:
                panel = FigurePanel(READINGS.get(reading, reading), f"point {point}", curves)
                caption = f"Acceleration PSD at point {point}; bare panels dotted."
                chart = chart_of(panel.title, lines, curves)
                image = style.png(psd_figure(lines, [panel]))
                name = f"psd_{len(pictures)}"
                pictures.append(Picture(name, image, caption, [chart]))
    return pictures


def _is_bare(side: Side, difference: Difference) -> bool:
    rows: pd.DataFrame = side.summary[side.summary["scenario"] == difference.key[1]]
    return bool(len(rows)) and bool((rows["patch"] == "none").all())


def _resample(side: Side, reading: str, scenario: str, point: str, frequency: Array) -> Array:
    """Return a PSD on other lines; NaN beyond its own."""
    psd = side.psd["acceleration_psd"].sel(reading=reading, scenario=scenario, point=point)
    side_lines = side.psd["frequency"].to_numpy()
    return np.interp(frequency, side_lines, psd.to_numpy(), left=np.nan, right=np.nan)


def _maps(first: Side, second: Side) -> list[PageSection]:
    """Return the maps of both with the same colours for the same values."""
    if first.maps is None or second.maps is None:
        return []
    ends = [scale_ends(side.maps) for side in (first, second) if side.maps is not None]
    tops = {name: max(side_tops[name] for side_tops in ends) for name in ends[0]}
    blocks = []
    for number, side in enumerate((first, second)):
        if side.maps is None or side.cell_in_patch is None:
            continue
        cases = zip(side.maps["reading"].to_numpy(), side.maps["scenario"].to_numpy(), strict=True)
        titles = {(str(r), str(s)): f"{side.name}: {s}" for r, s in cases}
        image = style.png(map_figure(side.maps, side.cell_in_patch, titles, tops))
        caption = f"Rms acceleration and stress of {side.name}; colours as in the other map."
        blocks.append(Picture(f"maps_{number}", image, caption))
    return [PageSection("maps", "Maps", blocks)]
