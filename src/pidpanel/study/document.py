"""The file of a study: YAML 1.2 with keys as written, the lines of its keys; read and checked.

``on`` and ``1:30`` are text, as YAML 1.2 means them, not true and 90; ``031`` is no number. Dates
are text too: no key of a study is one. Nothing explodes.
"""

import copy
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import ValidationError

from pidpanel.study.base import SectionModel, StudyError
from pidpanel.study.coupon_study import RESERVED, CouponStudy
from pidpanel.study.loader import CORE, Loader, number_of, printable, problem_of
from pidpanel.study.mistakes import Mistake, dotted, mistakes_of
from pidpanel.study.numbers import merged, numbered, sections
from pidpanel.study.study import Study
from pidpanel.text_files import TextFileError, one_line, read_text

LONGEST_VALUE = 60  # longest value that a message shows whole [characters]
# Most bytes of a study: what is longer belongs into a mesh or a table beside it.
LARGEST = 1_000_000
# Keys at the top that begin like this hold what is repeated elsewhere by anchors and ``<<``.
ASIDE = "x-"


class Document:
    """A YAML file whose keys are text, as they are written; `StudyError` if it is none.

    ``data`` is its content, ``mistakes`` are duplicate keys and keys without a value. Values that
    came without a file, or in place of those of the file, have no line: messages begin with
    ``source``.
    """

    def __init__(self, path: Path, source: str = "") -> None:
        self.path, self.source = path, source
        self.place = one_line(str(path))
        self._changed: dict[str, Any] = {}
        try:
            loader = Loader(read_text(path, LARGEST))
            root = loader.get_single_node()
            data = loader.construct_document(root) if root else None
        except TextFileError as error:
            place = self.place if error.line is None else f"{self.place}:{error.line}"
            raise StudyError(f"{place}: {error.message}") from None
        except yaml.YAMLError as error:
            line, message = problem_of(error)
            raise StudyError(
                f"{self.place}:{line}: {message}" if line else f"{self.place}: {message}"
            ) from None
        except RecursionError:
            raise StudyError(f"{self.place}: lists and mappings are nested too deeply") from None
        if root is None or not isinstance(data, dict):
            is_empty = "" if root is not None else "is empty; "
            raise StudyError(
                f"{self.place}: {is_empty}must be a mapping with keys such as name, coupon, panel"
            )
        self._root = root
        self.data: Mapping[str, Any] = {
            key: value for key, value in data.items() if not key.startswith(ASIDE)
        }
        self.mistakes = loader.mistakes

    @classmethod
    def of_values(cls, values: Mapping[str, Any], path: Path, source: str = "") -> "Document":
        """Return the document that values are, named and placed as a file of the path would be."""
        document = cls.__new__(cls)
        document.path, document.source, document.place, document.mistakes = path, source, source, []
        document._root = yaml.MappingNode(f"{CORE}map", [])
        document.data = document._changed = numbered(values, read=printable)
        return document

    def changed(self, values: Mapping[str, Any]) -> "Document":
        """Return the document with other values: text among them is read as YAML reads it."""
        document = copy.copy(self)
        document._changed = numbered(sections(values), read=number_of)
        document.data = merged(self.data, document._changed)
        return document

    def error(self, mistakes: Iterable[Mistake]) -> StudyError:
        """Return the error with a line for each mistake, in the order of the file.

        Those of the document are among them. For a key without a value nothing else is reported:
        neither for the sections around it nor for what is then missing.
        """
        empty = [mistake.keys for mistake in self.mistakes if mistake.message == Loader.EMPTY]
        around = {keys[:count] for keys in empty for count in range(len(keys) + 1)}
        remaining = (mistake for mistake in mistakes if mistake.keys not in around)
        located = [(line, value, mistake) for mistake in (*self.mistakes, *remaining)
                for line, value in [self._line_and_value(mistake)]
                if line or not empty]  # fmt: skip
        ordered = sorted(located, key=lambda entry: entry[0])
        return StudyError("\n".join(self._message(*entry) for entry in ordered))

    def _message(self, line: int, value: str, mistake: Mistake) -> str:
        place = f"{self.place}:{line}" if line else self.place
        if line < 0:
            place = self.source
        key = dotted(mistake.keys)
        setting = f"{key} = {value}" if value else key
        parts = (place, setting, one_line(mistake.message))
        return ": ".join(part for part in parts if part)

    def _line_and_value(self, mistake: Mistake) -> tuple[int, str]:
        """Return the line of a key, or of the last on the way that is there, and its value.

        The line is 0 for the file as a whole; the value is empty for a key that is not there.
        """
        changed, node, line = self._changed, self._root, -1 if self._changed is self.data else 0
        for depth, key in enumerate(mistake.keys, start=1):
            if not isinstance(changed, Mapping) or key not in changed:
                break
            changed = changed[key]
            if depth == len(mistake.keys) or not isinstance(changed, Mapping):
                return -1, _short_text(changed)
        if line < 0:
            return line, ""
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
    return _short_text(_in_a_line(node, 3))


