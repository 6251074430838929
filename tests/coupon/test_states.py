"""Several states of one bed: found cell by cell, from both sides, and covered by the error."""

import numpy as np
import pytest

from pidpanel.coupon import attempts, cycles, records, rows, states, summary
from pidpanel.coupon.bed import HARD_CYCLES
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.records import CaseOutcome
from pidpanel.study.coupon import Coupon
from tests.coupons import with_changes


def split(means, errors):
    return [state.tolist() for state in states.states_of(np.array(means), np.array(errors))]


def test_values_apart_by_a_quarter_and_four_errors_are_of_two_states():
    assert split([3.0, 1.0, 3.1, 1.1], [0.1] * 4) == [[1, 3], [0, 2]]
    assert split([1.0, 1.25], [0.01] * 2) == [[0, 1]]  # less than a quarter of their mean
    assert split([1.0, 1.3], [0.01] * 2) == [[0], [1]]
    assert split([-1.1, -1.0], [0.001] * 2) == [[0, 1]]
    assert split([1.0, 2.0], [0.2, 0.2]) == [[0, 1]]  # less than four errors
    assert split([1.0, 2.0], [0.17, 0.17]) == [[0], [1]]
    assert split([2.0], [np.inf]) == [[0]]
    assert split([1.0, 9.0], [np.inf, 0.1]) == [[0, 1]]


def test_states_are_as_many_as_there_are_gaps_between_neighbours():
    # one bed of acrylic, single cells at 100 Hz, 80 g, r = 0.5: η of each
    eta = [0.05, 0.103, 0.049, 0.25, 0.104, 0.05]
    assert split(eta, [0.002] * 6) == [[2, 0, 5], [1, 4], [3]]
    # what lies between closes the gap
    assert split([1.0, 1.2, 1.44], [0.001] * 3) == [[0, 1, 2]]


def test_the_error_of_states_reaches_the_one_that_is_farthest():
    means = np.array([1.0, 1.0, 1.0, 5.0])
    found = states.states_of(means, np.full(4, 0.01))
    assert states.farthest(means, found) == 3.0
    assert states.farthest(6 - means, found[::-1]) == 3.0  # below the mean
    assert states.farthest(means, [np.arange(4)]) == 0.0


def test_a_motion_that_repeats_after_a_few_cycles_has_no_scatter():
    for period in ([0.05], [0.0, 0.2], [-0.55, 0.03, 0.86], [1.0, 2.0, 3.0, -1.0, 0.0, 1.0]):
        series = np.resize(period, 72)
        mean, error = cycles.settled(series)
        assert mean == pytest.approx(np.mean(period), abs=1e-12)
        assert error == pytest.approx(0.0, abs=1e-12)
    ragged = np.concatenate([[1e3] * 5, np.zeros(12)])  # the first of 17 are in no block
    assert cycles.settled(ragged)[1] == 0.0
    assert cycles.settled(np.zeros(11))[1] == np.inf


def coupon(**changes):
    values = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 25, "count": 2},
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [80]},
        "time_step_rayleigh": 0.2,
        "accuracy": {
            "relative_error": 0.5, "seeds": 2, "min_cycles": 60, "max_cycles": 90, "min_time_s": 0,
            "state_seeds": 3, "state_cycles": 90,
        },
    }  # fmt: skip
    return Coupon.model_validate(with_changes(values, changes))


def test_beds_that_may_ride_or_cross_come_from_both_sides_and_have_a_reserve():
    (case,) = cases_of(coupon())
    assert [run.start for run in case.runs] == ["rest", "hard"]
    assert [run.packing.seed for run in case.reserve] == [3]
    assert case.with_reserve.label == case.label
    # a third of the cycles of states, within those of the study
    (short,) = cases_of(coupon(accuracy={"min_cycles": 10}))
    (shorter,) = cases_of(coupon(accuracy={"min_cycles": 10, "max_cycles": 20}))
    assert [one.least_cycles for one in (case, short, shorter)] == [60, 30, 20]
    (rides,) = cases_of(coupon(sweep={"acceleration_g": [20]}))
    assert (rides.reserve, rides.state_cycles) == ((), 0)
    assert {run.start for run in rides.runs} == {"rest"}
    (once,) = cases_of(coupon(accuracy={"state_cycles": 0}))
    assert (once.reserve, {run.start for run in once.runs}) == ((), {"rest"})
    (many,) = cases_of(coupon(accuracy={"seeds": 5}))
    assert (len(many.runs), many.reserve) == (5, ())


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """A bed that has several states, shaken."""
    # 48 cycles are enough: the same states and η within 15 % as after 90 or 120
    folder = tmp_path_factory.mktemp("states")
    accuracy = {"min_cycles": 24, "max_cycles": 48, "state_cycles": 48}
    (case,) = cases_of(coupon(time_step_rayleigh=0.25, accuracy=accuracy))
    attempts.write_case(case, folder, case.outcome_file(folder))
    return folder, case


