"""Tables of pressure PSDs in CSV files, and which of the two kinds of table a file is.

Beside tables of band levels (`table`) there are those with the columns ``frequency_hz`` and
``psd_pa2_hz``, straight between the rows on logarithmic axes. Two rows at one frequency are a step.
"""

from pathlib import Path

import numpy as np

from pidpanel.columns import Allowed, UserTable, numbers, read_rows
from pidpanel.sound.spectrum import Spectrum
from pidpanel.sound.table import read_spl_table
from pidpanel.spectra.break_points import BreakPoints

COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False),
    # 200 dB in a band of 1 Hz
    "psd_pa2_hz": Allowed(0.0, low_itself=False, high=4e10),
}


def read_spectrum(path: str | Path) -> Spectrum:
    """Read a CSV table of band levels or of a pressure PSD, with its comments as the source.

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed.
    """
    text = read_rows(Path(path))
    if not any(name.lower().startswith("psd") for name in text.header):
        return read_spl_table(path)
    table = numbers(text, COLUMNS)
    table.refuse(fewest=2, too_few=f"must have at least 2 rows, not {len(table.lines)}")
    _note_order(table)
    table.refuse()
    return Spectrum(BreakPoints(*(table[name] for name in COLUMNS)), text.source)


def _note_order(table: UserTable) -> None:
    """Note rows that fall, and steps that are none."""
    rise = np.diff(table["frequency_hz"], prepend=-np.inf)
    table.note(rise < 0, "frequency_hz = {frequency_hz:g} follows a higher one")
    is_step = rise == 0
    at_end = is_step.copy()
    at_end[2:-1] = False
    of_three = is_step & ~at_end & np.append(is_step[1:], False)
    for wrong, step in (
        (at_end, "a step at an end"),
        (of_three, "more than two rows at one frequency"),
    ):
        table.note(wrong, f"frequency_hz = {{frequency_hz:g}}: {step} is not allowed")
