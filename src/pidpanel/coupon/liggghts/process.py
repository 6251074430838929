"""LIGGGHTS as a job: one process, one rank, fed command by command.

The commands go through the standard input, so a run can be prolonged without a restart until
it is long enough; they are kept in a file that ``liggghts -in`` runs again to the same bits.
If the caller dies, LIGGGHTS is killed with it.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
from pathlib import Path
from types import TracebackType

from pidpanel.coupon.liggghts.output import (
    MARK,
    ParticlesLost,
    RunStopped,
    SolverFailure,
    SolverMissing,
)

COMMAND = "liggghts"
VERSION = "3.8.0"


def check_installed() -> str:
    """Path of LIGGGHTS.

    Raises
    ------
    SolverMissing
        With the command that installs it.
    """
    path = shutil.which(COMMAND)
    if path is None:
        raise SolverMissing(
            f"{COMMAND}: not installed; on Debian: apt-get install liggghts (version {VERSION})"
        )
    return path


class Liggghts:
    """A running LIGGGHTS; a context manager that leaves no process behind.

    Parameters
    ----------
    folder
        Working folder; gets ``<name>.in``, ``<name>.log`` and ``<name>.err``.
    name
        Stem of these files.
    """

    def __init__(self, folder: Path, name: str) -> None:
        path = check_installed()
        self.log = folder / f"{name}.log"
        self._err = folder / f"{name}.err"
        # a step of srun's without PMI, and Open MPI's daemon for a lone rank, are not wanted
        env = {k: v for k, v in os.environ.items() if k != "SLURM_STEP_ID"}
        env |= {"OMPI_MCA_ess_singleton_isolated": "1", "OMP_NUM_THREADS": "1"}
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
            raise RunStopped(f"{self.log}: no pipe to {path}")
        self._input, self._output = self._process.stdin, self._process.stdout
        self._check_version()

    def __enter__(self) -> Liggghts:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.wait()
        for stream in (self._input, self._output, self._errors, self._deck):
            with contextlib.suppress(BrokenPipeError):
                stream.close()

    def _check_version(self) -> None:
        first = self._output.readline()
        if VERSION not in first:
            raise SolverMissing(f"{COMMAND}: says {first.strip()!r}; version {VERSION} is wanted")

    def execute(self, commands: str, value: str = "0") -> tuple[int, int, float]:
        """Send commands and wait until they are done.

        Parameters
        ----------
        commands
            Lines of LIGGGHTS' language.
        value
            An expression of LIGGGHTS evaluated afterwards.

        Returns
        -------
        step, atoms, value
            Of the simulation after the commands.

        Raises
        ------
        RunStopped, ParticlesLost
            If the process ended instead, with its exit status and its last words.
        """
        text = f'{commands.rstrip()}\nprint "MARK step $(step) atoms $(atoms) value $({value})"\n'
        self._deck.write(text)
        self._deck.flush()
        said: list[str] = []
        try:
            self._input.write(text)
            self._input.flush()
            for line in self._output:
                mark = MARK.match(line.rstrip("\n"))
                if mark:
                    return int(mark[1]), int(mark[2]), float(mark[3])
                said.append(line)
        except BrokenPipeError:
            pass
        raise self._failure(said)

    def finish(self) -> None:
        """End the input and wait for a clean exit."""
        self._input.close()
        said = self._output.readlines()
        if self._process.wait() != 0:
            raise self._failure(said)

    def _failure(self, said: list[str]) -> SolverFailure:
        """The failure that the exit status and the last words of the process tell of."""
        status = self._process.wait()
        self._errors.flush()
        words = [w.strip() for w in (*said, *self._err.read_text(errors="replace").splitlines())]
        errors = [w for w in words if "ERROR" in w]
        last = (errors or [w for w in reversed(words) if w] or ["no message"])[0]
        kind = ParticlesLost if "ost atoms" in last else RunStopped
        return kind(f"{self.log}: exit status {status}: {last}")
