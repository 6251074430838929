"""Values of a study as a mapping, changed, and as the text of a YAML file."""

import math
from collections.abc import Mapping
from datetime import date
from decimal import Decimal
from numbers import Integral, Real
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pidpanel.study.base import StudyError
from pidpanel.study.document import Document
from pidpanel.study.loader import CORE
from pidpanel.study.mistakes import Keys, dotted
from pidpanel.study.numbers import WrittenFloat, WrittenInt

DEEPEST = 50  # most lists and mappings around a value


def values_of(file: Path) -> dict[str, Any]:
    """Return the values of a study file; the names of its files are absolute."""
    return dict(_with_absolute_files(plain(Document(file).data), file.parent))


def with_changes(values: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Set values by their keys joined with dots; a key that is not there is added."""
    for key, value in changes.items():
        if not isinstance(key, str):
            raise StudyError(f"{key!r}: a key must be text, such as panel.damping_ratio")
        *sections, name = key.split(".")
        section = values
        for entry in sections:
            section = section.setdefault(entry, {})
            if not isinstance(section, dict):
                raise StudyError(f"{key}: {entry} is not a section of this study")
        section[name] = value
    return values


def text_of(values: Mapping[str, Any]) -> str:
    """Return a mapping as YAML; numbers of numpy, tuples and paths as a file has them."""
    return yaml.dump(plain(values), Dumper=_Dumper, sort_keys=False, allow_unicode=True)


class _Dumper(yaml.SafeDumper):
    """Writes the numbers of a study as they are written there, since they may be names."""


def _written(dumper: yaml.SafeDumper, number: WrittenInt | WrittenFloat) -> yaml.ScalarNode:
    kind = "int" if isinstance(number, int) else "float"
    return dumper.represent_scalar(f"{CORE}{kind}", number.written)


_Dumper.add_representer(WrittenInt, _written)
_Dumper.add_representer(WrittenFloat, _written)


def _with_absolute_files(value: Any, folder: Path) -> Any:
    """Return values in which the names of files in a folder are absolute."""
    if isinstance(value, dict):
        return {key: _with_absolute_files(item, folder) for key, item in value.items()}
    if isinstance(value, list):
        return [_with_absolute_files(item, folder) for item in value]
    is_file = isinstance(value, str) and Path(value).suffix and (folder / value).is_file()
    return str(folder / value) if is_file else value


def plain(value: Any, keys: Keys = ()) -> Any:
    """Return values as YAML has them: numbers of any library as those of Python, dates as text.

    Raises
    ------
    StudyError
        If a value is none that a file can have, with its key.
    """
    if len(keys) > DEEPEST:
        raise StudyError(f"{dotted(keys[:1])}: lists and mappings are nested too deeply")
    if isinstance(value, Mapping):
        names = {_name(key, keys): item for key, item in value.items()}
        return {name: plain(item, (*keys, name)) for name, item in names.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), keys)
    if isinstance(value, list | tuple | range):
        return [plain(item, (*keys, number)) for number, item in enumerate(value)]
    if isinstance(value, str | Path | date | np.datetime64):
        return str(value)
    if isinstance(value, np.bool_):
        return bool(value)
    if value is None or isinstance(value, bool | WrittenInt | WrittenFloat):
        return value
    if isinstance(value, Real | Decimal):
        return _number(value, keys)
    kind = type(value).__name__
    raise _refusal(keys, f"is of type {kind}; must be a number, text, a list or a mapping")


def _name(key: object, keys: Keys) -> str:
    if isinstance(key, str):
        return str(key)
    if isinstance(key, Real):
        return str(_number(key, keys))
    raise _refusal(keys, f"has a key of type {type(key).__name__}; must be text")


def _number(value: Any, keys: Keys) -> int | float:
    try:
        number = float(value)
    except (OverflowError, ValueError):  # a signalling NaN
        number = math.inf
    if math.isinf(number) and not isinstance(value, float):
        raise _refusal(keys, "must be a finite number")
    return int(value) if isinstance(value, Integral) else number


def _refusal(keys: Keys, message: str) -> StudyError:
    return StudyError(f"{dotted(keys)}: {message}" if keys else message)
