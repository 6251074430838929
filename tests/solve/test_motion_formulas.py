"""Lines, bands and the search of a level at the ends of their ranges; the bare panel's own level."""

import math

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve import bands, scenarios
from pidpanel.solve.linearisation import find_motions
from pidpanel.solve.lines import frequency_grid, root_mean_square
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.solvers import PanelInField, PanelSolver


def test_a_centre_at_either_end_of_the_range_belongs_to_it():
    # lg of 10^(N/10) is off by rounding; red: + 1e-9 → - 1e-9 in `third_octaves`
    centre, _ = bands.third_octaves(10**2.1, 10**2.9)
    np.testing.assert_allclose(centre, 10 ** (np.arange(21, 30) / 10))


def test_natural_frequencies_outside_the_range_are_left_out():
    # red: (peaks > lowest) & → | in `frequency_grid`
    grid = frequency_grid(50.0, 200.0, 0.1, [20.0, 100.0, 900.0])
    assert (grid[0], grid[-1]) == (50.0, 200.0)
    assert 100.0 in grid


def test_a_step_below_1_hz_is_integrated_exactly():
    # red: np.nextafter(inside, 0.0) → np.nextafter(inside, 1.0)
    grid = frequency_grid(0.2, 2.0, 0.1, jumps=[0.5])
    psd = np.where(grid < 0.5, 3.0, 7.0)
    assert root_mean_square(grid, psd) == pytest.approx(np.sqrt(3 * 0.3 + 7 * 1.5), rel=1e-12)


def level_of(expected, gamma_range, scan_count=7):
    """Search with a motion that is ``expected`` whatever the damping is; and count the asking."""
    asked = []

    def rms(damping, mass):
        asked.append(damping)
        return expected * STANDARD_GRAVITY / math.sqrt(2)

    lines = np.array([100.0])
    search = find_motions(
        lines, lambda f, gamma: (f * 0 + gamma, f * 0, True), rms, gamma_range, scan_count
    )
    return search, len(asked)


@pytest.mark.parametrize("expected", [0.0101, 0.05, 1.0, 9.9])
def test_a_level_is_found_in_every_part_of_the_range_and_every_response_counted(expected):
    # 0.0101 lies in the first interval of the scan of 0.01 to 10, 9.9 in its last
    # red: math.log(low) → low; range(len(above) - 1) → - 2; iterations = 0 → 1
    search, asked = level_of(expected, (0.01, 10.0))
    assert [point.gamma for point in search.fixed_points] == [pytest.approx(expected, rel=1e-6)]
    assert search.iterations == asked


def test_the_bare_panel_states_its_own_level_under_any_sound():
    # one mode whose patch moves as its point does: √2 a_rms/g of either
    # red: root * solver.bare → / in `_scenario`
    frequency = frequency_grid(20.0, 300.0, 0.02, [65.0])
    patch = Patches(np.array([[[0.04]]]), np.array([0.04]))
    panel = PanelInField(
        ModalBasis([65.0], [1.5], 0.02), patch, lambda f: np.ones(f.size), np.array([[0.3]])
    )
    solver = PanelSolver(panel, frequency, [[1.0]], frequency)
    for sound in (1.0, 100.0):
        found = scenarios.solve_bare(solver, sound)
        level = math.sqrt(2) * found.response.acceleration_rms[0] / STANDARD_GRAVITY
        assert found.bare_patch_acceleration_g[0] == pytest.approx(level, rel=1e-9)
        assert found.fixed_points == 0
        assert found.acceleration_g.size == 0


def test_a_stated_level_is_one_level():
    # red: fixed_points: int = 1 → 2 in `_Found`
    frequency = frequency_grid(20.0, 300.0, 0.02, [65.0])
    patch = Patches(np.array([[[0.04]]]), np.array([0.04]))
    panel = PanelInField(
        ModalBasis([65.0], [1.5], 0.02), patch, lambda f: np.ones(f.size), np.array([[0.3]])
    )
    solver = PanelSolver(panel, frequency, [[1.0]], frequency)

    def law(f, level):
        return np.full(f.shape, 300.0), np.zeros(f.shape), np.ones(f.shape, bool)

    follows, stays = scenarios.Load(0, law), scenarios.Load(0, law, False)
    stated = scenarios.solve_layout(solver, [follows], 1.0, stated_acceleration_g=3.0)
    assert stated.fixed_points == 1
    assert scenarios.solve_layout(solver, [stays], 1.0).fixed_points == 1
