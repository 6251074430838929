"""`pidpanel` and Snakemake as a user starts them, in forks of a process that has imported what they
need: of the 2 CPU-seconds of a dry run, 1.5 are imports.

A fork imports pidpanel itself, from the PYTHONPATH of the call.
"""

import functools
import gc
import importlib
import itertools
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SNAKEFILE = Path(__file__).parents[1] / "Snakefile"
IMPORTED = (
    "jinja2.meta", "matplotlib.figure", "pandas", "pydantic", "scipy.interpolate",
    "scipy.optimize", "scipy.sparse.linalg", "shapely", "skfem", "smart_open", "snakemake.report",
    "xarray",
)  # fmt: skip


# a Slurm of this machine that is down holds each start of Snakemake for ten seconds
NO_SLURM = {"SLURM_CONF": os.devnull}


def pidpanel(folder, *arguments):
    """Call the command line in a folder."""
    return _call("pidpanel", folder, arguments, {})


def snakemake(folder, study, *options):
    """Run Snakemake on a study in a folder."""
    return call("-s", SNAKEFILE, "-d", folder, "--configfile", study, "-j2", *options)


def call(*arguments, **environment):
    """Run Snakemake with arguments, and further variables of the environment."""
    return _call("snakemake", os.getcwd(), arguments, environment)


def said(result):
    return result.stdout + result.stderr


def jobs(result):
    """Number of jobs by rule, from the table of a dry run; empty where nothing is to be done."""
    assert result.returncode == 0, said(result)
    if "Job stats" not in said(result):
        return {}
    lines = said(result).split("Job stats:")[1].splitlines()[3:]
    rows = (line.split() for line in itertools.takewhile(str.strip, lines))
    return {row[0]: int(row[1]) for row in rows if row[0] not in ("all", "total")}


def _call(program, folder, arguments, environment):
    with tempfile.TemporaryDirectory() as name:
        files = [Path(name, stream) for stream in ("stdout", "stderr")]
        order = {
            "arguments": [program, *map(str, arguments)],
            "environment": os.environ | NO_SLURM | environment,
            "folder": str(folder),
            "files": [os.devnull, *map(str, files)],
        }
        server = _server()
        server.stdin.write(json.dumps(order) + "\n")
        server.stdin.flush()
        status = int(server.stdout.readline())
        output = [file.read_text() for file in files]
    return subprocess.CompletedProcess(order["arguments"], status, *output)


@functools.cache
def _server():
    """The process that each call forks."""
    pipe, environment = subprocess.PIPE, os.environ | NO_SLURM
    command = [sys.executable, "-P", __file__]
    return subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe, text=True)


def _serve():
    from snakemake.cli import get_argument_parser

    for name in IMPORTED:
        importlib.import_module(name)
    get_argument_parser()  # imports the plugins
    gc.freeze()  # no fork looks through what was imported: half of its time
    for line in sys.stdin:
        order = json.loads(line)
        child = os.fork()
        if not child:
            _become(order)
            program = importlib.import_module(f"{sys.argv[0]}.cli")
            sys.exit(program.main())
        _, status = os.waitpid(child, 0)
        print(os.waitstatus_to_exitcode(status), flush=True)


def _become(order):
    """Take the streams, folder, environment and arguments of a command."""
    for number, file in enumerate(order["files"]):
        os.dup2(os.open(file, os.O_RDWR | os.O_CREAT), number)
    os.chdir(order["folder"])
    os.environ.clear()
    os.environ.update(order["environment"])
    sys.argv[:] = order["arguments"]
    sys.path[:0] = filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))
    for name in [name for name in sys.modules if name.partition(".")[0] == "pidpanel"]:
        del sys.modules[name]


if __name__ == "__main__":
    _serve()