def _short_text(value: Any) -> str:
    text = one_line(str(value))
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


T = TypeVar("T", bound=SectionModel)


def load_study(path: str | Path) -> Study:
    """Read and check the file of a study that has a panel; see `load_any_study`."""
    study = load_any_study(path)
    if not isinstance(study, Study):
        raise StudyError(f"{path}: panel: missing; this is a study of the coupon alone")
    return study


def load_any_study(path: str | Path) -> Study | CouponStudy:
    """Read and check a study file.

    Parameters
    ----------
    path
        YAML file. Paths in it are relative to its own folder, to the working folder, or to the
        folder of such files that come with pidpanel.

    Returns
    -------
    Study or CouponStudy
        A `CouponStudy` if the file has a section ``coupon`` and nothing of a panel.

    Raises
    ------
    StudyError
        One line for each mistake: file, line, key, value, what is wrong or what is allowed.
    """
    return study_in(Document(Path(path)))


def study_in(document: Document) -> Study | CouponStudy:
    """Return the study of a file that has been read; see `load_any_study`."""
    panel_keys = set(Study.model_fields) - set(CouponStudy.model_fields)
    is_coupon = "coupon" in document.data and not (panel_keys - {"damping"}) & set(document.data)
    if is_coupon and "damping" in document.data:
        message = "only in a study with a panel; a study of the coupon alone reads no damping model"
        raise document.error(
            [Mistake(("damping",), f"{message}. Delete it, or add panel and sound")]
        )
    return section_in(document, CouponStudy if is_coupon else Study, _in_file)


def section_in(
    document: Document,
    model: type[T],
    explain: Callable[[Mistake, Document], Mistake] | None = None,
) -> T:
    """Return the model of a whole file; `StudyError` with its mistakes, as they are explained."""
    values = {"name": document.path.stem, **document.data}
    try:
        section = model.model_validate(values, context={"folder": document.path.parent})
    except ValidationError as error:
        mistakes = list(mistakes_of(error, model))
        if explain:
            mistakes = [explain(mistake, document) for mistake in mistakes]
        raise document.error(mistakes) from None
    if document.mistakes:
        raise document.error([])
    return section


def _in_file(mistake: Mistake, document: Document) -> Mistake:
    """Return a mistake with its cause: an indented section, or the name of the file."""
    *around, key = mistake.keys or ("",)
    if around and key in Study.model_fields and mistake.message.startswith("unknown key"):
        message = f"unknown key; {key} is a top-level section; do not indent its line"
        return mistake._replace(message=message)
    if mistake.keys != ("name",) or "name" in document.data:
        return mistake
    stem = document.path.stem
    plain = unicodedata.normalize("NFKD", stem).encode("ascii", "ignore").decode()
    better = re.sub("[^A-Za-z0-9_-]+", "_", plain).strip("_-")
    better = better if better and better not in RESERVED else f"{better or 'my'}_study"
    message = f"missing; the name of the file, {stem!r}, cannot be that of the study: "
    return mistake._replace(message=f"{message}{mistake.message}; such as name: {better}")
