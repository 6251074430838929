"""Studies that cannot be meant are refused at their line, with key, kind and the likely unit."""

from pathlib import Path

import pytest
import yaml

STUDIES = yaml.safe_load((Path(__file__).parent / "wrong.yaml").read_text("utf-8"))["studies"]
CASES = [
    (base, old, new, mistakes if isinstance(mistakes, list) else [mistakes])
    for base, changes in STUDIES.items()
    for old, values in changes.items()
    for new, mistakes in values.items()
]


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}: {case[2][:50]!r}")
def test_what_cannot_be_meant_is_refused(wrong, case):
    base, old, new, mistakes = case
    wrong(base, old, new, *mistakes)


@pytest.mark.parametrize(
    ("base", "old", "key", "count", "mistake"),
    [
        ("design", "mass_kg: 0.9", "mass_kg: 0.9\n  fill_fraction", 51, "@fill| optimise.fill_fraction: count"),
        ("coupon", "[0.4, 0.8]", "", 60_000, "@sweep:| coupon.sweep: too many"),
        ("coupon", "accuracy:", "vary: {particles.friction: [0.1, 0.2], particles.restitution: ", 900_000, "@| too many"),
    ],
)  # fmt: skip
def test_more_values_than_a_machine_computes_are_refused(wrong, base, old, key, count, mistake):
    values = ", ".join(f"{0.1 + k * (0.01 if count < 100 else 1e-6):.6f}" for k in range(count))
    wrong(base, old, f"{key}{': ' if key[-1:] == 'n' else ''}[{values}]{'}' * key.count('{')}", mistake)  # fmt: skip


def keys(told):
    return [line.split(": ")[1].split(" = ")[0] for line in told]


def test_mistakes_between_sections_are_told_where_there_are_none_within(written, bases, change):
    study = change(bases["sandwich"], "damper: lab", "damper: Lab")
    study = change(study, "slanted: {damper: foil}", "slantd: {damper: foil}")
    assert keys(written(study).told()) == ["scenarios.fill.damper", "scenarios.both.layout.slantd"]
    study = change(study, "damping_ratio: 0.01", "damping_ratio: 1")
    study = change(study, "loss_factor: 0.1", "loss_factor: 10")
    assert keys(written(study).told()) == ["panel.damping_ratio", "dampers.layer.loss_factor"]


def test_a_cell_has_one_fill_and_may_lie_under_a_blanket(written, bases, change):
    study = change(bases["sandwich"], "centre_m: [0.4, 0.3]", "centre_m: [0.2, 0.65]")
    assert written(study).told() == []
    study = change(study, "round: {damper: Tuned}", "round: {damper: lab, fill_fraction: 0.5}")
    assert written(study).told() == []
    study = change(study, "slanted: {damper: foil}", "slanted: {damper: lab, fill_fraction: 0.6}")
    (said,) = written(study).told()
    assert said.endswith("covers cells of round too; a cell has only one fill fraction")


def test_the_fills_of_a_table_are_compared(written, bases, change):
    study = change(bases["sandwich"], "[0.4, 0.8]\n  both", "[0.4, 0.95]\n  both")
    assert keys(written(study).told()) == ["scenarios.fill.fill_fraction[1]"]


def test_a_section_that_is_missing_brings_no_mistakes_of_others(written, bases, change):
    assert keys(written(change(bases["thin"], "panel:\n", "panl:\n")).told()) == ["panel", "panl"]
