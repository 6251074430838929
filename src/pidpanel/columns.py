"""Tables of a user, with units in the names of the columns: read, or refused line by line."""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.tabular.cells import NUMBER, Label, value_of
from pidpanel.tabular.rows import TableRows, rows_of
from pidpanel.text_files import TextFileError, one_line, read_table_text

__all__ = ["NUMBER", "TableRows"]

MOST_FAULTS = 20  # most mistakes reported per file
MOST_ALIKE = 3  # most mistakes of one kind reported on a line each
LARGEST = 20_000_000  # most bytes of a table


class ColumnsError(ValueError):
    """A table, or another file of a user, with mistakes."""

    def __init__(self, faults: Sequence[str]) -> None:
        if len(faults) > MOST_FAULTS:
            file = re.split(", line |:", faults[0])[0]
            summary = f"{file}: {len(faults) - MOST_FAULTS} further mistakes"
            faults = [*faults[:MOST_FAULTS], summary]
        self.faults = tuple(one_line(fault) for fault in faults)
        super().__init__("\n".join(self.faults))


@dataclass(frozen=True)
class Bounds:
    """Bounds of a number.

    Examples
    --------
    >>> Bounds(0, 1, low_itself=False).allowed, Bounds(0.5, 30).allowed, Bounds(2).allowed
    ('must be above 0 and at most 1', 'must be from 0.5 to 30', 'must be at least 2')
    """

    low: float = -np.inf
    high: float = np.inf
    low_itself: bool = True  # whether the bound is allowed
    high_itself: bool = True

    @property
    def allowed(self) -> str:
        """Allowed values in words."""
        low = f"{'at least' if self.low_itself else 'above'} {self.low:g}"
        if self.high == np.inf:
            return f"must be {low}"
        if self.low_itself and self.high_itself:
            return f"must be from {self.low:g} to {self.high:g}"
        return f"must be {low} and {'at most' if self.high_itself else 'below'} {self.high:g}"

    def holds(self, value: float) -> bool:
        """Return whether a value lies within the bounds."""
        above_low = value >= self.low if self.low_itself else value > self.low
        return above_low and (value <= self.high if self.high_itself else value < self.high)


@dataclass(frozen=True)
class Allowed(Bounds):
    """Allowed numbers of a column."""

    hint: str = ""  # hint for values above ``high``
    may_be_missing: bool = False  # of the whole column
    may_be_empty: bool = False  # of cells, which are NaN then
    label: Label = field(default_factory=Label)  # of a column that may have other names and units

    def refuses(self, value: float) -> str:
        """Return what is allowed in place of a value; empty if it is."""
        hint = f" ({self.hint})" if self.hint and value > self.high else ""
        return "" if self.holds(value) else self.allowed + hint


