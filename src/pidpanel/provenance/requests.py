"""Requests and records: which jobs of the workflow Snakemake has to run.

Every job has a request, a JSON file in ``.made`` beside its results that the rule takes as an
input. It holds what the result depends on besides other results. A job that ends writes a record
beside it: the digests of that and of all the files that it made. Before Snakemake builds its graph,
`ask` compares them. Where all is as the job left it, the request is older than any result. Where
values have changed, or a file is damaged or lost, the request is new, and Snakemake runs the job.
"""

import hashlib
import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pidpanel.provenance import digests, durable
from pidpanel.provenance.locks import WORKFLOW_PROCESS

FOLDER, RECORD = ".made", ".record"
# Key of a request that makes its content another one, since Snakemake compares checksums.
ATTEMPT = "attempt"

LONG_AGO = 1.0  # time stamp of the request of a job that need not run [s since 1970]


def request_of(output: str | Path) -> Path:
    """Return the request of a job from the first file that it makes.

    Examples
    --------
    >>> str(request_of("results/wing/panel/modes.nc"))
    'results/wing/panel/.made/modes.nc.json'
    """
    output = Path(output)
    return output.parent / FOLDER / f"{output.name}.json"


def ask(
    request: Path, content: Mapping[str, Any], outputs: Sequence[str | Path], *, is_made: bool
) -> None:
    """Write the request of a job, so that Snakemake runs it unless it is made.

    Parameters
    ----------
    content
        Dependencies of the job, as values of JSON.
    is_made
        Whether the outputs exist, are undamaged and were made from this content.
    """
    content = json.loads(json.dumps(content))
    try:
        stored = json.loads(request.read_bytes())
        since = request.stat().st_mtime
    except (OSError, ValueError, RecursionError):
        stored, since = None, 0.0
    if not is_made:
        waiting = isinstance(stored, dict) and stored.pop(ATTEMPT, None) and stored == content
        if waiting and not any(_time(Path(output)) >= since for output in outputs):
            return
        _write(request, {**content, ATTEMPT: time.time_ns()})
        return
    if stored != content:
        _write(request, content)
        since = time.time()
    if since != LONG_AGO:
        os.utime(request, (LONG_AGO, LONG_AGO))


def is_made(
    request: Path, content: Mapping[str, Any], outputs: Sequence[str | Path]
) -> tuple[bool, list[Path]]:
    """Compare what is there with the record that a job left.

    Returns whether all its files are there, undamaged, and made from this content; and those that
    are not as the job left them, or are gone.
    """
    record = read_record(request)
    if record is None:
        return False, []
    present, recorded = file_digests(outputs), record["files"]
    damaged = [Path(file) for file in sorted(present.keys() | recorded.keys())
               if present.get(file, "") != recorded.get(file)]  # fmt: skip
    return not damaged and record["content"] == digests.json_digest(content), damaged


def read_record(request: Path) -> dict[str, Any] | None:
    """Return the record of a job; None where it has none, or a damaged one."""
    try:
        record = json.loads(request.with_suffix(RECORD).read_bytes())
        return record if isinstance(record["files"], dict) and "content" in record else None
    except (OSError, ValueError, RecursionError, KeyError, TypeError):
        return None


def read_request(request: Path) -> dict[str, Any]:
    """Return what a job depends on; it is read before the job begins."""
    content = json.loads(request.read_bytes())
    content.pop(ATTEMPT, None)
    return dict(content)


def write_record(request: Path, content: Mapping[str, Any], outputs: Iterable[str | Path]) -> None:
    """Note what a job that has ended made, and from what."""
    record = {"content": digests.json_digest(content), "files": file_digests(outputs)}
    durable.write_text(request.with_suffix(RECORD), json.dumps(record, indent=1) + "\n")


def file_digests(paths: Iterable[str | Path]) -> dict[str, str]:
    """Return the digest of each file, and of each in a folder; an empty one where there is none."""
    return {str(file): content_digest(file) for path in paths for file in _files(Path(path))}


def _write(request: Path, content: Mapping[str, Any]) -> None:
    """Write a request at one stroke; one that a power cut damages is written again."""
    request.parent.mkdir(parents=True, exist_ok=True)
    draft = request.with_name(f"{request.name}.{os.getpid()}")
    draft.write_text(json.dumps(content) + "\n", encoding="utf-8")
    draft.replace(request)


def _time(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0


def _files(path: Path) -> Iterator[Path]:
    if path.is_dir():
        # Snakemake puts files of its own into a folder
        inside = (file for file in path.rglob("*") if not file.name.startswith(".snakemake"))
        yield from sorted(file for file in inside if file.is_file())
    else:
        yield path


def content_digest(path: Path) -> str:
    """Return the digest of the content of a file; an empty one where it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


class Requests:
    """Writes the request of each job once: on its way a job changes the files itself."""

    def __init__(self) -> None:
        # a job of a cluster is a Snakemake of its own, whose parent has written the requests
        parent = os.environ.get(WORKFLOW_PROCESS, "")
        self.is_main = parent in ("", str(os.getpid()))
        self._paths: set[Path] = set()
        self._damaged: list[Path] = []
        self._runs = False

    def quick(self, outputs: Sequence[str], values: Mapping[str, Any]) -> str:
        """Request a job that takes seconds, and so depends on the whole package; see `job`."""
        return self.job(outputs, {"package": digests.package_digest, **values})

    def job(self, outputs: Sequence[str], values: Mapping[str, Any]) -> str:
        """Request a job that leaves a record."""
        request = request_of(outputs[0])
        if self.is_new(request):
            content = {name: v() if callable(v) else v for name, v in values.items()}
            is_complete, damaged = is_made(request, content, outputs)
            ask(request, content, outputs, is_made=is_complete)
            self.report(f"{path}: damaged, changed or lost since it was made" for path in damaged)
            self._damaged += damaged
            if self._runs:
                self.begin()
        return str(request)

    def is_new(self, request: Path) -> bool:
        """Return whether a request is to be written, which it then is only once."""
        is_new = self.is_main and request not in self._paths
        self._paths.add(request)
        return is_new

    def report(self, lines: Iterable[str]) -> None:
        """Say what of the results is not as it was left."""
        for line in lines:
            print(line, file=sys.stderr, flush=True)

    def begin(self) -> None:
        """Set damaged files aside, before jobs make them again."""
        self._runs = True
        for path in self._damaged:
            durable.set_aside(path, str(path))
        self._damaged.clear()
