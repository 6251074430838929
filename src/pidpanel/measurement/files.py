"""Measured PSDs and transmissibilities from CSV tables and universal files (data set 58)."""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import Allowed, ColumnsError, TableRows, numbers, read_rows
from pidpanel.measurement import universal
from pidpanel.measurement.universal import LONE_RECORD, RecordChoice
from pidpanel.spectra.acceleration_table import ACCELERATION as ACCELERATION_DENSITY
from pidpanel.tabular import cells
from pidpanel.tabular.cells import Label
from pidpanel.tabular.units import DIMENSIONLESS, GRAVITY, HERTZ, KILOGRAM

COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False, label=cells.HERTZ),
    "acceleration_psd_g2_hz": Allowed(0.0, high=1e6, label=ACCELERATION_DENSITY),
    "transmissibility": Allowed(
        0.0, high=1e6, label=Label.named("1", "transmissibility q gain frf", "magnitude")
    ),
    "accelerance_1_kg": Allowed(
        0.0, high=1e6, label=Label.named("m/s^2/N", "accelerance inertance", "frf magnitude")
    ),
}
FREQUENCY_COLUMN, PSD_COLUMN, RATIO_COLUMN, FORCE_COLUMN = COLUMNS

ANY = (universal.UNKNOWN, universal.GENERAL)  # data types of an axis
FUNCTIONS = {1: "a time history", 2: "an auto spectrum without a width", 3: "a cross spectrum",
             6: "a coherence", 12: "of amplitudes", 24: "a shock response spectrum"}  # fmt: skip


class MeasuredPsd(NamedTuple):
    """A measured acceleration PSD."""

    # (nf,) rising [Hz] and [g²/Hz]
    frequency: Array
    psd: Array
    # name of a table: of a ratio the PSD is its square, of a transmissibility or accelerance
    column: str = PSD_COLUMN

    @property
    def over_base(self) -> bool:
        """Whether the PSD is over that of the supports."""
        return self.column == RATIO_COLUMN

    @property
    def columns(self) -> dict[str, Array]:
        """Values by the names of a table."""
        values = self.psd if self.column == PSD_COLUMN else np.sqrt(self.psd)
        return {FREQUENCY_COLUMN: self.frequency, self.column: values}


def read_measured(path: Path, choice: RecordChoice = LONE_RECORD, point: str = "") -> MeasuredPsd:
    """Read a measured PSD or transmissibility from a table or, by its suffix, a universal file.

    Parameters
    ----------
    choice
        Data set 58 of a universal file with several.
    point
        Name of the point, whose column is read of a table with several, as in ``response/export``.

    Raises
    ------
    ColumnsError
        With all faults of a file.
    """
    if path.suffix.lower() in universal.SUFFIXES:
        return _checked(path, *_universal(path, choice))
    if choice != LONE_RECORD:
        message = "record, node and direction are only allowed with a universal file"
        raise ColumnsError([f"{path}: {message}"])
    text = _of_point(read_rows(path, COLUMNS), point)
    ratios = (name for name in (RATIO_COLUMN, FORCE_COLUMN) if name in text.header)
    names = (FREQUENCY_COLUMN, next(ratios, PSD_COLUMN))
    table = numbers(text, {name: COLUMNS[name] for name in names})
    table.refuse()
    frequency, values = (table[name] for name in names)
    return _checked(path, frequency, values, names[1])


def _of_point(text: TableRows, point: str) -> TableRows:
    """Return frequency and PSD of a point from a table with the columns of several."""
    names = text.header
    columns = [
        place
        for place, (name, title) in enumerate(zip(names, text.titles, strict=True))
        if title == f"{PSD_COLUMN}_{point}"
        or (name == PSD_COLUMN and names.count(name) > 1 and point in re.split(r"[\s:(\[]+", title))
    ]
    if FREQUENCY_COLUMN not in names or len(columns) != 1:
        return text
    places = [names.index(FREQUENCY_COLUMN), *columns]
    rows = [
        (line, [row[place] for place in places] if len(row) == len(names) else row)
        for line, row in text.rows
    ]
    factor = [text.factor[place] for place in places]
    return text._replace(header=[FREQUENCY_COLUMN, PSD_COLUMN], rows=rows, factor=factor)


