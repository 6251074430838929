"""LIGGGHTS as a process of one rank that receives commands step by step.

The methods of `Liggghts` are in the words of the coupon. Commands of LIGGGHTS occur only here and
in the templates. They go through the standard input, so a run can be prolonged without a restart,
and are kept in a file that ``liggghts -in`` runs again to the same bits. If the caller dies,
LIGGGHTS is killed with it. If LIGGGHTS is silent far longer than its commands take, or prints on
and on, the caller kills it: it can hang for ever, for example in a damaged restart.
"""

from __future__ import annotations

import contextlib
import math
import os
import queue
import re
import shutil
import subprocess
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, NamedTuple

from pidpanel.constants import LIGGGHTS_VERSION as VERSION
from pidpanel.coupon.liggghts import failures, output

COMMAND = "liggghts"

# Silence after which LIGGGHTS is taken as hung, in addition to that of its steps [s]. Reading the
# largest deck takes a second.
QUIET = 30.0

# Longest time of a step, and of it for each sphere [s]: thirty times what they take on an
# ordinary core (15 µs and 0.35 µs), since a machine may be shared.
SLOWEST_STEP = 4.5e-4, 1.05e-5

# Longest time of a deck and of the end [s], in which lines may come one by one.
LONGEST_DECK, LONGEST_END = 86_400.0, 600.0

MOST_LINES = 10_000_000  # lines after which a command is taken as hung

# Lines that are not read yet, after which LIGGGHTS waits, and characters of a line: what a
# process that prints without end takes of the memory.
LINES_WAITING, LONGEST_LINE = 1000, 4096

# Silence is counted in ticks of this length [s], so that none is counted while the caller itself
# is suspended.
TICK = 1.0

# Commands that move the spheres; they enter the labels of what is run by them. A run goes cycle by
# cycle: LIGGGHTS lists neighbours again at the start of each, as it does after a restart, so a run
# that goes on and one that never stopped have the same rows to the last bit.
RUN, CYCLE = "run {steps}", "run {steps} post no"

# Settings of Open MPI: no daemon for a lone rank, and no folders of its own. All lone ranks of a
# machine make and remove the same folders below the temporary one, so one that starts while another
# ends can fail.
LONE_RANK = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_orte_create_session_dirs": "0"}

_RUN = re.compile(r"^\s*run\s+(\d+)\s*$", re.MULTILINE)
_THERMO = re.compile(r"^\s*thermo\s+(\d+)\s*$", re.MULTILINE)


class Instant(NamedTuple):
    """Step that a simulation has reached."""

    # Its number, and how many spheres there are
    step: int
    spheres: int
    kinetic_energy: float  # of all spheres without their spin [J]; 0 where it was not read


class ContactFiles(NamedTuple):
    """Output of `Liggghts.list_contacts`."""

    motion: Path
    pairs: Path
    touches: Path


def check_installed() -> str:
    """Find LIGGGHTS.

    Raises
    ------
    SolverMissing
        If LIGGGHTS is not installed, with the command that installs it.
    """
    path = shutil.which(COMMAND)
    if path is None:
        raise failures.SolverMissing(
            f"{COMMAND}: not installed; on Debian: apt-get install liggghts (version {VERSION})"
        )
    return path


