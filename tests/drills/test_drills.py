"""A few of the drills; `make drills` does all of them, and each of them many times."""

import os
import signal
import time

import pytest
from world import World

pytestmark = pytest.mark.liggghts


def test_killed_it_comes_to_the_same_bytes(tmp_path):
    world = World(tmp_path / "a$(touch hit)b", made=True)
    world.write()
    process = world.start()
    assert world.wait_for("liggghts", process) is not None
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    while world.processes("liggghts"):
        time.sleep(0.1)
    killed = world.call()
    assert killed.status == 0, killed.said
    assert "unlocked" in killed.said
    table = world.table()
    assert table and not list(tmp_path.rglob("hit"))
    whole = World(tmp_path / "whole")
    whole.write()
    assert whole.call().status == 0
    assert whole.table() == table
