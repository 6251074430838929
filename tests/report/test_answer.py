"""What the page answers: which scenarios, at which level, and what can be told apart."""

import dataclasses
import math

import numpy as np
import pytest

from pidpanel.report import answer, answer_section
from pidpanel.report.answer import PointResponse
from pidpanel.report.html import Picture
from pidpanel.report.names import main_level
from pidpanel.report.templates import fill
from pidpanel.response.from_study import scenarios_of
from pidpanel.response.trust import judged
from pidpanel.sound.from_study import spectrum_of
from pidpanel.study import Study
from pidpanel.study.stated_dampers import ConstantSection
from tests.page_reader import blocks_of

POINTS = ["middle", "corner"]
SCALE = {("A_r0.1_150dB", p): 3.0 for p in POINTS} | {("A_r0.7_150dB", p): 2.8 for p in POINTS}
SCALE |= {("A_r0.9_150dB", p): 1.0 for p in POINTS} | {("B_r0.5_150dB", p): 0.5 for p in POINTS}


def doubted(study, summary):
    """A summary with the doubts that its numbers raise."""
    return judged(scenarios_of(study), summary, study.damping.coupled.relative_error)


def answer_of(study, summary):
    """The answer to it."""
    return answer.answer_of(study, doubted(study, summary))


def answered(study, respond, error_db=0.2, **changes):
    summary, _ = respond(SCALE, error_db=error_db)
    return answer_of(study, summary.assign(**changes))


def test_the_best_are_those_that_cannot_be_told_from_the_first(study, respond):
    found = answered(study, respond)
    assert [one.scenario.name for one in found.best] == ["A, r = 0.1", "A, r = 0.7"]
    assert [one.scenario.name for one in answered(study, respond, 0.01).best] == ["A, r = 0.1"]
    worse = answered(study, respond, 0.01, reduction_db=-0.3)
    assert "(+0.300 to +0.300 ± 0.010 dB)" in answer_section.headline(worse)
    # 3.0 and 2.8 dB: 0.2 dB apart, told apart from errors of 0.07 dB each on
    assert len(answered(study, respond, 0.0706).best) == 1
    assert len(answered(study, respond, 0.0708).best) == 2


def test_without_errors_no_scenario_is_called_better(study, respond):
    found = answered(study, respond, math.nan)
    assert len(found.best) == len(found.candidates) > 3
    said = answer_section.headline(found)
    assert "±" not in said and "nan" not in said
    assert all("no stated error" in one.doubts for one in found.candidates)


def test_a_gain_within_its_error_is_none(study, respond, inputs):
    weights = {"added_mass_kg": 0.3, "added_mass_percent": 5.0}
    for error, text in ((1.6, "–"), (1.4, "10")):
        rows = answer_table(inputs, answered(study, respond, error, **weights)).rows
        assert rows[1][-2] == text


def test_nothing_is_told_apart_with_an_error_that_is_not_a_number():
    one, other = PointResponse(1.0, math.nan, 6.0, math.nan), PointResponse(1.0, 0.1, 0.0, 0.1)
    assert not answer.are_distinct(one, other)
    assert answer.is_gain(one) is None and answer.is_gain(other) is False


def test_the_error_of_the_damping_model_is_common_to_both():
    one, other = (
        PointResponse(1.0, 0.1, db, math.hypot(0.2, error), model_error=error)
        for db, error in ((6.0, 1.5), (5.0, 1.4))
    )
    # two errors of 0.2 and a difference of 0.1
    assert answer.are_distinct(one, other)
    closer = other._replace(reduction=5.45)
    assert not answer.are_distinct(one, closer)


def test_a_point_on_a_support_takes_no_part(study, respond):
    summary, _ = respond(SCALE, error_db=0.2)
    of = summary["point"] == "middle"
    summary.loc[of & (summary["status"] == "ok"), "status"] = "held"
    summary.loc[of, ["acceleration_rms_g", "reduction_db"]] = 0.0
    found = answer.answer_of(study, summary)
    assert found.points == ("corner",)
    summary["status"] = summary["status"].replace("ok", "held")
    assert answer.answer_of(study, summary) is None


def test_the_answer_is_at_the_level_of_the_study_or_of_most_scenarios(study):
    assert main_level(study) == 150
    elsewhere = study.model_copy(update={"sound": study.sound.model_copy(update={"oaspl_db": 120})})
    # the families without a level of their own follow the study
    assert main_level(elsewhere) == 120
    family = {"level": study.scenarios["level"]}
    alone = elsewhere.model_copy(update={"scenarios": family})
    assert isinstance(alone, Study) and main_level(alone) == 150


