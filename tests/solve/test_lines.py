"""Frequency lines and integration over them."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.lines import GridError, frequency_grid, root_mean_square
from pidpanel.solve.modal import bare_panels


def rms_with(panel, lines_per_bandwidth, mass=0.0):
    frequency = frequency_grid(
        28.0, 500.0, 0.01, panel.basis.natural_frequency, lines_per_bandwidth=lines_per_bandwidth
    )
    (bare,) = bare_panels(
        frequency,
        panel.basis,
        [panel.patches],
        panel.points,
        1e4 / frequency,
        panel.modal_force(100.0)[0],
    )
    zero = np.zeros((2, frequency.size))
    response = attach_dampers(bare, zero, zero + mass)
    return np.concatenate([response.acceleration_rms, response.displacement_rms])


@pytest.mark.parametrize("mass", [0.0, 6.4])
def test_rms_is_converged_on_the_default_grid(panel, mass):
    panel = replace(panel, modes=panel.modes[::3])  # a third is enough
    # against four times the lines, bare and with resonances moved by undamped mass: the added
    # natural frequencies cost 0.05 %; 0.5 % is what a reader can tell
    default, fine = rms_with(panel, 8.0, mass), rms_with(panel, 32.0, mass)
    np.testing.assert_allclose(default, fine, rtol=5e-4)


def test_lines_are_no_further_apart_than_a_share_of_the_bandwidth():
    grid = frequency_grid(20.0, 2000.0, 0.01, [100.0, 101.0], [350.0])
    assert np.max(np.diff(np.log(grid))) <= 2 * 0.01 / 8 * (1 + 1e-9)
    assert (grid[0], grid[-1]) == (20.0, 2000.0)
    assert {100.0, 101.0, 350.0} <= set(grid.tolist())


def test_a_step_is_integrated_exactly_where_the_grid_knows_it():
    # 3 below 100 Hz, 7 from 100 Hz: exact by the pair of lines; rounding
    grid = frequency_grid(50.0, 200.0, 0.1, jumps=[100.0, 30.0, 900.0])
    psd = np.where(grid < 100.0, 3.0, 7.0)
    assert root_mean_square(grid, psd) == pytest.approx(np.sqrt(3 * 50 + 7 * 100), rel=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0, 100.0, 0.01), "lowest = 0.0"),
        ((200.0, 100.0, 0.01), "0 < lowest < highest"),
        ((20.0, np.inf, 0.01), "highest = inf"),
        ((20.0, 100.0, 0.0), "damping_ratio = 0"),
        ((20.0, 100.0, 0.01, (), (), -1.0), "lines_per_bandwidth = -1"),
    ],
)
def test_a_range_without_lines_is_refused(arguments, message):
    with pytest.raises(GridError, match=message):
        frequency_grid(*arguments)


def test_few_lines_with_the_steps_of_a_spectrum_give_rms_values_within_a_thousandth():
    # third octaves of random levels, thirty modes
    draw = np.random.default_rng(2)
    edges = 28.0 * 2 ** (np.arange(1, 13) / 3)
    for _ in range(20):
        modes, level = np.sort(draw.uniform(40, 450, 30)), 10 ** draw.uniform(-0.5, 0.5, 13)

        def rms(count, jumps, modes=modes, level=level):
            f = frequency_grid(30.0, 450.0, 0.01, jumps=jumps, lines_per_bandwidth=count)
            r = f[:, None] / modes
            motion = np.sum(r**4 / ((1 - r**2) ** 2 + (0.02 * r) ** 2), axis=1)
            return root_mean_square(f, level[np.searchsorted(edges, f, side="right")] * motion)

        assert rms(3, edges) == pytest.approx(rms(32, edges), rel=1e-3)
