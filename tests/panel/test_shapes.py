"""Shapes of a plate whose matrices are diagonal: what adds to the others is known exactly."""

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp

from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.shapes import Shapes, panel_shapes, residual_vectors


def diagonal_plate(stiffness, couples=()):
    """Coordinates of unit mass on springs of their own; a patch couples pairs (i, j, size)."""
    size = len(stiffness)
    overlap = np.zeros((size, size))
    for i, j, value in couples:
        overlap[i, j] = overlap[j, i] = value
    empty = dict.fromkeys(field.name for field in dataclasses.fields(AssembledPlate))
    return AssembledPlate(
        **empty
        | {
            "stiffness": sp.csr_array(np.diag(stiffness)),
            "mass": sp.csr_array(np.eye(size)),
            "patch_overlap": {"a": sp.csr_array(overlap)} if len(couples) else {},
            "at_vertices": sp.csr_array(np.eye(size)),
            "at_quadrature": sp.csr_array((0, size)),
        }
    )


def hertz(stiffness):
    return np.sqrt(stiffness) / (2 * np.pi)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_shape_joins_that_has_more_than_1e_8_of_its_energy_beside_the_others(scale):
    # of shapes of any size; the second lies within what the first and the others span
    # red: LOADED_TOLERANCE * 2, ** 3; rest * sqrt(energy); unit added in place of taken away
    k = np.array([1.0, 2.0, 9.0, 16.0, 25.0, 36.0])
    plate, unit = diagonal_plate(k), np.eye(6)
    shapes = Shapes(hertz(k[:2]), hertz(k[2:3]), unit[:, :3])
    further = np.stack(
        [
            unit[:, 2] / 3 + 1e-3 * unit[:, 3] / 4,  # 1e-6 of its energy
            unit[:, 2] / 3 + 1e-5 * unit[:, 4] / 5,  # 1e-10
            unit[:, 0] + unit[:, 2],
        ],
        axis=1,
    )
    joined = shapes.joined_by(plate, scale * further)
    np.testing.assert_allclose(joined.frequency, hertz(k[:2]))
    np.testing.assert_allclose(joined.residual_frequency, hertz(k[2:4]), rtol=1e-6)
    np.testing.assert_allclose(joined.vectors, unit[:, :4], atol=1e-6)


def test_a_basis_of_no_tolerance_keeps_1e_13_of_the_largest_energy():
    # static answers d/k of three forces, with energies d²/k of 1, 1e-12 and 1e-14
    # red: 1e-13 * energy[1], * energy[-2]
    k = np.array([0.1, 0.2, 0.3, 1.0, 2.0, 3.0])
    force = np.sqrt(k[3:] * [1.0, 1e-12, 1e-14])
    plate = diagonal_plate(k, [(i, i + 3, value) for i, value in enumerate(force)])
    frequency, residuals = residual_vectors(plate, np.eye(6)[:, :3], 0.0)
    np.testing.assert_allclose(frequency, hertz(k[3:5]))
    np.testing.assert_allclose(residuals, np.eye(6)[:, 3:5], atol=1e-9)


def test_a_damper_below_1_kg_m2_brings_its_shapes():
    # w of two coordinates coupled by mass: the loaded modes lie between them
    # red: value > 1
    k = np.concatenate([[1.0], np.linspace(1e3, 1e4, 39)])
    plate = diagonal_plate(k, [(0, 39, 0.9)])
    found = [
        panel_shapes(plate, hertz(1600.0), 1.0, mass).residuals.shape[1]
        for mass in (None, {"a": 0.0}, {"a": 0.5})
    ]
    assert found == [0, 0, 1]