def test_levels_that_are_written_alike_are_one(study, respond):
    # 136.7 dB of a scenario beside 136.738 of the table
    summary, _ = respond(SCALE)
    of = summary["scenario"] == "A_r0.5_140dB"
    for level, joins in ((150.03, True), (149.9, False)):
        summary.loc[of, "oaspl_db"] = level
        labels = [one.scenario.label for one in answer_of(study, summary).candidates]
        assert ("A_r0.5_140dB" in labels) == joins


def test_the_model_of_lowest_rank_answers_and_says_what_the_others_find(study, respond_to):
    lab = {"equivalent_damping_n_s_m3": 300, "apparent_mass_kg_m2": 1}
    text = study.scenarios["fill"].model_copy(update={"damper": ("law", "lab")})
    dampers = study.dampers | {"lab": ConstantSection.model_validate(lab)}
    both = study.model_copy(update={"dampers": dampers, "scenarios": {"fill": text}})
    lowered = {s.label: 4.0 if s.dampers == "lab" else 2.0 for s in both.all_scenarios()}
    summary, _ = respond_to(both, {(label, p): db for label, db in lowered.items() for p in POINTS})
    found = answer_of(both, summary)
    assert {one.scenario.dampers for one in found.candidates} == {"lab"}
    assert len(found.candidates) == 3
    for one in found.candidates:
        ((name, said),) = one.alternatives
        assert name == "law" and said.reduction == pytest.approx(2.0)


def answer_table(inputs, found):
    """The table below the first sentence."""
    return blocks_of(answer_section.answer_fragment(inputs, found))[0]


def test_the_table_says_whether_a_number_is_to_be_trusted(study, respond, inputs):
    found = answered(study, respond, levels=2, extrapolated_share=0.12)
    table = answer_table(inputs, found)
    assert len(table.rows) <= 6
    for row in table.rows[1:]:
        assert len(row) == len(table.columns)
        assert row[-1] == (
            "no: 12 % of the change extrapolated, extend dem to 61 g; "
            "several solutions, use it as an upper bound"
        )
    good = answer_table(inputs, answered(study, respond))
    assert [row[-1] for row in good.rows] == ["yes"] * len(good.rows)
    between = answer_table(inputs, answered(study, respond, between_share=0.3))
    assert between.rows[1][-1] == "yes; simulate for a smaller ±"
    # g rms ± error (3σ), and dB ± error
    assert good.rows[1][3].startswith("125.0 ± 2.9 (375)") and good.rows[1][-3] == "3.00 ± 0.20"


@pytest.mark.parametrize("error", [math.nan, 0.5])
def test_the_error_of_the_load_is_named_where_the_bare_panel_has_one(inputs, study, respond, error):
    found = answered(study, respond)
    bare = {name: one._replace(rms_error=error) for name, one in found.bare.responses.items()}
    loaded = dataclasses.replace(found, bare=found.bare._replace(responses=bare))
    fragment = answer_section.answer_fragment(inputs, loaded)
    named = "on which sound loads the surface" in fill("answer.html", fragment.values)
    assert named == (error > 0)


def test_the_curves_of_the_answer_are_the_bare_panel_and_the_best(inputs, study, respond):
    summary, psd = respond(SCALE, error_db=0.2)
    one = dataclasses.replace(inputs, summary=summary, psd=psd)
    picture = answer_section.psd_picture_of(one, answer_of(study, summary))
    assert isinstance(picture, Picture)
    (chart,) = picture.charts
    assert [curve.label.split(":")[0] for curve in chart.curves] == ["bare panel", "A, r = 0.1"]
    bare, best = chart.curves
    assert best.values == pytest.approx(bare.values / 10**0.3)
    assert best.log_error == pytest.approx(np.full(len(best.values), 0.2 * np.log(10) / 10))


def test_coupled_runs_answer_as_any_model_does(coupled, coupled_study):
    found = answer_of(coupled_study, coupled.summary)
    assert found.is_coupled and found.candidates[0].scenario.name == "A, r = 0.5"
    assert not any(one.doubts for one in found.candidates)
    curve = answer_section.psd_picture_of(coupled, found).charts[0].curves[1]
    psd = coupled.psd["acceleration_psd"].sel(scenario="A_r0.5_150dB", point=found.worst)
    assert curve.values[0] * 9.80665**2 == pytest.approx(psd.to_numpy().ravel()[0])


def test_a_study_without_a_level_answers_at_that_of_its_spectrum(study):
    none = study.sound.model_copy(update={"oaspl_db": None})
    table = round(spectrum_of(none).oaspl, 1)
    family = study.scenarios["level"].model_copy(update={"oaspl_db": (table - 10, table, 170.0)})
    one = study.model_copy(update={"sound": none, "scenarios": {"level": family}})
    assert main_level(one) == table