class Liggghts:
    """A running LIGGGHTS; a context manager that leaves no process behind.

    Parameters
    ----------
    folder
        Working folder; gets ``<name>.in``, ``<name>.log`` and ``<name>.err``.
    """

    def __init__(self, folder: Path, name: str) -> None:
        path = check_installed()
        self._folder = folder
        self.log = folder / f"{name}.log"
        self._err = folder / f"{name}.err"
        # srun must not start a step of its own without PMI
        env = {k: v for k, v in os.environ.items() if k != "SLURM_STEP_ID"}
        env |= LONE_RANK | {"OMP_NUM_THREADS": "1"}
        self._deck = (folder / f"{name}.in").open("w", encoding="utf-8")
        self._errors = self._err.open("w", encoding="utf-8")
        self._process = subprocess.Popen(
            # killed with its parent, and line-buffered: else an error leaves no text at all
            ["setpriv", "--pdeathsig", "KILL", "stdbuf", "-oL", path, "-log", self.log.name],
            cwd=folder,
            env=env,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            errors="replace",
            bufsize=1,
        )
        if self._process.stdin is None or self._process.stdout is None:
            raise failures.RunStopped(f"{self.log}: no pipe to {path}")
        self._input, self._output = self._process.stdin, self._process.stdout
        self._spheres = 0
        self._report_steps = math.inf
        self._queue: queue.Queue[str | None] = queue.Queue(LINES_WAITING)
        self._listener = threading.Thread(
            target=_listen, args=(self._output, self._queue), daemon=True
        )
        self._listener.start()
        try:
            self._check_version()
        except BaseException:
            self.__exit__()
            raise

    def __enter__(self) -> Liggghts:
        return self

    def __exit__(self, *error: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        while self._listener.is_alive():  # it may wait for room in the queue
            with contextlib.suppress(queue.Empty):
                self._queue.get(timeout=0.01)
        for stream in (self._input, self._output, self._errors, self._deck):
            with contextlib.suppress(BrokenPipeError):
                stream.close()

    def _check_version(self) -> None:
        first = next(self._lines("its first line"), None)
        if first is None:  # killed before any output
            raise self._failure([])
        if VERSION not in first:
            raise failures.SolverMissing(
                f"{COMMAND}: reports {first.strip()!r}; version {VERSION} is required"
            )

    # ------------------------------------------------------------------------ commands

    def read_deck(self, text: str) -> None:
        """Set up a simulation.

        Parameters
        ----------
        text
            Text of a deck; see `deck`.
        """
        reports = _THERMO.findall(text)
        self._report_steps = int(reports[-1]) if reports and int(reports[-1]) else math.inf
        steps = sum(map(int, _RUN.findall(text)))
        self._execute(text, steps=steps, is_deck=True)

    def run(self, steps: int, *, read_energy: bool = False) -> Instant:
        """Run further steps, and read the kinetic energy at the end."""
        return self._execute(RUN.format(steps=steps), "ke" if read_energy else "0", steps=steps)

    def run_cycles(self, cycles: int, steps: int, restart: str) -> Instant:
        """Run cycles of a number of steps; write a restart, from which a deck can continue."""
        commands = [CYCLE.format(steps=steps)] * cycles
        text = "\n".join([*commands, f"write_restart {restart}"])
        return self._execute(text, steps=cycles * steps, report=steps)

    def run_and_dump(
        self, steps: int, stride: int, file: str, columns: tuple[str, ...] = output.POSITION
    ) -> Instant:
        """Run so many steps and write the spheres every few, for `output.read_dump`.

        The spheres at the start are the first frame.
        """
        return self._execute(
            f"dump frames all custom {stride} {file} id {' '.join(columns)}\nrun {steps}",
            steps=steps,
        )

    def dump(self, file: str, columns: tuple[str, ...] = output.POSITION) -> Instant:
        """Write the spheres as they are; `output.read_dump` reads them."""
        return self._execute(
            f"dump last all custom 1 {file} id {' '.join(columns)}\nrun 0\nundump last"
        )

    def end_rows(self, *, by_cell: bool) -> None:
        """Write no more rows of cycles, nor those by cell where there are any."""
        self._execute("unfix cycle" + ("\nunfix cycle_cells" if by_cell else ""))

    def list_contacts(self, steps: int, stride: int, *, rolling: bool) -> tuple[int, ContactFiles]:
        """Run steps and list the motion and all contacts every few of them."""
        files = ContactFiles(
            *(self._folder / name for name in ("spheres.bin", "pairs.dump", "touches.dump"))
        )
        pairs = output.contact_columns("pairs", with_wall=False, rolling=rolling)
        touches = output.contact_columns("touches", with_wall=True, rolling=rolling)
        first = self._execute(
            f"dump pairs all local {stride} {files.pairs.name} {pairs}\n"
            f"dump touches all local {stride} {files.touches.name} {touches}\n"
            f"dump spheres all custom {stride} {files.motion.name} id {' '.join(output.MOTION)}\n"
            "dump_modify spheres sort id"
        )
        self._execute(f"run {steps}\nundump pairs\nundump touches\nundump spheres", steps=steps)
        return first.step, files

    def set_velocity(self, x: float, y: float, z: float) -> None:
        """Give all spheres a velocity [m/s]."""
        self._execute(f"velocity all set {x} {y} {z}")

    def instant(self) -> Instant:
        """Return the step that the simulation has reached."""
        return self._execute("")

    def finish(self, last_step: int | None = None, spheres: int | None = None) -> None:
        """End the input, wait for a clean exit and check the log against the expected run.

        Parameters
        ----------
        last_step, spheres
            Last step and number of spheres at the end; see `output.check_log`. The log is not read
            without them.

        Raises
        ------
        RunStopped, RunHung, ParticlesLost, LogTruncated
        """
        self._input.close()
        lines = deque(self._lines("its end", LONGEST_END), LINES_WAITING)
        if self._process.wait() != 0:
            raise self._failure(lines)
        if last_step is not None and spheres is not None:
            text = self.log.read_text(errors="replace")
            output.check_log(text, str(self.log), last_step=last_step, atoms=spheres)

    # ------------------------------------------------------------------------ transport

    def _lines(
        self, action: str, longest: float = math.inf, longest_silence: float | None = None
    ) -> Iterator[str]:
        """Yield the lines that the process prints; it is killed after a time or a silence [s]."""
        longest_silence = QUIET if longest_silence is None else longest_silence
        spent = silence = 0.0
        for _ in range(MOST_LINES):
            start = time.monotonic()
            while True:
                with contextlib.suppress(queue.Empty):
                    line = self._queue.get(timeout=TICK)
                    break
                silence += TICK
                if silence >= longest_silence:
                    raise self._hung(f"no output for {longest_silence:.3g} s in {action}")
            spent += max(silence, min(time.monotonic() - start, TICK))
            silence = 0.0
            if line is None:
                return
            yield line
            if spent >= longest:
                raise self._hung(f"not done in {longest:.3g} s: {action}")
        raise self._hung(f"{MOST_LINES} lines in {action}")

    def _hung(self, message: str) -> failures.RunHung:
        self._process.kill()
        return failures.RunHung(f"{self.log}: {message}; ended")

    def _patience(self, steps: float) -> float:
        """Return the longest time of a number of steps [s]."""
        return QUIET + (SLOWEST_STEP[0] + SLOWEST_STEP[1] * self._spheres) * steps

    def _execute(
        self,
        commands: str,
        value: str = "0",
        steps: int = 0,
        report: int | None = None,
        *,
        is_deck: bool = False,
    ) -> Instant:
        """Send commands that run a number of steps, then evaluate an expression of LIGGGHTS.

        A line comes at least every ``report`` steps; by default as often as the deck states. The
        number of spheres that a deck makes is not known, so it may take `LONGEST_DECK`.
        """
        text = f'{commands.rstrip()}\nprint "MARK step $(step) atoms $(atoms) value $({value})"\n'
        self._deck.write(text)
        self._deck.flush()
        lines: deque[str] = deque(maxlen=LINES_WAITING)
        try:
            self._input.write(text)
            self._input.flush()
            longest = LONGEST_DECK if is_deck else self._patience(steps)
            silence = self._patience(min(steps, report or self._report_steps))
            last_command = repr(commands.strip().rpartition("\n")[2])
            for line in self._lines(last_command, longest, silence):
                mark = output.MARK.match(line.rstrip("\n"))
                if mark:
                    self._spheres = int(mark[2])
                    return Instant(int(mark[1]), self._spheres, self._number(mark[3]))
                lines.append(line)
        except BrokenPipeError:
            lines.extend(self._lines("its end", LONGEST_END))
        raise self._failure(lines)

    def _number(self, word: str) -> float:
        try:
            return float(word)
        except ValueError:
            raise failures.NotFinite(f"{self.log}: not a number, {word!r}") from None

    def _failure(self, lines: Iterable[str]) -> failures.SolverFailure:
        """Return the failure by the exit status and the last output of the process."""
        try:
            status = self._process.wait(timeout=QUIET)
        except subprocess.TimeoutExpired:
            return self._hung(f"no end {QUIET:.3g} s after its output")
        self._errors.flush()
        words = [w.strip() for w in (*lines, *self._err.read_text(errors="replace").splitlines())]
        errors = [w for w in words if "ERROR" in w]
        last = (errors or [w for w in reversed(words) if w] or ["no message"])[0]
        kind = failures.ParticlesLost if "ost atoms" in last else failures.RunStopped
        return kind(f"{self.log}: exit status {status}: {last}")


def _listen(output: IO[str], lines: queue.Queue[str | None]) -> None:
    """Hand on every line of a pipe, long ones in pieces, and None at its end."""
    while line := output.readline(LONGEST_LINE):
        lines.put(line)
    lines.put(None)
