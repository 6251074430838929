"""Functions of universal files, data set 58, with the units of their labels or of data set 164."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyuff

from pidpanel.arrays import Array
from pidpanel.columns import ColumnsError
from pidpanel.tabular.units import (
    DIMENSIONLESS,
    HERTZ,
    Unit,
    UnitError,
    contradicts,
    unit_of_label,
    unit_system,
)

SUFFIXES = (".uff", ".unv", ".uf58")

# Codes of data set 58: functions, and what an axis has
AUTO, RESPONSE, TRANSMISSIBILITY, PSD, SPECTRUM = 2, 4, 5, 9, 12
UNKNOWN, GENERAL, ACCELERATION, FORCE, FREQUENCY = 0, 1, 12, 13, 18
FUNCTION, UNITS = 58, 164  # numbers of data sets

BODY = 13  # line of a data set from which on it has numbers
AXES = {"abscissa": 9, "ordinate": 10, "orddenom": 11}  # lines of a data set
LABEL = 46  # column from which on an axis has its unit; longer ones than the format has are whole
NO_LABELS = ("", "NONE")
DIRECTIONS = {"x": 1, "y": 2, "z": 3}  # codes of directions
MOST_LISTED = 6  # data sets in a message
PADDING = 6  # numbers of a line, the last of which some programs fill


class Axis(NamedTuple):
    """What an axis has, by its code, and the label of its unit."""

    kind: int
    label: str


class UniversalFunction(NamedTuple):
    """A function of a data set 58."""

    path: Path
    kind: int
    frequency: Array  # (n,) [Hz]
    values: Array  # (n,) real or complex
    axes: Mapping[str, Axis]
    units: tuple[Unit, Unit] | None  # of length and force, of the data set 164 before it

    def refusal(self, message: str) -> ColumnsError:
        """Return the error of a message."""
        return ColumnsError([f"{self.path}: {message}"])

    def factor(self, expected: Unit, quantity: str, allowed: str) -> float:
        """Return the ordinate's unit over the expected one.

        Parameters
        ----------
        expected
            Unit with the dimension of the ordinate.
        quantity, allowed
            Its name and examples of labels, for the message.

        Raises
        ------
        ColumnsError
            If labels are missing, unknown, of another dimension, or contradict data set 164.
        """
        numerator, denominator = self.axes["ordinate"], self.axes["orddenom"]
        texts = [axis.label for axis in (numerator, denominator) if axis.label]
        labels = " over ".join(map(repr, texts))
        is_density = self.kind == PSD
        try:
            unit, divisor = self._unit_of(numerator, is_density), self._unit_of(denominator, False)
        except UnitError as error:
            raise self.refusal(f"unit {labels}: {error}; {quantity} must be in {allowed}") from None
        if len({"rms" in text.lower() for text in texts}) > 1:
            raise self.refusal(f"unit {labels}: must be rms on both sides, or on neither")
        is_ratio = expected.dimension == DIMENSIONLESS.dimension
        if is_ratio and numerator == denominator == Axis(ACCELERATION, ""):
            return 1.0  # whatever the unit of both
        if unit is None:
            message = f"the unit of the ordinate is missing; {quantity} must be in {allowed}"
            raise self.refusal(message)
        is_complete = not denominator.label and unit.dimension == expected.dimension
        if divisor is not None and not is_complete:
            labelled = numerator if numerator.label else denominator
            if len(texts) == 1 and not self._is_system(labelled):
                message = "has no unit on the other side, and that of data set 164 is another"
                raise self.refusal(f"unit {labels} {message}; {quantity} must be in {allowed}")
            unit = unit.divide(divisor)
        if unit.dimension != expected.dimension:
            raise self.refusal(
                f"unit {labels or 'of data set 164'}: {quantity} must be in {allowed}"
            )
        return unit.factor / expected.factor

    def _is_system(self, axis: Axis) -> bool:
        """Return whether the label of an axis is the unit that data set 164 gives to it."""
        unit, system = self._unit_of(axis, False), self._unit_of(axis._replace(label=""), False)
        factors = [side.factor if side else math.nan for side in (unit, system)]
        return math.isclose(*factors, rel_tol=1e-3)

    def _unit_of(self, axis: Axis, is_density: bool) -> Unit | None:
        """Return the unit that an axis states, or has by data set 164; None for none."""
        if axis.label:
            unit = unit_of_label(axis.label)
            is_si = self.units is None or all(unit.factor == 1.0 for unit in self.units)
            if self.units is not None and not is_si and contradicts(axis.label, self.units):
                raise UnitError("data set 164 states others")
            return unit
        if self.units is None or axis.kind not in (ACCELERATION, FORCE):
            return None
        length, force = self.units
        unit = length.multiply(HERTZ.power(2)) if axis.kind == ACCELERATION else force
        return unit.power(2).divide(HERTZ) if is_density else unit


class RecordChoice(NamedTuple):
    """What selects a data set 58 of a file that has several: its number, or where it is."""

    record: int | None = None  # from 1
    node: int | None = None  # of the response
    direction: str = ""  # of the response, such as z or -x; without a sign that of the axis alone

    def selects(self, number: int, node: int, direction: int) -> bool:
        """Return whether a data set with a number, node and code of its direction is meant."""
        code = DIRECTIONS.get(self.direction[-1:], 0) * (-1 if self.direction[:1] == "-" else 1)
        is_signed = self.direction[:1] in ("+", "-")
        return (
            self.record in (None, number)
            and self.node in (None, node)
            and (not code or code == direction or (not is_signed and code == abs(direction)))
        )


LONE_RECORD = RecordChoice()  # of a file that has no other


def read_function(path: Path, choice: RecordChoice = LONE_RECORD) -> UniversalFunction:
    """Read a data set 58 of a universal file.

    Raises
    ------
    ColumnsError
        If the file cannot be read, it is not clear which data set is meant, values are missing, or
        the abscissa is no frequency.
    """
    data, axes, units = _data_set(path, choice)
    count, x, values = int(data["num_pts"]), np.asarray(data["x"]), np.asarray(data["data"])
    if min(x.size, values.size) < count:
        message = f"has {min(x.size, values.size)} of the {count} values that it states"
        raise ColumnsError([f"{path}: {message}"])
    if values.size - count >= PADDING and values[count:].any():
        message = f"has {values.size} values; it states {count}"
        raise ColumnsError([f"{path}: {message}"])
    axis = axes["abscissa"]
    label = axis.label or "Hz"
    try:
        unit = unit_of_label(label)
    except UnitError:
        unit = DIMENSIONLESS
    if axis.kind not in (UNKNOWN, GENERAL, FREQUENCY) or unit.dimension != HERTZ.dimension:
        message = f"the abscissa must be a frequency, in Hz, kHz or rad/s, not {label!r}"
        raise ColumnsError([f"{path}: {message} of data type {axis.kind}"])
    frequency = unit.factor * x[:count].astype(float)
    if not (frequency[:1] >= 0).all() or not (np.diff(frequency) >= 0).all():
        raise ColumnsError([f"{path}: frequencies must rise from 0 Hz or more"])
    return UniversalFunction(path, int(data["func_type"]), frequency, values[:count], axes, units)


def _data_set(
    path: Path, choice: RecordChoice
) -> tuple[dict[str, Any], dict[str, Axis], tuple[Unit, Unit] | None]:
    """Return a data set 58 in the fields of pyuff, its axes, and the units of data set 164."""
    try:
        file = pyuff.UFF(str(path))
        kinds = file.get_set_types().tolist() if file.get_n_sets() else []
        places = [place for place, kind in enumerate(kinds) if kind == FUNCTION]
        found = {
            place: (number, int(head["rsp_node"]), int(head["rsp_dir"]))
            for number, place in enumerate(places, 1)
            for head in [file.read_sets(place, header_only=True)]
        }
        selected = [place for place, where in found.items() if choice.selects(*where)]
        if len(selected) != 1:
            raise ColumnsError([f"{path}: {_ambiguity(list(found.values()), len(selected))}"])
        place = selected[0]
        data: dict[str, Any] = file.read_sets(place)
        start, end = file._block_ind[place]
        lines = path.read_bytes()[start:end].splitlines()
        if not data["binary"] and not _is_in_columns(data, lines[BODY:]):
            message = "has numbers of another width than the 13 or 20 characters of its format"
            raise ColumnsError([f"{path}: {message}"])
        axes = {
            name: Axis(int(data[f"{name}_spec_data_type"]), _label(lines[number]))
            for name, number in AXES.items()
        }
        systems = [place for place, kind in enumerate(kinds[:place]) if kind == UNITS]
        system = file.read_sets(systems[-1]) if systems else None
        return (
            data,
            axes,
            system and unit_system(*map(system.get, ("units_code", "length", "force"))),
        )
    except ColumnsError:
        raise
    except UnitError as error:
        raise ColumnsError([f"{path}: data set 164: {error}"]) from None
    except Exception as error:  # whatever the library meets in a broken file
        message = f"is no universal file that can be read ({type(error).__name__})"
        raise ColumnsError([f"{path}: {message}"]) from None


def _ambiguity(places: Sequence[tuple[int, int, int]], count: int) -> str:
    """Return why numbers, nodes and directions of data sets 58 do not select one."""
    if not places:
        return "has no data set 58"
    axes = {code: axis for axis, code in DIRECTIONS.items()}
    listed = [
        f"{number} at node {node} {'-' * (code < 0)}{axes.get(abs(code), '')}".rstrip()
        for number, node, code in places[:MOST_LISTED]
    ]
    further = ["…"] * (len(places) > MOST_LISTED)
    message = f"has {len(places)} data sets 58, {count or 'none'} of them as selected; record, or "
    return f"{message}node and direction, must select one of {', '.join([*listed, *further])}"


def _is_in_columns(data: Mapping[str, Any], lines: Sequence[bytes]) -> bool:
    """Return whether the numbers between blanks are those of the columns, unless they touch."""
    try:
        numbers = np.array(b" ".join(lines).split(), dtype=float)
    except ValueError:
        return True
    values = np.asarray(data["data"])
    parts = [values.real, values.imag] if np.iscomplexobj(values) else [values]
    columns = np.stack(parts if data["abscissa_spacing"] else [data["x"], *parts], axis=1).ravel()
    count = min(numbers.size, columns.size)
    return bool(count) and np.array_equal(numbers[:count], columns[:count], equal_nan=True)


def _label(line: bytes) -> str:
    """Return the unit of a line that describes an axis, in UTF-8 or Latin-1; empty for none."""
    try:
        text = line.decode("utf-8")
    except UnicodeDecodeError:
        text = line.decode("cp1252", errors="replace")
    label = text[LABEL:].strip()
    return "" if label.upper() in NO_LABELS else label
