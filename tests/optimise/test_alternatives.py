"""The mass of a layout on the panel itself."""

import numpy as np
import pytest

from pidpanel.optimise.variants import damped_by_layer, thicker_faces
from pidpanel.solve.model import ModalBasis

MODES = ModalBasis([50.0, 80.0], [1.0, 1.5], 0.01)


def stiffness(modal):
    return modal.modal_mass * (2 * np.pi * modal.natural_frequency) ** 2


def test_thicker_faces_raise_mass_and_stiffness_by_their_shares():
    faces = thicker_faces(MODES, 0.08)
    assert faces.modal_mass == pytest.approx(1.08 * MODES.modal_mass)
    assert stiffness(faces) == pytest.approx(1.16 * stiffness(MODES))  # half of it are faces
    assert np.all(faces.damping_ratio == MODES.damping_ratio)


def test_a_layer_adds_half_its_loss_factor_to_the_damping_ratio_and_no_stiffness():
    layer = damped_by_layer(MODES, 0.08, 0.02)
    assert layer.damping_ratio == pytest.approx(0.02)
    assert stiffness(layer) == pytest.approx(stiffness(MODES))
    assert layer.modal_mass == pytest.approx(1.08 * MODES.modal_mass)
