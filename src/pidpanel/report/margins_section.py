"""Margins to the limits of a study on the page: the verdict in a sentence, and a small table."""

import itertools
from collections.abc import Sequence

import pandas as pd

from pidpanel.report.html import Fragment, PageSection, template_section
from pidpanel.report.names import Study, main_level, main_scenarios, names_of, with_names
from pidpanel.report.templates import lines
from pidpanel.report.text import records
from pidpanel.response.trust import doubts_in

CASE = ["excitation", "scenario"]
EXCITATIONS = {
    "sound": " under sound", "base": " under base motion", "notched base": " with the notched input"
}  # fmt: skip


def margin_lines(study: Study, margins: pd.DataFrame) -> list[str]:
    """Return the verdict under each excitation: of the best scenario, and of the bare panel.

    The best has the largest of the least margins, at the level at which the study answers.
    """
    level, main = main_level(study), main_scenarios(study)
    at_level = [s.label for s in main if s.oaspl_db == level]
    bare = [
        label for s in study.all_scenarios() if s.is_bare for label in (s.label, s.layout_label)
    ]
    results, groups = [], margins.groupby("excitation", sort=False)
    for excitation, group in groups:
        rows = group[group["scenario"].isin(at_level)] if excitation == "sound" else group
        rows = group if rows.empty else rows
        minima = rows.loc[rows.groupby("scenario", sort=False)["margin_db"].idxmin()]
        is_bare = minima["scenario"].isin(bare)
        best = minima[~is_bare].sort_values("margin_db", ascending=False, kind="stable")
        cases = [*records(best.head(1)), *records(minima[is_bare].head(1))]
        count = len(group.drop_duplicates(["point", "quantity"]))
        table = with_names(pd.DataFrame(cases), scenario_names(study))
        results.append(
            {
                "under": EXCITATIONS[str(excitation)] if len(groups) > 1 else "",
                "rows": [{**row, "doubts": doubts_in(row)} for row in records(table)],
                "count": count,
            }
        )
    return lines("margin_lines.html", {"results": results})


def levels_fragment(study: Study, summary: pd.DataFrame, margins: pd.DataFrame | None) -> Fragment:
    """Return bare and damped g rms and the least margin of each layout at each named level."""
    place, sound = ["scenario", "point"], study.acoustics
    table = summary[summary["status"] == "ok"].assign(severity=summary["acceleration_rms_g"])
    if margins is not None:
        judged = margins[margins["excitation"] == "sound"]
        minima = judged.loc[judged.groupby(place, sort=False)["margin_db"].idxmin()]
        table = table.merge(minima[[*place, "margin_db", "verdict"]], "inner", place)
        table["severity"] = -table["margin_db"]
    by_place = {(row["scenario"], row["point"]): row for row in records(table)}
    scenarios = [s for s in main_scenarios(study) if not (s.is_bare and study.scenarios)]
    rows = []
    for level, scenario in itertools.product(sound.named_levels, scenarios):
        at_points = table[table["scenario"] == scenario.label]
        if scenario.oaspl_db == level and len(at_points):
            point = at_points.nlargest(1, "severity")["point"].iloc[0]
            row, bare = (by_place[s.label, point] for s in (scenario, scenario.bare))
            names = {"level": sound.level_text(level), "scenario": scenario.name}
            rows.append({**row, **names, "bare": bare, "is_bare": scenario.is_bare})
    values = {"rows": rows, "is_judged": margins is not None, "zero": sound.oaspl_db}
    return Fragment("levels.html", values)


def scenario_names(study: Study) -> dict[str, str]:
    """Return the names of scenarios by label, with and without a sound level."""
    layouts = {scenario.layout_label: scenario.name for scenario in study.all_scenarios()}
    return {**layouts, **names_of(study)}


def margins_section(study: Study, margins: pd.DataFrame) -> PageSection:
    """Return the least margin of each scenario to each limit."""
    case: Sequence[str] = [*CASE, "point", "quantity"]
    minima = margins.loc[margins.groupby(list(case), sort=False)["margin_db"].idxmin()]
    values = {
        "rows": records(with_names(minima, scenario_names(study))),
        "has_excitations": minima["excitation"].nunique() > 1,
        "has_bands": bool((minima["quantity"] == "psd").any()),
    }
    return template_section("margins.html", "Margins to the limits", values)
