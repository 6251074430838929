"""The coupon on the page: a film, how steady the runs are, what came out of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from pidpanel.arrays import Array
from pidpanel.damping.surface_cases import COUNTED
from pidpanel.report import style
from pidpanel.report.coupon_figures import (
    ACCELERATION,
    EQUIVALENT_DAMPING,
    FREQUENCY,
    LOSS_FACTOR,
    MASS_SHARE,
    loss_factor_map,
    steadiness_figure,
    sweep_figure,
)
from pidpanel.report.facts import cases_text
from pidpanel.report.films import film_picture
from pidpanel.report.html import (
    Block,
    Cell,
    Fold,
    PageSection,
    Paragraph,
    Picture,
    Table,
    table_of,
)
from pidpanel.report.inputs import CouponResults
from pidpanel.report.layout import swept
from pidpanel.report.text import counted, number, percent, records, with_error

Law = Callable[[Array, float], Array]
"""C_e [N s/m³] of frequency [Hz], shape ``(n,)``, and fill fraction."""

STATES = "states: C_e (share of the cells)"

BARS = (
    "Bars: one standard error, from the scatter between cycles and between seeds. Only cases that "
    "count are drawn: status ok, or NotSteady with enlarged errors."
)


def coupon_section(
    coupon: CouponResults, *, law: Law | None = None, varied: Sequence[str] = ()
) -> PageSection:
    """Return the film, how steady the runs are, the sweep and all cases."""
    cases = coupon.cases
    good = cases[cases["status"].isin(COUNTED)]
    steadiness = Picture(
        "steadiness",
        style.png(steadiness_figure(coupon.records)),
        "Energy dissipated per cycle and area in some runs. Dotted: end of the transient, "
        "determined from the data (marginal standard error rule). Band: mean of the following "
        "cycles ± one standard error (by blocking; from 60 cycles on without the energy that "
        "the bed stores in one cycle and returns in the next).",
    )
    blocks: list[Block] = [
        *states_paragraph(cases),
        *([] if coupon.shot is None else [film_picture(coupon.shot)]),
        Fold("How steady the runs are", [steadiness]),
        *([] if varied else sweep_blocks(good, law)),
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
    """Return C_e, loss factor and apparent mass over frequency and acceleration."""
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
    bound = "bound_n_s_m3"
    of_sweep = [
        cases[axis.column].isin(swept(cases[axis.column])) for axis in (ACCELERATION, FREQUENCY)
    ]
    omissions = ["" if s.all() else _omission_text(int((~s).sum())) for s in of_sweep]
    # over what has one value alone there is nothing to draw
    over_g = cases[ACCELERATION.column].nunique() > 1
    over_frequency = cases[FREQUENCY.column].nunique() > 1 or not over_g
    x, panel = (ACCELERATION, FREQUENCY) if over_g else (FREQUENCY, ACCELERATION)
    name, omission = ("Γ", omissions[1]) if over_g else ("frequency", omissions[0])
    drawn: list[tuple[str, Figure, str]] = []
    if over_frequency:
        fig = sweep_figure(cases, FREQUENCY, EQUIVALENT_DAMPING, ACCELERATION, law=law, bound=bound)
        says = f"Equivalent damping per area over frequency at constant Γ = a/g.{omissions[0]}"
        drawn.append(("damping_over_frequency", fig, f"{says} {BARS} {references}"))
    if over_g:
        fig = sweep_figure(cases, ACCELERATION, EQUIVALENT_DAMPING, FREQUENCY, law=law, bound=bound)
        says = f"Equivalent damping per area over Γ = a/g at constant frequency.{omissions[1]}"
        drawn.append(("damping_over_acceleration", fig, f"{says} {BARS} {references}"))
    drawn += [
        (
            "loss_factor",
            sweep_figure(cases, x, LOSS_FACTOR, panel),
            f"Loss factor η = E_d/(π m″(ωW)²) over {name}; the bound of a perfectly inelastic bed "
            f"is 4/π = 1.27.{omission} {BARS}",
        ),
        (
            "apparent_mass",
            sweep_figure(cases, x, MASS_SHARE, panel),
            "Share of the particles' mass that moves in phase with the cell (apparent mass over "
            f"mass, both per area), over {name}.{omission} {BARS}",
        ),
    ]
    return [Picture(name, style.png(figure), caption) for name, figure, caption in drawn]


def loss_factor_picture(cases: pd.DataFrame) -> Picture:
    """Return η over frequency and acceleration as maps."""
    return Picture(
        "loss_factor_map",
        style.png(loss_factor_map(cases)),
        "Loss factor η = E_d/(π m″(ωW)²) over frequency and Γ = a/g, by fill fraction; the bound "
        "of a perfectly inelastic bed is 4/π = 1.27. Empty: no case with status ok.",
    )


def _omission_text(count: int) -> str:
    return f" {counted(count, 'case')} between those of the sweep are only in the table."


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
