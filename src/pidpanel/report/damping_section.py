"""The damping on the page: the surface, the law as an engineer quotes it."""

import itertools
from collections.abc import Callable
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pidpanel.arrays import Array
from pidpanel.damping.fit import OVER_FILL, constants_at
from pidpanel.damping.laws import equation_5
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES, ERROR, VALUE
from pidpanel.report import style
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.inputs import DampingResults
from pidpanel.report.layout import (
    GREY,
    WIDTH,
    add_legend,
    figure_of_axes,
    fill_handles,
    frequency_axis,
    log_scale,
    pick,
)
from pidpanel.report.text import number


def damping_section(results: DampingResults) -> PageSection:
    """Return the surface and the law."""
    surface = results.surface
    left = surface.leave_one_out()
    z = left["log_error"] / left["log_standard_error"]
    rms = float(np.sqrt((left["log_error"] ** 2).mean()))
    values = {
        "cases": len(surface.cases),
        "onset": surface.onset_g,
        "rms": rms,
        "factor": np.exp(rms),
        "covered": (z.abs() < 1.96).mean(),
        "low": surface.low,
        "high": surface.high,
        "map": figure_picture("map_frequency_acceleration", map_figure, surface),
        **_law_values(results),
    }
    return template_section("damping.html", "Damping law", values)


def _law_values(results: DampingResults) -> dict[str, Any]:
    """Return the equation with its constants at every Γ and fill, and the paper's."""
    law = results.law
    # at a Γ with cases of a single fill there is no equation over fill
    over_fill = law[law["fill_fraction"].isna() & law["constant"].isin(OVER_FILL)]
    best = None
    if len(over_fill):
        gamma = float(over_fill["acceleration_g"].to_numpy()[int(over_fill["scatter"].argmin())])
        constants = over_fill[over_fill["acceleration_g"] == gamma].set_index("constant")
        best = {**constants["value"], **_fit(constants), "gamma": gamma}
        best["alpha"] = np.exp(best["ln_alpha"])

    def fitted(frequency: Array, fill: float, gamma: float) -> Array:
        at_gamma = over_fill[np.isclose(over_fill["acceleration_g"], gamma)].set_index("constant")
        if not len(at_gamma):
            return np.full(frequency.shape, np.nan)
        constants = at_gamma.loc[list(OVER_FILL), "value"].to_numpy(float)
        a1, a2, a3 = constants_at(np.full(frequency.shape, fill), constants)
        with np.errstate(invalid="ignore"):
            return np.where(a1 > 0, equation_5(2 * np.pi * frequency, a1, a2, a3), np.nan)

    law_drawn = fitted if len(over_fill) else None
    picture = figure_picture("damping_law", law_figure, results.surface, law_drawn)
    fits = []
    for at_g, group in over_fill.groupby("acceleration_g"):
        constants = group.set_index("constant")
        intervals = {name: _interval(constants, name) for name in OVER_FILL}
        fits.append({**intervals, **_fit(constants), "gamma": at_g})
    return {"best": best, "law": picture, "fits": fits}


def _fit(constants: pd.DataFrame) -> dict[str, Any]:
    first = constants.iloc[0]
    return {"points": int(first["points"]), "scatter": first["scatter"]}


def _interval(constants: pd.DataFrame, constant: str) -> str:
    """Return a constant, or e to it, with its interval: value [low, high]."""
    numbers = [float(constants[name][constant]) for name in ("value", "low", "high")]
    if constant.startswith("ln_"):
        with np.errstate(over="ignore"):  # an interval without an end
            numbers = np.exp(numbers).tolist()
    value, low, high = numbers
    return f"{number(value)} [{number(low)}, {number(high)}]"


FILL, FREQUENCY, ACCELERATION = AXES
ACCELERATION_LABEL = "acceleration amplitude Γ, –"
FINE = 61  # values of the surface along each axis of a map

MAPS = 5  # fill fractions that are shown at most, a column each

OUTSIDE = "#ffffff"  # colour outside the simulated range


