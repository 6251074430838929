"""The command ``new``."""

from functools import partial
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from pidpanel.cli.options import (
    ATTITUDE,
    FILE,
    HOLE,
    PLACE,
    SIZE,
    STEADY,
    Command,
    force,
    print_next,
)  # fmt: skip

ABOVE_ZERO = click.FloatRange(0, min_open=True)
EDGES = click.Choice(["simply_supported", "clamped", "free"])
SECTIONS = click.Choice(["sandwich", "solid", "thin"])
SURROUNDINGS = click.Choice(["free", "baffle"])
PARTICLES = click.Choice(["acrylic", "steel", "none"])
SPECTRUM = "smc_s_016_2014_min_third.csv"

option = partial(click.option, show_default=True)
several = partial(option, multiple=True)


@click.command(cls=Command)
@click.argument("file", type=FILE, help="YAML file to write, such as wing.yaml")
@force
@option("--title", help="title of the report (default: the name of the file)")
@option("--size", type=SIZE, default="1.5x1.0", help="edges of the panel [m]")
@option("--mesh", type=FILE, help="Nastran deck or gmsh file: mesh, supports, section, masses")
@option("--modes", type=FILE, help="modes of another solver, with --mesh: a structure, no panel")
@option("--mass-normalised", is_flag=True, help="modes without masses are scaled to 1 kg")
@option("--uniform-kg", type=ABOVE_ZERO, help="mass that modes without masses spread evenly [kg]")
@several("--group", "groups", help="property or SET that the panel is, or the sound meets")
@option("--unit-m", type=ABOVE_ZERO, help="length unit of the mesh [m] (1, or 0.001 by its extent)")
@several("--hold-down", "hold_downs", type=PLACE, help="hold-down of 2 cm radius [m]; repeatable")
@option("--supports", type=EDGES, help="edges (default: simply_supported; free with hold-downs)")
@option("--section", type=SECTIONS, default="sandwich", help="kind of the panel's section")
@option("--face-mm", default=0.3, help="sandwich: thickness of a face, aluminium [mm]")
@option("--core-mm", default=20.0, help="sandwich: thickness of the core [mm]")
@option("--core-grade", default="3/16-5056-0.0007", help="sandwich: grade of the core")
@option("--thickness-mm", type=ABOVE_ZERO, help="solid or thin: thickness [mm] (5 or 25)")
@option("--mass-kg-m2", default=4.0, help="thin: mass per area [kg/m²]")
@option("--stiffness-n-m", default=3273.0, help="thin: bending stiffness [N m]")
@several("--hole", "holes", type=HOLE, help="round hole: centre and diameter [m]; repeatable")
@several("--point", "points", type=PLACE, help="further response point [m]; repeatable")
@option("--spectrum", default=SPECTRUM, help="CSV table of sound levels")
@several("--limits", metavar="[POINT=]G", help="largest g rms, or CSV of a PSD; of all points")
@option("--oaspl", type=ABOVE_ZERO, help="overall level [dB] (default: that of the table)")
@option("--surroundings", type=SURROUNDINGS, default="free", help="free, or in a rigid wall")
@option("--wall-m", type=ABOVE_ZERO, help="free, this far from a rigid wall behind the panel [m]")
@option("--bead", type=PARTICLES, default="acrylic", help="particles; none: the paper's law")
@option("--bead-mm", type=ABOVE_ZERO, default=2.0, help="diameter of the particles [mm]")
@option("--cell-mm", type=ABOVE_ZERO, help="width of the cells [mm] (that of the core, or 6.35)")
@option("--attitude", type=ATTITUDE, default="flat", help="of the panel, or gravity in its axes")
@option("--steady-g", type=STEADY, help="what particles feel in flight besides gravity [g]")
@option("--table", help="CSV table of measured damping, instead of particles")
@option("--budget-kg", type=ABOVE_ZERO, help="search layouts of dampers within this mass [kg]")
@option("--uncertain", is_flag=True, help="usual spreads of the inputs, marked as assumed")
@option("--shaker", help="CSV table of base motion, such as gevs_qualification.csv")
def new(file: Path, force: bool, **options: Any) -> None:
    """Write a commented study, which is then edited.

    The panel is rectangular, or that of --mesh. Each option has a default; the study states its
    assumptions.
    """
    from pidpanel.cli.draft import Draft, write
    from pidpanel.study import StudyError

    context = click.get_current_context()
    is_stated = {
        key: context.get_parameter_source(key) is ParameterSource.COMMANDLINE
        for key in ("size", "section")
    }
    if options["mesh"] is not None and is_stated["size"]:
        raise StudyError(f"--size: not allowed with --mesh, the size is that of {options['mesh']}")
    if Path(options["mesh"] or "").suffix.lower() in (".step", ".stp"):
        message = "no mesh; a study names it in structure.shell.form: {kind: file, file: …}"
        raise StudyError(f"--mesh: {options['mesh']}: {message} (docs/structures.md)")
    draft = Draft(**options, file=file, is_section_stated=is_stated["section"])
    write(draft, file, force=force)
    print(f"{file}: written")
    if draft.structure is not None:
        print(f"{draft.modes or draft.mesh}: {draft.structure.text}")
        for remark in draft.structure.remarks:
            print(f"  {remark}")
    if draft.deck is not None:
        section = "" if draft.laminate else ", section of the options"
        print(f"{draft.mesh}: {draft.deck.text}{section}")
        for remark in draft.deck.remarks:
            print(f"  {remark}")
    print_next(file, Path(), "check")
