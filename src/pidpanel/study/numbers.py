"""Numbers of a study with their text, and values in place of others."""

from collections.abc import Callable, Mapping
from typing import Any, TypeVar


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


def numbered(value: Any, read: Callable[[str], Any] = str) -> Any:
    """Return values as those of a file: numbers with their text, tuples as lists, texts as read."""
    if isinstance(value, Mapping):
        return {str(key): numbered(item, read) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [numbered(item, read) for item in value]
    if isinstance(value, str):
        return read(value)
    if isinstance(value, bool | WrittenInt | WrittenFloat):
        return value
    if isinstance(value, int):
        return written(WrittenInt, value, repr(value))
    return written(WrittenFloat, value, repr(value)) if isinstance(value, float) else value


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
            together[key] = merged(section, change)
        else:
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
