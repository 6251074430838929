"""YAML 1.2 with the lines of its keys: keys as written, numbers with their text, nothing that runs.

PyYAML composes the nodes. ruamel.yaml makes numbers of keys, stops at the first duplicate key and
takes 1.6 times as long for the same nodes.
"""

import contextlib
import re
from collections.abc import Iterator
from typing import Any, ClassVar

import yaml

from pidpanel.columns import NUMBER
from pidpanel.study.base import StudyError
from pidpanel.study.mistakes import WORDS, Keys, Mistake
from pidpanel.study.values import WrittenFloat, WrittenInt, written

CORE = "tag:yaml.org,2002:"
PLAIN = "plain"  # tag of a scalar without quotes and without a tag
# Tags of what is read as plain text is, and all that are allowed.
READ = {PLAIN, *(CORE + kind for kind in ("int", "float", "bool", "null"))}
TAGS = {*READ, *(CORE + kind for kind in ("str", "map", "seq"))}
EMPTY = "has no value; give one, or omit the key"
NON_PRINTABLE = yaml.reader.Reader.NON_PRINTABLE

CONSTANTS = {
    form(word): value
    for word, value in {"true": True, "false": False, "null": None, "~": None, "": None}.items()
    for form in (str.lower, str.title, str.upper)
}
NUMERIC = re.compile(rf"(?![+-]?0\d)({NUMBER.pattern})|[+-]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


def scalar_of(text: str) -> Any:
    """Return what plain text is in YAML 1.2: a number, a truth value, None, or the text.

    ``on``, ``1:30`` and dates are text, and ``031`` is no number.

    Examples
    --------
    >>> scalar_of("1e3"), scalar_of("True"), scalar_of("~"), scalar_of("on"), scalar_of("031")
    (1000.0, True, None, 'on', '031')
    """
    if NUMERIC.fullmatch(text):
        number = re.sub(r"\.([inINfFaA]{3})", r"\1", text)
        with contextlib.suppress(ValueError):
            return written(WrittenInt, number, text)
        return written(WrittenFloat, number, text)
    return CONSTANTS.get(text, text)


def number_of(text: str) -> Any:
    """Return the number or truth value that a text is in YAML; the text where it is none."""
    value = scalar_of(text.strip())
    return text if value is None or isinstance(value, str) else value


def printable(text: str) -> str:
    """Refuse what no file of results can have."""
    if odd := NON_PRINTABLE.search(text):
        raise StudyError(f"{text!r}: the character U+{ord(odd[0]):04X} is not allowed")
    return text


class _Composer(yaml.BaseLoader):
    """Leaves the meaning of plain scalars to `scalar_of`."""

    yaml_implicit_resolvers: ClassVar = {None: [(PLAIN, re.compile(""))]}  # type: ignore[misc]


class Content:
    """The content of a YAML text.

    Attributes
    ----------
    data : Any
        Its values; None for an empty text.
    lines : dict
        Line of each key and each entry of a list, by the way to it.
    mistakes : list of Mistake
        Duplicate keys and keys without a value.
    """

    def __init__(self, text: str) -> None:
        self.lines: dict[Keys, int] = {(): 0}
        self.mistakes: list[Mistake] = []
        self._nodes = set[int]()
        root = yaml.compose(text, _Composer)
        self.data: Any = None if root is None else self._value(root, ())
        self.is_empty = root is None

    def _value(self, node: yaml.Node, keys: Keys) -> Any:
        if node.tag not in TAGS:
            raise _refusal(f"the tag {node.tag.replace(CORE, '!!')} is not allowed", node)
        # of a mapping that stands in several places the mistakes are reported once
        is_new = id(node) not in self._nodes
        self._nodes.add(id(node))
        if isinstance(node, yaml.MappingNode):
            return self._mapping(node, keys, is_new)
        if isinstance(node, yaml.SequenceNode):
            entries = enumerate(node.value)
            return [self._entry(item, item, (*keys, index), is_new) for index, item in entries]
        text = _text(node)
        return scalar_of(text) if node.tag in READ else text

    def _mapping(self, node: yaml.MappingNode, keys: Keys, is_new: bool) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for merged in _merged(node):  # before what counts more
            values |= self._value(merged, keys)
        lines: dict[str, int] = {}
        for key, child in node.value:
            name, line = _text(key), key.start_mark.line + 1
            if is_new and name in lines:
                message = f"duplicate key; already in line {lines[name]}"
                self.mistakes.append(Mistake((*keys, name), message, line))
            lines.setdefault(name, line)
            if not _is_merge(key):
                values[name] = self._entry(key, child, (*keys, name), is_new)
        return values

    def _entry(self, key: yaml.Node, node: yaml.Node, keys: Keys, is_new: bool) -> Any:
        self.lines[keys] = line = key.start_mark.line + 1
        value = self._value(node, keys)
        if is_new and value is None and "vary" not in keys[:-1]:  # where none is a value
            self.mistakes.append(Mistake(keys, EMPTY, line))
        return value


def _text(node: yaml.Node) -> str:
    if not isinstance(node, yaml.ScalarNode):
        raise _refusal("a key must be text", node)
    # an escape such as "\ud800" writes what no file of results can have
    if odd := NON_PRINTABLE.search(node.value):
        raise _refusal(f"the character U+{ord(odd[0]):04X} is not allowed", node)
    return str(node.value)


def _is_merge(key: yaml.Node) -> bool:
    return key.tag == PLAIN and key.value == "<<"


def _merged(node: yaml.MappingNode) -> Iterator[yaml.MappingNode]:
    """Yield the mappings that are merged into one, the first of several last, which counts.

    Versions of PyYAML differ in that order (https://yaml.org/type/merge.html).
    """
    for key, child in node.value:
        mappings = child.value if isinstance(child, yaml.SequenceNode) else [child]
        for mapping in reversed(mappings) if _is_merge(key) else ():
            if not isinstance(mapping, yaml.MappingNode):
                raise _refusal("<< must be a mapping or a list of mappings", mapping)
            yield mapping


def _refusal(message: str, node: yaml.Node) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(None, None, message, node.start_mark)


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
