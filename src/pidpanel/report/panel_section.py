"""The panel on the page: what it is, its mesh, its section, its modes, the paper's Table 1."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.panel.basis import PanelBasis
from pidpanel.report import panel_figures, style
from pidpanel.report.html import Block, Cell, PageSection, Picture, Table, table_of
from pidpanel.report.inputs import ReportedPanel
from pidpanel.report.text import number, records, signed, unit

MODES_SHOWN = 9
"""Modes of which the shape is drawn."""

PRINTED_ROUNDING = 2e-4
"""Relative difference up to which a frequency counts as the printed one: Table 1 has two
decimals (8e-5 of the lowest) and the panel is the paper's within that or it is not."""

ROUNDING = 1e-9
"""Share of the largest entry of a matrix below which another is 0 but for rounding."""

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


def panel_text(panel: ReportedPanel, basis: PanelBasis, section: pd.DataFrame) -> str:
    """Return the panel in a sentence: size, mass, stiffness, damping, supports, modes."""
    length, width = np.ptp(basis.vertex_position, axis=0)
    value = section.set_index(["quantity", "row", "column"])["value"]
    size = f"{length:g} m × {width:g} m"
    if not panel.is_rectangle:
        size = f"{value['area', 0, 0]:.4g} m² within {size}"
    parts = [size, f"{value['mass_per_area', 0, 0]:.5g} kg/m²"]
    if panel.section_kind == "thin":
        parts.append(f"D = {value['bending', 1, 1]:.6g} N m")
    else:
        parts += [
            f"{panel.section_kind} section",
            f"D_x = {value['bending', 1, 1]:.5g} and D_y = {value['bending', 2, 2]:.5g} N m",
            f"S_x = {number(value['shear', 1, 1])} and S_y = {number(value['shear', 2, 2])} N/m",
        ]
    parts += panel.words
    modes = ~basis.is_residual
    rigid = int(np.sum(basis.natural_frequency[modes] == 0))
    counted = f"{modes.sum()} modes"
    if rigid:
        counted += f" ({rigid} of them undamped rigid-body modes at 0 Hz)"
    return f"{', '.join(parts)}; {counted} and {int(basis.is_residual.sum())} residual vectors"


def panel_section(
    panel: ReportedPanel,
    basis: PanelBasis,
    modes: pd.DataFrame,
    section: pd.DataFrame,
    printed: pd.DataFrame,
) -> PageSection:
    """Return mesh, section, modes, and Table 1 where the panel is the paper's."""
    positions = zip(basis.point_names, basis.point_position.tolist(), strict=True)
    figure = panel_figures.mesh_figure(
        basis.vertex_position,
        basis.cells,
        dict(zip(basis.patch_names, basis.cell_in_patch, strict=True)),
        {name: (x, y) for name, (x, y) in positions},
    )
    caption = f"Mesh of {len(basis.cells)} elements with the patches and the response points."
    if not panel.is_rectangle:
        caption += " Curved edges are drawn as straight segments."
    blocks: list[Block] = [_shapes(basis, modes), mode_table(modes, folded=True)]
    if is_papers_panel(modes, printed):
        blocks += paper_mode_tables(modes, printed)
    if panel.section_kind != "thin":
        blocks.append(section_table(section))
    blocks.append(Picture("mesh", style.png(figure), caption))
    return PageSection("panel", "Panel", blocks)


def is_papers_panel(modes: pd.DataFrame, printed: pd.DataFrame) -> bool:
    """Return whether closed form and printed table are of one panel."""
    if "navier_hz" not in modes:
        return False
    merged = printed.merge(modes, on=["m", "n"], suffixes=("_printed", ""))
    if len(merged) < len(printed):
        return False
    away = np.abs(merged["navier_hz"] / merged["frequency_hz_printed"] - 1)
    return bool((away < PRINTED_ROUNDING).all())


