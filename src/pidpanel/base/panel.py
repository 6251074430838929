"""A panel on moving supports, ready for the solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.base.supports import BaseExcitation, Inertia, inertia_of, with_translation
from pidpanel.break_points import BreakPoints
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.eigen import factors
from pidpanel.panel.modes import SHIFT
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.response.cases import ResponseScenario, heaviest_dampers, plan_cases, resolving
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import ResponsePanel, Settings
from pidpanel.solve.basis_error import MovedFace, basis_shapes, refined
from pidpanel.solve.moved import Matrices
from pidpanel.sound.radiation import Air


@dataclass(frozen=True)
class SupportedPanel:
    """The panel on its supports, in a basis with the static response to their acceleration."""

    basis: PanelBasis  # without the translation
    vectors: Array  # (n_free, n) its shapes
    inertia: Inertia


@dataclass(frozen=True)
class Shaker:
    """The source of base motion; see `response.panel.ExcitationSource`. Its basis is final."""

    excitation: BaseExcitation

    def on_basis(self, basis: PanelBasis, air: Air | None) -> tuple[BaseExcitation, Air | None]:
        """Return the excitation, which holds for its own basis."""
        return self.excitation, air

    def force_at(self, frequency: float, face: MovedFace) -> Matrices:
        """Refuse: the force of base motion is one of the mass, not of a pressure on the face."""
        raise NotImplementedError("base motion has no pressure on the face")


def supported_panel(
    basis: PanelBasis, plate: StoredPlate, further_shapes: Array, highest: float, mass: float
) -> SupportedPanel:
    """Return the panel in its basis with further shapes, and with K⁻¹ M 1 beside it.

    Parameters
    ----------
    further_shapes
        (n_free, k) what the basis is known to miss.
    highest
        Highest frequency [Hz].
    mass
        Of the panel with attached masses [kg].
    """
    shift = (2 * np.pi * SHIFT * highest) ** 2  # a panel on hinges in a line has a singular K
    static = factors(plate.stiffness + shift * plate.mass).solve(plate.inertia)
    shapes = basis_shapes(basis, plate, np.column_stack([further_shapes, static]))
    wider = refined(basis, plate, shapes)
    return SupportedPanel(wider, shapes.vectors, inertia_of(wider, plate, shapes.vectors, mass))


def shaken_panel(
    settings: Settings,
    supported: SupportedPanel,
    spectrum: BreakPoints,
    scenarios: Sequence[ResponseScenario],
    models: DampingModels,
) -> ResponsePanel:
    """Return the panel under a random motion of its supports [g²/Hz], in vacuum.

    The settings count but for their frequencies, which are those of the spectrum. The lines resolve
    the resonances that the dampers of all scenarios make.
    """
    inertia = supported.inertia
    level = replace(spectrum, psd=STANDARD_GRAVITY**2 * spectrum.psd)
    excitation = BaseExcitation.of_inertia(level, inertia)
    low, high = spectrum.frequency[[0, -1]].tolist()
    settings = replace(settings, frequency_range=(low, high))
    basis = with_translation(supported.basis, inertia)
    panel = ResponsePanel(settings, basis, excitation, Shaker(excitation))
    plan = plan_cases(panel, scenarios, models, dead_weight=False)
    return resolving(panel, heaviest_dampers(panel, plan))
