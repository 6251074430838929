"""A scenario: its damping read at the level of its own motion, or at a stated one."""

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.tables import OnPatches, psd_dataset, summary_rows
from pidpanel.solve import scenarios
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches, UnstableDamping
from pidpanel.solve.solvers import DiagonalSolver, PanelInField, PanelSolver

MASS, FREQUENCY, RATIO, AREA = 1.5, 65.0, 0.02, 0.04


def one_mode(kind=PanelSolver):
    """A panel of one mode under white sound, its patch moving with the mode's crest."""
    lines = frequency_grid(20.0, 300.0, RATIO, [FREQUENCY])
    basis = ModalBasis([FREQUENCY], [MASS], RATIO)
    patches = Patches(np.array([[[AREA]]]), np.array([AREA]))
    panel = PanelInField(basis, patches, lambda f: np.ones(f.size), np.array([[0.3]]))
    return kind(panel, lines, np.array([[1.0]]), lines)


def solve(solver, damping, factor, *, depends=True, stated=None):
    load = scenarios.Load(0, damping, depends)
    return scenarios.solve_layout(solver, [load], factor, stated_acceleration_g=stated)


def dashpot(value):
    def damping(frequency, level):
        shape = frequency.shape
        return np.full(shape, value), np.zeros(shape), np.ones(shape, bool)

    return damping


def falling(frequency, level):
    """C_e = 2000/Γ, on run points up to Γ = 5."""
    shape = frequency.shape
    return np.full(shape, 2000 / level), np.zeros(shape), np.full(shape, level <= 5)


@pytest.mark.parametrize("kind", [PanelSolver, DiagonalSolver])
@pytest.mark.parametrize("sound", [1.0, 100.0])
def test_the_level_read_is_the_level_that_results(kind, sound):
    found = solve(one_mode(kind), falling, sound)
    # the search closes to 1e-6; fine and coarse lines are the same here
    assert found.patch_acceleration_g == pytest.approx(found.acceleration_g, rel=1e-5)
    assert found.equivalent_damping[0, 0] == pytest.approx(2000 / found.acceleration_g)
    rms = found.response.acceleration_rms[0]  # the patch moves as its point does
    assert found.acceleration_g == pytest.approx(np.sqrt(2) * rms / STANDARD_GRAVITY, rel=1e-5)


def test_the_motion_is_searched_from_a_hundredth_to_three_times_that_of_the_bare_panel():
    # at 13 values in equal ratios; red: bare / 100 → bare / 101; 3 * bare → 4 * bare;
    # scan_count=13 → 14
    asked = []

    def law(frequency, level):
        asked.append(level)
        return falling(frequency, level)

    bare = scenarios.solve_bare(one_mode(), 1.0).bare_patch_acceleration_g[0]
    solve(one_mode(), law, 1.0)
    np.testing.assert_allclose(asked[:13], np.geomspace(bare / 100, 3 * bare, 13), rtol=1e-10)


def test_a_stated_level_is_taken_as_it_is_and_the_own_one_is_told_beside():
    found = solve(one_mode(), falling, 1.0, stated=4.0)
    assert found.acceleration_g == 4.0
    assert found.equivalent_damping[0, 0] == 500.0
    assert found.patch_acceleration_g != pytest.approx(4.0, rel=0.1)


def test_a_level_beyond_the_run_points_is_marked():
    assert solve(one_mode(), falling, 1.0, stated=4.0).inside.all()
    assert not solve(one_mode(), falling, 1.0, stated=6.0).inside.any()


def test_a_law_without_level_scales_with_the_sound():
    quiet = solve(one_mode(), dashpot(300.0), 1.0, depends=False)
    loud = solve(one_mode(), dashpot(300.0), 100.0, depends=False)
    ratio = loud.response.acceleration_psd / quiet.response.acceleration_psd
    np.testing.assert_allclose(ratio, 100.0, rtol=1e-12)
    assert np.isnan(quiet.acceleration_g)


def test_more_sound_moves_the_damping_that_depends_on_motion():
    quiet = solve(one_mode(), falling, 1.0)
    loud = solve(one_mode(), falling, 100.0)
    # ten times the sound pressure, less damping: more than ten times the motion
    assert loud.patch_acceleration_g > 10 * quiet.patch_acceleration_g


def test_damping_that_feeds_the_panel_is_refused():
    with pytest.raises(UnstableDamping):
        solve(one_mode(), dashpot(-300.0), 1.0, depends=False)


def test_the_table_says_decibels_against_bare_and_flags_large_deflection():
    bare = scenarios.solve_bare(one_mode(), 1.0)
    damped = solve(one_mode(), dashpot(300.0), 1.0, depends=False)
    (row,) = summary_rows(
        damped, bare, ["p"], thickness=0.025, power_balance_error=0.0, full=damped.response,
        read_at_g=np.nan, patch_motion_g=1.0,
    )  # fmt: skip
    ratio = bare.response.acceleration_rms[0] / damped.response.acceleration_rms[0]
    assert row["reduction_db"] == pytest.approx(20 * np.log10(ratio))
    assert row["reduction_db"] > 0
    assert not row["beyond_linear_plate"]
    displacement = damped.response.displacement_rms[0]
    (thin,) = summary_rows(
        damped, bare, ["p"], thickness=9 * displacement, power_balance_error=0.0,
        full=bare.response, read_at_g=np.nan, patch_motion_g=1.0,
    )  # fmt: skip
    assert thin["beyond_linear_plate"]
    # the last asked beside the bare panel in place of the full form: minus the reduction
    assert (row["diagonal_form_error_db"], thin["diagonal_form_error_db"]) == pytest.approx(
        (0.0, -row["reduction_db"])
    )


def test_a_scenario_without_response_is_nan_in_the_file():
    one = scenarios.solve_bare(one_mode(), 1.0)
    none = np.zeros((1, one.response.frequency.size))
    on_patches = OnPatches(one.response, none, none, none == 0)
    data = psd_dataset(
        {("dem", "bare"): on_patches}, {}, one.response.frequency, ["dem"], ["bare", "x"], ["p"],
        ["PID-1"],
    )  # fmt: skip
    assert np.isfinite(data["acceleration_psd"].sel(scenario="bare")).all()
    assert np.isnan(data["acceleration_psd"].sel(scenario="x")).all()
    assert all("units" in data[name].attrs for name in data.data_vars)
