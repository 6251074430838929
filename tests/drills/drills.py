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

from world import LONG, PANEL_FILES, ROOT, SHORT, Call, World, flip, lose

VARIANTS = {
    "deck": ("templates/fill.in.j2", "viscous {{ drag }}", "viscous {{ 1.1 * drag }}"),
    "constant": ("src/pidpanel/coupon/packing.py", "restitution: float = 0.5", "restitution: float = 0.4"),
    "solver": ("src/pidpanel/constants.py", 'LIGGGHTS_VERSION = "3.8.0"', 'LIGGGHTS_VERSION = "3.8"'),
    "comment": ("templates/fill.in.j2", "# drag, so that", "# a drag, so that"),
}  # fmt: skip
"""Other versions of pidpanel: a file, what of it is another, and how that ends then."""
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
    """The right table for each number of cycles, variant of pidpanel and change of the panel's."""


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
    for name, (file, before, after) in VARIANTS.items():
        project = folder / f"project_{name}"
        for part in ("src", "workflow", "templates", "profiles"):
            shutil.copytree(ROOT / part, project / part)
        shutil.copy(ROOT / "Snakefile", project)
        _edit(project / file, before, after)
        world = World(folder / f"by_{name}", project=project)
        world.write()
        tables[name] = _undisturbed(world)
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


