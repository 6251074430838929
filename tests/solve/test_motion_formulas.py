"""Lines and bands at the ends of their ranges; the motion of the bare panel."""

import math

import numpy as np
import pytest
from solving import panel_solver, solve_bare, solve_layout

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve import bands
from pidpanel.solve.layout import Load
from pidpanel.solve.lines import frequency_grid, root_mean_square
from pidpanel.solve.model import ModalBasis, Patches


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


def test_the_bare_panel_states_its_own_level_under_any_sound():
    # one mode whose patch moves as its point does: √2 a_rms/g of either
    # red: root * solver.bare → / in `_response`
    frequency = frequency_grid(20.0, 300.0, 0.02, [65.0])
    patch = Patches(np.array([[[0.04]]]), np.array([0.04]))
    basis = ModalBasis([65.0], [1.5], 0.02)
    solver = panel_solver(basis, patch, frequency, [[1.0]], np.array([[0.3]]))
    for sound in (1.0, 100.0):
        found = solve_bare(solver, sound)
        level = math.sqrt(2) * found.response.acceleration_rms[0] / STANDARD_GRAVITY
        assert found.bare_patch_acceleration_g[0] == pytest.approx(level, rel=1e-9)
        assert found.fixed_points == 0
        assert found.acceleration_g.size == 0


def test_a_stated_level_is_one_level():
    # red: fixed_points: int = 1 → 2 in `_Motion`
    frequency = frequency_grid(20.0, 300.0, 0.02, [65.0])
    patch = Patches(np.array([[[0.04]]]), np.array([0.04]))
    basis = ModalBasis([65.0], [1.5], 0.02)
    solver = panel_solver(basis, patch, frequency, [[1.0]], np.array([[0.3]]))

    def law(f, level):
        return np.full(f.shape, 300.0), np.zeros(f.shape), np.ones(f.shape, bool)

    follows, stays = Load(0, law), Load(0, law, False)
    stated = solve_layout(solver, [follows], 1.0, stated_acceleration_g=3.0)
    assert stated.fixed_points == 1
    assert solve_layout(solver, [stays], 1.0).fixed_points == 1
