"""Strain and stress of the layers from the cross-PSDs of the motion."""

import numpy as np
import pytest

from pidpanel.solve import stress
from pidpanel.solve.model import PanelResponse

LAYERS = stress.Layers(
    ("top",),
    0.01 * np.eye(3)[None],
    7e8 * np.array([[[1.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.35]]]),
)


def sampled(matrix, count=400_000):
    """A Gaussian motion (w, κ, γ) with the covariance A Aᵀ, and a one-line response to it."""
    covariance = matrix @ matrix.T
    response = PanelResponse(
        np.array([0.0, 2.0]), np.broadcast_to(covariance / 2, (2, 1, 6, 6)) + 0j
    )
    return response, matrix @ np.random.default_rng(2).standard_normal((6, count))


def test_rms_stresses_are_those_of_a_sampled_motion():
    # 400 000 samples: 1/√(2·4e5) = 0.11 % on an rms; 0.5 % is 4.5 standard errors
    matrix = np.tril(np.random.default_rng(1).standard_normal((6, 6))) + np.eye(6)
    response, motion = sampled(matrix)
    strain, (sx, sy, txy) = LAYERS.strain[0] @ motion[1:4], LAYERS.stress[0] @ motion[1:4]
    von_mises = np.sqrt(sx**2 + sy**2 - sx * sy + 3 * txy**2)
    expected = [np.sqrt(np.mean(x**2)) for x in (*strain, sx, sy, txy, von_mises)]
    rms = np.sqrt(np.trapezoid(stress.layer_psd(response, LAYERS), response.frequency, axis=0))
    np.testing.assert_allclose(rms[0, 0], expected, rtol=5e-3)
    core = np.array([[2e8, 0.0], [0.0, 1e8]])
    shear = np.sqrt(np.trapezoid(stress.core_psd(response, core), response.frequency, axis=0))
    np.testing.assert_allclose(shear[0], np.std(core @ motion[4:], axis=1), rtol=5e-3)


def test_von_mises_stress_of_pure_shear_is_root_three_times_it():
    matrix = np.zeros((6, 6))
    matrix[3, 3] = 1.0
    response, _ = sampled(matrix, 1)
    psd = stress.layer_psd(response, LAYERS)[0, 0, 0]
    assert psd[-1] == pytest.approx(3 * psd[5], rel=1e-12)


def test_layers_that_differ_by_sign_alone_are_one_and_turned_plies_are_not():
    turned = np.array([[1.0, 0.2, 0.3], [0.2, 1.0, 0.3], [0.3, 0.3, 0.4]])
    other = turned * np.array([[1, 1, -1], [1, 1, -1], [-1, -1, 1]])  # the ply at −45°
    matrices = np.stack([turned, -turned, other])
    layers = stress.distinct_layers(["+45", "under", "-45"], matrices, matrices)
    assert layers.names == ("+45 and under", "-45")