def stopped(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """LIGGGHTS is stopped (SIGSTOP) for ever, or all processes are stopped and continued."""
    world = stage.prepared.copy(folder)
    process = world.start()
    world.wait_for("liggghts", process)
    time.sleep(rng.uniform(0, 0.3))
    everything = [*world.processes("liggghts"), *world.processes("python", "scripts.")]
    if rng.random() < 0.5:
        for one in everything[:1]:
            _send(one, signal.SIGSTOP)
    else:
        for sig in (signal.SIGSTOP, signal.SIGCONT):
            for one in [process.pid, *everything]:
                _send(one, sig)
            time.sleep(rng.uniform(0.5, 5))
    ended = world.ended(process)
    return Ended(world, world.call() if ended.status is not None else ended)


def orphan(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A job is stopped, Snakemake is killed and called again, and the job continues."""
    world = stage.prepared.copy(folder)
    process = world.start()
    world.wait_for("liggghts", process)
    jobs = world.processes("python", "scripts.shake")
    for one in jobs:
        _send(one, signal.SIGSTOP)
    process.kill()
    process.wait()  # not for the end of its pipe, which the job holds
    process = world.start()
    time.sleep(rng.uniform(0, 5))
    for one in jobs:
        _send(one, signal.SIGCONT)
    last = world.ended(process)
    return Ended(world, last, orphans=bool(world.processes("liggghts")))


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
        one = world.wait_for(victim, process, "scripts." if victim == "python" else "")
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


def power_cut(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The last files of an unfinished or finished run are empty, cut or zero."""
    world = rng.choice([stage.done, *stage.cut]).copy(folder)
    files = world.written()
    for file in files[: rng.randrange(1, 8)]:
        lose(file, rng)
    if rng.random() < 0.3:
        shutil.rmtree(world.folder / ".snakemake", ignore_errors=True)
    return Ended(world, world.call())


KINDS = (
    "*/packing.csv", "*/packing.json", "*/bed.csv", "*/bed.json", "bed/*/walls.stl", "s1/walls.stl",
    "s1/start.data", "s1/cycles_*.txt", "s1/*.restart", "s1/*.dump", "s1/state.json", "s1/*pc_*.json",
    "batch/*.json", "cases.csv", ".made/*.json", ".made/*.record",
)  # fmt: skip
"""Kinds of files that are kept."""


def flipped_bit(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """One bit of a stored file is flipped; the study is called again or continued."""
    world = stage.done.copy(folder)
    kind = rng.choice(KINDS)
    flip(rng.choice(sorted((world.folder / "results").rglob(kind))), rng, rng.random() < 0.7)
    if rng.random() < 0.5:
        shutil.rmtree(world.folder / ".snakemake", ignore_errors=True)
    cycles = rng.choice((SHORT, LONG))
    world.write(cycles)
    return Ended(world, world.call(), cycles)


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
    """``.snakemake`` is lost; the study is changed or unchanged."""
    world = rng.choice([stage.done, *stage.cut]).copy(folder)
    shutil.rmtree(world.folder / ".snakemake")
    cycles = rng.choice((SHORT, LONG))
    world.write(cycles)
    return Ended(world, world.call(), cycles)


def panel_file_damaged(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A file of the surface, the panel, the sound or the response is changed or cut."""
    world = stage.panel.copy(folder)
    places = ("damping", "panel", "sound", "response")
    own = world.folder / "results" / "drill" / rng.choice(places)
    files = sorted(f for f in own.rglob("*") if f.suffix not in (".log", ".lock") and f.is_file())
    file = rng.choice(files)
    if rng.random() < 0.5:
        flip(file, rng, rng.random() < 0.7)
    else:
        lose(file, rng)
    if rng.random() < 0.5:
        shutil.rmtree(world.folder / ".snakemake", ignore_errors=True)
    return Ended(world, world.call(), "panel")


def panel_killed(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A stage of the panel, or Snakemake during it, is killed, and the study is called again."""
    world = stage.panel.copy(folder)
    for stage_left in ("panel", "sound", "response"):
        shutil.rmtree(world.folder / "results" / "drill" / stage_left)
    process = world.start()
    name = rng.choice(("panel", "sound", "response"))
    job = world.wait_for("python", process, f"scripts.{name}")
    time.sleep(rng.uniform(0, 2))
    for one in world.processes("python", f"scripts.{name}") if job is not None else []:
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
    if rng.random() < 0.5:
        shutil.rmtree(world.folder / ".snakemake", ignore_errors=True)
    return Ended(world, world.call(), wanted)


# ------------------------------------------------------------------ history and machine


def other_version(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """Another version of a deck, a constant or LIGGGHTS runs the study, then the first version."""
    world = rng.choice((stage.done, stage.prepared, stage.cut[1])).copy(folder)
    name = rng.choice(sorted(VARIANTS))
    world.project = stage.folder / f"project_{name}"
    ended = world.call()
    (folder / "first.txt").write_text(ended.said)
    if world.table() != stage.tables[name]:
        return Ended(world, ended, name)
    world.project = ROOT
    return Ended(world, world.call())


def other_history(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """A run continues to more cycles, or fewer are needed than it has."""
    begin = stage.done if rng.random() < 0.5 else World(stage.folder / f"to_{LONG}")
    world = begin.copy(folder)
    cycles = LONG if begin is stage.done else SHORT
    world.write(cycles)
    return Ended(world, world.call(), cycles)


def home_unwritable(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The home folder is not writable."""
    world = stage.prepared.copy(folder)
    world.environment["HOME"] = rng.choice(("/proc/nothing", "/nonexistent", "/sys"))
    return Ended(world, world.call())


def other_locale(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """Numbers and letters have another format."""
    world = stage.prepared.copy(folder)
    name = rng.choice(("C", "POSIX", "de_DE.UTF-8", "tr_TR.UTF-8", "ja_JP.eucJP", "nonsense"))
    world.environment |= {"LC_ALL": name, "LANG": name, "LC_NUMERIC": name, "TZ": "Asia/Tokyo"}
    return Ended(world, world.call())


def other_jobs(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """One job runs at a time, or more jobs than cores."""
    world = rng.choice((_fresh(stage, folder / "a"), stage.prepared.copy(folder / "b")))
    return Ended(world, world.call(rng.choice(("-j1", "-j3"))))


def other_folder(stage: Stage, folder: Path, rng: random.Random) -> Ended:
    """The study and its results so far are moved to another folder."""
    name = rng.choice(("a b", "a$(touch hit)b", "ä'ö", "x;y", "{damper}"))
    world = rng.choice([stage.done, stage.prepared, *stage.cut]).copy(folder / name)
    return Ended(world, world.call())


DRILLS: dict[str, Drill] = {
    "LIGGGHTS killed": liggghts_killed,
    "Snakemake interrupted (SIGINT)": _snakemake(signal.SIGINT),
    "Snakemake ended (SIGTERM)": _snakemake(signal.SIGTERM),
    "Snakemake killed (SIGKILL)": _snakemake(signal.SIGKILL),
    "stopped": stopped,
    "orphan beside its successor": orphan,
    "memory short": memory_short,
    "power cut": power_cut,
    "one bit flipped": flipped_bit,
    "disk full": disk_full,
    "`.snakemake` lost": snakemake_files_lost,
    "panel file damaged": panel_file_damaged,
    "panel stage killed": panel_killed,
    "table changed, older date": table_changed,
    "other version": other_version,
    "other history": other_history,
    "`HOME` unwritable": home_unwritable,
    "other locale": other_locale,
    "`-j1`, `-j3`": other_jobs,
    "other folder": other_folder,
}
