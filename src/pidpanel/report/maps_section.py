"""Maps on the page: rms acceleration and rms von Mises stress of some scenarios."""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from pidpanel.arrays import Array, Flags
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.layout import add_colour_bar, draw_field, outline_curves, panel_axes

# Fields drawn: label with unit, factor from SI to that unit, colour map.
FIELD_STYLES = {
    "acceleration_rms": ("rms acceleration, g", 1 / STANDARD_GRAVITY, "viridis"),
    "von_mises_rms": ("rms von Mises stress, MPa", 1e-6, "magma"),
}

ACROSS = 2  # maps side by side

EXCEEDED_SHARE = 0.01  # share of the area that lies beyond the end of the colour scale


def case_titles(maps: xr.Dataset, names: Mapping[str, str]) -> list[str]:
    """Return the titles of the cases of maps, which are scenarios."""
    return [names[str(label)] for label in maps["scenario"].to_numpy()]


def maps_section(maps: xr.Dataset, cell_in_patch: Flags, names: Mapping[str, str]) -> PageSection:
    """Return the maps of rms acceleration and stress."""
    titles = case_titles(maps, names)
    drawn = fields_of(maps)
    values = {
        "maps": figure_picture("maps", map_figure, maps, cell_in_patch, titles, styles=drawn),
        "layers": maps["layer"].to_numpy().tolist() if "layer" in maps else [],
        "exceeded_share": EXCEEDED_SHARE,
    }
    return template_section("maps.html", "Maps", values)


def fields_of(*maps: xr.Dataset) -> dict[str, tuple[str, float, str]]:
    """Return the looks of the fields that all maps have; modes from a file have no stress."""
    return {name: look for name, look in FIELD_STYLES.items() if all(name in each for each in maps)}


def map_figure(
    maps: xr.Dataset,
    cell_in_patch: Flags,
    titles: Sequence[str],
    tops: Mapping[str, float] | None = None,
    styles: Mapping[str, tuple[str, float, str]] = FIELD_STYLES,
) -> Figure:
    """Draw the cases side by side, in rows of `ACROSS`; all maps of a field have one scale."""
    tops = tops or scale_ends(maps, styles)
    position, cells = maps["vertex_position"].to_numpy(), maps["cells"].to_numpy().astype(np.int64)
    edges = [line for members in cell_in_patch for line in outline_curves(position, cells[members])]
    outline = outline_curves(position, cells)
    length, width = np.ptp(position, axis=0)
    across = min(ACROSS, len(titles))
    rows = -(-len(titles) // across)
    height = min(4.5, 3.6 * width / length) + 0.6
    figure = Figure(figsize=(1.0 + 4.5 * across, height * rows * len(styles)), layout="constrained")
    grid = figure.subplots(rows * len(styles), across, squeeze=False)
    for unused in grid.reshape(len(styles), -1)[:, len(titles) :].flat:
        unused.remove()
    for axes_row, (name, (label, factor, colours)) in zip(
        grid.reshape(len(styles), -1), styles.items(), strict=True
    ):
        fields = maps[name].max("layer") if "layer" in maps[name].dims else maps[name]
        drawn = []
        for axes, title, field in zip(axes_row, titles, fields.to_numpy(), strict=False):
            drawn.append(
                draw_field(axes, position, cells, field * factor, colours, (0.0, tops[name]))
            )
            axes.add_collection(PolyCollection(outline, facecolors="white"))
            axes.add_collection(LineCollection(edges, color="white", linewidth=0.8))
            panel_axes(axes, position, 0.0)
            axes.set_title(title)
        add_colour_bar(figure, drawn[0], axes_row[: len(titles)].tolist(), label, shrink=0.8)
    return figure


def scale_ends(
    maps: xr.Dataset, styles: Mapping[str, tuple[str, float, str]] = FIELD_STYLES
) -> dict[str, float]:
    """Return the end of the colour scale of each field, in its unit there."""
    position, cells = maps["vertex_position"].to_numpy(), maps["cells"].to_numpy().astype(np.int64)
    area = np.abs(cell_areas(position, cells))
    return {
        name: _exceeded_by(_on_cells(maps, name) * factor, area)
        for name, (_, factor, _) in styles.items()
    }


def _on_cells(maps: xr.Dataset, name: str) -> Array:
    """Return a field (n_cases, n_cells) on the elements, of the most stressed layer."""
    worst = maps[name].max("layer") if "layer" in maps[name].dims else maps[name]
    return worst.to_numpy()[:, maps["cells"].to_numpy().astype(np.int64)].mean(axis=2)


def _exceeded_by(values: Array, area: Array) -> float:
    """Return the value that `EXCEEDED_SHARE` of the area exceeds, the largest of several maps."""
    tops = []
    for field in values:
        order = np.argsort(field)
        cumulated = np.cumsum(area[order]) / area.sum()
        tops.append(field[order][np.searchsorted(cumulated, 1 - EXCEEDED_SHARE)])
    return float(max(tops))
