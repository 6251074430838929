"""What users of Snakemake type, on one small study without LIGGGHTS."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from base64 import urlsafe_b64encode
from pathlib import Path

import pandas as pd
import pytest

from tests.commands import call, jobs, pidpanel, said
from tests.commands import snakemake as snakemake_on
from tests.workflow.test_workflow import ROOT

AFTER_RESPONSE = {"response", "maps", "export", "severity", "margins", "measurement", "report"}
ALL = {"panel", "sound", *AFTER_RESPONSE}
SUMMARY = "results/small/response/summary.csv"


@pytest.fixture(scope="module")
def made(tmp_path_factory, write_study, table_values):
    """Folder in which Snakemake has run the study to its page."""
    folder = tmp_path_factory.mktemp("small")
    write_study(folder, "small", table_values())
    result = snakemake(folder, "--cores", "all")
    assert result.returncode == 0, said(result)
    return folder


@pytest.fixture
def copied(made, tmp_path):
    """A copy of that folder that a test may change."""
    return shutil.copytree(made, tmp_path / "copy", symlinks=True)


def snakemake(folder, *options):
    return snakemake_on(folder, folder / "small.yaml", *options)


def files(folder):
    return {p: p.stat().st_mtime_ns for p in Path(folder, "results").rglob("*") if p.is_file()}


def changed(folder, old, new):
    """Change the text of the study."""
    path = folder / "small.yaml"
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


# ------------------------------------------------------------------ what runs when


def test_a_second_run_has_nothing_to_do_and_a_dry_run_writes_nothing(made):
    before = files(made)
    assert jobs(snakemake(made, "-n")) == {}
    # of params Snakemake 9.27 lists one file of each job whether or not they have changed
    assert "results/small" not in said(snakemake(made, "--list-changes", "input"))
    assert snakemake(made, "--list-changes", "params").returncode == 0
    assert "Nothing to be done" in said(snakemake(made))
    assert files(made) == before


def test_a_dry_run_of_an_empty_folder_leaves_no_results(tmp_path, write_study, table_values):
    values = table_values()
    values["uncertain"] = {"panel.damping_ratio": {"normal": [0.018, 0.022], "source": "a"}}
    values["update"] = {
        "modal_survey": {"damping_ratio": {1: 0.01}, "damping_ratio_error": 0.1},
    }
    write_study(tmp_path, "small", values)
    assert set(jobs(snakemake(tmp_path, "-n"))) == ALL | {"margin"}
    assert not (tmp_path / "results").exists()


def test_commands_know_what_is_left_and_make_it(copied):
    shutil.rmtree(copied / "results" / "small" / "response" / "export")
    left = pidpanel(copied, "status", "small.yaml")
    assert left.returncode == 1 and "small: not complete" in said(left)
    assert pidpanel(copied, "export", "small.yaml").returncode == 0
    assert (copied / "results" / "small" / "response" / "export" / "psd.uff").is_file()


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("damping_ratio: 0.02", "damping_ratio: 0.03", ALL - {"sound"} | {"sound"}),
        ("oaspl_db: 150\n  field", "oaspl_db: 151\n  field", ALL - {"panel"}),
        ("title: A small panel", "title: The small panel", {"report"}),
        ("exponent: 6", "exponent: 7", {"severity", "report"}),
        ("rms_g: 20", "rms_g: 19", {"margins", "report"}),
    ],
)
def test_a_change_of_the_study_runs_what_depends_on_it_whatever_the_dates(copied, old, new, wanted):
    # results of another machine whose clock is ahead
    for path in files(copied):
        os.utime(path, (4e9, 4e9))
    changed(copied, old, new)
    assert set(jobs(snakemake(copied, "-n"))) == wanted


def test_a_changed_table_runs_what_reads_it(copied):
    table = copied / "lab.csv"
    age = table.stat()
    table.write_text(table.read_text().replace("0.3,40,3,", "0.3,41,3,", 1))
    os.utime(table, (age.st_atime, age.st_mtime))
    assert AFTER_RESPONSE <= set(jobs(snakemake(copied, "-n")))


def test_another_version_of_the_package_runs_all_again(copied, monkeypatch):
    records = [p for p in (copied / ".snakemake" / "metadata").rglob("*") if p.is_file()]
    for path in records:
        path.write_text(path.read_text().replace("'0.1.0+", "'0.0.9+"))
    assert set(jobs(snakemake(copied, "-n"))) == ALL


def test_values_of_the_command_line_take_the_place_of_those_of_the_study(copied):
    plain = pd.read_csv(copied / SUMMARY)
    options = ["--config", "panel={damping_ratio: 0.04}"]
    result = snakemake(copied, SUMMARY, *options)
    assert result.returncode == 0, said(result)
    damped = pd.read_csv(copied / SUMMARY)
    bare = plain["scenario"].str.startswith("bare")
    assert (damped[bare]["acceleration_rms_g"] < 0.9 * plain[bare]["acceleration_rms_g"]).all()
    assert jobs(snakemake(copied, "-n", SUMMARY, *options)) == {}
    assert "response" in jobs(snakemake(copied, "-n", SUMMARY))


def test_a_further_configfile_takes_the_place_of_values(made, tmp_path):
    further = tmp_path / "small.yaml"
    further.write_text("response: {frequency_hz: [40, 140]}\n")
    files_of = made / "small.yaml", further
    options = ["-s", ROOT / "Snakefile", "-d", made, "-n", "-j1", "--configfile", *files_of]
    assert AFTER_RESPONSE <= set(jobs(call(*options)))


# ------------------------------------------------------------------ commands of Snakemake


def test_graphs_and_summaries_name_every_rule(made):
    for option in ("--rulegraph", "--dag"):
        graph = said(snakemake(made, option))
        assert all(f'"{name}' in graph for name in ALL)
    rows = snakemake(made, "--summary").stdout.splitlines()
    plans = [line.split("\t")[-1] for line in rows if line.startswith("results/")]
    assert len(plans) > 20 and set(plans) == {"no update"}


def test_parts_of_the_study_are_chosen(made):
    assert set(jobs(snakemake(made, "-n", "-R", "response"))) == AFTER_RESPONSE
    assert set(jobs(snakemake(made, "-n", "--forceall"))) == ALL
    assert set(jobs(snakemake(made, "-n", "--forceall", "--until", "sound"))) == {"panel", "sound"}


def test_touched_results_are_up_to_date(copied):
    changed(copied, "title: A small panel", "title: The small panel")
    assert snakemake(copied, "--touch").returncode == 0
    assert jobs(snakemake(copied, "-n")) == {}


def test_lost_records_of_snakemake_leave_time_stamps(copied):
    shutil.rmtree(copied / ".snakemake")
    assert jobs(snakemake(copied, "-n")) == {}
    (copied / "results" / "small" / "panel" / "modes.nc").touch()
    assert AFTER_RESPONSE <= set(jobs(snakemake(copied, "-n")))


def test_what_a_killed_job_left_is_made_again(copied):
    name = urlsafe_b64encode(b"results/small/sound/spectrum.csv").decode()
    (copied / ".snakemake" / "incomplete" / name).write_text('{"external_jobid": null}')
    assert "sound" in jobs(snakemake(copied, "-n"))


def test_a_failed_stage_is_one_line_and_leaves_no_result(copied):
    (copied / "results" / "small" / "panel" / "modes.nc").write_bytes(b"no NetCDF")
    result = snakemake(copied, "--keep-going", "-R", "sound")
    assert result.returncode != 0
    assert "Error in rule sound" in said(result)
    assert not (copied / "results" / "small" / "sound" / "spectrum.csv").exists()


def test_the_report_of_snakemake_has_the_page(made, tmp_path):
    result = snakemake(made, "--report", tmp_path / "report.zip")
    assert result.returncode == 0, said(result)
    with zipfile.ZipFile(tmp_path / "report.zip") as archive:
        assert any("report.html" in name for name in archive.namelist())


def test_all_results_are_deleted(copied):
    assert snakemake(copied, "--delete-all-output").returncode == 0
    left = [p.name for p in files(copied) if p.suffix not in (".log", ".tsv")]
    assert not left


def test_the_study_is_archived_without_what_was_computed(made, tmp_path):
    result = snakemake(made, "--archive", tmp_path / "all.tar.gz")
    assert result.returncode == 0, said(result)
    with tarfile.open(tmp_path / "all.tar.gz") as archive:
        names = archive.getnames()
    assert "small.yaml" in names and not [name for name in names if "results" in name]


def test_lint_finds_nothing(made):
    assert "Congratulations" in said(snakemake(made, "--lint"))


@pytest.mark.parametrize(
    "options",
    [
        ("--software-deployment-method", "apptainer"),
        ("--workflow-profile", ROOT / "profiles" / "slurm", "-j1"),
    ],
    ids=["apptainer", "slurm"],
)
def test_a_cluster_and_a_container_plan_the_same_jobs(tmp_path, write_study, table_values, options):
    # Snakemake asks for the version of apptainer, and a dry run for nothing else
    apptainer = tmp_path / "bin" / "apptainer"
    apptainer.parent.mkdir()
    apptainer.write_text("#!/bin/sh\necho apptainer version 1.3.0\n")
    apptainer.chmod(0o755)
    path = f"{apptainer.parent}:{os.environ['PATH']}"
    study = write_study(tmp_path, "small", table_values())
    places = ["-s", ROOT / "Snakefile", "-d", tmp_path, "--configfile", study, "-j2", "-n"]
    assert set(jobs(call(*places, *options, PATH=path))) == ALL


# ------------------------------------------------------------------ pidpanel run


def test_one_process_leaves_the_same_files_and_snakemake_makes_them_again(made, tmp_path):
    for name in ("small.yaml", "lab.csv", "limit.csv", "test.csv"):
        shutil.copy(made / name, tmp_path)
    result = pidpanel(tmp_path, "run", "small.yaml")
    assert result.returncode == 0, said(result)
    names = {str(p.relative_to(tmp_path)) for p in files(tmp_path)}
    wanted = {str(p.relative_to(made)) for p in files(made)}
    own = {"results/small/run.log", "results/small/.in_process.json"}
    theirs = {name for name in wanted if name.endswith((".log", ".tsv")) or ".snakemake" in name}
    assert names - own == wanted - theirs
    for name in sorted(names & wanted):
        if name.endswith((".csv", ".nc")):
            assert (tmp_path / name).read_bytes() == (made / name).read_bytes(), name
    assert "Nothing to be done" in said(pidpanel(tmp_path, "run", "small.yaml"))
    assert pidpanel(tmp_path, "status", "small.yaml").stdout.startswith("small: complete")
    assert set(jobs(snakemake(tmp_path, "-n"))) == ALL
    changed(tmp_path, "damping_ratio: 0.02", "damping_ratio: 0.04")
    before = (tmp_path / SUMMARY).read_bytes()
    assert pidpanel(tmp_path, "run", "small.yaml").returncode == 0
    assert (tmp_path / SUMMARY).read_bytes() != before


def test_a_killed_process_leaves_no_page_of_before(copied):
    (copied / "limit.csv").write_text("frequency_hz,acceleration_psd_g2_hz\n40,0.5\n150,0.5\n")
    code = (
        "import os, signal, sys; from pidpanel.workflow import in_process\n"
        "in_process.map_in_forks = lambda *given: os.kill(os.getpid(), signal.SIGKILL)\n"
        "from pidpanel.cli import main; main(['run', 'small.yaml'])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=copied, check=False)
    assert done.returncode != 0
    assert not (copied / "results" / "small" / "report.html").exists()
    assert pidpanel(copied, "run", "small.yaml").returncode == 0
