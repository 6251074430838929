"""The requests of this call of Snakemake."""

import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pidpanel.provenance import digests, durable, requests
from pidpanel.provenance.locks import WORKFLOW_PROCESS


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
        request = requests.request_of(outputs[0])
        if self.is_new(request):
            content = {name: v() if callable(v) else v for name, v in values.items()}
            is_made, damaged = requests.is_made(request, content, outputs)
            requests.ask(request, content, outputs, is_made=is_made)
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
