"""Mistakes at the keys of a study, those that pydantic finds too, in a reader's words."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from pidpanel.columns import ColumnsError
from pidpanel.study.choice import TAG, keys_of, kinds_of
from pidpanel.text_files import one_line

T = TypeVar("T")
Keys = tuple[str | int, ...]  # way to a place of a study: names of keys, and indices in lists


# Messages for mistakes found by pydantic and pyyaml, and for wrong units.
WORDS = yaml.safe_load(Path(__file__).with_name("words.yaml").read_text(encoding="utf-8"))

LONGEST_NAME = 80
MOST_NAMES = 1000  # under one key; what reads them takes a time that grows with their square


class Mistake(NamedTuple):
    """A mistake at a key."""

    keys: Keys  # way from the model that speaks; empty for the whole model
    message: str  # what is wrong or allowed, without the key and its value
    line: int | None = None  # of a duplicate key, and of one without a value

    def prefix(self, *keys: str | int) -> Mistake:
        """Return the same mistake with the way to its model put in front."""
        return self._replace(keys=(*keys, *self.keys))


class Mistakes(ValueError):
    """All mistakes that a model, or a check of a whole study, has found."""

    def __init__(self, mistakes: Iterable[Mistake], model: type[BaseModel] | None = None) -> None:
        self.mistakes, self.model = tuple(mistakes), model  # the model that has found them
        lines = (
            f"{dotted(keys)}: {message}" if keys else message for keys, message, _ in self.mistakes
        )
        super().__init__("; ".join(lines))


def read_at(keys: Keys, read: Callable[[], T]) -> Generator[Mistake, None, T | None]:
    """Yield the mistakes of a file at the key that names it; return what is read; None for any."""
    try:
        return read()
    except ColumnsError as error:
        yield from (Mistake(keys, fault) for fault in error.faults)
        return None


def dotted(keys: Keys) -> str:
    """Return the way to a key as a reader writes it.

    Examples
    --------
    >>> dotted(("panel", "patches", "Left wing", "corners_m", 2))
    'panel.patches.Left wing.corners_m[2]'
    """
    parts = (
        f"[{key}]" if isinstance(key, int) else f".{one_line(key) or repr(key)}" for key in keys
    )
    return "".join(parts).removeprefix(".")


def mistakes_of_names(key: str, names: Iterable[str]) -> Iterator[Mistake]:
    """Yield the names under a key that cannot name a file and a group of a mesh.

    At most `LONGEST_NAME` characters: with those of others a name is part of that of a file. More
    than `MOST_NAMES` are one mistake.

    Examples
    --------
    >>> [mistake.keys for mistake in mistakes_of_names("points", ["A", "B/C", ""])]
    [('points', 'B/C'), ('points', '')]
    """
    names = list(names)
    if len(names) > MOST_NAMES:
        yield Mistake((key,), f"has {len(names)} names; allowed are {MOST_NAMES}")
        return
    for name in names:
        if is_formula(name):
            message = f"must not begin with {name[0]!r}: spreadsheets compute it in the tables"
            yield Mistake((key, name), message)
        text = name.strip()
        plain = name.isprintable() and text == name and not set(name) & {"/", '"'}
        if not plain or name in ("", ".", "..") or len(name) > LONGEST_NAME:
            yield Mistake(
                (key, name),
                f"must have a name of 1 to {LONGEST_NAME} printable characters without '/', '\"' "
                "or surrounding spaces, because files and mesh groups use it",
            )


def is_formula(text: str) -> bool:
    """Return whether a spreadsheet computes a text of a table: not a plain ``-X`` or ``+Y wing``.

    Examples
    --------
    >>> [is_formula(text) for text in ("=1+cmd|' /C calc'!A0", "@SUM(1)", "-2+3", "+Y wing", "A=B")]
    [True, True, True, False, False]
    """
    return re.match(r"\s*(?:[=@]|[+-](?![\w .-]*$))", text) is not None


def unknown_key(key: str, allowed: Sequence[str]) -> str:
    """Return the message for an unknown key: the nearest allowed one, or all of them.

    Examples
    --------
    >>> unknown_key("dept_mm", ["depth_mm", "count"])
    'unknown key; did you mean depth_mm?'
    >>> unknown_key("restitution", ["depth_mm", "count"])
    'unknown key; allowed are depth_mm, count'
    """
    guess = _guess(key, allowed, 0.5)
    return f"unknown key; {guess or 'allowed are ' + ', '.join(allowed)}"


def not_among(section: str, name: str, allowed: Sequence[str]) -> str:
    """Return the message for a name that is not in a section.

    Examples
    --------
    >>> not_among("dampers", "stele", ["acrylic", "steel"])
    'must be one of dampers: acrylic, steel; did you mean steel?'
    """
    guess = _guess(name, allowed, 0.6) if len(allowed) > 1 else ""
    return f"must be one of {section}: {', '.join(allowed)}" + (f"; {guess}" if guess else "")


def _guess(name: str, allowed: Sequence[str], cutoff: float) -> str:
    lower = {entry.lower(): entry for entry in allowed}
    near = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=cutoff)
    return f"did you mean {lower[near[0]]}?" if near else ""


def listed(words: Sequence[str]) -> str:
    """Return words as in a sentence.

    Examples
    --------
    >>> listed(["a"]), listed(["a", "b", "c"])
    ('a', 'a, b and c')
    """
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def in_words(error: ErrorDetails) -> str:
    """Return the message of pydantic for a mistake, in words for the user of a study.

    Examples
    --------
    >>> from pydantic import TypeAdapter, ValidationError
    >>> try:
    ...     TypeAdapter(str).validate_python(3)
    ... except ValidationError as refused:
    ...     in_words(refused.errors()[0])
    'must be text'
    """
    context = error.get("ctx", {})
    if error["type"] in ("too_short", "too_long"):
        extreme, bound = ("least", "min") if error["type"] == "too_short" else ("most", "max")
        count = context[f"{bound}_length"]
        values = f"{count} value{'' if count == 1 else 's'}"
        return f"must have at {extreme} {values}, not {context['actual_length']}"
    if "message" in context:  # of a `Quantity`
        return str(context["message"])
    if error["type"] in WORDS["pydantic"]:
        return WORDS["pydantic"][error["type"]].format(**context)
    message = error["msg"].removeprefix("Value error, ")
    return message.replace("Input should be ", "must be ", 1)


def mistakes_of(error: ValidationError, model: type[BaseModel]) -> Iterator[Mistake]:
    """Yield the mistakes in the values of a model, those that its sections have found too."""
    items = {_keys_of(item): item for item in error.errors(include_url=False)}
    reported: set[tuple[Keys, str]] = set()
    for keys, item in items.items():
        refused = item.get("ctx", {}).get("error")
        if isinstance(refused, Mistakes):
            yield from (mistake.prefix(*keys) for mistake in refused.mistakes)
        elif item["type"] == "too_short" and any(
            len(inner) > len(keys) and inner[: len(keys)] == keys for inner in items
        ):
            continue  # pydantic counts the good items only
        else:
            mistake = _mistake_at(keys, item, model)
            # the first item of a list with the same mistake represents all
            around = keys[:-1] if keys and isinstance(keys[-1], int) else keys
            if (alike := (around, mistake.message.partition(";")[0])) not in reported:
                yield mistake
            reported.add(alike)


def _keys_of(item: ErrorDetails) -> Keys:
    """Return the way to a mistake, without the names of alternatives; a short list as a whole."""
    keys = tuple(part for part in item["loc"] if not str(part).startswith(TAG))
    refused = item.get("ctx", {}).get("error")
    # a section that is chosen by its kind has that after its key
    is_kind = isinstance(refused, Mistakes) and kinds_of(refused.model) == keys[-1:]
    is_short = item["type"] == "missing" and isinstance(keys[-1], int)
    return keys[:-1] if is_kind or is_short else keys


def _mistake_at(keys: Keys, item: ErrorDetails, model: type[BaseModel]) -> Mistake:
    kind = item["type"]
    if kind == "extra_forbidden":
        return Mistake(keys, unknown_key(str(keys[-1]), keys_of(model)))
    if kind == "model_type":
        return Mistake(keys, f"must be a mapping with keys {', '.join(keys_of(model))}")
    if kind == "union_tag_not_found" and not isinstance(item["input"], Mapping):
        return Mistake(keys, WORDS["pydantic"]["model_attributes_type"])
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        options = get_args(model.model_fields[str(keys[0])].annotation)
        *kinds, last = [repr(name) for option in options for name in kinds_of(option)]
        missing = "missing; " if kind == "union_tag_not_found" else ""
        return Mistake((*keys, "kind"), f"{missing}must be {', '.join(kinds)} or {last}")
    if kind == "missing" and isinstance(item["loc"][-1], int):
        length, count = item["loc"][-1] + 1, len(item["input"])
        return Mistake(keys, f"must have at least {length} values, not {count}")
    return Mistake(keys, in_words(item))
