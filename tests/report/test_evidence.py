"""The runs shown are those that succeeded."""

import dataclasses

import numpy as np
import pytest

from pidpanel.coupon import coding
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.records import Shaken, ShakeOutcome
from pidpanel.report import evidence
from pidpanel.study.coupon import Cell, Coupon
from pidpanel.study.particles import Particles
from pidpanel.study.sweep import Sweep


@pytest.fixture
def case():
    coupon = Coupon(
        cell=Cell(depth_mm=10, count=1),
        particles=Particles(diameter_mm=2.5),
        sweep=Sweep(fill_fraction=(0.5,), frequency_hz=(100.0,), acceleration_g=(10.0,)),
    )
    return cases_of(coupon)[0]


def write_run(case, folder):
    (file,) = case.outcomes(folder)[:1]
    own = file.parent
    own.mkdir(parents=True)
    mass = 2 * 1190 * np.pi / 6 * 2.5e-3**3
    found = Shaken(12, (12,), 2, mass, "accuracy", None, "", "")
    coding.write(file, ShakeOutcome("ok", "", 1, "3.8.0", 0.0, case.runs[0], case.target, found))
    (own / "start.data").write_text(
        "spheres\n\n2 atoms\n\nAtoms\n\n1 1 0.0025 1190 0 0 0.002\n2 1 0.002 1190 0 0 0.006\n"
    )
    (own / "at_12.dump").write_text(
        "ITEM: TIMESTEP\n5\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
        "ITEM: ATOMS id x y z vx vy vz \n2 0 0 0.007 0 0 0.1 \n1 0 0 0.003 0.3 0 0.4 \n"
    )


def test_the_case_of_the_film_succeeded_and_is_nearest_to_half_fill(cases):
    # red: the status not looked at
    cases["fill_fraction"] += 0.1
    nearest = evidence.nearest_case(cases)
    assert nearest == "r0.3_f100Hz_a12g"  # now of r = 0.4
    cases.loc[cases["case"] == nearest, "status"] = "NotSteady"
    assert evidence.nearest_case(cases) != nearest


def test_the_runs_shown_are_spread_over_the_cases_that_succeeded(cases):
    # red: the first so many
    cases.loc[0, "status"] = "NotSteady"
    shown = evidence.spread_cases(cases, 3)
    assert shown == [cases["case"][i] for i in (1, 6, 11)]
    assert len(evidence.spread_cases(cases, 99)) == len(cases) - 1


def test_the_energy_of_a_cycle_follows_from_its_momentum(case, tmp_path, monkeypatch):
    # red: the spheres' number of another run; a factor of 2
    single = dataclasses.replace(case, runs=case.runs[:1])
    write_run(single, tmp_path)
    run = case.runs[0]
    p_sin = 1e-6 * (1 + 0.1 * np.sin(np.arange(12)))
    rows = np.zeros((12, 7))
    rows[:, 1] = p_sin
    monkeypatch.setattr(evidence.rows, "read_shaken", lambda *_: rows)
    (record,) = evidence.read_records(single, tmp_path)
    area = np.sqrt(3) / 2 * 6.35e-3**2
    # work of the shaker per cycle and area, π ω W p_s / A with p_s = 2⟨p sin ωt⟩
    expected = np.pi * 2 * np.pi * 100 * run.drive.amplitude * 2 * p_sin / area
    assert record.energy == pytest.approx(expected, rel=1e-9)
    assert record.seed == 1


def test_a_figure_of_a_varied_case_says_what_was_varied(case, tmp_path, monkeypatch):
    # red: three figures of one title for three coefficients of friction
    varied = dataclasses.replace(
        case, runs=case.runs[:1], varied={"particles.friction": 0.1, "deck": "mine.in.j2"}
    )
    write_run(varied, tmp_path)
    monkeypatch.setattr(evidence.rows, "read_shaken", lambda *_: np.ones((12, 7)))
    (record,) = evidence.read_records(varied, tmp_path, with_size=True)
    assert record.title == ("r = 0.5, 100 Hz, Γ = 10\nd = 2.5 mm, friction 0.1, deck mine.in.j2")
