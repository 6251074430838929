"""The facts at the head of a page are those of the study."""

import dataclasses

import pytest

from pidpanel.report import facts
from pidpanel.report.inputs import CouponResults
from pidpanel.report.templates import pairs


def words(study):
    return dict(pairs("words.html", {"study": study}))


def test_the_level_of_the_sound_is_named_where_the_study_sets_it(study):
    # red: `if sound.oaspl_db` always taken
    assert "smc_s_016_2014_min_third.csv, 150 dB overall, " in words(study)["sound"]
    own = study.model_copy(update={"sound": study.sound.model_copy(update={"oaspl_db": None})})
    assert "overall" not in words(own)["sound"]


def test_the_largest_error_of_the_power_balance_is_named(inputs):
    # red: the mean; rows without a response counted
    summary = inputs.summary.copy()
    summary.loc[0, "power_balance_error"] = 3e-7
    rows = dict(facts.study_facts(dataclasses.replace(inputs, summary=summary)))
    assert rows["Power balance"].startswith("power input and power loss agree within 3.0·10⁻⁷ of")
    assert "Coupon" not in rows


@pytest.mark.parametrize("acts", [True, False])
def test_a_neglected_apparent_mass_is_named(inputs, study, acts):
    # red: the two words exchanged
    response = study.response.model_copy(update={"damper_mass": acts})
    told = study.model_copy(update={"response": response})
    rows = dict(facts.study_facts(dataclasses.replace(inputs, study=told)))
    assert rows["Response"].endswith("included" if acts else "neglected")


def test_a_coupon_is_counted_by_its_cases_that_are_ok(cases):
    # red: all cases counted twice
    cases.loc[[1, 5], "status"] = "NotSteady"
    assert facts.cases_text(cases) == "12 cases, 10 of them ok"


def test_a_study_outside_the_project_is_named_by_its_whole_path(tmp_path):
    # red: relative_to without is_relative_to
    _, command = facts.run_step(tmp_path / "mine.yaml")
    assert command == f"pidpanel run {tmp_path / 'mine.yaml'}"


def test_a_study_without_coupons_names_no_liggghts(inputs, cases):
    # red: `if dem` left out of software_text
    assert "LIGGGHTS" not in dict(facts.study_facts(inputs))["Software"]
    shaken = dataclasses.replace(inputs, coupons={"coupon": CouponResults(cases)})
    assert "LIGGGHTS 3" in dict(facts.study_facts(shaken))["Software"]


def test_the_largest_error_of_the_basis_is_named(inputs):
    # red: good['basis_error'].min()
    summary = inputs.summary.copy()
    summary.loc[0, "basis_error"] = 0.0042
    rows = dict(facts.study_facts(dataclasses.replace(inputs, summary=summary)))
    assert rows["Basis"].startswith("misses at most 0.42 % of a PSD")
