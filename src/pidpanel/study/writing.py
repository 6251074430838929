"""Values of a study as a mapping, changed, and as the text of a YAML file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pidpanel.study.base import StudyError
from pidpanel.study.document import CORE, Document
from pidpanel.study.numbers import WrittenFloat, WrittenInt


def values_of(file: Path) -> dict[str, Any]:
    """Return the values of a study file; the names of its files are absolute."""
    return dict(_with_absolute_files(plain(Document(file).data), file.parent))


def with_changes(values: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Set values by their keys joined with dots; a key that is not there is added."""
    for key, value in changes.items():
        *sections, name = key.split(".")
        section = values
        for entry in sections:
            section = section.setdefault(entry, {})
            if not isinstance(section, dict):
                raise StudyError(f"{key}: {entry} is not a section of this study")
        section[name] = value
    return values


def text_of(values: Mapping[str, Any], name: str) -> str:
    """Return a mapping as YAML; numbers of numpy, tuples and paths as a file has them."""
    document = plain({"name": name, **values})
    return yaml.dump(document, Dumper=_Dumper, sort_keys=False, allow_unicode=True)


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


def plain(value: Any) -> Any:
    """Return values as YAML has them: no arrays or paths."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return str(value) if isinstance(value, Path) else value
