"""A panel on moving supports, ready for the solver."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.cases import ResponseScenario, heaviest_dampers, resolving
from pidpanel.response.dampers import DampingModels
from pidpanel.response.panel import ResponsePanel, Settings, ShiftOfWave
from pidpanel.solve.supports import BaseExcitation, SupportedPanel, with_translation
from pidpanel.spectra.break_points import BreakPoints


@dataclass(frozen=True)
class Shaker:
    """A random motion of the supports of a panel in vacuum."""

    settings: Settings  # of the panel; its frequencies are those of the spectrum
    spectrum: BreakPoints  # [g²/Hz]
    mass_per_area: float  # of the panel, without dampers [kg/m²]
    shift_of_wave: ShiftOfWave  # as of `ResponsePanel`
    change_near_supports: Array | float  # likewise

    def panel(self, supported: SupportedPanel) -> ResponsePanel:
        """Return a panel under the motion."""
        inertia = supported.inertia
        level = replace(self.spectrum, psd=STANDARD_GRAVITY**2 * self.spectrum.psd)
        low, high = self.spectrum.frequency[[0, -1]].tolist()
        return ResponsePanel(
            replace(self.settings, frequency_range=(low, high)),
            with_translation(supported.basis, inertia),
            BaseExcitation.of_inertia(level, inertia),
            mass_per_area=self.mass_per_area,
            shift_of_wave=self.shift_of_wave,
            change_near_supports=self.change_near_supports,
        )

    def panel_with(
        self,
        supported: SupportedPanel,
        scenarios: Sequence[ResponseScenario],
        models: DampingModels,
    ) -> ResponsePanel:
        """Return the panel with lines for the resonances that the dampers of scenarios make."""
        panel = self.panel(supported)
        return resolving(panel, heaviest_dampers(panel, scenarios, models))
