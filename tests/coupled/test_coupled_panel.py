"""A patch keeps the shapes that it feels, and adds up a force that its cells share."""

import numpy as np
import pytest

from pidpanel.coupled.coupled_panel import CoupledPatch, bare_psd
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.source import PatchParts


def middles(count, width, height):
    """Middles of count × count parts of a rectangle."""
    x = (np.arange(count) + 0.5) / count
    return np.array([(width * a, height * b) for a in x for b in x])


def patch(overlap=None, parts=1, width=0.3, height=0.3):
    """A rectangular patch in so many parts each way."""
    place = middles(parts, width, height)
    area = np.full(len(place), width * height / len(place))
    return CoupledPatch(
        shape=np.ones((1, 1)),
        area=np.array([width * height]),
        position=np.array([[width / 2, height / 2]]),
        cell_area=4e-5,
        overlap=np.eye(1) if overlap is None else overlap,
        parts=PatchParts(np.ones((len(place), 1)), area, place),
    )


@pytest.mark.parametrize("frequency", [20.0, 150.0, 1000.0])
def test_the_shared_area_is_the_double_integral_of_the_coherence(frequency):
    # by a plain sum over 30 × 30 points, each with itself as a disc of its area
    width, height, length = 0.3, 0.2, 30.0
    place = middles(30, width, height)
    apart = np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))
    point = width * height / len(place)
    np.fill_diagonal(apart, 0.5 * np.sqrt(point))
    wanted = point**2 * np.exp(-apart * frequency / length).sum()
    found = patch(parts=8, width=width, height=height).shared_area(length, np.array([frequency]))
    assert found[0] == pytest.approx(wanted, rel=0.01)


def test_the_bare_panel_answers_by_its_receptances():
    modal = ModalBasis([60.0, 90.0, 200.0], [1.0, 2.0, 1.5], [0.02, 0.03, 0.01])
    root = np.random.default_rng(2).standard_normal((3, 3))
    frequency = np.linspace(40.0, 300.0, 50)
    shape = np.array([[1.0, -0.5, 0.2], [0.3, 0.8, -1.0]])
    found = bare_psd(modal, ModalForce(lambda f: 0.1 * f, root @ root.T), shape, frequency)
    omega, own = 2 * np.pi * frequency[:, None], 2 * np.pi * np.array([60.0, 90.0, 200.0])
    ratio, mass = np.array([0.02, 0.03, 0.01]), np.array([1.0, 2.0, 1.5])
    per_force = 1 / (mass * (own**2 - omega**2 + 2j * ratio * own * omega))
    rows = (shape[None] * per_force[:, None, :]) @ root
    wanted = 0.1 * frequency[:, None] * (np.abs(rows) ** 2).sum(axis=2)
    assert found == pytest.approx(wanted, rel=1e-9)
