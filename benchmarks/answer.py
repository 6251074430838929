"""From a command to its answer beside the physics alone, for studies without LIGGGHTS.

    python benchmarks/answer.py workflow/studies/l_panel.yaml …

`pidpanel check`, `pidpanel run` in an empty folder with one job at a time, and the responses of
the same study through `pidpanel.Model` in a process that has imported all it needs. CPU seconds,
user and system; wall time of the run in brackets.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PIDPANEL = Path(sys.executable).with_name("pidpanel")
ALONE = """
import resource, sys
import pidpanel
import pidpanel.response.from_study, pidpanel.panel.from_study, pidpanel.sound.from_study
def used():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
model, begun = pidpanel.Model(sys.argv[1]), used()
model.response()
print(used() - begun)
"""


def used():
    """CPU seconds of the children of this process that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def clock(command, folder):
    """CPU and wall seconds of a command."""
    begun, since = used(), time.monotonic()
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    return used() - begun, time.monotonic() - since


def main():
    print(f"{'study':14} {'check':>7} {'run':>7} {'wall':>8} {'alone':>7} {'ratio':>6}")
    for study in (Path(name).resolve() for name in sys.argv[1:]):
        with tempfile.TemporaryDirectory() as folder:
            check, _ = clock([PIDPANEL, "check", study], folder)
            run, wall = clock([PIDPANEL, "run", study, "-j1"], folder)
            alone = subprocess.run(
                [sys.executable, "-c", ALONE, study],
                check=True, capture_output=True, text=True, cwd=folder,
            )  # fmt: skip
        physics = float(alone.stdout)
        row = f"{check:7.2f} {run:7.1f} {f'({wall:.0f} s)':>8} {physics:7.1f} {run / physics:6.1f}"
        print(f"{study.stem:14} {row}", flush=True)


if __name__ == "__main__":
    main()
