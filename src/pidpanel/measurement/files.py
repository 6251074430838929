"""Measured PSDs and transmissibilities from CSV tables and universal files (data set 58)."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyuff

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, ColumnsError, numbers, read_rows
from pidpanel.constants import STANDARD_GRAVITY

COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False),
    "acceleration_psd_g2_hz": Allowed(0.0, high=1e6),
    "transmissibility": Allowed(0.0, high=1e6),
}
FREQUENCY_COLUMN, PSD_COLUMN, RATIO_COLUMN = COLUMNS
UNIVERSAL = (".uff", ".unv", ".uf58")

# Codes of data set 58: two kinds of function, and the kind of ordinate
RESPONSE, PSD, ACCELERATION = 4, 9, 12
FUNCTIONS = {1: "a time history", 2: "an auto spectrum without a width", 3: "a cross spectrum",
             6: "a coherence"}  # fmt: skip

IN_G = re.compile(r"g(n|\^2|\*\*2|²)?\s*(/|$)", re.IGNORECASE)  # label of an axis in g²/Hz


class MeasuredPsd(NamedTuple):
    """A measured acceleration PSD."""

    # (nf,) rising [Hz] and [g²/Hz]
    frequency: Array
    psd: Array
    # Whether the PSD is over that of the supports [1]: the square of a transmissibility
    over_base: bool = False

    @property
    def columns(self) -> dict[str, Array]:
        """Values by the names of a table."""
        name, values = PSD_COLUMN, self.psd
        if self.over_base:
            name, values = RATIO_COLUMN, np.sqrt(values)
        return {FREQUENCY_COLUMN: self.frequency, name: values}


def read_measured(path: Path, record: int | None = None) -> MeasuredPsd:
    """Read a measured PSD or transmissibility from a table or, by its suffix, a universal file.

    ``record`` is the number of the data set 58, from 1. A `ColumnsError` has all faults of a file.
    """
    if path.suffix.lower() in UNIVERSAL:
        return _checked(path, *_universal(path, record))
    text = read_rows(path)
    over_base = RATIO_COLUMN in text.header
    names = (FREQUENCY_COLUMN, RATIO_COLUMN if over_base else PSD_COLUMN)
    table = numbers(text, {name: COLUMNS[name] for name in names})
    table.refuse()
    frequency, values = (table[name] for name in names)
    return _checked(path, frequency, values, over_base)


def _checked(path: Path, frequency: Array, values: Array, over_base: bool) -> MeasuredPsd:
    if frequency.size < 2:
        raise ColumnsError([f"{path}: must have at least two lines, not {frequency.size}"])
    falls = np.flatnonzero(np.diff(frequency) <= 0)
    if falls.size:
        low = frequency[falls[0] + 1]
        raise ColumnsError([f"{path}: frequencies must rise; {low:g} Hz follows a higher one"])
    if not (np.isfinite(values).all() and (values >= 0).all() and values.any()):
        message = f"the {'transmissibility' if over_base else 'PSD'} must be finite, not negative, "
        raise ColumnsError([f"{path}: {message}and not 0 everywhere"])
    return MeasuredPsd(frequency, values**2 if over_base else values, over_base)


def read_data_set(path: Path, record: int | None) -> Mapping[str, Any]:
    """Read a data set 58 of a universal file, in the fields of pyuff.

    Raises
    ------
    ColumnsError
        If the file cannot be read, or it is not clear which data set is meant.
    """
    try:
        file = pyuff.UFF(str(path))
        numbers_of_58 = [n for n, kind in enumerate(file.get_set_types()) if kind == 58]
        message = "" if numbers_of_58 else "has no data set 58"
        if record is None and len(numbers_of_58) > 1:
            message = f"has {len(numbers_of_58)} data sets 58; the key record selects one"
        if numbers_of_58 and (record or 1) > len(numbers_of_58):
            message = f"has {len(numbers_of_58)} data sets 58; record is {record}"
        if message:
            raise ColumnsError([f"{path}: {message}"])
        data: dict[str, Any] = file.read_sets(numbers_of_58[(record or 1) - 1])
        arrays = {key: np.asarray(data[key]) for key in ("x", "data")}
        return {**data, **arrays, "func_type": int(data["func_type"])}
    except ColumnsError:
        raise
    except Exception as error:  # whatever the library meets in a broken file
        message = f"is no universal file that can be read ({type(error).__name__})"
        raise ColumnsError([f"{path}: {message}"]) from None


def _universal(path: Path, record: int | None) -> tuple[Array, Array, bool]:
    """Return frequency, PSD [g²/Hz] or transmissibility, and which, of a data set 58."""

    def refuse(message: str) -> ColumnsError:
        return ColumnsError([f"{path}: {message}"])

    data = read_data_set(path, record)
    x, values = data["x"], data["data"]
    kind, label = data["func_type"], str(data["ordinate_axis_units_lab"])
    if kind not in (PSD, RESPONSE):
        message = (
            f"a power spectral density or frequency response, function type {PSD} or {RESPONSE}"
        )
        raise refuse(f"must be {message}; {kind} is {FUNCTIONS.get(kind, 'another function')}")
    if int(data["ordinate_spec_data_type"]) not in (0, ACCELERATION):
        raise refuse("must be an acceleration, data type 12 of the ordinate")
    if kind == RESPONSE:
        denominator = str(data["orddenom_axis_units_lab"])
        if int(data["orddenom_spec_data_type"]) not in (0, ACCELERATION):
            message = "must be over the acceleration of the base, data type 12 of the denominator"
            raise refuse(message)
        stated = {text.strip() for text in (label, denominator)} - {"", "NONE"}
        if len({is_in_g(text) for text in stated}) > 1:
            raise refuse(f"must have one unit above and below, not {label} and {denominator}")
        return x.astype(float), np.abs(values).astype(float), True
    factor = 1.0 if is_in_g(label) else STANDARD_GRAVITY**-2
    return x.astype(float), values.real.astype(float) * factor, False


def is_in_g(label: str) -> bool:
    """Return whether the label of an axis states g, or g²/Hz."""
    return IN_G.match(label.strip().lstrip("(")) is not None
