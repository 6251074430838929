"""A job of the workflow: its named files, and what every script does besides its one call."""

from __future__ import annotations

import ctypes
import errno
import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import Any

from pidpanel.paths import COUPON
from pidpanel.provenance import durable, requests
from pidpanel.provenance.locks import WORKFLOW_PROCESS, end_with, exclusive_lock

# Variables with the file of the study and the longest time of a job [s]. They are no parameters:
# neither changes a result.
STUDY, JOB_SECONDS = "PIDPANEL_STUDY", "PIDPANEL_JOB_SECONDS"

GROUPS = ("--input", "--output", "--params")

# Errors that are no fault of pidpanel.
OF_THE_MACHINE = {
    errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO,
    errno.EMFILE, errno.ENFILE, errno.ENOMEM, errno.ESTALE,
}  # fmt: skip

# M_MMAP_MAX and M_TRIM_THRESHOLD [bytes] of glibc: memory of arrays is used again for the next
# ones. Handed back to the system, its pages are cleared each time: a tenth of the CPU time of the
# response of a wing, more of that of a large one. It stays with the process until that ends.
MALLOPT = {-4: 0, -1: 256 << 20}

# Messages of an import without memory for its library.
NOT_LOADED = ("failed to map segment", "cannot allocate memory", "Cannot allocate memory")


class Files:
    """Named files of a job: ``files.modes`` is a path, ``files.get("air")`` may be None."""

    def __init__(self, paths: Mapping[str, Sequence[Path]]) -> None:
        self.all = dict(paths)

    def __getattr__(self, name: str) -> Path:
        """Return the only file of a name."""
        path = self.get(name)
        if path is None:
            raise AttributeError(f"no file of the name {name}")
        return path

    def get(self, name: str) -> Path | None:
        """Return the only file of a name; None if there is none."""
        paths = self.all.get(name, ())
        if len(paths) > 1:
            raise ValueError(f"{name}: {len(paths)} files in place of one")
        return paths[0] if paths else None

    def several(self, name: str) -> list[Path]:
        """Return all files of a name."""
        return list(self.all.get(name, ()))


@dataclass(frozen=True)
class Job:
    """Arguments of a script of the workflow."""

    # Files, by the names that the rule gives them
    input: Files
    output: Files
    params: Mapping[str, str] = field(default_factory=dict)
    study: Path = Path()
    seconds: float = math.inf  # longest time of the job [s]
    coupon: Path = COUPON  # folder of the LIGGGHTS runs of all studies

    def folder(self, name: str) -> Path:
        """Return a folder among the texts."""
        return Path(self.params[name])

    def optional_folder(self, name: str) -> Path | None:
        """Return a folder among the texts; None if it is not among them."""
        return self.folder(name) if name in self.params else None

    @staticmethod
    def parse(arguments: Sequence[str]) -> Job:
        """Read ``--input name=path … --output name=path … --params name=text …``."""
        groups: dict[str, dict[str, list[str]]] = {group: {} for group in GROUPS}
        names = groups[GROUPS[0]]
        for argument in arguments:
            if argument in groups:
                names = groups[argument]
            else:
                name, _, text = argument.partition("=")
                names.setdefault(name, []).append(text)
        *named_files, texts = groups.values()
        read, written = (
            Files({name: list(map(Path, paths)) for name, paths in group.items()})
            for group in named_files
        )
        params = {name: text for name, (text,) in texts.items()}
        study, seconds = os.environ.get(STUDY, ""), os.environ.get(JOB_SECONDS, "inf")
        return Job(read, written, params, Path(study), float(seconds))


def arguments_of(**groups: Mapping[str, Any]) -> list[str]:
    """Return the arguments from which `Job.parse` reads names and paths.

    Examples
    --------
    >>> arguments_of(input={"modes": "m.nc", "air": []}, output={"psd": "p.nc"})
    ['--input', 'modes=m.nc', '--output', 'psd=p.nc']
    """
    arguments = []
    for group, names in groups.items():
        arguments.append(f"--{group}")
        for name, paths in names.items():
            several = [paths] if isinstance(paths, str) else paths
            arguments += [f"{name}={path}" for path in several]
    return arguments


def run(main: Callable[[Job], None]) -> None:
    """Run a script as a job of the workflow; known failures end it with one line.

    An error of a class of pidpanel, or of the machine, is printed as one line; any other keeps its
    traceback. Files take their places when the script has ended, whole; the
    record of the job is then written beside its request, if the rule has one.
    """
    if parent := os.environ.get(WORKFLOW_PROCESS):
        end_with(int(parent))
    _keep_memory()
    try:
        _run(main, sys.argv[1:])
    except KeyboardInterrupt:  # who pressed Ctrl-C knows why
        sys.exit(130)
    except OSError as error:
        if error.errno not in OF_THE_MACHINE:
            raise
        sys.exit(f"{error.filename or sys.argv[0]}: {error.strerror}")
    except Exception as error:
        if is_of_memory(error):
            sys.exit(f"{sys.argv[0]}: not enough memory ({error or 'no further word'})")
        if not type(error).__module__.startswith("pidpanel."):
            raise
        sys.exit(str(error))


def _keep_memory() -> None:
    """Set `MALLOPT`, where the C library is glibc."""
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in MALLOPT.items():
            mallopt(parameter, value)


def _run(main: Callable[[Job], None], arguments: Sequence[str]) -> None:
    job = Job.parse(arguments)
    request = job.input.get("request")
    if request is None:
        main(job)
        return
    with exclusive_lock(request.with_suffix(".lock")):
        content = requests.read_request(request)
        with ExitStack() as stack:
            drafts = {
                name: [stack.enter_context(durable.replacing(path)) for path in paths]
                for name, paths in job.output.all.items()
            }
            main(replace(job, output=Files(drafts)))
        outputs = [path for paths in job.output.all.values() for path in paths]
        requests.write_record(request, content, outputs)


def tell_of_memory() -> None:
    """Report too little memory for the imports of a process in one line."""
    previous_hook = sys.excepthook

    def hook(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
        if is_of_memory(error):
            print(f"{sys.argv[0]}: not enough memory ({error or 'no further word'})"[:500],
                  file=sys.stderr)  # fmt: skip
        else:
            previous_hook(kind, error, trace)

    sys.excepthook = hook


def is_of_memory(error: BaseException) -> bool:
    """Return whether an error means too little memory, also for loading a library.

    Examples
    --------
    >>> is_of_memory(ImportError("libm.so.6: failed to map segment from shared object"))
    True
    >>> is_of_memory(ImportError("No module named 'gmsh'"))
    False
    """
    if isinstance(error, ImportError):
        return any(words in str(error) for words in NOT_LOADED)
    if isinstance(error, RuntimeError):
        return "can't start new thread" in str(error)
    return isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM
