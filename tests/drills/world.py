"""A small study in folders of its own, run by Snakemake with real LIGGGHTS, and what to do to it."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PIDPANEL = Path(sys.executable).with_name("pidpanel")
TABLE = "results/drill/coupon/cases.csv"
PANEL_FILES = tuple(
    f"results/drill/{name}"
    for name in (
        "response/summary.csv",
        "response/psd.nc",
        "damping/bed/surface.nc",
        "coupon/bed/cases.csv",
    )
)
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

BEDS = """\
dampers:
  lab: {table: damping.csv}
  bed:
    model: tones"""

PANEL = """\
panel:
  outline_m: [1.0, 0.6]
  section: {kind: thin, mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07, thickness_mm: 25}
  supports: simply_supported
  damping_ratio: 0.02
  mesh: {kind: quadrilaterals, elements: [10, 6]}
  patches: {PID-1: {centre_m: [0.5, 0.3], size_m: [0.4, 0.2]}}
  points: {centre: [0.5, 0.3]}
sound: {spectrum: sound.csv, field: diffuse, pressure_reference: surface}
response: {frequency_hz: [40, 250]}
scenarios: {fill: {patch: PID-1, damper: [bed, lab], fill_fraction: 0.6}}
"""
"""What makes it the study of a panel."""
FILES = {
    "damping.csv": "fill_fraction,frequency_hz,acceleration_g,equivalent_damping_n_s_m3,"
    "equivalent_damping_error_n_s_m3\n"
    + "".join(f"{r},{f},{g},{r * f},{0.05 * r * f}\n" for r in (0.3, 0.9) for f in (40, 250) for g in (1, 100)),
    "sound.csv": "# band: 1/3 octave\ncenter_hz,spl_db\n"
    + "".join(f"{f},125\n" for f in (31.5, 40, 50, 63, 80, 100, 125, 160, 200, 250, 315)),
}  # fmt: skip
"""Tables that it names."""


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
    files: tuple[str, ...] = (TABLE,)
    """What is asked for, and compared."""
    made: bool = False
    """Run by `make run`."""

    def write(self, cycles: int = SHORT) -> None:
        """Write the study."""
        self.folder.mkdir(parents=True, exist_ok=True)
        text = STUDY.format(cycles=cycles)
        if self.files != (TABLE,):
            text = text.replace("\n  ", "\n    ").replace("coupon:", BEDS) + PANEL
            for name, content in FILES.items():
                if not (self.folder / name).exists():
                    (self.folder / name).write_text(content)
        (self.folder / "drill.yaml").write_text(text)

    def start(self, *options: str, megabytes: int | None = None) -> subprocess.Popen[str]:
        """Start `pidpanel run` in a session of its own, as a shell does.

        Parameters
        ----------
        options
            ``-j2`` by default.
        megabytes
            To which ``ulimit -v`` limits each process.
        """
        command = [PIDPANEL, "run", "drill.yaml", *(options or ("-j2",)), "--", *self.files]
        if self.made:  # without installing
            command = [
                "make",
                "-s",
                "-o",
                "ready",
                "-f",
                ROOT / "Makefile",
                "run",
                "STUDY=drill.yaml",
            ]
        if megabytes is not None:
            command = ["sh", "-c", f"ulimit -v {1024 * megabytes}; exec " + '"$@"', "sh", *command]
        # compiled code is kept, as `make` keeps it
        left_out = ("PYTHONDONTWRITEBYTECODE", "PYTHONPATH")
        inherited = {
            key: value
            for key, value in os.environ.items()
            if not key.startswith("PIDPANEL_") and key not in left_out
        }
        path = os.pathsep.join((str(PIDPANEL.parent), os.environ["PATH"]))
        return subprocess.Popen(
            command,
            cwd=self.folder,
            env={**inherited, "OMP_NUM_THREADS": "1", "PATH": path, **self.environment},
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

    def call(self, *options: str, megabytes: int | None = None) -> Call:
        """Call Snakemake and wait."""
        return self.ended(self.start(*options, megabytes=megabytes))

    def table(self) -> bytes:
        """What is compared; nothing where a part of it is not there."""
        files = [self.folder / name for name in self.files]
        if not all(file.is_file() for file in files):
            return b""
        return b"".join(file.read_bytes() for file in files)

    def copy(self, folder: Path) -> World:
        """Return a world that is the same, ages of files included."""
        shutil.copytree(self.folder, folder, symlinks=True)
        return World(folder, dict(self.environment), self.files)

    def written(self) -> list[Path]:
        """Files of the results, the ones written last first."""
        found = [f for f in (self.folder / "results").rglob("*") if f.is_file()]
        return sorted(found, key=lambda file: (-file.stat().st_mtime_ns, str(file)))

    def processes(self, name: str, argument: str = "") -> list[int]:
        """Processes of that name which work in the folder, and have such an argument."""
        found = []
        for entry in Path("/proc").iterdir():
            if not entry.name.isdecimal():
                continue
            try:
                command = (entry / "comm").read_text().strip()
                words = (entry / "cmdline").read_bytes().decode("utf-8", "replace").split("\0")
                there = (entry / "cwd").resolve().is_relative_to(self.folder.resolve())
            except OSError:
                continue
            if command == name and there and any(argument in one for one in words):
                found.append(int(entry.name))
        return found

    def wait_for(self, name: str, process: subprocess.Popen[str], argument: str = "") -> int | None:
        """Return the first process of that name; None if the call ends before."""
        while process.poll() is None:
            if found := self.processes(name, argument):
                return found[0]
            time.sleep(0.01)
        return None
