"""The panel on the page: what it is, its mesh, its section, its modes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from pidpanel.panel.modes import PanelBasis
from pidpanel.panel.supports import boundary_edges
from pidpanel.report import figures, pictures, style, tables
from pidpanel.report.html import Block, Picture, Section, Table
from pidpanel.study import Study

MODES_SHOWN = 9

SUPPORTED = {
    "simply_supported": "simply supported",
    "simply_supported_soft": "simply supported (soft)",
    "clamped": "clamped",
    "free": "free",
}

MATRIX_NAMES = {
    "A": "A, forces per strain",
    "B": "B, forces per curvature",
    "D": "D, moments per curvature about the middle of the core",
    "bending": "bending stiffness, in-plane forces free (D − B A⁻¹ B)",
    "shear": "transverse shear stiffness S",
    "rotary_inertia": "rotary inertia",
    "mass_per_area": "mass per area",
    "area": "area",
    "mass": "mass",
}


def panel_text(study: Study, basis: PanelBasis, section: pd.DataFrame) -> str:
    """The panel in a sentence: size, mass, stiffness, damping, supports, modes.

    Parameters
    ----------
    study
        The study.
    basis
        ``panel/modes.nc``.
    section
        ``panel/section.csv``.
    """
    panel = study.panel
    length, width = np.ptp(basis.vertex_position, axis=0)
    value = section.set_index(["quantity", "row", "column"])["value"]
    size = f"{length:g} m × {width:g} m"
    if panel.size is None:
        size = f"{value['area', 0, 0]:.4g} m² within {size}"
    parts = [size, f"{value['mass_per_area', 0, 0]:.5g} kg/m²"]
    if panel.section.kind == "thin":
        parts.append(f"D = {value['bending', 1, 1]:.6g} N·m")
    else:
        parts += [
            f"{panel.section.kind} section",
            f"D_x = {value['bending', 1, 1]:.5g} and D_y = {value['bending', 2, 2]:.5g} N·m",
            f"S_x = {value['shear', 1, 1]:.4g} and S_y = {value['shear', 2, 2]:.4g} N/m",
        ]
    parts += [f"ζ = {panel.damping_ratio:g}", supports_text(study)]
    if panel.masses:
        total = sum(mass.mass_kg for mass in panel.masses.values())
        parts.append(f"{total:g} kg attached ({', '.join(panel.masses)})")
    modes = ~basis.is_residual
    rigid = int(np.sum(basis.natural_frequency[modes] == 0))
    counted = f"{modes.sum()} modes"
    if rigid:
        counted += f", {rigid} of them of the panel as a rigid body at 0 Hz, undamped,"
    return f"{', '.join(parts)}; {counted} and {int(basis.is_residual.sum())} residual vectors"


def supports_text(study: Study) -> str:
    """What holds the panel."""
    held = study.panel.held
    text = SUPPORTED[held.outline]
    if held.outline == "free":
        text = "free along its edges"
    for edge in held.edges:
        text += f", {SUPPORTED[edge.kind]} from {edge.from_m} to {edge.to_m} m"
    if held.holes != "free":
        text += f", holes {SUPPORTED[held.holes]}"
    for kind, what in (("hinge", "hinges"), ("hold_down", "hold-downs"), ("spring", "springs")):
        names = [name for name, point in held.points.items() if point.kind == kind]
        if names:
            text += f", {what} at {', '.join(names)}"
    return text


def panel_section(
    study: Study,
    basis: PanelBasis,
    modes: pd.DataFrame,
    section: pd.DataFrame,
    printed: pd.DataFrame,
) -> Section:
    """Mesh, section, modes, and Table 1 where the panel is the paper's.

    Parameters
    ----------
    study
        The study.
    basis, modes, section
        ``panel/modes.nc``, ``panel/modes.csv``, ``panel/section.csv``.
    printed
        Table 1 of the paper.
    """
    at = zip(basis.point_names, basis.point_position.tolist(), strict=True)
    figure = figures.mesh_figure(
        basis.vertex_position,
        basis.cells,
        dict(zip(basis.patch_names, basis.cell_in_patch, strict=True)),
        {name: (x, y) for name, (x, y) in at},
    )
    caption = (
        f"The mesh of {len(basis.cells)} elements with the patches that may be filled and the "
        "points listened to."
    )
    if study.panel.size is None:
        caption += " Curves are drawn by straight pieces."
    blocks: list[Block] = [Picture("mesh", style.png(figure), caption)]
    if study.panel.section.kind != "thin":
        blocks.append(section_table(section))
    if tables.is_papers_panel(modes, printed):
        blocks += tables.paper_mode_tables(modes, printed)
        blocks.append(tables.mode_table(modes, folded=True))
    else:
        blocks.append(tables.mode_table(modes))
    blocks.append(_shapes(basis, modes))
    return Section("panel", "Panel", blocks)


def section_table(section: pd.DataFrame) -> Table:
    """Matrices of the section by rows.

    Parameters
    ----------
    section
        ``panel/section.csv``.
    """
    rows = []
    for (quantity, row), entries in section.groupby(["quantity", "row"], sort=False):
        values = "  ".join(tables.number(value, 5) for value in entries["value"])
        name = MATRIX_NAMES[str(quantity)] + (f", row {row}" if row else "")
        rows.append([name, values, str(entries["unit"].iloc[0])])
    return Table("The section as computed from its layup", ["quantity", "value", "unit"], rows)


def _shapes(basis: PanelBasis, modes: pd.DataFrame) -> Picture:
    """Pictures of the first modes."""
    count = min(MODES_SHOWN, len(modes))
    lines = [boundary_edges(basis.cells)]
    lines += [boundary_edges(basis.cells[inside]) for inside in basis.cell_in_patch]
    images = pictures.mode_pictures(
        basis.vertex_position,
        basis.cells,
        basis.shape_at_vertices[:, :count],
        np.concatenate(lines),
        basis.point_position,
    )
    figure = figures.pictures_figure(
        images,
        [_title(row) for row in tables.records(modes.head(count))],
        columns=3,
        colormap="RdBu_r",
        limits=(-1, 1),
        label="deflection over its largest value",
    )
    orders = " with their half waves (m, n) along x and y" if "m" in modes else ""
    caption = f"The first {count} modes{orders}. Lines: patches; dots: response points."
    return Picture("mode_shapes", style.png(figure), caption)


def _title(row: dict[str, Any]) -> str:
    order = f" ({row['m']}, {row['n']})," if "m" in row else ""
    return f"{row['mode']}:{order} {row['frequency_hz']:.2f} Hz"
