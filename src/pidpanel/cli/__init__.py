"""The command ``pidpanel``: from a new study to its page, in the order of its help.

Each subcommand is a module here with ``call``; its arguments are in ``commands.toml``. None of them
imports a study or numpy before it is called, so that help and completion come at once.
"""

import errno
import os
import sys
from collections.abc import Sequence

# Exit codes, listed by ``pidpanel --help``.
DONE, FAILED, MISTAKE, MACHINE, INTERRUPTED = 0, 1, 2, 3, 130

FULL = (errno.ENOSPC, errno.EDQUOT)
# Exit codes by the name of the error, so that none is imported before it is raised.
OF_CLASS = {"SolverMissing": MACHINE, "MachineError": MACHINE, "RunError": FAILED,
            "WorkflowRunning": FAILED}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``pidpanel``."""
    arguments = sys.argv[1:] if arguments is None else arguments
    try:
        from pidpanel.cli.parser import parsed

        options = parsed(arguments)
        if getattr(options, "trust_deck", False):
            os.environ["PIDPANEL_TRUST_DECK"] = "1"
        if hasattr(options, "directory"):
            from pidpanel.provenance.links import check_working_folder

            check_working_folder(options.directory)
        status: int = options.call(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        return _print_error("stopped; the same command resumes", INTERRUPTED)
    except BrokenPipeError:  # whoever read the output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        if error.errno in FULL:  # what is left of the output cannot be written either
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _print_error(_with_plain_names(format_error(error), arguments), MACHINE)
    except Exception as error:
        if not type(error).__module__.startswith("pidpanel."):
            raise
        text = _with_plain_names(str(error), arguments)
        return _print_error(text, OF_CLASS.get(type(error).__name__, MISTAKE))
    return status


def format_error(error: OSError) -> str:
    """Return an error of a file or the disk in one line.

    Examples
    --------
    >>> format_error(OSError(errno.ENOSPC, "No space left on device", "results/psd.nc"))
    'results/psd.nc: no space left on the disk; free some and run the same command again'
    >>> format_error(PermissionError(errno.EACCES, "Permission denied", "results"))
    'results: permission denied'
    """
    place = f"{error.filename}: " if error.filename else ""
    if error.errno in FULL:
        return f"{place}no space left on the disk; free some and run the same command again"
    reason = error.strerror or str(error) or type(error).__name__
    return f"{place}{reason[:1].lower()}{reason[1:]}"


def _with_plain_names(text: str, arguments: Sequence[str]) -> str:
    """Return a message with arguments that would break its lines written as escapes."""
    from pidpanel.text_files import one_line

    for argument in arguments:
        if not argument.isprintable():
            text = text.replace(argument, one_line(argument))
    return text


def _print_error(text: str, status: int) -> int:
    print(text, file=sys.stderr)
    return status
