"""The panel on the page: what it is, its mesh, its section, its modes, the paper's Table 1."""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure

from pidpanel.arrays import Array
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.panel.basis import PanelBasis
from pidpanel.report import style
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.layout import WIDTH, add_colour_bar, draw_field
from pidpanel.report.names import Study
from pidpanel.report.text import records

MODES_SHOWN = 9  # modes whose shapes are drawn
TURNED_CELLS = 6000  # most elements of a view that turns: a quarter of a megabyte

# Axes of a picture of a shape, to the right and up, of one who looks down on the panel.
SEEN = np.array([[0.9439, -0.3303, 0.0], [0.2376, 0.6789, 0.6947]])
# Height of a picture over the panel's diagonal; largest deflection over its least side.
SPREAD, LIFT = 0.63, 0.1

# Relative difference up to which a frequency agrees with the printed one: Table 1 has two
# decimals (8e-5 of the lowest) and the panel is the paper's within that or it is not.
PRINTED_ROUNDING = 2e-4


def panel_section(
    basis: PanelBasis,
    modes: pd.DataFrame,
    printed: pd.DataFrame,
    study: Study | None = None,
    in_space: PanelBasis | None = None,
) -> PageSection:
    """Return the modes, compared with Table 1 for the panel of the paper.

    Of the study of a structure also its patches, and a curved one from three sides.
    """
    shown, drawn = modes, basis
    if basis.tangential_share is not None:  # rigid motions are mostly along the surface
        shown = modes[modes["frequency_hz"] > 0]
        shapes = basis.shape_at_vertices[:, shown["mode"].to_numpy() - 1]
        drawn = replace(basis, shape_at_vertices=shapes)
    first = records(shown.head(MODES_SHOWN))
    titles = [_title(row) for row in first]
    values = {
        "shapes": figure_picture("mode_shapes", shapes_figure, drawn, titles),
        "shown": len(first),
        "views": None if in_space is None else figure_picture("views", views_figure, in_space),
        "turned": None if in_space is None else turned_surface(in_space),
        "patches": [] if study is None else _patches(basis, study),
        **_mode_values(modes, printed if is_papers_panel(modes, printed) else None),
    }
    title = "Panel" if basis.tangential_share is None else "Structure"
    return template_section("panel.html", title, values)


def _patches(basis: PanelBasis, study: Study) -> list[dict[str, Any]]:
    """Return normal, angle of gravity and tangential share of each patch of a structure."""
    if basis.tangential_share is None:
        return []
    shares = zip(basis.patch_names, basis.tangential_share.tolist(), strict=True)
    return [
        {
            "patch": name,
            "normal": ", ".join(f"{x:.3g}" for x in study.patch_normal(name) or ()),
            "angles": ", ".join(f"{angle:.0f}°" for angle in study.gravity_angles(name)) or "–",
            "share": share,
        }
        for name, share in shares
    ]


def is_papers_panel(modes: pd.DataFrame, printed: pd.DataFrame) -> bool:
    """Return whether closed form and printed table are of one panel."""
    if "navier_hz" not in modes:
        return False
    merged = printed.merge(modes, on=["m", "n"], suffixes=("_printed", ""))
    if len(merged) < len(printed):
        return False
    deviation = np.abs(merged["navier_hz"] / merged["frequency_hz_printed"] - 1)
    return bool((deviation < PRINTED_ROUNDING).all())


def _mode_values(modes: pd.DataFrame, printed: pd.DataFrame | None) -> dict[str, Any]:
    """Return all modes, with orders, closed forms and printed frequencies if they have any."""
    if printed is None:
        return {"modes": records(modes), "printed": None}
    modes = modes.merge(printed, on=["m", "n"], suffixes=("", "_printed"), how="left")
    off = 100 * (modes["frequency_hz"] / modes["frequency_hz_printed"] - 1)
    # to the next hundred above the last printed frequency
    limit = 100 * math.ceil(printed["frequency_hz"].max() / 100)
    missing = modes["frequency_hz_printed"].isna() & (modes["frequency_hz"] < limit)
    about = {"count": len(printed), "off": off.abs().max(), "missing": missing.sum()}
    return {"modes": records(modes.assign(off_percent=off)), "printed": {**about, "limit": limit}}


def _title(row: dict[str, Any]) -> str:
    order = f" ({row['m']}, {row['n']})," if "m" in row else ""
    return f"{row['mode']}:{order} {row['frequency_hz']:.2f} Hz"


