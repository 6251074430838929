"""Tables of band levels in CSV files.

A table has comment lines that begin with `#` (title, source), a line with the names of the columns
`center_hz` and `spl_db`, and one line per band. Refusals name the file, the line, the value and
what is allowed.
"""

import math
import re
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
from pidpanel.sound.spectrum import BAND_WIDTH, BandKind, BandSpectrum
from pidpanel.spectra.third_octaves import center_frequency

HEADER = ("center_hz", "spl_db")

# Relative distance allowed between a stated centre and the exact one.
#
# Nominal centres (ISO 266) lie within 0.95 % of 10^(N/10), base-2 ones within 1.4 % above
# 16 Hz, and half the way to the next third is 12 %.
CENTER_TOLERANCE = 0.02

# Band levels allowed [dB]: 191 dB is one atmosphere rms, so more is a typing error. A scaled or
# filtered spectrum may have bands far below the threshold of hearing, 0 dB.
LEVEL_RANGE = (-100.0, 200.0)

# Levels of neighbouring bands of a launcher or a chamber differ by less [dB].
DEEPEST_DIP_DB = 40.0

COLUMNS = {
    HEADER[0]: Allowed(0.0, low_itself=False),
    HEADER[1]: Allowed(LEVEL_RANGE[0], high=LEVEL_RANGE[1], hint="in Pa?"),
}


# How a comment line `# band: …` may state the kind, which must be what the centres say.
BAND_WORDS: dict[str, BandKind] = {"1/3 octave": "third octave", "1/1 octave": "octave"}


def read_spl_table(path: str | Path) -> BandSpectrum:
    """Read a CSV table of octave or third-octave band levels, with its comments as the source.

    The kind of band is found from the ratio of neighbouring centres. Stated centres may be nominal
    (31.5, 63, 125 …) or exact; the exact base-10 centre is used.

    Raises
    ------
    ColumnsError
        With all faults of the file: where it is missing or not text, columns have other names, a
        value is not a number, a level is outside `LEVEL_RANGE`, a centre is not a preferred one; if
        there are none of these, where centres are unsorted, double or leave a gap, there are fewer
        than two bands, or a comment states another kind.
    """
    table = read_rows(Path(path))
    lines, columns, of_cells = numbers(table, COLUMNS)
    faults = faults_of_header(table, HEADER)
    faults += [(line, f"{says}{_of_overall(table, line)}") for line, says in of_cells]
    band_number: list[int] = []
    if not set(HEADER) - set(table.header):
        band_number, of_centers = _band_numbers(lines, columns[HEADER[0]])
        faults += of_centers
    if not faults and len(lines) < 2:
        bands = "1 band" if lines else "no bands"
        says = f"{bands}; at least two are needed to tell octaves from thirds"
        raise ColumnsError([f"{path}: {says}"])
    if not faults:
        kind, faults = _band_kind(lines, columns[HEADER[0]], band_number)
        faults += _faults_of_comments(table, kind)
        faults += _faults_of_dips(lines, columns[HEADER[1]])
    refuse(Path(path), faults)
    source = "\n".join(comment for _, comment in table.comments)
    return BandSpectrum.of_levels(kind, np.array(band_number), columns[HEADER[1]], source)


def _of_overall(table: TableRows, line: int) -> str:
    """Return what to do with a row that is no band but the level of all; nothing for others."""
    cells = dict(table.rows)[line]
    named = any(re.match(r"(?i)oa|over|total|sum|all|lin", cell) for cell in cells)
    is_last = line == table.rows[-1][0] and "0" in cells
    if not named and not is_last:
        return ""
    return (
        "; omit the row of the overall level; oaspl_db of the section sound shifts to an "
        "overall level"
    )


def _faults_of_dips(lines: Sequence[int], level: Array) -> Iterator[Fault]:
    """Yield bands far below both neighbours, as with a digit missing."""
    for row in range(1, len(level) - 1):
        below, above = level[row - 1], level[row + 1]
        if level[row] < min(below, above) - DEEPEST_DIP_DB:
            yield (
                lines[row],
                f"spl_db = {level[row]:g}: more than {DEEPEST_DIP_DB:g} dB below both neighbours,"
                f" {below:g} and {above:g} dB",
            )


def _faults_of_comments(table: TableRows, kind: BandKind) -> Iterator[Fault]:
    """Yield comments that state another kind of band than the centres have."""
    for line, comment in table.comments:
        for words, stated in BAND_WORDS.items():
            if comment.startswith(f"band: {words}") and stated != kind:
                yield (
                    line,
                    f"the comment states {stated} bands, the centres are those of {kind} bands",
                )


def _band_numbers(lines: Sequence[int], center: Array) -> tuple[list[int], list[Fault]]:
    """Return N of the nearest exact centre 10^(N/10) for each stated centre, and what has none."""
    band_numbers, faults = [], []
    for line, stated in zip(lines, center, strict=True):
        if not stated > 0:  # reported already
            continue
        number = round(10 * math.log10(stated))
        exact = float(center_frequency(number))
        if abs(stated / exact - 1) > CENTER_TOLERANCE:
            faults.append(
                (line, f"center_hz = {stated:g} is not a preferred centre; the nearest is "
                       f"{exact:.4g} Hz (within {CENTER_TOLERANCE:.0%})")
            )  # fmt: skip
        band_numbers.append(number)
    return band_numbers, faults


def _band_kind(
    lines: Sequence[int], center: Array, band_number: Sequence[int]
) -> tuple[BandKind, list[Fault]]:
    """Return the kind of band from the steps between neighbours, and what does not adjoin."""
    steps = np.diff(band_number)
    faults = []
    for row, step in enumerate(steps, start=1):
        if step <= 0:
            fault = "appears twice" if step == 0 else "follows a higher centre"
            says = f"center_hz = {center[row]:g} {fault}; centres must increase"
            faults.append((lines[row], says))
    if faults:
        return "third octave", faults
    kind: BandKind = "third octave" if steps.min() < BAND_WIDTH["octave"] else "octave"
    for row, step in enumerate(steps, start=1):
        if step != BAND_WIDTH[kind]:
            says = (
                f"between {center[row - 1]:g} and {center[row]:g} Hz there is a gap; {kind} bands "
                "must adjoin"
            )
            faults.append((lines[row], says))
    if kind == "octave" and band_number[0] % 3:
        says = (
            f"center_hz = {center[0]:g} is not an octave centre "
            "(31.5, 63, 125, 250, 500, 1000 … Hz)"
        )
        faults.append((lines[0], says))
    return kind, faults
