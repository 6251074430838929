"""Values of a study as YAML has them: numbers with their text, and values in place of others."""

from collections.abc import Callable, Mapping
from datetime import date
from decimal import Decimal
from numbers import Integral, Real
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from pidpanel.study.base import StudyError
from pidpanel.study.mistakes import Keys, dotted

DEEPEST = 50  # most lists and mappings around a value


class WrittenInt(int):
    """A whole number, and how it is written: ``7`` may be meant as a name."""

    written: str


class WrittenFloat(float):
    """A number, and how it is written: ``1.50`` may be meant as a name."""

    written: str


Number = TypeVar("Number", WrittenInt, WrittenFloat)


def written(kind: type[Number], value: Any, text: str) -> Number:
    """Return a number with its text."""
    number = kind(value)
    number.written = text
    return number


def plain(value: Any, read: Callable[[str], Any] = str, keys: Keys = ()) -> Any:
    """Return values as YAML has them: numbers of any library as those of Python, dates as text.

    Parameters
    ----------
    read
        What a text among the values means.
    keys
        Way to the value.

    Raises
    ------
    StudyError
        If a value is none that a file can have, with its key.
    """
    if len(keys) > DEEPEST:
        raise StudyError(f"{dotted(keys[:1])}: lists and mappings are nested too deeply")
    if isinstance(value, Mapping):
        names = {_name(key, keys): item for key, item in value.items()}
        return {name: plain(item, read, (*keys, name)) for name, item in names.items()}
    if isinstance(value, np.ndarray | np.bool_):
        return plain(value.tolist(), read, keys)
    if isinstance(value, list | tuple | range):
        return [plain(item, read, (*keys, number)) for number, item in enumerate(value)]
    if isinstance(value, str):
        return read(value)
    if isinstance(value, Path | date | np.datetime64):
        return str(value)
    if value is None or isinstance(value, bool | WrittenInt | WrittenFloat):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real | Decimal):
        return float(value)
    kind = type(value).__name__
    raise _refusal(keys, f"is of type {kind}; must be a number, text, a list or a mapping")


def _name(key: object, keys: Keys) -> str:
    if isinstance(key, str | Real):
        return str(key)
    raise _refusal(keys, f"has a key of type {type(key).__name__}; must be text")


def _refusal(keys: Keys, message: str) -> StudyError:
    return StudyError(f"{dotted(keys)}: {message}" if keys else message)


def merged(values: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with others in their places, section by section.

    Examples
    --------
    >>> merged({"panel": {"a": 1, "b": 2}}, {"panel": {"b": 3}})
    {'panel': {'a': 1, 'b': 3}}
    """
    together = dict(values)
    for key, change in changes.items():
        section = together.get(key)
        if isinstance(section, Mapping) and isinstance(change, Mapping):
            change = merged(section, change)
        together[key] = change
    return together


def sections(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values whose keys are joined with dots as nested sections.

    Examples
    --------
    >>> sections({"panel.damping_ratio": 0.02, "panel.points": {"a.b": [0, 0]}})
    {'panel': {'damping_ratio': 0.02, 'points': {'a.b': [0, 0]}}}
    """
    nested: dict[str, Any] = {}
    for name, value in values.items():
        for key in reversed(name.split(".")):
            value = {key: value}
        nested = merged(nested, value)
    return nested
