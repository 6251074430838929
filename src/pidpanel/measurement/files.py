"""Measured acceleration PSDs from CSV tables and universal files (data set 58)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyuff

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, ColumnsError, faults_of_names, numbers, read_rows
from pidpanel.constants import STANDARD_GRAVITY

COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False),
    "acceleration_psd_g2_hz": Allowed(0.0, high=1e6),
}
UNIVERSAL = (".uff", ".unv", ".uf58")

PSD, AUTO_SPECTRUM, FREQUENCY, ACCELERATION = 9, 2, 18, 12
"""Codes of data set 58: two kinds of function, kind of abscissa and of ordinate."""
FUNCTIONS = {1: "a time history", 2: "an auto spectrum without a width", 3: "a cross spectrum",
             4: "a frequency response", 6: "a coherence"}  # fmt: skip

IN_G = re.compile(r"g(n|\^2|\*\*2|²)?\s*(/|$)", re.IGNORECASE)
"""Label of an axis in g²/Hz."""


class MeasuredPsd(NamedTuple):
    """A measured acceleration PSD over frequency: (nf,) rising [Hz] and [g²/Hz]."""

    frequency: Array
    psd: Array


def read_measured(path: Path, record: int | None = None) -> MeasuredPsd:
    """Read a measured PSD.

    Parameters
    ----------
    path
        A table in CSV, or a universal file by the end of its name.
    record
        Number of the data set 58, from 1; needed where there are several.

    Raises
    ------
    ColumnsError
        With all faults of the file.
    """
    if path.suffix.lower() in UNIVERSAL:
        return _checked(path, *_universal(path, record))
    table = read_rows(path)
    faults = [(table.line, says) for says in faults_of_names(table.header, list(COLUMNS))]
    if not faults:
        missing = [name for name in COLUMNS if name not in table.header]
        faults = [(table.line, f"column {name}: missing") for name in missing]
    _, columns, of_cells = numbers(table, COLUMNS)
    if faults or of_cells:
        ordered = sorted([*faults, *of_cells], key=lambda fault: fault[0])
        raise ColumnsError([f"{path}, line {line}: {says}" for line, says in ordered])
    return _checked(path, *(columns[name] for name in COLUMNS))


def _checked(path: Path, frequency: Array, psd: Array) -> MeasuredPsd:
    if frequency.size < 2:
        raise ColumnsError([f"{path}: must have at least two lines, not {frequency.size}"])
    falls = np.flatnonzero(np.diff(frequency) <= 0)
    if falls.size:
        low = frequency[falls[0] + 1]
        raise ColumnsError([f"{path}: frequencies must rise; {low:g} Hz follows a higher one"])
    if not (np.isfinite(psd).all() and (psd >= 0).all() and psd.any()):
        raise ColumnsError([f"{path}: the PSD must be finite, not negative, and not 0 everywhere"])
    return MeasuredPsd(frequency, psd)


def _universal(path: Path, record: int | None) -> tuple[Array, Array]:
    """Return frequency and PSD [g²/Hz] of a data set 58."""

    def refuse(says: str) -> ColumnsError:
        return ColumnsError([f"{path}: {says}"])

    try:
        file = pyuff.UFF(str(path))
        numbers_of_58 = [n for n, kind in enumerate(file.get_set_types()) if kind == 58]
        if not numbers_of_58:
            raise refuse("has no data set 58")
        if record is None and len(numbers_of_58) > 1:
            raise refuse(f"has {len(numbers_of_58)} data sets 58; the key record selects one")
        if (record or 1) > len(numbers_of_58):
            raise refuse(f"has {len(numbers_of_58)} data sets 58; record is {record}")
        data: dict[str, Any] = file.read_sets(numbers_of_58[(record or 1) - 1])
        x, values = (np.asarray(data[key]) for key in ("x", "data"))
        kind, label = int(data["func_type"]), str(data["ordinate_axis_units_lab"])
    except ColumnsError:
        raise
    except Exception as error:  # whatever the library meets in a broken file
        raise refuse(f"is no universal file that can be read ({type(error).__name__})") from None
    if kind != PSD:
        says = FUNCTIONS.get(kind, "another function")
        raise refuse(f"must be a power spectral density, function type {PSD}; {kind} is {says}")
    if int(data["ordinate_spec_data_type"]) not in (0, ACCELERATION):
        raise refuse("must be an acceleration, data type 12 of the ordinate")
    in_g = IN_G.match(label.strip().lstrip("("))
    factor = 1.0 if in_g else STANDARD_GRAVITY**-2
    return x.astype(float), values.real.astype(float) * factor
