"""Scenarios as a reader knows them: in every sentence, table and legend of a page the same."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from pidpanel.study import Scenario, Study


def scenario_name(scenario: Scenario) -> str:
    """Return a scenario without its sound level as a reader knows it.

    Examples
    --------
    >>> from pidpanel.study import Filling
    >>> one = Filling(patch="PID-1", damper=None, fill_fraction=0.5)
    >>> scenario_name(Scenario(label="PID-1_r0.5", fillings=(one,), oaspl_db=None))
    'PID-1, r = 0.5'
    >>> scenario_name(Scenario.bare_at(142.0))
    'bare panel'
    """
    if scenario.is_bare:
        return "bare panel"
    parts = []
    for filling in scenario.fillings:
        fill = [] if filling.fill_fraction is None else [f"r = {filling.fill_fraction:g}"]
        damper = [] if filling.damper in (None, "coupon") else [str(filling.damper)]
        parts.append(", ".join([filling.patch, *damper, *fill]))
    named = "; ".join(parts)
    return named if len(parts) == 1 else f"{scenario.label} ({named})"


def names_of(study: Study) -> dict[str, str]:
    """Return the name of every scenario by its label, with its level where the study has several.

    An explicit layout goes by its own name. A label remains where two scenarios would have one
    name.
    """
    scenarios = study.all_scenarios()
    several = len({scenario.oaspl_db for scenario in scenarios}) > 1
    labels = {s.label for key in study.layouts for s in study.family_scenarios(key)}
    names = {}
    for scenario in scenarios:
        level = f", {scenario.oaspl_db:g} dB" if several and scenario.oaspl_db is not None else ""
        is_own = scenario.label in labels or len(scenario.fillings) > 1
        names[scenario.label] = scenario.label if is_own else scenario_name(scenario) + level
    used = list(names.values())
    return {label: label if used.count(name) > 1 else name for label, name in names.items()}


def with_names(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table of results with the names of its scenarios in place of their labels."""
    return frame.assign(scenario=[names.get(label, label) for label in frame["scenario"]])
