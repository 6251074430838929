"""The key ``damping_ratio`` of a panel: a number, a list by mode, a table, or its file."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, WithJsonSchema
from pydantic_core import PydanticCustomError

from pidpanel.damping_ratio import DampingRatio, read_damping_ratio
from pidpanel.study.base import file_in
from pidpanel.study.choice import Choice
from pidpanel.study.mistakes import Mistake, read_at
from pidpanel.study.quantity import Quantity, inside, text_hint

Ratio = Annotated[float, inside(0, 0.5)]
NaturalFrequency = Annotated[float, Quantity(0, 1e5, low_itself=False, unit="kilohertz")]


def _table_of_ratios(value: Any) -> Any:
    if not str(value).endswith(".csv"):
        hint = text_hint(value) or " or a list or a CSV file"
        raise PydanticCustomError("csv_type", "must be a number{hint}", {"hint": hint})
    return value


RatioFile = Annotated[
    Path,
    BeforeValidator(_table_of_ratios),
    file_in(),
    WithJsonSchema({"type": "string", "format": "path", "pattern": r"\.csv$"}),
]
DampingRatios = Annotated[
    Ratio
    | Annotated[tuple[Ratio, ...], Field(min_length=1)]
    | Annotated[tuple[tuple[NaturalFrequency, Ratio], ...], Field(min_length=1)]
    | RatioFile,
    Choice(),
]


def damping_ratio_of(value: Any) -> DampingRatio:
    """Return the damping ratio that the key states; `ColumnsError` for the faults of a file."""
    if isinstance(value, Path):
        return read_damping_ratio(value)
    if not isinstance(value, tuple):
        return DampingRatio((value,))
    if not isinstance(value[0], tuple):
        return DampingRatio(value)
    frequency, ratio = zip(*value, strict=True)
    return DampingRatio(ratio, frequency)


def mistakes_of_damping_ratio(value: Any) -> Iterator[Mistake]:
    """Yield what of a table cannot be read, and what does not rise."""
    ratio = yield from read_at(("damping_ratio",), lambda: damping_ratio_of(value))
    for row, (lower, higher) in enumerate(pairwise(ratio.frequency if ratio else ()), start=1):
        if higher <= lower:
            message = f"the frequency must be above that of the row before, {lower:g} Hz"
            yield Mistake(("damping_ratio", row), message)