class LineFaults:
    """Faults of a file by line."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.hints: dict[int, str] = {}  # hints after the faults of a line
        self._alike: dict[str, list[tuple[int, str]]] = {}

    def __bool__(self) -> bool:
        return bool(self._alike)

    def add(self, line: int, message: str, kind: str = "") -> None:
        """Add a fault; of many of a kind the first is reported, with the lines of all."""
        if kind:
            self._alike.setdefault(kind, []).append((line, message))
        else:
            self._alike[f"{line}: {message}"] = [(line, message)]

    def texts(self) -> list[str]:
        """Return all faults with their places, in the order of the lines."""
        faults = [fault for group in self._alike.values() for fault in _alike_once(group)]
        return [
            f"{self.path}, line {line}: {message}{self.hints.get(line, '')}"
            for line, message in sorted(faults, key=lambda fault: fault[0])
        ]


def read_rows(
    path: Path, columns: Mapping[str, Allowed] | None = None, *, has_overall: bool = False
) -> TableRows:
    """Read the cells of a table.

    Parameters
    ----------
    columns
        Columns, those with a `Label` by any of its usual names and units. Without any the first
        line names the columns.
    has_overall
        Whether a row may state a level of the whole table.

    Raises
    ------
    ColumnsError
        If the file cannot be read, is no text, or `rows_of` refuses it.
    """
    try:
        text, encoding = read_table_text(path, LARGEST)
        labels = {name: column.label for name, column in (columns or {}).items()}
        rows = rows_of(path, text, labels, has_overall=has_overall)
    except TextFileError as error:
        place = path if error.line is None else f"{path}, line {error.line}"
        raise ColumnsError([f"{place}: {error.message}"]) from None
    return rows._replace(remarks=(*([encoding] if encoding else []), *rows.remarks))


def faults_of_names(
    header: Sequence[str],
    allowed: Sequence[str],
    elsewhere: Mapping[str, str] | None = None,
    titles: Sequence[str] = (),
) -> Iterator[str]:
    """Yield the names of columns that are unknown or given twice; all of them if they are numbers.

    ``elsewhere`` has messages for columns of other tables, ``titles`` the names in the file.

    Examples
    --------
    >>> list(faults_of_names(["centre_hz", "spl_db"], ["center_hz", "spl_db"]))
    ["column 'centre_hz': unknown; did you mean center_hz?"]
    """
    if are_numbers(header):
        yield f"must name the columns, found the numbers {', '.join(header)}"
        return
    for place, name in enumerate(header):
        if name not in allowed:
            yield (elsewhere or {}).get(name) or _unknown(name, place, allowed)
        elif name in header[:place]:
            pair = sorted({titles[header.index(name)], titles[place]}) if titles else []
            both = f", {' and '.join(map(repr, pair))}; keep one" if len(pair) > 1 else ""
            yield f"column {name}: given twice{both}"


def are_numbers(header: Sequence[str]) -> bool:
    """Return whether there are numbers where names of columns should be."""
    return all(NUMBER.fullmatch(name) for name in header)


def nearest(name: str, allowed: Sequence[str]) -> str:
    """Return the column that is meant; empty if none is near."""
    if not name or name in allowed:
        return name
    key = name.lower()
    near = [c for c in allowed if key.startswith(c) or c.startswith(key)]
    near += difflib.get_close_matches(key, allowed, n=1, cutoff=0.6)
    return near[0] if near else ""


def _unknown(name: str, place: int, allowed: Sequence[str]) -> str:
    """Return the message for an unknown column."""
    if not name:
        return f"column {place + 1} has no name"
    near = nearest(name, allowed)
    message = f"did you mean {near}?" if near else f"allowed are {', '.join(allowed)}"
    return f"column {name!r}: unknown; {message}"


def in_kilohertz(frequency: ArrayLike, low: float, high: float) -> bool:
    """Return whether frequencies below a range [Hz] lie in it if they are in kHz.

    Examples
    --------
    >>> in_kilohertz([0.02, 2.0], 20.0, 2000.0), in_kilohertz([5.0, 15.0], 20.0, 2000.0)
    (True, False)
    """
    highest = float(np.max(frequency))
    return highest < low <= 1e3 * highest <= 2 * high


@dataclass(frozen=True)
class UserTable:
    """The numbers of a table, and what is wrong in which line."""

    text: TableRows
    lines: list[int]  # of the rows
    columns: dict[str, Array]  # (n_rows,) each
    faults: LineFaults

    def __getitem__(self, name: str) -> Array:
        return self.columns[name]

    def note(self, wrong: ArrayLike, message: str, *, first: bool = False, **values: Array) -> None:
        """Note a fault in the rows, or the first, in which something is wrong.

        Parameters
        ----------
        wrong
            (n_rows,) bool.
        says
            A format of columns and of further values (n_rows,), such as ``"{frequency_hz:g} Hz"``.
        """
        for row in np.flatnonzero(wrong)[: 1 if first else None].tolist():
            named = {name: column[row] for name, column in {**self.columns, **values}.items()}
            self.faults.add(self.lines[row], message.format(**named))

    def refuse(self, fewest: int = 0, too_few: str = "") -> None:
        """Raise a `ColumnsError` with all faults, if there are any or there are too few rows."""
        faults = self.faults.texts()
        if len(self.lines) < fewest and not (faults and self.text.rows):
            remarks = [text for text in self.text.remarks if text.endswith("of text left out")]
            faults.append("; ".join([f"{self.text.path}: {too_few}", *remarks]))
        if faults:
            raise ColumnsError(faults)


def numbers(
    text: TableRows, columns: Mapping[str, Allowed], header_faults: Sequence[str] | None = None
) -> UserTable:
    """Return the numbers of a table.

    Parameters
    ----------
    columns
        Allowed values of each column.
    header_faults
        Faults of the header; by default names that are unknown or given twice; if there are none,
        columns that are missing.
    """
    header, faults = text.header, LineFaults(text.path)
    if header_faults is None:
        header_faults = list(faults_of_names(header, tuple(columns), titles=text.titles)) or [
            f"column {name}: missing"
            for name, allowed in columns.items()
            if not allowed.may_be_missing and name not in header
        ]
    for message in header_faults:
        faults.add(text.line, message)
    lines, rows = [], []
    for line, cells in text.rows:
        if len(cells) != len(header):
            commas = " (decimal commas?)" if len(cells) > len(header) else ""
            message = f"has {len(cells)} values, must have {len(header)} as the header{commas}"
            faults.add(line, message, message)
            continue
        lines.append(line)
        values = zip(header, cells, text.factor or [1.0] * len(cells), strict=True)
        rows.append([
            value_of(cell, columns.get(name, Allowed()).label, factor)
            for name, cell, factor in values
        ])  # fmt: skip
        for name, cell, value in zip(header, cells, rows[-1], strict=True):
            if name in columns and (message := _fault_of_cell(cell, value, columns[name])):
                # one line represents all mistakes of a kind
                faults.add(line, f"{name} = {message}", f"{name}: {message.rpartition(': ')[2]}")
    array = np.array(rows).reshape(len(lines), len(header))
    return UserTable(text, lines, dict(zip(header, array.T, strict=True)), faults)


def _alike_once(group: Sequence[tuple[int, str]]) -> Sequence[tuple[int, str]]:
    """Return faults of a kind, each a line and a text: of many the first, with the lines of all."""
    if len(group) <= MOST_ALIKE:
        return group
    (line, message), *repeats = group
    lines = [number for number, _ in repeats]
    where = f"{', '.join(map(str, lines[:3]))} and {len(lines) - 3} more"
    if lines[-1] - lines[0] == len(lines) - 1:
        where = f"{lines[0]} to {lines[-1]}"
    return [(line, f"{message}; likewise in lines {where}")]


def _fault_of_cell(cell: str, value: float, allowed: Allowed) -> str:
    """Return the cell and what is allowed in its place; empty if there is nothing wrong."""
    if not cell and allowed.may_be_empty:
        return ""
    if not np.isfinite(value):
        text = repr(cell if len(cell) <= 40 else f"{cell[:40]}…")
        comma = " with a decimal point" if re.fullmatch(r"[+-]?\d+,\d+", cell) else ""
        return f"{text}: must be a finite number{comma}" if cell else "(empty): must be a number"
    message = allowed.refuses(value)
    return f"{cell}: {message}" if message else ""
