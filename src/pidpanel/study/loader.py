"""YAML 1.2 with keys as written: numbers with their text, nothing that explodes or never ends."""

import contextlib
import re
from collections.abc import Iterator
from typing import Any, ClassVar

import yaml

from pidpanel.columns import NUMBER
from pidpanel.study.base import StudyError
from pidpanel.study.mistakes import WORDS, Keys, Mistake
from pidpanel.study.numbers import WrittenFloat, WrittenInt

CORE = "tag:yaml.org,2002:"
NULL, MERGE = f"{CORE}null", f"{CORE}merge"
TAGS = {CORE + kind for kind in ("str", "int", "float", "bool", "null", "map", "seq", "merge")}
MOST_VALUES = 500_000  # values that a study may have once its aliases are written out


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


def printable(text: str) -> str:
    """Refuse what no file of results can have."""
    if odd := Loader.NON_PRINTABLE.search(text):
        raise StudyError(f"{text!r}: the character U+{ord(odd[0]):04X} is not allowed")
    return text


def number_of(text: str) -> Any:
    """Return the number or truth value that a text is in YAML; the text where it is none."""
    with contextlib.suppress(yaml.YAMLError):
        loader = Loader(text)
        node = loader.get_single_node()
        if isinstance(node, yaml.ScalarNode) and node.tag.endswith(("int", "float", "bool")):
            return loader.construct_document(node)
    return text
