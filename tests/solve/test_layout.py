"""A scenario: its damping read at the level of its own motion, or at a stated one."""

import numpy as np
import pytest
from solving import panel_solver, solve_bare, solve_layout

from pidpanel import solve
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.tables import PSD_VARIABLES, cases_dataset
from pidpanel.solve.layout import AttachedDamper, DamperLayout, solve_with
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches, UnstableDamping

MASS, FREQUENCY, RATIO, AREA = 1.5, 65.0, 0.02, 0.04


def one_mode(is_diagonal=False):
    """A panel of one mode under white sound, its patch moving with the mode's crest."""
    lines = frequency_grid(20.0, 300.0, RATIO, [FREQUENCY])
    basis = ModalBasis([FREQUENCY], [MASS], RATIO)
    patches = Patches(np.array([[[AREA]]]), np.array([AREA]))
    force = np.array([[0.3]])
    return panel_solver(basis, patches, lines, [[1.0]], force, is_diagonal=is_diagonal)


def solved(solver, damping, factor, *, depends=True, stated=None):
    load = AttachedDamper(0, damping, depends)
    return solve_layout(solver, [load], factor, stated_acceleration_g=stated)


def dashpot(value):
    def damping(frequency, level):
        shape = frequency.shape
        return np.full(shape, value), np.zeros(shape), np.ones(shape, bool)

    return damping


def falling(frequency, level):
    """C_e = 2000/Γ, on run points up to Γ = 5."""
    shape = frequency.shape
    return np.full(shape, 2000 / level), np.zeros(shape), np.full(shape, level <= 5)


@pytest.mark.parametrize("is_diagonal", [False, True])
@pytest.mark.parametrize("sound", [1.0, 100.0])
def test_the_level_read_is_the_level_that_results(is_diagonal, sound):
    found = solved(one_mode(is_diagonal), falling, sound)
    # the search closes to 1e-6; fine and coarse lines are the same here
    assert found.patch_acceleration_g == pytest.approx(found.acceleration_g, rel=1e-5)
    assert found.equivalent_damping[0, 0] == pytest.approx(2000 / found.acceleration_g)
    rms = found.response.acceleration_rms[0]  # the patch moves as its point does
    assert found.acceleration_g == pytest.approx(np.sqrt(2) * rms / STANDARD_GRAVITY, rel=1e-5)


def test_responses_are_the_same_bits_on_two_cores(monkeypatch):
    layouts = [
        DamperLayout([AttachedDamper(0, law)]) for law in (falling, dashpot(300.0), dashpot(-1.0))
    ]
    alone = solve_with(one_mode(), layouts)
    monkeypatch.setenv("PIDPANEL_CORES", "2")
    together = solve_with(one_mode(), layouts)
    for first, second in zip(alone[:2], together[:2], strict=True):
        np.testing.assert_array_equal(first.response.cross_psd, second.response.cross_psd)
        np.testing.assert_array_equal(first.acceleration_g, second.acceleration_g)
    assert all(isinstance(answers[2], UnstableDamping) for answers in (alone, together))


def test_a_stated_level_is_taken_as_it_is_and_the_own_one_is_told_beside():
    found = solved(one_mode(), falling, 1.0, stated=4.0)
    assert found.acceleration_g == 4.0
    assert found.equivalent_damping[0, 0] == 500.0
    assert found.patch_acceleration_g != pytest.approx(4.0, rel=0.1)


def test_a_level_beyond_the_run_points_is_marked():
    assert solved(one_mode(), falling, 1.0, stated=4.0).inside.all()
    assert not solved(one_mode(), falling, 1.0, stated=6.0).inside.any()


def test_a_scenario_without_response_is_nan_in_the_file():
    one = solve_bare(one_mode(), 1.0)
    none = np.zeros((1, one.response.frequency.size))
    case = {"acceleration_psd": one.response.acceleration_psd, "inside": none}
    axes = {"frequency": one.response.frequency, "scenario": ["bare", "x"],
            "point": ["p"], "patch": ["PID-1"]}  # fmt: skip
    data = cases_dataset({"bare": case}, PSD_VARIABLES, axes)
    assert np.isfinite(data["acceleration_psd"].sel(scenario="bare")).all()
    assert np.isnan(data["acceleration_psd"].sel(scenario="x")).all()
    assert all("units" in data[name].attrs for name in data.data_vars)


def test_the_entry_for_arrays_answers_as_a_solver_that_is_kept():
    solver, louder = one_mode(), DamperLayout([AttachedDamper(0, falling)], 100.0)
    kept = solve_with(solver, [DamperLayout(()), louder])
    for found, wanted in zip(
        solve.layouts(solver.panel, solver.excitation, [DamperLayout(()), louder]),
        kept,
        strict=True,
    ):
        np.testing.assert_array_equal(found.response.cross_psd, wanted.response.cross_psd)
        np.testing.assert_array_equal(found.acceleration_g, wanted.acceleration_g)
