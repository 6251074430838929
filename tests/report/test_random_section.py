"""Coupons driven at random, on the page."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.random_reading import RandomReading
from pidpanel.random_round import PatchDrive, RandomRound
from pidpanel.report import style
from pidpanel.report.html import Table
from pidpanel.report.inputs import RandomResults
from pidpanel.report.layout import few_of
from pidpanel.report.random_section import (
    near_gap,
    not_agreed,
    random_figure,
    random_section,
    random_warnings,
    stroke_per_gap,
    too_heavy,
)
from pidpanel.report.read import panel_mass_of, read_rounds_at_random

BANDS = LinearApproximation(
    low=np.array([20.0, 100.0]),
    high=np.array([100.0, 900.0]),
    frequency=np.array([50.0, 400.0]),
    equivalent_damping=np.array([400.0, -30.0]),
    equivalent_damping_error=np.array([500.0, 200.0]),
    apparent_mass=np.array([3.0, -0.5]),
    apparent_mass_error=np.array([0.3, 0.1]),
    coherence=np.array([0.9, 0.1]),
    common_psd=np.array([10.0, 0.0]),
    own_psd=np.array([2.0, 8.0]),
    packing_error=0.03,
)
NAMES = {"low": "PID-1, 122 dB", "high": "PID-1, 142 dB"}


DEPTH = {"coupon": 0.025}
FLAT = np.linspace(20, 900, 500)


def drive(scenario, period, moved, error, *, reached):
    one = PatchDrive(
        label=scenario, scenario=scenario, patch="PID-1", damper="coupon", fill_fraction=0.5,
        period=period, phases=1, moved=moved, relative_error=error, reached=reached,
    )  # fmt: skip
    return one.with_motion(FLAT, np.full(500, {"low": 1.0, "high": 400.0}[scenario]))


@pytest.fixture
def results():
    ends = {"low": True, "high": False}
    rounds = [
        RandomRound(0, tuple(drive(one, 1.0, None, None, reached=False) for one in ends)),
        RandomRound(1, (drive("low", 0.0, 0.004, 0.011, reached=True),
                        drive("high", 2.0, 0.3, 0.05, reached=False))),
        RandomRound(2, (drive("low", 0.0, 0.004, 0.011, reached=True),
                        drive("high", 0.0, 0.032, 0.017, reached=False))),
    ]  # fmt: skip
    reading = RandomReading(BANDS, weight=6.4, area=1e-4)
    return RandomResults(rounds, {(one, "PID-1"): reading for one in ends}, DEPTH)


def test_a_scenario_that_ended_early_is_named_with_what_is_missing(results):
    # red: in not_agreed, `not drive.reached` -> `drive.reached`
    (said,) = random_warnings(results, NAMES)
    assert "PID-1, 142 dB (rms acceleration moved by 3.2 %" in said and "known to 1.7 %" in said
    assert "122 dB" not in said
    agreed = RandomResults(
        [RandomRound(0, (drive("low", 0.0, 0.004, 0.011, reached=True),))], results.readings, DEPTH
    )
    assert random_warnings(agreed, NAMES) == []


def test_particles_that_come_near_to_cross_their_gap_are_named_with_their_stroke(results):
    # S_a = 400 from 20 to 900 Hz: a² = 400 · 880, v² = 400/(2π)² (1/20 − 1/900), W = √2 v²/a, and
    # the gap is (1 − 0.94/2) 25 mm; red: NEAR_GAP = 0.02; (1 − r) left out; no √2
    acceleration = np.sqrt(400 * 880)
    velocity = np.sqrt(400 / (2 * np.pi) ** 2 * (1 / 20 - 1 / 900))
    expected = np.sqrt(2) * velocity**2 / acceleration / 0.01325
    _, high = results.rounds[-1].drives
    assert stroke_per_gap(high, results) == pytest.approx(expected, rel=2e-3)
    assert [one.scenario for one in near_gap(results)] == []
    shallow = replace(results, depth={"coupon": 0.025 * expected / 0.15})
    assert [one.scenario for one in near_gap(shallow)] == ["high"]
    *_, said = random_warnings(shallow, NAMES)
    assert "PID-1, 142 dB (W/L = 0.15)" in said and "122 dB" not in said


def test_particles_that_are_heavy_beside_the_panel_are_named(results):
    # red: HEAVY = 8; `/ results.panel_mass` → `* …`; without `too_heavy` in random_warnings
    assert too_heavy(results) == [] and too_heavy(replace(results, panel_mass=1.7)) == []
    thin = replace(results, panel_mass=1.28)
    assert [one.scenario for one in too_heavy(thin)] == ["low", "high"]
    *_, said = random_warnings(thin, NAMES)
    assert "PID-1, 122 dB (5.00 times)" in said and "PID-1, 142 dB (5.00 times)" in said


def test_the_mass_of_the_panel_is_that_of_its_section():
    # red: `== "mass_per_area"` → `== "mass"`
    section = pd.DataFrame(
        {"quantity": ["bending", "mass_per_area", "mass"], "value": [26.3, 4.32, 0.4]}
    )
    assert panel_mass_of(section) == 4.32


def test_the_table_has_rounds_time_and_what_was_reached(results):
    # red: in rounds_table, `period > 0` -> `period >= 0`
    section = random_section(results, NAMES)
    (table,) = (block for block in section.blocks if isinstance(block, Table))
    assert table.rows == [
        ["PID-1, 122 dB", "PID-1", "1", "1.0", "0.004", "0.4 %", "1.1 %", "yes"],
        ["PID-1, 142 dB", "PID-1", "2", "3.0", "0.089", "3.2 %", "1.7 %", "no"],
    ]
    assert "1 of 2 patches" in section.blocks[0].text


def test_an_error_beyond_the_value_does_not_stretch_the_axis(results):
    # red: without set_ylim
    with style.context():
        damping, _ = random_figure(results, NAMES).axes
    low, high = damping.get_ylim()
    assert 100 < low < 400 < high


def test_values_are_chosen_evenly():
    # red: `values[: count]` in few_of
    assert few_of("abcdefg", 3) == ["a", "d", "g"]


def test_rounds_after_the_last_are_not_read(results, tmp_path):
    # red: glob of round*.json in read_rounds_at_random
    for number, one in enumerate((*results.rounds, results.rounds[0])):
        one.write(tmp_path / f"round{number}.json")
    (tmp_path / "impedance2.csv").write_text(
        "scenario,patch,particle_mass_per_area_kg_m2,coupon_area_m2,packing_error,low_hz,high_hz,"
        "frequency_hz,equivalent_damping_n_s_m3,equivalent_damping_error_n_s_m3,"
        "apparent_mass_kg_m2,apparent_mass_error_kg_m2,coherence,common_force_psd_pa2_hz,"
        "own_force_psd_pa2_hz,agreed\nhigh,PID-1,6.4,1e-4,0.03,20,100,50,400,40,3,0.3,0.9,10,2,False\n"
    )
    found = read_rounds_at_random(tmp_path, DEPTH)
    assert len(found.rounds) == 3 and list(found.readings) == [("high", "PID-1")]
    assert [one.scenario for one in not_agreed(found.rounds)] == ["high"]
