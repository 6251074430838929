"""Which runs a sweep asks for, and what a label stands for."""

import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import cases, contact
from pidpanel.study import Coupon


def coupon(**changes):
    values = {
        "sweep": {
            "fill_fraction": [0.3, 0.6],
            "frequency_hz": [50, 500],
            "acceleration_g": [5, 50],
        }
    }
    for key, value in changes.items():
        values[key] = {**values.get(key, {}), **value} if isinstance(value, dict) else value
    return Coupon.model_validate(values)


def test_every_combination_is_a_case_with_a_label_of_its_own():
    found = cases.cases_of(coupon())
    assert len(found) == 8
    assert len({case.label for case in found}) == 8
    assert found[0].label.startswith("r0.3_f50Hz_a5g_d2mm_")


def test_sphere_sizes_multiply_the_cases():
    found = cases.cases_of(coupon(sweep={"diameter_mm": [1.5, 2.0, 2.5]}))
    assert len(found) == 24
    assert {case.point.packing.diameter for case in found} == {1.5e-3, 2.0e-3, 2.5e-3}


def test_combinations_too_fast_are_left_out():
    found = cases.cases_of(coupon(sweep={"max_velocity_m_s": 1.0}))
    # 50 g at 50 Hz is 1.56 m/s
    assert {(c.point.frequency, round(c.point.acceleration / STANDARD_GRAVITY)) for c in found} == {
        (50, 5), (500, 5), (500, 50),
    }  # fmt: skip


def test_one_packing_serves_every_fill_frequency_and_level():
    found = cases.cases_of(coupon())
    assert len({run.packing for case in found for run in case.runs}) == 2  # one a seed
    assert len({run.bed for case in found for run in case.runs}) == 4  # fills times seeds


@pytest.mark.parametrize(
    "change",
    [
        {"particles": {"friction": 0.31}},
        {"particles": {"restitution": 0.81}},
        {"walls": {"friction": 0.2}},
        {"cell": {"depth_mm": 26}},
        {"cell": {"count": 6}},
        {"gravity_g": 0.0},
        {"time_step_rayleigh": 0.1},
        {"samples_per_cycle": 50},
        {"accuracy": {"relative_error": 0.01}},
    ],
)
def test_whatever_the_result_depends_on_changes_the_label(change):
    before = {case.label for case in cases.cases_of(coupon())}
    after = {case.label for case in cases.cases_of(coupon(**change))}
    assert not before & after


def test_the_deck_belongs_to_the_label(monkeypatch):
    before = {case.label for case in cases.cases_of(coupon())}
    monkeypatch.setattr(cases, "_template_hash", lambda names: "another deck")
    assert not before & {case.label for case in cases.cases_of(coupon())}


def test_a_run_survives_its_way_through_json():
    run = cases.cases_of(coupon())[0].runs[0]
    assert cases.Run.from_dict(run.as_dict()) == run


def test_a_period_is_a_whole_number_of_steps_and_of_samples():
    for case in cases.cases_of(coupon(sweep={"frequency_hz": [37.3, 211.7, 1999.0]})):
        run = case.point
        assert run.steps_per_cycle % run.samples_per_cycle == 0
        assert run.steps_per_cycle * run.time_step * run.frequency == pytest.approx(1, rel=1e-14)
        longest = 0.15 * contact.rayleigh_time(1e-3, 1190.0, run.youngs_modulus, 0.35)
        assert run.time_step <= longest


def test_a_run_lasts_at_least_the_least_time():
    found = cases.cases_of(coupon(accuracy={"min_time_s": 0.1, "max_cycles": 40}))
    for case in found:
        assert case.point.min_cycles / case.point.frequency >= 0.1
        assert case.point.max_cycles >= case.point.min_cycles
    assert {c.point.min_cycles for c in found if c.point.frequency == 500} == {50}


def test_walls_are_as_the_spheres_unless_they_are_said_to_differ():
    run = cases.cases_of(coupon())[0].point
    assert (run.packing.wall_friction, run.bed.wall_restitution) == (0.3, 0.8)
    run = cases.cases_of(coupon(walls={"friction": 0.2, "restitution": 0.9}))[0].point
    assert (run.packing.wall_friction, run.bed.wall_restitution) == (0.2, 0.9)
