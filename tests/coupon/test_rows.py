"""What the rows of a run say: read in order, of which energy, and when they are enough."""

import math

import numpy as np
import pytest

from pidpanel.coupon import rows
from pidpanel.coupon.cycles import Estimate
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts.failures import LogTruncated
from pidpanel.study.coupon import Coupon


def run(**changes):
    values = {"sweep": {"fill_fraction": [0.5], "frequency_hz": [80], "acceleration_g": [10]}}
    return cases_of(Coupon.model_validate(values | changes))[0].point


def write(folder, leg, steps, values):
    """A file of cycle rows; the columns beside the step all hold the number of the row."""
    head = ["# Time-averaged data for fix cycle", "# TimeStep v_p_sin v_p_cos v_p c_ke c_rot v_zc"]
    lines = [
        f"{step} " + " ".join([str(value)] * 6) for step, value in zip(steps, values, strict=True)
    ]
    (folder / f"cycles_{leg}.txt").write_text("\n".join(head + lines) + "\n")


def test_the_rows_of_all_legs_follow_one_another(tmp_path):
    # red: before = 0 → 1; enumerate(legs, 1) → 2; before += leg → -=
    one = run()
    steps = one.steps_per_cycle * np.arange(1, 6)
    write(tmp_path, 1, steps[:2], [1, 2])
    write(tmp_path, 2, steps[2:], [3, 4, 5])
    read = rows.read_rows(one, tmp_path, [2, 3], 4)
    np.testing.assert_array_equal(read[:, 0], steps[:4])
    np.testing.assert_array_equal(read[:, 1], [1, 2, 3, 4])
    with pytest.raises(LogTruncated, match="5 of 6 cycles"):
        rows.read_rows(one, tmp_path, [2, 3], 6)


def as_rows(columns):
    """Rows with the columns step, p_sin, p_cos, p_mean, kinetic, rotational energy, height."""
    return np.array(columns, dtype=float)


@pytest.mark.parametrize("direction", [(0, 0, -1), (0.6, 0, -0.8), (1, 0, 0)])
def test_stored_energy_is_that_of_motion_and_of_height_against_gravity(direction):
    # red: -mass → mass; direction[2] → direction[1]; kinetic + rotational → -; * height → /
    one = run(gravity_g=2.0, gravity_direction=direction)
    found = rows.stored_energy(
        one, as_rows([[0, 0, 0, 0, 3.0, 0.5, 4e-3], [0, 0, 0, 0, 0, 0, 2e-3]]), 0.7
    )
    weight = 0.7 * 2 * 9.80665 * -direction[2]
    np.testing.assert_allclose(found, [3.5 + weight * 4e-3, weight * 2e-3], rtol=1e-12)


def test_spheres_that_move_with_the_cells_are_so_much_mass_and_no_damping():
    # in the frame of the cells they rest; red: p_sin and p_cos exchanged; mass / area → * area
    one = run()
    damping, mass = rows.harmonic(one, np.zeros((3, 7)), 0.7)
    np.testing.assert_array_equal(damping, 0)
    np.testing.assert_allclose(mass, 0.7 / one.packing.area, rtol=1e-12)
    pushed = np.zeros((1, 7))
    pushed[0, 1] = 2.0
    damping, _ = rows.harmonic(one, pushed, 0.7)
    speed = 98.0665 / (2 * math.pi * 80)
    expected = 2 * 2.0 * 2 * math.pi * 80 / (speed * one.packing.area)
    np.testing.assert_allclose(damping, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("start", "drift", "steady"),
    [
        (44, 0.0, True), (46, 0.0, False), (48, 0.0, False),
        (0, 2.9, True), (0, -2.9, True), (0, 3.1, False), (0, -3.1, False), (46, 3.1, False),
    ],
)  # fmt: skip
def test_a_run_is_steady_if_its_transient_ends_early_and_its_halves_agree(start, drift, steady):
    # of 100 cycles; red: 0.45 → 0.495; DRIFT_LIMIT = 3.3; and → or; abs left out
    assert rows.is_steady(Estimate(1.0, 0.1, start, 100 - start, drift), 100) is steady


def test_the_smallest_error_is_a_share_of_the_bound_of_inelastic_mass():
    # 2e-4 of 8 m″ f; red: FLOOR = 2.2e-4; FLOOR * → FLOOR /; mass / area → * area
    one = run()
    expected = 2e-4 * 8 * 0.7 / one.packing.area * 80
    assert rows.smallest_error(one, 0.7) == pytest.approx(expected, rel=1e-12)
