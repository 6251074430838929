"""What can go wrong, done to a small study at random moments; afterwards it is called again."""

from __future__ import annotations

import contextlib
import os
import random
import resource
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from world import LONG, PANEL_FILES, SHORT, Call, World

TABLES = {"table changed": ("damping.csv", "0.9,250,100,225.0,", "0.9,250,100,325.0,"),
          "spectrum changed": ("sound.csv", "100,125", "100,135")}  # fmt: skip
"""Changes of the tables of the study of a panel."""


@dataclass
class Stage:
    """What every drill begins from."""

    folder: Path
    done: World
    """Finished."""
    prepared: World
    """With packing and bed, and nothing shaken."""
    cut: list[World]
    """Killed on their way."""
    panel: World
    """The study of a panel, finished."""
    tables: dict[int | str, bytes]
    """The right table for each number of cycles and change of the panel's."""


@dataclass
class Ended:
    """How a drill left its world."""

    world: World
    last: Call
    wanted: int | str = SHORT
    """Which of `Stage.tables` is right."""
    orphans: bool = False
    tracebacks: bool = False
    """Whether a failed call said more than what failed."""


Drill = Callable[[Stage, Path, random.Random], Ended]


def make_stage(folder: Path) -> Stage:
    """Run the study undisturbed, to both lengths, each from nothing."""
    tables: dict[int | str, bytes] = {}
    for cycles in (SHORT, LONG):
        world = World(folder / f"to_{cycles}")
        world.write(cycles)
        tables[cycles] = _undisturbed(world)
    done = World(folder / f"to_{SHORT}")
    panel = World(folder / "panel", files=PANEL_FILES)
    panel.write()
    tables["panel"] = _undisturbed(panel)
    for name, edit in TABLES.items():
        world = World(folder / name, files=PANEL_FILES[:2])
        world.write()
        _edit(world.folder / edit[0], *edit[1:])
        tables[name] = _undisturbed(world)
    prepared = done.copy(folder / "prepared")
    for path in (prepared.folder / "results/coupon").iterdir():
        if path.is_dir() and path.name not in ("packing", "bed"):
            shutil.rmtree(path)
    shutil.rmtree(prepared.folder / "results/drill")
    cut = []
    for number, wait in enumerate((0.1, 0.6, 1.5)):
        world = prepared.copy(folder / f"cut_{number}") if number else World(folder / "cut_0")
        world.write()
        process = world.start()
        world.wait_for("liggghts", process)
        time.sleep(wait)
        _kill(process, signal.SIGKILL)
        cut.append(world)
    return Stage(folder, done, prepared, cut, panel, tables)


def _undisturbed(world: World) -> bytes:
    """Run a study from nothing, and return its table."""
    ended = world.call()
    if ended.status != 0 or not world.table():
        raise SystemExit(f"the undisturbed study fails:\n{ended.said}")
    return world.table()


def _edit(file: Path, before: str, after: str) -> None:
    text = file.read_text()
    if text.count(before) != 1:
        raise SystemExit(f"{file}: {before!r} is not there once")
    file.write_text(text.replace(before, after))


def _kill(process: subprocess.Popen[str], sig: signal.Signals) -> None:
    process.send_signal(sig)
    process.communicate()


def _fresh(stage: Stage, folder: Path, cycles: int = SHORT) -> World:
    world = World(folder)
    world.write(cycles)
    return world


# ------------------------------------------------------------------ processes


def liggghts_killed(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """LIGGGHTS is killed once or twice, and the study is called again."""
    world = stage.prepared.copy(folder)
    process = world.start()
    for _ in range(rng.choice((1, 2))):
        solver = world.wait_for("liggghts", process)
        time.sleep(rng.uniform(0, 0.7))
        if solver is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(solver, rng.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGSEGV)))
            while world.processes("liggghts") == [solver]:
                time.sleep(0.01)
    world.ended(process)
    return Ended(world, world.call())


def _snakemake(sig: signal.Signals) -> Drill:
    def drill(stage: Stage, folder: Path, rng: random.Random) -> Ended:
        begin = rng.choice((None, stage.prepared))
        world = _fresh(stage, folder) if begin is None else begin.copy(folder)
        process = world.start()
        if rng.random() < 0.7:
            world.wait_for("liggghts", process)
            time.sleep(rng.uniform(0, 1.5))
        else:
            time.sleep(rng.uniform(0, 8))
        _kill(process, sig)
        end = time.monotonic() + 20
        while world.processes("liggghts") and time.monotonic() < end:
            time.sleep(0.1)
        orphans = bool(world.processes("liggghts"))
        return Ended(world, world.call(), orphans=orphans)

    drill.__doc__ = f"Snakemake gets {sig.name}, and the study is called again."
    return drill


def _send(process: int, sig: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, sig)


