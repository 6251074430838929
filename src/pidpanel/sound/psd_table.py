"""Tables of pressure PSDs in CSV files, and which of the two kinds of table a file is.

Beside tables of band levels (`table`) there are those with the columns ``frequency_hz`` and
``psd_pa2_hz``, straight between the rows on logarithmic axes. Two rows at one frequency are a step.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import (
    Allowed,
    ColumnsError,
    Fault,
    TableRows,
    faults_of_header,
    numbers,
    read_rows,
    refuse,
)
from pidpanel.sound.spectrum import Spectrum
from pidpanel.sound.table import read_spl_table
from pidpanel.spectra.break_points import BreakPoints

HEADER = ("frequency_hz", "psd_pa2_hz")

COLUMNS = {
    HEADER[0]: Allowed(0.0, low_itself=False),
    # 200 dB in a band of 1 Hz
    HEADER[1]: Allowed(0.0, low_itself=False, high=4e10),
}


def read_spectrum(path: str | Path) -> Spectrum:
    """Read a CSV table of band levels or of a pressure PSD, with its comments as the source.

    Raises
    ------
    ColumnsError
        With all faults of the file.
    """
    table = read_rows(Path(path))
    if any(name.lower().startswith("psd") for name in table.header):
        return _psd_spectrum(table)
    return read_spl_table(path)


def _psd_spectrum(table: TableRows) -> Spectrum:
    lines, columns, of_cells = numbers(table, COLUMNS)
    faults = faults_of_header(table, HEADER) + of_cells
    if not faults and len(lines) < 2:
        raise ColumnsError([f"{table.path}: must have at least 2 rows, not {len(lines)}"])
    if not faults:
        faults += _faults_of_order(lines, columns[HEADER[0]])
    refuse(table.path, faults)
    source = "\n".join(comment for _, comment in table.comments)
    return Spectrum(BreakPoints(columns[HEADER[0]], columns[HEADER[1]]), source)


def _faults_of_order(lines: Sequence[int], frequency: Array) -> Iterator[Fault]:
    """Yield rows that fall, and steps that are none."""
    rise = np.diff(frequency)
    for row in (np.flatnonzero(rise < 0) + 1).tolist():
        yield lines[row], f"frequency_hz = {frequency[row]:g} follows a higher one"
    for row in (np.flatnonzero(rise == 0) + 1).tolist():
        ends = row in (1, len(frequency) - 1)
        if ends or frequency[row + 1] == frequency[row]:
            where = "a step at an end" if ends else "more than two rows at one frequency"
            yield lines[row], f"frequency_hz = {frequency[row]:g}: {where} is not allowed"
