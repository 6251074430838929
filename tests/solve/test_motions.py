"""Motions of patches: their covariance, the shapes that count, and what a negative C_e takes."""

import numpy as np
import pytest
from solving import panel_solver

from pidpanel.solve.diagonal import DiagonalPanel
from pidpanel.solve.direct import DirectMotions, DirectPanel
from pidpanel.solve.model import ModalBasis, Patches


def direct(frequency, basis, patches, points):
    force = np.eye(basis.natural_frequency.size)
    return DirectPanel(frequency, basis, patches, points, np.ones(frequency.size), force)


@pytest.mark.parametrize("form", ["reduced", "direct"])
@pytest.mark.parametrize("frequency", [[60.0, 70.0], [40.0, 44.0, 65.0, 120.0, 121.0]])
def test_the_covariance_over_a_patch_is_the_mean_square_of_its_acceleration(panel, frequency, form):
    # red: weights of one end alone halved; a covariance of two lines without their distance
    f = np.array(frequency)
    points = panel.points[:, None]
    if form == "reduced":
        force = np.eye(len(panel.modes))
        motions = panel_solver(panel.basis, panel.patches, f, points, force).motions((0, 1))
    else:
        motions = DirectMotions(direct(f, panel.basis, panel.patches, points), 1e9)
    damping, mass = np.full((2, f.size), 500.0), np.full((2, f.size), 2.0)
    covariance = motions.acceleration_covariance(damping, mass)
    square = np.einsum("pij,ji->p", motions.weight, covariance) / motions.area
    psd = motions.acceleration_psd(damping, mass)
    np.testing.assert_allclose(square, np.trapezoid(psd, f, axis=1), rtol=1e-10)


def test_shapes_to_five_times_a_line_count_and_the_ten_lowest_in_any_case():
    # to two and a half times on fewer lines; red: ten less one; the line before the last
    natural = np.arange(20, 0, -1) * 100.0
    basis = ModalBasis(natural, np.ones(20), 0.01)
    patches = Patches(np.eye(20)[None], np.ones(1))
    f = np.array([10.0, 210.0, 290.0])
    motions = DirectMotions(direct(f, basis, patches, np.ones((1, 1, 20))), 0.0)
    counts = [natural[motions._counts(lines)].max() for lines in (slice(0, 1), slice(1, 3))]
    assert counts == [1000.0, 1400.0]
    few = motions.subsampled(2)
    np.testing.assert_array_equal(few.frequency, [10.0, 290.0])
    assert natural[few._counts(slice(0, 1))].max() == 1000.0
    high = DirectMotions(direct(2 * f, basis, patches, np.ones((1, 1, 20))), 0.0)
    assert natural[high.subsampled(2)._counts(slice(1, 2))].max() == 1400.0


def test_of_uncoupled_modes_a_negative_damping_takes_its_share_of_each():
    # D_ii/C_ii with C = 2 ζ m ω: 0.1/(4 π) and 0.3/(8 π); red: at least 1
    basis = ModalBasis([50.0, 100.0], [2.0, 2.0], 0.01)
    patches = Patches(np.diag([0.1, 0.3])[None], np.array([0.2]))
    f = np.array([60.0])
    paper = DiagonalPanel(f, basis, patches, np.ones((1, 1, 2)), f, np.eye(2))
    np.testing.assert_allclose(paper.damping_norm, 0.3 / (8 * np.pi))
