"""Do the drills, and write the table of the documents: ``python tests/drills --repeats 20``."""

from __future__ import annotations

import argparse
import itertools
import json
import random
import resource
import shutil
import sys
import tempfile
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from drills import DRILLS, Ended, Stage, make_stage
from world import ROOT

ENDS = ("lost", "silent", "stuck", "identical")
TABLE = ROOT / "benchmarks" / "drills.md"
HEAD = """\
# Drills

Each drill injects a failure into a small study with real LIGGGHTS at a random moment. The study is then called again with the same command. `make drills` repeats each drill 20 times, or `REPEATS=…` times, and writes this page.

The study is one coupon case of one cell and one packing: poured, loosened, shaken for 30 or 45 cycles, and evaluated in `cases.csv`. The drills of panels add a small panel, up to `surface.nc`, `psd.nc` and `summary.csv`. These files are compared byte by byte with those of an undisturbed run from the start.

- **lost**: the call succeeds, and the table is missing;
- **silent**: the call succeeds, and the table differs;
- **stuck**: the call fails or does not end, LIGGGHTS keeps running, or a file stays broken;
- **identical**: the bytes are the same.

| drill | failure | repeats | lost | silent | stuck | identical |
|---|---|---|---|---|---|---|
"""


def ended_as(ended: Ended, stage: Stage) -> str:
    """Return how a drill ended: one of `ENDS`."""
    if ended.last.status != 0 or ended.orphans or ended.tracebacks:
        return "stuck"
    table = ended.world.table()
    if not table:
        return "lost"
    return "identical" if table == stage.tables.get(ended.wanted) else "silent"


def main() -> int:
    """Do what the command line says; return 1 if a drill did not end identical."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--only", nargs="*", default=list(DRILLS), metavar="drill")
    parser.add_argument("--first", type=int, default=0, help="number of the first repeat")
    parser.add_argument("--jobs", type=int, default=2, help="drills at a time")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--counts", type=Path, help="JSON file to which the counts are added")
    parser.add_argument("--write", action="store_true", help=f"write {TABLE.name}")
    given = parser.parse_args()
    counts = {name: Counter() for name in DRILLS}
    if given.counts and given.counts.exists():
        counts |= {k: Counter(v) for k, v in json.loads(given.counts.read_text()).items()}
    with tempfile.TemporaryDirectory(prefix="drills_") as name:
        stage = make_stage(Path(name))
        lock = threading.Lock()

        def do(number: int, drill: str) -> None:
            folder = Path(name) / f"{number}_{list(DRILLS).index(drill)}"
            rng = random.Random(f"{given.seed} {number} {drill}")
            ended = DRILLS[drill](stage, folder, rng)
            end = ended_as(ended, stage)
            with lock:
                counts[drill][end] += 1
                print(f"{drill}, {number + 1}: {end}", flush=True)
                if end != "identical":
                    kept = Path(tempfile.mkdtemp(prefix="drill_failed_")) / "world"
                    shutil.copytree(ended.world.folder, kept)
                    (kept.parent / "said.txt").write_text(ended.last.said)
                    print(f"  kept in {kept}", flush=True)
                if given.counts:
                    given.counts.write_text(json.dumps(counts, indent=1) + "\n")
            shutil.rmtree(folder)

        todo = itertools.product(range(given.first, given.first + given.repeats), given.only)
        with ThreadPoolExecutor(given.jobs) as pool:
            for one in [pool.submit(do, *each) for each in todo]:
                one.result()
    if given.write:
        rows = (
            f"| {drill} | {DRILLS[drill].__doc__.splitlines()[0]} | {sum(found.values())} | "
            + " | ".join(str(found[end]) for end in ENDS)
            + " |\n"
            for drill, found in counts.items()
        )
        TABLE.write_text(HEAD + "".join(rows), encoding="utf-8")
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{(used.ru_utime + used.ru_stime) / 60:.1f} CPU-minutes")
    return int(any(found[end] for found in counts.values() for end in ENDS[:-1]))


if __name__ == "__main__":
    sys.exit(main())
