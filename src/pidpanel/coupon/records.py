"""Results of the steps of a coupon, as records in JSON files.

`packing.json`, `bed.json` and `<case>/<target>.json` hold outcomes of steps;
`<case>/s<seed>/state.json` is the `RunState` of a run. Pydantic checks what is read without
converting it: no key is missing, no value has another type.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Generic, TypeVar, cast

from pydantic import TypeAdapter, ValidationError

from pidpanel.coupon.balance import EnergyBalance
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.failures import FileDamaged, RecordUnreadable, RunFailed
from pidpanel.provenance import durable
from pidpanel.provenance.digests import file_digest

OK = "ok"  # status of a step that did what it should; any other is the name of a failure

Product = TypeVar("Product")


def write(path: Path, record: Any) -> None:
    """Write a record, a dataclass of numbers, texts and further records, as a JSON file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    durable.write_text(path, json.dumps(asdict(record), indent=1) + "\n")


def read(kind: type[Product], path: Path) -> Product:
    """Read a record of a kind from a JSON file.

    Raises
    ------
    RecordUnreadable
        If the file is missing, or is not such a record.
    """
    try:
        # strict JSON takes a list for a tuple and 1 for 1.0, and nothing else
        return _adapter(cast(Any, kind)).validate_json(path.read_bytes(), strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "record"
        message = f"{place}: {first['msg']}"
    except OSError as error:
        message = str(error.strerror)
    raise RecordUnreadable(f"{path}: {message}; delete it and run again")


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


Files = Mapping[str, str]  # names of files of a folder, and the hash of the content of each


def files_of(folder: Path, names: Iterable[str]) -> Files:
    """Return the hashes of files of a folder; an empty one for a file that cannot be read.

    Raises
    ------
    FileDamaged
        If a name, which may come from a record of somebody else, leads out of the folder.
    """
    hashes = dict.fromkeys(names, "")
    if outside := [name for name in hashes if Path(name).name != name]:
        raise FileDamaged(f"{folder}: {outside[0]!r} must be the name of a file in it")
    for name in hashes:
        with suppress(OSError):
            hashes[name] = file_digest(folder / name)
    return hashes


def check_files(folder: Path, files: Files) -> None:
    """Refuse a folder whose files are not those that were left in it."""
    for name, digest in files_of(folder, files).items():
        if digest != files[name]:
            condition = "damaged or changed" if digest else "missing"
            raise FileDamaged(f"{folder / name}: {condition} since it was written")


@dataclass(frozen=True)
class Poured:
    """A poured packing."""

    poured: int  # spheres in all cells, up to above the lid
    spheres_full: int  # N_full: spheres of a full cell
    bulk_fraction: float  # volume of the spheres over that of the cell, where it is full [1]


@dataclass(frozen=True)
class Loosened:
    """A bed that was shaken loose."""

    spheres: int  # in all cells
    deepest_overlap_m: float  # [m]


@dataclass(frozen=True)
class MeasuredBalance:
    """The energy balance of a run over a window; see `window`."""

    energies: EnergyBalance
    closure: float  # residual over the work [1]
    cycles: int
    frames: int


@dataclass(frozen=True)
class Shaken:
    """A run that went to its target."""

    cycles: int  # that the target took; more may have been run for another
    # Cycles of each LIGGGHTS process, in ``cycles_1.txt``, ``cycles_2.txt``, …
    legs: tuple[int, ...]
    spheres: int  # in all cells
    mass_kg: float  # of all spheres [kg]
    ended_by: str  # ``accuracy`` or ``max_cycles``
    balance: MeasuredBalance | None  # none where the deck cannot list its contacts


@dataclass(frozen=True)
class Outcome(Generic[Product]):
    """Outcome of a step: `Poured`, `Loosened` or `Shaken`, or the name of a failure."""

    status: str  # `OK`, or the name of a failure of `liggghts.failures`
    message: str
    found: Product | None  # None after a failure

    @property
    def product(self) -> Product:
        """What the step made.

        Raises
        ------
        RunFailed
            If it ended with a failure.
        """
        if self.found is None:
            raise RunFailed(self.status, self.message)
        return self.found


@dataclass(frozen=True)
class CaseOutcome:
    """Outcomes of the runs of a case: its seeds and, where it has several states, its reserve."""

    runs: tuple[Outcome[Shaken], ...]


@dataclass(frozen=True)
class End:
    """End of a run where it met a target."""

    cycles: int  # of the run so far
    # Balance of the cycles that follow; None if the deck cannot list its contacts.
    balance: MeasuredBalance | None


@dataclass(frozen=True)
class RunState:
    """Valid contents of a run's folder."""

    run: str  # `Run.identity`; the files of another run are ignored
    spheres: int  # in all cells
    mass: float  # of all spheres [kg]
    # Cycles of each LIGGGHTS process, in ``cycles_1.txt``, ``cycles_2.txt``, …
    legs: tuple[int, ...]
    ends: tuple[End, ...]  # one for each length at which the run has met a target
    # `window.BALANCE_VERSION` when their balances were measured; those of another are ignored.
    balance_version: int
    files: Files  # what a leg starts from, `start_files`

    @property
    def cycles(self) -> int:
        """Cycles of all legs."""
        return sum(self.legs)

    @property
    def restart(self) -> str:
        """File from which the run can continue; empty before the first."""
        return f"at_{self.cycles}.restart" if self.cycles else ""

    @property
    def start_files(self) -> list[str]:
        """Names of what a leg starts from: spheres, walls, restart."""
        return [name for name in (deck.START_FILE, deck.WALLS_FILE, self.restart) if name]

    def ended(self, end: End, balance_version: int) -> RunState:
        """Return the state with one more end; ends of another balance version are dropped."""
        ends = self.ends if self.balance_version == balance_version else ()
        earlier = (earlier_end for earlier_end in ends if earlier_end.cycles != end.cycles)
        return replace(self, ends=(*earlier, end), balance_version=balance_version)

    def with_files(self, folder: Path) -> RunState:
        """Return the state with the hashes of the files of a folder."""
        return replace(self, files=files_of(folder, self.start_files))

    def write(self, folder: Path) -> None:
        """Write ``state.json``."""
        write(folder / "state.json", self)

    @staticmethod
    def read(folder: Path) -> RunState | None:
        """Return the state of a folder; None if it has none."""
        path = folder / "state.json"
        return read(RunState, path) if path.exists() else None
