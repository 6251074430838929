"""Which runs a sweep asks for, and what a label says."""

import math

import pytest

from pidpanel.coupon import contact
from pidpanel.coupon.from_study import cases_of
from pidpanel.study.coupon_study import VariedCoupon
from tests.coupons import with_changes


def coupon(**changes):
    sweep = {"fill_fraction": [0.3, 0.6], "frequency_hz": [50, 500], "acceleration_g": [5, 50]}
    return VariedCoupon.model_validate(with_changes({"sweep": sweep}, changes))


def test_every_combination_is_a_case_with_a_label_of_its_own():
    found = cases_of(coupon())
    assert len(found) == 8
    assert len({case.label for case in found}) == 8
    assert found[0].label.startswith("r0.3_f50Hz_a5g_d2mm_")


def test_combinations_too_fast_are_left_out():
    found = cases_of(coupon(sweep={"max_velocity_m_s": 1.0}))
    # 50 g at 50 Hz is 1.56 m/s
    assert {(c.point.drive.frequency, round(c.point.drive.gamma)) for c in found} == {
        (50, 5), (500, 5), (500, 50),
    }  # fmt: skip


def test_one_packing_serves_every_fill_frequency_and_level():
    found = cases_of(coupon())
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
        {"gravity_direction": [1, 0, 0]},
        {"cell": {"shape": "square"}},
        {"particles": {"distribution": {"kind": "uniform", "half_width_mm": 0.2}}},
        {"particles": {"rolling_friction": 0.1}},
        {"particles": {"shell_mm": 0.1}},
        {"walls": {"youngs_modulus_mpa": 70000}},
    ],
)
def test_whatever_the_result_depends_on_changes_the_label(change):
    before = {case.label for case in cases_of(coupon())}
    after = {case.label for case in cases_of(coupon(**change))}
    assert not before & after


def test_a_run_is_the_same_run_whatever_accuracy_is_asked_of_it():
    before, after = (cases_of(coupon(accuracy={"relative_error": error})) for error in (0.05, 0.01))
    assert [case.label for case in before] == [case.label for case in after]
    assert before[0].target.label == "7.07106781pc_12to400"
    assert after[0].target.label == "1.41421356pc_12to400"


def test_an_amplitude_of_displacement_is_the_acceleration_over_omega_squared():
    sweep = {"fill_fraction": [0.5], "frequency_hz": [80], "acceleration_g": []}
    (case,) = cases_of(coupon(sweep=sweep | {"displacement_mm": [0.2]}))
    assert case.point.drive.amplitude == pytest.approx(0.2e-3, rel=1e-12)
    assert case.point.drive.acceleration == pytest.approx(0.2e-3 * (2 * math.pi * 80) ** 2)


def test_any_key_of_the_coupon_can_be_varied_and_becomes_a_column():
    vary = {"particles.friction": [0.1, 0.6], "gravity_direction": [[0, 0, -1], [2, 0, 0]]}
    found = cases_of(coupon(vary=vary))
    assert len(found) == 4 * 8
    assert found[0].varied == {"particles.friction": 0.1, "gravity_direction": "0 0 -1"}
    last = found[-1]
    assert last.varied == {"particles.friction": 0.6, "gravity_direction": "2 0 0"}
    assert last.point.constants.friction == last.point.constants.wall_friction == 0.6
    assert last.point.bed.gravity_direction == (1.0, 0.0, 0.0)


def test_a_stiff_wall_is_softened_in_the_same_proportion_as_the_spheres():
    run = cases_of(coupon(walls={"youngs_modulus_mpa": 64000}))[1].point
    assert run.constants.youngs_modulus < 3200e6
    assert run.constants.wall_youngs_modulus == pytest.approx(20 * run.constants.youngs_modulus)


def test_a_bed_that_bounces_as_one_body_is_as_stiff_as_its_material():
    low, high = cases_of(coupon())[:2]  # 5 and 50 g at 50 Hz
    assert low.point.constants.youngs_modulus == 3200e6
    assert high.point.constants.youngs_modulus < 3200e6
    soft = cases_of(coupon(stiffness={"from_acceleration_g": 0}))
    assert soft[0].point.constants.youngs_modulus < 3200e6


STEEL = {
    "density_kg_m3": 7850, "youngs_modulus_mpa": 200000, "poissons_ratio": 0.3, "friction": 0.2,
}  # fmt: skip


