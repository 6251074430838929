"""The margin over the spread of all inputs on the page: what to sign, and what to measure next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pidpanel.constants import IMPROBABLE
from pidpanel.report import html, style
from pidpanel.report.inputs import SpreadResults
from pidpanel.report.style import Drawing
from pidpanel.report.templates import lines, sentence
from pidpanel.report.text import number, records

LARGEST, SMALLEST = 6, 0.01  # shares that the figure shows
BAR = 0.32  # height of a bar
NARROWED = 0.9  # width of the interval of an input over that before the tests
KINDS = {"damped": style.PLACES[0], "bare": style.BARE}


def margin_values(results: SpreadResults, names: Mapping[str, str]) -> dict[str, Any]:
    """Return what the templates need: the governing answer, its shares, tests."""
    place = results.next_test.iloc[0][["scenario", "point", "panel"]]

    def at_place(table: pd.DataFrame, state: str, **columns: str) -> pd.DataFrame:
        wanted = pd.Series({**place, "inputs": state, **columns})
        return table[(table[list(wanted.index)] == wanted).all(axis=1)]

    ranges = results.ranges.assign(
        name=[names.get(s, s) for s in results.ranges["scenario"]],
        exceeding=[_probability(*pair) for pair in
                   zip(results.ranges["probability_exceeding"], results.ranges["samples"],
                       strict=True)],
    )  # fmt: skip
    last = "stated" if results.update is None else "updated"
    tests = at_place(results.next_test, last)
    single, pairs = (tests[tests["tests"] == count] for count in (1, 2))
    return {
        "main": dict(at_place(ranges, "stated").iloc[0]),
        "bare": dict(at_place(ranges, "stated", panel="bare").iloc[0]),
        "updated": dict(at_place(ranges, last).iloc[0]),
        "name": names.get(place["scenario"], place["scenario"]),
        "shares": records(at_place(results.shares, "stated")),
        "left": records(at_place(results.shares, last)),
        "unmeasured": dict(tests.iloc[0]),
        "tests": records(single),
        "pairs": records(pairs.head(5)),
        "ranges": records(_by_point(ranges)),
        "factor": results.factor_of_safety,
        "has_limit": bool(ranges["limit_g"].notna().any()),
        "is_stated": results.level == "p95_50",
        "worst_q2": float(ranges["q2"].min()),
        **made_tests(results),
    }


def _probability(exceeding: float, samples: int) -> str:
    """Return a probability in words; of too few samples its upper end (rule of three)."""
    threshold = 3 / samples
    return (
        f"below {100 * threshold:.2g} %"
        if exceeding < threshold
        else f"{number(100 * exceeding, 2)} %"
    )


def made_tests(results: SpreadResults) -> dict[str, Any]:
    """Return the tests that have been made, the refused ones, and the inputs that they changed."""
    if results.update is None or results.inputs is None:
        return {"made": [], "refused": [], "contradiction": None, "changed": []}
    farthest = results.update["score"].abs().groupby(results.update["test"], sort=False).idxmax()
    tests = results.update.loc[farthest]
    is_refused = tests["probability"] < IMPROBABLE
    together = float(tests["probability_together"].iloc[0])
    inputs = results.inputs
    width, stated = (inputs[f"{w}_p95"] - inputs[f"{w}_p05"] for w in ("updated", "stated"))
    changed = inputs.assign(narrowed=width / stated).sort_values("narrowed")
    return {
        "made": tests.loc[~is_refused, "test"].tolist(),
        "refused": records(tests[is_refused]),
        "contradiction": together if together < IMPROBABLE else None,
        "changed": records(changed[changed["narrowed"] < NARROWED]),
    }


def update_lines(results: SpreadResults, names: Mapping[str, str]) -> list[str]:
    """Return what tests changed, and those that contradict the stated spreads, in sentences."""
    return (
        [] if results.update is None else lines("margin_update.html", margin_values(results, names))
    )


def _by_point(ranges: pd.DataFrame) -> pd.DataFrame:
    """Return each range once with its title, point by point, the bare panel first."""
    once = ranges.drop_duplicates(["inputs", "panel", "point", "p50_g"])
    is_bare, title = once["panel"] == "bare", once["name"].copy()
    has_levels = once[is_bare].duplicated(["inputs", "point"]).any()
    title[is_bare] = "bare, " + title.str.split(", ").str[-1] if has_levels else "bare"
    title += np.where(once["inputs"] == "updated", ", after tests", "")
    once = once.assign(title=title)
    order = {name: number for number, name in enumerate(dict.fromkeys(once["point"]))}
    return once.assign(order=once["point"].map(order)).sort_values(
        ["order", "panel"], kind="stable"
    )


def margin_headline(results: SpreadResults, names: Mapping[str, str]) -> str:
    """Return the answer: the range, the margin of safety, the probability, the next test."""
    values, updates = margin_values(results, names), update_lines(results, names)
    stated = [] if values["made"] else [sentence("margin_headline.html", values)]
    return " ".join([*stated, *updates])


def margin_first(results: SpreadResults, names: Mapping[str, str]) -> html.Fragment:
    """Return the first screen: ranges against the limit, shares, the next tests."""
    values = margin_values(results, names)
    ranges = Drawing(range_figure, values["ranges"])
    values["range_figure"] = html.Picture("margin_ranges", ranges, vector=ranges)
    values["share_figure"] = html.figure_picture(
        "margin_shares", share_figure, values["shares"], values["tests"]
    )
    return html.Fragment("margin_first.html", values)


def margin_section(results: SpreadResults, names: Mapping[str, str]) -> html.PageSection:
    """Return all ranges, shares with their sources, and pairs of tests."""
    values = margin_values(results, names)
    return html.template_section("margin.html", "Spread of the inputs and margin", values)


def range_figure(rows: list[dict[str, Any]]) -> Figure:
    """Draw the 5 to 95 % of g rms as bars, bare and damped, with median, nominal and limit."""
    table = pd.DataFrame(rows)
    points = list(dict.fromkeys(table["point"]))
    figure = Figure(
        figsize=(6.4, 0.7 + 0.26 * len(table) + 0.15 * len(points)), layout="constrained"
    )
    axes, y, ticks = figure.subplots(), 0.0, []
    for point in points:
        group = table[table["point"] == point]
        for row in records(group.sort_values("panel", kind="stable")):
            width = row["p95_g"] - row["p05_g"]
            colour = KINDS[row["panel"]]
            alpha = 1.0 if row["inputs"] == "updated" else 0.6
            axes.barh(y, width, BAR * 2, left=row["p05_g"], color=colour, alpha=alpha)
            axes.plot([row["p50_g"]] * 2, [y - BAR, y + BAR], color="white", linewidth=2)
            axes.plot(row["nominal_g"], y, "D", color="black", markersize=3.5)
            ticks.append((y, f"{point}, {row['title']}"))
            y += 1
        if np.isfinite(limit := group["limit_g"].iloc[0]):
            ends = y - len(group) - 0.5, y - 0.5
            axes.plot([limit, limit], ends, color=style.PLACES[3], linewidth=2)
            axes.annotate(
                "limit", (limit, ends[0]), (3, -8), textcoords="offset points", fontsize=8
            )
        y += 0.5
    axes.set_yticks([y for y, _ in ticks], [label for _, label in ticks])
    axes.invert_yaxis()
    limits = table["limit_g"].max(skipna=True)
    right = 1.1 * max(table["p95_g"].max(), limits if np.isfinite(limits) else 0.0)
    axes.set(xlabel="acceleration [g rms]", xlim=(0, right))
    axes.grid(axis="y", visible=False)
    return figure


def share_figure(shares: list[dict[str, Any]], tests: list[dict[str, Any]]) -> Figure:
    """Draw the total shares of the inputs in the variance, and what tests would leave of it."""
    inputs = [row for row in shares if row["share"] >= SMALLEST][:LARGEST] or shares[:1]
    names = [row["input"].replace(" and ", "\nand ") for row in inputs]
    tests = tests[:LARGEST]
    parts = [
        ("share of the variance of g rms", names, [row["share"] for row in inputs]),
        ("variance left after a test", [row["measurement"] for row in tests],
         [row["share_left"] for row in tests]),
    ]  # fmt: skip
    heights = [len(names) + 1 for _, names, _ in parts]
    figure = Figure(figsize=(6.4, 0.6 + 0.26 * sum(heights)), layout="constrained")
    panes = figure.subplots(2, height_ratios=heights, sharex=True)
    for axes, (title, names, values), colour in zip(panes, parts, style.PLACES, strict=False):
        place = np.arange(len(names))
        axes.barh(place, values, 0.65, color=colour, alpha=0.75)
        for y, value in zip(place, values, strict=True):
            axes.annotate(f"{value:.2f}", (value, y), (4, 0), textcoords="offset points",
                          va="center", fontsize=8)  # fmt: skip
        axes.set_yticks(place, names)
        axes.invert_yaxis()
        axes.set(xlabel=title, xlim=(0, 1.12))
        axes.grid(axis="y", visible=False)
    return figure
