"""Figures of the answer: the panel with its worst map, and reductions against mass.

Functions return a `matplotlib.figure.Figure`; call them within `style.context`. They are narrow, so
that their text can be read where a page is as wide as a telephone.
"""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import shapely
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation

from pidpanel.arrays import Array
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.supports import Supports
from pidpanel.report import style
from pidpanel.report.answer import Candidate, StudyAnswer
from pidpanel.report.layout import (
    add_colour_bar,
    add_legend,
    draw_field,
    figure_of_axes,
    outline_curves,
    panel_axes,
    separate,
)
from pidpanel.report.text import number, records
from pidpanel.structure.any_structure import AnyStructure
from pidpanel.structure.from_study import AnyPanel

WIDTH = 5.0  # width of a figure at the head of a page [inch]

_HALO = [withStroke(linewidth=2.2, foreground="white")]
# Looks of names on the panel: of points and patches, and of what holds or loads it.
_NAME: dict[str, Any] = {"textcoords": "offset points", "path_effects": _HALO, "zorder": 10}
_BOLD = {**_NAME, "fontweight": "bold", "fontsize": 8.5}
_SMALL = {**_NAME, "fontsize": 7, "ha": "center"}
_SUPPORT = {
    "hinge": ("^", "hinge"),
    "hold_down": ("s", "hold-down"),
    "spring": ("P", "spring to ground"),
}
_EDGE = {
    "simply_supported": ("#000000", 2.6, "-", "simply supported edge"),
    "simply_supported_soft": ("#000000", 2.6, (0, (4, 1)), "simply supported edge (soft)"),
    "clamped": ("#8c1515", 3.4, "-", "clamped edge"),
    "free": ("#555555", 0.9, "-", "free edge"),
    "edge": ("#555555", 0.9, "-", "edge"),
}


def panel_figure(
    basis: PanelBasis,
    panel: AnyPanel,
    rms: Array | None,
    layout: pd.DataFrame | None = None,
) -> Figure:
    """Draw outline, supports, masses, patches and points over a map of rms acceleration.

    ``rms``: (n_vertices,) [g]; None for no map. ``layout``: rows of ``optimise/layouts.csv`` in
    place of the patches of the study.
    """
    vertices, cells = basis.vertex_position, basis.cells
    size = np.ptp(vertices, axis=0)
    height = min(7.0, (WIDTH - 1.35) * size[1] / size[0] + 1.15)
    figure, (axes,) = figure_of_axes(1, 1, height, 0.0, WIDTH)
    names: list[Annotation] = []
    if rms is not None:
        mapped = draw_field(axes, vertices, cells, rms, "YlOrRd", (0.0, float(rms.max())))
        look: dict[str, Any] = {"shrink": 0.8, "pad": 0.02, "aspect": 25}
        add_colour_bar(figure, mapped, [axes], "g rms", **look)
        worst = vertices[int(rms.argmax())]
        axes.plot(
            *worst, "*", color="#111111", ms=11, mec="white", mew=0.8, clip_on=False, zorder=9,
            label=f"largest, {rms.max():.3g} g rms",
        )  # fmt: skip
    _edges(axes, basis, panel.supports)
    names += _patches(axes, basis) if layout is None else _fillings(axes, layout)
    names += _attachments(axes, panel)
    if isinstance(panel, AnyStructure):
        _held_parts(axes, panel)
    for name, (x, y) in zip(basis.point_names, basis.point_position.tolist(), strict=True):
        axes.plot(
            x, y, "o", color="white", mec="black", ms=5, mew=1.2, zorder=8, label="response point"
        )
        names.append(axes.annotate(name, (x, y), (4, 4), va="bottom", **_BOLD))
    panel_axes(axes, vertices, 0.025)
    axes.spines[:].set_visible(False)
    add_legend(figure, 3)
    supports = panel.supports.points.values()
    marked = [*basis.point_position, *(support.position for support in supports)]
    if rms is not None:
        marked.append(vertices[int(rms.argmax())])
    marked += itertools.chain.from_iterable(item.ends for item in panel.attachments.values())
    separate(figure, names, marked)
    return figure


def _patches(axes: Axes, basis: PanelBasis) -> list[Annotation]:
    vertices, cells, names = basis.vertex_position, basis.cells, []
    for name, inside in zip(basis.patch_names, basis.cell_in_patch, strict=True):
        colour = style.place_colour(name, basis.patch_names)
        lines = outline_curves(vertices, cells[inside])
        axes.add_collection(LineCollection(lines, colors="white", linewidths=3.0, zorder=4))
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=1.8, zorder=5))
        places = np.concatenate(lines)
        low, high = places.min(axis=0), places.max(axis=0)
        below = (low[0] + high[0]) / 2, low[1]
        names.append(axes.annotate(
            name, below, (0, -2), color=colour, ha="center", va="top", **_BOLD
        ))  # fmt: skip
    return names


def _fillings(axes: Axes, layout: pd.DataFrame) -> list[Annotation]:
    names, dampers = [], sorted(set(layout["damper"]))
    for row in records(layout):
        x, y, across, up = (
            row[f"{name}_m"] for name in ("centre_x", "centre_y", "size_x", "size_y")
        )
        colour, low = style.place_colour(row["damper"], dampers), y - up / 2
        axes.add_patch(Rectangle((x - across / 2, low), across, up, color=colour, alpha=0.35))
        share = f" {100 * row['fill_fraction']:g} %" if np.isfinite(row["fill_fraction"]) else ""
        text = f"{row['damper']}{share}\n{number(row['mass_kg'])} kg"
        names.append(axes.annotate(text, (x, low), (0, -2), va="top", color=colour, **_SMALL))
    return names


