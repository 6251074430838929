"""Write a commented study of a rectangular panel, from options or from questions.

Without options it asks, on a terminal. The study states its default assumptions.
"""

import argparse
import math
import sys
from collections.abc import Callable
from pathlib import Path

HELP = "Write a commented study, from options or questions."

BEADS = ("acrylic", "steel", "none")
SECTIONS = ("sandwich", "solid", "thin")
SUPPORTS = ("simply_supported", "clamped", "free")
SPECTRUM = "smc_s_016_2014_min_third.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, help="YAML file to write, such as wing.yaml")
    parser.add_argument(
        "--ask", action="store_true", help="ask for values that are not given as options"
    )
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")
    add = parser.add_argument_group("the study").add_argument
    add("--title", help="title of the report (default: the name of the file)")
    add("--size", type=size, metavar="AxB", help="edges of the panel [m] (default: 1.5x1.0)")
    add("--supports", choices=SUPPORTS, help="edges of the panel (default: simply_supported)")
    for name, read, form, meaning in (
        ("hold-down", place, "X,Y", "hold-down, 2 cm in radius [m]; the edges are then free by "
         "default"),
        ("hole", hole, "X,Y,D", "round hole: centre and diameter [m]"),
        ("point", place, "X,Y", "further response point [m]"),
    ):  # fmt: skip
        add(
            f"--{name}", dest=f"{name.replace('-', '_')}s", action="append", type=read,
            metavar=form, help=f"{meaning}; repeatable",
        )  # fmt: skip
    add("--budget-kg", type=above_zero, help="search layouts of dampers within this mass [kg]")
    add(
        "--shaker", metavar="TABLE", help="CSV table of base motion, such as gevs_qualification.csv"
    )
    add("--section", choices=SECTIONS, help="kind of the panel's section (default: sandwich)")
    add("--face-mm", type=above_zero, help="sandwich: thickness of a face, aluminium (0.3)")
    add("--core-mm", type=above_zero, help="sandwich: thickness of the core (20)")
    add("--core-grade", help="sandwich: grade of the core (3/16-5056-0.0007)")
    add("--thickness-mm", type=above_zero, help="solid or thin: thickness (5 or 25)")
    add("--mass-kg-m2", type=above_zero, help="thin: mass per area (4)")
    add("--stiffness-n-m", type=above_zero, help="thin: bending stiffness (3273)")
    add("--spectrum", help=f"CSV table of sound levels (default: {SPECTRUM})")
    add("--oaspl", type=above_zero, help="overall level [dB] (default: that of the table)")
    add("--bead", choices=BEADS, help="particles; none: the paper's law (acrylic)")
    add("--bead-mm", type=above_zero, help="diameter of the particles (2)")
    add("--cell-mm", type=above_zero, help="width of a honeycomb cell across flats (6.35)")
    add("--table", help="CSV table of measured damping, instead of particles")


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel.cli.draft import Draft, questions, write

    values = {
        key: value
        for key, value in vars(args).items()
        if key in Draft.__dataclass_fields__ and value is not None
    }
    if args.ask or (not values and sys.stdin.isatty()):
        values = questions(values, input)
    write(Draft(**values), args.file, force=args.force)
    print(f"{args.file}: written; next: pidpanel check {args.file}")
    return 0


def size(text: str) -> tuple[float, float]:
    """Return the edges of a panel, as ``2.1x1.2`` [m]."""
    parts = text.replace("×", "x").split("x")
    if len(parts) != 2:
        raise argparse.ArgumentTypeError(f"{text!r}: must be two lengths in m, such as 2.1x1.2")
    return above_zero(parts[0]), above_zero(parts[1])


def numbers(text: str, count: int, words: str) -> tuple[float, ...]:
    """Return so many numbers that are separated by commas."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != count or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"{text!r}: must be {words}")
    return values


def place(text: str) -> tuple[float, ...]:
    """Return a position, as ``0.4,0.2`` [m]."""
    return numbers(text, 2, "x,y in m, such as 0.4,0.2")


def hole(text: str) -> tuple[float, ...]:
    """Return centre and diameter of a hole, as ``0.4,0.2,0.1`` [m]."""
    return numbers(text, 3, "x,y,diameter in m, such as 0.4,0.2,0.1")


def several(read: Callable[[str], tuple[float, ...]]) -> Callable[[str], list[tuple[float, ...]]]:
    """Return what reads texts that are separated by semicolons."""
    return lambda text: [read(part) for part in text.split(";")]


def above_zero(text: str) -> float:
    """Return a number above zero."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number above 0")
    return number
