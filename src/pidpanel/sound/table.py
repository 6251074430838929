"""Tables of band levels in CSV files.

A table has comment lines that begin with `#` (title, source), the header `center_hz,spl_db`
and one line per band. Refusals name the file, the line, the value and what is allowed.
"""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pidpanel.sound.spectrum import BAND_WIDTH, BandKind, BandSpectrum, SpectrumError
from pidpanel.third_octaves import center_frequency

HEADER = ("center_hz", "spl_db")

CENTER_TOLERANCE = 0.02
"""Relative distance allowed between a stated centre and the exact one.

Nominal centres (ISO 266) lie within 0.95 % of 10^(N/10), base-2 ones within 1.4 % above
16 Hz, and half the way to the next third is 12 %.
"""

LEVEL_RANGE = (0.0, 200.0)
"""Band levels allowed [dB]: 191 dB is one atmosphere rms, so more is a typing error."""

BAND_WORDS: dict[str, BandKind] = {"1/3 octave": "third octave", "1/1 octave": "octave"}
"""How a comment line `# band: …` may state the kind, which must be what the centres say."""


def read_spl_table(path: str | Path) -> BandSpectrum:
    """Read a table of octave or third-octave band levels.

    The kind of band is found from the ratio of neighbouring centres. Stated centres may be
    nominal (31.5, 63, 125 …) or exact; the exact base-10 centre is used.

    Parameters
    ----------
    path
        CSV file, UTF-8.

    Returns
    -------
    BandSpectrum with the comment lines as its `source`.

    Raises
    ------
    SpectrumError
        Where the file is missing or not text, the header is another, a value is not a number,
        a level is outside 0-200 dB, a centre is not a preferred one, centres are unsorted,
        double or leave a gap, there are fewer than two bands, or a comment states another kind.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SpectrumError(f"{path}: no such file; a CSV table of band levels is needed") from None
    except (OSError, UnicodeDecodeError) as error:
        raise SpectrumError(f"{path}: cannot be read as UTF-8 text ({error})") from error

    comments: list[str] = []
    stated_kind: dict[int, BandKind] = {}
    for line, content in _lines(text):
        if content.startswith("#"):
            comment = content.lstrip("# ")
            comments.append(comment)
            for words, kind in BAND_WORDS.items():
                if comment.startswith(f"band: {words}"):
                    stated_kind[line] = kind

    line_of_row, center, level = _read_rows(path, text)
    band_number = _band_numbers(path, line_of_row, center)
    kind = _band_kind(path, line_of_row, center, band_number)
    for line, stated in stated_kind.items():
        if stated != kind:
            raise SpectrumError(
                f"{path}, line {line}: the comment states {stated} bands, "
                f"the centres are those of {kind} bands"
            )
    return BandSpectrum(kind, np.array(band_number), np.array(level), source="\n".join(comments))


def _lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the number and the stripped content of each line that is not empty."""
    for line, content in enumerate(text.splitlines(), start=1):
        if content.strip():
            yield line, content.strip()


def _read_rows(path: Path, text: str) -> tuple[list[int], list[float], list[float]]:
    """Return line numbers, stated centres [Hz] and levels [dB]."""
    rows = [(line, content) for line, content in _lines(text) if not content.startswith("#")]
    header = ",".join(HEADER)
    if not rows or tuple(cell.strip() for cell in rows[0][1].split(",")) != HEADER:
        found = f"{rows[0][1]!r}, line {rows[0][0]}" if rows else "nothing"
        raise SpectrumError(f"{path}: the header must be {header!r}, found {found}")
    if len(rows) < 3:
        raise SpectrumError(
            f"{path}: {len(rows) - 1} band(s); at least two are needed to tell octaves from thirds"
        )
    line_of_row: list[int] = []
    center: list[float] = []
    level: list[float] = []
    for line, content in rows[1:]:
        cells = content.split(",")
        if len(cells) != len(HEADER):
            raise SpectrumError(f"{path}, line {line}: {content!r} must be two values, {header}")
        values = [_number(path, line, name, cell) for name, cell in zip(HEADER, cells, strict=True)]
        if not LEVEL_RANGE[0] <= values[1] <= LEVEL_RANGE[1]:
            raise SpectrumError(
                f"{path}, line {line}: spl_db = {values[1]:g} must lie within "
                f"{LEVEL_RANGE[0]:g} to {LEVEL_RANGE[1]:g} dB"
            )
        line_of_row.append(line)
        center.append(values[0])
        level.append(values[1])
    return line_of_row, center, level


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SpectrumError(f"{path}, line {line}: {name} = {cell.strip()!r} must be a number")
    return value


def _band_numbers(path: Path, line_of_row: list[int], center: list[float]) -> list[int]:
    """Return N of the nearest exact centre 10^(N/10) for each stated centre."""
    numbers = []
    for line, stated in zip(line_of_row, center, strict=True):
        if stated <= 0:
            raise SpectrumError(f"{path}, line {line}: center_hz = {stated:g} must be positive")
        number = round(10 * math.log10(stated))
        exact = float(center_frequency(number))
        if abs(stated / exact - 1) > CENTER_TOLERANCE:
            raise SpectrumError(
                f"{path}, line {line}: center_hz = {stated:g} is not a preferred centre; "
                f"the nearest is {exact:.4g} Hz (within {CENTER_TOLERANCE:.0%})"
            )
        numbers.append(number)
    return numbers


def _band_kind(
    path: Path, line_of_row: list[int], center: list[float], band_number: list[int]
) -> BandKind:
    """Return the kind of band from the steps between neighbours; refuse what does not adjoin."""
    steps = np.diff(band_number)
    for row, step in enumerate(steps, start=1):
        if step <= 0:
            what = "appears twice" if step == 0 else "follows a higher centre"
            raise SpectrumError(
                f"{path}, line {line_of_row[row]}: center_hz = {center[row]:g} {what}; "
                "centres must rise, each once"
            )
    kind: BandKind = "third octave" if steps.min() < BAND_WIDTH["octave"] else "octave"
    for row, step in enumerate(steps, start=1):
        if step != BAND_WIDTH[kind]:
            raise SpectrumError(
                f"{path}, line {line_of_row[row]}: between {center[row - 1]:g} and "
                f"{center[row]:g} Hz there is a gap; {kind} bands must adjoin"
            )
    if kind == "octave" and band_number[0] % 3:
        raise SpectrumError(
            f"{path}, line {line_of_row[0]}: center_hz = {center[0]:g} is not an octave centre "
            "(31.5, 63, 125, 250, 500, 1000 … Hz)"
        )
    return kind
