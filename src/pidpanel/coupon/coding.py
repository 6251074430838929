"""Records to JSON and back; a record is a frozen dataclass.

A record holds numbers, text, truth values, None, other records and tuples of these. Pydantic
checks what comes back without converting it: no key is missing or unknown, no value has another
type. A file holds the hash of its values, which shows a changed digit.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from pidpanel import durable
from pidpanel.coupon.liggghts.failures import RecordUnreadable

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
        With the source and the first key that is missing, unknown or of another type.
    """
    try:
        # strict JSON takes a list for a tuple and 1 for 1.0, and nothing else
        record: Record = _adapter(cast(Any, kind)).validate_json(
            json.dumps(values), strict=True, extra="forbid"
        )
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or kind.__name__
        raise RecordUnreadable(f"{source}: {place}: {first['msg']}") from None
    if _plain(encode(record)) != _plain(values):  # a default in place of a value
        raise RecordUnreadable(f"{source}: a key of {kind.__name__} is missing")
    return record


@lru_cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _plain(values: Any) -> str:
    """JSON in which whole numbers are written as others are."""
    return json.dumps(json.loads(json.dumps(values), parse_int=float), sort_keys=True)


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


SHARED = "="
"""Key of what stands for an earlier record, with its number."""


def shared_json(records: Sequence[Any]) -> str:
    """Records as JSON in which one that comes again is written once.

    Examples
    --------
    >>> from dataclasses import make_dataclass
    >>> bed, run = make_dataclass("Bed", ["r"]), make_dataclass("Run", ["bed"])
    >>> shared_json([run(bed(0.5)), run(bed(0.5))])
    '[[{"r": 0.5}, {"bed": {"=": 0}}], [{"=": 1}, {"=": 1}]]'
    """
    numbers: dict[str, int] = {}
    # of records that are not only equal but the same; kept, so that no other takes its place
    same: dict[int, tuple[Any, dict[str, int]]] = {}
    table: list[Any] = []

    def shared(value: Any) -> Any:
        if id(value) in same:
            return same[id(value)][1]
        if is_dataclass(value) or isinstance(value, Mapping):
            values = value if isinstance(value, Mapping) else _fields_of(value)
            short = {name: shared(item) for name, item in values.items()}
            number = numbers.setdefault(json.dumps(short), len(table))
            if number == len(table):
                table.append(short)
            same[id(value)] = (value, {SHARED: number})
            return {SHARED: number}
        if isinstance(value, list | tuple):
            return [shared(item) for item in value]
        return value

    top = shared(records)
    return json.dumps([table, top])


def _fields_of(record: Any) -> dict[str, Any]:
    """Values of its fields, without what it keeps besides (`functools.cached_property`)."""
    return {field.name: getattr(record, field.name) for field in fields(record)}


def from_shared_json(text: str) -> Any:
    """The inverse of `shared_json`."""
    table, top = json.loads(text)
    decoded: list[Any] = []

    def whole(value: Any) -> Any:
        if isinstance(value, dict):
            return decoded[value[SHARED]]
        return [whole(item) for item in value] if isinstance(value, list) else value

    for values in table:
        decoded.append({key: whole(item) for key, item in values.items()})
    return whole(top)
