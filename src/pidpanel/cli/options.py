"""What the commands have in common: help as it is written, arguments, types of arguments."""

import inspect
import math
import os
import shlex
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from pidpanel.paths import study_path

FILE = click.Path(path_type=Path)
FOLDER = click.Path(file_okay=False, path_type=Path)


class Command(click.Command):
    """A command with its help as it is written."""

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        formatter.write(f"\n{textwrap.indent(inspect.cleandoc(self.help or ''), '  ')}\n")

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        if self.epilog:
            formatter.write(f"\n{self.epilog}\n")


class Commands(Command, click.Group):
    """Commands in the order of use."""

    command_class = Command

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)


class Numbers(click.ParamType):
    """Finite numbers with a sign between them, such as ``0.4,0.2``."""

    def __init__(
        self, name: str, words: str, sign: str = ",", least: float = -math.inf, **texts: str
    ) -> None:
        self.name, self.words, self.sign, self.least, self.texts = name, words, sign, least, texts

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return self.name

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        try:
            text = self.texts.get(value, str(value)).replace("×", "x")
            numbers = tuple(float(part) for part in text.split(self.sign))
        except ValueError:
            numbers = ()
        is_allowed = all(self.least < number < math.inf for number in numbers)
        if len(numbers) != self.name.count(self.sign) + 1 or not is_allowed:
            self.fail(f"{value!r}: must be {self.words}", param, ctx)
        return numbers


SIZE = Numbers("AxB", "two lengths in m, such as 2.1x1.2", "x", least=0)
PLACE = Numbers("X,Y", "x,y in m, such as 0.4,0.2")
STEADY = Numbers("X,Y,Z", "x,y,z in g, such as 0,0,-3")
WORDS = "flat, upright, or the direction of gravity, such as 0,1,0"
ATTITUDE = Numbers("flat|upright|X,Y,Z", WORDS, flat="0,0,-1", upright="1,0,0")
HOLE = Numbers("X,Y,D", "x,y,diameter in m, such as 0.4,0.2,0.1")


def _trust_deck(context: click.Context, parameter: click.Parameter, is_trusted: bool) -> None:
    if is_trusted:
        os.environ["PIDPANEL_TRUST_DECK"] = "1"


def _checked_folder(context: click.Context, parameter: click.Parameter, folder: Path) -> Path:
    from pidpanel.provenance.links import check_working_folder

    check_working_folder(folder)
    return folder


def _study_file(context: click.Context, parameter: click.Parameter, file: Path) -> Path:
    """Return a study by its path, or by the name of one that comes with pidpanel."""
    return study_path(str(file))


def study_argument(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the file of a study, and the trust in its decks."""
    file = click.argument(
        "file", metavar="STUDY", type=FILE, callback=_study_file, help="YAML file of the study"
    )
    words = "run your own decks, which can start programs and write any file"
    trust = click.option(
        "--trust-deck", is_flag=True, expose_value=False, callback=_trust_deck, help=words
    )
    return file(trust(command))


directory = click.option(
    "-d", "--directory", type=FOLDER, metavar="FOLDER", default=".", callback=_checked_folder,
    help="folder that contains the folder results (default: the working folder)",
)  # fmt: skip
jobs = click.option(
    "-j", "--jobs", type=click.IntRange(1), metavar="N", default=2,
    help="number of parallel jobs (default: 2)",
)  # fmt: skip
force = click.option("--force", is_flag=True, help="overwrite an existing file")


def print_next(file: Path, directory: Path, *commands: str) -> None:
    """Print the commands that may come next, apart from stdout, which scripts read."""
    place = [] if directory == Path() else ["-d", str(directory)]
    words = [command.split() for command in commands]
    calls = [shlex.join(["pidpanel", name, str(file), *more, *place]) for name, *more in words]
    sys.stdout.flush()  # what comes next is the last line where both go to one file
    print(f"next: {' or '.join(calls)}", file=sys.stderr)
