"""A simply supported rectangle in closed form, tilted in space, as other solvers would state it."""

from typing import NamedTuple

import numpy as np
import pytest
import scipy.linalg

WIDTH, HEIGHT, AREAL_MASS = 1.2, 0.8, 3.0  # [m], [kg/m²]
MODES = [(1, 1), (2, 1), (1, 2), (3, 1)]
COUNT = 12, 8  # elements
SIGNS = 2 * np.eye(3, 4) - 1  # (3, 4) directions of four motions, all with |φ|² of 3


class Plate(NamedTuple):
    node: np.ndarray
    position: np.ndarray  # [m]
    corners: np.ndarray  # numbers of nodes
    frequency: np.ndarray
    modal_mass: np.ndarray
    displacement: np.ndarray
    normal: np.ndarray


@pytest.fixture(scope="session")
def plate():
    """Modes sin(mπx/a) sin(nπy/b) along the normal, of mass m″ab/4."""
    x, y = np.meshgrid(*(np.linspace(0, 1, n + 1) for n in COUNT))
    turn = scipy.linalg.expm(np.cross(np.eye(3), [0.3, -0.4, 0.9]))
    flat = np.stack([WIDTH * x.ravel(), HEIGHT * y.ravel(), 0 * x.ravel()], axis=1)
    node = 5 + 3 * np.arange(x.size)[::-1]  # neither consecutive nor in order
    place = np.arange(x.size).reshape(x.shape)
    corners = np.stack([place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]], axis=-1)
    shapes = np.stack(
        [np.sin(np.pi * m * x.ravel()) * np.sin(np.pi * n * y.ravel()) for m, n in MODES]
    )
    frequency = np.array([50 * ((m / WIDTH) ** 2 + (n / HEIGHT) ** 2) for m, n in MODES])
    order = np.argsort(frequency)
    return Plate(
        node, flat @ turn.T, node[corners.reshape(-1, 4)], frequency[order],
        np.full(len(MODES), AREAL_MASS * WIDTH * HEIGHT / 4),
        np.einsum("i,mn->nim", turn[:, 2], shapes[order]),
        turn[:, 2],
    )  # fmt: skip
