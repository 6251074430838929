"""The face of a panel as its sound needs it, condensed by `pidpanel.geometry.plane_waves`."""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature, condensed
from pidpanel.panel.basis import PanelBasis

# Largest wavenumber of the face over the larger of those of the sound and of the shapes.
#
# The air's mass needs what shapes have beyond their own wavenumber (`pidpanel.sound.added_mass`).
REACH = 2.0

Face = TypeVar("Face", bound=MovedFace)


def face_wavenumber(basis: PanelBasis, sound: float) -> float:
    """Return the wavenumber to which the face of a panel has to be known [rad/m].

    The modes of a plate are N = κ² A/4π up to the wavenumber κ of its bending (Weyl's law),
    whatever its stiffness.
    """
    modes, area = np.sum(~basis.is_residual), basis.quadrature_weight.sum()
    return REACH * max(sound, float(np.sqrt(4 * np.pi * modes / area)))


def with_condensed_face(moved: Face, wavenumber: float) -> Face:
    """Return a basis, or other motions of a face, condensed for waves to a wavenumber [rad/m]."""
    face = condensed(PanelQuadrature.from_face(moved), wavenumber)
    return replace(
        moved,
        quadrature_position=face.position,
        quadrature_weight=face.weight,
        shape_at_quadrature=face.shape,
        quadrature_wavenumber=wavenumber,
    )
