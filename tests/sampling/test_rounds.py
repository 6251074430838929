"""Rounds of tones: the whole sweep first, then cases where the scenarios read it."""

import json
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from pidpanel.coupon.drive import Tone
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.round import Round, read_rounds
from pidpanel.damping.surface import DampingSurface
from pidpanel.response.from_study import PanelFiles, read_response_panel, scenarios_of
from pidpanel.sampling.rounds import _demands, next_tones, swept_round
from pidpanel.study import load_study
from pidpanel.study.damping import Tones
from tests.jobs import call, make_panel, make_sound

CASE_ERROR = 0.03


def test_a_round_comes_back_from_its_file(tmp_path):
    one = Round(3, ("a", "b"), 1, False, 0.07, {"PID-1_r0.5": {"centre": 0.07}})
    one.write(tmp_path / "round3.json")
    assert Round.read(tmp_path / "round3.json") == one


@pytest.mark.parametrize("text", ["", "[1]", '{"round": 1}', '{"cases": [], "colour": 2}'])
def test_a_file_that_is_no_round_is_named(tmp_path, text):
    # red: `except ValueError` alone in Round.read
    (tmp_path / "round0.json").write_text(text)
    with pytest.raises(ValueError, match=r"round0\.json: not a round of tones"):
        Round.read(tmp_path / "round0.json")


def test_rounds_are_read_up_to_the_last_and_no_further(tmp_path):
    # red: `is_last` that says new == 1
    for number, new in enumerate((4, 1, 0, 5)):
        Round(number, ("a",), new).write(tmp_path / f"round{number}.json")
    assert [one.round for one in read_rounds(tmp_path)] == [0, 1, 2]


def simulated(fill, frequency, gamma):
    """What a case knows, as a row of cases.csv."""
    damping = fill * frequency * (20 / gamma) ** 0.5
    return {
        "fill_fraction": fill,
        "frequency_hz": frequency,
        "acceleration_g": gamma,
        "equivalent_damping_n_s_m3": damping,
        "equivalent_damping_error_n_s_m3": CASE_ERROR * damping,
        "apparent_mass_kg_m2": 4 * fill / gamma**0.2,
        "apparent_mass_error_kg_m2": 0.02,
        "particle_mass_per_area_kg_m2": 12 * fill,
    }


def case(fill, frequency, gamma):
    """A case of the sweep by its point alone."""
    point = SimpleNamespace(fill_fraction=fill, drive=Tone(frequency, gamma * 9.80665))
    return SimpleNamespace(label=f"r{fill}_f{frequency}_a{gamma}", point=point)


POOL = [
    case(r, f, g) for r in (0.3, 0.5, 0.8) for f in (40.0, 80.0, 150.0) for g in (3.0, 30.0, 300.0)
]


@pytest.fixture(scope="module")
def law(tmp_path_factory, write_study, law_values):
    """The file of a study, and what panel and sound left of it."""
    folder = tmp_path_factory.mktemp("rounds")
    values = law_values()
    values["scenarios"] = {"fill": values["scenarios"]["fill"]}
    study = write_study(folder, "law", values)
    make_panel(study, folder)
    make_sound(study, folder)
    return study, PanelFiles(folder / "modes.nc", folder / "modal_force.nc", None)


@pytest.fixture(scope="module")
def panel(law):
    study, files = law
    one = load_study(study)
    return read_response_panel(one, files, "none"), scenarios_of(one)


def surface_of(labels):
    rows = [
        simulated(c.point.fill_fraction, c.point.drive.frequency, c.point.drive.gamma)
        for c in POOL
        if c.label in labels
    ]
    return DampingSurface.from_frame(pd.DataFrame(rows))


TONES = Tones(relative_error=1e-4, damping_error=1e-3, batch=5, most=8)


def test_tones_are_at_the_fills_and_motions_of_the_scenarios_and_no_faster_than_allowed(panel):
    # red: fastest left out of slice_points; the fill of the first scenario for all
    first = swept_round(POOL)
    assert first.cases == tuple(c.label for c in POOL) and first.new == len(POOL)
    surface = surface_of(first.cases)
    found = _demands(*panel, surface)
    one = next_tones(first, TONES, CASE_ERROR, None, *panel, surface)
    assert (one.round, one.new, len(one.tones), one.cases) == (1, 5, 5, first.cases)
    motions = {(w.fill_fraction, float(f"{w.acceleration_g:.3g}")) for w in found.values()}
    assert {(r, gamma) for r, _, gamma in one.tones} <= motions
    assert {r for r, *_ in one.tones} == {0.3, 0.8}

    def speeds(tones):
        return np.array([gamma * 9.80665 / (2 * np.pi * f) for _, f, gamma in tones])

    fastest = float(np.median(speeds(one.tones)))
    slow = next_tones(first, TONES, CASE_ERROR, fastest, *panel, surface)
    assert 0 < speeds(slow.tones).max() <= fastest < speeds(one.tones).max()


