"""What the mesh does to PSDs: stated for resonances that are known to be too high."""

import numpy as np
import pytest

from pidpanel.solve.mesh_error import (
    AMPLITUDE,
    MeshShift,
    decibels,
    mesh_error,
    point_shifts,
    shift_of_modes,
)
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.sharpness import LoadedModes, loaded_modes

RATIO = 0.01
AT = np.array([120.0, 310.0, 340.0, 770.0])


def by_waves(frequency, shift):
    return MeshShift(np.broadcast_to(shift, frequency.shape), np.zeros(frequency.shape))


def resonances(frequency, raised=0.0):
    """(nf, 1) of an acceleration under white pressure."""
    f = frequency[:, None]
    at = AT * (1 + raised)
    return np.sum(f**4 / ((f**2 - at**2) ** 2 + (2 * RATIO * f * at) ** 2), axis=1)[:, None]


@pytest.mark.parametrize("raised", [1e-4, 1e-3, 3e-3])
def test_the_error_is_that_of_resonances_which_are_too_high(raised):
    f = np.geomspace(50, 1000, 20_000)
    true, meshed = resonances(f), resonances(f, raised)
    error = mesh_error(f, meshed, np.ones_like(f), by_waves(f, raised))
    np.testing.assert_allclose(error.line, np.max(np.abs(true / meshed - 1)), rtol=0.05)
    squares = np.trapezoid(np.hstack([true, meshed]), f, axis=0)
    difference = abs(np.sqrt(squares[0] / squares[1]) - 1)
    # of the weight f⁴ at a resonance, beside what its shift does at the ends of the range
    assert error.rms - AMPLITUDE * raised == pytest.approx(difference, abs=2.5 * raised)


def test_steps_of_the_sound_do_not_count():
    f = np.geomspace(50, 1000, 2000)
    step = np.where(f < 500, 1.0, 4.0)
    smooth = (step * f**2)[:, None]
    error = mesh_error(f, smooth, step, by_waves(f, 1e-3))
    assert error.line == pytest.approx(2e-3, rel=0.02) and error.point_rms == 0
    resting = mesh_error(f, np.zeros((2000, 1)), step, by_waves(f, 1e-3))
    assert resting.line == 0 and resting.rms == 0  # a point on a support


def test_a_mode_is_raised_by_the_mean_over_its_kinetic_energy():
    modal = ModalBasis([30.0, 90.0], [2.0, 2.0], RATIO)  # of 4 kg/m² on 2 m²
    patch = np.diag([0.25, 0.0])[None]  # half the energy of the first, nothing of the second
    modes = loaded_modes(modal, patch, np.array([12.0]), 4.0)
    share = 16 * 0.25 / (2 + 12 * 0.25)
    np.testing.assert_allclose(modes.share, [[share, 0.0]])
    np.testing.assert_allclose(modes.frequency, [30 / np.sqrt(2.5), 90.0])
    bare, patches, points = np.array([1e-4, 1e-3]), [[1e-2, 1e-2]], np.array([0.2, 0.1])
    shift = shift_of_modes(np.array([10.0, 60.0]), modes, bare, patches, points)
    first = share * 1e-2 + (1 - share) * 1e-4
    np.testing.assert_allclose(shift, [[first, first], points])  # the second has less by waves


def test_a_line_has_the_shift_of_the_mode_that_is_nearest_in_the_logarithm():
    modes = LoadedModes(
        np.array([100.0, 400.0, 900.0]), np.full(3, RATIO), np.zeros((1, 3)), np.eye(3)
    )
    lines = np.array([50.0, 199.0, 201.0, 599.0, 601.0, 2000.0])
    points = np.array([7.0, 5.0, 6.0])
    shift = shift_of_modes(lines, modes, np.array([1.0, 2.0, 4.0]), np.zeros((1, 3)), points)
    np.testing.assert_array_equal(shift, [[1, 1, 2, 2, 4, 4], [7, 7, 5, 5, 6, 6]])


