"""Work in a child: its result, its error, its abort, its silence."""

import os
import time

import numpy as np
import pytest

from pidpanel.coupled.pieces import in_child
from pidpanel.coupon.liggghts.failures import EnergyNotClosed, RunStopped


def test_a_child_returns_what_it_found_and_tells_how_far_it_is():
    said = []

    def work(progress):
        progress(0.5)
        return np.arange(3)

    found = in_child(work, "work", silence_s=30, cpu_limit_s=30, progress=said.append)
    assert (found.tolist(), said) == ([0, 1, 2], [0.5])


def test_an_abort_is_a_failure_with_the_last_words():
    # as LIGGGHTS does on an error
    def work(progress):
        os.write(1, b"all is well\n")
        os.write(2, b"ERROR: Atom lost (./src/domain.cpp:12)\n")
        os.abort()

    with pytest.raises(RunStopped, match=r"^one: exit status -6: ERROR: Atom lost"):
        in_child(work, "one", silence_s=30, cpu_limit_s=30)


def test_a_named_failure_comes_through():
    def work(progress):
        raise EnergyNotClosed("half is missing")

    with pytest.raises(EnergyNotClosed, match="half is missing"):
        in_child(work, "one", silence_s=30, cpu_limit_s=30)


def test_silence_ends_a_child():
    def work(progress):
        time.sleep(60)

    with pytest.raises(RunStopped, match=r"^one: no progress for 0 s"):
        in_child(work, "one", silence_s=0.2, cpu_limit_s=30)


@pytest.mark.slow
def test_cpu_time_ends_a_child_and_wall_time_does_not():
    # a second of the one and of the other
    def idle(progress):
        for share in np.linspace(0, 1, 8):
            time.sleep(0.2)
            progress(share)
        return "done"

    def busy(progress):
        while time.process_time() < 20:
            progress(0.5)

    assert in_child(idle, "idle", silence_s=30, cpu_limit_s=1) == "done"
    with pytest.raises(RunStopped, match=r"^busy: more than 1 s of CPU time"):
        in_child(busy, "busy", silence_s=30, cpu_limit_s=1)
