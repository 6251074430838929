"""Tables of break points of an acceleration PSD in CSV files.

The columns are `frequency_hz`, `acceleration_psd_g2_hz` and optionally `slope_db_octave`, the
slope from a row to the next. A level may be left empty where a slope gives it.
"""

from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, UserTable, numbers, read_rows
from pidpanel.spectra.break_points import BreakPoints

FREQUENCY, LEVEL, SLOPE = ("frequency_hz", "acceleration_psd_g2_hz", "slope_db_octave")

COLUMNS = {
    FREQUENCY: Allowed(0.5, high=20000.0),
    LEVEL: Allowed(0.0, low_itself=False, high=10.0, hint="in (m/s²)²/Hz?", may_be_empty=True),
    SLOPE: Allowed(-100.0, high=100.0, may_be_missing=True, may_be_empty=True),
}

# Difference of levels and slope allowed [dB]: levels are stated to two digits.
SLOPE_TOLERANCE = 0.5


def read_base_table(path: Path) -> BreakPoints:
    """Read a table of break points [Hz, g²/Hz].

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed: columns with other names, values that are no numbers
        or out of range, frequencies that do not increase, levels without a value or slope, slopes
        that contradict the levels.
    """
    table = numbers(read_rows(path), COLUMNS)
    table.refuse(fewest=2, too_few="must have at least two break points")
    frequency, previous = table[FREQUENCY], np.roll(table[FREQUENCY], 1)
    falls = np.diff(frequency, prepend=-np.inf) <= 0
    message = "frequency_hz = {frequency_hz:g} follows {previous:g}; frequencies must increase"
    table.note(falls, message, previous=previous)
    table.refuse()
    slope = table.columns.get(SLOPE, np.full(frequency.shape, np.nan))
    psd = _filled(frequency, table[LEVEL], slope)
    _note_levels(table, psd, slope)
    table.refuse()
    return BreakPoints(frequency, psd)


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
    message = f"{SLOPE} = {{slope_db_octave:g}} at the last row leads nowhere; omit it"
    table.note(is_last & np.isfinite(slope), message)
    octaves, rise = np.diff(np.log2(table[FREQUENCY])), np.diff(10 * np.log10(psd))
    leads_elsewhere = np.abs(slope[:-1] * octaves - rise) > SLOPE_TOLERANCE
    message = f"{SLOPE} = {{slope_db_octave:g}} between {{frequency_hz:g}} and {{to:g}} Hz, "
    message += "where the levels give {levels:+.2f}"
    table.note(leads_elsewhere, message, to=table[FREQUENCY][1:], levels=rise / octaves)
