"""The page of an identification: the particles, measured values and those of the atlas."""

from __future__ import annotations

import math
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.atlas_files import version_text
from pidpanel.identify.from_study import IdentificationResult, summary
from pidpanel.identify.posterior import Posterior
from pidpanel.provenance import durable
from pidpanel.report import style
from pidpanel.report.html import Fragment, Page, PageSection, figure_picture, render
from pidpanel.report.layout import figure_of_axes, frequency_axis, log_scale
from pidpanel.report.templates import lines
from pidpanel.report.text import records

NAMES = {
    "restitution": "restitution e",
    "friction": "friction μ",
    "fill_fraction": "fill fraction r",
}
REGIONS = (0.9, 0.5)  # shares of the posterior within the drawn regions
PROPOSED = 8  # further tones in the table


def answer_of(result: IdentificationResult) -> list[str]:
    """Return e, μ and r, the fit, the limitations and the next tone, each in a sentence."""
    tones = _further(result)
    values = {
        "result": result,
        "rows": records(summary(result.posterior)),
        "further": max(tones, key=itemgetter("information_nat"), default=None),
    }
    return lines("identify_answer.html", values)


def answer_lines(result: IdentificationResult) -> list[str]:
    """Return the answer in lines, the particles first if they explain the measurement."""
    *particles, fit = (answer := answer_of(result))[:4]
    first = [*particles, fit] if result.posterior.is_explained else [fit, *particles]
    return [*first, *answer[4:]]


def _further(result: IdentificationResult) -> list[dict[str, Any]]:
    """Return the further tones, each with its stroke [mm]."""
    tones = result.further
    acceleration = 1e3 * tones["acceleration_g"] * STANDARD_GRAVITY
    return records(tones.assign(stroke=acceleration / (2 * math.pi * tones["frequency_hz"]) ** 2))


def write_identification(result: IdentificationResult, file: Path) -> None:
    """Write the page."""
    durable.write_text(file, render(identification_page(result)))


def identification_page(result: IdentificationResult) -> Page:
    """Return the page."""
    identification, posterior = result.identification, result.posterior
    e, friction, fill, fit, *limitations, next_tone = answer_of(result)
    cell, particles = identification.coupon.cell, identification.coupon.particles
    rows = [{**row, "name": NAMES[row["parameter"]]} for row in records(summary(posterior))]
    first = {
        "particles": rows,
        "correlation": posterior.correlation[0, 1],
        "posterior": figure_picture("posterior", posterior_figure, posterior),
        "measured": figure_picture("measured", measured_figure, result.predictions),
    }
    tones = sorted(_further(result), key=itemgetter("information_nat"), reverse=True)[:PROPOSED]
    proposed = Fragment("identify_next.html", {"line": next_tone, "tones": tones})
    values = Fragment("identify_values.html", {"tones": records(result.predictions)})
    size = f"{particles.diameter_mm:g} mm, {particles.density_kg_m3:g} kg/m³"
    return Page(
        title=identification.title or f"Particles of {identification.name}",
        answer=f"{e}, {friction}, {fill}. {fit}",
        first=[Fragment("identify_first.html", first)],
        caveats=limitations,
        facts=[
            ("measurement", identification.measured.file.name),
            ("cell", f"hexagon, {cell.across_flats_mm:g} mm × {cell.depth_mm:g} mm"),
            ("particles", size),
            ("atlas", version_text(result.atlas)),
        ],
        sections=[
            PageSection("next", "Further tests", [proposed]),
            PageSection("values", "Measured and computed", [values]),
        ],
        steps=[("In the folder of the file:", f"pidpanel identify {identification.name}.yaml")],
    )


def posterior_figure(posterior: Posterior) -> Figure:
    """Draw the regions of e and μ with some shares of the posterior."""
    figure, (axes,) = figure_of_axes(1, 1, 3.4, 0.0, 4.6)
    e, log_friction, _ = posterior.axes
    share = posterior.weights.sum(axis=2)
    density = share / share.max()
    friction = np.exp(log_friction)
    # a region that is a single point has the level 1 of the mode
    levels = np.unique([*(_level(share, region) / share.max() for region in REGIONS), 1.0])
    if min(density.shape) > 1 and len(levels) > 1:
        colours = ["#9ecae1", "#3182bd"][: len(levels) - 1]
        axes.contourf(e, friction, density.T, levels=levels, colors=colours)
    axes.plot(posterior.best[0], math.exp(posterior.best[1]), "o", color="black", ms=5)
    log_scale(axes)
    axes.set(xlabel="restitution e", ylabel="friction μ")
    return figure


def _level(share: Array, region: float) -> float:
    """Return the weight above which points together have a share of the posterior."""
    ordered = np.sort(share.ravel())[::-1]
    place = int(np.searchsorted(np.cumsum(ordered), region * ordered.sum()))
    return float(ordered[min(place, len(ordered) - 1)])


def measured_figure(predictions: pd.DataFrame) -> Figure:
    """Draw C_e measured and of the atlas over frequency, and their differences."""
    grid = figure_of_axes(2, 1, 2.2, 0.0, 5.6, height_ratios=(3, 1), sharex=True)
    figure, (values, differences) = grid
    levels = sorted(predictions["acceleration_g"].round(3).unique())
    for level, rows in predictions.groupby(predictions["acceleration_g"].round(3)):
        colour = style.level_colour(float(level), levels)
        for kind, shift, face in (("measured", 1.0, colour), ("atlas", 1.02, "white")):
            x, y = shift * rows["frequency_hz"], rows[f"{kind}_equivalent_damping_n_s_m3"]
            errors = rows[f"{kind}_equivalent_damping_error_n_s_m3"]
            look: dict[str, Any] = {"fmt": "o", "color": colour, "lw": 0.8, "ms": 4, "mfc": face}
            named = kind == "measured" and len(levels) <= 8
            values.errorbar(x, y, errors, **look, label=f"{level:.3g} g" if named else "")
        differences.plot(
            rows["frequency_hz"], rows["damping_difference_over_error"], "o", color=colour
        )
    low, high = predictions["frequency_hz"].min(), predictions["frequency_hz"].max()
    frequency_axis(differences, low / 1.2, high * 1.2)
    log_scale(values)
    values.set_ylabel("Cₑ, N s/m³")
    if len(levels) <= 8:
        values.legend(ncols=2)
    differences.axhspan(-2, 2, color="#dddddd", lw=0)
    differences.set_ylabel("difference\nover error")
    return figure