def test_further_tones_are_others_and_no_more_than_the_most(panel):
    # red: `run` without the tones before; room without most
    first = swept_round(POOL)
    surface = surface_of(first.cases)
    one = next_tones(first, TONES, CASE_ERROR, None, *panel, surface)
    two = next_tones(one, TONES, CASE_ERROR, None, *panel, surface)
    assert two.tones[:5] == one.tones and len(set(two.tones)) == 8 and two.new == 3
    last = next_tones(two, TONES, CASE_ERROR, None, *panel, surface)
    assert last.is_last and last.tones == two.tones


def test_tones_end_where_rms_values_and_damping_are_known_well_enough(panel):
    # red: with_damping_along left out: the rms values alone are known to 90 % at once
    first = swept_round(POOL)
    surface = surface_of(first.cases)
    loose = Tones(relative_error=0.9, damping_error=0.99)
    assert next_tones(first, loose, CASE_ERROR, None, *panel, surface).is_last
    along = Tones(relative_error=0.9, damping_error=1e-3)
    assert not next_tones(first, along, CASE_ERROR, None, *panel, surface).is_last


def test_a_round_states_the_errors_it_saw(panel):
    # red: the errors of other scenarios
    first = swept_round(POOL)
    one = next_tones(first, TONES, CASE_ERROR, None, *panel, surface_of(first.cases))
    stated = [value for of in one.relative_error.values() for value in of.values()]
    assert set(one.relative_error) == {"PID-1_r0.3_150dB", "PID-1_r0.8_150dB"}
    # five digits of each are kept
    assert max(stated) == pytest.approx(one.largest_relative_error, abs=1e-5)


def test_without_the_mass_of_the_particles_less_is_uncertain(panel):
    # red: without_mass that returns self
    first = swept_round(POOL)
    surface = surface_of(first.cases)
    with_mass, without = (
        next_tones(first, TONES, CASE_ERROR, None, *panel, one).largest_relative_error
        for one in (surface, surface.without_mass())
    )
    assert 0 < without < with_mass


def test_a_round_is_plain_json(tmp_path):
    swept_round(POOL).write(tmp_path / "round0.json")
    values = json.loads((tmp_path / "round0.json").read_text())
    assert values["new"] == len(POOL) and not values["reached"]


COUPON = {
    "sweep": {
        "fill_fraction": [0.3, 0.5, 0.8],
        "frequency_hz": [40, 80, 150],
        "acceleration_g": [3, 30, 300],
    }
}


def test_the_rounds_of_a_study_leave_the_mass_out_where_it_says_so(
    tmp_path, law, write_study, law_values
):
    # red: `if study.response.damper_mass` in write_round
    stated = {}
    for mass in (True, False):
        values = law_values()
        values["scenarios"] = {"fill": values["scenarios"]["fill"]}
        values["coupon"] = COUPON
        values["damping"] = {"readings": ["dem"], "tones": {"relative_error": 1e-4}}
        values["response"]["damper_mass"] = mass
        folder = tmp_path / str(mass)
        study = write_study(folder, "dem", values)
        cases = cases_of(load_study(study).coupon)
        rows = [
            {"case": c.label, "status": "ok"}
            | simulated(c.point.fill_fraction, c.point.drive.frequency, c.point.drive.gamma)
            for c in cases
        ]
        pd.DataFrame(rows).to_csv(folder / "cases.csv", index=False)
        read = {"modes": law[1].modes, "modal_force": law[1].modal_force}
        rounds = [folder / "round0.json", folder / "round1.json"]
        call("design", study, read, {"round": rounds[0]})
        read |= {"before": rounds[0], "cases": folder / "cases.csv"}
        call("design", study, read, {"round": rounds[1]})
        first, second = map(Round.read, rounds)
        assert (first.round, second.round) == (0, 1)
        assert second.cases[: len(first.cases)] == first.cases
        stated[mass] = second.largest_relative_error
    assert 0 < stated[False] < stated[True]
