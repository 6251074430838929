"""Write a commented study of a rectangular panel.

Each option has a default; the study states its assumptions.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

SPECTRUM = "smc_s_016_2014_min_third.csv"


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


@dataclass(frozen=True)
class Draft:
    """Values of a study from the options of the command."""

    title: str = ""
    size: tuple[float, float] = (1.5, 1.0)  # [m]
    hold_downs: Sequence[tuple[float, ...]] = ()
    supports: str = ""
    section: str = "sandwich"
    face_mm: float = 0.3
    core_mm: float = 20.0
    core_grade: str = "3/16-5056-0.0007"
    thickness_mm: float | None = None
    mass_kg_m2: float = 4.0
    stiffness_n_m: float = 3273.0
    holes: Sequence[tuple[float, ...]] = ()
    points: Sequence[tuple[float, ...]] = ()
    spectrum: str = SPECTRUM
    oaspl: float | None = None
    surroundings: str = "free"
    wall_m: float | None = None
    bead: str = "acrylic"
    bead_mm: float = 2.0
    cell_mm: float | None = None
    table: str = ""
    budget_kg: float | None = None
    shaker: str = ""

    @property
    def edges(self) -> str:
        """Supports of the edges; free on hold-downs."""
        return self.supports or ("free" if self.hold_downs else "simply_supported")

    @property
    def thickness(self) -> float:
        """Thickness of a solid or thin section [mm]."""
        return self.thickness_mm or (5.0 if self.section == "solid" else 25.0)

    @property
    def depth_mm(self) -> float:
        """Depth of the cells: that of the core, or of the panel."""
        return self.core_mm if self.section == "sandwich" else self.thickness

    @property
    def width_mm(self) -> float:
        """Width of the cells: that of the core, or usual."""
        from pidpanel.study.section import core_cell_width_mm  # slow to import

        of_core = core_cell_width_mm(self.core_grade) if self.section == "sandwich" else None
        return self.cell_mm or of_core or 6.35

    @property
    def is_simulated(self) -> bool:
        """Whether patches are filled with particles."""
        return not self.table and self.bead != "none"

    @property
    def has_law(self) -> bool:
        """Whether damping is that of the paper's law."""
        return not self.table and not self.is_simulated

    @property
    def is_in_atlas(self) -> bool:
        """Whether the atlas has cells of this width and depth."""
        from pidpanel.study.requirements import DEPTH, WIDTH  # slow to import

        sizes = {WIDTH: self.width_mm, DEPTH: self.depth_mm}
        return all(low <= mm / self.bead_mm <= high for (low, high), mm in sizes.items())

    @property
    def model(self) -> str:
        """Damping model of particles; a search and base motion need damping from single tones."""
        if self.is_in_atlas:
            return "atlas"
        return "tones" if self.budget_kg is not None or self.shaker else "coupled"
