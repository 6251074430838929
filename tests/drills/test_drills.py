"""A few of the drills; `make drills` does all of them, and each of them many times."""

import random
import shutil
import signal
import time
from pathlib import Path

import pytest
from drills import DRILLS, KINDS
from world import World, flip

pytestmark = pytest.mark.liggghts


def test_killed_and_damaged_it_comes_to_the_same_bytes(tmp_path):
    # red: `end_with` left out of job.run (LIGGGHTS stays); `nolock` left out of the profile (the
    # lock stays); `batches.compare_results` asked for outcomes alone (the row stays as it is)
    world = World(tmp_path / "a$(touch hit)b")
    world.write()
    process = world.start()
    assert world.wait_for("liggghts", process) is not None
    process.send_signal(signal.SIGKILL)
    process.communicate()
    while world.processes("liggghts"):
        time.sleep(0.1)
    killed = world.call()
    assert killed.status == 0, killed.said
    table = world.table()
    assert table and not list(tmp_path.rglob("hit"))
    (rows,) = (world.folder / "results").rglob("cycles_1.txt")
    flip(rows, random.Random(1), keep_age=True)
    (world.folder / "results" / "drill" / "coupon" / "cases.csv").write_text("")
    shutil.rmtree(world.folder / ".snakemake")
    healed = world.call()
    assert healed.status == 0, healed.said
    assert f"{rows.parent.relative_to(world.folder)}" in healed.said
    assert "cases.csv: damaged" in healed.said
    assert world.table() == table


def test_every_drill_is_told_in_a_line():
    # red: a drill without a docstring, which the table of the documents shows
    for drill in DRILLS.values():
        assert drill.__doc__.endswith(".") and "\n" not in drill.__doc__
    assert len(KINDS) == len(set(KINDS))
    assert Path(__file__).with_name("__main__.py").is_file()
