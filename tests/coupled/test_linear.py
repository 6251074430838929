"""Linear dampers on the panel, against a solve of all its equations."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupled.linear import LINES_AT_ONCE, Receptances

LINES = 2 * LINES_AT_ONCE + 9


@pytest.fixture(scope="module")
def damped(plate):
    """The plate with a damper of its own at every cell, over more lines than are solved at once."""
    frequency = np.linspace(40, 500, LINES)
    rng = np.random.default_rng(2)
    z = 300 * (1 + rng.random(8)) + 2j * np.pi * frequency[:, None] * (1 + rng.random(8))
    load = z * plate.area
    felt = plate.at_cells.T
    omega = 2 * np.pi * frequency[:, None, None]
    bare = plate.stiffness(frequency)[:, :, None] * np.eye(plate.count)
    seen = plate.at_points
    return SimpleNamespace(
        receptances=Receptances(frequency, plate.stiffness, felt, seen),
        load=load,
        bare=bare,
        full=bare + 1j * omega * ((felt * load[:, None]) @ felt.T),
        seen=seen,
    )


def hermitian(rng, count, kind):
    """A cross-PSD at every line, of full rank."""
    root = rng.standard_normal((LINES, count, count))
    if kind is complex:
        root = root + 1j * rng.standard_normal(root.shape)
    return root @ np.swapaxes(root.conj(), 1, 2)


def wanted_psd(matrix, seen, force):
    row = seen @ np.linalg.inv(matrix)
    return np.einsum("fpi,fij,fpj->fp", row, force, row.conj()).real


def test_motion_is_that_of_all_equations(plate, damped):
    # red: `- (receptance` → `+ (receptance`; frequency left out of `force`
    rng = np.random.default_rng(3)
    amplitude = rng.standard_normal((LINES, plate.count)) + 1j
    found = damped.receptances.motion(damped.load, amplitude)
    wanted = np.linalg.solve(damped.full, amplitude[:, :, None])[:, :, 0] @ damped.seen.T
    assert found == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("kind", [float, complex])
def test_psds_are_those_of_all_equations(plate, damped, kind):
    # of three dampers at once: none, one, and one with a force of its own
    # red: flat.conj() → flat in _quadratic; `psds[k, lines] +=` → `psds[:, lines] +=`;
    # `receptance[:, count:]` transposed; `excitation(lines)` → that of the first lines
    rng = np.random.default_rng(4)
    sound, own = hermitian(rng, plate.count, kind), hermitian(rng, plate.count, float)
    found = damped.receptances.psds(
        [0 * damped.load, damped.load, damped.load],
        lambda lines: sound[lines],
        [None, None, lambda lines: own[lines]],
    )
    wanted = [
        wanted_psd(damped.bare, damped.seen, sound),
        wanted_psd(damped.full, damped.seen, sound),
        wanted_psd(damped.full, damped.seen, sound + own),
    ]
    assert found == pytest.approx(np.array(wanted), rel=1e-9)


def test_without_sound_the_own_force_moves_the_panel_alone(plate, damped):
    # red: `if excitation is not None` → `if True`
    own = hermitian(np.random.default_rng(5), plate.count, complex)
    (found,) = damped.receptances.psds([damped.load], None, [lambda lines: own[lines]])
    assert found == pytest.approx(wanted_psd(damped.full, damped.seen, own), rel=1e-9)


def test_of_no_damper_the_panel_is_bare(plate, damped):
    # red: `motions / stiffness` of its real part
    frequency = damped.receptances.frequency
    bare = Receptances(frequency, plate.stiffness, np.zeros((plate.count, 0)), damped.seen)
    sound = hermitian(np.random.default_rng(6), plate.count, float)
    (found,) = bare.psds([np.zeros((LINES, 0), complex)], lambda lines: sound[lines], [None])
    assert found == pytest.approx(wanted_psd(damped.bare, damped.seen, sound), rel=1e-9)


def test_a_panel_in_air_has_the_whole_matrix(plate, damped):
    # red: `swapaxes` left out; the diagonal of Z₀ alone
    air = 2e4 * hermitian(np.random.default_rng(7), plate.count, float)[0] * (0.3 + 0.1j)
    frequency, felt = damped.receptances.frequency, plate.at_cells.T

    def stiffness(lines):
        return plate.stiffness(lines)[:, :, None] * np.eye(plate.count) + air

    whole = Receptances(frequency, stiffness, felt, damped.seen)
    sound = hermitian(np.random.default_rng(8), plate.count, float)
    (found,) = whole.psds([damped.load], lambda lines: sound[lines], [None])
    assert found == pytest.approx(wanted_psd(damped.full + air, damped.seen, sound), rel=1e-9)
    amplitude = np.ones((LINES, plate.count), complex)
    wanted = np.linalg.solve(damped.full + air, amplitude[:, :, None])[:, :, 0] @ damped.seen.T
    assert whole.motion(damped.load, amplitude) == pytest.approx(wanted, rel=1e-9)
