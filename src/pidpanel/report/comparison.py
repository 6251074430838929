"""Results of two studies against each other: what differs by more than the stated errors."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis_files import read_basis
from pidpanel.report import html
from pidpanel.report.answer import SIGNIFICANCE
from pidpanel.report.inputs import read_by_point, read_dataset, without_errors
from pidpanel.report.maps_section import map_figure, scale_ends
from pidpanel.report.response_figures import PSD_UNIT, chart_picture
from pidpanel.report.text import DECIBEL_DECIMALS, READINGS, common_decimals, records, value_text

SAME = 1e-3  # share of a value below which a difference is that of lines and meshes [1]

BEST = "best"  # name of the row of the scenario with the lowest rms value, whatever it is

Key = tuple[str, str, str]  # reading, scenario, point


@dataclass(frozen=True)
class Side:
    """One of the two."""

    name: str
    summary: pd.DataFrame  # ``response/summary.csv``, points as text
    psd: xr.Dataset  # ``response/psd.nc``
    maps: xr.Dataset | None = None  # ``response/maps.nc``
    cell_in_patch: Flags | None = None  # (n_patches, n_cells)


@dataclass(frozen=True)
class Value:
    """Rms acceleration of a scenario at a point, with its standard error [g]; NaN if not known."""

    scenario: str
    reading: str
    rms: float
    error: float


@dataclass(frozen=True)
class Difference:
    """The same of two studies."""

    key: Key
    first: Value
    second: Value

    @property
    def reduction(self) -> float:
        """Of the other below the one [dB]."""
        return 20 * math.log10(self.first.rms / self.second.rms)

    @property
    def error(self) -> float:
        """Standard error of `reduction` if both are independent [dB]; NaN if not known.

        Errors that both have in common, such as those of one coupon, make it too large.
        """
        relative = math.hypot(*(value.error / value.rms for value in (self.first, self.second)))
        return 20 / math.log(10) * relative

    @property
    def verdict(self) -> str:
        """What can be said of the difference."""
        if abs(self.first.rms - self.second.rms) <= SAME * self.first.rms:
            return "the same"
        if math.isnan(self.error):
            return "not judged: no stated error"
        if abs(self.reduction) <= SIGNIFICANCE * self.error:
            return "within the errors"
        return "lower" if self.reduction > 0 else "higher"


def read_side(folder: Path, unknown: Sequence[str] = ()) -> Side:
    """Read the results of a study, ``results/<study>``.

    Parameters
    ----------
    folder
        Of the results.
    unknown
        Scenarios without stated errors, from `pidpanel.report.from_study.partly_known`.
    """
    response = folder / "response"
    tables = read_by_point(response / "summary.csv"), read_dataset(response / "psd.nc")
    summary, psd = without_errors(unknown, *tables)
    maps, inside = None, None
    if (response / "maps.nc").is_file() and (folder / "panel" / "modes.nc").is_file():
        maps = read_dataset(response / "maps.nc")
        inside = read_basis(folder / "panel" / "modes.nc").cell_in_patch
    return Side(folder.name, summary, psd, maps, inside)


def values_of(summary: pd.DataFrame) -> dict[Key, Value]:
    """Return the rms accelerations of a study, and of each point and reading the lowest as `BEST`.

    A bare panel has no error of its damping.
    """
    values: dict[Key, Value] = {}
    for row in records(summary[summary["acceleration_rms_g"] > 0]):
        reading, scenario, point = (row[name] for name in ("reading", "scenario", "point"))
        is_bare = row["patch"] == "none"
        error = 0.0 if is_bare else row.get("acceleration_rms_error_g", math.nan)
        value = Value(scenario, reading, row["acceleration_rms_g"], error)
        values[reading, scenario, point] = value
        key = (reading, BEST, point)
        if not is_bare and (key not in values or value.rms < values[key].rms):
            values[key] = value
    return values


def differences(first: Side, second: Side) -> list[Difference]:
    """Return what both studies have: same reading, scenario and point.

    Two studies of one reading each are compared whatever the readings are.
    """
    base, rival = values_of(first.summary), values_of(second.summary)
    readings = [{key[0] for key in values} for values in (base, rival)]
    if len(readings[0]) == len(readings[1]) == 1 and readings[0] != readings[1]:
        (shared,) = readings[0]
        rival = {(shared, scenario, point): v for (_, scenario, point), v in rival.items()}
    return [Difference(key, base[key], rival[key]) for key in base if key in rival]


def missing_scenarios(first: Side, second: Side) -> Iterator[str]:
    """Yield for each study which scenarios it has that the other has not."""
    for side, other_side in ((first, second), (second, first)):
        names = set(other_side.summary["scenario"])
        missing = [name for name in dict.fromkeys(side.summary["scenario"]) if name not in names]
        if missing:
            yield f"only in {side.name}: {', '.join(missing)}"


def rows_of(shared: Sequence[Difference]) -> list[list[str]]:
    """Return the rows of a table, with the columns of `columns_of`."""
    rows = []
    rms_decimals = common_decimals(s.error for d in shared for s in (d.first, d.second))
    decimals = common_decimals((difference.error for difference in shared), DECIBEL_DECIMALS)
    for difference in shared:
        reading, scenario, point = difference.key
        if scenario == BEST:
            labels = difference.first.scenario, difference.second.scenario
            scenario = f"{BEST}: {' | '.join(dict.fromkeys(labels))}"
        values = (difference.first, difference.second)
        rms = [value_text(value.rms, value.error, rms_decimals) for value in values]
        gain = value_text(difference.reduction, difference.error, decimals)
        rows.append(
            [READINGS.get(reading, reading), scenario, point, *rms, gain, difference.verdict]
        )
    return rows


def columns_of(first: Side, second: Side) -> list[str]:
    """Return the heads of the columns of `rows_of`."""
    values = [f"{side.name}, g rms" for side in (first, second)]
    return ["damping model", "scenario", "point", *values, "reduction, dB", f"{second.name} is"]


def comparison_lines(first: Side, second: Side) -> Iterator[str]:
    """Yield the comparison as lines of text.

    Raises
    ------
    NothingInCommon
    """
    shared = differences(first, second)
    if not shared:
        raise NothingInCommon(
            f"{first.name}, {second.name}: no common scenario and point; points of {first.name} "
            f"are {', '.join(first.summary['point'].unique())}, "
            f"of {second.name} {', '.join(second.summary['point'].unique())}"
        )
    rows = [columns_of(first, second), *rows_of(shared)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(map(str.ljust, row, widths)).rstrip()
    yield outcome(shared)
    yield from missing_scenarios(first, second)


class NothingInCommon(ValueError):
    """Two studies without a value to compare."""


def outcome(shared: Sequence[Difference]) -> str:
    """Return a sentence: how many values differ by more than their errors."""
    verdicts = Counter(difference.verdict for difference in shared)
    named = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
    return (
        f"{len(shared)} values: {named}. Differences of at least {SIGNIFICANCE:g} standard errors "
        "are significant; the errors of the two studies are taken as independent."
    )


# Of the two studies, distinct for the common kinds of colour blindness.
COLOURS = ("#0072B2", "#D55E00")


def write_comparison(first: Side, second: Side, file: Path) -> None:
    """Write the page of two studies against each other."""
    page = comparison_page(first, second)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(html.render(page), encoding="utf-8")


def comparison_page(first: Side, second: Side) -> html.Page:
    """Return the page."""
    shared = differences(first, second)
    certain = [d for d in shared if d.verdict in ("lower", "higher")]
    caption = f"Where {second.name} and {first.name} differ by more than the stated errors"
    tables = [_table(caption, first, second, certain, is_first=True)] if certain else []
    values = _table("Rms accelerations of both", first, second, shared)
    return html.Page(
        title=f"{first.name} and {second.name}",
        answer=outcome(shared),
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
    first: Side,
    second: Side,
    differences: list[Difference],
    *,
    is_first: bool = False,
) -> html.Fragment:
    """Return differences as a table; all of them with the scenarios that only one study has."""
    values = {
        "caption": caption,
        "columns": columns_of(first, second),
        "rows": rows_of(differences),
        "cards": is_first,
        "missing": [] if is_first else list(missing_scenarios(first, second)),
    }
    return html.Fragment("comparison.html", values)


def _facts(first: Side, second: Side) -> list[tuple[str, str]]:
    facts = []
    for side in (first, second):
        names = "study", "study_hash", "pidpanel_version"
        study, digest, version = (side.psd.attrs.get(name, "–") for name in names)
        facts.append((side.name, f"study {study}, hash {digest}, pidpanel {version}"))
    return facts


def _psds(first: Side, second: Side, shared: list[Difference]) -> list[html.Picture]:
    """Return the PSDs of each point: both bare panels, and the best of both where there is one."""
    pictures: list[html.Picture] = []
    lines = np.union1d(first.psd["frequency"], second.psd["frequency"])
    for point in dict.fromkeys(d.key[2] for d in shared):
        for reading in dict.fromkeys(d.key[0] for d in shared):
            rows = [d for d in shared if d.key[0] == reading and d.key[2] == point]
            drawn = [d for d in rows if d.key[1] == BEST]
            drawn += [d for d in rows if _is_bare(first, d)][:1]
            curves = [
                html.PageCurve(
                    f"{side.name}, {value.scenario}",
                    _resample(side, value.reading, value.scenario, point, lines),
                    colour,
                    "solid" if difference.key[1] == BEST else "dotted",
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


def _is_bare(side: Side, difference: Difference) -> bool:
    rows: pd.DataFrame = side.summary[side.summary["scenario"] == difference.key[1]]
    return bool(len(rows)) and bool((rows["patch"] == "none").all())


def _resample(side: Side, reading: str, scenario: str, point: str, frequency: Array) -> Array:
    """Return a PSD [g²/Hz] on other lines; NaN beyond its own."""
    psd = side.psd["acceleration_psd"].sel(reading=reading, scenario=scenario, point=point)
    side_lines = side.psd["frequency"].to_numpy()
    values = np.interp(frequency, side_lines, psd.to_numpy(), left=np.nan, right=np.nan)
    return values / STANDARD_GRAVITY**2


def _maps(first: Side, second: Side) -> list[html.PageSection]:
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
