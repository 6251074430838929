"""Maps of rms values against the response at single points, by hand, and over many lines."""

import numpy as np
import pytest

from pidpanel.solve import stress
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.maps import layer_maps, modal_covariances, motion_weights, rms_map
from pidpanel.solve.model import ModalBasis, PanelResponse, Patches

RNG = np.random.default_rng(9)
TURNED = RNG.normal(size=(2, 3, 3))
"""Strain per curvature of plies that no symmetry helps."""


def test_maps_of_a_layer_without_symmetry_are_means_of_squares():
    # E[(Eκ)²] and E[σ_x² + σ_y² − σ_x σ_y + 3τ²] of a small motion, by its square root
    root = 1e-3 * RNG.normal(size=(5, 5))
    curvature = RNG.normal(size=(4, 3, 5))
    layers = stress.Layers(("+30", "-30"), TURNED, 2 * TURNED[::-1])
    maps = layer_maps(root @ root.T, curvature, layers)
    for layer in range(2):
        strain = layers.strain[layer] @ curvature @ root  # (places, 3, independent sources)
        x, y, xy = np.moveaxis(layers.stress[layer] @ curvature @ root, 1, 0)
        for index, name in enumerate(("xx", "yy", "xy")):
            rms = np.sqrt((strain[:, index] ** 2).sum(axis=1))
            np.testing.assert_allclose(maps[f"strain_{name}"][layer], rms, rtol=1e-9)
        von_mises = np.sqrt((x**2 + y**2 - x * y + 3 * xy**2).sum(axis=1))
        np.testing.assert_allclose(maps["von_mises"][layer], von_mises, rtol=1e-9)
        np.testing.assert_allclose(maps["stress_xy"][layer], np.sqrt((xy**2).sum(1)), rtol=1e-9)


@pytest.mark.parametrize("rows", [3, 6])  # of a plate, and of a shell with its membrane strains
def test_psds_of_a_layer_and_core_without_symmetry_are_those_of_their_components(rows):
    root = RNG.normal(size=(3 + rows, 3 + rows))
    response = PanelResponse(np.array([1.0]), (root @ root.T)[None, None] + 0j)
    turned = RNG.normal(size=(2, 3, rows))
    layers = stress.Layers(("+30", "-30"), turned, 2 * turned[::-1])
    found = stress.layer_psd(response, layers)[0, 0]
    core = np.array([[2.0, 0.3], [-0.4, 1.0]])
    for layer in range(2):
        strain, of = layers.strain[layer] @ root[1:-2], layers.stress[layer] @ root[1:-2]
        expected = [*(strain**2).sum(axis=1), *(of**2).sum(axis=1)]
        np.testing.assert_allclose(found[layer, :6], expected, rtol=1e-10)
    shear = ((core @ root[-2:]) ** 2).sum(axis=1)
    np.testing.assert_allclose(stress.core_psd(response, core)[0, 0], shear, rtol=1e-10)


def test_thin_layers_are_told_apart_as_thick_ones_are():
    # strains per curvature of 1e-10 m differ as those of 1 m do; the scale has no part in it
    for scale in (1e-10, 1.0, 1e10):
        layers = stress.distinct_layers(["a", "b"], scale * TURNED, scale * TURNED)
        assert layers.names == ("a", "b")
        joined = stress.distinct_layers(
            ["a", "b"], *[scale * np.stack([TURNED[0], -TURNED[0]])] * 2
        )
        assert joined.names == ("a and b",)


def test_layers_of_one_strain_and_two_stresses_are_two():
    # two materials in one plane
    strain = np.stack([TURNED[0], TURNED[0]])
    assert stress.distinct_layers(["a", "b"], strain, TURNED).names == ("a", "b")


def test_layers_that_are_the_same_are_one():
    same = np.stack([TURNED[0], TURNED[0]])
    assert stress.distinct_layers(["a", "b"], same, same).names == ("a and b",)


def test_a_mean_square_over_hundreds_of_lines_is_that_of_miles():
    # S/(4 c k) of one mode with a dashpot, all lines once; range and trapezoids leave 1e-3
    frequency = frequency_grid(1.0, 1e4, 0.05, [100.0])
    assert frequency.size > 400
    flat, patch = np.ones((1, frequency.size)), Patches(np.array([[[0.1]]]), np.array([0.1]))
    ((_, displacement),) = modal_covariances(
        frequency, motion_weights(frequency), ModalBasis([100.0], [2.0], 0.05), patch, 4.0 * flat[0], np.array([[1.0]]),
        [(300 * flat, 0 * flat, 1.0)],
    )  # fmt: skip
    omega = 2 * np.pi * 100.0
    damping = 2 * 0.05 * 2.0 * omega + 30.0
    expected = np.sqrt(4.0 / (4 * damping * 2.0 * omega**2))
    assert rms_map(displacement, [[1.0]])[0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("with_air", [False, True])
def test_covariances_are_sums_of_the_psds_of_all_shapes(with_air):
    n, frequency = 12, np.array([40.0, 55.0, 71.0, 90.0])
    omega = 2 * np.pi * frequency
    basis = ModalBasis(np.linspace(20.0, 110.0, n), np.linspace(1.0, 2.0, n), 0.02)
    factors = RNG.normal(size=(3, n, n))
    G, overlap = factors[0] @ factors[0].T, (factors[1, :, :3] @ factors[1, :, :3].T)[None]
    air = (0.1 + 0.05j) * omega[:, None, None] ** 2 * (factors[2] @ factors[2].T) / n
    damping, mass = RNG.uniform(1.0, 9.0, (2, 1, frequency.size))
    pressure = RNG.uniform(1.0, 2.0, frequency.size)
    (found,) = modal_covariances(
        frequency, motion_weights(frequency), basis, Patches(overlap, np.array([0.1])), pressure, G,
        [(damping, mass, 3.0)], air if with_air else None,
    )  # fmt: skip
    psd = np.empty((frequency.size, n, n))
    for line, w in enumerate(omega):
        Z = np.diag(basis.dynamic_stiffness(frequency[line : line + 1])[0])
        Z = Z + (1j * w * damping[0, line] - w**2 * mass[0, line]) * overlap[0]
        H = np.linalg.inv(Z + air[line] * with_air)
        psd[line] = (3.0 * pressure[line] * H @ G @ H.conj().T).real
    acceleration = np.trapezoid(omega[:, None, None] ** 4 * psd, frequency, axis=0)
    np.testing.assert_allclose(found[0], acceleration, atol=1e-9 * acceleration.max())
    displacement = np.trapezoid(psd, frequency, axis=0)
    np.testing.assert_allclose(found[1], displacement, atol=1e-9 * displacement.max())
