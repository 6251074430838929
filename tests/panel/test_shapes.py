"""Shapes of a plate whose matrices are diagonal: what adds to the others is known exactly."""

import dataclasses

import numpy as np
import scipy.sparse as sp

from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.shapes import panel_shapes


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


def test_a_damper_below_1_kg_m2_brings_its_shapes():
    # w of two coordinates coupled by mass: the loaded modes lie between them
    k = np.concatenate([[1.0], np.linspace(1e3, 1e4, 39)])
    plate = diagonal_plate(k, [(0, 39, 0.9)])
    found = [
        panel_shapes(plate, hertz(1600.0), 1.0, mass).residuals.shape[1]
        for mass in (None, {"a": 0.0}, {"a": 0.5})
    ]
    assert found == [0, 0, 1]
