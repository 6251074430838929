"""Linear dampers on the panel, against a solve of all its equations."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupled.linear import linear_motion, linear_psds
from pidpanel.solve.modal import LINES_AT_ONCE

LINES = 4 * LINES_AT_ONCE + 9


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
        panel=(frequency, plate.modal, None, felt, seen),
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
    rng = np.random.default_rng(3)
    amplitude = rng.standard_normal((LINES, plate.count)) + 1j
    found = linear_motion(*damped.panel, damped.load, amplitude)
    wanted = np.linalg.solve(damped.full, amplitude[:, :, None])[:, :, 0] @ damped.seen.T
    assert found == pytest.approx(wanted, rel=1e-9)


def on_lines(damped, matrix):
    """A cross-PSD at every line as a function of frequency."""
    return lambda lines: matrix[np.searchsorted(damped.panel[0], lines)]


@pytest.mark.parametrize("kind", [float, complex])
def test_psds_are_those_of_all_equations(plate, damped, kind):
    # of three dampers at once: none, one, and one under another force
    rng = np.random.default_rng(4)
    sound, own = hermitian(rng, plate.count, kind), hermitian(rng, plate.count, float)
    both, alone = on_lines(damped, sound + own), on_lines(damped, sound)
    sets = [(0 * damped.load, alone), (damped.load, alone), (damped.load, both)]
    found = linear_psds(*damped.panel, sets)
    wanted = [
        wanted_psd(damped.bare, damped.seen, sound),
        wanted_psd(damped.full, damped.seen, sound),
        wanted_psd(damped.full, damped.seen, sound + own),
    ]
    assert found == pytest.approx(np.array(wanted), rel=1e-9)


def test_of_no_damper_the_panel_is_bare(plate, damped):
    frequency, modal, _, _, seen = damped.panel
    sound = hermitian(np.random.default_rng(6), plate.count, float)
    none = np.zeros((LINES, 0), complex), on_lines(damped, sound)
    (found,) = linear_psds(frequency, modal, None, np.zeros((plate.count, 0)), seen, [none])
    assert found == pytest.approx(wanted_psd(damped.bare, damped.seen, sound), rel=1e-9)


def test_a_panel_in_air_has_the_whole_matrix(plate, damped):
    air = 2e4 * hermitian(np.random.default_rng(7), plate.count, float)[0] * (0.3 + 0.1j)
    frequency, modal, _, felt, seen = damped.panel

    def added(lines):
        return (lines / 100.0)[:, None, None] * air

    whole, full = (frequency, modal, added, felt, seen), damped.full + added(frequency)
    sound = hermitian(np.random.default_rng(8), plate.count, float)
    (found,) = linear_psds(*whole, [(damped.load, on_lines(damped, sound))])
    assert found == pytest.approx(wanted_psd(full, seen, sound), rel=1e-9)
    amplitude = np.ones((LINES, plate.count), complex)
    wanted = np.linalg.solve(full, amplitude[:, :, None])[:, :, 0] @ seen.T
    assert linear_motion(*whole, damped.load, amplitude) == pytest.approx(wanted, rel=1e-9)
