"""Maps on the page: rms acceleration and rms von Mises stress of some scenarios."""

from collections.abc import Mapping

import xarray as xr

from pidpanel.arrays import Flags
from pidpanel.report import style
from pidpanel.report.html import PageSection, Picture
from pidpanel.report.maps_figures import EXCEEDED_SHARE, map_figure
from pidpanel.report.text import READINGS, percent


def case_titles(maps: xr.Dataset, names: Mapping[str, str]) -> dict[tuple[str, str], str]:
    """Return the titles of the cases of maps by damping model and scenario."""
    cases = zip(maps["reading"].to_numpy(), maps["scenario"].to_numpy(), strict=True)
    return {
        (str(reading), str(label)): (
            names[str(label)]
            if str(label).startswith("bare")
            else f"{names[str(label)]}\n{READINGS[str(reading)]}"
        )
        for reading, label in cases
    }


def maps_section(maps: xr.Dataset, cell_in_patch: Flags, names: Mapping[str, str]) -> PageSection:
    """Return the maps of rms acceleration and stress."""
    layers = ", ".join(str(name) for name in maps["layer"].to_numpy())
    figure = map_figure(maps, cell_in_patch, case_titles(maps, names))
    caption = (
        "Rms values over the frequency range of the response (response.maps; numbers in "
        "response/maps.nc, for ParaView in response/maps/maps.pvd). The von Mises stress is "
        f"its root mean square, the largest of the layers ({layers}). White: edges of the "
        f"patches. The colour scale ends at the value that {percent(EXCEEDED_SHARE)} of the area "
        "exceeds, because plate theory has unbounded stress at re-entrant corners and point "
        "supports."
    )
    return PageSection("maps", "Maps", [Picture("maps", style.png(figure), caption)])
