"""Requests are new only where a job has to run; files are whole or as they were."""

import json
import os
import subprocess
import sys
import textwrap
import time

import pytest

from pidpanel.provenance import durable, locks, requests

CONTENT = {"study": "a", "highest": [1, 2.5]}


@pytest.fixture()
def job(tmp_path, monkeypatch):
    """A job that has made a file and a folder; its request and its files."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "results" / "maps"
    folder.mkdir(parents=True)
    (folder / "one.vtu").write_text("1")
    (tmp_path / "results" / "maps.nc").write_text("2")
    outputs = ["results/maps.nc", "results/maps"]
    request = requests.request_of(outputs[0])
    requests.ask(request, CONTENT, outputs, is_made=False)
    requests.write_record(request, requests.read_request(request), outputs)
    return request, outputs


def test_what_is_as_it_was_left_is_made_whatever_its_age(job):
    # red: the time stamp of a file among what is compared; the attempt among the content
    request, outputs = job
    os.utime("results/maps.nc", (0, 0))
    assert requests.is_made(request, CONTENT, outputs) == (True, [])


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("maps.nc", lambda file: file.write_text("3")),
        ("maps.nc", lambda file: file.unlink()),
        ("maps/one.vtu", lambda file: file.write_text("")),
        ("maps/one.vtu", lambda file: file.unlink()),
        ("maps/two.vtu", lambda file: file.write_text("new")),
    ],
)
def test_a_damaged_or_lost_file_is_named(job, tmp_path, name, change):
    # red: `now.keys()` alone, or `left.keys()` alone; `rglob` left out
    request, outputs = job
    change(tmp_path / "results" / name)
    made, damaged = requests.is_made(request, CONTENT, outputs)
    assert not made and [str(path) for path in damaged] == [f"results/{name}"]


def test_other_values_name_no_file(job):
    # red: the content left out of the record
    request, outputs = job
    assert requests.is_made(request, {"study": "b"}, outputs) == (False, [])


@pytest.mark.parametrize("text", ["", "{", "[1]", '{"results/maps.nc": "0"}', "\x00" * 40])
def test_after_a_damaged_record_it_is_made_anew(job, text):
    # red: only `OSError` caught
    request, outputs = job
    request.with_suffix(requests.RECORD).write_text(text)
    assert requests.is_made(request, CONTENT, outputs) == (False, [])


def test_a_request_is_older_than_every_result_where_all_is_made_and_new_where_not(job):
    # red: `os.utime` left out; the attempt left out (Snakemake compares checksums)
    request, outputs = job
    requests.ask(request, CONTENT, outputs, is_made=True)
    assert request.stat().st_mtime == requests.LONG_AGO
    assert json.loads(request.read_text()) == CONTENT
    texts = set()
    for _ in range(2):  # damaged twice
        now = time.time()
        os.utime("results/maps.nc", (now, now))
        requests.ask(request, CONTENT, outputs, is_made=False)
        assert request.stat().st_mtime >= now - 1
        texts.add(request.read_text())
        requests.ask(request, CONTENT, outputs, is_made=True)
    assert len(texts) == 2
    assert requests.read_request(request) == CONTENT


def test_a_request_that_waits_stays_as_it_is(job):
    # red: `waiting` left out: whoever looks at a study that runs asks for all of it again
    request, outputs = job
    for output in outputs:
        os.utime(output, (1, 1))
    requests.ask(request, CONTENT, outputs, is_made=False)
    before = request.read_text()
    requests.ask(request, CONTENT, outputs, is_made=False)
    assert request.read_text() == before
    requests.ask(request, {"study": "b"}, outputs, is_made=False)
    assert request.read_text() != before


# ------------------------------------------------------------------ files


def test_a_file_is_whole_or_as_it_was(tmp_path):
    # red: the draft moved into place in `finally`
    file = tmp_path / "a.csv"
    durable.write_text(file, "old")
    with pytest.raises(RuntimeError), durable.replacing(file) as draft:
        draft.write_text("half")
        assert draft.suffix == ".csv"
        raise RuntimeError
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_a_folder_takes_the_place_of_another(tmp_path):
    # red: files that are no more left in it
    folder = tmp_path / "maps"
    for name in ("one", "two"):
        with durable.replacing(folder) as draft:
            draft.mkdir()
            (draft / name).write_text(name)
    assert [file.name for file in folder.iterdir()] == ["two"]


def test_what_is_damaged_is_kept_under_another_name(tmp_path, capsys):
    # red: removed in place of renamed; nothing said
    for number in (1, 2):
        (tmp_path / "a.nc").write_text(f"bad {number}")
        durable.set_aside(tmp_path / "a.nc", "a.nc: damaged")
    assert (tmp_path / "a.nc.broken").read_text() == "bad 2"
    assert capsys.readouterr().err.startswith("a.nc: damaged; kept as a.nc.broken, made anew\n")


# ------------------------------------------------------------------ processes


def child(text, *arguments):
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(text), *map(str, arguments)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


HOLD = """
    import sys
    from pathlib import Path
    from pidpanel.provenance.locks import exclusive_lock
    with exclusive_lock(Path(sys.argv[1])):
        print("held", flush=True)
        sys.stdin.readline()
"""


def test_a_lock_is_waited_for_and_ends_with_its_process(tmp_path):
    # red: LOCK_SH for LOCK_EX; the lock a file that is there or not
    first, lock = child(HOLD, tmp_path / "lock"), tmp_path / "lock"
    assert first.stdout.readline() == "held\n"
    second = child(HOLD, lock)
    assert f"waiting for process {first.pid} on " in second.stderr.readline()
    first.kill()
    first.communicate()
    assert second.stdout.readline() == "held\n"
    second.communicate("\n")


FOLLOW = """
import sys, time
from pidpanel.provenance.locks import end_with
end_with(int(sys.argv[1]))
print("there", flush=True)
time.sleep(600)
"""


def test_what_was_started_for_a_process_ends_with_it():
    # red: the thread not started; only the parent itself among the ancestors
    shell = '"$@" & wait'
    parent = child(
        """
        import os, subprocess, sys
        shell, follow = sys.argv[1:]
        command = [sys.executable, "-c", follow, str(os.getpid())]
        subprocess.run(["sh", "-c", shell, "sh", *command])
        """,
        shell,
        FOLLOW,
    )
    assert parent.stdout.readline() == "there\n"
    parent.kill()
    # to the end of what the follower says too
    assert f"process {parent.pid}, for which this ran, has ended" in parent.stderr.read()


def test_a_process_of_that_number_elsewhere_is_not_watched():
    # red: `_ancestors` not asked
    other = child("import sys; sys.stdin.readline()")
    follower = child(FOLLOW.replace("600", "1"), other.pid)
    assert follower.stdout.readline() == "there\n"
    other.kill()
    other.communicate()
    assert follower.communicate()[1] == ""
    assert follower.returncode == 0


def test_results_are_held_by_one_process_and_as_long_as_it_lives(tmp_path):
    # red: LOCK_SH in place of LOCK_EX; the file closed
    held = locks.hold(tmp_path / "study")
    assert held is not None and locks.hold(tmp_path / "study") is None
    other = locks.hold(tmp_path / "other")
    held.close()
    other.close()
    assert locks.hold(tmp_path / "study") is not None