def turned_surface(basis: PanelBasis) -> str | None:
    """Return a surface in space as JSON for the view that turns, in a sphere of diameter 1."""
    vertices, cells = basis.vertex_position, basis.cells
    if len(cells) > TURNED_CELLS:
        return None
    middle = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    diameter = 2 * np.linalg.norm(vertices - middle, axis=1).max()
    places = [(part - middle) / diameter for part in (vertices, basis.point_position)]
    looks, look = np.unique(_cell_colours(basis), axis=0, return_inverse=True)
    parts = {
        "vertices": places[0].round(4).tolist(),
        "cells": cells.tolist(),
        "colours": [to_hex(colour) for colour in looks],
        "colour": look.ravel().tolist(),
        "points": dict(zip(basis.point_names, places[1].round(4).tolist(), strict=True)),
    }
    return json.dumps(parts, separators=(",", ":")).replace("<", "\\u003c")


def _cell_colours(basis: PanelBasis) -> Array:
    """Return the colours (n_cells, 3) of elements, by patch."""
    colours = np.full((len(basis.cells), 3), 0.93)
    for name, inside in zip(basis.patch_names, basis.cell_in_patch, strict=True):
        colours[inside] = to_rgb(style.place_colour(name, basis.patch_names))
    return colours


def views_figure(basis: PanelBasis) -> Figure:
    """Draw a surface in space from three sides, with its patches and points."""
    vertices, cells = basis.vertex_position, basis.cells
    size, colours = np.ptp(vertices, axis=0), _cell_colours(basis)
    views = ((0, 1, 2), (0, 2, 1), (1, 2, 0))  # to the right, up, and towards the eye or from it
    widths = [max(size[right], 0.1 * size.max()) for right, *_ in views]
    height = WIDTH / sum(widths) * max(size[1], size[2]) + 0.6
    figure = Figure(figsize=(WIDTH, min(height, 6.0)), layout="constrained")
    panes = figure.subplots(1, 3, gridspec_kw={"width_ratios": widths})
    for axes, (right, up, depth) in zip(panes, views, strict=True):
        towards = -1.0 if depth == 1 else 1.0  # one looks along +y, or against z and x
        order = np.argsort(towards * vertices[cells, depth].mean(axis=1))
        corners = vertices[cells[order]][..., [right, up]]
        look: dict[str, Any] = {"edgecolors": "#777777", "linewidths": 0.25}
        axes.add_collection(PolyCollection(list(corners), facecolors=colours[order], **look))
        for name, place in zip(basis.point_names, basis.point_position, strict=True):
            axes.plot(place[right], place[up], "o", color="white", mec="black", ms=4)
            axes.annotate(name, (place[right], place[up]), (3, 3), textcoords="offset points")
        axes.set(xlabel=f"{'xyz'[right]}, m", ylabel=f"{'xyz'[up]}, m", aspect="equal")
        axes.autoscale_view()
    return figure


def shapes_figure(basis: PanelBasis, titles: Sequence[str]) -> Figure:
    """Draw the first shapes of a basis as the deflected panel, coloured from −1 to 1.

    Lines are the edges of the panel and of its patches, dots the response points.
    """
    vertices, cells = basis.vertex_position, basis.cells
    edges = [cells, *(cells[inside] for inside in basis.cell_in_patch)]
    lines = np.concatenate([boundary_edges(part) for part in edges])
    rows = -(-len(titles) // 3)
    picture = (WIDTH - 0.9) / 3 * 400 / 660
    height = rows * (picture + 0.3)
    figure = Figure(figsize=(WIDTH, height))
    room = {"left": 0.0, "right": 1.0, "bottom": 0.0, "top": 1 - 0.3 / height, "wspace": 0.02}
    axes_grid = figure.subplots(
        rows, 3, squeeze=False, gridspec_kw={**room, "hspace": 0.3 / picture}
    )
    grid = axes_grid.ravel().tolist()
    for axes in grid:
        axes.set_axis_off()
    size, middle = np.ptp(vertices, axis=0), (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    distance = np.linalg.norm(vertices[:, None] - basis.point_position, axis=-1)
    half = 0.5 * SPREAD * float(np.hypot(*size))
    for axes, shape, title in zip(grid, basis.shape_at_vertices.T, titles, strict=False):
        scaled = shape / shape[np.abs(shape).argmax()]
        place = np.column_stack([vertices - middle, LIFT * float(size.min()) * scaled]) @ SEEN.T
        drawn = draw_field(axes, place, cells, scaled, "RdBu_r", (-1.0, 1.0))
        axes.add_collection(LineCollection(list(place[lines]), colors="black", linewidths=0.6))
        axes.plot(*place[distance.argmin(axis=0)].T, "o", color="black", ms=2.2)
        axes.set_title(title, fontsize=8)
        axes.set_aspect("equal")
        axes.set_xlim(-1.65 * half, 1.65 * half)
        axes.set_ylim(-half, half)
    look: dict[str, Any] = {"shrink": 0.75, "pad": 0.02, "aspect": 30}
    add_colour_bar(figure, drawn, figure.axes, "deflection over its\nlargest value, –", **look)
    return figure
