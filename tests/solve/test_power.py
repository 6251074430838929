"""What the field puts in is lost in the panel, its dampers and the air."""

from dataclasses import fields

import numpy as np
import pytest
from solving import air_resistance

from pidpanel.solve.power import power_balance


def balance_of(panel, lines, radiation=True, **changes):
    arguments = {
        "frequency": lines.frequency,
        "basis": panel.basis,
        "patches": panel.patches,
        "spectrum": lines.spectrum,
        "modal_force": lines.modal_force,
        "equivalent_damping": lines.equivalent_damping,
        "apparent_mass": lines.apparent_mass,
        "overlap_cutoff": 1e-14,
    }
    if radiation:
        omega = 2 * np.pi * lines.frequency[:, None, None]
        resistance = air_resistance(lines.frequency, lines.modal_force)
        added_mass = 0.1 * lines.modal_force  # any symmetric matrix: mass takes no power
        arguments["air_stiffness"] = 1j * omega * resistance - omega**2 * added_mass
    return power_balance(**(arguments | changes))


@pytest.mark.parametrize("radiation", [False, True])
def test_power_put_in_is_power_lost_at_every_line(panel, lines, radiation):
    # exact for the exact solution: 1e-10 is rounding, since Re(iωH) is a small part of |ωH|
    # off resonance
    balance = balance_of(panel, lines, radiation)
    assert np.max(balance.error) < 1e-10
    assert np.all(balance.structure > 0)
    assert np.all(balance.patches > 0)
    assert np.all(balance.radiation > 0 if radiation else balance.radiation == 0)


def test_power_balances_to_a_millionth_with_the_default_cutoff(panel, lines):
    assert np.max(balance_of(panel, lines, overlap_cutoff=1e-8).error) < 1e-6


def test_a_wrong_loss_upsets_the_balance(panel, lines):
    # the mark is no identity: 1 % more in one place shows
    balance = balance_of(panel, lines)
    share = balance.patches[:, 0] / balance.field
    upset = {f.name: getattr(balance, f.name) for f in fields(balance)}
    upset["patches"] = balance.patches * [1.01, 1.0]
    np.testing.assert_allclose(type(balance)(**upset).error, 0.01 * share, rtol=1e-6)


def test_a_plane_wave_balances_too(panel, lines):
    # a Hermitian force of rank one
    phase = np.exp(1j * np.arange(len(panel.modes)) ** 2)
    balance = balance_of(panel, lines, modal_force=np.outer(phase, phase.conj()))
    assert np.max(balance.error) < 1e-10


def test_one_mode_takes_from_white_noise_the_power_s_over_4m(panel):
    # ∫ Re(iωH) S df = S/(4m), whatever the damping is; 1e-3: range ends and trapezoids
    from pidpanel.solve.lines import frequency_grid
    from pidpanel.solve.model import ModalBasis, Patches

    frequency = frequency_grid(0.1, 1e5, 0.05, [100.0])
    none = np.zeros((1, frequency.size))
    balance = power_balance(
        frequency,
        ModalBasis([100.0], [2.0], 0.05),
        Patches(np.array([[[0.1]]]), np.array([0.1])),
        np.full(frequency.size, 4.0),
        [[1.0]],
        none + 300.0,
        none,
    )
    assert np.trapezoid(balance.field, frequency) == pytest.approx(4.0 / (4 * 2.0), rel=1e-3)
