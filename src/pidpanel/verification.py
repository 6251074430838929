"""What a stage computes against what is known: one row for each truth, in one neutral form.

A stage that can be held to a closed form or a published benchmark has a module
``pidpanel.<stage>.verification`` with ``CASES``: functions that compute in a folder and return
rows. The page of `pidpanel.report.verification` shows the rows of all stages.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Row:
    """One number held to its truth.

    Attributes
    ----------
    case
        What is looked at, common to its rows: "Inelastic slug in a box without gravity".
    quantity
        What is compared, with the point at which it is.
    computed, reference
        In ``unit``; "1" for a quantity without dimension.
    tolerance
        Largest |error| with which the truth counts as met; NaN where the row is shown only, to
        tell how the error falls with the resolution or where the truth ends.
    method
        With what it was computed: bodies, elements, steps.
    source
        Of the reference.
    at
        The point as a number, for figures; NaN if there is none.
    resolution
        Bodies, elements or steps as a number, for figures; NaN if there is none.
    """

    case: str
    quantity: str
    computed: float
    reference: float
    unit: str
    tolerance: float
    method: str
    source: str
    at: float = math.nan
    resolution: float = math.nan

    @property
    def error(self) -> float:
        """(computed − reference)/|reference|; the computed value itself where that is 0."""
        if self.reference == 0:
            return self.computed
        return (self.computed - self.reference) / abs(self.reference)

    @property
    def held(self) -> bool:
        """Whether a tolerance stands for the row."""
        return not math.isnan(self.tolerance)

    @property
    def met(self) -> bool:
        """Whether the error is within the tolerance; never for a NaN."""
        return abs(self.error) <= self.tolerance


COLUMNS = tuple(field.name for field in fields(Row))


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Rows as CSV, a column for each attribute of `Row` and the error."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*COLUMNS, "error"])
        writer.writerows([*astuple(row), row.error] for row in rows)


def read_rows(path: Path) -> list[Row]:
    """The inverse of `write_rows`.

    Raises
    ------
    ValueError
        With the file and its header, if that is not the one of `write_rows`.
    """
    numbers = {field.name for field in fields(Row) if field.type == "float"}

    def row(texts: dict[str, str]) -> Row:
        values: dict[str, Any] = {name: texts[name] for name in COLUMNS}
        return Row(**values | {name: float(texts[name]) for name in numbers})

    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames != [*COLUMNS, "error"]:
            raise ValueError(f"{path}:1: {reader.fieldnames}, not {[*COLUMNS, 'error']}")
        return [row(texts) for texts in reader]