def map_figure(surface: DampingSurface) -> Figure:
    """Draw C_e (above) and η (below) over frequency and Γ, one column per fill fraction."""
    fills = pick(np.unique(surface.cases[FILL]), MAPS)
    x, y = _fine(surface, FREQUENCY), _fine(surface, ACCELERATION)
    frequency, gamma = np.meshgrid(x, y)
    maps = []
    for fill in fills:
        estimate = surface.evaluate(np.full(frequency.size, fill), frequency.ravel(), gamma.ravel())
        damping = estimate.equivalent_damping.reshape(frequency.shape)
        unit = surface.bed.mass_per_fill * fill * 2 * np.pi * frequency
        maps.append((damping, damping / unit, estimate.inside.reshape(frequency.shape)))
    figure = Figure(figsize=(WIDTH, 4.7), layout="constrained")
    grid_of = figure.subplots(2, len(fills), sharex=True, sharey=True, squeeze=False)
    for row, (label, colormap) in enumerate(
        (("Cₑ, N s/m³", "viridis"), ("loss factor η, –", "magma"))
    ):
        drawn = np.concatenate([layer[row][layer[2]] for layer in maps])
        scale = ScalarMappable(LogNorm(drawn.min(), drawn.max()), mpl.colormaps[colormap])
        for axes, fill, layers in zip(grid_of[row], fills, maps, strict=True):
            axes.set_facecolor(OUTSIDE)
            axes.pcolormesh(
                x, y, np.where(layers[2], layers[row], np.nan), norm=scale.norm, cmap=scale.cmap,
                shading="nearest", rasterized=True,
            )  # fmt: skip
            run = surface.cases[np.isclose(surface.cases[FILL], fill)]
            axes.plot(
                run[FREQUENCY], run[ACCELERATION], "o", ms=3, mfc="white", mec="black", mew=0.6
            )
            axes.grid(False)
            frequency_axis(axes, x[0] / 1.1, x[-1] * 1.1)
            log_scale(axes)
            axes.label_outer()
            if row == 0:
                axes.set_title(f"r = {fill:g}", loc="left")
        grid_of[row, 0].set_ylabel(ACCELERATION_LABEL)
        figure.colorbar(scale, ax=grid_of[row].tolist(), label=label, pad=0.01)
    return figure


def _fine(surface: DampingSurface, axis: str) -> Array:
    low, high = (bound[AXES.index(axis)] for bound in (surface.low, surface.high))
    return np.geomspace(low, high, FINE)


# C_e [N s/m³] of frequency [Hz], shape ``(n,)``, fill fraction and Γ; NaN where undefined.
Law = Callable[[Array, float, float], Array]


def law_figure(surface: DampingSurface, law: Law | None) -> Figure:
    """Draw cases with error bars, the surface with its band, the fitted law and the bound.

    Axes for each acceleration of the cases, a colour for each fill.
    """
    accelerations = pick(np.unique(surface.cases[ACCELERATION]), 6)
    fills = pick(np.unique(surface.cases[FILL]), 5)
    figure, grid = figure_of_axes(len(accelerations), 3, 3.1, 0.6, sharex=True, sharey=True)
    frequency = _fine(surface, FREQUENCY)
    for axes, gamma in zip(grid, accelerations, strict=True):
        for fill, marker in zip(fills, itertools.cycle(style.MARKERS), strict=False):
            colour = style.fill_colour(fill)
            estimate = surface(frequency, fill, gamma)
            value = np.where(estimate.inside, estimate.equivalent_damping, np.nan)
            factor = np.exp(estimate.equivalent_damping_error / estimate.equivalent_damping)
            band = value / factor, value * factor
            axes.plot(frequency, value, color=colour, lw=0.9)
            axes.fill_between(frequency, *band, color=colour, alpha=0.22, lw=0)
            cases = surface.cases
            cases = cases[np.isclose(cases[ACCELERATION], gamma) & np.isclose(cases[FILL], fill)]
            axes.errorbar(
                cases[FREQUENCY], cases[VALUE], yerr=cases[ERROR], color=colour, ls="none",
                marker=marker, capsize=1.8, elinewidth=0.8,
            )  # fmt: skip
            if law is not None:
                axes.plot(frequency, law(frequency, fill, gamma), color=colour, ls="--", lw=0.9)
            bound = 8 * surface.bed.mass_per_fill * fill * frequency
            axes.plot(frequency, bound, color=colour, ls=":", lw=0.7)
        frequency_axis(axes, frequency[0] / 1.1, frequency[-1] * 1.1)
        log_scale(axes)
        axes.set_title(f"Γ = {gamma:g}", loc="left")
        axes.set_ylabel("Cₑ, N s/m³")
        axes.label_outer()
    low, high = surface.cases[VALUE].min(), surface.cases[VALUE].max()
    grid[0].set_ylim(low / 2, high * 5)
    handles = fill_handles(fills)
    handles["surface ± standard error"] = Patch(color=GREY, alpha=0.35)
    if law is not None:
        handles["Eq. 5 and 6, fitted at this Γ"] = Line2D([], [], color=GREY, ls="--")
    handles["bound of an inelastic bed"] = Line2D([], [], color=GREY, ls=":")
    add_legend(figure, 4, handles)
    return figure