def _checked(path: Path, frequency: Array, values: Array, name: str) -> MeasuredPsd:
    """Return the curve, with a step where two lines have one frequency; refuse other faults."""
    if frequency.size < 2:
        raise ColumnsError([f"{path}: must have at least two lines, not {frequency.size}"])
    if not ((values >= 0) & (values <= COLUMNS[name].high)).all() or not values.any():
        message = f"the {'PSD' if name == PSD_COLUMN else name} must be finite, from 0 to "
        raise ColumnsError([f"{path}: {message}{COLUMNS[name].high:g}, and not 0 everywhere"])
    is_step = np.diff(frequency) == 0
    lower = np.where(np.append(is_step, False), np.nextafter(frequency, 0.0), frequency)
    is_doubled = is_step & (np.diff(values) == 0)
    wrong = np.flatnonzero(is_doubled | ~(np.diff(lower) > 0))
    if wrong.size:
        row = wrong[0]
        message = f"{frequency[row + 1]:g} Hz follows {frequency[row]:g} Hz"
        if is_step[row]:
            message = f"{frequency[row]:g} Hz is given twice"
        allowed = "two lines at one frequency are a step between two values"
        raise ColumnsError([f"{path}: frequencies must rise; {message}; {allowed}"])
    return MeasuredPsd(lower, values if name == PSD_COLUMN else values**2, name)


def _universal(path: Path, choice: RecordChoice) -> tuple[Array, Array, str]:
    """Return frequency, PSD [g²/Hz], transmissibility or accelerance, and its column."""
    function = universal.read_function(path, choice)
    kind, axes = function.kind, function.axes
    numerator, denominator = axes["ordinate"], axes["orddenom"]
    is_ratio = kind in (universal.RESPONSE, universal.TRANSMISSIBILITY)
    # without a unit a spectrum may be one of amplitudes or of powers
    if kind in (universal.AUTO, universal.SPECTRUM) and not numerator.label:
        message = f"function type {kind} must have the unit of its ordinate, per Hz"
        raise function.refusal(f"{message}; without it it may be {FUNCTIONS[kind]}")
    if kind not in (universal.AUTO, universal.SPECTRUM, universal.PSD) and not is_ratio:
        types = f"{universal.PSD}, {universal.RESPONSE} or {universal.TRANSMISSIBILITY}"
        message = "must be a power spectral density, frequency response or transmissibility, "
        message += f"function type {types}"
        raise function.refusal(f"{message}; {kind} is {FUNCTIONS.get(kind, 'another function')}")
    if numerator.kind not in (*ANY, universal.ACCELERATION):
        raise function.refusal("must be an acceleration, data type 12 of the ordinate")
    magnitude = np.abs(function.values).astype(float)
    if is_ratio and denominator.kind == universal.FORCE:
        unit, allowed = KILOGRAM.power(-1), "units such as m/s^2 and N, g and lbf"
        factor = function.factor(unit, "acceleration over force", allowed)
        return function.frequency, factor * magnitude, FORCE_COLUMN
    if is_ratio:
        if denominator.kind not in (*ANY, universal.ACCELERATION):
            message = "must be over a force or the acceleration of the base, data type 13 or 12 of"
            raise function.refusal(f"{message} the denominator")
        factor = function.factor(
            DIMENSIONLESS, "a transmissibility", "one unit of acceleration over another"
        )
        return function.frequency, factor * magnitude, RATIO_COLUMN
    if denominator.kind not in (*ANY, universal.FREQUENCY):
        raise function.refusal("must have no denominator, data type 0")
    if np.abs(function.values.imag).max() > 1e-6 * np.abs(function.values).max():
        raise function.refusal("must be real; a complex one is a cross spectrum")
    unit = GRAVITY.power(2).divide(HERTZ)
    factor = function.factor(unit, "a PSD", "g^2/Hz, (m/s^2)^2/Hz, mm^2/s^4/Hz or the like")
    return function.frequency, factor * function.values.real.astype(float), PSD_COLUMN
