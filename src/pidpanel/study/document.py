"""The file of a study: YAML, and the lines at which its keys are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar

import yaml

from pidpanel.study.base import StudyError
from pidpanel.study.mistakes import Keys, Mistake, dotted, one_line

LONGEST_VALUE = 60
"""Longest value that a message shows whole [characters]."""


class Document:
    """A YAML file whose keys are text, as they are written.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    path : Path
    data : Mapping
        Its content.
    duplicates : list of str
        A message for each duplicate key; the last one counts.

    Raises
    ------
    StudyError
        If the file cannot be read or is no YAML mapping.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise StudyError(f"{path}: cannot be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise StudyError(f"{path}: must be UTF-8 text ({error.reason})") from None
        try:
            loader = _Loader(text)
            root = loader.get_single_node()
            data = loader.construct_document(root) if root else None
        except yaml.MarkedYAMLError as error:
            line = error.problem_mark.line + 1 if error.problem_mark else 1
            raise StudyError(f"{path}:{line}: not YAML: {error.problem}") from None
        except yaml.YAMLError as error:
            raise StudyError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
        if root is None or not isinstance(data, dict):
            raise StudyError(f"{path}: must be a mapping with keys such as name, coupon, panel")
        self._root = root
        self.data: Mapping[str, Any] = data
        self.duplicates = [
            f"{path}:{key.start_mark.line + 1}: {one_line(key.value)}: duplicate key"
            for key in loader.duplicates
        ]

    def error(self, mistakes: Iterable[Mistake]) -> StudyError:
        """Return the error that tells mistakes, a line for each in the order of the file."""
        ordered = sorted(mistakes, key=lambda mistake: self._line_and_value(mistake.keys)[0])
        return StudyError("\n".join([*self.duplicates, *map(self.message, ordered)]))

    def message(self, mistake: Mistake) -> str:
        """Return one line: file, line, key, value, what is wrong."""
        line, value = self._line_and_value(mistake.keys)
        place = f"{self.path}:{line}" if line else str(self.path)
        key = dotted(mistake.keys)
        shown = f"{key} = {value}" if value else key
        return ": ".join(part for part in (place, shown, mistake.says) if part)

    def _line_and_value(self, keys: Keys) -> tuple[int, str]:
        """Return the line of a key, or of the last on the way that is there, and its value.

        The line is 0 for the file as a whole; the value is empty for a key that is not there.
        """
        line, node = 0, self._root
        if not keys:
            return line, ""
        for key in keys:
            found = _entry(node, key)
            if found is None:
                return line, ""
            line, node = found
        return line, _shown(node)


def _entry(node: yaml.Node, key: str | int) -> tuple[int, yaml.Node] | None:
    """Return the line and the node of a key of a mapping, or of an index of a list."""
    if isinstance(node, yaml.MappingNode):
        for name, value in reversed(node.value):
            if name.value == key:
                return name.start_mark.line + 1, value
    elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key].start_mark.line + 1, node.value[key]
    return None


def _shown(node: yaml.Node) -> str:
    """Return a value as it would be written on one line, or the beginning of a long one."""
    text = one_line(_in_a_line(node, 3))
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}…"


def _in_a_line(node: yaml.Node, depth: int) -> str:
    """Return a value on one line, down to a depth: an alias may hold itself."""
    if isinstance(node, yaml.ScalarNode):
        return str(node.value)
    if depth == 0:
        return "…"
    if isinstance(node, yaml.MappingNode):
        pairs = (f"{key.value}: {_in_a_line(value, depth - 1)}" for key, value in node.value)
        return f"{{{', '.join(pairs)}}}"
    return f"[{', '.join(_in_a_line(item, depth - 1) for item in node.value)}]"


class _Loader(yaml.SafeLoader):
    """Safe YAML whose keys are text as written, and that collects duplicate keys.

    Dates are text: no key of a study is one.
    """

    yaml_implicit_resolvers: ClassVar = {  # type: ignore[misc]
        first: [pair for pair in pairs if pair[0] != "tag:yaml.org,2002:timestamp"]
        for first, pairs in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.duplicates: list[yaml.Node] = []

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        names: set[str] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise yaml.constructor.ConstructorError(
                    None, None, "a key must be text", key.start_mark
                )
            if key.value in names:
                self.duplicates.append(key)
            names.add(key.value)
        self.flatten_mapping(node)
        return {key.value: self.construct_object(value, deep) for key, value in node.value}
