"""Write a commented study of a rectangular panel.

Each option has a default; the study states its assumptions.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

HELP = "Write a commented study, which is then edited."

BEADS = ("acrylic", "steel", "none")
SECTIONS = ("sandwich", "solid", "thin")
SUPPORTS = ("simply_supported", "clamped", "free")
SPECTRUM = "smc_s_016_2014_min_third.csv"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("file", type=Path, help="YAML file to write, such as wing.yaml")
    parser.add_argument("--force", action="store_true", help="overwrite an existing file")
    group = parser.add_argument_group("the study")
    for value in INPUTS:
        option = f"--{value.name.replace('_', '-')}"
        group.add_argument(
            option.removesuffix("s") if value.is_list else option,
            dest=value.name,
            action="append" if value.is_list else "store",
            type=value.read,
            choices=value.choices,
            metavar=value.form,
            help=f"{value.words}; repeatable" if value.is_list else value.words,
        )


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel.cli.draft import Draft, write

    values = {
        key: value
        for key, value in vars(args).items()
        if key in Draft.__dataclass_fields__ and value is not None
    }
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


def above_zero(text: str) -> float:
    """Return a number above zero."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number above 0")
    return number


class Input(NamedTuple):
    """A value of a draft, as an option of the command."""

    name: str
    words: str  # what it is, with its unit; a default follows in brackets
    read: Callable[[str], Any] = str
    form: str | None = None  # in which it is written
    choices: Sequence[str] | None = None
    is_list: bool = False


INPUTS = (
    Input("title", "title of the report (default: the name of the file)"),
    Input("size", "edges of the panel [m] (default: 1.5x1.0)", size, "AxB"),
    Input("hold_downs", "hold-down, 2 cm in radius [m]; the edges are then free by default",
          place, "X,Y", is_list=True),
    Input("supports", "edges of the panel (default: simply_supported)", choices=SUPPORTS),
    Input("section", "kind of the panel's section (default: sandwich)", choices=SECTIONS),
    Input("face_mm", "sandwich: thickness of a face, aluminium [mm] (0.3)", above_zero),
    Input("core_mm", "sandwich: thickness of the core [mm] (20)", above_zero),
    Input("core_grade", "sandwich: grade of the core (3/16-5056-0.0007)"),
    Input("thickness_mm", "solid or thin: thickness [mm] (5 or 25)", above_zero),
    Input("mass_kg_m2", "thin: mass per area [kg/m²] (4)", above_zero),
    Input("stiffness_n_m", "thin: bending stiffness [N m] (3273)", above_zero),
    Input("holes", "round hole: centre and diameter [m]", hole, "X,Y,D", is_list=True),
    Input("points", "further response point [m]", place, "X,Y", is_list=True),
    Input("spectrum", f"CSV table of sound levels (default: {SPECTRUM})"),
    Input("oaspl", "overall level [dB] (default: that of the table)", above_zero),
    Input("bead", "particles; none: the paper's law (acrylic)", choices=BEADS),
    Input("bead_mm", "diameter of the particles [mm] (2)", above_zero),
    Input("cell_mm", "width of a honeycomb cell across flats [mm] (6.35)", above_zero),
    Input("table", "CSV table of measured damping, instead of particles"),
    Input("budget_kg", "search layouts of dampers within this mass [kg]", above_zero),
    Input("shaker", "CSV table of base motion, such as gevs_qualification.csv", form="TABLE"),
)  # fmt: skip
