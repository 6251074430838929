"""Sine sweeps: single tones at the amplitude of each frequency, and jumps between motions."""

import numpy as np
from moving import solved, transfer_of

from pidpanel.base.sine import _Damping, sweep
from pidpanel.base.transfer import Transfer
from pidpanel.solve.dampers import patch_stiffness
from pidpanel.solve.layout import Load

FREQUENCY = np.linspace(55.0, 75.0, 161)
AMPLITUDE = 1.0


def damper(law):
    """A load whose C_e is a law of Γ."""
    return Load(0, lambda f, gamma: (0 * f + law(gamma), 0 * f + 0.5, f > 0), True)


def test_the_damping_is_that_of_each_frequencys_own_amplitude(panel):
    # red: Γ of the whole sweep; √2; the amplitude of the point
    def law(gamma):
        return 300 / gamma

    transfer = transfer_of(panel, FREQUENCY)
    result = sweep(transfer, [damper(law)], AMPLITUDE)
    gamma = result.acceleration_g[0]
    assert gamma.max() / gamma.min() > 2
    s = patch_stiffness(FREQUENCY, law(gamma)[None], np.full((1, FREQUENCY.size), 0.5))
    again = AMPLITUDE * transfer.patch_acceleration(slice(None), s)[:, 0]
    np.testing.assert_allclose(again, gamma, rtol=2e-3)  # C_e is linear in ln Γ in steps of 20 %
    assert result.residual.max() < 1e-6


def test_the_damping_is_held_beyond_a_thousand_times_the_motion_of_the_base():
    # up to there it is that of its Γ; red: RANGE to 1100; beyond the last but one
    loads = [damper(lambda gamma: gamma**2)]
    damping = _Damping(loads, np.array([50.0]), 2.0, None)
    highest = patch_stiffness(np.array([50.0]), np.array([[2000.0**2]]), np.array([[0.5]]))
    for gamma in (2000.0, 9000.0):
        np.testing.assert_allclose(damping.at(0, np.log([gamma])), highest, rtol=1e-12)


def test_where_two_motions_are_possible_the_sweeps_differ(panel):
    # red: every line from the same start
    # a bed that rides on the panel at rest and leaves it in motion: the resonance moves up with Γ
    def leaving(frequency, gamma):
        return 0 * frequency + 20, 0 * frequency + 4 / (1 + (gamma / 15) ** 4), frequency > 0

    transfer = transfer_of(panel, FREQUENCY)
    up, down = (
        sweep(transfer, [Load(0, leaving, True)], AMPLITUDE, down=down) for down in (False, True)
    )
    assert max(up.residual.max(), down.residual.max()) < 1e-5
    up, down = up.acceleration_g[0], down.acceleration_g[0]
    apart = np.abs(up / down - 1) > 0.05
    assert apart.any() and not apart.all()
    # a resonance that moves up is followed by the sweep up
    assert np.all(up[apart] > down[apart])
    np.testing.assert_allclose(up[[0, -1]], down[[0, -1]], rtol=1e-4)


def test_a_stated_acceleration_is_the_one_that_counts(panel):
    transfer = transfer_of(panel, FREQUENCY)
    result = sweep(transfer, [damper(lambda gamma: 100 * gamma)], AMPLITUDE, stated_g=4.0)
    exact = patch_stiffness(FREQUENCY, *np.full((2, 1, FREQUENCY.size), [[[400.0]], [[0.5]]]))
    np.testing.assert_allclose(result.stiffness, exact)


def test_the_bare_panel_has_no_damper(panel):
    motion, _, _ = solved(panel, FREQUENCY)
    rows = panel.observed.reshape(-1, panel.observed.shape[2])
    bare = Transfer.of_panel(
        FREQUENCY, panel.modal, panel.patches.subset([]), panel.excitation.force, rows
    )
    result = sweep(bare, [], AMPLITUDE)
    np.testing.assert_allclose(result.motion, motion.reshape(len(FREQUENCY), -1), rtol=1e-12)
    assert result.acceleration_g.shape == (0, len(FREQUENCY))
