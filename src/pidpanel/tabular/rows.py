"""The rows of a table: its separator, mark of decimals, header and what lies around it.

Whatever is left out or read otherwise than as written is a remark. A row that may have values is
never left out.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pidpanel.tabular.cells import NUMBER, Label, column_of, has_decimal_comma, is_value, plain
from pidpanel.tabular.units import UnitError
from pidpanel.text_files import TextFileError, lines_of

Row = tuple[int, list[str]]  # number and cells of a line

# Lines of comments and, behind values, the blanks before one
COMMENT = re.compile(r"\s*(#|[%!](?!\W*\d)|//|sep=.$)")
SEPARATORS = {"\t": "tabs", ";": "semicolons", "|": "bars", " ": "blanks", ",": ""}
# The beginning of a row with the level of the whole table
OVERALL = re.compile(r"(?i)(oa\b|oa ?spl|over.?all|total|sum|gesamt|g?rms|all\b|lin(ear)?\b|Σ)")
csv.register_dialect("spreadsheet", strict=True, skipinitialspace=True)
BEGINNING = re.compile(r"[\"\s|]*[+−-]?[.,]?\d")  # of a line or a cell with a number
WORD = re.compile(r"[+-]?\d+(,\d*)?([eE][+-]?\d+)?", re.ASCII)


class TableRows(NamedTuple):
    """A table as text."""

    path: Path
    comments: list[tuple[int, str]]  # number and text of lines that begin with ``#``
    header: list[str]  # names of the columns, the usual ones for those that are known
    line: int  # of the header
    rows: list[Row]  # of each line with values
    titles: Sequence[str] = ()  # of the columns as written
    factor: Sequence[float] = ()  # unit of each column over that of its name
    remarks: tuple[str, ...] = ()  # what is left out or read otherwise than as written
    overall: tuple[tuple[int, float], ...] = ()  # lines and levels of the whole table

    @property
    def source(self) -> str:
        """The comments."""
        return "\n".join(comment for _, comment in self.comments)


def rows_of(
    path: Path, text: str, labels: Mapping[str, Label], *, has_overall: bool = False
) -> TableRows:
    """Return the rows of a table.

    Parameters
    ----------
    labels
        Columns with usual names and units; the first two are those of a table without a header.
        Without any, the first line is the header, whatever it has.
    has_overall
        Whether a row may state a level of the whole table.

    Raises
    ------
    TextFileError
        If it is empty, a column has another unit, or commas may be those of decimals or not.
    """
    comments, lines = _content(text)
    separator = _separator([content for _, content in lines])
    rows = [(line, _cells(line, content, separator)) for line, content in lines]
    rows = [row for row in rows if any(cell.strip("-=:") for cell in row[1])]
    if not rows:
        raise TextFileError("empty; the first line must name the columns")
    has_numbers = [BEGINNING.match(text) or OVERALL.match(text) for text in map(_first, rows)]
    is_comma = has_decimal_comma([row for row, has in zip(rows, has_numbers, strict=True) if has])
    rows = [(line, [plain(cell, is_comma=is_comma) for cell in cells]) for line, cells in rows]
    remarks = [f"columns between {SEPARATORS[separator]}"] * (separator != ",")
    remarks += ["decimal comma"] * is_comma
    line, titles, rows = _with_titles(rows, comments, separator, labels)
    overall: list[tuple[int, float]] = []
    if has_overall:
        rows, overall = _without_overall(rows)
    if labels:
        end = max((k for k, row in enumerate(rows, 1) if _may_have_values(row)), default=0)
        count = len(rows) - end
        remarks += [f"{count} line{'s' * (count > 1)} of text left out"] * (count > 0)
        rows = rows[:end]
    if labels and rows and line == rows[0][0]:
        remarks.append(f"no header, read as {', '.join(titles)}")
    columns = []
    for title in titles:
        try:
            columns.append(column_of(title, labels))
        except UnitError as error:
            raise TextFileError(f"column {title!r}: {error}", line) from None
    columns_used = []
    for k, (title, (name, factor)) in enumerate(zip(titles, columns, strict=True)):
        cells = [row[k] for _, row in rows if k < len(row) and row[k]]
        if not labels or name or any(map(is_value, cells)) or (title and not cells):
            columns_used += [k] if title or cells else []
        elif title or cells:
            remarks.append(f"column {title!r} left out")
        if name and title != name and (factor != 1 or labels[name].has_name(title)):
            scale = "" if factor == 1 else f" times {factor:g}"
            remarks.append(f"{title!r} as {name}{scale}")
    return TableRows(
        path,
        sorted(comments),
        [columns[k][0] or titles[k] for k in columns_used],
        line,
        [
            (
                number,
                [row[k] for k in columns_used if k < len(row)]
                + [c for c in row[len(titles) :] if c],
            )
            for number, row in rows
        ],
        [titles[k] for k in columns_used],
        [columns[k][1] for k in columns_used],
        tuple(remarks),
        tuple(overall),
    )


def _content(text: str) -> tuple[list[tuple[int, str]], list[tuple[int, str]]]:
    """Return the comments and the other lines with content, each with its number."""
    comments: list[tuple[int, str]] = []
    lines: list[tuple[int, str]] = []
    for number, content in enumerate(lines_of(text), start=1):
        mark, values = COMMENT.match(content), re.split(r"\s#", content, maxsplit=1)[0]
        if mark:
            comments += [] if "sep=" in mark[1] else [(number, content[mark.end() :].strip())]
        elif (
            lines
            and not BEGINNING.match(values)
            and re.search(r'(^|[,;|\t])\s*"[^"]*$', lines[-1][1])
        ):
            lines[-1] = lines[-1][0], f"{lines[-1][1]} {values}"  # a cell of two lines
        elif values.strip():
            lines.append((number, values))
    return comments, lines


def _separator(lines: Sequence[str]) -> str:
    """Return what is between the columns in most lines with values."""
    data = [line for line in lines if BEGINNING.match(line)] or lines
    for mark in "\t;|":
        if 2 * sum(mark in line for line in data) > len(data):
            return mark
    words = [line.split() for line in data]
    if all(len(row) > 1 and all(map(WORD.fullmatch, row)) for row in words):
        return "," if any("," in line for line in lines if line not in data) else " "
    has_one = all(len(row) == 1 for row in words)
    return "," if any("," in line for line in (lines if has_one else data)) else " "


def _cells(line: int, content: str, separator: str) -> list[str]:
    if separator == " ":
        wide = re.split(r"\s{2,}", content.strip())
        return wide if len(wide) > 1 else re.split(r"\s+(?![\[(/])", content.strip())
    try:
        cells = next(csv.reader([content], "spreadsheet", delimiter=separator), [])
    except csv.Error as error:
        raise TextFileError(str(error), line) from None
    return [cell.strip() for cell in cells]


def _first(row: Row) -> str:
    return next(filter(None, row[1]), "")


def _is_data(row: Row) -> bool:
    return is_value(_first(row))


def _may_have_values(row: Row) -> bool:
    return bool(BEGINNING.match(_first(row))) or any(map(NUMBER.fullmatch, row[1]))


def _with_titles(
    rows: list[Row], comments: list[tuple[int, str]], separator: str, labels: Mapping[str, Label]
) -> tuple[int, list[str], list[Row]]:
    """Return line and titles of the header, and the rows below; lines above become comments."""
    if not labels:
        return *rows[0], rows[1:]
    end = next((k for k, row in enumerate(rows) if _is_data(row)), len(rows))
    titled = _with_units(rows[:end], labels)
    is_column = end < len(rows) and len(rows[end][1]) == 1
    counts = [
        _count_names(cells, labels) if len(cells) > 1 or is_column else 0 for _, cells in titled
    ]
    if any(counts) or (titled and (len(titled[-1][1]) > 1 or end == len(rows))):
        place = max(range(len(titled)), key=lambda k: (counts[k], k))
        texts, values = _texts(titled[:place])
        comments += texts
        return *titled[place], values + titled[place + 1 :] + rows[end:]
    for line, comment in comments[::-1]:  # as NumPy writes a header
        cells = _cells(line, comment, separator)
        if line < rows[0][0] and _count_names(cells, labels) == len(rows[end][1]):
            return line, cells, rows[end:]
    texts, values = _texts(titled)
    comments += texts
    rows, end = values + rows[end:], 0
    named = [name for name, label in labels.items() if label.unit][:2]
    if len(named) == len(list(filter(None, rows[end][1]))) == 2:
        return rows[end][0], named, rows[end:]
    return *rows[end], rows[end + 1 :]


def _texts(rows: Sequence[Row]) -> tuple[list[tuple[int, str]], list[Row]]:
    """Return lines of text as comments, and those that may be values, without a word."""
    texts, values = [], []
    for line, cells in rows:
        text = " ".join(filter(None, cells))
        if re.search(r"[^\W\d_]{3}", text) or not BEGINNING.match(text):
            texts.append((line, text))
        else:
            values.append((line, cells))
    return texts, values


def _count_names(cells: Sequence[str], labels: Mapping[str, Label]) -> int:
    """Return how many cells name a column."""
    count = 0
    for cell in cells:
        try:
            count += bool(column_of(cell, labels)[0])
        except UnitError:
            count += 1
    return count


def _with_units(rows: Sequence[Row], labels: Mapping[str, Label]) -> list[Row]:
    """Return lines above the values, each with the units of a line of units below it."""
    merged: list[Row] = []
    for line, cells in rows:
        units = [cell.strip("[]() ") if cell[:2] != "((" else cell[1:-1] for cell in cells]
        are_units = all(
            not unit or any(label.factor(unit) is not None for label in labels.values())
            for unit in units
        )
        if merged and are_units and len(merged[-1][1]) == len(cells) > 1:
            titles = [f"{title} ({unit})" if unit else title
                      for title, unit in zip(merged[-1][1], units, strict=True)]  # fmt: skip
            merged[-1] = line, titles
        else:
            merged.append((line, cells))
    return merged


def _without_overall(rows: list[Row]) -> tuple[list[Row], list[tuple[int, float]]]:
    """Return the rows without those of the whole table, and the lines and levels of those."""
    overall, others = [], []
    for row in rows:
        line, cells = row
        numbers = [match for match in map(NUMBER.match, cells) if match]
        numbers = numbers or [*NUMBER.finditer(" ".join(cells))][-1:]
        is_zero = row is rows[-1] and re.fullmatch(r"0+\.?0*", _first(row)) and len(numbers) == 2
        if numbers and (is_zero or (not _is_data(row) and OVERALL.match(_first(row)))):
            overall.append((line, float(numbers[-1 if is_zero else 0][0])))
        else:
            others.append(row)
    return others, overall
