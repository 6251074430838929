"""The coupon on the page: a film, and what came out of its runs."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import pandas as pd

from pidpanel.coupon.window import CLOSURE_LIMIT
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.report import coupon_figures as figures
from pidpanel.report.facts import cases_text
from pidpanel.report.films import film_picture
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.inputs import CouponResults
from pidpanel.report.text import counted, number, percent, records


def coupon_section(
    coupon: CouponResults,
    *,
    text: str = "",
    law: figures.Law | None = None,
    surface: DampingSurface | None = None,
    varied: Sequence[str] = (),
) -> PageSection:
    """Return the coupon in words, the film, the sweep and all cases."""
    cases = coupon.cases
    good = cases[cases["status"].isin(COUNTED)]
    closure = good["closure"].dropna().abs()
    values = {
        "text": text,
        "several": int((cases["states"] > 1).sum()),
        "film": None if coupon.shot is None else film_picture(coupon.shot),
        "sweeps": [],
        "law": law and law.name,
        "has_surface": surface is not None,
        "closure": None if closure.empty else (closure.median(), closure.max(), CLOSURE_LIMIT),
        "count": cases_text(cases),
        "varied": varied,
        "cases": [{**row, "states_text": _states(row)} for row in records(cases)],
    }
    if not (varied or coupon.is_design):
        values |= _sweeps(good, law, surface)
    return template_section("coupon.html", "Coupon", values)


def _states(row: Mapping[str, Any]) -> str:
    """Return C_e of each state of a case and its share of the cells."""
    if not row["states"] > 1:
        return ""
    values = str(row["state_damping_n_s_m3"]).split()
    shares = str(row["state_share"]).split()
    return "; ".join(
        f"{number(float(value))} ({percent(float(share))})"
        for value, share in zip(values, shares, strict=True)
    )


def _sweeps(
    cases: pd.DataFrame, law: figures.Law | None, surface: DampingSurface | None
) -> dict[str, Any]:
    """Return C_e over frequency and over acceleration, and the apparent mass over one of them."""
    mass = cases["particle_mass_per_area_kg_m2"]
    cases = cases.assign(
        apparent_mass_share=cases["apparent_mass_kg_m2"] / mass,
        apparent_mass_share_error=cases["apparent_mass_error_kg_m2"] / mass,
    )
    # over what has one value alone there is nothing to draw
    over_g = cases[figures.ACCELERATION.column].nunique() > 1
    sides = [("acceleration", figures.ACCELERATION, figures.FREQUENCY)] if over_g else []
    if cases[figures.FREQUENCY.column].nunique() > 1 or not over_g:
        sides.insert(0, ("frequency", figures.FREQUENCY, figures.ACCELERATION))
    sweeps, draw = [], partial(figure_picture, draw=figures.sweep_figure, cases=cases)
    for name, x, panel in sides:
        damping = draw(
            f"damping_over_{name}", x=x, y=figures.EQUIVALENT_DAMPING, panel=panel,
            law=law, bound="bound_n_s_m3", surface=surface,
        )  # fmt: skip
        sweeps.append({"damping": damping, "x": x.symbol, "panel": panel.symbol})
    mass_picture = draw("apparent_mass", x=x, y=figures.MASS_SHARE, panel=panel)
    return {"sweeps": sweeps, "mass": mass_picture}


def coupon_text(results: CouponResults) -> str:
    """Return a coupon in words, with required and reached accuracy."""
    good = results.cases[results.cases["status"] == "ok"]
    if not len(good):
        return f"{results.words}; no case is ok."
    relative = (good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"]).abs()
    return (
        f"{results.words}. Reached: {percent(relative.median(), 1)} in the median, "
        f"{percent(relative.max(), 1)} at most, in {len(good)} of "
        f"{counted(len(results.cases), 'case')}."
    )
