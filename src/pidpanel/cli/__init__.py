"""The command ``pidpanel``: from a new study to its page; exit codes and one-line messages."""

import errno
import os
import sys
from collections.abc import Sequence

# Exit codes, listed by ``pidpanel --help``.
DONE, FAILED, MISTAKE, MACHINE, INTERRUPTED = 0, 1, 2, 3, 130

FULL = (errno.ENOSPC, errno.EDQUOT)
# Exit codes by the name of the error, so that none is imported before it is raised.
OF_CLASS = {"SolverMissing": MACHINE, "MachineError": MACHINE, "RunError": FAILED,
            "StageFailed": FAILED}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``pidpanel``; what follows ``--`` is for Snakemake."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    try:
        import click

        from pidpanel.cli.commands import VARIABLE, pidpanel

        if VARIABLE in os.environ:
            pidpanel.main(prog_name="pidpanel", complete_var=VARIABLE)
        end = arguments.index("--") if "--" in arguments else len(arguments)
        further = arguments[end + 1 :]
        with pidpanel.make_context("pidpanel", arguments[:end], obj=further) as context:
            status = pidpanel.invoke(context) or DONE
        sys.stdout.flush()
    except KeyboardInterrupt:
        return _print_error("stopped; the same command resumes", INTERRUPTED)
    except click.exceptions.Exit as ended:
        return ended.exit_code
    except click.ClickException as error:
        place = getattr(error, "ctx", None)
        name = place.command_path if place else "pidpanel"
        message = " ".join(error.format_message().split()).removesuffix(".")
        return _print_error(f"{name}: {message}; see {name} --help", MISTAKE)
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
