"""Maps of the panel: rms acceleration and rms von Mises stress of some scenarios."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from pidpanel.arrays import Array, Flags, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.plane_mesh import boundary_edges, cell_areas
from pidpanel.report import style
from pidpanel.report.html import Picture, Section

SHOWN = {
    "acceleration_rms": ("rms acceleration, g", 1 / STANDARD_GRAVITY, "viridis"),
    "von_mises_rms": ("rms von Mises stress, MPa", 1e-6, "magma"),
}
"""Maps drawn, with their units as read, the factor to them and their colours."""

BEYOND = 0.01
"""Share of the area beyond the end of the colours."""


def patch_edges(cells: Index, cell_in_patch: Flags) -> Index:
    """Vertex numbers (n, 2) of the edges round the patches: those of one cell of a patch only.

    Examples
    --------
    >>> two = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    >>> len(patch_edges(two, np.array([[True, True]])))
    6
    """
    around = []
    for members in cell_in_patch:
        around.append(boundary_edges(cells[members]))
    return np.concatenate([np.zeros((0, 2), dtype=np.int64), *around])


def map_figure(
    maps: xr.Dataset,
    cell_in_patch: Flags,
    titles: Mapping[tuple[str, str], str],
) -> Figure:
    """A row for each case, a column for each of `SHOWN`; one scale of colour a column.

    Parameters
    ----------
    maps
        ``response/maps.nc``; of several layers the most stressed at each vertex is drawn.
    cell_in_patch
        (n_patches, n_cells) the cells of each patch.
    titles
        (reading, scenario) → what the case is called.
    """
    position = maps["vertex_position"].to_numpy()
    cells = maps["cells"].to_numpy().astype(np.int64)
    area = np.abs(cell_areas(position, cells))
    corners, edges = position[cells], position[patch_edges(cells, cell_in_patch)]
    length, width = np.ptp(position, axis=0)
    count = maps.sizes["case"]
    height = 2.6 * width / length + 0.75
    figure, axes = plt.subplots(
        count, len(SHOWN), figsize=(7.4, height * count), squeeze=False, layout="constrained"
    )
    for column, (name, (label, factor, colours)) in enumerate(SHOWN.items()):
        worst = maps[name].max("layer") if "layer" in maps[name].dims else maps[name]
        values = worst.to_numpy()[:, cells].mean(axis=2) * factor
        top = _exceeded_by(values, area)
        for row in range(count):
            ax = axes[row, column]
            drawn = PolyCollection(
                list(corners), array=values[row], cmap=colours, edgecolors="face"
            )
            drawn.set_clim(0.0, top)
            drawn.set_linewidth(0.2)
            ax.add_collection(drawn)
            ax.add_collection(LineCollection(list(edges), color="white", linewidth=0.8))
            ax.set_aspect("equal")
            ax.set_xlim(position[:, 0].min(), position[:, 0].max())
            ax.set_ylim(position[:, 1].min(), position[:, 1].max())
            ax.grid(False)
            case = (str(maps["reading"].to_numpy()[row]), str(maps["scenario"].to_numpy()[row]))
            ax.set_title(titles[case])
            ax.set_ylabel("y, m" if column == 0 else "")
            ax.set_xlabel("x, m" if row == count - 1 else "")
        figure.colorbar(drawn, ax=axes[:, column].tolist(), label=label, shrink=0.8, extend="max")
    return figure


def _exceeded_by(values: Array, area: Array) -> float:
    """The value that `BEYOND` of the area exceeds, of several maps (n, n_cells) the largest."""
    tops = []
    for one in values:
        order = np.argsort(one)
        below = np.cumsum(area[order]) / area.sum()
        tops.append(one[order][np.searchsorted(below, 1 - BEYOND)])
    return float(max(tops))


def map_section(maps: xr.Dataset, cell_in_patch: Flags, names: Mapping[str, str]) -> Section:
    """The maps of a study.

    Parameters
    ----------
    maps, cell_in_patch
        As of `map_figure`.
    names
        What each reading is called.
    """
    cases = zip(maps["reading"].to_numpy(), maps["scenario"].to_numpy(), strict=True)
    titles = {
        (str(reading), str(label)): (
            "bare panel" if str(label).startswith("bare") else f"{label}\n{names[str(reading)]}"
        )
        for reading, label in cases
    }
    layers = ", ".join(str(name) for name in maps["layer"].to_numpy())
    figure = map_figure(maps, cell_in_patch, titles)
    caption = (
        "Rms over the frequencies looked at, all over the panel (response.maps; numbers in "
        "response/maps.nc, for ParaView response/maps/maps.pvd). The von Mises stress is the root "
        f"of the mean of its square, the largest of the layers ({layers}). White: patches. Colours "
        f"end where {BEYOND:.0%} of the area is beyond: at a re-entrant corner or a point support "
        "the stress of plate theory has no bound."
    )
    return Section("maps", "Maps", [Picture("maps", style.png(figure), caption)])
