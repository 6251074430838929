"""The table of cases of a coupon: a row is a case, a column a dotted key of the coupon."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from pidpanel.columns import NUMBER, ColumnsError, LineFaults, faults_of_names, read_rows
from pidpanel.study.sweep import Sweep

POINT = ("sweep.fill_fraction", "sweep.frequency_hz")
AMPLITUDES = ("sweep.acceleration_g", "sweep.displacement_mm")


class CaseRow(NamedTuple):
    """A row of the table."""

    line: int  # in the file
    values: Mapping[str, Any]  # key → number, text, or tuple of them

    @property
    def inputs(self) -> dict[str, Any]:
        """Values besides the drive and the accuracy."""
        sections = ("sweep.", "accuracy.")
        return {key: value for key, value in self.values.items() if not key.startswith(sections)}


def read_cases(file: Path) -> list[CaseRow]:
    """Read the rows of a table of cases.

    Raises
    ------
    ColumnsError
        A line for each column that is missing, and for each empty cell or repeated row.
    """
    table = read_rows(file)
    header, faults = table.header, LineFaults(file)
    missing = (f"missing column {name}" for name in POINT if name not in header)
    for says in (*faults_of_names(header, header), *missing):
        faults.add(table.line, says)
    if len(set(AMPLITUDES) & set(header)) != 1:
        faults.add(table.line, f"must have either column {' or '.join(AMPLITUDES)}")
    if faults:
        raise ColumnsError(faults.texts())
    rows: list[CaseRow] = []
    lines: dict[tuple[str, ...], int] = {}
    for line, cells in table.rows:
        says = ""
        if len(cells) != len(header):
            says = f"has {len(cells)} values, must have {len(header)} as the header"
        elif "" in cells:
            says = f"{header[cells.index('')]}: empty; must have a value"
        elif tuple(cells) in lines:
            says = f"duplicate of line {lines[tuple(cells)]}"
        if says:
            faults.add(line, says, says)
            continue
        lines[tuple(cells)] = line
        rows.append(CaseRow(line, dict(zip(header, map(_value, cells), strict=True))))
    if faults:
        raise ColumnsError(faults.texts())
    if not rows:
        raise ColumnsError([f"{file}: must have at least one row"])
    return rows


def sweep_of(rows: Sequence[CaseRow]) -> Sweep:
    """Return the drives of all rows as a sweep; each row is checked with its coupon."""
    values: dict[str, Any] = {
        key.removeprefix("sweep."): tuple(dict.fromkeys(row.values[key] for row in rows))
        for key in rows[0].values
        if key.startswith("sweep.")
    }
    return Sweep.model_construct(None, **values)


def _value(cell: str) -> Any:
    """Return what a cell means.

    Examples
    --------
    >>> _value("0.5"), _value("hexagon"), _value("0 0 -1")
    (0.5, 'hexagon', (0.0, 0.0, -1.0))
    """
    words = re.split(r"\s+", cell)
    values = [float(word) if NUMBER.fullmatch(word) else word for word in words]
    return values[0] if len(values) == 1 else tuple(values)