def test_a_mode_falls_by_the_energy_of_its_reactions():
    # a spring k at a point of w = 2 and a mass m at one of w = 3, modal mass 1 kg: a compliance C
    # in series lowers ω² by F² C
    compliance, k, m = 1e-9, 5e4, 0.3
    omega = np.array([0.0, 100.0, 400.0])
    rows = (
        np.sqrt(compliance / 2) * np.array([[2 * k], [0.0]]),
        np.sqrt(compliance / 2) * np.array([[0.0], [3 * m]]),
    )
    shift = point_shifts(np.array(rows) * np.ones(3), omega)
    force = np.array([np.full(3, 2 * k), 3 * m * omega**2])
    lowered = np.sqrt(omega[1:] ** 2 - compliance * np.sum(force[:, 1:] ** 2, axis=0))
    np.testing.assert_allclose(shift[1:], 1 - lowered / omega[1:], rtol=0.03)
    assert shift[0] == 0


def test_what_stands_at_points_counts_for_the_rms_alone():
    f = np.geomspace(10, 1000, 5000)
    psd = f[:, None] ** -4
    shift = MeshShift(np.zeros(f.shape), np.full(f.shape, 0.01), np.array([0.07]))
    error = mesh_error(f, psd, np.ones_like(f), shift)
    assert error.line == 0 and error.rms == 0
    assert error.point_rms == pytest.approx(1 - np.exp(-0.02) + 2 * 0.01 + 0.07, rel=1e-4)
    assert mesh_error(f, 0 * psd, np.ones_like(f), shift).point_rms == 0  # on the support
    shift.points[f > 20] = 0.0  # 7/8 of the mean square lie below 20 Hz
    assert mesh_error(f, psd, np.ones_like(f), shift).point_rms == pytest.approx(0.105, abs=2e-3)


@pytest.mark.parametrize("slope", [5.0, -5.0])
@pytest.mark.parametrize("line", [30, 58, 59])
def test_a_raised_line_errs_by_the_slope_above_it_and_the_last_by_that_below(slope, line):
    # flat but from a line on, or before the last
    x = 0.01 * np.arange(60)
    psd = np.exp(slope * np.maximum(x - x[min(line, 58)], 0))
    shift = np.where(np.arange(60) == line, 1e-3, 0.0)
    error = mesh_error(np.exp(x), psd[:, None], np.ones(60), by_waves(x, shift))
    assert error.line == pytest.approx(np.expm1(5e-3), rel=1e-9)


def test_the_error_of_an_rms_is_that_of_the_slope_and_of_the_amplitudes():
    # S ∝ f⁻⁴ is lower by exp(−0.04) everywhere, and amplitudes err by three times the shift
    f = np.geomspace(10, 1000, 5000)
    error = mesh_error(f, f[:, None] ** -4, np.ones_like(f), by_waves(f, 0.01))
    assert error.rms == pytest.approx(1 - np.exp(-0.02) + 3 * 0.01, rel=1e-4)


def test_a_point_without_motion_at_a_line_has_no_error():
    psd = np.ones((9, 1))
    psd[4] = 0
    f = np.geomspace(1, 2, 9)
    error = mesh_error(f, psd, np.ones(9), by_waves(f, 1e-3))
    assert error.line == 0 and error.rms == 0


def test_decibels_of_an_error():
    assert decibels(10**0.05 - 1) == pytest.approx(0.5)


def test_over_the_largest_point_a_minimum_of_another_counts_little():
    # the first point is 20 dB above the second, whose minimum is shifted
    f = np.geomspace(50.0, 200.0, 2001)
    dip = (f / 100 - 1) ** 2 + 1e-4
    psd, shift = np.stack([np.full(f.size, 100.0), dip], axis=1), by_waves(f, 1e-3)
    alone = mesh_error(f, psd, np.ones(f.size), shift).line
    among = mesh_error(f, psd, np.ones(f.size), shift, over_largest=True).line
    assert alone[1] > 0.05 and among[1] < 1e-2 * alone[1]
    assert among[0] == pytest.approx(alone[0])
