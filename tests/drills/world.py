"""A small study in folders of its own, run by Snakemake with real LIGGGHTS, and what to do to it."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")
TABLE = "results/drill/coupon/cases.csv"
PATIENCE = 400
"""Longest time of a call [s]; about five on a free core."""

STUDY = """\
title: "A drill"
coupon:
  cell: {{shape: hexagon, across_flats_mm: 6.35, depth_mm: 8, count: 1}}
  particles: {{diameter_mm: 3, density_kg_m3: 1190, youngs_modulus_mpa: 500, poissons_ratio: 0.35, restitution: 0.8, friction: 0.3}}
  sweep: {{fill_fraction: [0.6], frequency_hz: [60], acceleration_g: [20]}}
  accuracy: {{relative_error: 0.9, seeds: 1, min_cycles: {cycles}, max_cycles: {cycles}, min_time_s: 0, coverage: 1, state_cycles: 0}}
"""
SHORT, LONG = 30, 45
"""Cycles of the study, and where it is to go on."""


@dataclass
class Call:
    """How a call of Snakemake ended."""

    status: int | None
    """None where it did not end in time."""
    said: str


@dataclass
class World:
    """A folder with a study, its results and Snakemake's own files."""

    folder: Path
    environment: dict[str, str] = field(default_factory=dict)

    def write(self, cycles: int = SHORT) -> None:
        """Write the study."""
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "drill.yaml").write_text(STUDY.format(cycles=cycles))

    def start(self, *options: str) -> subprocess.Popen[str]:
        """Start Snakemake in a session of its own, as a shell does."""
        command = [SNAKEMAKE, "-s", ROOT / "Snakefile", *(options or ("-j2",)), TABLE]
        inherited = {k: v for k, v in os.environ.items() if not k.startswith("PIDPANEL_")}
        return subprocess.Popen(
            [*command, "--configfile", "drill.yaml"],
            cwd=self.folder,
            env={**inherited, "OMP_NUM_THREADS": "1", **self.environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            start_new_session=True,
        )

    def ended(self, process: subprocess.Popen[str]) -> Call:
        """Wait for a call; one that does not end is killed."""
        try:
            said, _ = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            said, _ = process.communicate()
            return Call(None, said)
        return Call(process.returncode, said)

    def call(self, *options: str) -> Call:
        """Call Snakemake and wait."""
        return self.ended(self.start(*options))

    def table(self) -> bytes:
        """What is compared; nothing where it is not there."""
        file = self.folder / TABLE
        return file.read_bytes() if file.is_file() else b""

    def copy(self, folder: Path) -> World:
        """Return a world that is the same, ages of files included."""
        shutil.copytree(self.folder, folder, symlinks=True)
        return World(folder, dict(self.environment))

    def files(self) -> list[Path]:
        """Files of the results, the ones written last first."""
        found = [f for f in (self.folder / "results").rglob("*") if f.is_file()]
        return sorted(found, key=lambda file: (-file.stat().st_mtime_ns, str(file)))

    def processes(self, name: str) -> list[int]:
        """Processes of that name which work in the folder."""
        found = []
        for entry in Path("/proc").iterdir():
            if not entry.name.isdecimal():
                continue
            try:
                command = (entry / "comm").read_text().strip()
                there = (entry / "cwd").resolve().is_relative_to(self.folder.resolve())
            except OSError:
                continue
            if command == name and there:
                found.append(int(entry.name))
        return found

    def wait_for(self, name: str, process: subprocess.Popen[str]) -> int | None:
        """Return the first process of that name; None if the call ends before."""
        while process.poll() is None:
            if found := self.processes(name):
                return found[0]
            time.sleep(0.01)
        return None


def flip(file: Path, rng: random.Random, keep_age: bool) -> None:
    """Flip one bit of a file."""
    data, age = bytearray(file.read_bytes()), file.stat()
    if not data:
        return
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    file.write_bytes(bytes(data))
    if keep_age:
        os.utime(file, ns=(age.st_atime_ns, age.st_mtime_ns))


def lose(file: Path, rng: random.Random) -> None:
    """Do to a file what a power cut does to one that was not yet on the disk; its age stays."""
    data, age = file.read_bytes(), file.stat()
    kept = rng.randrange(len(data) + 1)
    file.write_bytes(rng.choice([b"", data[:kept], data[:kept] + bytes(len(data) - kept)]))
    os.utime(file, ns=(age.st_atime_ns, age.st_mtime_ns))
