"""The arguments of all commands, and what ``--help`` says of them."""

import argparse
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import NoReturn

from pidpanel.paths import study_path

# In the order in which a study needs them; each is a module of this package.
COMMANDS = (
    "new", "check", "run", "optimise", "identify", "status", "report", "compare",
    "export", "deck", "schema", "completion",
)  # fmt: skip

# as in shtab, which is imported for the command `completion` alone
FILES = {"bash": "_shtab_compgen_files", "zsh": "_files", "tcsh": "f"}
# What completes an argument in each shell.
FOLDERS = {"bash": "_shtab_compgen_dirs", "zsh": "_files -/", "tcsh": "d"}


class Parser(argparse.ArgumentParser):
    """A parser that answers a mistake in one line."""

    def error(self, message: str) -> NoReturn:
        """Print the mistake and where help is; exit with 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command with all its subcommands."""
    whole = Parser(
        prog="pidpanel",
        description=_text("description.txt"),
        epilog=_text("epilog.txt"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"%(prog)s {version('pidpanel')}")
    commands = whole.add_subparsers(
        dest="command", required=True, metavar="command", title="commands, in the order of use"
    )
    for name in COMMANDS:
        module = import_module(f"pidpanel.cli.{name}")
        subparser = commands.add_parser(
            name,
            help=module.HELP,
            description=module.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        module.add_arguments(subparser)
        subparser.set_defaults(call=module.call)
    return whole


def _text(name: str) -> str:
    """Return a text beside this module, as ``--help`` prints it."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def parsed(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a command; `further` is what follows ``--``, for Snakemake."""
    end = list(arguments).index("--") if "--" in arguments else len(arguments)
    whole = parser()
    if arguments[:1] == ["estimate"]:
        whole.error("estimate was removed: check prints the time of the LIGGGHTS runs")
    args = whole.parse_args(arguments[:end])
    args.further = list(arguments[end + 1 :])
    if args.further and args.command != "run":
        whole.error("options after -- are for Snakemake and only allowed with run")
    return args


def add_study(parser: argparse.ArgumentParser) -> None:
    """Add the file of a study."""
    completed(parser.add_argument("study", type=study_path, help="YAML file of the study"), FILES)
    parser.add_argument(
        "--trust-deck",
        action="store_true",
        help="run your own decks, which can start programs and write any file",
    )


def add_directory(parser: argparse.ArgumentParser) -> None:
    """Add the folder that contains ``results``."""
    argument = parser.add_argument(
        "-d",
        "--directory",
        type=Path,
        default=Path(),
        metavar="FOLDER",
        help="folder that contains the folder results (default: the working folder)",
    )
    completed(argument, FOLDERS)


def completed(argument: argparse.Action, how: Mapping[str, str]) -> None:
    """Say how a shell completes an argument (`FILES`, `FOLDERS`)."""
    argument.complete = how  # type: ignore[attr-defined]


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Add the number of jobs."""
    parser.add_argument(
        "-j",
        "--jobs",
        type=positive,
        default=2,
        metavar="N",
        help="number of parallel jobs (default: 2)",
    )


def positive(text: str) -> int:
    """Return a whole number from 1."""
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a whole number from 1")
    return number
