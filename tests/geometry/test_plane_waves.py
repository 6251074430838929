"""Few Gauss points of the box stand for many points of a mesh under every plane wave."""

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed, degree, gauss

KAPPA = 30.0


def points(seed, sides, corner=(0.0, 0.0)):
    """Random points with weights and values of three shapes, on a box without its middle."""
    random = np.random.default_rng(seed)
    at = random.uniform(size=(4000, 2))
    at = at[np.linalg.norm(at - 0.5, axis=1) > 0.2]
    at = np.vstack([at, [[0, 0], [1, 1]]]) * sides + corner
    return at, random.uniform(size=len(at)), random.standard_normal((len(at), 3))


def waves(position, weight, values, kappa):
    """Σ w φ exp(iκ·x) for waves in sixteen directions, over Σ w|φ|."""
    angle = np.pi * np.arange(16) / 16
    phase = np.exp(1j * kappa * position @ np.array([np.cos(angle), np.sin(angle)]))
    return phase.T @ (weight[:, None] * values)


@pytest.mark.parametrize(
    ("sides", "corner"), [((2.1, 1.2), (0, 0)), ((0.3, 2.0), (5, -3)), ((0.1, 0.1), (0, 0))]
)
@pytest.mark.parametrize(("share", "error"), [(1.0, 1e-6), (0.5, 1e-10), (0.0, 1e-13)])
def test_condensed_points_answer_to_every_wave_as_all_of_them_do(sides, corner, share, error):
    # the accuracy that `condensed` states; at κ = 0 the integral of the shapes, to rounding
    position, weight, values = points(3, sides, corner)
    few = condensed(PanelQuadrature(position, weight, values), KAPPA)
    size = weight @ np.abs(values)
    apart = waves(position, weight, values, share * KAPPA) - waves(
        few.position, few.weight, few.shape, share * KAPPA
    )
    assert np.max(np.abs(apart) / size) < error


def test_the_points_are_gauss_points_of_the_box_whose_weights_sum_to_its_area():
    # as many as the degree of a wave across either side
    position, weight, values = points(4, (2.0, 1.0))
    few = condensed(PanelQuadrature(position, weight, values), KAPPA)
    assert len(few.weight) == degree(KAPPA) * degree(KAPPA / 2)
    assert few.weight.sum() == pytest.approx(2.0, rel=1e-13)
    assert few.shape.shape == (len(few.weight), 3)
    x = np.unique(few.position[:, 0].round(12))
    np.testing.assert_allclose(x, 1 + gauss(degree(KAPPA))[0], atol=1e-11)


def test_the_boxes_in_which_points_are_gathered_change_nothing(monkeypatch):
    # one box of 19 wavelengths against sixty
    position, weight, values = points(5, (2.0, 1.0))
    found = []
    for size in (2.0, 100.0):
        monkeypatch.setattr("pidpanel.geometry.plane_waves.WAVES_IN_A_BOX", size)
        few = condensed(PanelQuadrature(position, weight, values), KAPPA)
        found.append(waves(few.position, few.weight, few.shape, KAPPA / 2))
    scale = np.max(weight @ np.abs(values))
    np.testing.assert_allclose(found[0], found[1], atol=1e-11 * scale)
