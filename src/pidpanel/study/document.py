"""The file of a study: its values, the lines of its keys, and the study that they are."""

import copy
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import ValidationError

from pidpanel.study.base import SectionModel, StudyError
from pidpanel.study.coupon_study import RESERVED, CouponStudy
from pidpanel.study.loader import EMPTY, Content, number_of, printable, problem_of
from pidpanel.study.mistakes import Keys, Mistake, dotted, mistakes_of
from pidpanel.study.structure import KEY
from pidpanel.study.study import Study
from pidpanel.study.values import merged, plain, sections
from pidpanel.text_files import TextFileError, one_line, read_text

LONGEST_VALUE = 60  # longest value that a message shows whole [characters]
# Most bytes of a study: what is longer belongs into a mesh or a table beside it.
LARGEST = 1_000_000
# Keys at the top that begin like this hold what is repeated elsewhere by anchors and ``<<``.
ASIDE = "x-"
NO_LINE = -1  # of values that came without a file, or in place of those of the file


class Document:
    """A YAML file whose keys are text, as they are written; `StudyError` if it is none.

    ``data`` is its content, ``mistakes`` are duplicate keys and keys without a value. Messages
    about values without a line begin with ``source``. Values of no file are named and placed as a
    file of the path would be.
    """

    def __init__(
        self, path: Path, source: str = "", values: Mapping[str, Any] | None = None
    ) -> None:
        self.path, self.source = path, source
        self.place = one_line(str(path))
        self.data: Mapping[str, Any]
        self.mistakes: list[Mistake] = []
        self._lines: dict[Keys, int] = {(): NO_LINE}
        if values is not None:
            self.data = plain(values, printable)
            return
        try:
            content = Content(read_text(path, LARGEST))
        except TextFileError as error:
            raise self._refusal(error.message, error.line) from None
        except yaml.YAMLError as error:
            line, message = problem_of(error)
            raise self._refusal(message, line) from None
        except RecursionError:
            raise self._refusal("lists and mappings are nested too deeply") from None
        if not isinstance(content.data, dict):
            is_empty = "is empty; " if content.is_empty else ""
            message = f"{is_empty}must be a mapping with keys such as name, coupon, panel"
            raise self._refusal(message)
        self.data = {key: value for key, value in content.data.items() if not key.startswith(ASIDE)}
        self.mistakes, self._lines = content.mistakes, content.lines

    def _refusal(self, message: str, line: int | None = None) -> StudyError:
        return StudyError(f"{self.place}:{line}: {message}" if line else f"{self.place}: {message}")

    def changed(self, values: Mapping[str, Any]) -> "Document":
        """Return the document with other values: text among them is read as YAML reads it."""
        document, changes = copy.copy(self), plain(sections(values), number_of)
        document._lines = {**self._lines, **dict.fromkeys(_replaced(self.data, changes), NO_LINE)}
        document.data = merged(self.data, changes)
        return document

    def error(self, mistakes: Iterable[Mistake]) -> StudyError:
        """Return the error with a line for each mistake, in the order of the file.

        Those of the document are among them. For a key without a value nothing else is reported:
        neither for the sections around it nor for what is then missing.
        """
        if KEY in self.data and "panel" not in self.data:
            mistakes = [
                m._replace(keys=(KEY, *m.keys[1:])) if m.keys[:1] == ("panel",) else m
                for m in mistakes
            ]
        empty = [mistake.keys for mistake in self.mistakes if mistake.message == EMPTY]
        around = {keys[:count] for keys in empty for count in range(len(keys) + 1)}
        remaining = (mistake for mistake in mistakes if mistake.keys not in around)
        located = [(line, value, mistake) for mistake in (*self.mistakes, *remaining)
                for line, value in [self._line_and_value(mistake)]
                if line or not empty]  # fmt: skip
        ordered = sorted(located, key=lambda entry: entry[0])
        return StudyError("\n".join(self._message(*entry) for entry in ordered))

    def _message(self, line: int, value: str, mistake: Mistake) -> str:
        place = f"{self.place}:{line}" if line else self.place
        key = dotted(mistake.keys)
        parts = (
            self.source if line == NO_LINE else place,
            f"{key} = {value}" if value else key,
            one_line(mistake.message),
        )
        return ": ".join(part for part in parts if part)

    def _line_and_value(self, mistake: Mistake) -> tuple[int, str]:
        """Return the line of a key, or of the last on the way that is there, and its value.

        The line is 0 for the file as a whole; the value is empty for a key that is not there.
        """
        if mistake.line is not None:
            return mistake.line, ""
        value: Any = self.data
        line = self._lines[()]
        for depth, key in enumerate(mistake.keys, start=1):
            try:
                value = None if isinstance(value, str) else value[key]
            except (LookupError, TypeError):
                return line, ""
            if line != NO_LINE:
                line = self._lines.get(mistake.keys[:depth], line)
        return line, _shown(value) if mistake.keys else ""


def _replaced(values: Any, changes: Mapping[str, Any], keys: Keys = ()) -> Iterator[Keys]:
    """Yield the ways to values that others take the place of."""
    for key, change in changes.items():
        value = values.get(key)
        if isinstance(value, Mapping) and isinstance(change, Mapping):
            yield from _replaced(value, change, (*keys, key))
        else:
            yield (*keys, key)


def _shown(value: Any) -> str:
    """Return a value as it would be written on one line, or the beginning of a long one."""
    text = one_line(_in_a_line(value, 3))
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]}…"


def _in_a_line(value: Any, depth: int) -> str:
    """Return a value on one line, down to a depth."""
    if not isinstance(value, Mapping | list):
        text = str(getattr(value, "written", value))
        return text.lower() if isinstance(value, bool) else text
    if depth == 0:
        return "…"
    if isinstance(value, Mapping):
        pairs = (f"{key}: {_in_a_line(item, depth - 1)}" for key, item in value.items())
        return f"{{{', '.join(pairs)}}}"
    return f"[{', '.join(_in_a_line(item, depth - 1) for item in value)}]"


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
    panel_keys = {KEY, *Study.model_fields} - set(CouponStudy.model_fields)
    is_coupon = "coupon" in document.data and not (panel_keys - {"damping"}) & set(document.data)
    if is_coupon and "damping" in document.data:
        message = "only in a study with a panel; a study of the coupon alone reads no damping model"
        raise document.error(
            [Mistake(("damping",), f"{message}. Delete it, or add panel and sound")]
        )
    return section_in(document, CouponStudy if is_coupon else Study)


def section_in(document: Document, model: type[T]) -> T:
    """Return the model of a whole file; `StudyError` with its mistakes."""
    values = {"name": document.path.stem, **document.data}
    try:
        section = model.model_validate(values, context={"folder": document.path.parent})
    except ValidationError as error:
        mistakes = mistakes_of(error, model)
        raise document.error(_in_file(mistake, document) for mistake in mistakes) from None
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
