"""Cells and headers of tables as people write them: forms of numbers, units, usual names.

>>> plain("−1,5E-02", is_comma=True), plain("1.5×10^-2"), plain("1.0D+01"), plain("12a")
('-1.5E-02', '1.5e-2', '1.0e+01', '12a')
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from pidpanel.tabular.units import SUPERSCRIPTS, UnitError, unit_of_label
from pidpanel.text_files import TextFileError

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# A number with a unit, such as 31.5 Hz, 1.25k or 0.04 g²/Hz
QUANTITY = re.compile(rf"({NUMBER.pattern})\s*([A-Za-zµμ%(\[].*)")
# Two frequencies, such as 20-80 Hz or 20 Hz to 80 Hz
RANGE = re.compile(
    rf"({NUMBER.pattern.removeprefix('[+-]?')})\s*(k?Hz|k)?\s*(?:-|–|to|bis|\.\.\.?|…)\s*"
    rf"({NUMBER.pattern.removeprefix('[+-]?')})\s*(k?Hz|k)?",
    re.ASCII | re.IGNORECASE,
)
# The digits of a number, and those in groups of thousands
HEAD = re.compile(r"[+-]?[\d.,]*\d[\d.,]*", re.ASCII)
GROUPED = re.compile(r"[+-]?[1-9]\d{0,2}([,.])\d{3}((?:\1\d{3})*)", re.ASCII)
POWER_OF_TEN = re.compile(r"\s*[x×*·]\s*10\s*(?:\^|\*\*)?\s*\(?([+-]?\d+)\)?")
SPACED = re.compile(r"(?<=\d)[\u00a0\u2009\u202f](?=\d{3}(?!\d))")  # blanks in thousands
DECIBELS = re.compile(
    r"(?i)dB ?(SPL|\(?(Z|lin(ear)?)\)?)?,?[ (]*((re\.?|ref\.?|rel\. to)[ :]*"
    r"(20 ?[uµμ]Pa|(2 ?(e|[x×*·] ?10\^?)-0?5|0?\.00002|20e-0?6) ?Pa))?\)?"
)
PER_OCTAVE = re.compile(r"(?i)dB ?(/|per) ?o[ck]t(ave)?s?\.?")
# What is no value of a column, whatever its unit
ASIDE = re.compile(r"(?i)a.?weight|dB ?\(?[AC]\)?\b|LAeq|sqrt|√|toler|error|sigma|uncert|±")
NO_UNIT = ("", "-", "–", "1")


class Label(NamedTuple):
    """Usual names of a column and its unit."""

    unit: str = ""
    # words of its name, of which one in `keys` is enough without a unit
    keys: frozenset[str] = frozenset()
    words: frozenset[str] = frozenset()

    @classmethod
    def named(cls, unit: str, keys: str, words: str = "") -> "Label":
        """Return a label of words with blanks between them."""
        return cls(unit, frozenset(keys.split()), frozenset(f"{keys} {words}".split()))

    def factor(self, text: str) -> float | None:
        """Return a stated unit over that of the label; None for another dimension."""
        if self.unit in ("dB", "dB/octave"):
            form = DECIBELS if self.unit == "dB" else PER_OCTAVE
            return 1.0 if form.fullmatch(text) else None
        if self.unit == "Hz" and text == "k":
            text = "kHz"
        try:
            unit, expected = unit_of_label(text), unit_of_label(self.unit or "1")
        except UnitError:
            return None
        return unit.factor / expected.factor if unit.dimension == expected.dimension else None

    def has_name(self, name: str) -> bool:
        """Return whether a header without a unit is a usual one."""
        words = _words(name)
        return bool(words & self.keys) and words <= self.words and not set(name) & set("([{%")


HERTZ = Label.named(
    "Hz", "f fc fm freq frequency frequencies frequenz center centre",
    "of band bands octave oct third one 1 3 mid nominal break breakpoint point range hz",
)  # fmt: skip


def _words(name: str) -> set[str]:
    return set(re.findall(r"[^\W\d_]+|\d+", name.lower()))


def is_value(cell: str) -> bool:
    """Return whether a cell is a number, one with a unit, or a range of two."""
    return any(form.fullmatch(cell) for form in (NUMBER, QUANTITY, RANGE))


def plain(cell: str, *, is_comma: bool = False) -> str:
    """Return a number in the one form that Python reads; other text as it is."""
    if not is_comma and NUMBER.fullmatch(cell):
        return cell
    text = SPACED.sub("", cell.replace("−", "-").replace("–", "-").strip())
    text = re.sub(
        r"[\d.,]*\d[\d.,]*", lambda run: _with_point(run[0], ".,"[:: 1 if is_comma else -1]), text
    )
    text = POWER_OF_TEN.sub(r"e\1", text.translate(SUPERSCRIPTS) if "10" in text else text)
    text = re.sub(r"(?<=[\d.])[dD](?=[+-]?\d)", "e", text)
    return text if is_value(text) else cell


def _with_point(digits: str, marks: str) -> str:
    """Return digits with a point and no groups; marks are those of thousands and decimals."""
    group, decimal = map(re.escape, marks)
    if re.fullmatch(rf"(\d{{1,3}}({group}\d{{3}})+|\d*)({decimal}\d*)?", digits):
        return digits.replace(marks[0], "").replace(marks[1], ".")
    return digits


def ends_of_range(cell: str) -> tuple[str, str] | None:
    """Return the two frequencies of a range; the unit of the last is that of both by default.

    >>> ends_of_range("20-80 Hz"), ends_of_range("20 Hz to 2 kHz"), ends_of_range("1-2 kHz")
    (('20Hz', '80Hz'), ('20Hz', '2kHz'), ('1kHz', '2kHz'))
    """
    match = RANGE.fullmatch(cell)
    if match is None:
        return None
    units = [
        {"h": "Hz", "k": "kHz"}.get((unit or "")[:1].lower(), "") for unit in match.group(4, 8)
    ]
    return match[1] + (units[0] or units[1]), match[5] + units[1]


def value_of(cell: str, label: Label, factor: float = 1.0) -> float:
    """Return the number of a cell [unit of the label]; NaN if it is none.

    Parameters
    ----------
    factor
        Unit of the column over that of the label, where the cell states none.

    Examples
    --------
    >>> value_of("1.25k", Label("Hz")), value_of("0.04 g²/Hz", Label("g^2/Hz"))
    (1250.0, 0.04)
    """
    if NUMBER.fullmatch(cell):
        return factor * float(cell)
    stated = QUANTITY.fullmatch(cell)
    if stated is None or not label.unit:
        return np.nan
    scale = label.factor(stated[4].strip())
    return np.nan if scale is None else scale * float(stated[1])


def _parts(header: str) -> Iterator[tuple[str, str]]:
    """Yield name and unit of a header, split wherever it may be."""
    yield from ((header, ""), ("", header))
    for mark in re.finditer(r"\s*[,/:;]\s*|\s+in\s+|\s+|(?=[\[(])", header):
        unit = header[mark.end() :].strip()
        if unit[:1] in ("[", "(") and unit[-1:] in ("]", ")"):
            yield header[: mark.start()], unit[1:-1].strip()
        yield header[: mark.start()], unit


def column_of(header: str, columns: Mapping[str, Label]) -> tuple[str, float]:
    """Return the column that a header means, and its unit over that of the column.

    Raises
    ------
    UnitError
        If it has a usual name and another unit.

    Examples
    --------
    >>> column_of("PSD [(m/s²)²/Hz]", {"psd": Label.named("(m/s^2)^2/Hz", "psd")})
    ('psd', 1.0)
    """
    slug = re.sub("[^a-z0-9%]+", "_", header.translate(SUPERSCRIPTS).lower()).strip("_")
    if slug in columns:
        return slug, 1.0
    if not header or QUANTITY.fullmatch(header):
        return "", 1.0
    is_aside, misfit = ASIDE.search(header) is not None, ""
    for text, unit in _parts(header):
        words = _words(text)
        for column, label in columns.items():
            rivals = (q.keys - label.keys for q in columns.values())
            if not label.unit or words & frozenset().union(*rivals):
                continue
            factor = None if is_aside or unit in NO_UNIT else label.factor(unit)
            # ratios of any two units have that of a ratio
            if factor is not None and (label.unit != "1" or label.has_name(text)):
                return column, factor
            if label.has_name(text):
                if unit in NO_UNIT:
                    return column, 1.0
                misfit = misfit or f"must be in {label.unit}".replace("in 1", "a ratio")
    if misfit:
        raise UnitError(misfit)
    return "", 1.0


def has_decimal_comma(rows: Iterable[tuple[int, Sequence[str]]]) -> bool:
    """Return whether commas in the numbers of lines are those of decimals, not of thousands.

    Raises
    ------
    TextFileError
        With its line, if a comma may be either, or commas and points are both of decimals.

    Examples
    --------
    >>> has_decimal_comma([(1, ["31,5", "120"])]), has_decimal_comma([(1, ["1,000", "31.5"])])
    (True, False)
    """
    rows = list(rows)
    if not any("," in cell or cell.count(".") > 1 for _, cells in rows for cell in cells):
        return False  # at once, as of most tables
    marks: dict[str, tuple[int, str]] = {}  # the first number that shows each
    for line, cells in rows:
        for head in filter(None, map(HEAD.match, cells)):
            number = head[0]
            kind = number[max(map(number.rfind, ",."))] if re.search("[,.]", number) else ""
            if kind and len(set(number) & set(",.")) == 1 and (group := GROUPED.fullmatch(number)):
                kind = f"{kind}?" if not group[2] else ",."[kind == ","]
            marks.setdefault(kind, (line, number))
    if "," in marks and "." in marks:
        line, number = max(marks[","], marks["."])
        first = min(marks[","], marks["."])[1]
        raise TextFileError(f"{number!r} has another mark of decimals than {first!r}", line)
    if "," not in marks and "." not in marks and ",?" in marks:
        line, number = marks[",?"]
        choice = f"{number.replace(',', '')} or {number.replace(',', '.')}"
        raise TextFileError(f"{number!r} may be {choice}; write it with a decimal point", line)
    return "," in marks
