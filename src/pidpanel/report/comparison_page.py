"""The page of two studies against each other: table, PSDs and maps side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.report import style
from pidpanel.report.charts import chart_of
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
from pidpanel.report.response_figures import FigurePanel, PsdCurve, psd_figure
from pidpanel.report.text import READINGS

COLOURS = ("#0072B2", "#D55E00")
"""Of the two studies, told apart with the common kinds of colour blindness."""


def write_comparison(one: Side, other: Side, file: Path) -> None:
    """Write the page of two studies against each other."""
    with style.context():
        page = comparison_page(one, other)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(render(page), encoding="utf-8")


def comparison_page(one: Side, other: Side) -> Page:
    """Return the page; call it within `style.context`."""
    found = differences(one, other)
    certain = [d for d in found if d.verdict in ("lower", "higher")]
    columns = columns_of(one, other)
    said = f"Where {other.name} and {one.name} differ by more than the stated errors"
    first = [Table(said, columns, rows_of(certain), cards=True)] if certain else []
    missing = [
        Paragraph(f"Only in {side.name}: {', '.join(names)}.")
        for side, names in ((one, only_in(one, other)), (other, only_in(other, one)))
        if names
    ]
    return Page(
        title=f"{one.name} and {other.name}",
        answer=outcome(found),
        first=first,
        facts=_facts(one, other),
        assumptions=(),
        summary=(),
        warnings=(),
        claims=None,
        sections=[
            PageSection("psd", "Acceleration PSDs", _psds(one, other, found)),
            *_maps(one, other),
            PageSection("values", "All values", [Table("Rms accelerations of both", columns,
                                                   rows_of(found)), *missing]),
        ],
    )  # fmt: skip


def _facts(one: Side, other: Side) -> list[tuple[str, str]]:
    return [
        (
            side.name,
            f"study {side.psd.attrs.get('study', '–')}, hash "
            f"{side.psd.attrs.get('study_hash', '–')}, pidpanel "
            f"{side.psd.attrs.get('pidpanel_version', '–')}",
        )
        for side in (one, other)
    ]


def _psds(one: Side, other: Side, found: list[Difference]) -> list[Picture]:
    """Return the PSDs of each point: both bare panels, and the best of both where there is one."""
    pictures: list[Picture] = []
    both = np.union1d(one.psd["frequency"], other.psd["frequency"])
    for point in dict.fromkeys(d.key[2] for d in found):
        for reading in dict.fromkeys(d.key[0] for d in found):
            at = [d for d in found if d.key[0] == reading and d.key[2] == point]
            drawn = [d for d in at if d.key[1] == BEST] + [d for d in at if _is_bare(one, d)][:1]
            curves = [
                PsdCurve(
                    f"{side.name}, {value.scenario}",
                    _on(side, value.reading, value.scenario, point, both),
                    colour,
                    dotted=difference.key[1] != BEST,
                )
                for difference in drawn
                for side, value, colour in zip(
                    (one, other), (difference.one, difference.other), COLOURS, strict=True
                )
            ]
            if curves:
                panel = FigurePanel(READINGS.get(reading, reading), f"point {point}", curves)
                caption = f"Acceleration PSD at point {point}; bare panels dotted."
                chart = chart_of(panel.title, both, curves)
                image = style.png(psd_figure(both, [panel]))
                name = f"psd_{len(pictures)}"
                pictures.append(Picture(name, image, caption, [chart]))
    return pictures


def _is_bare(side: Side, difference: Difference) -> bool:
    rows: pd.DataFrame = side.summary[side.summary["scenario"] == difference.key[1]]
    return bool(len(rows)) and bool((rows["patch"] == "none").all())


def _on(side: Side, reading: str, scenario: str, point: str, frequency: Array) -> Array:
    """Return a PSD on other lines; NaN beyond its own."""
    psd = side.psd["acceleration_psd"].sel(reading=reading, scenario=scenario, point=point)
    own = side.psd["frequency"].to_numpy()
    return np.interp(frequency, own, psd.to_numpy(), left=np.nan, right=np.nan)


def _maps(one: Side, other: Side) -> list[PageSection]:
    """Return the maps of both with the same colours for the same values."""
    if one.maps is None or other.maps is None:
        return []
    ends = [scale_ends(side.maps) for side in (one, other) if side.maps is not None]
    tops = {name: max(each[name] for each in ends) for name in ends[0]}
    blocks = []
    for number, side in enumerate((one, other)):
        if side.maps is None or side.cell_in_patch is None:
            continue
        cases = zip(side.maps["reading"].to_numpy(), side.maps["scenario"].to_numpy(), strict=True)
        titles = {(str(r), str(s)): f"{side.name}: {s}" for r, s in cases}
        image = style.png(map_figure(side.maps, side.cell_in_patch, titles, tops))
        caption = f"Rms acceleration and stress of {side.name}; colours as in the other map."
        blocks.append(Picture(f"maps_{number}", image, caption))
    return [PageSection("maps", "Maps", blocks)]
