"""Cells of dampers and cells of the core: by default they are the same."""

from collections.abc import Mapping
from typing import Any

from pidpanel.geometry.cells import SHAPES
from pidpanel.study.dampers import BedDamper
from pidpanel.study.section import (
    SandwichSectionInput,
    core_cell_width_mm,
)
from pidpanel.study.stated_dampers import DamperSection

SAME = 0.01  # relative difference of sizes up to which cells are the same


def cells_of_core(values: Any) -> Any:
    """Return the values of a study with the cells of the core, where a damper states none.

    The width is that of hexagons, of a core that has a grade. What is not as it should be is left
    to the models of the sections.
    """
    core = _at(values, "panel", "section", "core")
    if not core:
        return values
    grade, depth = core.get("grade"), core.get("thickness_mm")
    width = core_cell_width_mm(grade) if isinstance(grade, str) else None

    def filled(damper: Any) -> Any:
        if not isinstance(damper, Mapping) or "particles" not in damper:
            return damper
        cell = damper.get("cell", {})
        if not isinstance(cell, Mapping):
            return damper
        cell = dict(cell)
        if width is not None and cell.get("shape", "hexagon") == "hexagon":
            cell.setdefault("across_flats_mm", width)
        if depth is not None:
            cell.setdefault("depth_mm", depth)
        return {**damper, "cell": cell}

    return {**values, "dampers": {n: filled(damper) for n, damper in values["dampers"].items()}}


def _at(values: Any, *keys: str) -> Mapping[str, Any]:
    for key in keys:
        values = values.get(key) if isinstance(values, Mapping) else None
    return values if isinstance(values, Mapping) else {}


def differing_cells(
    section: object,
    dampers: Mapping[str, DamperSection],
) -> list[str]:
    """Return the dampers whose cells differ from those of the core, with both sizes."""
    if not isinstance(section, SandwichSectionInput):
        return []
    core = section.core
    remarks = []
    for name, damper in dampers.items():
        if not isinstance(damper, BedDamper):
            continue
        cell = damper.cell
        width = core.cell_width_mm or cell.across_flats_mm
        sizes = (cell.across_flats_mm, width), (cell.depth_mm, core.thickness_mm)
        if cell.shape != "hexagon" or any(abs(a / b - 1) > SAME for a, b in sizes):
            wide = f" {core.cell_width_mm:.3g} mm wide," if core.cell_width_mm else ""
            remarks.append(
                f"{name} has {SHAPES[cell.shape].word} cells {cell.across_flats_mm:.3g} mm wide,"
                f" {cell.depth_mm:.3g} mm deep; those of the core are{wide}"
                f" {core.thickness_mm:.3g} mm deep"
            )
    return remarks
