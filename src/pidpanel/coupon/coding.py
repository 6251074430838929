"""Records to JSON and back; a record is a frozen dataclass.

A record holds numbers, text, truth values, None, other records and tuples of these. Pydantic
checks what comes back without converting it: no key is missing or unknown, no value has another
type.
"""

import json
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from pidpanel.coupon.liggghts.failures import RecordUnreadable
from pidpanel.provenance import durable

Record = TypeVar("Record")


def encode(record: Any) -> dict[str, Any]:
    """Return a record as values of JSON; `decode` is the inverse."""
    return asdict(record)


def decode(kind: type[Record], values: Any, source: str = "record") -> Record:
    """Return a record from values of JSON.

    Parameters
    ----------
    values
        Result of `encode`.

    Raises
    ------
    RecordUnreadable
        If a key is missing, unknown or of another type.
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
    """Return JSON with whole numbers written like others."""
    return json.dumps(json.loads(json.dumps(values), parse_int=float), sort_keys=True)


def write(path: Path, record: Any) -> None:
    """Write a record as a JSON file; make its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    durable.write_text(path, json.dumps(encode(record), indent=1) + "\n")


def read(kind: type[Record], path: Path) -> Record:
    """Read a record from a JSON file.

    Raises
    ------
    RecordUnreadable
        If the file is missing, or is not such a record.
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise RecordUnreadable(f"{path}: {error}; delete it and run again") from None
    return decode(kind, values, str(path))
