"""The response of a panel to its excitation and to the own force of its particles, and its changes.

All is in closed form and linear in changes of C_e, m_a and own force.
"""

from collections.abc import Sequence

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled.coupled_panel import CoupledPanel, Impedance, cell_load
from pidpanel.coupled.linear import OverFrequency, linear_psds
from pidpanel.coupled.own_force import OwnForce
from pidpanel.coupled.spectra import band_sums
from pidpanel.solve.bands import band_rms
from pidpanel.solve.source import interpolated_load

# γ of C_e ∝ v^−γ, and how far it may be off: 1 of a bed that is thrown up and caught, −1 of one
# that crosses its gap, 0.75 of acrylic at r = 0.5 from 131 to 137 dB.
EXPONENT, EXPONENT_ERROR = 0.75, 0.35

SMALL = 0.01  # change of Z, over its size, from which derivatives are taken [1]


class Variants:
    """PSDs of the displacement at the points and the cells, and their changes with the damping.

    Parameters
    ----------
    frequency, centre
        (nf,) [Hz] and (bands,) nodes of the own force [Hz].
    """

    def __init__(
        self,
        panel: CoupledPanel,
        frequency: Array,
        centre: Array,
        impedances: Sequence[Impedance],
        forces: Sequence[OwnForce],
    ) -> None:
        self.panel, self.frequency, self.centre = panel, frequency, centre
        self.impedances = impedances
        factors = [patch.factor for patch in panel.patches]
        felt = np.concatenate(factors, axis=1)
        owner = np.repeat(np.arange(len(factors)), [factor.shape[1] for factor in factors])
        z = np.array([impedance(frequency) for impedance in impedances])
        step = SMALL * np.abs(z)
        loads = [
            patch.whole_load(force, centre) * force.psd[:, None, None]
            for patch, force in zip(panel.patches, forces, strict=True)
        ]

        def forced(load: Array) -> OverFrequency:
            return lambda lines: panel.load(lines) + interpolated_load(lines, centre, load)

        total, *single = (forced(load) for load in (np.sum(loads, axis=0), *loads))
        sets: list[tuple[Complexes, OverFrequency]] = [(z, panel.load), (z, total)]
        sets += [(z, force) for force in single]
        for p in range(len(loads)):
            for unit in (1.0, 1j):
                changed = z.copy()
                changed[p] += unit * step[p]
                sets.append((changed, total))
        observed = np.concatenate([panel.points, panel.at_cells])
        sets = [(values[owner].T, force) for values, force in sets]
        psds = linear_psds(frequency, panel.modal, panel.added, felt, observed, sets)
        base, forced_psd, patches = psds[0], psds[1], len(loads)
        changed = psds[2 + patches :].reshape(patches, 2, *base.shape)
        slope = (changed - forced_psd) / step[:, None, :, None]
        self.linear_psd = base  # (nf, p + c) without own force [m²/Hz]
        # (patches, nf, p + c) of the own force of each patch [m²/Hz]
        self.own_psd = psds[2 : 2 + patches] - base
        # (patches, nf, p + c) derivatives of the whole PSD by C_e and m_a
        self.of_damping = slope[:, 0]
        self.of_mass = slope[:, 1] * (2 * np.pi * frequency)[None, :, None]

    @property
    def points(self) -> slice:
        """Columns of the points."""
        return slice(len(self.panel.points))

    @property
    def psd(self) -> Array:
        """(nf, p + c) with own force [m²/Hz]."""
        return self.linear_psd + self.own_psd.sum(axis=0)

    def at_motion(self, recorded: Array) -> Array:
        """Return factors (patches,) of C_e from the motion of the records to that of the panel.

        C_e falls as the rms velocity v of its patch rises, about as v^−`EXPONENT`, and v follows
        C_e: ln of the factor is γ m with m = ln(v_recorded/v) + Σ_q ∂ ln v/∂ ln C_e γ m_q.
        """
        panel, frequency = self.panel, self.frequency
        omega, cells = 2 * np.pi * frequency[:, None], slice(len(panel.points), None)
        share = np.zeros((len(panel.area), len(panel.patches)))  # of each cell in its patch
        for patch, part in enumerate(panel.slices):
            share[part, patch] = panel.area[part] / panel.area[part].sum()
        psd = (omega**2 * self.psd[:, cells]) @ share
        square = np.asarray(np.trapezoid(psd, frequency, axis=0))
        damping = np.array([z(frequency).real for z in self.impedances])
        slope = damping[:, :, None] * ((omega**2 * self.of_damping[:, :, cells]) @ share)
        # ∂ ln v_p/∂ ln C_q
        by_damping = np.trapezoid(slope, frequency, axis=1).T / square[:, None] / 2
        log_ratio = np.log(recorded / square) / 2
        matrix = np.eye(len(square)) + EXPONENT * by_damping
        return np.exp(EXPONENT * np.linalg.solve(matrix, log_ratio))

    def change(self, impedances: Sequence[Impedance], ratios: Sequence[Array]) -> Array:
        """Return the change of ln of the PSD, (nf, p + c)."""
        total = np.zeros_like(self.linear_psd)
        for p, impedance in enumerate(impedances):
            difference = impedance(self.frequency) - self.impedances[p](self.frequency)
            mass = difference.imag / (2 * np.pi * self.frequency)
            total += self.of_damping[p] * difference.real[:, None] + self.of_mass[p] * mass[:, None]
            ratio = np.interp(np.log(self.frequency), np.log(self.centre), ratios[p])
            total += self.own_psd[p] * (ratio - 1)[:, None]
        psd = self.psd
        return np.divide(total, psd, out=np.zeros_like(psd), where=psd > 0)

    def _acceleration(self) -> Array:
        """Return the PSD of the acceleration at the points, over (2π)⁴ (nf, p)."""
        return self.frequency[:, None] ** 4 * self.psd[:, self.points]

    def total_change(self, change: Array) -> Array:
        """Return the change of ln of the mean square of the acceleration at the points, (p,)."""
        psd = self._acceleration()
        moved = np.trapezoid(psd * change[:, self.points], self.frequency, axis=0)
        total = np.trapezoid(psd, self.frequency, axis=0)
        return np.divide(moved, total, out=np.zeros_like(total), where=total > 0)

    def band_change(self, change: Array, edge: Array) -> Array:
        """Return that of the mean square in each band, (bands, p)."""
        psd = self._acceleration()
        width = np.gradient(self.frequency)[:, None]
        moved, total = (
            band_sums(self.frequency, values * width, edge)
            for values in (psd * change[:, self.points], psd)
        )
        return np.divide(moved, total, out=np.zeros_like(total), where=total > 0)

    def band_squares(self, psd: Array, edge: Array) -> Array:
        """Return the mean squares (bands, p) of accelerations of PSDs (nf, p) [m²/Hz]."""
        squares = band_rms(self.frequency, (2 * np.pi * self.frequency[:, None]) ** 4 * psd, edge)
        return squares**2


def simulated_psd(
    panel: CoupledPanel,
    frequency: Array,
    centre: Array,
    impedances: Sequence[Impedance],
    own_sums: Sequence[Array],
    lines: Array,
) -> Array:
    """Return the PSDs (nf, p) at the points of the own force of the simulated cells."""
    load = np.zeros((len(centre), panel.points.shape[1], panel.points.shape[1]))
    for patch, sums in zip(panel.patches, own_sums, strict=True):
        weighted = patch.shape * patch.area[:, None]
        psd = sums.sum(axis=0) / lines.sum(axis=0)[:, None, None]
        load += weighted.T @ psd @ weighted
    dampers = cell_load(panel, frequency, impedances)

    def own_force(lines: Array) -> Array:
        return interpolated_load(lines, centre, load)

    cells, added, sets = panel.at_cells.T, panel.added, [(dampers, own_force)]
    (result,) = linear_psds(frequency, panel.modal, added, cells, panel.points, sets)
    return np.asarray(result)
