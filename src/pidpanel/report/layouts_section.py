"""Layouts on the page: their PSDs beside those of the same mass as dead weight."""

import itertools
from collections.abc import Sequence

import numpy as np

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.html import Chart, Fragment, PageCurve, PageSection, Picture
from pidpanel.report.inputs import Inputs
from pidpanel.report.names import Scenario, layouts_of
from pidpanel.report.response_figures import PSD_UNIT, chart_picture, nested_width
from pidpanel.report.rms import inside_of, log_error_of
from pidpanel.report.text import READINGS
from pidpanel.response.psd_files import is_steady

DRAWN_TOGETHER = 6  # layouts in one figure at most: as many as there are colours without an order


def layouts_section(inputs: Inputs) -> PageSection:
    """Return the PSDs of the explicit layouts and of their dead weights at every point."""
    study = inputs.study
    points = []
    for point in inputs.moving_points:
        psds = []
        for reading in study.readings:
            drawn = [s for s in layouts_of(study) if is_steady(inputs.psd, reading, s.label)]
            for first in range(0, len(drawn), DRAWN_TOGETHER):
                part = drawn[first : first + DRAWN_TOGETHER]
                name = f"psd_layouts_{reading}_{first // DRAWN_TOGETHER + 1}_{point}"
                inside = [inside_of(inputs.psd, reading, scenario.label) for scenario in part]
                psds.append(
                    {
                        "picture": _psd_picture(inputs, reading, part, point, name),
                        "has_band": len(part) == 1,
                        "is_dashed": not np.all(inside),
                    }
                )
        if psds:
            points.append([point, psds])
    fragment = Fragment("layouts.html", {"points": points})
    return PageSection("layouts", "Layouts", [fragment])


def _psd_picture(
    inputs: Inputs, reading: str, scenarios: Sequence[Scenario], point: str, name: str
) -> Picture:
    """Return PSDs of the bare panel, of layouts and of their dead weights at a point."""
    selected = inputs.psd.sel(reading=reading, point=point)
    psd, dead_psd = (
        selected[f"{name}acceleration_psd"] / STANDARD_GRAVITY**2 for name in ("", "dead_weight_")
    )
    bare = dict.fromkeys(s.bare.label for s in scenarios)
    curves = [
        PageCurve(
            "bare panel" if len(bare) == 1 else label,
            psd.sel(scenario=label).to_numpy(),
            style.BARE,
            width=0.8,
        )
        for label in bare
    ]
    labels = [layout.label for layout in layouts_of(inputs.study)]
    colours = dict(zip(labels, itertools.cycle(style.PLACES), strict=False))
    dead, treated = [], []
    for index, scenario in enumerate(scenarios):
        label, colour = scenario.label, colours[scenario.label]
        weight = dead_psd.sel(scenario=label).to_numpy()
        if np.isfinite(weight).all():
            dead.append(
                PageCurve(f"{label}: dead weight", weight, style.pale(colour), "dotted", 1.0)
            )
        treated.append(
            PageCurve(
                label,
                psd.sel(scenario=label).to_numpy(),
                colour,
                width=nested_width(index, len(scenarios)),
                # a band of one curve hides nothing; those of several would
                log_error=log_error_of(inputs.psd, reading, label, point)
                if len(scenarios) == 1
                else None,
                inside=inside_of(inputs.psd, reading, label),
            )
        )
    frequency = inputs.psd["frequency"].to_numpy()
    chart = Chart(READINGS[reading], frequency, PSD_UNIT, [*curves, *dead, *treated])
    return chart_picture(name, [chart])
