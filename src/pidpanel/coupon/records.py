"""Results of the steps of a coupon, as records; `coding` converts them to JSON and back.

`packing.json` is a `PourOutcome`, `bed.json` a `LoosenOutcome`, `<case>/s<seed>/<target>.json` a
`ShakeOutcome`; `<case>/s<seed>/state.json` is the `RunState` of a run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from pidpanel.coupon import coding
from pidpanel.coupon.balance import EnergyBalance
from pidpanel.coupon.bed import Bed, Run
from pidpanel.coupon.cases import RunTarget
from pidpanel.coupon.liggghts.failures import FileDamaged, RecordUnreadable, RunFailed
from pidpanel.coupon.packing import Packing
from pidpanel.provenance.requests import content_digest

OK = "ok"  # status of a step that did what it should; any other is the name of a failure

Files = Mapping[str, str]  # names of files of a folder, and the hash of the content of each


def files_of(folder: Path, names: Iterable[str]) -> Files:
    """Return the hashes of files of a folder; an empty one for a missing file.

    Raises
    ------
    FileDamaged
        If a name, which may come from a record of somebody else, leads out of the folder.
    """
    names = tuple(names)
    if outside := [name for name in names if Path(name).name != name]:
        raise FileDamaged(f"{folder}: {outside[0]!r} must be the name of a file in it")
    return {name: content_digest(folder / name) for name in names}


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
    rows_digest: str  # hash of the rows of these cycles; see `rows.digest`
    last_digest: str  # hash of the file with the spheres at the end; see `runs.last_file`


def check_same(left: Packing | Bed | Run, expected: Packing | Bed | Run, file: Path) -> None:
    """Refuse a folder that was copied or renamed."""
    if left != expected:
        raise FileDamaged(f"{file}: belongs to another {type(expected).__name__.lower()}")


@dataclass(frozen=True)
class Attempt:
    """Outcome of a step."""

    status: str  # `OK`, or the name of a failure of `liggghts.failures`
    message: str
    attempts: int
    liggghts: str  # version
    solver_cpu_s: float  # CPU time of LIGGGHTS [s]


@dataclass(frozen=True)
class PourOutcome(Attempt):
    """Outcome of a packing; ``found`` is None after a failure."""

    packing: Packing
    found: Poured | None
    files: Files


@dataclass(frozen=True)
class LoosenOutcome(Attempt):
    """Outcome of a bed; ``found`` is None after a failure."""

    bed: Bed
    found: Loosened | None
    files: Files


@dataclass(frozen=True)
class ShakeOutcome(Attempt):
    """Outcome of a run; ``found`` is None after a failure."""

    run: Run
    target: RunTarget
    found: Shaken | None
    # Seeds of its case that were run: more than the case has runs where its cells are in several
    # states; 0 where that was not looked for.
    seeds: int = 0

    def check_run(self, run: Run, file: Path) -> None:
        """Refuse a record of another run; a deck may have moved."""
        check_same(replace(self.run, deck=run.deck), run, file)

    @property
    def shaken(self) -> Shaken:
        """Results of the run.

        Raises
        ------
        RunFailed
            If the run ended with a failure.
        """
        if self.found is None:
            raise RunFailed(self.status, self.message)
        return self.found


@dataclass(frozen=True)
class End:
    """End of a run where it met a target."""

    cycles: int  # of the run so far
    # Balance of the cycles that follow; None if the deck cannot list its contacts.
    balance: MeasuredBalance | None
    last_digest: str  # see `Shaken`


@dataclass(frozen=True)
class RunState:
    """Valid contents of a run's folder."""

    run: str  # `Run.identity`; the files of another run are ignored
    spheres: int  # in all cells
    mass: float  # of all spheres [kg]
    # Cycles of each LIGGGHTS process, in ``cycles_1.txt``, ``cycles_2.txt``, …
    legs: tuple[int, ...] = ()
    restart: str = ""  # file from which the run can continue; empty before the first
    ends: tuple[End, ...] = ()  # one for each length at which the run has met a target
    # `window.BALANCE_VERSION` when their balances were measured; those of another are ignored.
    balance_version: int = 0
    rows_digest: str = ""  # hash of all rows; see `rows.digest`
    files: Files = field(default_factory=dict)  # what a leg starts from: spheres, walls, restart

    @property
    def cycles(self) -> int:
        """Cycles of all legs."""
        return sum(self.legs)

    def ended(self, end: End, balance_version: int) -> RunState:
        """Return the state with one more end; ends of another balance version are dropped."""
        ends = self.ends if self.balance_version == balance_version else ()
        earlier = (earlier_end for earlier_end in ends if earlier_end.cycles != end.cycles)
        return replace(self, ends=(*earlier, end), balance_version=balance_version)

    def write(self, folder: Path) -> None:
        """Write ``state.json``."""
        coding.write(folder / "state.json", self)

    @staticmethod
    def read(folder: Path) -> RunState | None:
        """Return the state of a folder; None if it has none.

        Raises
        ------
        RecordUnreadable
            If it is not as it was written, or its restart is not that of its cycles: the name is a
            word in a deck.
        """
        path = folder / "state.json"
        if not path.exists():
            return None
        state = coding.read(RunState, path)
        if state.restart not in ("", restart_file(state.cycles)):
            raise RecordUnreadable(
                f"{path}: restart = {state.restart!r}: must be {restart_file(state.cycles)}"
            )
        return state


def restart_file(cycles: int) -> str:
    """Return the name of the restart that a run leaves after a number of cycles."""
    return f"at_{cycles}.restart"
