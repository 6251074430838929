"""Tables of break points of an acceleration PSD in CSV files.

The columns are `frequency_hz`, `acceleration_psd_g2_hz` and, where wanted, `slope_db_octave`, the
slope from a row to the next. A level may be left empty where a slope gives it.
"""

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import (
    Allowed,
    ColumnsError,
    Fault,
    faults_of_header,
    numbers,
    read_rows,
    refuse,
)
from pidpanel.spectra.break_points import BreakPoints

FREQUENCY, LEVEL, SLOPE = COLUMNS = ("frequency_hz", "acceleration_psd_g2_hz", "slope_db_octave")

ALLOWED = {
    FREQUENCY: Allowed(0.5, high=20000.0),
    LEVEL: Allowed(0.0, low_itself=False, high=10.0, hint="in (m/s²)²/Hz?"),
    SLOPE: Allowed(-100.0, high=100.0),
}

# Difference of levels and slope allowed [dB]: levels are stated to two digits.
SLOPE_TOLERANCE = 0.5


def read_base_table(path: Path) -> BreakPoints:
    """Read a table of break points [Hz, g²/Hz].

    Raises
    ------
    ColumnsError
        With all faults of the file: columns with other names, values that are no numbers or out of
        range, frequencies that do not increase, levels that neither a value nor a slope gives,
        slopes that contradict the levels.
    """
    table = read_rows(path)
    faults = faults_of_header(table, COLUMNS, required=COLUMNS[:2])
    # an empty level or slope is not stated
    stand_in = {LEVEL: "1", SLOPE: "0"}
    heads = [stand_in.get(name, "") for name in table.header]
    rows = [
        (line, [cell or head for cell, head in zip(cells, heads, strict=True)])
        if len(cells) == len(heads)
        else (line, cells)
        for line, cells in table.rows
    ]
    lines, columns, of_cells = numbers(table._replace(rows=rows), ALLOWED)
    faults += of_cells
    if not faults and len(lines) < 2:
        raise ColumnsError([f"{path}: must have at least two break points"])
    if not faults:
        stated = {
            name: np.array([bool(cells[table.header.index(name)]) for _, cells in table.rows])
            for name in table.header
        }
        level = np.where(stated[LEVEL], columns[LEVEL], np.nan)
        slope = np.full(len(lines), np.nan)
        if SLOPE in columns:
            slope = np.where(stated[SLOPE], columns[SLOPE], np.nan)
        faults = _faults_of_order(lines, columns[FREQUENCY])
        if not faults:
            psd = _filled(columns[FREQUENCY], level, slope)
            faults = _faults_of_levels(lines, columns[FREQUENCY], psd, slope)
    refuse(path, faults)
    return BreakPoints(columns[FREQUENCY], psd)


def _faults_of_order(lines: Sequence[int], frequency: Array) -> list[Fault]:
    return [
        (line, f"frequency_hz = {f:g} follows {before:g}; frequencies must increase")
        for line, f, before in zip(lines[1:], frequency[1:], frequency[:-1], strict=True)
        if f <= before
    ]


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


def _faults_of_levels(
    lines: Sequence[int], frequency: Array, psd: Array, slope: Array
) -> list[Fault]:
    """Return levels that nothing gives, and slopes that lead elsewhere."""
    faults = [
        (line, f"a gap: {LEVEL} is empty at {f:g} Hz, and no slope leads there")
        for line, f, value in zip(lines, frequency, psd, strict=True)
        if np.isnan(value)
    ]
    if np.isfinite(slope[-1]):
        says = f"{SLOPE} = {slope[-1]:g} at the last row leads nowhere; omit it"
        faults.append((lines[-1], says))
    for row, wide in enumerate(np.diff(np.log2(frequency))):
        rise = 10 * math.log10(psd[row + 1] / psd[row])
        if abs(slope[row] * wide - rise) > SLOPE_TOLERANCE:
            says = f"{SLOPE} = {slope[row]:g} between {frequency[row]:g} and "
            says += f"{frequency[row + 1]:g} Hz, where the levels give {rise / wide:+.2f}"
            faults.append((lines[row], says))
    return faults