def paper_mode_tables(modes: pd.DataFrame, printed: pd.DataFrame) -> list[Table]:
    """Return Table 1 beside the computed frequencies, and the modes that it leaves out."""
    merged = printed.merge(modes, on=["m", "n"], suffixes=("_printed", ""), how="left")
    worst = (merged["frequency_hz"] / merged["frequency_hz_printed"] - 1).abs().max()
    first = table_of(
        records(merged),
        f"Table 1 of the paper, all {len(printed)} rows in the printed order; the computed "
        f"frequencies differ from the printed ones by {100 * worst:.3f} % at most",
        {
            "mode (m, n)": _order,
            "printed, Hz": _hertz("frequency_hz_printed"),
            **COMPUTED,
            "computed − printed, %": lambda row: signed(
                100 * (row["frequency_hz"] / row["frequency_hz_printed"] - 1), 4
            ),
        },
        folded=True,
    )
    # to the next hundred above the last printed frequency
    limit = 100 * math.ceil(printed["frequency_hz"].max() / 100)
    listed = pd.MultiIndex.from_frame(printed[["m", "n"]])
    unlisted = ~pd.MultiIndex.from_frame(modes[["m", "n"]]).isin(listed)
    missing = modes[(modes["frequency_hz"] < limit) & unlisted]
    caption = f"The {len(missing)} modes below {limit} Hz that Table 1 leaves out"
    cells = {"mode (m, n)": _order, **COMPUTED}
    return [first, table_of(records(missing), caption, cells, folded=True)]


def _order(row: Mapping[str, Any]) -> str:
    return f"({row['m']}, {row['n']})"


def _hertz(column: str) -> Cell:
    return lambda row: f"{row[column]:.2f}"


COMPUTED = {
    "computed, Hz": _hertz("frequency_hz"),
    "closed form (Navier), Hz": _hertz("navier_hz"),
}


def mode_table(modes: pd.DataFrame, *, folded: bool = False) -> Table:
    """Return all modes, with their orders and closed forms where they have them."""
    cells: dict[str, Cell] = {
        "mode": lambda row: str(row["mode"]),
        **({"(m, n)": _order} if "m" in modes else {}),
        **(COMPUTED if "navier_hz" in modes else {"computed, Hz": _hertz("frequency_hz")}),
        "modal mass, kg": lambda row: f"{row['modal_mass_kg']:.4f}",
    }
    return table_of(records(modes), f"All {len(modes)} modes of the panel", cells, folded=folded)


def section_table(section: pd.DataFrame) -> Table:
    """Return the matrices of the section row by row."""
    rows = []
    largest = section["value"].abs().groupby(section["quantity"]).max().to_dict()
    for (quantity, row), entries in section.groupby(["quantity", "row"], sort=False):
        noise = ROUNDING * float(largest[quantity])
        values = "  ".join(
            number(value, 5) if abs(value) > noise else "0" for value in entries["value"]
        )
        name = MATRIX_NAMES[str(quantity)] + (f", row {row}" if row else "")
        rows.append([name, values, unit(str(entries["unit"].iloc[0]))])
    return Table("Section computed from its layup", ["quantity", "value", "unit"], rows)


def _shapes(basis: PanelBasis, modes: pd.DataFrame) -> Picture:
    """Return pictures of the first modes."""
    count = min(MODES_SHOWN, len(modes))
    lines = [boundary_edges(basis.cells)]
    lines += [boundary_edges(basis.cells[inside]) for inside in basis.cell_in_patch]
    figure = panel_figures.shapes_figure(
        basis.vertex_position,
        basis.cells,
        basis.shape_at_vertices[:, :count],
        np.concatenate(lines),
        basis.point_position,
        [_title(row) for row in records(modes.head(count))],
    )
    orders = " with their half waves (m, n) along x and y" if "m" in modes else ""
    caption = f"First {count} modes{orders}. Lines: patches; dots: response points."
    return Picture("mode_shapes", style.png(figure), caption)


def _title(row: dict[str, Any]) -> str:
    order = f" ({row['m']}, {row['n']})," if "m" in row else ""
    return f"{row['mode']}:{order} {row['frequency_hz']:.2f} Hz"
