"""The facts at the head of a page are those of the study."""

import dataclasses

from pidpanel.report import facts


def test_the_largest_error_of_the_power_balance_is_named(inputs):
    summary = inputs.summary.copy()
    summary.loc[0, "power_balance_error"] = 3e-7
    rows = dict(facts.study_facts(dataclasses.replace(inputs, summary=summary)))
    assert rows["Power balance"].startswith("power input and power loss agree within 3.0·10⁻⁷ of")
    assert "Coupon" not in rows


def test_a_coupon_is_counted_by_its_cases_that_are_ok(cases):
    cases.loc[[1, 5], "status"] = "NotSteady"
    assert facts.cases_text(cases) == "12 cases, 10 of them ok"


def test_the_largest_error_of_the_basis_is_named(inputs):
    summary = inputs.summary.copy()
    summary.loc[0, "basis_error"] = 0.0042
    rows = dict(facts.study_facts(dataclasses.replace(inputs, summary=summary)))
    assert rows["Basis"].startswith("misses at most 0.42 % of a PSD")


def test_modes_of_a_file_have_no_known_error_of_the_mesh(inputs, foreign):
    rows = dict(facts.study_facts(dataclasses.replace(inputs, study=foreign)))
    assert rows["Mesh"].endswith(
        "natural frequencies are those of the file, whose error is not known"
    )
    assert rows["Basis"].endswith("the change by the last modes or the static cases")
    assert "which changes PSDs by at most" in dict(facts.study_facts(inputs))["Mesh"]
