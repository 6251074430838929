"""The damping on the page: the surface, the laws as an engineer quotes them."""

from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping import forms
from pidpanel.damping.fit import OVER_FILL, constants_at
from pidpanel.damping.laws import equation_5
from pidpanel.report.damping_figures import collapse_figure, law_figure, map_figure
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.inputs import DampingResults
from pidpanel.report.text import number


def damping_section(results: DampingResults) -> PageSection:
    """Return the surface and the laws."""
    surface = results.surface
    left = surface.leave_one_out()
    z = left["log_error"] / left["log_standard_error"]
    rms = float(np.sqrt((left["log_error"] ** 2).mean()))
    over = "frequency_hz", "acceleration_g"
    values = {
        "cases": len(surface.cases),
        "onset": surface.onset_g,
        "rms": rms,
        "factor": np.exp(rms),
        "covered": (z.abs() < 1.96).mean(),
        "low": surface.low,
        "high": surface.high,
        "map": figure_picture("map_frequency_acceleration", map_figure, surface, *over),
        **_law_values(results),
        **_form_values(results),
    }
    return template_section("damping.html", "Damping law", values)


def _law_values(results: DampingResults) -> dict[str, Any]:
    """Return the equation with its constants at every Γ and fill, beside the paper's."""
    law = results.law[results.law["form"] == "paper"]
    # at a Γ with cases of one fill alone there is nothing to tell over fill
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

    picture = figure_picture("damping_law", law_figure, results.surface, fitted)
    fits = []
    for at_g, group in over_fill.groupby("acceleration_g"):
        constants = group.set_index("constant")
        fits.append({**_intervals(constants, OVER_FILL), **_fit(constants), "gamma": at_g})
    return {"best": best, "law": picture, "fits": fits}


def _fit(constants: pd.DataFrame) -> dict[str, Any]:
    first = constants.iloc[0]
    return {"points": int(first["points"]), "scatter": first["scatter"]}


def _intervals(constants: pd.DataFrame, names: Iterable[str]) -> dict[str, str]:
    return {name: _interval(constants, name, exponent=name.startswith("ln_")) for name in names}


def _interval(constants: pd.DataFrame, constant: str, *, exponent: bool) -> str:
    """Return a constant, or e to it, with its interval: value [low, high]."""
    numbers = [float(constants[name][constant]) for name in ("value", "low", "high")]
    if exponent:
        with np.errstate(over="ignore"):  # an interval without an end
            numbers = np.exp(numbers).tolist()
    value, low, high = numbers
    return f"{number(value)} [{number(low)}, {number(high)}]"


def _form_values(results: DampingResults) -> dict[str, Any]:
    """Return the law of two regimes, and the cases on dimensionless axes."""
    points, log_eta = forms.points_of(results.surface, results.depth)
    constants = results.law[results.law["form"] == "two_regimes"].set_index("constant")
    drawn = regimes = None
    if len(constants):
        values = constants.loc[list(forms.CONSTANTS), "value"].to_numpy(float)
        drawn = partial(forms.two_regimes, values)
        regimes = {**_intervals(constants, forms.CONSTANTS), **_fit(constants)}
    picture = figure_picture("damping_collapse", collapse_figure, points, log_eta, drawn)
    return {"regimes": regimes, "collapse": picture}