def steel_at(gamma, **changes):
    sweep = {"fill_fraction": [0.7], "frequency_hz": [80], "acceleration_g": [gamma]}
    (case,) = cases_of(coupon(particles=STEEL, sweep=sweep, **changes))
    return case


def test_contacts_are_harder_where_the_bed_may_cross_its_gap():
    # steel at r = 0.7, 80 Hz, 80 g rides at 50 MPa and crosses from 100 MPa on: W/L = 0.41
    run = steel_at(80).point
    assert run.bed.stroke_per_gap(run.drive) == pytest.approx(3.105e-3 / 7.5e-3, rel=1e-3)
    modulus = run.constants.youngs_modulus
    assert modulus == 800e6
    assert run.contact_time_at(modulus) * 80 <= 0.01 and run.overlap_at(modulus) <= 0.05
    assert run.contact_time_at(200e6) * 80 <= 0.01 and run.overlap_at(200e6) > 0.05
    # below and above the range the wider limits hold
    below, above = steel_at(15).point, steel_at(110).point
    assert below.bed.stroke_per_gap(below.drive) < 0.1
    # thrown as one body of 8.75 layers: contacts of 0.02/1.4³ periods
    assert below.constants.youngs_modulus == 800e6
    assert above.bed.stroke_per_gap(above.drive) > 0.5
    assert above.constants.youngs_modulus == 200e6
    # the bed that all of them start from is one
    assert run.bed == below.bed == above.bed


def test_limits_of_the_study_hold_where_it_says():
    wide = {"stiffness": {"crossing": {"stroke_per_gap": [0.5, 1], "overlap_per_radius": 0.04}}}
    assert steel_at(80, **wide).point.constants.youngs_modulus == 50e6
    assert steel_at(110, **wide).point.overlap_at(800e6) > 0.04
    assert steel_at(110, **wide).point.constants.youngs_modulus == 200e9
    lax = {"stiffness": {"crossing": {"overlap_per_radius": 0.4, "contact_time_per_period": 0.4}}}
    assert steel_at(80, **lax).point.constants.youngs_modulus == 50e6


def test_a_full_bed_has_no_gap_and_the_limits_of_any_other():
    full = cases_of(coupon(sweep={"fill_fraction": [1.0], "acceleration_g": [50]}))[0].point
    assert full.bed.stroke_per_gap(full.drive) == math.inf
    assert full.constants.youngs_modulus == 50e6


@pytest.mark.parametrize(
    ("gravity", "direction", "rides"),
    [
        (1, [0, 0, -1], True),
        (0.25, [0, 0, -1], False),
        (1, [1, 0, 0], False),
        (0, [0, 0, -1], False),
    ],
    ids=["upright", "light", "lying", "weightless"],
)
def test_a_bed_that_does_not_reach_the_lid_has_no_states_to_be_looked_for(
    gravity, direction, rides
):
    # 4 g at 30 Hz, r = 0.7: W/L = 0.15, and the bed rises by 0.3 of the gap under 1 g
    sweep = {"fill_fraction": [0.7], "frequency_hz": [30], "acceleration_g": [4]}
    (case,) = cases_of(coupon(sweep=sweep, gravity_g=gravity, gravity_direction=direction))
    assert 0.1 < case.point.bed.stroke_per_gap(case.point.drive) < 0.5
    assert (case.state_cycles == 0) == (case.runs[1].start == "rest") == rides
    assert (not case.reserve) == rides


def deep(fill, gamma, frequency=250.0):
    sweep = {"fill_fraction": [fill], "frequency_hz": [frequency], "acceleration_g": [gamma]}
    return cases_of(coupon(sweep=sweep, particles={"youngs_modulus_mpa": 3200.0}))[0]


def test_deep_beds_thrown_as_one_body_are_shaken_with_harder_contacts():
    # r = 0.9, 250 Hz: η at 200 MPa over that at 3200 is 1.21 at 20 g, 1.14 at 40 g
    assert [deep(0.5, gamma).point.constants.youngs_modulus for gamma in (20, 40)] == [200e6, 200e6]
    for gamma in (20, 40):
        assert deep(0.9, gamma).point.constants.youngs_modulus == 3200e6
        assert deep(0.9, gamma).bias == 0.0
    # agitated: 200 MPa have contacts of 0.0185 periods
    assert deep(0.9, 80, 300.0).point.constants.youngs_modulus == 200e6
    # where the bed may cross, the limits are those of crossing
    assert deep(0.9, 20, 60.0).point.bed.deepening(deep(0.9, 20, 60.0).point.drive) == 1.0


