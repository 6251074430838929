"""What every script of the workflow does besides its one call."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path


def run(main: Callable[[Sequence[str]], None]) -> None:
    """Call a script with the arguments of the process; a failure of ours ends it in one line.

    An error whose class is defined in pidpanel says what is wrong; any other keeps its traceback.

    Parameters
    ----------
    main
        The script's function of its arguments.
    """
    try:
        main(sys.argv[1:])
    except Exception as error:
        if not type(error).__module__.startswith("pidpanel."):
            raise
        sys.exit(str(error))


def optional(path: str) -> Path | None:
    """Return a path of the command line, or None where it says ``none``."""
    return None if path == "none" else Path(path)
