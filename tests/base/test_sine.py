"""Sine sweeps: single tones at the amplitude of each frequency, and jumps between motions."""

import numpy as np
import pytest
from moving import solved, transfer_of

from pidpanel.base.sine import Transfer, _other_motion, interface_force, sweep
from pidpanel.solve.layout import AttachedDamper
from pidpanel.solve.receptances import patch_stiffness

FREQUENCY = np.linspace(55.0, 75.0, 161)
AMPLITUDE = 1.0


def damper(law):
    """A load whose C_e is a law of Γ."""
    return AttachedDamper(0, lambda f, gamma: (0 * f + law(gamma), 0 * f + 0.5, f > 0), True)


def test_the_damping_is_that_of_each_frequencys_own_amplitude(panel):
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


class Prescribed:
    """In place of a transfer: ln Γ that follow on each line, from a C_e of 10 + ln Γ."""

    def __init__(self, frequency, outcomes):
        self.frequency, self.outcomes = np.array(frequency), outcomes

    def patch_acceleration(self, lines, stiffness):
        log_gamma = stiffness[:, 0].imag / (2 * np.pi * self.frequency[lines]) - 10
        return np.exp(self.outcomes[lines.start](log_gamma))[None]

    def motions(self, stiffness):
        return np.stack([self.frequency, 2 * self.frequency], axis=1)


@pytest.mark.parametrize(("down", "last"), [(False, 2.0), (True, 0.0)])
def test_each_line_is_solved_once_from_the_line_before(down, last):
    outcomes = [lambda x: 0 * x + 2, lambda x: 0 * x + 2, lambda x: x - x * (x - 1) * (x - 2) / 2]
    transfer = Prescribed([40.0, 50.0, 60.0], outcomes)
    result = sweep(transfer, [damper(lambda gamma: 10 + np.log(gamma))], AMPLITUDE, down=down)
    np.testing.assert_allclose(np.log(result.acceleration_g[0]), [2.0, 2.0, last], atol=1e-5)
    np.testing.assert_array_equal(result.motion, [[40, 80], [50, 100], [60, 120]])


def leaping(roots):
    """ln Γ that leap to and fro without a motion, but near the roots: (place, slope, reach)."""

    def outcome(x):
        surplus = 1.0 if int(np.floor(4 * x)) % 2 else -1.0
        for place, slope, reach in roots:
            if abs(x - place) <= reach:
                surplus = slope * (x - place)
        return x + surplus

    return outcome


def test_the_motion_that_follows_is_the_nearest_stable_one_of_all_loads():
    first = leaping([(1.5, 0.5, 0.2), (2.9, -1.0, 0.3), (-1.3, -1.0, 0.4)])

    def outcome(x):
        return np.array([first(x[0]), x[0] if x[0] > 0 else 1.0])

    ended, residual = _other_motion(outcome, np.array([1.0, 1.0]))
    np.testing.assert_allclose(ended, [2.9, 2.9], atol=1e-5)
    assert residual <= 1e-6


def test_the_force_of_the_supports_is_that_of_all_momenta_and_of_each_damper():
    motion = np.array([[2.0 + 1j, 7.0, 11.0], [1.0, 5.0, 3.0]])
    s = np.array([[1j, 2.0], [10.0, 100j]])
    force = interface_force(np.array([0.5, 1.0]) / np.pi, motion, [0, 1], s)
    np.testing.assert_allclose(force, [-2 - 1j + 7j + 110, -4 + 10 + 300j])


def test_where_two_motions_are_possible_the_sweeps_differ(panel):
    # a bed that rides on the panel at rest and leaves it in motion: the resonance moves up with Γ
    def leaving(frequency, gamma):
        return 0 * frequency + 20, 0 * frequency + 4 / (1 + (gamma / 15) ** 4), frequency > 0

    transfer = transfer_of(panel, FREQUENCY)
    up, down = (
        sweep(transfer, [AttachedDamper(0, leaving, True)], AMPLITUDE, down=down)
        for down in (False, True)
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