@pytest.mark.parametrize(("gravity", "direction", "soft"), [(1, -1, True), (4, -1, False), (4, 0, True)])  # fmt: skip
def test_a_bed_is_one_body_up_to_an_acceleration_that_grows_with_what_presses_it(
    gravity, direction, soft
):
    """At 4 g, 36 g throw a bed as 9 g do at 1 g."""
    sweep = {"fill_fraction": [0.5], "frequency_hz": [150], "acceleration_g": [36]}
    values = {"gravity_g": gravity, "gravity_direction": [1 + direction, 0, direction]}
    (case,) = cases_of(coupon(sweep=sweep, particles={"youngs_modulus_mpa": 3200.0}, **values))
    assert (case.point.constants.youngs_modulus < 3200e6) is soft
    assert case.point.bed.constants.youngs_modulus < 3200e6  # while it is shaken loose


def test_the_bias_of_a_deep_bed_is_larger_as_the_cube_of_its_layers():
    # 2.5 (t_c f − t_c0 f) (0.7 25 mm/(6.25 · 2 mm))³
    case = deep(0.7, 20, 90.0)
    run = case.point
    assert run.constants.youngs_modulus == 200e6
    longer = run.contact_time_at(200e6) - run.contact_time_at(3200e6)
    assert case.bias == pytest.approx(2.5 * longer * 90 * 1.4**3)


def test_the_bias_of_overlaps_is_that_of_a_bed_over_twice_its_gap_where_it_crosses():
    # r = 0.7: a bed of 0.7 depths shortens against twice 0.3
    crossing, riding = steel_at(80), steel_at(15)
    run = crossing.point
    deeper = run.overlap_at(800e6) - run.overlap_at(200e9)
    assert crossing.bias == pytest.approx(1.5 * 0.7 / 0.6 * deeper)
    run = riding.point
    longer = run.contact_time_at(800e6) - run.contact_time_at(200e9)
    assert riding.bias == pytest.approx(2.5 * longer * 80 * 1.4**3)


def test_a_hollow_sphere_weighs_its_shell():
    run = cases_of(coupon(particles={"shell_mm": 0.2}))[0].point
    # 4/3 π (R³ − (R − t)³) of a shell of 0.2 mm on 1 mm
    assert run.packing.density == pytest.approx(1190 * (1 - 0.8**3))


def test_the_time_step_is_that_of_the_smallest_sphere_and_the_softness_of_the_largest():
    wide = {"distribution": {"kind": "binary", "second_mm": 1.0, "second_share": 0.5}}
    run = cases_of(coupon(particles=wide))[0].point
    assert (run.packing.sizes.smallest, run.packing.sizes.largest) == (1e-3, 2e-3)
    smallest = contact.ElasticSphere(0.5e-3, 1190.0, run.constants.youngs_modulus, 0.35)
    assert run.time_step <= 0.15 * smallest.rayleigh_time


def test_a_period_is_a_whole_number_of_steps_and_of_samples():
    for case in cases_of(coupon(sweep={"frequency_hz": [37.3, 211.7, 1999.0]})):
        run = case.point
        assert run.steps_per_cycle % run.samples_per_cycle == 0
        periods = run.steps_per_cycle * run.time_step * run.drive.frequency
        assert periods == pytest.approx(1, rel=1e-14)


def test_a_run_lasts_at_least_the_least_time():
    found = cases_of(coupon(accuracy={"min_time_s": 0.1, "max_cycles": 40}))
    for case in found:
        assert case.target.min_cycles / case.point.drive.frequency >= 0.1
        assert case.target.max_cycles >= case.target.min_cycles
    assert {c.target.min_cycles for c in found if c.point.drive.frequency == 500} == {50}


def test_walls_are_as_the_spheres_unless_they_are_said_to_differ():
    run = cases_of(coupon())[0].point
    assert (run.packing.wall_friction, run.bed.constants.wall_restitution) == (0.3, 0.8)
    run = cases_of(coupon(walls={"friction": 0.2, "restitution": 0.9}))[0].point
    assert (run.packing.wall_friction, run.bed.constants.wall_restitution) == (0.2, 0.9)
