"""The paper's form of the panel with dampers: the modes stay uncoupled.

The paper keeps only the diagonal of D and takes C_e(ω) through a Laplace transform as a constant
(Eq. 9-15); here C_e is that of each line,

    H_i = 1/(m_i (ω_i² − ω² + 2iζ_i ω_i ω) + (iω C_e − ω² m_a) D_ii),

though a patch couples all modes: with a strong patch the full matrix differs by several dB above
1 kHz. The modal forces stay correlated. C_e is evaluated at the motion of the full form.
"""

from pidpanel.arrays import Complexes
from pidpanel.solve.direct import DirectPanel, Receptance


class DiagonalPanel(DirectPanel):
    """The panel with uncoupled modes, in vacuum; parameters are those of `DirectPanel`."""

    def _pulled(self, patch: int, motion: Complexes) -> Complexes:
        return self.patches.diagonal[patch][:, None] * motion

    def _receptance(self, lines: slice, stiffness: Complexes, *, again: bool) -> Receptance:
        added = stiffness.T @ self.patches.diagonal
        transfer = 1 / (self.basis.dynamic_stiffness(self.frequency[lines]) + added)
        return lambda force: transfer[:, :, None] * force
