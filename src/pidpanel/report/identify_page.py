"""The page of an identification: the particles, and measured values beside those of the atlas."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.identify.from_study import IdentificationResult, summary
from pidpanel.identify.posterior import Posterior
from pidpanel.report import style
from pidpanel.report.html import (
    Block,
    Page,
    PageSection,
    Paragraph,
    Picture,
    Table,
    render,
    table_of,
)
from pidpanel.report.layout import frequency_axis
from pidpanel.report.text import number, records

SYMBOLS = {"restitution": "e", "friction": "μ", "fill_fraction": "r"}
NAMES = {
    "restitution": "restitution e",
    "friction": "friction μ",
    "fill_fraction": "fill fraction r",
}
REGIONS = (0.9, 0.5)  # shares of the posterior within the drawn regions
PROPOSED = 8  # further tones in the table


def answer_lines(result: IdentificationResult) -> list[str]:
    """Return the answer in lines, the particles first."""
    posterior = result.posterior
    fit = f"χ² = {number(posterior.least_chi_square)} of {posterior.count} values"
    lines = []
    if not posterior.is_explained:
        lines.append(f"No particles of the atlas explain the measurement: {fit}.")
    for row in records(summary(posterior)):
        lines.append(f"{SYMBOLS[row['parameter']]} = {_interval(row)}")
    if posterior.is_explained:
        lines.append(f"These particles explain the measurement: {fit}.")
    return [*lines, *warnings(result), next_line(result)]


def _interval(row: dict[str, float]) -> str:
    return f"{row['value']:.3g} (90 %: {row['low_90']:.3g} to {row['high_90']:.3g})"


def warnings(result: IdentificationResult) -> list[str]:
    """Return what limits the answer."""
    lines = []
    for row in records(summary(result.posterior)):
        ends = [text for end, text in (("low", "lower"), ("high", "upper")) if row[f"cut_{end}"]]
        if ends:
            lines.append(
                f"The interval of {SYMBOLS[row['parameter']]} is cut at the {' and '.join(ends)} "
                "limit of the atlas."
            )
    if result.outside:
        lines.append(f"{result.outside} of {len(result.predictions)} tones lie outside the atlas.")
    if result.measured.tones.is_broadband.any():
        lines.append(
            "The test is random: C_e of the atlas is corrected for it, with a further error of "
            "25 % that all frequencies share."
        )
    return lines


def next_line(result: IdentificationResult) -> str:
    """Return the further tone that narrows the answer most."""
    further, (e, friction, _) = result.further, records(summary(result.posterior))
    if not len(further.frequency):
        return "The shaker cannot run a further tone: widen its limits (shaker)."
    best = further.best
    f, gamma = further.frequency[best], further.acceleration_g[best]
    return (
        f"A further tone at {number(f)} Hz and {number(gamma)} g ({number(_stroke(f, gamma), 2)} "
        "mm) would narrow "
        f"the answer most: standard deviation of e from {e['error']:.2g} to "
        f"{further.restitution_error[best]:.2g}, of μ from "
        f"{100 * friction['error'] / friction['value']:.0f} to "
        f"{100 * further.friction_error[best]:.0f} %."
    )


def _stroke(frequency: float, gamma: float) -> float:
    """Displacement amplitude [mm]."""
    return 1e3 * gamma * STANDARD_GRAVITY / (2 * math.pi * frequency) ** 2


def write_identification(result: IdentificationResult, file: Path) -> None:
    """Write the page."""
    file.write_text(render(identification_page(result)), encoding="utf-8")


def identification_page(result: IdentificationResult) -> Page:
    """Return the page."""
    identification, posterior = result.identification, result.posterior
    lines = answer_lines(result)
    further: list[Block] = [Paragraph(next_line(result)), _proposals(result)]
    coupon = identification.coupon
    cell = f"{coupon.cell.across_flats_mm:g} mm × {coupon.cell.depth_mm:g} mm"
    known = table_of(
        records(summary(posterior)),
        "Identified particles",
        {
            "": lambda row: NAMES[row["parameter"]],
            "value": lambda row: f"{row['value']:.3g}",
            "standard deviation": lambda row: f"{row['error']:.2g}",
            "90 % interval": lambda row: f"{row['low_90']:.3g} to {row['high_90']:.3g}",
        },
    )
    region = (
        "Regions with 90 and 50 % of the posterior, and its mean. The frame is part of the range "
        "of the atlas, e 0.3 to 0.95 and μ 0.05 to 0.8."
    )
    compared = (
        "C_e measured (filled, one standard error of the test) and of the atlas with the "
        "identified particles (open, its calibrated error), by acceleration; below, the difference "
        "over both errors."
    )
    return Page(
        title=identification.title or f"Particles of {identification.name}",
        answer=" ".join(lines[:4]),
        first=[
            known,
            Picture("posterior", style.Drawing(posterior_figure, posterior), region),
            Picture("measured", style.Drawing(measured_figure, result.predictions), compared),
        ],
        caveats=warnings(result),
        facts=[
            ("measurement", identification.measured.file.name),
            ("cell", f"hexagon, {cell}"),
            ("particles", f"{coupon.particles.diameter_mm:g} mm, "
             f"{coupon.particles.density_kg_m3:g} kg/m³"),
            ("atlas", f"version {result.atlas.version}, {len(result.atlas.cases)} simulated cases"),
        ],
        summary=[f"Correlation of e and ln μ: {posterior.correlation[0, 1]:+.2f}."],
        sections=[
            PageSection("next", "Further tests", further),
            PageSection("values", "Measured and computed", [_values(result.predictions)]),
        ],
    )  # fmt: skip


def _proposals(result: IdentificationResult) -> Table:
    further = result.further
    order = np.argsort(-further.information)[:PROPOSED]
    rows = [
        [
            number(further.frequency[k]),
            number(further.acceleration_g[k]),
            number(_stroke(further.frequency[k], further.acceleration_g[k]), 2),
            number(further.restitution_error[k], 2),
            f"{100 * further.friction_error[k]:.0f}",
        ]
        for k in order
    ]
    columns = ["f, Hz", "Γ, g", "W, mm", "expected standard deviation of e", "of μ, %"]
    return Table("Further tones that tell most; all are in next_tests.csv", columns, rows)


def _values(predictions: pd.DataFrame) -> Table:
    damping, mass = "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"

    def pair(name: str) -> tuple[str, str]:
        return f"measured_{name}", f"atlas_{name}"

    cells = {
        "f, Hz": lambda row: number(row["frequency_hz"]),
        "Γ, g": lambda row: number(row["acceleration_g"]),
        "W/L": lambda row: number(row["stroke_per_gap"]),
        "C_e measured, N s/m³": lambda row: _text(row[pair(damping)[0]]),
        "atlas": lambda row: _text(row[pair(damping)[1]]),
        "difference over error": lambda row: _text(row["damping_difference_over_error"]),
        "m_a measured, kg/m²": lambda row: _text(row[pair(mass)[0]]),
        "atlas ": lambda row: _text(row[pair(mass)[1]]),
        "difference over error ": lambda row: _text(row["mass_difference_over_error"]),
    }
    return table_of(records(predictions), "Numbers are in predictions.csv", cells)


def _text(value: float) -> str:
    return number(value) if np.isfinite(value) else "–"


def posterior_figure(posterior: Posterior) -> Figure:
    """Draw the regions of e and μ with some shares of the posterior."""
    figure = Figure(figsize=(4.6, 3.4), layout="constrained")
    axes = figure.subplots()
    e, log_friction, _ = posterior.axes
    share = posterior.weights.sum(axis=2)
    density = share / share.max()
    friction = np.exp(log_friction)
    levels = [_level(share, region) / share.max() for region in REGIONS]
    if min(density.shape) > 1:
        colours = ["#9ecae1", "#3182bd"]
        axes.contourf(e, friction, density.T, levels=[*levels, 1.0], colors=colours)
    mean = posterior.estimate(0).mean, math.exp(posterior.estimate(1).mean)
    axes.plot(*mean, "o", color="black", ms=5)
    axes.set(yscale="log", xlabel="restitution e", ylabel="friction μ")
    axes.set_yticks(_ticks(friction), [f"{value:g}" for value in _ticks(friction)], minor=False)
    axes.minorticks_off()
    return figure


def _ticks(values: Array) -> list[float]:
    ticks = (0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8)
    return [tick for tick in ticks if values[0] * 0.999 <= tick <= values[-1] * 1.001]


def _level(share: Array, region: float) -> float:
    """Return the weight above which points together have a share of the posterior."""
    ordered = np.sort(share.ravel())[::-1]
    place = int(np.searchsorted(np.cumsum(ordered), region * ordered.sum()))
    return float(ordered[min(place, len(ordered) - 1)])


def measured_figure(predictions: pd.DataFrame) -> Figure:
    """Draw C_e measured and of the atlas over frequency, and their differences."""
    figure = Figure(figsize=(5.6, 4.4), layout="constrained")
    values, differences = figure.subplots(2, 1, height_ratios=(3, 1), sharex=True)
    levels = sorted(predictions["acceleration_g"].round(3).unique())
    for level, rows in predictions.groupby(predictions["acceleration_g"].round(3)):
        colour = style.level_colour(float(level), levels)
        _draw(values, rows, colour, f"{level:.3g} g" if len(levels) <= 8 else "")
        differences.plot(
            rows["frequency_hz"], rows["damping_difference_over_error"], "o", color=colour
        )
    low, high = predictions["frequency_hz"].min(), predictions["frequency_hz"].max()
    frequency_axis(differences, low / 1.2, high * 1.2)
    values.set(yscale="log", ylabel="$C_e$, N s/m³")
    if len(levels) <= 8:
        values.legend(ncols=2)
    differences.axhspan(-2, 2, color="#dddddd", lw=0)
    differences.set_ylabel("difference\nover error")
    return figure


def _draw(axes: Axes, rows: pd.DataFrame, colour: str, label: str) -> None:
    name = "equivalent_damping_n_s_m3"
    error = name.replace("damping", "damping_error")
    for kind, shift, face, text in (("measured", 1.0, colour, label), ("atlas", 1.02, "white", "")):
        x, y = shift * rows["frequency_hz"], rows[f"{kind}_{name}"]
        errors = rows[f"{kind}_{error}"]
        axes.errorbar(x, y, errors, fmt="o", color=colour, lw=0.8, ms=4, mfc=face, label=text)
