"""Mistakes at the keys of a study."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from pidpanel.columns import ColumnsError

if TYPE_CHECKING:
    from pydantic import BaseModel

T = TypeVar("T")
Keys = tuple[str | int, ...]  # way to a place of a study: names of keys, and indices in lists


LONGEST_NAME = 80
MOST_NAMES = 1000  # under one key; what reads them takes a time that grows with their square


class Mistake(NamedTuple):
    """What is wrong at a key."""

    keys: Keys  # way from the model that speaks; empty for the whole model
    says: str  # what is wrong or allowed, without the key and its value
    line: int | None = None  # where a duplicate key is

    def prefix(self, *keys: str | int) -> Mistake:
        """Return the same mistake with the way to its model put in front."""
        return self._replace(keys=(*keys, *self.keys))


class Mistakes(ValueError):
    """All mistakes that a model, or a check of a whole study, has found."""

    def __init__(self, mistakes: Iterable[Mistake], model: type[BaseModel] | None = None) -> None:
        self.mistakes, self.model = tuple(mistakes), model  # the model that has found them
        lines = (f"{dotted(keys)}: {says}" if keys else says for keys, says, _ in self.mistakes)
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


def one_line(text: str) -> str:
    """Return a text with all that would break its line written as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


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
        text = name.strip()
        plain = name.isprintable() and text == name and not set(name) & {"/", '"'}
        if not plain or name in ("", ".", "..") or len(name) > LONGEST_NAME:
            yield Mistake(
                (key, name),
                f"must have a name of 1 to {LONGEST_NAME} printable characters without '/', '\"' "
                "or surrounding spaces, because files and mesh groups use it",
            )


def unknown_key(key: str, allowed: Sequence[str]) -> str:
    """Return what to say of an unknown key: the nearest allowed one, or all of them.

    Examples
    --------
    >>> unknown_key("dept_mm", ["depth_mm", "count"])
    'unknown key; did you mean depth_mm?'
    >>> unknown_key("restitution", ["depth_mm", "count"])
    'unknown key; allowed are depth_mm, count'
    """
    meant = _meant(key, allowed, 0.5)
    return f"unknown key; {meant or 'allowed are ' + ', '.join(allowed)}"


def not_among(section: str, name: str, allowed: Sequence[str]) -> str:
    """Return what to say of a name that is not among those of a section.

    Examples
    --------
    >>> not_among("dampers", "stele", ["acrylic", "steel"])
    'must be one of dampers: acrylic, steel; did you mean steel?'
    """
    meant = _meant(name, allowed, 0.6) if len(allowed) > 1 else ""
    return f"must be one of {section}: {', '.join(allowed)}" + (f"; {meant}" if meant else "")


def _meant(name: str, allowed: Sequence[str], cutoff: float) -> str:
    lower = {entry.lower(): entry for entry in allowed}
    near = difflib.get_close_matches(name.lower(), lower, n=1, cutoff=cutoff)
    return f"did you mean {lower[near[0]]}?" if near else ""
