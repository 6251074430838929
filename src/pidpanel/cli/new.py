"""Write a commented study of a rectangular panel.

Each option has a default; the study states its assumptions.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Any

from pidpanel.constants import ATLAS

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
    for value in fields(Draft):
        is_list = value.metadata.get("action") == "append"
        option = value.name.removesuffix("s") if is_list else value.name
        group.add_argument(f"--{option.replace('_', '-')}", dest=value.name, **value.metadata)


def call(args: argparse.Namespace) -> int:
    """Run the command; return its exit code."""
    from pidpanel.cli.draft import write

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


# A position, and centre and diameter of a hole [m].
place = partial(numbers, count=2, words="x,y in m, such as 0.4,0.2")
hole = partial(numbers, count=3, words="x,y,diameter in m, such as 0.4,0.2,0.1")


def above_zero(text: str) -> float:
    """Return a number above zero."""
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r}: must be a number above 0")
    return number


def _option(default: Any, words: str, **settings: Any) -> Any:
    """Return a value of a draft that is an option of the command; settings are argparse's."""
    return field(default=default, metadata={"help": words, **settings})


def _positive(default: float | None, words: str) -> Any:
    return _option(default, words, type=above_zero)


def _list(words: str, read: Callable[[str], Any], form: str) -> Any:
    return _option((), f"{words}; repeatable", type=read, metavar=form, action="append")


@dataclass(frozen=True)
class Draft:
    """What is known of a study."""

    title: str = _option("", "title of the report (default: the name of the file)")
    size: tuple[float, float] = _option(
        (1.5, 1.0), "edges of the panel [m] (default: 1.5x1.0)", type=size, metavar="AxB"
    )
    hold_downs: Sequence[tuple[float, ...]] = _list(
        "hold-down, 2 cm in radius [m]; the edges are then free by default", place, "X,Y"
    )
    supports: str = _option("", "edges of the panel (default: simply_supported)", choices=SUPPORTS)
    section: str = _option(
        "sandwich", "kind of the panel's section (default: sandwich)", choices=SECTIONS
    )
    face_mm: float = _positive(0.3, "sandwich: thickness of a face, aluminium [mm] (0.3)")
    core_mm: float = _positive(20.0, "sandwich: thickness of the core [mm] (20)")
    core_grade: str = _option("3/16-5056-0.0007", "sandwich: grade of the core (3/16-5056-0.0007)")
    thickness_mm: float | None = _positive(None, "solid or thin: thickness [mm] (5 or 25)")
    mass_kg_m2: float = _positive(4.0, "thin: mass per area [kg/m²] (4)")
    stiffness_n_m: float = _positive(3273.0, "thin: bending stiffness [N m] (3273)")
    holes: Sequence[tuple[float, ...]] = _list("round hole: centre and diameter [m]", hole, "X,Y,D")
    points: Sequence[tuple[float, ...]] = _list("further response point [m]", place, "X,Y")
    spectrum: str = _option(SPECTRUM, f"CSV table of sound levels (default: {SPECTRUM})")
    oaspl: float | None = _positive(None, "overall level [dB] (default: that of the table)")
    bead: str = _option("acrylic", "particles; none: the paper's law (acrylic)", choices=BEADS)
    bead_mm: float = _positive(2.0, "diameter of the particles [mm] (2)")
    cell_mm: float = _positive(6.35, "width of a honeycomb cell across flats [mm] (6.35)")
    table: str = _option("", "CSV table of measured damping, instead of particles")
    budget_kg: float | None = _positive(None, "search layouts of dampers within this mass [kg]")
    shaker: str = _option(
        "", "CSV table of base motion, such as gevs_qualification.csv", metavar="TABLE"
    )

    @property
    def edges(self) -> str:
        """Supports of the edges; free on hold-downs."""
        return self.supports or ("free" if self.hold_downs else "simply_supported")

    @property
    def thickness(self) -> float:
        """Of a solid or thin section [mm]."""
        return self.thickness_mm or (5.0 if self.section == "solid" else 25.0)

    @property
    def depth_mm(self) -> float:
        """Of the cells: that of the core, or of the panel."""
        return self.core_mm if self.section == "sandwich" else self.thickness

    @property
    def is_simulated(self) -> bool:
        """Whether patches are filled with particles."""
        return not self.table and self.bead != "none"

    @property
    def is_in_atlas(self) -> bool:
        """Whether the atlas has cells of this width and depth."""
        from pidpanel.study.requirements import DEPTH, WIDTH  # slow to import

        sizes = {WIDTH: self.cell_mm, DEPTH: self.depth_mm}
        return all(low <= mm / self.bead_mm <= high for (low, high), mm in sizes.items())

    @property
    def reading(self) -> str:
        """Where the damping comes from; a search and base motion need that of single tones."""
        if not self.table and not self.is_simulated:
            return "paper_corrected"
        if self.is_simulated and self.is_in_atlas:
            return ATLAS
        if self.budget_kg is not None:
            return "stated"
        return "table" if self.table else "dem" if self.shaker else "coupled"
