"""Results of two studies against each other: what differs by more than the stated errors."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.arrays import Flags
from pidpanel.panel.basis_files import read_basis
from pidpanel.report.answer import SIGNIFICANCE
from pidpanel.report.read import read_by_point, read_dataset, without_errors
from pidpanel.report.text import DECIBEL_DECIMALS, common_decimals, records, value_text

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
            scenario = f"{BEST}: {difference.first.scenario} | {difference.second.scenario}"
        values = (difference.first, difference.second)
        rms = [value_text(value.rms, value.error, rms_decimals) for value in values]
        gain = value_text(difference.reduction, difference.error, decimals)
        rows.append([reading, scenario, point, *rms, gain, difference.verdict])
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
        f"{len(shared)} values: {named}. A difference is significant from {SIGNIFICANCE:g} "
        "standard errors on, with the errors of both studies taken as independent."
    )
