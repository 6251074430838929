"""The page of verification: what every stage computes beside what is known.

The rows of `pidpanel.verification` come from any stage; cases with a curve or a convergence to
show have a figure here, all others a table alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
from matplotlib import ticker
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pidpanel.coupon import inelastic
from pidpanel.coupon.liggghts.process import VERSION
from pidpanel.coupon.verification import contacts, shaken
from pidpanel.report import style
from pidpanel.report.html import Block, Page, Paragraph, Picture, Section, Table
from pidpanel.report.tables import number
from pidpanel.verification import Row

GREY = "#777777"


@dataclass(frozen=True)
class Shown:
    """What a case has beyond its table."""

    name: str
    """Anchor of the section and stem of the figure's file."""
    text: str
    caption: str
    figure: Callable[[Sequence[Row]], Figure]


def percent(row: Row, value: float, sign: str = "") -> str:
    """An error or tolerance of a row: relative in %, or in the unit where the truth is 0."""
    if row.reference:
        text = f"{100 * value:{sign}.2g} %"
    else:
        plus = sign if value > 0 else ""
        text = plus + number(value, 2) + (f" {row.unit}" if row.unit != "1" else "")
    return text.replace("-", "−")


def _resolutions(rows: Sequence[Row]) -> list[float]:
    return sorted({row.resolution for row in rows})


def differences(rows: Sequence[Row]) -> dict[float, list[float]]:
    """|computed − reference| at each resolution, over the points that are held at one of them."""
    held = {row.at for row in rows if row.held}
    return {
        size: [abs(r.computed - r.reference) for r in rows if r.resolution == size and r.at in held]
        for size in _resolutions(rows)
    }


def _spheres(count: float) -> str:
    return f"{count:g} sphere" + "s" * (count != 1)


# --------------------------------------------------------------------------- figures


def collision_figure(rows: Sequence[Row]) -> Figure:
    """Error of the loss against the time step, a line a restitution."""
    figure = Figure(figsize=(6.2, 3.6), layout="constrained")
    axes = figure.subplots()
    for i, restitution in enumerate(sorted({row.at for row in rows if row.reference})):
        points = sorted((r.resolution, abs(r.error)) for r in rows if r.at == restitution)
        axes.loglog(
            *zip(*points, strict=True),
            color=style.PLACES[i],
            marker=style.MARKERS[i],
            label=f"e = {restitution:g}",
        )
    steps = np.array(_resolutions(rows))[[0, -1]]
    axes.loglog(steps, 0.08 * steps, color=GREY, ls=":", label="first order")
    for row in rows:
        if row.held and row.reference:
            axes.plot(row.resolution, row.tolerance, color="black", marker="_", ms=14, mew=1.5)
            axes.annotate(
                "tolerance",
                (row.resolution, row.tolerance),
                (-9, 4),
                textcoords="offset points",
                ha="right",
                fontsize=7.5,
            )
            break
    axes.xaxis.set_major_locator(ticker.FixedLocator(_resolutions(rows)))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(ticker.NullLocator())
    axes.set_xlabel("time step over Rayleigh time, –")
    axes.set_ylabel("|error| of the energy lost, worst of 8, –")
    axes.legend()
    return figure


