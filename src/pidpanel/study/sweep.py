"""The points at which a coupon is shaken: a sweep, or a table of cases.

In the table a row is a case, a column a dotted key of the coupon.
"""

import bisect
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import Field

from pidpanel.columns import NUMBER, ColumnsError, LineFaults, faults_of_names, read_rows
from pidpanel.constants import LARGEST_GAMMA, STANDARD_GRAVITY
from pidpanel.study.base import Fill, SectionModel
from pidpanel.study.choice import Choice
from pidpanel.study.mistakes import Mistake
from pidpanel.study.particles import Diameter
from pidpanel.study.quantity import Quantity
from pidpanel.study.units import InSI

Frequency = Annotated[float, Quantity(1, 20000, unit="kilohertz")]  # of a drive [Hz]
MOST_VALUES = 10_000  # values that a range may have


class Range(SectionModel):
    """Equally spaced values: ``{from: 5, to: 2000, step: 10}``."""

    start: Frequency = Field(alias="from")
    """First value [Hz]."""
    stop: Frequency = Field(alias="to")
    """Largest value [Hz]; included if it is a whole number of steps away."""
    step: Annotated[float, Quantity(1e-3, 20000)]
    """Step between values [Hz]."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.stop < self.start:
            yield Mistake(("to",), f"must be at least from = {self.start:g}")
        elif self.count > MOST_VALUES:
            yield Mistake((), f"has {self.count} values; allowed are {MOST_VALUES}")

    @property
    def count(self) -> int:
        """Number of the values."""
        return int((self.stop - self.start) / self.step * (1 + 1e-12)) + 1

    def values(self) -> tuple[float, ...]:
        """Return the values, the end among them if it is a whole number of steps away.

        Examples
        --------
        >>> Range(**{"from": 1, "to": 1.3, "step": 0.1}).values()
        (1.0, 1.1, 1.2, 1.3)
        """
        return tuple(round(self.start + i * self.step, 9) for i in range(self.count))


# Amplitude of an acceleration [g].
Gamma = Annotated[float, Quantity(0, LARGEST_GAMMA, low_itself=False, unit="gravities")]
# Amplitude of a displacement [mm].
Amplitude = Annotated[float, Quantity(0, 1000, low_itself=False, unit="millimetres")]

# Frequencies and amplitudes of a sweep, below which an interpolation cannot be checked.
LEAST_VALUES = 3


class Sweep(SectionModel):
    """The points at which the coupon is shaken: every combination of the lists."""

    fill_fraction: Annotated[tuple[Fill, ...], Field(min_length=1)] = (0.1, 0.3, 0.5, 0.7, 0.9)
    """Fill fractions r: number of particles over that of a full cell."""
    frequency_hz: Annotated[Range | Annotated[tuple[Frequency, ...], Field(min_length=1)], Choice()]
    """Frequencies of the drive [Hz], as a list or as a range."""
    acceleration_g: tuple[Gamma, ...] = ()
    """Amplitude Γ of the acceleration, in units of standard gravity."""
    displacement_mm: tuple[Amplitude, ...] = ()
    """Amplitude W of the displacement [mm], instead of that of the acceleration."""
    diameter_mm: tuple[Diameter, ...] = ()
    """Diameters of the particles [mm]; by default ``particles.diameter_mm``."""
    max_velocity_m_s: Annotated[float, Quantity(1e-3, 1000, unit="velocity")] | None = None
    """Combinations with a larger velocity amplitude a/ω are omitted [m/s]."""

    accelerations: ClassVar = InSI("acceleration_g")
    displacements: ClassVar = InSI("displacement_mm")
    diameters: ClassVar = InSI("diameter_mm")

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Frequencies [Hz], a range of them written out."""
        if isinstance(self.frequency_hz, Range):
            return self.frequency_hz.values()
        return self.frequency_hz

    @property
    def is_coarse(self) -> bool:
        """Whether no case has neighbours on both sides in frequency and in amplitude.

        The error of an interpolation between the cases is then not known: none can be predicted
        from the others.
        """
        amplitudes = self.acceleration_g or self.displacement_mm
        return min(len(set(self.frequencies)), len(set(amplitudes))) < LEAST_VALUES

    def drive_count(self) -> int:
        """Return the number of combinations of frequency and amplitude that are not left out."""
        fastest = self.max_velocity_m_s or math.inf
        W, a = sorted(self.displacements), sorted(self.accelerations)
        return sum(
            bisect.bisect_right(W, fastest / omega) + bisect.bisect_right(a, fastest * omega)
            for omega in (2 * math.pi * frequency for frequency in self.frequencies)
        )

    def slowest(self) -> float:
        """Return the least velocity amplitude of all combinations [m/s]."""
        omega = [2 * math.pi * frequency for frequency in self.frequencies]
        if self.displacements:
            return min(omega) * min(self.displacements)
        return min(self.accelerations) / max(omega)

    def _mistakes_of_displacements(self) -> Iterator[Mistake]:
        """Yield displacements with an acceleration that no shaker and no panel has."""
        omega = 2 * math.pi * max(self.frequencies)
        fastest = self.max_velocity_m_s or math.inf
        for index, amplitude in enumerate(self.displacements):
            gamma = min(amplitude * omega, fastest) * omega / STANDARD_GRAVITY
            if gamma > LARGEST_GAMMA:
                longest = 1e3 * LARGEST_GAMMA * STANDARD_GRAVITY / omega**2
                message = (
                    f"{gamma:.3g} g at {max(self.frequencies):g} Hz; at most {LARGEST_GAMMA:g} g, "
                )
                message += f"{longest:.2g} mm there; max_velocity_m_s omits fast combinations"
                yield Mistake(("displacement_mm", index), message)

    def mistakes(self) -> Iterator[Mistake]:
        keys = self.model_fields_set
        if self.acceleration_g and self.displacement_mm:
            yield Mistake(("displacement_mm",), "not allowed together with acceleration_g")
        yield from self._mistakes_of_displacements()
        if not self.acceleration_g and not self.displacement_mm:
            message = "must have at least 1 value" if "acceleration_g" in keys else "missing"
            yield Mistake(
                ("acceleration_g",), f"{message}; required unless displacement_mm is given"
            )
        for key, values in self:
            texts: set[str] = set()
            for index, value in enumerate(values if isinstance(values, tuple) else ()):
                text = f"{value:.6g}"
                if text in texts:
                    message = "duplicate value; its cases would have the same labels"
                    yield Mistake((key, index), message)
                texts.add(text)


# Sweep of a coupon without one: coarse, from below the first mode of a panel to 2 kHz.
USUAL_SWEEP = Sweep(
    frequency_hz=(30, 80, 250, 700, 2000), acceleration_g=(4, 20, 120, 700), max_velocity_m_s=7
)


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
    for message in (*faults_of_names(header, header), *missing):
        faults.add(table.line, message)
    if len(set(AMPLITUDES) & set(header)) != 1:
        faults.add(table.line, f"must have either column {' or '.join(AMPLITUDES)}")
    if faults:
        raise ColumnsError(faults.texts())
    rows: list[CaseRow] = []
    lines: dict[tuple[str, ...], int] = {}
    for line, cells in table.rows:
        message = ""
        if len(cells) != len(header):
            message = f"has {len(cells)} values, must have {len(header)} as the header"
        elif "" in cells:
            message = f"{header[cells.index('')]}: empty; must have a value"
        elif tuple(cells) in lines:
            message = f"duplicate of line {lines[tuple(cells)]}"
        if message:
            faults.add(line, message, message)
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
