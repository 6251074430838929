"""Scenarios as a reader knows them: in every sentence, table and legend of a page the same."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from pidpanel.sound.from_study import spectrum_of
from pidpanel.study import CouponStudy as CouponStudy
from pidpanel.study import Scenario as Scenario
from pidpanel.study import Study as Study
from pidpanel.study.severity import Severity as Severity

SAME_LEVEL = 0.05  # difference of two levels below which they are written alike [dB]


class ComparedScenarios(NamedTuple):
    """Scenarios that differ in one key."""

    key: str
    title: str
    varied: str
    scenarios: tuple[Scenario, ...]


def family_of(study: Study, key: str) -> ComparedScenarios:
    """Return a family of a study with its scenarios."""
    family = study.families[key]
    return ComparedScenarios(key, family.title, family.varied, study.family_scenarios(key))


def layouts_of(study: Study) -> list[Scenario]:
    """Return the explicit layouts of a study."""
    return [scenario for name in study.layouts for scenario in study.family_scenarios(name)]


def names_of(study: Study) -> dict[str, str]:
    """Return the names of scenarios by label, with the level where the study has several.

    Several dampers together go by their label, and so do two scenarios that would have one name.
    """
    scenarios = study.all_scenarios()
    several = len({scenario.oaspl_db for scenario in scenarios}) > 1
    names = {}
    for scenario in scenarios:
        level = scenario.oaspl_db
        suffix = f", {level:g} dB" if several and level is not None else ""
        is_several = len(scenario.fillings) > 1
        names[scenario.label] = scenario.label if is_several else scenario.name + suffix
    used = list(names.values())
    return {label: label if used.count(name) > 1 else name for label, name in names.items()}


def main_level(study: Study) -> float | None:
    """Return the level at which a study answers: its own if dampers are tried there.

    Otherwise that of most scenarios, the highest of several.
    """
    study_level = study.oaspl_db
    levels = [s.oaspl_db for s in study.all_scenarios() if not s.is_bare] or [study_level]
    if study_level in levels or study.sound is None:
        return study_level
    table = spectrum_of(study.sound).oaspl
    for level in levels:
        if level is not None and abs(level - table) < SAME_LEVEL:
            return level
    return max(
        levels, key=lambda level: (levels.count(level), -math.inf if level is None else level)
    )


def with_names(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table of results with the names of its scenarios in place of their labels."""
    return frame.assign(scenario=[names.get(label, label) for label in frame["scenario"]])
