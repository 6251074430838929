"""The page of a study of the coupon alone: what the dissipation depends on, and how much."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib import ticker
from matplotlib.figure import Figure

from pidpanel.report import figures, style, tables
from pidpanel.report.coupon_section import beads_block
from pidpanel.report.figures import EQUIVALENT_DAMPING, FREQUENCY, LEVEL
from pidpanel.report.html import Block, Page, Picture, Section
from pidpanel.report.inputs import Coupon
from pidpanel.report.losses import losses_picture
from pidpanel.study import CouponStudy

LABELS = {
    "particles.friction": "friction coefficient μ",
    "particles.restitution": "coefficient of restitution e",
    "particles.youngs_modulus_mpa": "Young's modulus, MPa",
    "particles.density_kg_m3": "density of the spheres, kg/m³",
    "diameter_mm": "diameter of the spheres, mm",
    "time_step_rayleigh": "time step over Rayleigh time",
    "gravity_direction": "direction of gravity (z: motion)",
    "gravity_g": "gravity, g",
    "cell.count": "number of cells",
    "cell.across_flats_mm": "width of a cell, mm",
    "cell.shape": "shape of the cells",
    "deck": "deck",
}
"""Names of what is varied, as an axis says them; any other key stands as it is written."""

VALUE, ERROR = EQUIVALENT_DAMPING.column, str(EQUIVALENT_DAMPING.error)


def varied_keys(study: CouponStudy) -> list[str]:
    """Columns of ``cases.csv`` that the study varies besides fill, frequency and level."""
    if study.coupon is None:
        return []
    sizes = ["diameter_mm"] if len(study.coupon.sweep.diameter_mm) > 1 else []
    return [*study.coupon.vary, *sizes]


def comparison(cases: pd.DataFrame, key: str) -> pd.DataFrame:
    """Every case beside the one at the first value of ``key``, all else equal.

    Returns
    -------
    One row a case but the first of its group: ``ratio`` of C_e to that of the first, its
    ``ratio_error``, and their difference over its standard error, ``deviation``.

    Notes
    -----
    The bias of softened contacts is common to both and leaves the difference, unless the
    modulus differs.
    """
    same = ["fill_fraction", "frequency_hz", "acceleration_g"]
    statistical = "statistical_error_n_s_m3"
    rows = []
    for point, group in cases.groupby(same, sort=True):
        first = group.iloc[0]
        for _, row in group.iloc[1:].iterrows():
            equal = row["youngs_modulus_mpa"] == first["youngs_modulus_mpa"]
            error = statistical if equal else ERROR
            ratio = row[VALUE] / first[VALUE]
            spread = math.hypot(row[error] / row[VALUE], first[error] / first[VALUE])
            rows.append(
                {
                    **dict(zip(same, point, strict=True)),
                    "from": first[key],
                    "to": row[key],
                    "ratio": ratio,
                    "ratio_error": ratio * spread,
                    "deviation": (row[VALUE] - first[VALUE]) / math.hypot(row[error], first[error]),
                }
            )
    return pd.DataFrame(rows)


def varied_figure(cases: pd.DataFrame, key: str) -> Figure:
    """C_e over what is varied, one pair of axes a frequency, a line a fill and level."""
    frequencies = sorted(cases[FREQUENCY.column].unique())
    figure = Figure(figsize=(figures.WIDTH, 3.0))
    grid = figure.subplots(1, len(frequencies), squeeze=False)[0]
    lines = sorted(
        {(r, g) for r, g in zip(cases["fill_fraction"], cases[LEVEL.column], strict=True)}
    )
    values = list(dict.fromkeys(cases[key]))
    numeric = pd.api.types.is_numeric_dtype(cases[key])
    place = {value: value if numeric else float(i) for i, value in enumerate(values)}
    for axes, frequency in zip(grid, frequencies, strict=True):
        for number, (fill, level) in enumerate(lines):
            one = cases[
                (cases[FREQUENCY.column] == frequency)
                & (cases["fill_fraction"] == fill)
                & (cases[LEVEL.column] == level)
            ]
            axes.errorbar(
                [place[value] for value in one[key]], one[VALUE], yerr=one[ERROR],
                color=style.PLACES[number % len(style.PLACES)],
                marker=style.MARKERS[number % len(style.MARKERS)],
                ls="-" if numeric else "none", capsize=2,
                label=f"r = {fill:g}, Γ = {level:g}",
            )  # fmt: skip
        axes.set_title(f"f = {frequency:g} Hz", loc="left")
        axes.set_xlabel(LABELS.get(key, key))
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
        axes.yaxis.set_major_formatter("{x:g}")
        axes.yaxis.set_minor_formatter(ticker.NullFormatter())
        if numeric and min(values) > 0 and max(values) > 8 * min(values):
            axes.set_xscale("log")
            axes.xaxis.set_major_formatter("{x:g}")
        if numeric:
            axes.set_xticks(values, [f"{value:g}" for value in values])
            axes.set_xticks([], minor=True)
        else:
            axes.set_xticks(list(place.values()), [str(value) for value in values])
            axes.margins(x=0.25)
    grid[0].set_ylabel(EQUIVALENT_DAMPING.label)
    handles, names = grid[0].get_legend_handles_labels()
    figure.tight_layout(rect=(0, 0.1, 1, 1))
    figure.legend(handles, names, loc="lower center", ncols=4)
    return figure


def findings(cases: pd.DataFrame, keys: Sequence[str]) -> list[str]:
    """What came out, one sentence for every key that was varied."""
    said = []
    for key in keys:
        found = comparison(cases, key)
        if found.empty:
            continue
        name = LABELS.get(key, key)
        largest = found.iloc[int(np.log(found["ratio"]).abs().argmax())]
        far = int((found["deviation"].abs() > 2).sum())
        said.append(
            f"{name}: from {_text(largest['from'])} to {_text(largest['to'])} C_e changes by a "
            f"factor of {largest['ratio']:.3g} ± {largest['ratio_error']:.2g} at most "
            f"(r = {largest['fill_fraction']:g}, {largest['frequency_hz']:g} Hz, "
            f"Γ = {largest['acceleration_g']:g}). Of {len(found)} differences {far or 'none'} "
            f"{'is' if far < 2 else 'are'} larger than two of their standard errors (by chance "
            f"one in twenty would be); the largest is {found['deviation'].abs().max():.1f}."
        )
    return said


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def page(
    study: CouponStudy, stamp: Mapping[str, str], coupon: Coupon, steps: Sequence[tuple[str, str]]
) -> Page:
    """The whole page of a study of the coupon."""
    cases = coupon.cases
    good = cases[cases["status"] == "ok"]
    keys = varied_keys(study)
    blocks: list[Block] = []
    for key in keys:
        other = ", ".join(LABELS.get(one, one) for one in keys if one != key)
        blocks.append(
            Picture(
                f"over_{key.replace('.', '_')}",
                style.png(varied_figure(good, key)),
                "Equivalent damping per area; bars: one standard error, scatter of cycles and "
                "seeds and the bias of softened contacts together."
                + (f" Points one above the other differ in {other}." if other else ""),
            )
        )
    if not keys:
        for x, along in ((FREQUENCY, LEVEL), (LEVEL, FREQUENCY)):
            figure = figures.sweep_figure(good, x, EQUIVALENT_DAMPING, along, bound="bound_n_s_m3")
            blocks.append(
                Picture(
                    f"damping_over_{x.column}",
                    style.png(figure),
                    "Equivalent damping per area; bars: one standard error; dotted: bound.",
                )
            )
    losses = losses_picture(good)
    if losses is not None:
        blocks.append(losses)
    blocks.append(beads_block(coupon.beads))
    blocks.append(
        Picture(
            "steadiness",
            style.png(figures.steadiness_figure(coupon.records)),
            "Energy dissipated per cycle and area in a few runs, cycle by cycle. Dotted: end of "
            "the transient; band: mean after it ± one standard error.",
        )
    )
    blocks.append(tables.case_table(cases, keys))
    lost = cases[cases["status"] != "ok"]
    return Page(
        title=study.title or study.name,
        facts=[
            ("study", f"{study.name}, {stamp['study_hash']}"),
            ("cases", f"{len(cases)}, {len(good)} of them ok"),
            ("programs", f"pidpanel {stamp['pidpanel_version']}, "
                         f"LIGGGHTS {stamp['liggghts_version']}"),
        ],
        assumptions=study.assumptions,
        summary=findings(good, keys)
        or [f"C_e from {good[VALUE].min():.3g} to {good[VALUE].max():.3g} N s/m³."],
        warnings=[
            f"{row['case']}: {row['status']}: {row['message']}" for _, row in lost.iterrows()
        ],
        claims=None,
        sections=[Section("coupon", "Coupon", blocks)],
        steps=steps,
    )  # fmt: skip
