"""A panel that can carry dampers on its patches, and its lines and motions."""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.panel.basis import PanelBasis
from pidpanel.solve.excitation import MatrixInput
from pidpanel.solve.modal import checked_motions
from pidpanel.solve.model import ModalBasis, Patches

# Motion of a point over the largest of its shape below which it does not move [1]: rounding is
# 1e-16 of the shape, and no panel is known to a millionth.
FIXED = 1e-6


@dataclass(frozen=True)
class PatchElements:
    """The elements of all patches; one that lies in two patches belongs to both."""

    parts: Patches
    patch: Index  # (n_elements,) index of its patch


@dataclass(frozen=True)
class ModalPanel:
    """A panel with patches and points."""

    basis: ModalBasis
    patches: Patches  # all patches that may carry dampers
    frequency: Array  # (nf,) lines of the result [Hz]
    # (n_points, m, n) m motions at each point as rows over the shapes, the deflection first; or
    # (n_points, n), the deflection alone
    points: Array
    search_frequency: Array  # fewer lines, for the search for the motion [Hz]
    # Stiffness of the air [N/m], see `modal.bare_panels`; None for a panel in vacuum
    air_stiffness: MatrixInput | None = None
    # Cells whose motion is computed in addition to the mean of the patch; None for none
    cells: PatchElements | None = None
    # Whether the dampers leave the modes uncoupled, as in the paper (`direct.DiagonalPanel`)
    is_diagonal: bool = False

    def __post_init__(self) -> None:
        points = checked_motions(np.asarray(self.points), self.patches.shapes)
        object.__setattr__(self, "points", points)


def fixed_points(basis: PanelBasis) -> Flags:
    """Return (n_points,) which points no shape moves, such as those on a support."""
    at_points = np.abs(basis.shape_at_points)
    largest = np.abs(basis.shape_at_vertices).max(axis=0)
    moves = at_points > FIXED * np.where(largest > 0, largest, 1.0)
    return np.asarray(~moves.any(axis=1))


def deflection_at_points(basis: PanelBasis) -> Array:
    """Return (n_points, n) w of the shapes, exactly none at a point that is fixed."""
    return np.where(fixed_points(basis)[:, None], 0.0, basis.shape_at_points)
