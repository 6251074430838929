"""A coupon driven at random in LIGGGHTS: a linear element that is known, and rows that are wrong."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import geometry
from pidpanel.coupon.from_study import bed_at, random_run_of
from pidpanel.coupon.liggghts.failures import LogTruncated, NotFinite
from pidpanel.coupon.random_runs import (
    HEADER,
    Record,
    check_rows,
    random_run,
    read_rows,
    shake_at_random,
    sine_of,
)
from pidpanel.damping.best_linear import Leg, approximate
from pidpanel.study.coupon import Coupon

COUPON = Coupon.model_validate(
    {
        "cell": {"across_flats_mm": 20, "depth_mm": 20, "count": 2},
        "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
        "gravity_g": 0,
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [10]},
    }
)
BED = bed_at(COUPON, 0.5, 1)
BAND = (50.0, 500.0)
MOTION = np.array(BAND), np.full(2, (3 * STANDARD_GRAVITY) ** 2 / 450)
CENTRES = BED.packing.centres

EDGES = np.arange(50.0, 501.0, 25.0)

ELEMENT = """
{% include "random.in.j2" %}
fix spring all spring/self {{ stiffness }}
fix pot all viscous {{ drag }}
"""


def spheres(height, diameter=2.5e-3):
    """One in the middle of each cell."""
    count = len(CENTRES)
    return np.column_stack([CENTRES, np.full(count, height), np.full(count, diameter)])


def leg(period, phases=1, time_step=None):
    run = random_run(BED, BED.constants, BAND, period, phases, 0.15)
    if time_step is None:
        return run
    sample = run.time_step * run.steps_per_sample
    steps = int(np.ceil(sample / time_step))
    return replace(run, time_step=sample / steps, steps_per_sample=steps)


@pytest.mark.liggghts
def test_a_sphere_on_a_spring_and_a_dashpot_has_the_impedance_of_its_equation(tmp_path):
    """1/Z = 1/(iωm) + 1/(c + k/iω) of each sphere, here at 160 Hz with a third of critical."""
    # red: `mass * motion.acceleration` → `-mass * …` in spectra; `-values` → `values` in the drive
    mass = float(geometry.masses(np.array([2.5e-3]), BED.packing.density)[0])
    stiffness, drag = mass * 1000.0**2, 2 * 0.33 * mass * 1000.0
    template = tmp_path / "element.in.j2"
    template.write_text(
        ELEMENT.replace("{{ stiffness }}", f"{stiffness:.12g}").replace(
            "{{ drag }}", f"{drag:.12g}"
        )
    )
    # the drag of a step is that of half a step before: ω Δt/2 of it, 3e-4 at 1 µs
    run = leg(0.4, time_step=1e-6)
    found = shake_at_random(run, MOTION, spheres(10e-3), tmp_path / "leg", template)
    iw = 2j * np.pi * found.frequency
    expected = len(CENTRES) / (1 / (iw * mass) + 1 / (drag + stiffness / iw)) / BED.packing.area
    assert found.force / found.velocity == pytest.approx(expected, rel=2e-3)
    assert found.mass_per_area == pytest.approx(len(CENTRES) * mass / BED.packing.area)
    # what the estimator makes of it in bands: the mean over the power of the motion
    bands = approximate([Leg(found.frequency, found.velocity, found.force[None])], EDGES)
    power = np.abs(found.velocity) ** 2
    means = [
        np.average(expected.real[some], weights=power[some])
        for low, high in zip(bands.low, bands.high, strict=True)
        for some in ((found.frequency >= low) & (found.frequency < high),)
    ]
    assert bands.equivalent_damping == pytest.approx(means, rel=2e-3)


@pytest.mark.liggghts
def test_a_sphere_that_touches_nothing_feels_no_force_and_the_next_leg_begins_where_it_was(
    tmp_path,
):
    # red: `last` → `spheres[:, :3]` in shake_at_random
    first = shake_at_random(leg(0.2), MOTION, spheres(10e-3), tmp_path / "one")
    # against M a, which it would feel as dead weight; rows have six digits
    dead = first.mass_per_area * 2 * np.pi * first.frequency * np.abs(first.velocity)
    assert np.abs(first.force).max() < 2e-3 * dead.max()
    moved = first.spheres[:, 2] - 10e-3
    assert np.ptp(moved) < 1e-8
    assert abs(moved[0]) > 1e-5
    again = shake_at_random(leg(0.2, phases=2), MOTION, first.spheres, tmp_path / "two")
    assert abs(again.spheres[0, 2] - first.spheres[0, 2]) > 1e-6
    assert (
        abs(np.vdot(first.velocity, again.velocity))
        < 0.5 * np.vdot(first.velocity, first.velocity).real
    )
    first.write(tmp_path / "one.npz")
    read = Record.read(tmp_path / "one.npz")
    assert (read.force == first.force).all()
    assert (read.cells, read.period) == (2, 0.2)


def test_contacts_are_those_of_the_sine_with_the_same_rms_acceleration_and_velocity():
    # red: `math.sqrt(2) * acceleration` → `acceleration` in sine_of
    f = np.geomspace(20, 2000, 4000)
    psd = 7.0 * f
    sine = sine_of((f, psd))
    acceleration = np.sqrt(3.5 * (2000**2 - 20**2))
    velocity = np.sqrt(7 * np.log(100)) / (2 * np.pi)
    # 4000 points of a trapezoid
    assert sine.acceleration == pytest.approx(np.sqrt(2) * acceleration, rel=1e-5)
    assert sine.speed == pytest.approx(np.sqrt(2) * velocity, rel=1e-5)
    run = random_run_of(COUPON, BED, sine, BAND, 0.2, 1)
    assert run.steps_per_sample * run.time_step == pytest.approx(1 / 5000)


def rows_of(count=4):
    value = np.array([1.0, -2.0, 3.0, 0.5, 1.0])[: count + 1]
    return np.column_stack([10 * np.arange(count + 1), value / 100, value, value**2])


def written(path, rows, header=HEADER):
    text = "".join(" ".join(f"{x:g}" for x in row) + "\n" for row in rows)
    path.write_text("\n".join(header) + "\n" + text)
    return path


def test_rows_are_read_as_they_are(tmp_path):
    # red: `lines[2:]` → `lines[3:]` in read_rows
    assert (read_rows(written(tmp_path / "rows", rows_of()), 10, 4) == rows_of()).all()


@pytest.mark.parametrize(
    ("damage", "kind", "says"),
    [
        (lambda text: text[:-1], LogTruncated, "cut in its last line"),
        (lambda text: text.replace("c_ke", "v_x"), LogTruncated, "no header"),
        (lambda text: text + "50 0 0 0\n", LogTruncated, "not 5 rows of 4 columns, 10 steps"),
        (lambda text: text.replace("20 ", "21 "), LogTruncated, "10 steps apart"),
        (lambda text: text.replace(" 3 ", " nan "), NotFinite, "1 numbers are not finite"),
        (lambda text: text.replace(" 3 ", " 3x "), NotFinite, "3x"),
        (lambda text: text.replace(" 3 9", " 3"), NotFinite, "inhomogeneous"),
    ],
)
def test_rows_that_are_cut_or_garbled_are_named(tmp_path, damage, kind, says):
    # red: any one of the conditions of read_rows
    path = written(tmp_path / "rows", rows_of())
    path.write_text(damage(path.read_text()))
    with pytest.raises(kind, match=says):
        read_rows(path, 10, 4)


def test_rows_of_another_motion_or_against_physics_are_refused():
    # red: `off > FELT` → `off > 1`; `2 * mass` → `4 * mass` in check_rows
    rows, mass = rows_of(), 1e-3
    rows[:, 1] = np.sqrt(2 * mass * rows[:, 3]) * (1 - 1e-7)
    check_rows(rows, rows[:, 2], mass, "here")
    with pytest.raises(NotFinite, match=r"felt another motion, 0\.032"):
        check_rows(rows, rows[:, 2] + [0, 0, 0.1, 0, 0], mass, "here")
    rows[1, 1] *= 1.001
    with pytest.raises(NotFinite, match="here: p² above 2 M E_kin"):
        check_rows(rows, rows[:, 2], mass, "here")


def test_a_record_that_is_cut_is_named(tmp_path):
    # red: `except (OSError, …)` without BadZipFile
    (tmp_path / "cut.npz").write_bytes(b"PK\x03\x04 nothing")
    with pytest.raises(LogTruncated, match=r"cut\.npz: not a record of a random motion"):
        Record.read(tmp_path / "cut.npz")
