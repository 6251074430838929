"""A panel on moving supports, ready for the solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.panel.basis import PanelBasis
from pidpanel.response.cases import ResponseScenario, heaviest_dampers, plan_cases, resolving
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import ResponsePanel, Settings
from pidpanel.solve.basis_error import MovedFace
from pidpanel.solve.moved import Matrices
from pidpanel.solve.supports import BaseExcitation, SupportedPanel, with_translation
from pidpanel.sound.radiation import Air
from pidpanel.spectra.break_points import BreakPoints


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
