"""Tables of break points of a PSD, straight on logarithmic axes, with steps.

A row has a frequency or a range of two, and a level or a slope, such as ``20-50 Hz`` and
``+6 dB/oct``. A level may be left empty where a slope gives it; the slope of a row leads to the
next.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, ColumnsError, UserTable, numbers, read_rows
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.tabular.cells import HERTZ, QUANTITY, Label, ends_of_range, value_of
from pidpanel.tabular.rows import TableRows

FREQUENCY, LEVEL, SLOPE = ("frequency_hz", "acceleration_psd_g2_hz", "slope_db_octave")

ACCELERATION = Label.named(
    "g^2/Hz", "asd psd apsd density level levels",
    "acceleration accel power spectral auto input random vibration value",
)  # fmt: skip
PER_OCTAVE = Label.named("dB/octave", "slope slopes")
COLUMNS = {
    FREQUENCY: Allowed(0.0, low_itself=False, high=1e5, label=HERTZ),
    LEVEL: Allowed(
        0.0, low_itself=False, high=1e5, hint="in (m/s²)²/Hz?", may_be_empty=True,
        label=ACCELERATION,
    ),
    SLOPE: Allowed(-100.0, high=100.0, may_be_missing=True, may_be_empty=True, label=PER_OCTAVE),
}  # fmt: skip

# Difference of levels and slope allowed [dB]: levels are stated to two digits.
SLOPE_TOLERANCE = 0.5
OVERALL_TOLERANCE = 0.03  # difference of a stated overall value, likewise


def read_base_table(path: Path) -> BreakPoints:
    """Read a table of break points [Hz, g²/Hz].

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed: columns with other names, values that are no numbers
        or out of range, frequencies that fall, levels without a value or slope, slopes
        that contradict the levels, an overall value that does.
    """
    return read_acceleration(path)[0]


def read_acceleration(path: Path) -> tuple[BreakPoints, str]:
    """Read a table of break points, and say in a line what was understood; see `read_base_table`.

    Returns
    -------
    Break points [Hz, g²/Hz], and their number, range, overall value, file and what was read
    otherwise than as written.
    """
    text = read_rows(path, COLUMNS, has_overall=True)
    points = break_points(text, COLUMNS)
    for line, value in text.overall:
        if abs(points.rms / value - 1) > OVERALL_TOLERANCE:
            message = f"states {value:g} g rms, its break points have {points.rms:.3g}; must agree"
            message += f" within {100 * OVERALL_TOLERANCE:.0f} %"
            raise ColumnsError([f"{path}, line {line}: {message}"])
    count = f"{points.frequency.size} break points"
    return points, summary(text, count, points.frequency, f"{points.rms:.3g} g rms")


def summary(text: TableRows, count: str, frequency: Array, overall: str) -> str:
    """Return in a line what was understood of a table."""
    low, high = frequency[[0, -1]]
    source = ", ".join([f"from {text.path.name}", *text.remarks])
    return f"{count} {low:g} to {high:g} Hz, {overall}, {source}"


def break_points(text: TableRows, columns: Mapping[str, Allowed]) -> BreakPoints:
    """Return the break points of a table with frequency, level and, where allowed, slope.

    Raises
    ------
    ColumnsError
        With all faults.
    """
    frequency, level, *slopes = columns
    table = numbers(_expanded(text, tuple(columns)) if slopes else text, columns)
    table.refuse(fewest=2, too_few=f"must have at least two break points, not {len(table.lines)}")
    note_order(table, frequency)
    table.refuse()
    psd = table[level]
    if slopes:
        slope = table.columns.get(slopes[0], np.full(psd.shape, np.nan))
        psd = _filled(table[frequency], psd, slope)
        _note_levels(table, psd, slope)
        table.refuse()
    return BreakPoints(table[frequency], psd)


def _expanded(text: TableRows, columns: Sequence[str]) -> TableRows:
    """Return a table with the ends of ranges as rows, and slopes of levels as slopes."""
    header = text.header
    width = len(header)
    if (
        len(set(header)) < width
        or set(header) - set(columns)
        or not set(columns[:2]) <= set(header)
        or any(len(cells) != width for _, cells in text.rows)
    ):  # which is reported
        return text
    rows: list[tuple[int, list[str], str]] = []  # line, cells of the columns, end of a range
    for line, cells in text.rows:
        frequency, level, slope = (
            dict(zip(header, cells, strict=True)).get(n, "") for n in columns
        )
        words = QUANTITY.fullmatch(level)
        if words and PER_OCTAVE.factor(words[4]) and not slope:
            level, slope = "", words[1]
        ends = ends_of_range(frequency)
        if ends is None:
            parts = [([frequency, level, slope], "")]
        else:
            flat = "0" if level and not slope else slope
            parts = [([ends[0], level, flat], "first")]
            parts += [([ends[1], level if flat != slope else "", ""], "last")]
        for row, end in parts:
            is_joint = (
                rows
                and (end or rows[-1][2])
                and value_of(rows[-1][1][0], HERTZ) == value_of(row[0], HERTZ)
            )
            if is_joint and (not (level_before := rows[-1][1][1]) or row[1] in ("", level_before)):
                row = [row[0], row[1] or level_before, row[2] or rows[-1][1][2]]
                rows.pop()
            elif end == "first" and rows and rows[-1][2] == "last" and not is_joint:
                gap = f"{rows[-1][1][0]} to {row[0]}".removesuffix("Hz") + " Hz"
                raise ColumnsError(
                    [f"{text.path}, line {line}: no row has {gap}; ranges must adjoin"]
                )
            rows.append((line, row, end))
    factor = dict(zip(header, text.factor, strict=True))
    return text._replace(
        header=list(columns),
        rows=[(line, row) for line, row, _ in rows],
        factor=[factor.get(name, 1.0) for name in columns],
    )


def note_order(table: UserTable, name: str = FREQUENCY) -> None:
    """Note frequencies that fall, and steps that are none."""
    frequency = table[name]
    rise = np.diff(frequency, prepend=-np.inf)
    message = f"{name} = {{{name}:g}} follows {{previous:g}}; frequencies must increase"
    table.note(rise < 0, message, previous=np.roll(frequency, 1))
    is_step = rise == 0
    at_end = is_step.copy()
    at_end[2:-1] = False
    is_triple = is_step & ~at_end & np.append(is_step[1:], False)
    for wrong, step in (
        (at_end, "a step at an end"),
        (is_triple, "more than two rows at one frequency"),
    ):
        table.note(wrong, f"{name} = {{{name}:g}}: {step} is not allowed")


def _filled(frequency: Array, level: Array, slope: Array) -> Array:
    """Return the levels with those that slopes give; NaN where none does."""
    psd = level.copy()
    rise = 10 ** (slope[:-1] * np.diff(np.log2(frequency)) / 10)
    for row in range(1, psd.size):
        if np.isnan(psd[row]):
            psd[row] = psd[row - 1] * rise[row - 1]
    for row in range(psd.size - 2, -1, -1):
        if np.isnan(psd[row]):
            psd[row] = psd[row + 1] / rise[row]
    return psd


def _note_levels(table: UserTable, psd: Array, slope: Array) -> None:
    """Note levels that nothing gives, and slopes that lead elsewhere."""
    message = f"a gap: {LEVEL} is empty at {{frequency_hz:g}} Hz, and no slope leads there"
    table.note(np.isnan(psd), message)
    is_last = np.arange(psd.size) == psd.size - 1
    message = f"{SLOPE} = {{slope:g}} at the last row leads nowhere; omit it"
    table.note(is_last & np.isfinite(slope), message, slope=slope)
    octaves, rise = np.diff(np.log2(table[FREQUENCY])), np.diff(10 * np.log10(psd))
    message = f"{SLOPE} = {{slope:g}} between {{frequency_hz:g}} and {{to:g}} Hz, "
    message += "where the levels give {levels:+.2f}"
    levels = np.divide(rise, octaves, out=np.full_like(rise, np.inf), where=octaves > 0)
    leads_elsewhere = np.abs(slope[:-1] * octaves - rise) > SLOPE_TOLERANCE
    table.note(leads_elsewhere, message, to=table[FREQUENCY][1:], levels=levels, slope=slope)
    is_doubled = (octaves == 0) & (rise == 0)
    table.note(is_doubled, "frequency_hz = {frequency_hz:g} is given twice with one level")