def curve_figure(
    rows: Sequence[Row],
    truth: Callable[[float], float],
    between: tuple[float, float],
    label: str,
) -> Figure:
    """Closed form and computed points, beside their difference over the number of spheres."""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    x = np.linspace(*between, 600)
    left.plot(
        x, [truth(value) for value in x], color=style.BARE, lw=1.3, label="closed form, e = 0"
    )
    for i, size in enumerate(_resolutions(rows)):
        one = [row for row in rows if row.resolution == size]
        left.plot(
            [row.at for row in one],
            [row.computed for row in one],
            ls="none",
            marker=style.MARKERS[i],
            ms=5.5,
            color=style.PLACES[i],
            mfc=style.PLACES[i] if size == _resolutions(rows)[-1] else "white",
            label=f"LIGGGHTS, {_spheres(size)}",
        )
    held = [row.at for row in rows if row.held]
    beyond = [row.at for row in rows if row.at > max(held)]
    if beyond:
        left.axvspan(0.5 * (max(held) + min(beyond)), between[1], color="#eeeeee", lw=0)
        left.annotate(
            "shown, not held", (between[1], 0.02), (-3, 0), xycoords=("data", "axes fraction"),
            textcoords="offset points", ha="right", fontsize=7, color=GREY,
        )  # fmt: skip
    left.set_xlabel(label)
    left.set_ylabel("energy per cycle over $m A^2 \\omega^2$, –")
    left.set_xlim(*between)
    left.set_ylim(bottom=0)
    left.legend(loc="upper left")
    _difference_axes(right, rows)
    return figure


def _difference_axes(axes: Axes, rows: Sequence[Row]) -> None:
    found = differences(rows)
    axes.loglog(
        list(found),
        [float(np.mean(values)) for values in found.values()],
        color=style.BARE,
        marker="o",
        ms=5,
    )
    axes.xaxis.set_major_locator(ticker.FixedLocator(list(found)))
    axes.xaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    axes.xaxis.set_minor_locator(ticker.NullLocator())
    axes.set_xlabel("spheres that stand for the body, –")
    axes.set_ylabel("mean |difference| over the held points, $m A^2 \\omega^2$")


def slug_figure(rows: Sequence[Row]) -> Figure:
    """Energy against the clear gap."""
    return curve_figure(
        rows,
        inelastic.slug_energy,
        (0.05, inelastic.LONGEST_GAP),
        "clear gap over amplitude, L/A, –",
    )


def floor_figure(rows: Sequence[Row]) -> Figure:
    """Energy against the level."""
    return curve_figure(
        rows,
        inelastic.floor_energy,
        (0.8, inelastic.LARGEST_LEVEL),
        "acceleration amplitude over gravity, Γ, –",
    )


SHOWN = {
    contacts.COLLISION: Shown(
        "collision",
        "A restitution e asks for the share 1 − e² of the energy of the relative motion. What is "
        "lost depends on the moment within a time step at which the spheres meet, so eight pairs "
        "meet at eight moments, and the worst of them counts.",
        "Error of the energy lost in a head-on collision against the time step. It falls in "
        "proportion to the step.",
        collision_figure,
    ),
    shaken.SLUG: Shown(
        "slug",
        "A perfectly inelastic body in a shaken box is collected by one wall, thrown, and "
        "collides with the other. LIGGGHTS has no perfectly inelastic sphere (it refuses "
        f"e ≤ 0.05): a bed of spheres with e = {shaken.BED_RESTITUTION:g} and friction stands for "
        "it, in a narrow hexagonal cell without friction; the more of them there are, the less of "
        "their speed survives a landing. The gap L is the free path of their centre of mass. The "
        "spheres are hard, so that the deepest overlap is 0.2 % of the amplitude: soft ones "
        "rebound together as one spring. Beyond L = πA the body of the closed form leaves a wall "
        "in the moment in which it lands; a bed of spheres does not stay together there, and "
        "dissipates less.",
        "Left: energy per cycle against the clear gap, closed form and LIGGGHTS; the largest, 4, "
        "is at L = πA and is the bound that every case of a study is shown against. Right: how the "
        "difference falls with the number of spheres.",
        slug_figure,
    ),
    shaken.FLOOR: Shown(
        "floor",
        "The same beds on a shaken floor under gravity, without a lid. The body lies on the floor "
        "until that falls away from it, flies, and lands dead. Near Γ = 3.3 it has no time left to "
        "lie: what little a bed of spheres rebounds then makes it miss its next throw.",
        "Left: energy per cycle against the acceleration of the floor, closed form and LIGGGHTS; "
        "it starts at Γ = 1. Right: how the difference falls with the number of spheres.",
        floor_figure,
    ),
}
"""Cases with more than a table; the others need nothing here."""


