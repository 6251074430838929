"""What the rows of a run say: read in order, of which energy, and when they are enough."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pidpanel.coupon import rows
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts.failures import LogTruncated, Unphysical
from pidpanel.coupon.records import Shaken
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
    one = run(gravity_g=2.0, gravity_direction=direction)
    found = rows.stored_energy(
        one, as_rows([[0, 0, 0, 0, 3.0, 0.5, 4e-3], [0, 0, 0, 0, 0, 0, 2e-3]]), 0.7
    )
    weight = 0.7 * 2 * 9.80665 * -direction[2]
    np.testing.assert_allclose(found, [3.5 + weight * 4e-3, weight * 2e-3], rtol=1e-12)


def test_spheres_that_move_with_the_cells_are_so_much_mass_and_no_damping():
    # in the frame of the cells they rest
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


# ------------------------------------------------------------------ what no motion can have

MASS, AMPLITUDE = 0.7, 2e-3


def rigid(count=1, **changes):
    """Rows of a bed that moves as one body, p = P sin(ωt + 1): its energy is just enough."""
    p_sin, p_cos = (0.5 * AMPLITUDE * f(1.0) for f in (math.cos, math.sin))
    row = {
        "step": 0.0, "p_sin": p_sin, "p_cos": p_cos, "p_mean": 0.0,
        "kinetic_energy": AMPLITUDE**2 / (4 * MASS), "rotational_energy": 0.0, "height": 12e-3,
    }  # fmt: skip
    return np.tile(list((row | changes).values()), (count, 1))


def refused(what, **changes):
    """Whether `check_physics` refuses the rows for one reason, in the cycle that it names."""
    one = run(cell={"count": 1})
    # so heavy a bed would not fit; of a density that makes it a third of the cell
    volume = one.packing.area * one.packing.depth / 3
    one = replace(one, bed=replace(one.bed, packing=replace(one.packing, density=MASS / volume)))
    rows.check_physics(one, rigid(5), MASS, "there")
    bad = np.concatenate([rigid(4), rigid(1, **changes)])
    try:
        rows.check_physics(one, bad, MASS, "there")
    except Unphysical as failure:
        assert f"there: cycle 5 has {what}" in str(failure)
        return True
    return False


def test_the_harmonics_of_the_momentum_are_within_the_kinetic_energy():
    # ⟨p²⟩ ≤ 2M⟨E⟩ is an equality for a rigid body; six digits are written, 1e-5 is allowed
    energy = AMPLITUDE**2 / (4 * MASS)
    what = "more momentum than its kinetic energy allows"
    assert not refused(what, kinetic_energy=energy * (1 - 0.9e-5))
    assert refused(what, kinetic_energy=energy * (1 - 1.2e-5))
    assert refused(what, p_mean=0.01 * AMPLITUDE)
    assert refused(what, p_sin=-0.5 * AMPLITUDE)
    assert not refused(what, p_sin=0.5 * AMPLITUDE, p_cos=0.0)
    assert not refused(what, p_sin=0.0, p_cos=-0.5 * AMPLITUDE)
    assert not refused(what, p_sin=0.0, p_cos=0.0, p_mean=math.sqrt(0.5) * 0.999 * AMPLITUDE)


def test_energies_have_the_sign_that_they_must():
    still = {"p_sin": 0.0, "p_cos": 0.0, "p_mean": 0.0}
    assert refused("a kinetic energy that is not positive", kinetic_energy=0.0, **still)
    assert refused("a kinetic energy that is not positive", kinetic_energy=-1.0, **still)
    assert refused("a negative energy of rotation", rotational_energy=-1e-12)


def test_the_centre_of_mass_has_half_the_height_of_the_solid_below_and_above_it():
    # a third of the cell is solid: at least 25/6 mm from floor and lid, less a tenth of that for
    # the overlaps
    what = "a centre of mass outside the free space of the cells"
    lowest = 0.9 * 25e-3 / 6
    assert refused(what, height=0.999 * lowest) and not refused(what, height=1.001 * lowest)
    assert refused(what, height=25e-3 - 0.999 * lowest)
    assert not refused(what, height=25e-3 - 1.001 * lowest)


def test_a_bed_returns_no_more_work_than_it_had():
    # ½ M (ωW)² of the motion of the cells and M g L of the height; 10 g at 80 Hz, L = 25 mm
    speed = 98.0665 / (2 * math.pi * 80)
    had = MASS * (0.5 * speed**2 + 9.80665 * 25e-3)
    one = run(cell={"count": 1})
    volume = one.packing.area * one.packing.depth / 3
    one = replace(one, bed=replace(one.bed, packing=replace(one.packing, density=MASS / volume)))

    def returned(work, start="rest"):
        """Rows that return so much work in the first two cycles and get it back in the third."""
        p_sin = np.array([-work / 2, -work / 2, work]) * 80 / 98.0665
        read = rigid(3, kinetic_energy=10.0)
        read[:, 1] = p_sin
        rows.check_physics(replace(one, start=start), read, MASS, "there")

    returned(0.999 * had)
    with pytest.raises(Unphysical, match="cycle 2 has more work returned by then than the bed had"):
        returned(1.001 * had)
    # shaken at 2.5 times the acceleration before, it has at most twice the speed of the cells then
    more = MASS * (0.5 * (5 * speed) ** 2 + 9.80665 * 25e-3)
    returned(0.999 * more, "hard")
    with pytest.raises(Unphysical):
        returned(1.001 * more, "hard")


def test_the_cells_together_have_the_momentum_of_the_run():
    cells = np.array([[[0.3, -0.2], [0.1, 0.05]], [[-0.2, 0.1], [0.2, -0.3]]])
    read = np.zeros((2, 7))
    read[:, 1:3] = cells.sum(axis=1)
    rows.check_cells(read, cells, "there")
    for column in (1, 2):
        for factor, good in ((0.9e-5, True), (1.1e-5, False)):
            wrong = read.copy()
            wrong[1, column] += factor * 0.8  # all that the cells have in the second cycle
            if good:
                rows.check_cells(wrong, cells, "there")
                continue
            with pytest.raises(Unphysical, match="there: the momentum of cycle 2 is not"):
                rows.check_cells(wrong, cells, "there")


def test_cells_are_judged_by_the_second_half_of_their_rows_each_with_its_share():
    one = run(cell={"count": 3})
    cells = np.zeros((48, 3, 2))
    cells[:24, :2] = 7.0
    cells[24:, 0] = (0.02, -0.01)
    cells[24:, 1] = (0.04, 0.0)
    damping, error, mass = rows.cell_estimates(one, cells, 3 * MASS)
    area, omega = one.packing.cell_area, 2 * math.pi * 80
    amplitude = 98.0665 / omega**2
    np.testing.assert_allclose(damping, 2 * np.array([0.02, 0.04]) / (amplitude * area))
    lighter = MASS - 2 * 0.01 / (omega * amplitude)
    np.testing.assert_allclose(mass, [lighter / area, MASS / area])
    assert error[0] == pytest.approx(0, abs=1e-9)


def shaken(legs, count):
    return Shaken(count, legs, 9, MASS, "accuracy", None)
