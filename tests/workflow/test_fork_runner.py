"""`pidpanel run` of a study without LIGGGHTS: what Snakemake would do, without Snakemake."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.commands import jobs, pidpanel, said, snakemake

PIDPANEL = Path(sys.executable).with_name("pidpanel")
AFTER_SOUND = {"sound", "response", "maps", "export", "report"}
NOT_COMPARED = (".made", "benchmark", ".running", ".snakemake_timestamp", "run.log")


@pytest.fixture(scope="module")
def values(law_values):
    """A study of a small panel with few scenarios."""
    values = law_values()
    values["damping"]["readings"] = ["paper_corrected"]
    values["scenarios"] = {"fill": values["scenarios"]["fill"]}
    return values


@pytest.fixture(scope="module")
def forked(tmp_path_factory, values, write_study):
    """A folder in which `pidpanel run` has run, with its study."""
    folder = tmp_path_factory.mktemp("forked")
    study = write_study(folder, "small", values)
    result = pidpanel(folder, "run", study)
    assert result.returncode == 0, said(result)
    assert result.stdout == f"{folder / 'results' / 'small' / 'report.html'}\n"
    assert ran(result) == {"panel"} | AFTER_SOUND
    assert not (folder / ".snakemake").exists()
    return folder


@pytest.fixture(scope="module")
def peer(tmp_path_factory, values, write_study):
    """A folder in which Snakemake has run the same study."""
    folder = tmp_path_factory.mktemp("snakemake")
    result = snakemake(folder, write_study(folder, "small", values))
    assert result.returncode == 0, said(result)
    return folder


def ran(result):
    """Names of the jobs that a forked run tells of."""
    lines = [line for line in result.stderr.splitlines() if " jobs: " in line]
    return {line.split(" jobs: ")[1].split(",")[0] for line in lines}


def contents(folder):
    """Content of each file below a folder of results."""
    files = (file for file in (folder / "results").rglob("*") if file.is_file())
    return {
        str(file.relative_to(folder)): file.read_bytes().replace(bytes(folder), b"folder")
        for file in files
        if not any(part in NOT_COMPARED for part in file.relative_to(folder).parts)
    }


def test_its_files_are_those_of_snakemake(forked, peer):
    ours, theirs = contents(forked), contents(peer)
    assert ours.keys() == theirs.keys() and len(ours) > 30
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_neither_runs_anything_again(forked, peer):
    assert jobs(snakemake(forked, forked / "small.yaml", "-n")) == {}
    for folder in (forked, peer):
        again = pidpanel(folder, "run", "small.yaml")
        assert again.returncode == 0 and ran(again) == set() and "Nothing to be done" in said(again)


def test_a_change_makes_what_snakemake_would_make(forked, values, write_study):
    # red: a request left out of the inputs; rules after a due one not due
    edits = [
        ({"title": "Another"}, {"report"}),
        ({"sound": values["sound"] | {"oaspl_db": 149}}, AFTER_SOUND),
    ]
    for edit, wanted in edits:
        study = write_study(forked, "small", values | edit)
        assert set(jobs(snakemake(forked, study, "-n"))) == wanted
        assert ran(pidpanel(forked, "run", study)) == wanted
    study = write_study(forked, "small", values)
    (forked / "results" / "small" / "response" / "psd.nc").write_text("damaged")
    result = pidpanel(forked, "run", study)
    assert ran(result) == AFTER_SOUND and "psd.nc: damaged" in result.stderr
    assert (forked / "results" / "small" / "response" / "psd.nc.broken").read_text() == "damaged"
    assert jobs(snakemake(forked, study, "-n")) == {}


def test_snakemake_accepts_other_inputs_than_it_noted(peer, values, write_study):
    # red: `rerun-triggers: [mtime, input]`: with the air the set of inputs is another; the
    # benchmark file of before
    changed = values | {"response": values["response"] | {"radiation": "one_side"}}
    study = write_study(peer, "small", changed)
    assert ran(pidpanel(peer, "run", study)) == AFTER_SOUND
    assert jobs(snakemake(peer, study, "-n")) == {}


def test_a_failure_leaves_no_half_of_a_job_and_the_same_command_resumes(
    forked, values, write_study
):
    study = write_study(forked, "small", values | {"title": "Fails"})
    results = forked / "results" / "small"
    size = (results / "report.html").stat().st_size
    limit = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size // 2, size // 2))  # noqa: E731
    result = subprocess.run(
        [PIDPANEL, "run", study], cwd=forked, capture_output=True, text=True, preexec_fn=limit
    )
    assert result.returncode == 1, said(result)
    assert "Error in rule report:" in result.stderr and "File too large" in result.stderr
    assert not (results / "report.html").exists() and not (results / "report").exists()
    assert not list(results.rglob(".new_*"))
    status = pidpanel(forked, "status", study)
    assert "failed: report, results/small/report.log" in status.stdout, said(status)
    assert "File too large" in status.stdout and "response  done" in status.stdout
    write_study(forked, "small", values)
    assert ran(pidpanel(forked, "run", study)) == {"report"}
    assert contents(forked).keys() >= {"results/small/report.html"}


@pytest.mark.parametrize("signal_number", [signal.SIGINT, signal.SIGKILL])
def test_a_stopped_run_ends_its_jobs_and_resumes(tmp_path, values, write_study, signal_number):
    study = write_study(tmp_path, "small", values)
    process = subprocess.Popen(
        [PIDPANEL, "run", study], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    assert "1 of 6 jobs: panel" in process.stderr.readline()
    process.send_signal(signal_number)
    rest = process.stderr.read()
    assert process.wait() == (130 if signal_number == signal.SIGINT else -signal.SIGKILL), rest
    while working_in(tmp_path):  # jobs of a killed run end by themselves
        time.sleep(0.1)
    assert (tmp_path / "results" / "small" / "panel" / "modes.nc").exists()
    again = pidpanel(tmp_path, "run", study)
    assert again.returncode == 0 and "panel" not in ran(again), said(again)
    assert not list(tmp_path.rglob(".new_*"))


def working_in(folder):
    """Processes that work in a folder."""
    places = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            places[process.name] = os.readlink(process / "cwd")
        except OSError:
            continue
    return [process for process, place in places.items() if place == str(folder)]
