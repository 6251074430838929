"""What another version left in ``results/coupon``: no study asks for it any more.

A label ends in the hash of all that its numbers depend on, so what was made by other code that
pours, another deck or another LIGGGHTS has a label of its own, and stays beside what this version
makes. It is found by its own record: of the values in there this version makes another label.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pidpanel.coupon import coding
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.liggghts.failures import RecordUnreadable
from pidpanel.coupon.packing import Packing

NO_CASES = frozenset(("packing", "bed", "batch", "leg"))
"""Folders of ``results/coupon`` that are none of a case."""


@dataclass(frozen=True)
class Older:
    """What no study asks for any more."""

    packings: tuple[Path, ...]
    beds: tuple[Path, ...]
    cases: tuple[Path, ...]

    @property
    def folders(self) -> tuple[Path, ...]:
        """All of them, and those of the legs of the cases."""
        legs = (case.parent / "leg" / case.name for case in self.cases)
        return (*self.cases, *(leg for leg in legs if leg.is_dir()), *self.beds, *self.packings)

    def __bool__(self) -> bool:
        return bool(self.packings or self.beds or self.cases)

    def __str__(self) -> str:
        kinds = {"case": self.cases, "bed": self.beds, "packing": self.packings}
        parts = (
            f"{len(paths)} {name if len(paths) == 1 else name + 's'}"
            for name, paths in kinds.items()
            if paths
        )
        return f"{', '.join(parts)} ({size_text(sum(map(size_of, self.folders)))})"


def describe_older(folder: Path, labels: Collection[str] = ()) -> str:
    """Return a line on what another version left in ``results/coupon``; none where nothing is.

    Parameters
    ----------
    folder, labels
        As of `older`.
    """
    remains = older(folder, labels)
    if not remains:
        return ""
    return (
        f"{folder}: {remains} made by another version of pidpanel, of LIGGGHTS or of a deck; "
        "kept but not used; pidpanel clean removes them"
    )


def older(folder: Path, labels: Collection[str] = ()) -> Older:
    """Find what another version left.

    Parameters
    ----------
    folder
        ``results/coupon``.
    labels
        Labels that this version asks for, which are not looked at.
    """
    return Older(
        tuple(_of_kind(folder / "packing", "packing.json", "packing", labels)),
        tuple(_of_kind(folder / "bed", "bed.json", "bed", labels)),
        tuple(path for path in _folders(folder, {*labels, *NO_CASES}) if _is_older_case(path)),
    )


def _folders(folder: Path, without: Collection[str]) -> Iterator[Path]:
    """Folders in a folder; not what is made or was set aside."""
    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    for path in paths:
        if path.name not in without and not path.name.startswith(".") and path.is_dir():
            if not path.name.endswith(".broken"):
                yield path


def _of_kind(folder: Path, file: str, key: str, labels: Collection[str]) -> Iterator[Path]:
    for path in _folders(folder, labels):
        kind = Packing if key == "packing" else Bed
        label = _label(_values(path / file).get(key), kind)
        if label not in ("", path.name):
            yield path


def _is_older_case(folder: Path) -> bool:
    """Whether a run of a case is another than the one that its record would be now."""
    for run_folder in _folders(folder, ()):
        identity = _values(run_folder / "state.json").get("run")
        for file in sorted(run_folder.glob("*to*.json")):
            values = _values(file).get("run")
            if identity is not None and values is not None:
                return _label(values, Run) not in ("", identity)
    return False


def _label(values: Any, kind: type[Packing] | type[Bed] | type[Run]) -> str:
    """Return the label of values in this version, a question mark where it cannot hold them.

    Empty where there are none, or where they name a deck that is not there.
    """
    if values is None:
        return ""
    try:
        record = coding.decode(kind, values)
        return record.identity if isinstance(record, Run) else record.label
    except RecordUnreadable:
        return "?"
    except Exception:  # a deck of somebody else may fail in any way
        return ""


def _values(file: Path) -> Mapping[str, Any]:
    """Return the values of a record; none of one that is damaged or not there."""
    try:
        values = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return values if isinstance(values, dict) else {}


def size_of(path: Path) -> int:
    """Bytes of a file, or of all files of a folder."""
    files = path.rglob("*") if path.is_dir() else [path]
    return sum(file.lstat().st_size for file in files if file.is_file())


def size_text(size: float) -> str:
    """Return a number of bytes as it is read.

    Examples
    --------
    >>> size_text(2.34e9), size_text(5e6), size_text(300)
    ('2.3 GB', '5.0 MB', '1 kB')
    """
    for unit, name in ((1e9, "GB"), (1e6, "MB")):
        if size >= unit:
            return f"{size / unit:.1f} {name}"
    return f"{max(1, round(size / 1e3))} kB"
