"""Records to JSON and back: the one place where a frozen dataclass becomes text.

A record holds numbers, text, truth values, None, other records and tuples of these. What comes
back is checked key by key: nothing is left out, nothing is added, nothing is of another kind. A
file holds the hash of its values beside them, so that a changed digit shows too.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, cast, get_args, get_origin, get_type_hints

from pidpanel.coupon.liggghts.failures import RecordUnreadable
from pidpanel.provenance import durable

Record = TypeVar("Record")


def encode(record: Any) -> dict[str, Any]:
    """A record as JSON holds it; `decode` is the inverse."""
    return asdict(record)


def decode(kind: type[Record], values: Any, source: str = "record") -> Record:
    """A record from what JSON held.

    Parameters
    ----------
    kind
        Class of the record.
    values
        What `encode` gave.
    source
        File or argument, for the message.

    Raises
    ------
    RecordUnreadable
        With the source and the key that is missing, unknown or of another kind.
    """
    if not isinstance(values, Mapping):
        raise RecordUnreadable(f"{source}: {values!r} is not a {kind.__name__}")
    expected = _types_of(cast(Any, kind))
    if missing := sorted(expected.keys() - values.keys()):
        raise RecordUnreadable(f"{source}: no key {missing[0]!r} of {kind.__name__}")
    if unknown := sorted(values.keys() - expected.keys()):
        raise RecordUnreadable(f"{source}: unknown key {unknown[0]!r} in {kind.__name__}")
    return kind(
        **{key: _value(own, values[key], f"{source}: {key}") for key, own in expected.items()}
    )


DIGEST = "digest"
"""Key of a file with the hash of all its other values."""


def write(path: Path, record: Any) -> None:
    """Write a record as a JSON file."""
    values = encode(record)
    text = json.dumps({**values, DIGEST: _digest(values)}, indent=1)
    durable.write_text(path, text + "\n")


def _digest(values: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


def read(kind: type[Record], path: Path) -> Record:
    """Read a record from a JSON file.

    Raises
    ------
    RecordUnreadable
        With the file and what is wrong in it, that it is not there, or that it is not as it was
        written.
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise RecordUnreadable(f"{path}: {error}") from None
    written = values.pop(DIGEST, None) if isinstance(values, dict) else None
    record = decode(kind, values, str(path))
    if written != _digest(values):
        raise RecordUnreadable(f"{path}: not as it was written: its values do not give its digest")
    return record


@lru_cache
def _types_of(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in fields(kind)}


def _meant(parts: tuple[Any, ...], value: Any, where: str) -> Any:
    """Of the types of a union the one there is, or the record whose ``kind`` the value names."""
    types = [part for part in parts if part is not NoneType]
    if len(types) == 1:
        return types[0]
    named = value.get("kind") if isinstance(value, Mapping) else None
    for one in types:
        if is_dataclass(one) and named in get_args(_types_of(cast(Any, one)).get("kind")):
            return one
    raise RecordUnreadable(f"{where} = {value!r}: none of {', '.join(t.__name__ for t in types)}")


def _value(kind: Any, value: Any, where: str) -> Any:
    """A value of a field, of the type that the record gives it."""
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Mapping or (origin is Literal and value in parts):
        return value
    if isinstance(kind, UnionType):
        if value is None and NoneType in parts:
            return None
        return _value(_meant(parts, value, where), value, where)
    if origin is tuple and isinstance(value, list | tuple):
        inner = parts[:1] * len(value) if parts[1:] == (...,) else parts
        if len(inner) == len(value):
            pairs = enumerate(zip(inner, value, strict=True))
            return tuple(_value(one, item, f"{where}[{i}]") for i, (one, item) in pairs)
    elif is_dataclass(kind):
        return decode(kind, value, where)  # type: ignore[arg-type]
    elif kind is float and type(value) is int:
        return float(value)
    elif type(value) is kind:
        return value
    raise RecordUnreadable(f"{where} = {value!r}: not of type {getattr(kind, '__name__', kind)}")