# --------------------------------------------------------------------------- page


def _table(caption: str, rows: Sequence[Row], *, folded: bool = False) -> Table:
    return Table(
        caption,
        ["quantity", "computed", "reference", "unit", "error", "tolerance", "", "computed with"],
        [
            [
                row.quantity,
                number(row.computed, 4),
                number(row.reference, 4),
                row.unit if row.unit != "1" else "–",
                percent(row, row.error, "+"),
                percent(row, row.tolerance) if row.held else "–",
                ("met" if row.met else "NOT MET") if row.held else "",
                row.method,
            ]
            for row in rows
        ],
        folded=folded,
    )


def _section(case: str, rows: Sequence[Row], index: int) -> Section:
    shown = SHOWN.get(case)
    blocks: list[Block] = []
    if shown:
        blocks.append(Paragraph(shown.text))
        blocks.append(Picture(shown.name, style.png(shown.figure(rows)), shown.caption))
    held = [row for row in rows if row.held]
    sources = "; ".join(dict.fromkeys(row.source for row in rows))
    blocks.append(_table(f"Reference: {sources}", held))
    others = [row for row in rows if not row.held]
    if others:
        blocks.append(_table(f"{len(others)} more, shown and not held", others, folded=True))
    return Section(shown.name if shown else f"case-{index}", case, blocks)


def _by_case(rows: Sequence[Row]) -> dict[str, list[Row]]:
    cases: dict[str, list[Row]] = {}
    for row in rows:
        cases.setdefault(row.case, []).append(row)
    return cases


def _worst(rows: Sequence[Row]) -> Row:
    """The held row that is nearest to its tolerance, or farthest beyond it."""
    return max(rows, key=lambda row: np.nan_to_num(abs(row.error), nan=np.inf) / row.tolerance)


def page(rows: Sequence[Row], steps: Sequence[tuple[str, str]]) -> Page:
    """The page of all rows, in their order; call it within `style.context`.

    Raises
    ------
    ValueError
        For a case of which no row is held to a tolerance.
    """
    cases = _by_case(rows)
    overview = []
    for case, members in cases.items():
        held = [row for row in members if row.held]
        if not held:
            raise ValueError(f"case '{case}': no row with a tolerance")
        worst = _worst(held)
        met = sum(row.met for row in held)
        overview.append(
            [
                case,
                f"{met} of {len(held)}",
                "met" if met == len(held) else "NOT MET",
                f"{worst.quantity}: {percent(worst, worst.error, '+')}, tolerance "
                f"{percent(worst, worst.tolerance)}",
            ]
        )
    missed = [row for row in rows if row.held and not row.met]
    count = sum(row.held for row in rows)
    summary = [
        f"{count - len(missed)} of {count} numbers are within their tolerance of the truth they "
        "are held to."
    ]
    for case in (shaken.SLUG, shaken.FLOOR):
        if case in cases:
            told = ", ".join(
                f"{number(float(np.mean(values)), 2)} with {_spheres(size)}"
                for size, values in differences(cases[case]).items()
            )
            summary.append(f"{case}: mean difference in E/(m A²ω²) {told}.")
    return Page(
        title="Verification: what is computed against what is known",
        facts=[
            ("Solver", f"LIGGGHTS {VERSION}"),
            ("pidpanel", version("pidpanel")),
        ],
        assumptions=[],
        summary=summary,
        warnings=[
            f"{row.case}, {row.quantity}: error {percent(row, row.error, '+')}, tolerance "
            f"{percent(row, row.tolerance)}."
            for row in missed
        ],
        claims=Table(
            "Every case with its worst number",
            ["case", "numbers met", "verdict", "worst number"],
            overview,
        ),
        sections=[_section(case, members, i) for i, (case, members) in enumerate(cases.items())],
        steps=steps,
    )
