"""The real LIGGGHTS as a process: how it fails, and what we then say."""

import os
import re
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pidpanel.coupon import preparation
from pidpanel.coupon.liggghts import failures, process
from pidpanel.coupon.liggghts.process import Liggghts
from tests.coupons import small_cases

pytestmark = pytest.mark.liggghts

CYCLES = 3000
"""Far more than it is let run: about a minute if nothing stops it."""


@pytest.fixture
def begun(tmp_path):
    """A run of a few spheres in one cell, its folder with its deck, and the steps of `CYCLES`."""
    run = small_cases(sweep={"fill_fraction": [0.6], "frequency_hz": [100]})[0].point
    spheres = np.array([[0.0, 0.0, height, 2.5e-3] for height in (2e-3, 4.6e-3, 7.2e-3)])
    preparation.write_start(tmp_path / "run", run.packing, spheres)
    (tmp_path / "run" / "deck").write_text(run.deck_text())
    return tmp_path / "run", CYCLES * run.steps_per_cycle


def stop_when_running(folder, steps, sig):
    """Send a signal to LIGGGHTS, or kill its caller, as soon as it has written a cycle."""
    script = (
        "import sys; from pathlib import Path\n"
        "from pidpanel.coupon.liggghts.process import Liggghts\n"
        "folder = Path(sys.argv[1])\n"
        "with Liggghts(folder, 'shake') as p:\n"
        "    print(p._process.pid, flush=True)\n"
        "    p.read_deck((folder / 'deck').read_text())\n"
        "    try:\n        p.run(int(sys.argv[2]))\n"
        "    except Exception as error:\n        print(type(error).__name__, error)\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", script, str(folder), str(steps)], stdout=subprocess.PIPE, text=True
    )
    pid = int(child.stdout.readline())
    while rows_in(folder) == 0:
        assert child.poll() is None, "it ended without a cycle"
        time.sleep(0.05)
    if sig is None:
        child.kill()
        child.wait()
    else:
        os.kill(pid, sig)
    return child, pid


def rows_in(folder):
    file = folder / "cycles_1.txt"
    return max(0, file.read_text().count("\n") - 2) if file.exists() else 0


@pytest.mark.parametrize(("sig", "status"), [(signal.SIGTERM, "0"), (signal.SIGKILL, "-9")])
def test_a_solver_killed_from_outside_is_a_stopped_run(begun, sig, status):
    folder, steps = begun
    child, _ = stop_when_running(folder, steps, sig)
    said, _ = child.communicate()
    # SIGTERM makes LIGGGHTS end its run early and continue as if nothing had happened
    assert "RunStopped" in said or f"exit status {status}" in said, said


def test_the_solver_dies_with_its_caller(begun):
    folder, steps = begun
    _, pid = stop_when_running(folder, steps, None)
    while _state(pid) != "Z":
        time.sleep(0.05)
    assert rows_in(folder) < CYCLES, "LIGGGHTS outlived its caller"