def memory_short(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """Memory is limited (`ulimit -v`) for all, a job or LIGGGHTS; then the limit is lifted."""
    world = _fresh(stage, folder) if rng.random() < 0.5 else stage.prepared.copy(folder)
    victim = rng.choice(("all", "python", "liggghts"))
    if victim == "all":
        first = world.call(megabytes=rng.randrange(120, 1500))
    else:
        process = world.start()
        one = world.wait_for(victim, process, ".snakemake/scripts/" if victim == "python" else "")
        time.sleep(rng.uniform(0, 0.4))
        more = rng.choice((0, 1_000_000, 20_000_000))
        with contextlib.suppress(OSError, TypeError, IndexError):
            pages = int(Path(f"/proc/{one}/statm").read_text().split()[0])
            limit = pages * resource.getpagesize() + more
            resource.prlimit(one, resource.RLIMIT_AS, (limit, resource.RLIM_INFINITY))
        first = world.ended(process)
    (folder / "first.txt").write_text(first.said)
    return Ended(world, world.call(), tracebacks="Traceback" in first.said)


# ------------------------------------------------------------------ files


# ------------------------------------------------------------------ files and machine


def disk_full(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The disk fills up at a random size; space is freed, and the study is called again."""
    with _small_disk(folder, rng) as grow:
        begin = rng.choice((None, stage.prepared))
        world = World(folder / "disk" / "study")
        if begin is not None:
            with contextlib.suppress(shutil.Error, OSError):
                shutil.copytree(begin.folder, world.folder)
        with contextlib.suppress(OSError):
            world.write()
        first = world.call()
        grow()
        world.write()
        last = world.call()
        kept = World(folder / "kept")
        shutil.copytree(world.folder, kept.folder)
    (kept.folder / "first.txt").write_text(first.said)
    return Ended(kept, last, tracebacks="Traceback" in first.said)


@contextlib.contextmanager
def _small_disk(folder: Path, rng: random.Random) -> Iterator[Callable[[], None]]:
    """A disk of its own in the folder ``disk``, and how it becomes a larger one."""
    disk = folder / "disk"
    disk.mkdir(parents=True)
    size = rng.randrange(60, 900)
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}k", "drill", disk], check=True)
    try:
        yield lambda: subprocess.run(["mount", "-o", "remount,size=64m", disk], check=True) and None
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


def snakemake_files_lost(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """``.snakemake`` is lost; the same study is called again."""
    world = rng.choice([stage.done, *stage.cut]).copy(folder)
    shutil.rmtree(world.folder / ".snakemake")
    return Ended(world, world.call())


def panel_killed(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A stage of the panel, or Snakemake during it, is killed, and the study is called again."""
    world = stage.panel.copy(folder)
    for stage_left in ("panel", "sound", "response"):
        shutil.rmtree(world.folder / "results" / "drill" / stage_left)
    process = world.start()
    name = rng.choice(("panel", "sound", "response"))
    job = world.wait_for("python", process, f".{name}.py")
    time.sleep(rng.uniform(0, 2))
    for one in world.processes("python", f".{name}.py") if job is not None else []:
        _send(one, signal.SIGKILL)
        if rng.random() < 0.5:
            process.send_signal(rng.choice((signal.SIGKILL, signal.SIGTERM, signal.SIGINT)))
    world.ended(process)
    return Ended(world, world.call(), "panel")


def table_changed(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A CSV file of the study has new content and an older date."""
    world = stage.panel.copy(folder)
    wanted = rng.choice(sorted(TABLES))
    name, before, after = TABLES[wanted]
    _edit(world.folder / name, before, after)
    world.files = PANEL_FILES[:2]  # the surface rests on neither, and tells which study made it
    age = rng.choice((0, 10**9))
    os.utime(world.folder / name, (age, age))
    return Ended(world, world.call(), wanted)


def other_folder(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The study and its results so far are moved to another folder."""
    name = rng.choice(("a b", "a$(touch hit)b", "ä'ö", "x;y", "{damper}"))
    world = rng.choice([stage.done, stage.prepared, *stage.cut]).copy(folder / name)
    return Ended(world, world.call())


def two_at_once(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The study is called while another call runs it, and again when that has ended."""
    world = stage.prepared.copy(folder)
    process = world.start()
    world.wait_for("liggghts", process)
    time.sleep(rng.uniform(0, 1))
    second = world.call()
    first = world.ended(process)
    if first.status != 0:
        return Ended(world, first)
    if second.status == 0 or "lock" in second.said.lower():
        return Ended(world, world.call())
    return Ended(world, second)


def other_clock(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """All results are of the far future or past, and the study has another length or not."""
    world = rng.choice([stage.done, stage.prepared, *stage.cut]).copy(folder)
    age = rng.choice((10**9, 4 * 10**9))
    for file in world.written():
        os.utime(file, (age, age))
    cycles = rng.choice((SHORT, LONG))
    world.write(cycles)
    return Ended(world, world.call(), cycles)


DRILLS: dict[str, Drill] = {
    "LIGGGHTS killed": liggghts_killed,
    "Snakemake interrupted (SIGINT)": _snakemake(signal.SIGINT),
    "Snakemake ended (SIGTERM)": _snakemake(signal.SIGTERM),
    "Snakemake killed (SIGKILL)": _snakemake(signal.SIGKILL),
    "memory short": memory_short,
    "disk full": disk_full,
    "`.snakemake` lost": snakemake_files_lost,
    "panel stage killed": panel_killed,
    "table changed, older date": table_changed,
    "two at once": two_at_once,
    "clock": other_clock,
    "other folder": other_folder,
}
