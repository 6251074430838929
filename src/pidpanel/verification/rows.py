"""What a stage computes against what is known: one row for each number, in one neutral form.

A stage with a closed form or a published benchmark has a module ``pidpanel.verification.<stage>``
with ``CASES``: functions that compute in a folder and return rows. `verify` runs one of them,
`write_rows` and `read_rows` keep the rows as CSV, `confirm` checks them, and
`pidpanel.verification.page` shows those of all stages.
"""

import importlib
import math
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Self, SupportsFloat

import pandas as pd
import yaml

from pidpanel.paths import DATA
from pidpanel.report.text import records

# Case, unit, tolerance, method and source of all rows, by the names of comparisons.
COMPARISONS = yaml.safe_load((DATA / "reference" / "comparisons.yaml").read_text(encoding="utf-8"))


class ToleranceMissedError(Exception):
    """Computed numbers miss their references; the text names each of them in a line."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One computed number and its reference.

    Attributes
    ----------
    case
        Problem, common to its rows, such as "Inelastic slug in a box without gravity".
    quantity
        Compared quantity and its point.
    computed, reference
        Values in ``unit``.
    unit
        Unit; "1" for a quantity without dimension.
    tolerance
        Largest |error| that agrees with the reference; NaN for a row that is only shown, such as
        convergence with the resolution, or the limit of validity of the reference.
    at
        The point as a number, for figures; NaN if there is none.
    resolution
        Bodies, elements or steps as a number, for figures; NaN if there is none.
    """

    case: str
    quantity: str = ""
    computed: float = math.nan
    reference: float = math.nan
    unit: str
    tolerance: float
    method: str
    source: str
    at: float = math.nan
    resolution: float = math.nan

    @property
    def error(self) -> float:
        """(computed − reference)/|reference|; the computed value where the reference is 0."""
        if self.reference == 0:
            return self.computed
        return (self.computed - self.reference) / abs(self.reference)

    @property
    def has_tolerance(self) -> bool:
        """Whether the row has a tolerance."""
        return not math.isnan(self.tolerance)

    @property
    def met(self) -> bool:
        """Whether the error is within the tolerance; False for NaN."""
        return abs(self.error) <= self.tolerance

    def row(
        self,
        quantity: str,
        computed: SupportsFloat,
        reference: SupportsFloat,
        at: float = math.nan,
        resolution: float = math.nan,
    ) -> Self:
        """Return the row of a computed number, which has the rest in common with this row."""
        values = vars(self) | {"quantity": quantity, "at": at, "resolution": resolution}
        return type(self)(**values | {"computed": float(computed), "reference": float(reference)})


def comparison(name: str, **values: object) -> Row:
    """Return what rows have in common: `COMPARISONS` by name, with the values in its method."""
    texts: dict[str, Any] = COMPARISONS[name]
    return Row(**{**texts, "method": texts["method"].format(**values)})


# Columns of the file of rows, besides the error.
COLUMNS = tuple(field.name for field in fields(Row))


def cases_of(functions: Mapping[str, Any]) -> dict[str, Callable[[Path], Iterable[Row]]]:
    """Return the cases of a module by name: each a function ``<case>_rows`` of a folder."""
    names = [name for name in functions if name.endswith("_rows") and name[0] != "_"]
    return {name.removesuffix("_rows"): functions[name] for name in names}


def verify(stage: str, case: str) -> list[Row]:
    """Compute a case of a stage in a temporary folder; raise `ValueError` if it has none."""
    cases = importlib.import_module(f"pidpanel.verification.{stage}").CASES
    if case not in cases:
        raise ValueError(f"{case}: not a verification case of {stage}: {', '.join(cases)}")
    with tempfile.TemporaryDirectory() as folder:
        return list(cases[case](Path(folder)))


def confirm(rows: Sequence[Row]) -> str:
    """Check that all rows with a tolerance meet their reference, and return how many they are.

    Examples
    --------
    >>> beam = Row(case="Beam", unit="Hz", tolerance=0.01, method="30 elements", source="Navier")
    >>> confirm([beam.row("f", 100.5, 100.0)])
    '1 of 1 numbers within their tolerance'
    """
    compared = [row for row in rows if row.has_tolerance]
    missed = [row for row in compared if not row.met]
    if missed:
        lines = [
            f"{row.case}, {row.quantity}: {row.computed:g} {row.unit}, reference "
            f"{row.reference:g}, error {row.error:+.2%}, tolerance {row.tolerance:.2%}"
            for row in missed
        ]
        lines.append(f"{len(missed)} of {len(compared)} numbers miss their tolerance")
        raise ToleranceMissedError("\n".join(lines))
    return f"{len(compared)} of {len(compared)} numbers within their tolerance"


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write rows as CSV, with a column for each attribute of `Row` and the error."""
    table = pd.DataFrame(rows).assign(error=[row.error for row in rows])
    table.to_csv(path, index=False, na_rep="nan", lineterminator="\n")


def read_rows(path: Path) -> list[Row]:
    """Read rows that `write_rows` wrote.

    Raises
    ------
    ValueError
        If the file has other columns; they are listed.
    """
    table = pd.read_csv(path, dtype=str, keep_default_na=False)
    if list(table) != [*COLUMNS, "error"]:
        raise ValueError(f"{path}:1: columns {list(table)}, not {[*COLUMNS, 'error']}")
    numbers = {field.name: float for field in fields(Row) if field.type is float}
    return [Row(**values) for values in records(table[list(COLUMNS)].astype(numbers))]
