"""The arguments of all commands, as ``commands.toml`` states them."""

import argparse
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, NoReturn

from pidpanel.paths import study_path

STATED = tomllib.loads(Path(__file__).with_name("commands.toml").read_text(encoding="utf-8"))

# In the order in which a study needs them; each is a module of this package.
COMMANDS = tuple(STATED["commands"])


class Parser(argparse.ArgumentParser):
    """A parser that answers a mistake in one line."""

    def error(self, message: str) -> NoReturn:
        """Print the mistake and where help is; exit with 2."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command with all its subcommands."""
    root = Parser(
        prog="pidpanel",
        description=STATED["description"],
        epilog=STATED["epilog"],
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    root.add_argument("--version", action="version", version=f"%(prog)s {version('pidpanel')}")
    commands = root.add_subparsers(
        dest="command", required=True, metavar="command", title="commands, in the order of use"
    )
    for name, stated in STATED["commands"].items():
        module = import_module(f"pidpanel.cli.{name}")
        subparser = commands.add_parser(
            name,
            help=stated["help"],
            description=module.__doc__,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        groups: dict[str, Any] = {"": subparser}
        for argument in stated.get("arguments", ()):
            settings = STATED["common"].get(argument.get("use"), argument)
            title = settings.get("group", "")
            if title not in groups:
                groups[title] = subparser.add_argument_group(title)
            _add(groups[title], settings)
        subparser.set_defaults(call=module.call, **stated.get("defaults", {}))
    return root


def _add(group: argparse.ArgumentParser, stated: Mapping[str, Any]) -> None:
    """Add an argument, with what completes it in a shell."""
    ours = ("flags", "group", "complete")
    settings = {key: value for key, value in stated.items() if key not in ours}
    if "type" in settings:
        settings["type"] = TYPES[settings["type"]]
    argument = group.add_argument(*stated["flags"], **settings)
    if "complete" in stated:
        argument.complete = COMPLETIONS[stated["complete"]]  # type: ignore[attr-defined]


def parsed(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the arguments of a command; `further` is what follows ``--``, for Snakemake."""
    end = list(arguments).index("--") if "--" in arguments else len(arguments)
    root = parser()
    if arguments[:1] == ["estimate"]:
        root.error("estimate was removed: check prints the time of the LIGGGHTS runs")
    args = root.parse_args(arguments[:end])
    args.further = list(arguments[end + 1 :])
    if args.further and args.command != "run":
        root.error("options after -- are for Snakemake and only allowed with run")
    return args


def above_zero(
    text: str, kind: type[int | float] = float, words: str = "a number above 0"
) -> float:
    """Return a number of a kind above zero."""
    try:
        number = kind(text)
    except ValueError:
        number = 0
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r}: must be {words}")
    return number


def size(text: str) -> tuple[float, float]:
    """Return the edges of a panel, as ``2.1x1.2`` [m]."""
    parts = text.replace("×", "x").split("x")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r}: must be two lengths in m, such as 2.1x1.2")
    return above_zero(parts[0]), above_zero(parts[1])


def numbers(text: str, count: int, words: str) -> tuple[float, ...]:
    """Return ``count`` numbers from a text with commas."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"{text!r}: must be {words}")
    return values


# Types and completions of arguments by their names in ``commands.toml``.
TYPES: Mapping[str, Callable[[str], Any]] = {
    "study": study_path,
    "path": Path,
    "count": partial(above_zero, kind=int, words="a whole number from 1"),
    "int": int,
    "above_zero": above_zero,
    "size": size,
    "place": partial(numbers, count=2, words="x,y in m, such as 0.4,0.2"),
    "hole": partial(numbers, count=3, words="x,y,diameter in m, such as 0.4,0.2,0.1"),
}
# as in shtab, which is imported for the command `completion` alone
COMPLETIONS = {
    "files": {"bash": "_shtab_compgen_files", "zsh": "_files", "tcsh": "f"},
    "folders": {"bash": "_shtab_compgen_dirs", "zsh": "_files -/", "tcsh": "d"},
}
