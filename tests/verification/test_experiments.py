"""Experiments of others: what is computed, and the page that says what was not known."""

import numpy as np
import pytest

from pidpanel.verification import experiments


@pytest.mark.liggghts
def test_impacts_that_slide_are_those_of_the_experiment(tmp_path):
    rows = [row for row in experiments.impact_rows(tmp_path) if row.unit == "1"]
    sliding = [row for row in rows if row.at > 30]
    assert len(sliding) == 4 * len(experiments.SOFTENED)
    # the experiment scatters by 1 %
    assert max(abs(row.error) for row in sliding) < 0.01
    # micro-slip near the normal is not modelled, and softer contacts stick less
    sticking = [row.computed for row in rows if row.at == 9.63]
    assert np.all(np.diff(sticking) < -0.01)


@pytest.mark.parametrize("cycles", [[1.0], [1.0, 3.0], [1.0, 2.0, 4.0], [1.0, 5.0, 1.2, 3.0]])
def test_the_period_of_losses_that_repeat_is_found(cycles):
    rng = np.random.default_rng(1)
    energy = np.tile(cycles, 20) * rng.normal(1, 0.03, 20 * len(cycles))
    assert experiments.period(energy) == len(cycles)


def test_losses_that_do_not_repeat_have_no_period():
    assert experiments.period(np.random.default_rng(1).uniform(0.5, 1.5, 60)) == 0


def test_a_loss_that_does_not_fall_has_no_end():
    assert np.isnan(experiments.falls_to(0.5, [1.0, 2.0], [1.0, 2.0]))


@pytest.mark.liggghts
def test_a_collision_is_that_of_lammps(tmp_path):
    # the same law in another program, with a step 200 times longer; forces to 1.2e-4 of the
    # largest.
    rows = list(experiments.lammps_rows(tmp_path))
    assert len(rows) == 3 * len(experiments.COLLISION)
    largest = {
        unit: max(abs(r.reference) for r in rows if r.unit == unit) for unit in ("m", "m/s", "N")
    }
    assert max(abs(r.computed - r.reference) / largest[r.unit] for r in rows) < 2e-4


def test_every_experiment_says_what_was_not_known():
    assert len(experiments.UNKNOWN) == len(experiments.CASES)