def _state(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return "Z"


def test_the_solver_needs_no_folder_that_others_remove(monkeypatch, tmp_path):
    monkeypatch.setenv("TMPDIR", "/proc/none")  # where nothing can be made
    with Liggghts(tmp_path, "own"):  # has said its version
        pass


def test_an_error_in_a_deck_is_told_in_the_solvers_words(tmp_path):
    with (
        Liggghts(tmp_path, "bad") as solver,
        pytest.raises(failures.RunStopped, match="exit status 1: ERROR: Unknown command"),
    ):
        solver.read_deck("units si\nno_such_command 1")


def test_without_liggghts_the_message_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(process, "COMMAND", "liggghts-that-is-not-there")
    with pytest.raises(failures.SolverMissing, match="apt-get install liggghts"):
        Liggghts(tmp_path, "x")


def test_another_version_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(process, "VERSION", "9.9.9")
    with pytest.raises(failures.SolverMissing, match=r"version 9\.9\.9 is required"):
        Liggghts(tmp_path, "x")


def test_an_instant_says_the_step_the_spheres_and_what_was_asked(begun):
    folder, _ = begun
    with Liggghts(folder, "shake") as solver:
        solver.read_deck(deck_of_speed(folder, 0.25))
        found = solver.run(0, read_energy=True)
        assert solver.instant() == (0, 3, 0.0)
        solver.finish(0, 3)
    mass = 1190 * np.pi / 6 * 2.5e-3**3
    # the log has eight digits
    assert found == (0, 3, pytest.approx(3 * 0.5 * mass * 0.25**2, rel=1e-7))


def deck_of_speed(folder, speed):
    """The deck of a run, its spheres at a speed of our own."""
    text = (folder / "deck").read_text()
    return re.sub(r"velocity all set .*", f"velocity all set 0 0 {speed}", text)


def test_a_log_that_ends_elsewhere_than_it_should_is_refused(begun):
    folder, _ = begun
    with Liggghts(folder, "shake") as solver:
        solver.read_deck((folder / "deck").read_text())
        solver.run(20)
        with pytest.raises(failures.RunStopped, match="last mark at step 20, not 30"):
            solver.finish(30, 3)


@pytest.fixture
def impatient(monkeypatch):
    """() → from now on half a second of silence is enough; the start may take its time."""

    def begin():
        monkeypatch.setattr(process, "QUIET", 0.5)
        monkeypatch.setattr(process, "TICK", 0.1)

    return begin


@pytest.mark.parametrize("ends", [False, True])
def test_a_solver_that_neither_ends_nor_goes_on_is_ended_and_named(begun, impatient, ends):
    folder, _ = begun
    action = "its end" if ends else "'run 20'"
    with Liggghts(folder, "shake") as solver:
        solver.read_deck((folder / "deck").read_text())
        os.kill(solver._process.pid, signal.SIGSTOP)
        impatient()
        with pytest.raises(failures.RunHung, match=f"no output for .* s in {action}; ended"):
            solver.finish(0, 3) if ends else solver.run(20)
        assert solver._process.wait() == -signal.SIGKILL


@pytest.fixture
def endless(tmp_path, monkeypatch):
    """(shell) → a solver that says its version and then does that, for every command."""

    def make(then):
        program = tmp_path / "bin" / "liggghts"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\necho '{process.VERSION}'\n{then}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}:{os.environ['PATH']}")
        return tmp_path

    return make


@pytest.mark.parametrize(
    ("then", "message"),
    [
        ("exec yes", "10000 lines in 'run 20'"),
        # one line without an end, and an input that closes as soon as tr starts
        ("exec tr '\\0' x < /dev/zero", "10000 lines in (its end|'run 20')"),
    ],
)
def test_a_solver_that_prints_for_ever_is_ended_and_takes_no_memory(
    endless, then, message, monkeypatch
):
    monkeypatch.setattr(process, "MOST_LINES", 10_000)
    folder = endless(then)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with Liggghts(folder, "shake") as solver:
        solver._spheres = 3
        time.sleep(0.5)  # what it prints meanwhile stays in the pipe
        assert solver._queue.qsize() <= process.LINES_WAITING
        with pytest.raises(failures.RunHung, match=message):
            solver.run(20)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB


def test_a_solver_that_prints_a_line_now_and_then_in_a_deck_or_at_its_end_is_ended(
    endless, monkeypatch
):
    monkeypatch.setattr(process, "LONGEST_DECK", 0.5)
    monkeypatch.setattr(process, "LONGEST_END", 0.4)
    folder = endless("while :; do echo step; sleep 0.05; done")
    with Liggghts(folder, "deck") as solver:
        with pytest.raises(failures.RunHung, match=r"not done in 0\.5 s"):
            solver.read_deck("run 20")
    with Liggghts(folder, "end") as solver:
        with pytest.raises(failures.RunHung, match=r"not done in 0\.4 s: its end"):
            solver.finish()