@pytest.mark.liggghts
def test_a_case_of_two_states_says_both_with_their_shares_and_an_error_that_covers_them(shaken):
    # acrylic, r = 0.5, 100 Hz, 80 g: from rest η = 0.25, shaken hard first 0.05
    # in place of that of the settled cells
    folder, case = shaken
    row = summary.summarise(case, *summary.read_seeds(case, folder))
    assert row["status"] == "ok", row["message"]
    values = [float(value) for value in row["state_damping_n_s_m3"].split()]
    shares = [float(value) for value in row["state_share"].split()]
    assert (row["states"], row["seeds"]) == (len(values), 3) and len(values) > 1
    assert values == sorted(values) and sum(shares) == pytest.approx(1, abs=2e-4)  # four digits
    mean, error = row["equivalent_damping_n_s_m3"], row["equivalent_damping_error_n_s_m3"]
    assert mean == pytest.approx(np.dot(values, shares), rel=5e-3)
    assert mean - error < values[0] and values[-1] < mean + error
    assert not row["target_met"]
    per_area = row["particle_mass_per_area_kg_m2"]
    lowest, highest = (value / per_area / (2 * np.pi * 100) for value in (values[0], values[-1]))
    assert lowest == pytest.approx(0.05, rel=0.15) and highest > 0.1
    # all settled: two halves of 48 cycles
    assert row["cycles_run"] == 3 * 48


@pytest.mark.liggghts
def test_a_run_shaken_hard_has_its_rows_after_that(shaken):
    folder, case = shaken
    run, home = case.runs[1], case.folders(folder)[1]
    steps = np.loadtxt(home / "cycles_1.txt")[:, 0]
    assert steps[0] == (HARD_CYCLES + 1) * run.steps_per_cycle
    found = records.read(CaseOutcome, case.outcome_file(folder)).runs[1].product
    assert len(rows.read_shaken(run, home, found)) == found.cycles == 48
    assert abs(found.balance.closure) < 0.02  # of the drive, not of what came before


@pytest.mark.liggghts
def test_what_was_run_is_not_run_again(shaken):
    folder, case = shaken
    before = summary.summarise(case, *summary.read_seeds(case, folder))
    third = case.with_reserve.folders(folder)[2]
    log = (third / "shake_1.log").stat().st_mtime_ns
    attempts.write_case(case, folder, case.outcome_file(folder))
    assert summary.summarise(case, *summary.read_seeds(case, folder)) == before
    assert (third / "shake_1.log").stat().st_mtime_ns == log


# ------------------------------------------------------------------ rows of every cell


def two_cells(**accuracy):
    """A small case of two cells that may ride or cross, shaken hard first, and its run."""
    (case,) = cases_of(
        coupon(
            cell={"depth_mm": 10, "count": 2},
            particles={"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
            sweep={"acceleration_g": [40]},
            accuracy={"state_cycles": 3, "min_cycles": 8, "max_cycles": 8} | accuracy,
        )
    )
    return case, case.runs[1]


@pytest.fixture(scope="module")
def celled(tmp_path_factory):
    """results/coupon with the run of two cells in two legs, and the files of its bed."""
    folder = tmp_path_factory.mktemp("celled")
    for cycles_run in (8, 14):
        case, _ = two_cells(min_cycles=cycles_run, max_cycles=cycles_run)
        attempts.write_case(case, folder, case.outcome_file(folder))
    return folder, case


@pytest.mark.liggghts
def test_the_cells_together_are_the_run_and_a_restart_goes_on_with_both(celled):
    folder, case = celled
    run, home = case.runs[1], case.folders(folder)[1]
    found = records.read(CaseOutcome, case.outcome_file(folder)).runs[1].product
    assert found.legs == (8, 6)
    cells = rows.read_cells(run, home, found)
    assert cells.shape == (14, 2, 2)
    read = rows.read_rows(run, home, found.legs, 14)
    # six digits are written of each
    np.testing.assert_allclose(
        cells.sum(axis=1), read[:, 1:3], rtol=0, atol=1e-5 * np.abs(cells).max()
    )
    assert not np.allclose(cells[:, 0], cells[:, 1], rtol=0.01)
    cell_damping, _, cell_mass = rows.cell_estimates(run, cells, found.mass_kg)
    damping, mass = rows.harmonic(run, read, found.mass_kg)
    assert cell_damping.mean() == pytest.approx(damping[7:].mean(), rel=1e-4)
    assert cell_mass.mean() == pytest.approx(mass[7:].mean(), rel=1e-4)
