"""The damping on the page: the surface, the law as an engineer quotes it."""

from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping.fit import OVER_FILL, constants_at
from pidpanel.damping.laws import equation_5
from pidpanel.report.coupon_figures import Law
from pidpanel.report.html import PageSection, template_section
from pidpanel.report.inputs import DampingResults
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
        **_law_values(results),
    }
    return template_section("damping.html", "Damping law", values)


def _law_values(results: DampingResults) -> dict[str, Any]:
    """Return the equation with its constants at every Γ and fill, and the paper's."""
    over_fill, best = _over_fill(results), None
    if len(over_fill):
        gamma = float(over_fill["acceleration_g"].to_numpy()[int(over_fill["scatter"].argmin())])
        constants = over_fill[over_fill["acceleration_g"] == gamma].set_index("constant")
        best = {**constants["value"], **_fit(constants), "gamma": gamma}
        best["alpha"] = np.exp(best["ln_alpha"])

    fits = []
    for at_g, group in over_fill.groupby("acceleration_g"):
        constants = group.set_index("constant")
        intervals = {name: _interval(constants, name) for name in OVER_FILL}
        fits.append({**intervals, **_fit(constants), "gamma": at_g})
    return {"best": best, "fits": fits}


def fitted_law(results: DampingResults) -> Law | None:
    """Return the law with the constants of each Γ; None where no Γ has cases of several fills."""
    over_fill = _over_fill(results)

    def damping(frequency: Array, fill: float, gamma: float) -> Array:
        at_gamma = over_fill[np.isclose(over_fill["acceleration_g"], gamma)].set_index("constant")
        if not len(at_gamma):
            return np.full(frequency.shape, np.nan)
        constants = at_gamma.loc[list(OVER_FILL), "value"].to_numpy(float)
        a1, a2, a3 = constants_at(np.full(frequency.shape, fill), constants)
        with np.errstate(invalid="ignore"):
            return np.where(a1 > 0, equation_5(2 * np.pi * frequency, a1, a2, a3), np.nan)

    return Law("Eq. 5 and 6, fitted at each Γ", damping) if len(over_fill) else None


def _over_fill(results: DampingResults) -> pd.DataFrame:
    """Return constants of the law over fill; at a Γ with cases of a single fill there are none."""
    law = results.law
    return law[law["fill_fraction"].isna() & law["constant"].isin(OVER_FILL)]


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
