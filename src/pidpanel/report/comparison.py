"""Results of two studies against each other: what differs by more than the stated errors."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.files import read_basis
from pidpanel.provenance.results import read_csv, read_netcdf
from pidpanel.report import html, text
from pidpanel.report.inputs import without_errors
from pidpanel.report.maps_section import fields_of, map_figure, scale_ends
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.text import DECIBEL_DECIMALS, common_decimals, records, value_text
from pidpanel.response.trust import SIGNIFICANCE

SAME = 1e-3  # share of a value below which a difference is that of lines and meshes [1]

BEST = "best"  # name of the row of the scenario with the lowest rms value at a level

KEYS = ["scenario", "point"]
SIDES = ("first", "second")  # ends of the columns of `differences`


class Side(NamedTuple):
    """One of the two."""

    name: str
    summary: pd.DataFrame  # ``response/summary.csv``, points as text
    psd: xr.Dataset  # ``response/psd.nc``
    # ``response/maps.nc`` and (n_patches, n_cells) which element is in which patch
    maps: tuple[xr.Dataset, Flags] | None = None


def read_side(folder: Path, unknown: Sequence[str] = ()) -> Side:
    """Read the results of a study, ``results/<study>``.

    Parameters
    ----------
    folder
        Folder of the results.
    unknown
        Scenarios without stated errors, from `pidpanel.report.from_study.partly_known`.
    """
    response = folder / "response"
    psd_file, columns = response / "psd.nc", [*KEYS, "acceleration_rms_g", "patch"]
    tables = (
        read_csv(response / "summary.csv", columns, dtype=dict.fromkeys([*KEYS, "patch"], str)),
        read_netcdf(psd_file, ["frequency", "acceleration_psd", *KEYS]),
    )
    summary, psd = without_errors(unknown, *tables)
    maps = None
    if (response / "maps.nc").is_file() and (folder / "panel" / "modes.nc").is_file():
        inside = read_basis(folder / "panel" / "modes.nc").cell_in_patch
        maps = read_netcdf(response / "maps.nc", ["cells", "acceleration_rms"]), inside
    return Side(folder.name, summary, psd, maps)


def values_of(summary: pd.DataFrame) -> pd.DataFrame:
    """Return scenario, point, rms acceleration, error [g] and mass [kg], row by row.

    The lowest of each point, source of damping and sound level is repeated as the scenario `BEST`,
    with its own ``label``, ``best_level`` and ``best_source``. A bare panel has no error of its
    damping, and no mass.
    """
    columns = [*KEYS, "acceleration_rms_g", "acceleration_rms_error_g", "added_mass_kg", "patch"]
    columns += ["oaspl_db", "damping_source"]
    values = summary[summary["acceleration_rms_g"] > 0].reindex(columns=columns)
    values = values.set_axis([*KEYS, "rms", "error", "mass", "is_bare", "level", "source"], axis=1)
    values = values.reset_index(drop=True)
    # to 0.1 dB; 0 under base motion, and for rows that are not the best of a level
    values = values.assign(level=values["level"].round(1).fillna(0.0), best_level=0.0)
    values = values.assign(is_bare=values["is_bare"] == "none", label=values["scenario"])
    values.loc[values["is_bare"], ["error", "mass"]] = (0.0, np.nan)
    treated = values[~values["is_bare"]].groupby(
        ["source", "point", "level"], sort=False, dropna=False
    )
    best = values.loc[treated["rms"].idxmin()]
    # the best of a single source is compared with that of another study, whatever its source
    is_single = best["source"].nunique() <= 1
    sources = "" if is_single else best["source"]
    best = best.assign(scenario=BEST, best_level=best["level"], best_source=sources)
    return pd.concat([values.assign(best_source=""), best])


def differences(first: Side, second: Side) -> pd.DataFrame:
    """Return the rows of both studies, by `KEYS`: both values, the reduction [dB], the verdict.

    The best are those of each source of damping. The error is
    that of independent values, so it is too large for common errors, such as those of one coupon.
    """
    base, rival = (values_of(side.summary) for side in (first, second))
    keys = [*KEYS, "best_level", "best_source"]
    shared = base.merge(rival, on=keys, suffixes=[f"_{side}" for side in SIDES])
    rms, rival_rms = shared["rms_first"], shared["rms_second"]
    reduction = 20 * np.log10(rms / rival_rms)
    relative = np.hypot(shared["error_first"] / rms, shared["error_second"] / rival_rms)
    error = 20 / np.log(10) * relative
    verdicts = {
        "the same": np.abs(rms - rival_rms) <= SAME * rms,
        "not judged: no stated error": np.isnan(error),
        "within the errors": np.abs(reduction) <= SIGNIFICANCE * error,
        "lower": reduction > 0,
    }
    verdict = np.select(list(verdicts.values()), list(verdicts), "higher")
    return shared.assign(reduction=reduction, error=error, verdict=verdict)


def missing_scenarios(first: Side, second: Side) -> Iterator[str]:
    """Yield for each study which scenarios it has that the other has not."""
    for side, other_side in ((first, second), (second, first)):
        names = set(other_side.summary["scenario"])
        missing = [name for name in dict.fromkeys(side.summary["scenario"]) if name not in names]
        if missing:
            yield f"only in {side.name}: {', '.join(missing)}"


def rows_of(shared: pd.DataFrame) -> list[list[str]]:
    """Return the rows of a table, with the columns of `columns_of`."""
    rows = []
    rms_decimals = common_decimals(shared[["error_first", "error_second"]].to_numpy().ravel())
    decimals = common_decimals(shared["error"], DECIBEL_DECIMALS)
    has_levels = shared.loc[shared["scenario"] == BEST, "best_level"].nunique() > 1
    for row in records(shared):
        scenario = row["scenario"]
        if scenario == BEST:
            labels = dict.fromkeys(row[f"label_{side}"] for side in SIDES)
            level = f" at {row['best_level']:g} dB" if has_levels else ""
            source = f" by {row['best_source']}" if row["best_source"] else ""
            scenario = f"{BEST}{level}{source}: {' | '.join(labels)}"
        rms = [value_text(row[f"rms_{s}"], row[f"error_{s}"], rms_decimals) for s in SIDES]
        gain = value_text(row["reduction"], row["error"], decimals)
        mass = text.span((text.number(row[f"mass_{side}"], 2) for side in SIDES), " | ")
        rows.append([scenario, row["point"], *rms, gain, row["verdict"], mass])
    return rows


def columns_of(first: Side, second: Side) -> list[str]:
    """Return the heads of the columns of `rows_of`."""
    values = [f"{side.name}, g rms" for side in (first, second)]
    values += ["reduction, dB", f"{second.name} is", "added, kg"]
    return ["scenario", "point", *values]


def comparison_lines(first: Side, second: Side) -> Iterator[str]:
    """Yield the comparison as lines of text.

    Raises
    ------
    NothingInCommon
    """
    shared = differences(first, second)
    if shared.empty:
        raise NothingInCommon(
            f"{first.name}, {second.name}: no common scenario and point; points of {first.name} "
            f"are {', '.join(first.summary['point'].unique())}, "
            f"of {second.name} {', '.join(second.summary['point'].unique())}"
        )
    rows = [columns_of(first, second), *rows_of(shared)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        yield "  ".join(map(str.ljust, row, widths)).rstrip()
    yield f"{outcome(shared, first, second)} {SIGNIFICANT}"
    yield from missing_scenarios(first, second)


class NothingInCommon(ValueError):
    """Two studies without a value to compare."""


SIGNIFICANT = (
    f"Differences above {SIGNIFICANCE:g} standard errors are significant; the errors of the two "
    "studies are taken as independent."
)


def outcome(shared: pd.DataFrame, first: Side, second: Side) -> str:
    """Return a sentence: how many values differ by more than their errors, and by how much."""
    named = []
    for verdict, rows in shared.groupby("verdict", sort=False):
        gains = rows["reduction"].abs()
        by = f" by {text.span(f'{gain:.1f}' for gain in (gains.min(), gains.max()))} dB"
        named.append(f"{len(rows)} {verdict}{by if verdict in ('lower', 'higher') else ''}")
    names = f"{second.name} against {first.name}"
    return f"{names}, {len(shared)} rms accelerations: {', '.join(named)}."


# Colours of the two studies, distinct for the common kinds of colour blindness.
COLOURS = ("#0072B2", "#D55E00")


def write_comparison(first: Side, second: Side, file: Path) -> None:
    """Write the page of two studies against each other."""
    page = comparison_page(first, second)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(html.render(page), encoding="utf-8")


def comparison_page(first: Side, second: Side) -> html.Page:
    """Return the page."""
    shared = differences(first, second)
    certain = shared[shared["verdict"].isin(["lower", "higher"])]
    caption = f"Where {second.name} and {first.name} differ. {SIGNIFICANT}"
    tables = [_table(caption, first, second, certain, is_first=True)] if len(certain) else []
    values = _table("Rms accelerations of both", first, second, shared)
    return html.Page(
        title=f"{first.name} and {second.name}",
        answer=outcome(shared, first, second),
        first=tables,
        facts=_facts(first, second),
        sections=[
            html.PageSection("psd", "Acceleration PSDs", _psds(first, second, shared)),
            *_maps(first, second),
            html.PageSection("values", "All values", [values]),
        ],
    )


def _table(
    caption: str, first: Side, second: Side, rows: pd.DataFrame, *, is_first: bool = False
) -> html.Fragment:
    """Return differences as a table; all of them with the scenarios that only one study has."""
    values = {
        "caption": caption,
        "columns": columns_of(first, second),
        "rows": rows_of(rows),
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


def _psds(first: Side, second: Side, shared: pd.DataFrame) -> list[html.Picture]:
    """Return the PSDs of each point: at each level both bare panels, and the best of both."""
    pictures: list[html.Picture] = []
    lines = np.union1d(first.psd["frequency"], second.psd["frequency"])
    sides = dict(zip(SIDES, (first, second), strict=True))
    for point in shared["point"].unique():
        rows = shared[shared["point"] == point]
        drawn = rows[(rows["scenario"] == BEST) | rows["is_bare_first"]]
        alike = drawn[drawn["level_first"] == drawn["level_second"]]
        # without a common level the bare panels alone
        groups = [part for _, part in alike.groupby("level_first")] or [drawn]
        for group in groups:
            best, bare = group[group["scenario"] == BEST], group[group["is_bare_first"]].head(1)
            curves = [
                html.PageCurve(
                    f"{side.name}, {row[f'label_{end}']}",
                    _resample(side, row[f"label_{end}"], point, lines),
                    colour,
                    "solid" if row["scenario"] == BEST else "dotted",
                    width=0.9,
                )
                for row in records(pd.concat([best, bare]))
                for (end, side), colour in zip(sides.items(), COLOURS, strict=True)
            ]
            if curves:
                level = f", {group['level_first'].iloc[0]:g} dB" if len(groups) > 1 else ""
                chart = html.Chart("", lines, psd_unit(point), curves)
                caption = f"Acceleration PSD at point {point}{level}; bare panels dotted."
                pictures.append(chart_picture(f"psd_{len(pictures)}", [chart], caption))
    return pictures


def _resample(side: Side, scenario: str, point: str, frequency: Array) -> Array:
    """Return a PSD [g²/Hz] on other lines; NaN beyond its own."""
    psd = side.psd["acceleration_psd"].sel(scenario=scenario, point=point)
    side_lines = side.psd["frequency"].to_numpy()
    values = np.interp(frequency, side_lines, psd.to_numpy(), left=np.nan, right=np.nan)
    return values / STANDARD_GRAVITY**2


def _maps(first: Side, second: Side) -> list[html.PageSection]:
    """Return the maps of both with the same colours for the same values."""
    if first.maps is None or second.maps is None:
        return []
    drawn = {first.name: first.maps, second.name: second.maps}
    styles = fields_of(*(maps for maps, _ in drawn.values()))
    ends = [scale_ends(maps, styles) for maps, _ in drawn.values()]
    tops = {name: max(side_tops[name] for side_tops in ends) for name in ends[0]}
    blocks = []
    for number, (name, (maps, inside)) in enumerate(drawn.items()):
        titles = [f"{name}: {scenario}" for scenario in maps["scenario"].to_numpy()]
        shown = maps, inside, titles, tops, styles
        caption = f"Rms acceleration and stress of {name}; colours as in the other map."
        blocks.append(html.figure_picture(f"maps_{number}", map_figure, *shown, caption=caption))
    return [html.PageSection("maps", "Maps", blocks)]
