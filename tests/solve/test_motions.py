"""Motions of patches: their covariance, the shapes that count, and what a negative C_e takes."""

import numpy as np
import pytest
from solving import panel_solver

from pidpanel.solve.direct import SHAPES_TO, DirectMotions, DirectPanel
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.motions import ReducedMotions


def direct(frequency, basis, patches, points, force=None):
    force = np.eye(basis.natural_frequency.size) if force is None else force
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


@pytest.mark.parametrize("loaded", [[0], [0, 1]])
@pytest.mark.parametrize("kind", ["real", "complex"])
def test_patches_move_and_follow_their_dampers_alike_in_few_motions_and_in_all_shapes(
    panel, loaded, kind
):
    # red: in _moved of all shapes, the imaginary part; the dampers of another patch
    f, n = np.array([60.0, 150.0, 700.0]), len(panel.modes)
    root = np.random.default_rng(1).normal(size=(2, n, 3))
    root = root[0] + (1j * root[1] if kind == "complex" else 0)
    force, patches = root @ root.conj().T, panel.patches.subset(loaded)
    none = np.zeros((0, 1, n))
    (bare,) = bare_panels(
        f, panel.basis, [patches], none, np.ones(3), force, overlap_cutoff=1e-14
    )  # fmt: skip
    few = ReducedMotions(bare)
    whole = DirectMotions(direct(f, panel.basis, patches, none, force), 1e9, 1e3)
    dampers = np.array([[300.0, 500.0, 900.0], [800.0, 400.0, 100.0]])[loaded]
    dampers = dampers, dampers / 200
    np.testing.assert_allclose(
        few.acceleration_psd(*dampers), whole.acceleration_psd(*dampers), rtol=1e-8
    )
    slope = whole.acceleration_slope(*dampers)
    np.testing.assert_allclose(
        few.acceleration_slope(*dampers), slope, rtol=0, atol=1e-8 * np.abs(slope).max()
    )


@pytest.mark.parametrize("short", [0, 1])
@pytest.mark.parametrize("in_air", [False, True])
def test_matrices_that_fit_into_memory_are_asked_for_once(in_air, short):
    # 8 bytes of a real number and 16 of a complex one; red: more than there is; one part left out
    n, f, asked = 6, np.array([60.0, 150.0, 700.0]), []

    def force(frequency):
        asked.append(frequency.size)
        return np.broadcast_to(np.eye(n), (frequency.size, n, n)).copy()

    air = np.zeros((f.size, n, n), complex) if in_air else None
    patches = Patches(np.eye(n)[None], np.ones(1))
    basis = ModalBasis(np.arange(1, n + 1) * 100.0, np.ones(n), 0.01)
    whole = DirectPanel(f, basis, patches, np.zeros((0, 1, n)), np.ones(3), force, air)
    size = n**2 * (8 * f.size + 8 + (16 * f.size if in_air else 0))
    motions = DirectMotions(whole, size - short)
    dampers = np.zeros((2, 1, f.size))
    psds = [motions.acceleration_psd(*dampers) for _ in range(2)]
    assert (len(asked) == 1) == (short == 0)
    np.testing.assert_array_equal(*psds)


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
    high = DirectMotions(direct(2 * f, basis, patches, np.ones((1, 1, 20))), 0.0, SHAPES_TO)
    assert natural[high.subsampled(2)._counts(slice(1, 2))].max() == 1400.0
