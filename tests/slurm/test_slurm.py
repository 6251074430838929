"""A study through Slurm, with jobs that are cancelled and killed, has the files of a local one.

`make slurm` brings up a Slurm of one node (`one_node.sh`) and runs this alone.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
STUDY = ROOT / "workflow" / "studies" / "smoke.yaml"
FILES = (
    "coupon/cases.csv",
    "damping/surface.nc",
    "panel/modes.nc",
    "sound/modal_force.nc",
    "response/psd.nc",
    "response/summary.csv",
    "report.html",
)
# so short that cases go on in further jobs
SHORT = ["--config", "job_minutes=0.03"]
QUICK = ["--slurm-init-seconds-before-status-checks", "2", "--seconds-between-status-checks", "2"]
# the test's Slurm keeps no accounts
ONE_NODE = ["--slurm-no-account", "--slurm-status-command", "squeue"]
LIMIT = 1800


def why_not():
    """Why there is no Slurm to run on; empty where there is one."""
    if shutil.which("sinfo") is None:
        return "no Slurm here: tests/slurm/one_node.sh up"
    found = subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True)
    states = found.stdout.split()
    if found.returncode or not {"idle", "mixed", "allocated"} & set(states):
        return f"Slurm has no node that is up ({found.stderr.strip() or ' '.join(states)})"
    return ""


pytestmark = [
    pytest.mark.slurm,
    pytest.mark.liggghts,
    pytest.mark.skipif(bool(why_not()), reason=why_not() or "-"),
]


def command(folder, *options):
    return [SNAKEMAKE, "-s", ROOT / "Snakefile", "-d", folder, *options,
            "--configfile", STUDY]  # fmt: skip


def running(rule, without=()):
    """The job of a rule that runs in Slurm and is none of some others; None if there is none."""
    said = subprocess.run(
        ["squeue", "-h", "-t", "R", "-o", "%i %k"], capture_output=True, text=True, check=True
    )
    jobs = (line.split(maxsplit=1) for line in said.stdout.splitlines())
    names = (job for job, *comment in jobs if "".join(comment).startswith(f"rule_{rule}"))
    return next((job for job in names if job not in without), None)


def processes(job):
    """Processes of a job that run our scripts."""
    said = subprocess.run(["scontrol", "listpids", job], capture_output=True, text=True)
    found = []
    for line in said.stdout.splitlines()[1:]:
        pid = line.split()[0]
        try:
            words = Path("/proc", pid, "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if any(b".shake.py" in word for word in words):
            found.append(int(pid))
    return found


def test_a_study_through_slurm_with_jobs_lost_on_the_way_has_the_local_files(tmp_path):
    local, far = tmp_path / "local", tmp_path / "far"
    for folder in (local, far):
        folder.mkdir()
    said = subprocess.run(command(local, "-j2"), capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr

    profile = ["--workflow-profile", ROOT / "profiles" / "slurm"]
    log = tmp_path / "slurm.log"
    with log.open("w") as stream:
        main = subprocess.Popen(
            command(far, *profile, *ONE_NODE, *QUICK, *SHORT), stdout=stream, stderr=stream
        )
        cancelled = killed = None
        end = time.monotonic() + LIMIT
        try:
            while main.poll() is None and time.monotonic() < end:
                time.sleep(0.2)
                if cancelled is None:
                    cancelled = running("shake")
                    if cancelled is not None:
                        subprocess.run(["scancel", cancelled], check=True)
                elif killed is None:
                    job = running("shake", (cancelled,))
                    for pid in [] if job is None else processes(job):
                        os.kill(pid, signal.SIGKILL)
                        killed = job
        finally:
            if main.poll() is None:
                main.terminate()
                main.wait()
    text = log.read_text()
    assert main.returncode == 0, text[-4000:]
    assert cancelled and killed, text[-4000:]
    for name in FILES:
        file = f"results/smoke/{name}"
        assert (far / file).read_bytes() == (local / file).read_bytes(), name
