"""The file of a study: YAML 1.2 with keys as written, the lines of its keys; read and checked.

``on`` and ``1:30`` are text, as YAML 1.2 means them, not true and 90; ``031`` is no number. Dates
are text too: no key of a study is one. Nothing explodes.
"""

import contextlib
import re
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import yaml
from pydantic import ValidationError

from pidpanel.columns import NUMBER
from pidpanel.study.base import SectionModel, StudyError
from pidpanel.study.coupon_study import RESERVED, CouponStudy
from pidpanel.study.mistakes import WORDS, Keys, Mistake, dotted, mistakes_of
from pidpanel.study.study import Study
from pidpanel.text_files import TextFileError, one_line, read_text

CORE = "tag:yaml.org,2002:"
NULL, MERGE = f"{CORE}null", f"{CORE}merge"
TAGS = {CORE + kind for kind in ("str", "int", "float", "bool", "null", "map", "seq", "merge")}
MOST_VALUES = 500_000  # values that a study may have once its aliases are written out


class WrittenInt(int):
    """A whole number, and how it is written: ``7`` may be meant as a name."""

    written: str


class WrittenFloat(float):
    """A number, and how it is written: ``1.50`` may be meant as a name."""

    written: str


class Loader(yaml.SafeLoader):
    """Safe YAML whose keys are text as written.

    Attributes
    ----------
    mistakes : list of Mistake
        Duplicate keys and keys without a value, with the way to each.
    """

    EMPTY = "has no value; give one, or omit the key"

    yaml_implicit_resolvers: ClassVar = {}  # type: ignore[misc]

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.mistakes: list[Mistake] = []

    def get_single_node(self) -> yaml.Node | None:
        """Return the root, without what would not fit into memory or never end."""
        root = super().get_single_node()
        if root is not None:
            count = _count(root, {}, set())
            if count > MOST_VALUES:
                message = f"has {count:.3g} values with its aliases written out"
                raise _refusal(f"{message}; allowed are {MOST_VALUES}")
            self.mistakes = list(_mistakes(root, (), set()))
        return root

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping with the keys as they are written, merged ones first."""
        self.flatten_mapping(node)
        return {key.value: self.construct_object(value, deep) for key, value in node.value}

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Put the keys of merged mappings before those of the mapping."""
        node.value = list(_pairs(node))

    def construct_number(self, node: yaml.ScalarNode) -> WrittenInt | WrittenFloat:
        """Return a number."""
        text = node.value.lower().replace(".inf", "inf").replace(".nan", "nan")
        for kind in (WrittenInt, WrittenFloat):
            with contextlib.suppress(ValueError):
                number = kind(text)
                number.written = node.value
                return number
        raise _refusal(f"{node.value} is not a number", node.start_mark)


Loader.add_implicit_resolver(
    f"{CORE}bool", re.compile("(true|True|TRUE|false|False|FALSE)$"), "tTfF"
)
Loader.add_implicit_resolver(f"{CORE}int", re.compile(r"[+-]?(0|[1-9][0-9]*)$"), "-+0123456789")
Loader.add_implicit_resolver(
    f"{CORE}float",
    re.compile(rf"(?![+-]?0\d)({NUMBER.pattern}|[+-]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$"),
    "-+0123456789.",
)
Loader.add_implicit_resolver(NULL, re.compile("(~|null|Null|NULL|)$"), ["~", "n", "N", ""])
Loader.add_implicit_resolver(MERGE, re.compile("<<$"), "<")
Loader.add_constructor(f"{CORE}int", Loader.construct_number)
Loader.add_constructor(f"{CORE}float", Loader.construct_number)


def _pairs(node: yaml.Node) -> Iterator[tuple[yaml.Node, yaml.Node]]:
    """Yield keys and values, those that count last: of several merged mappings the first.

    Versions of PyYAML differ in that order (https://yaml.org/type/merge.html).
    """
    if not isinstance(node, yaml.MappingNode):
        raise _refusal("expected a mapping or list of mappings for merging", node.start_mark)
    for key, value in node.value:
        if key.tag == MERGE:
            merged = value.value if isinstance(value, yaml.SequenceNode) else [value]
            for mapping in reversed(merged):
                yield from _pairs(mapping)
    yield from ((key, value) for key, value in node.value if key.tag != MERGE)


def _refusal(message: str, mark: yaml.Mark | None = None) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(None, None, message, mark)


def problem_of(error: yaml.YAMLError) -> tuple[int | None, str]:
    """Return the line of an error and what is wrong there."""
    if not isinstance(error, yaml.MarkedYAMLError):
        if isinstance(error, yaml.reader.ReaderError):
            return None, f"not YAML: the character U+{error.character:04X} is not allowed"
        return None, f"not YAML: {' '.join(str(error).split())}"
    mark, problem = error.problem_mark, " ".join(str(error.problem).split())
    context = error.context or ""
    if error.context_mark and context.startswith(("while scanning", "while parsing a flow")):
        mark = error.context_mark  # where what is not closed begins
    message = next(
        (message for fragment, message in WORDS["yaml"].items() if fragment in problem), problem
    )
    return (mark.line + 1 if mark else None), f"not YAML: {message}"


def _count(node: yaml.Node, counts: dict[int, int], ancestors: set[int]) -> int:
    """Return the number of values in a node with its aliases written out."""
    if node.tag not in TAGS:
        name = node.tag.replace(CORE, "!!")
        raise _refusal(f"the tag {name} is not allowed", node.start_mark)
    if id(node) in ancestors:
        raise _refusal("an alias contains itself", node.start_mark)
    # an escape such as "\ud800" writes what no file of results can have
    if isinstance(node, yaml.ScalarNode) and (odd := Loader.NON_PRINTABLE.search(node.value)):
        message = f"the character U+{ord(odd[0]):04X} is not allowed"
        raise _refusal(message, node.start_mark)
    if id(node) not in counts:
        ancestors.add(id(node))
        parts = [child for _, child in _children(node)]
        if isinstance(node, yaml.MappingNode):
            parts += [key for key, _ in node.value]
        counts[id(node)] = 1 + sum(_count(child, counts, ancestors) for child in parts)
        ancestors.remove(id(node))
    return counts[id(node)]


def _children(node: yaml.Node) -> Iterator[tuple[str | int, yaml.Node]]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if not isinstance(key, yaml.ScalarNode):
                raise _refusal("a key must be text", key.start_mark)
            yield key.value, value
    elif isinstance(node, yaml.SequenceNode):
        yield from enumerate(node.value)


def _mistakes(node: yaml.Node, way: Keys, visited: set[int]) -> Iterator[Mistake]:
    """Yield duplicate keys and keys without a value; in ``vary``, none is a value."""
    if id(node) in visited:
        return
    visited.add(id(node))
    lines: dict[str, int] = {}
    for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
        line = key.start_mark.line + 1
        if key.value in lines:
            message = f"duplicate key; already in line {lines[key.value]}"
            yield Mistake((*way, key.value), message, line)
        lines.setdefault(key.value, line)
    for name, child in _children(node):
        keys = (*way, name)
        if child.tag == NULL and "vary" not in way:
            yield Mistake(keys, Loader.EMPTY)
        yield from _mistakes(child, keys, visited)


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
        self.place = one_line(str(path))
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
        key = dotted(mistake.keys)
        setting = f"{key} = {value}" if value else key
        parts = (place, setting, one_line(mistake.message))
        return ": ".join(part for part in parts if part)

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
