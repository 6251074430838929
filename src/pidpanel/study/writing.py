"""Values of a study as a mapping, changed, and as the text of a YAML file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from pidpanel.study.base import StudyError
from pidpanel.study.document import Document
from pidpanel.study.loader import CORE
from pidpanel.study.values import WrittenFloat, WrittenInt, plain


def values_of(file: Path) -> dict[str, Any]:
    """Return the values of a study file; the names of its files are absolute."""

    def absolute(text: str) -> str:
        is_file = Path(text).suffix and (file.parent / text).is_file()
        return str(file.parent / text) if is_file else text

    return dict(plain(Document(file).data, absolute))


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
