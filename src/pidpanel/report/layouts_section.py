"""Layouts on the page: their PSDs beside those of the same mass as dead weight."""

import itertools
from collections.abc import Sequence

import numpy as np

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve, PageSection, Picture, template_section
from pidpanel.report.inputs import Inputs
from pidpanel.report.names import Scenario, layouts_of
from pidpanel.report.response_figures import PSD_UNIT, chart_picture, nested_width
from pidpanel.report.rms import inside_of, psd_curve
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
    return template_section("layouts.html", "Layouts", {"points": points})


def _psd_picture(
    inputs: Inputs, reading: str, scenarios: Sequence[Scenario], point: str, name: str
) -> Picture:
    """Return PSDs of the bare panel, of layouts and of their dead weights at a point."""
    place = {"reading": reading, "point": point}
    bare = dict.fromkeys(s.bare.label for s in scenarios)
    curves = []
    for label in bare:
        name_of = "bare panel" if len(bare) == 1 else label
        curves.append(psd_curve(inputs.psd, {**place, "scenario": label}, name_of, style.BARE, 0.8))
    labels = [layout.label for layout in layouts_of(inputs.study)]
    colours = dict(zip(labels, itertools.cycle(style.PLACES), strict=False))
    dead, treated = [], []
    for index, scenario in enumerate(scenarios):
        label, colour = scenario.label, colours[scenario.label]
        of_case = {**place, "scenario": label}
        dead_psd = inputs.psd["dead_weight_acceleration_psd"].sel(of_case)
        weight = dead_psd.to_numpy() / STANDARD_GRAVITY**2
        if np.isfinite(weight).all():
            dead.append(
                PageCurve(f"{label}: dead weight", weight, style.pale(colour), "dotted", 1.0)
            )
        width = nested_width(index, len(scenarios))
        # a band of one curve hides nothing; those of several would
        has_band = len(scenarios) == 1
        treated.append(psd_curve(inputs.psd, of_case, label, colour, width, has_band=has_band))
    frequency = inputs.psd["frequency"].to_numpy()
    chart = Chart(READINGS[reading], frequency, PSD_UNIT, [*curves, *dead, *treated])
    return chart_picture(name, [chart])
