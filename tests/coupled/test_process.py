"""Work in a child: its result, its error, its abort, its silence."""

import os
import time

import numpy as np
import pytest

from pidpanel.coupled.process import in_child
from pidpanel.coupon.liggghts.failures import EnergyNotClosed, RunStopped


def test_a_child_returns_what_it_found_and_tells_how_far_it_is():
    # red: `progress(value)` left out of `in_child`
    said = []

    def work(progress):
        progress(0.5)
        return np.arange(3)

    found = in_child(work, "work", silence_s=30, limit_s=30, progress=said.append)
    assert (found.tolist(), said) == ([0, 1, 2], [0.5])


def test_an_abort_is_a_failure_with_the_last_words():
    # as LIGGGHTS does on an error; red: os.dup2 of 2 left out
    def work(progress):
        os.write(1, b"all is well\n")
        os.write(2, b"ERROR: Atom lost (./src/domain.cpp:12)\n")
        os.abort()

    with pytest.raises(RunStopped, match=r"^one: exit status -6: ERROR: Atom lost"):
        in_child(work, "one", silence_s=30, limit_s=30)


def test_a_named_failure_comes_through():
    # red: `except Exception` left out of `_work`
    def work(progress):
        raise EnergyNotClosed("half is missing")

    with pytest.raises(EnergyNotClosed, match="half is missing"):
        in_child(work, "one", silence_s=30, limit_s=30)


@pytest.mark.parametrize(
    ("silence", "limit", "says"), [(0.2, 30, "no word for 0 s"), (30, 0.2, "time limit 0 s")]
)
def test_silence_and_delay_end_a_child(silence, limit, says):
    # red: here.poll(None)
    def work(progress):
        time.sleep(60)

    with pytest.raises(RunStopped, match=says):
        in_child(work, "one", silence_s=silence, limit_s=limit)
