"""Tables of band levels and of pressure PSDs in CSV files.

A table has comment lines that begin with `#` (title, source), a line with the names of the columns
`center_hz` and `spl_db`, and one line per band. A table of a PSD has the columns ``frequency_hz``
and ``psd_pa2_hz``, straight between the rows on logarithmic axes. Two rows at one frequency are a
step. Refusals name the file, the line, the value and what is allowed.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pidpanel.arrays import Index
from pidpanel.columns import Allowed, TableRows, UserTable, numbers, read_rows
from pidpanel.sound.spectrum import BAND_WIDTH, BandKind, BandSpectrum, Spectrum
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.spectra.third_octaves import center_frequency

# Relative distance allowed between a stated centre and the exact one.
#
# Nominal centres (ISO 266) lie within 0.95 % of 10^(N/10), base-2 ones within 1.4 % above
# 16 Hz, and half the way to the next third is 12 %.
CENTER_TOLERANCE = 0.02

# Band levels allowed [dB]: 191 dB is one atmosphere rms, so more is a typing error. A scaled or
# filtered spectrum may have bands far below the threshold of hearing, 0 dB.
LEVEL_RANGE = (-100.0, 200.0)

# Levels of neighbouring bands of a launcher or a chamber differ by less [dB].
LARGEST_STEP_DB = 40.0

BAND_COLUMNS = {
    "center_hz": Allowed(0.0, low_itself=False),
    "spl_db": Allowed(LEVEL_RANGE[0], high=LEVEL_RANGE[1], hint="in Pa?"),
}

PSD_COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False),
    # 200 dB in a band of 1 Hz
    "psd_pa2_hz": Allowed(0.0, low_itself=False, high=4e10),
}

# Words of a comment line `# band: …` for the kind, which must agree with the centres.
BAND_WORDS: dict[str, BandKind] = {"1/3 octave": "third octave", "1/1 octave": "octave"}


def read_spl_table(path: str | Path) -> BandSpectrum:
    """Read a CSV table of octave or third-octave band levels, with its comments as the source.

    The kind of band is found from the ratio of neighbouring centres. Stated centres may be nominal
    (31.5, 63, 125 …) or exact; the exact base-10 centre is used.

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed: a missing file, no text, other columns, values that
        are no numbers, levels outside `LEVEL_RANGE`, centres that are not preferred ones. Without
        these, centres that are unsorted, double or leave a gap, fewer than two bands, or a comment
        that states another kind.
    """
    table = numbers(read_rows(Path(path)), BAND_COLUMNS)
    table.faults.hints.update(_overall_hints(table.text))
    band_number = _band_numbers(table)
    bands = f"{len(table.lines) or 'no'} band{'s' * (not table.lines)}"
    reason = f"{bands}; at least two are needed to tell octaves from thirds"
    table.refuse(fewest=2, too_few=reason)
    kind = _band_kind(table, band_number)
    _note_comments(table, kind)
    _note_odd_levels(table)
    table.refuse()
    return BandSpectrum.of_levels(kind, band_number, table["spl_db"], table.text.source)


def _overall_hints(text: TableRows) -> Iterator[tuple[int, str]]:
    """Yield what to do with rows that are no band but the level of all."""
    for line, cells in text.rows:
        named = any(re.match(r"(?i)oa|over|total|sum|all|lin", cell) for cell in cells)
        if named or (cells is text.rows[-1][1] and "0" in cells):
            yield (
                line,
                "; omit the row of the overall level; oaspl_db of the section sound shifts to an "
                "overall level",
            )


def _note_odd_levels(table: UserTable) -> None:
    """Note bands far below or above both neighbours, as with a digit missing."""
    level = table["spl_db"]
    lower, upper = np.roll(level, 1), np.roll(level, -1)
    lowest, highest = np.minimum(lower, upper), np.maximum(lower, upper)
    for side, is_odd in (
        ("below", level < lowest - LARGEST_STEP_DB),
        ("above", level > highest + LARGEST_STEP_DB),
    ):
        is_odd[[0, -1]] = False
        message = f"spl_db = {{spl_db:g}}: more than {LARGEST_STEP_DB:g} dB {side} both neighbours,"
        table.note(is_odd, message + " {lower:g} and {upper:g} dB", lower=lower, upper=upper)


def _note_comments(table: UserTable, kind: BandKind) -> None:
    """Note comments that state another kind of band than the centres have."""
    for line, comment in table.text.comments:
        for words, stated in BAND_WORDS.items():
            if comment.startswith(f"band: {words}") and stated != kind:
                message = f"the comment states {stated} bands, the centres are those of {kind} "
                table.faults.add(line, f"{message}bands")


def _band_numbers(table: UserTable) -> Index:
    """Return N (n,) of the nearest exact centre 10^(N/10); note centres that have none."""
    center = table.columns.get("center_hz", np.empty(0))
    # what is not above 0 is noted already
    number = np.round(10 * np.log10(np.where(center > 0, center, 1.0))).astype(int)
    exact = center_frequency(number)
    message = "center_hz = {center_hz:g} is not a preferred centre; the nearest is {exact:.4g} Hz"
    is_far = (center > 0) & (np.abs(center / exact - 1) > CENTER_TOLERANCE)
    table.note(is_far, f"{message} (within {100 * CENTER_TOLERANCE:.0f} %)", exact=exact)
    return number


def _band_kind(table: UserTable, band_number: Index) -> BandKind:
    """Return the kind of band from the steps between neighbours; note what does not adjoin."""
    steps = np.diff(band_number)
    for wrong, fault in ((steps == 0, "appears twice"), (steps < 0, "follows a higher centre")):
        table.note(
            np.append(False, wrong), f"center_hz = {{center_hz:g}} {fault}; centres must increase"
        )
    if table.faults:
        return "third octave"
    kind: BandKind = "third octave" if steps.min() < BAND_WIDTH["octave"] else "octave"
    gaps = np.append(False, steps != BAND_WIDTH[kind])
    message = "between {lower:g} and {center_hz:g} Hz there is a gap; "
    lower = np.roll(table["center_hz"], 1)
    table.note(gaps, f"{message}{kind} bands must adjoin", lower=lower)
    if kind == "octave" and band_number[0] % 3:
        is_first = np.arange(band_number.size) == 0
        message = "center_hz = {center_hz:g} is not an octave centre "
        table.note(is_first, message + "(31.5, 63, 125, 250, 500, 1000 … Hz)")
    return kind


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
    table = numbers(text, PSD_COLUMNS)
    table.refuse(fewest=2, too_few=f"must have at least 2 rows, not {len(table.lines)}")
    _note_order(table)
    table.refuse()
    return Spectrum(BreakPoints(*(table[name] for name in PSD_COLUMNS)), text.source)


def _note_order(table: UserTable) -> None:
    """Note rows that fall, and steps that are none."""
    rise = np.diff(table["frequency_hz"], prepend=-np.inf)
    table.note(rise < 0, "frequency_hz = {frequency_hz:g} follows a higher one")
    is_step = rise == 0
    at_end = is_step.copy()
    at_end[2:-1] = False
    is_triple = is_step & ~at_end & np.append(is_step[1:], False)
    for wrong, step in (
        (at_end, "a step at an end"),
        (is_triple, "more than two rows at one frequency"),
    ):
        table.note(wrong, f"frequency_hz = {{frequency_hz:g}}: {step} is not allowed")