def _attachments(axes: Axes, panel: AnyPanel) -> list[Annotation]:
    names = []
    places = {name: (s.position, s.kind) for name, s in panel.supports.points.items()}
    springs = {name: a for name, a in panel.attachments.items() if a.stiffness}
    places |= {name: (spring.ends[0], "spring") for name, spring in springs.items()}
    for name, (position, kind) in places.items():
        marker, word = _SUPPORT[kind]
        axes.plot(
            *position, marker, color="#1a1a1a", ms=6, mec="white", mew=0.8, zorder=6, label=word
        )
        look = {**_SMALL, "color": "#1a1a1a", "va": "bottom"}
        names.append(axes.annotate(name, position, (0, 5), **look))
    for name, mass in panel.attachments.items():
        if name in springs:
            continue
        along = np.array(mass.ends)
        axes.plot(
            *along.T, "D-", color="#5b2a86", ms=4.5, lw=2, mec="white", mew=0.6, zorder=6,
            label="mass",
        )  # fmt: skip
        x, y = along.mean(axis=0)
        look = {**_SMALL, "color": "#5b2a86", "va": "top"}
        names.append(axes.annotate(name, (x, y), (0, -4), **look))
    return names


def _held_parts(axes: Axes, structure: AnyStructure) -> None:
    """Draw stiffeners, supports, feet and masses of a structure."""
    if len(lines := structure.stiffener_lines):
        look: dict[str, Any] = {"colors": "#5b2a86", "linewidths": 2.0, "linestyles": "dotted"}
        axes.add_collection(LineCollection(list(lines), label="stiffener", zorder=4, **look))
    dots = [shapely.get_coordinates(part) for part in structure.obstacles]
    if dots:
        x, y = np.concatenate(dots).T
        axes.plot(x, y, "s", color="#8c1515", ms=2, zorder=6, label="support, foot or mass")


def _edges(axes: Axes, basis: PanelBasis, supports: Supports) -> None:
    """Draw the outline and, a little wider, the edges with supports of their own."""
    outline = outline_curves(basis.vertex_position, basis.cells)
    # elements have chords: what is between them and a round hole is no surface
    axes.add_collection(PolyCollection(outline, facecolors="white", zorder=2))
    edges = [([np.array([edge.start, edge.end])], edge.kind, 0.6) for edge in supports.edges]
    for lines, kind, wider in ((outline, supports.outline, 0.0), *edges):
        colour, width, dashes, word = _EDGE[kind]
        axes.add_collection(LineCollection(
            lines, colors=colour, linewidths=width + wider, linestyles=[dashes], zorder=3,
            label=word,
        ))  # fmt: skip


def mass_figure(
    answer: StudyAnswer, with_mass: Sequence[Candidate], colours: Mapping[str, str]
) -> Figure:
    """Draw reduction against mass with error bars, and what the same mass does as dead weight.

    Colours are by `group_of` the candidates.
    """
    figure, (axes,) = figure_of_axes(1, 1, 3.7, 0.0, WIDTH)
    handles: dict[str, Line2D] = {}
    names = []
    drawn: list[tuple[float, float]] = []  # points, error bars
    responses = [answer.response(candidate) for candidate in with_mass]
    for candidate, response in zip(with_mass, responses, strict=True):
        group, mass = group_of(candidate), candidate.mass
        look: dict[str, Any] = {"color": colours[group], "marker": "o", "ls": ""}
        error = response.reduction_error if np.isfinite(response.reduction_error) else None
        axes.errorbar(mass, response.reduction, yerr=error, ms=5, capsize=3, elinewidth=1.2, **look)
        handles[group] = Line2D([], [], **look)
        bar = np.linspace(-1.0, 1.0, 25) * (error or 0.0)
        drawn += [(mass, y) for y in (response.reduction + bar).tolist()]
        if np.isfinite(response.dead_weight):
            axes.plot(mass, response.dead_weight, ms=4.5, mfc="white", **look)
            drawn.append((mass, response.dead_weight))
        fill = candidate.scenario.fill_fraction
        # colours tell dampers apart
        name = group if np.isnan(fill) else f"{candidate.scenario.patch}, r = {fill:g}"
        look = {"fontsize": 7.5, "color": colours[group], **_NAME}
        names.append(axes.annotate(name, (mass, response.reduction), (6, 3), **look))
    if any(np.isfinite(response.dead_weight) for response in responses):
        look = {"color": "#555555", "marker": "o", "mfc": "white", "ls": ""}
        handles["same mass, no damping"] = Line2D([], [], **look)
    if any(np.isfinite(response.reduction_error) for response in responses):
        handles["± one standard error"] = Line2D([], [], color="#555555", marker="|", ms=8, ls="")
    axes.axhline(0.0, color="black", lw=0.8)
    axes.set_xlim(left=0.0, right=1.28 * max(candidate.mass for candidate in with_mass))
    axes.set(xlabel="mass of the dampers, kg", ylabel=f"reduction at point {answer.worst}, dB")
    add_legend(figure, 3, handles)
    separate(figure, names, drawn)
    return figure


def group_of(candidate: Candidate) -> str:
    """Return what scenarios of one colour have in common: the place, or the layout."""
    scenario = candidate.scenario
    is_single = len(scenario.fillings) == 1
    return ", ".join(scenario.place(*scenario.patches)) if is_single else scenario.layout_label
