"""The coupon on the page: a film, and what came out of its runs."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from pidpanel.arrays import Array
from pidpanel.coupon.window import CLOSURE_LIMIT
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.report import style
from pidpanel.report.coupon_figures import (
    ACCELERATION,
    EQUIVALENT_DAMPING,
    FREQUENCY,
    MASS_SHARE,
    design_figure,
    loss_factor_map,
    losses_figure,
    sweep_figure,
)
from pidpanel.report.facts import cases_text
from pidpanel.report.films import film_picture
from pidpanel.report.html import Block, Cell, PageSection, Paragraph, Picture, Table, table_of
from pidpanel.report.inputs import CouponResults
from pidpanel.report.text import counted, number, percent, records, value_text, with_error

# C_e [N s/m³] of frequency [Hz], shape ``(n,)``, and fill fraction.
Law = Callable[[Array, float], Array]

STATES = "states: C_e (share of the cells)"

BARS = (
    "Bars: one standard error, from the scatter between cycles and between seeds. Only cases that "
    "count are drawn: status ok, or NotSteady with enlarged errors."
)


def coupon_section(
    coupon: CouponResults, *, law: Law | None = None, varied: Sequence[str] = ()
) -> PageSection:
    """Return the film, the sweep and all cases."""
    cases = coupon.cases
    good = cases[cases["status"].isin(COUNTED)]
    blocks: list[Block] = [
        *states_paragraph(cases),
        *([] if coupon.shot is None else [film_picture(coupon.shot)]),
        *([] if varied or coupon.is_design else sweep_blocks(good, law)),
        case_table(cases, varied),
    ]
    return PageSection("coupon", "Coupon", blocks)


def states_paragraph(cases: pd.DataFrame) -> list[Paragraph]:
    """Return a paragraph on the cases whose cells are in several states of motion, or nothing."""
    several = cases[cases["states"] > 1]
    if several.empty:
        return []
    return [
        Paragraph(
            f"In {counted(len(several), 'case')} the cells end in different states of motion "
            "under the same drive: a bed may ride, or cross the gap every one, two or three "
            "cycles. The table lists each state with its share of the cells, from beds at "
            "rest and beds shaken hard. C_e is the mean of all cells, and its error covers "
            "every state."
        )
    ]


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


def sweep_blocks(cases: pd.DataFrame, law: Law | None) -> list[Picture]:
    """Return C_e over frequency and over acceleration, and the apparent mass over one of them."""
    mass = cases["particle_mass_per_area_kg_m2"]
    cases = cases.assign(
        apparent_mass_share=cases["apparent_mass_kg_m2"] / mass,
        apparent_mass_share_error=cases["apparent_mass_error_kg_m2"] / mass,
    )
    references = (
        "Dashed: the paper's law, corrected (|a₁|, f in Hz), independent of Γ. " if law else ""
    ) + (
        "Dotted: C_e = 4 m″ω/π, the bound of a perfectly inelastic bed of this mass without "
        "gravity."
    )
    # over what has one value alone there is nothing to draw
    over_g = cases[ACCELERATION.column].nunique() > 1
    sides = [("acceleration", ACCELERATION, FREQUENCY)] if over_g else []
    if cases[FREQUENCY.column].nunique() > 1 or not over_g:
        sides.insert(0, ("frequency", FREQUENCY, ACCELERATION))
    pictures = []
    for name, x, panel in sides:
        figure = style.Drawing(
            sweep_figure, cases, x, EQUIVALENT_DAMPING, panel, law=law, bound="bound_n_s_m3"
        )
        caption = f"Equivalent damping per area over {x.symbol} at constant {panel.symbol}."
        pictures.append(Picture(f"damping_over_{name}", figure, f"{caption} {BARS} {references}"))
    caption = (
        "Share of the particles' mass that moves in phase with the cell (apparent mass over "
        f"mass, both per area), over {x.symbol}. {BARS}"
    )
    figure = style.Drawing(sweep_figure, cases, x, MASS_SHARE, panel)
    return [*pictures, Picture("apparent_mass", figure, caption)]


def loss_factor_picture(cases: pd.DataFrame) -> Picture:
    """Return η over frequency and acceleration as maps."""
    return Picture(
        "loss_factor_map",
        style.Drawing(loss_factor_map, cases),
        "Loss factor η = E_d/(π m″(ωW)²) over frequency and Γ = a/g, by fill fraction; the bound "
        "of a perfectly inelastic bed is 4/π = 1.27. Empty: no case with status ok.",
    )


def design_picture(cases: pd.DataFrame, varied: Sequence[str]) -> Picture:
    """Return η over each quantity of a table of cases."""
    return Picture(
        "loss_factor_design",
        style.Drawing(design_figure, cases, varied),
        "Loss factor η of every case over each quantity of the table; all others differ too.",
    )


def case_table(cases: pd.DataFrame, varied: Sequence[str] = ()) -> Table:
    """Return every case of the coupon with its errors and its status."""
    several = bool((cases["states"] > 1).any())
    cells: dict[str, Cell] = {
        **{key: _plain(key) for key in varied},
        "r": lambda row: f"{row['fill_fraction']:g}",
        "f, Hz": lambda row: f"{row['frequency_hz']:g}",
        "Γ": lambda row: f"{row['acceleration_g']:g}",
        "E_d, J/m²": _pair("dissipated_energy_j_m2", "dissipated_energy_error_j_m2"),
        "C_e, N s/m³": _pair(EQUIVALENT_DAMPING.column, str(EQUIVALENT_DAMPING.error)),
        "m_a, kg/m²": _pair("apparent_mass_kg_m2", "apparent_mass_error_kg_m2"),
        "η": lambda row: number(row["loss_factor"]),
        **({STATES: _states} if several else {}),
        "share of bound": lambda row: number(row["share_of_bound"], 2),
        "particles per cell": lambda row: number(row["spheres_per_cell"]),
        "modulus, MPa": lambda row: f"{row['youngs_modulus_mpa']:g}",
        "cycles run (used)": lambda row: f"{row['cycles_run']} ({row['cycles_used']})",
        "accuracy reached": lambda row: "yes" if row["target_met"] else "no",
        "energy balance error, %": lambda row: number(100 * row["closure"], 2),
        "normal loss, %": lambda row: number(100 * row["normal_share"], 2),
        "status": lambda row: row["status"],
    }
    caption = f"{cases_text(cases)}; ±: one standard error"
    return table_of(records(cases), caption, cells, folded=True)


def _plain(column: str) -> Cell:
    return lambda row: str(row[column])


def _pair(value: str, error: str) -> Cell:
    return lambda row: with_error(row[value], row[error])


def losses_section(cases: pd.DataFrame) -> PageSection:
    """Return shares of the losses and errors of the energy balance."""
    closure = cases["closure"].dropna().abs()
    if closure.empty:
        text = "No run listed its contacts, so the energy balance is unknown."
        return PageSection("losses", "Energy balance of the coupon", [Paragraph(text)])
    caption = (
        "Left: share of the losses in the normal direction of the contacts (damping of the Hertz "
        "contact); the rest is friction, the second integral of the paper's Eq. 3. Right: error of "
        "the balance work = losses + change of kinetic, elastic and potential energy, the worst "
        f"seed of each case: median {percent(closure.median(), 2)}, largest "
        f"{percent(closure.max(), 2)}. Grey: the {percent(CLOSURE_LIMIT)} within which a run is "
        "accepted. LIGGGHTS lists contact forces with the velocity at the end of a time step, so "
        "about 1 % is missing at a fifth of the Rayleigh time, and less with shorter steps."
    )
    picture = Picture("losses", style.Drawing(losses_figure, cases), caption)
    return PageSection("losses", "Energy balance of the coupon", [picture])


def coupon_text(results: CouponResults) -> str:
    """Return a coupon in words, which accuracy was asked for, and which was reached."""
    good = results.cases[results.cases["status"] == "ok"]
    text = f"{results.words} {results.accuracy}"
    if not len(good):
        return f"{text}; no case is ok."
    relative = (good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"]).abs()
    return (
        f"{text}. Reached: {percent(relative.median(), 1)} in the median, "
        f"{percent(relative.max(), 1)} at most, in {len(good)} of "
        f"{counted(len(results.cases), 'case')}."
    )


def coupon_finding(cases: pd.DataFrame) -> str:
    """Return the range of C_e and where the particles dissipate most, with errors."""
    if not len(cases):
        return "No case is ok, so there is no result for this coupon."
    peak = cases.iloc[int(cases["loss_factor"].to_numpy().argmax())]
    low, high = cases["equivalent_damping_n_s_m3"].min(), cases["equivalent_damping_n_s_m3"].max()
    span = (
        f"{number(low)} to {number(high)} N s/m³"
        if len(cases) > 1
        else value_text(low, float(cases["equivalent_damping_error_n_s_m3"].iloc[0])) + " N s/m³"
    )
    return (
        f"C_e is {span}; the largest loss factor is "
        f"{value_text(peak['loss_factor'], peak['loss_factor_error'])} (the bound of an inelastic "
        f"bed is 1.27), at r = {peak['fill_fraction']:g}, {peak['frequency_hz']:g} Hz, "
        f"Γ = {peak['acceleration_g']:.4g}."
    )
