"""Scenarios as a reader knows them: in every sentence, table and legend of a page the same."""

import math
from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

from pidpanel.sound.from_study import spectrum_of
from pidpanel.study import CouponStudy as CouponStudy
from pidpanel.study import Scenario as Scenario
from pidpanel.study import Study as Study
from pidpanel.study.claims import Claim as Claim
from pidpanel.study.severity import Severity as Severity
from pidpanel.study.structure import Structure

SAME_LEVEL = 0.05  # difference of two levels below which they are written alike [dB]


class ComparedScenarios(NamedTuple):
    """Scenarios that differ in one key."""

    key: str
    title: str
    varied: str
    scenarios: tuple[Scenario, ...]
    # The same by damping model, with its title; one group where dampers are compared
    groups: Mapping[str, tuple[Scenario, ...]] = {}


def family_of(study: Study, key: str) -> ComparedScenarios:
    """Return a family of a study with its scenarios."""
    family, scenarios = study.families[key], study.family_scenarios(key)
    by_title: dict[str, list[Scenario]] = {}
    for scenario in scenarios:
        title = "" if family.varied == "damper" else model_title(study, scenario)
        by_title.setdefault(title, []).append(scenario)
    groups = {title: tuple(group) for title, group in by_title.items()}
    has_levels = len({scenario.oaspl_db for scenario in scenarios}) > 1
    varied = "oaspl_db" if has_levels else family.varied
    return ComparedScenarios(key, family.title, varied, scenarios, groups)


def model_title(study: Study, scenario: Scenario) -> str:
    """Return what a page calls the damping of a scenario: damping models, and of which damper."""
    title = " and ".join(text.title for text in study.model_texts(scenario))
    return f"{scenario.dampers}: {title}" if scenario.has_dampers else title


def damper_titles(study: Study) -> dict[str, str]:
    """Return the title of the damping model of each damper of the scenarios."""
    return {name: study.dampers[name].text.title for name in study.scenario_dampers}


def main_scenarios(study: Study) -> list[Scenario]:
    """Return the bare panels, and the scenarios whose damping model answers first."""
    return [s for s in study.all_scenarios() if s.is_bare or study.is_main(s)]


def layouts_of(study: Study) -> list[Scenario]:
    """Return the explicit layouts of a study."""
    return [scenario for name in study.layouts for scenario in study.family_scenarios(name)]


def noun_of(study: Study) -> str:
    """Return what a study is of: a panel or a structure."""
    return "structure" if isinstance(study.panel, Structure) else "panel"


def motion_of(study: Study) -> str:
    """Return the direction of the base motion in words."""
    if not isinstance(study.panel, Structure) or study.base is None:
        return "the normal"
    x, y, z = study.base.direction or (0.0, 0.0, 1.0)
    return f"({x:g}, {y:g}, {z:g})"


def names_of(study: Study) -> dict[str, str]:
    """Return the names of scenarios by label, with the level where the study has several.

    Several dampers together go by their label, and so do two scenarios that would have one name.
    """
    scenarios = study.all_scenarios()
    several = len({scenario.oaspl_db for scenario in scenarios}) > 1
    names = {}
    for scenario in scenarios:
        level = scenario.oaspl_db
        suffix = f", {study.acoustics.level_text(level)}" if several and level is not None else ""
        name = f"bare {noun_of(study)}" if scenario.is_bare else scenario.name
        if len(scenario.fillings) > 1:
            name = scenario.layout_label
            suffix = suffix if name != scenario.label else ""
        names[scenario.label] = name + suffix
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
