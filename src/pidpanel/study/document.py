"""The file of a study: YAML, and the lines at which its keys are."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from pidpanel.study.base import StudyError
from pidpanel.study.mistakes import Mistake, dotted, one_line
from pidpanel.study.yaml_loader import Loader, problem_of
from pidpanel.text_files import TextFileError, read_text

LONGEST_VALUE = 60  # longest value that a message shows whole [characters]
# Most bytes of a study: what is longer belongs into a mesh or a table beside it.
LARGEST = 1_000_000
# Keys at the top that begin like this hold what is repeated elsewhere by anchors and ``<<``.
ASIDE = "x-"


class Document:
    """A YAML file whose keys are text, as they are written; `StudyError` if it is none.

    ``data`` is its content, ``mistakes`` are duplicate keys and keys without a value.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            loader = Loader(read_text(path, LARGEST))
            root = loader.get_single_node()
            data = loader.construct_document(root) if root else None
        except TextFileError as error:
            place = path if error.line is None else f"{path}:{error.line}"
            raise StudyError(f"{place}: {error.says}") from None
        except yaml.YAMLError as error:
            line, says = problem_of(error)
            raise StudyError(f"{path}:{line}: {says}" if line else f"{path}: {says}") from None
        except RecursionError:
            raise StudyError(f"{path}: lists and mappings are nested too deeply") from None
        if root is None or not isinstance(data, dict):
            is_empty = "" if root is not None else "is empty; "
            raise StudyError(
                f"{path}: {is_empty}must be a mapping with keys such as name, coupon, panel"
            )
        self._root = root
        self.data: Mapping[str, Any] = {
            key: value for key, value in data.items() if not key.startswith(ASIDE)
        }
        self.mistakes = loader.mistakes

    def error(self, mistakes: Iterable[Mistake]) -> StudyError:
        """Return the error with a line for each mistake, in the order of the file.

        Those of the document are among them. For a key without a value nothing else is reported:
        neither for the sections around it nor for what is then missing.
        """
        empty = [mistake.keys for mistake in self.mistakes if mistake.says == Loader.EMPTY]
        around = {keys[:count] for keys in empty for count in range(len(keys) + 1)}
        remaining = (mistake for mistake in mistakes if mistake.keys not in around)
        located = [(line, value, mistake) for mistake in (*self.mistakes, *remaining)
                for line, value in [self._line_and_value(mistake)]
                if line or not empty]  # fmt: skip
        ordered = sorted(located, key=lambda entry: entry[0])
        return StudyError("\n".join(self._message(*entry) for entry in ordered))

    def _message(self, line: int, value: str, mistake: Mistake) -> str:
        place = f"{self.path}:{line}" if line else str(self.path)
        key = dotted(mistake.keys)
        setting = f"{key} = {value}" if value else key
        return ": ".join(part for part in (place, setting, mistake.says) if part)

    def _line_and_value(self, mistake: Mistake) -> tuple[int, str]:
        """Return the line of a key, or of the last on the way that is there, and its value.

        The line is 0 for the file as a whole; the value is empty for a key that is not there.
        """
        line, node = 0, self._root
        for key in mistake.keys:
            entry = _entry(node, key)
            if entry is None:
                return line, ""
            line, node = entry
        if mistake.line is not None:
            return mistake.line, ""
        return line, _short_value(node) if mistake.keys else ""


def _entry(node: yaml.Node, key: str | int) -> tuple[int, yaml.Node] | None:
    """Return the line and the node of a key of a mapping, or of an index of a list."""
    if isinstance(node, yaml.MappingNode):
        for name, value in reversed(node.value):
            if name.value == key:
                return name.start_mark.line + 1, value
    elif isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
        return node.value[key].start_mark.line + 1, node.value[key]
    return None


def _short_value(node: yaml.Node) -> str:
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
