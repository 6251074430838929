"""The mass of a layout spent on the panel itself: thicker face sheets, or a damping layer.

Either is spread over the whole panel, so that its modes keep their shapes.
"""

import numpy as np

from pidpanel.solve.model import ModalBasis

FACE_SHARE = 0.5  # share of the face sheets in the mass of a panel whose section does not state it


def thicker_faces(modal: ModalBasis, share: float) -> ModalBasis:
    """Return the modes with a share of the panel's mass added to its face sheets.

    The bending stiffness grows as the thickness of thin face sheets, by ``share / FACE_SHARE``.
    """
    mass, stiffness = 1 + share, 1 + share / FACE_SHARE
    frequency = modal.natural_frequency * np.sqrt(stiffness / mass)
    return ModalBasis(frequency, mass * modal.modal_mass, modal.damping_ratio)


def damped_by_layer(modal: ModalBasis, share: float, loss_factor: float) -> ModalBasis:
    """Return the modes with a layer that adds a share of mass and a loss factor 2 Δζ."""
    mass = 1 + share
    frequency = modal.natural_frequency / np.sqrt(mass)
    return ModalBasis(frequency, mass * modal.modal_mass, modal.damping_ratio + loss_factor / 2)
