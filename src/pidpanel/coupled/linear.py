"""The panel with linear dampers over frequency.

With the motions u = Eᵀq that the dampers feel, and the force iωL u that they exert on them,

    q = Z₀⁻¹ (f − E iωL u),   u = (I + R iωL)⁻¹ Eᵀ Z₀⁻¹ f,   R = Eᵀ Z₀⁻¹ E.

At the simulated cells E has their shapes as columns and L = diag(a_c Z_c); of whole patches
D_p = E_p E_pᵀ and L = diag(Z_p). An own force n of the particles acts on the
modes as −Σ φ n a.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pidpanel.arrays import Array, Complexes

LINES_AT_ONCE = 64  # frequency lines solved together


class Receptances:
    """Receptances of the bare panel between dampers and motions Wᵀq of interest.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    stiffness
        (nf, n) diagonal of Z₀ [N/m].
    felt, observed
        (n, r) E and (s, n) Wᵀ [1].
    """

    def __init__(
        self, frequency: Array, stiffness: Complexes, felt: Array, observed: Array
    ) -> None:
        self.frequency, self.felt, self.observed = frequency, felt, observed
        inverse = self.inverse = 1 / stiffness
        motions = np.concatenate([observed, felt.T])
        products = np.empty((len(frequency), len(motions), felt.shape[1]), complex)
        for lines in _chunks(len(frequency)):
            products[lines] = (motions * inverse[lines, None, :]) @ felt
        # (nf, s, r) Wᵀ Z₀⁻¹ E and (nf, r, r) R [m/N]
        self.across, self.coupling = products[:, : len(observed)], products[:, len(observed) :]

    def motion(self, load: Complexes, amplitude: Complexes) -> Complexes:
        """Return the motions Wᵀq (nf, s) [m] under given modal forces."""
        free = amplitude * self.inverse
        felt = np.linalg.solve(self._closed(load), (free @ self.felt)[:, :, None])
        force = self._force(load)[:, :, None] * felt
        return free @ self.observed.T - (self.across @ force)[:, :, 0]

    def psds(
        self,
        loads: Sequence[Complexes],
        excitation: Callable[[slice], Array | Complexes] | None,
        forces: Sequence[Callable[[slice], Array] | None],
    ) -> Array:
        """Return the PSDs (dampers, nf, s) [m²/Hz] of the motions Wᵀq, for several dampers."""
        psds = np.zeros((len(loads), len(self.frequency), len(self.observed)))
        for lines in _chunks(len(self.frequency)):
            rows = np.stack([self._rows(load[lines], lines) for load in loads], axis=1)
            if excitation is not None:
                psds[:, lines] += _quadratic(rows, excitation(lines)).swapaxes(0, 1)
            for k, force in enumerate(forces):
                if force is not None:
                    psds[k, lines] += _quadratic(rows[:, k], force(lines))
        return psds

    def _rows(self, load: Complexes, lines: slice) -> Complexes:
        """Return Wᵀ times the receptance of the panel with dampers, (k, s, n) [m/N]."""
        inverse = self.inverse[lines, None]
        reaction = (self.across[lines] * self._force(load, lines)[:, None]).swapaxes(1, 2)
        closed = self._closed(load, lines).swapaxes(1, 2)
        felt = np.linalg.solve(closed, reaction).swapaxes(1, 2)
        return (self.observed - felt @ self.felt.T) * inverse

    def _force(self, load: Complexes, lines: slice = slice(None)) -> Complexes:
        return 2j * np.pi * self.frequency[lines, None] * load

    def _closed(self, load: Complexes, lines: slice = slice(None)) -> Complexes:
        """Return I + R iωL."""
        unit = np.eye(self.felt.shape[1], dtype=np.complex128)
        return unit + self.coupling[lines] * self._force(load, lines)[:, None]


def _quadratic(rows: Complexes, matrix: Array | Complexes) -> Array:
    """Return row S rowᴴ, (k, …), of rows (k, …, n) and Hermitian S (k, n, n)."""
    flat = rows.reshape(len(rows), -1, rows.shape[-1])
    if np.isrealobj(matrix):  # the imaginary parts of row S rowᴴ cancel
        parts = np.concatenate([flat.real, flat.imag], axis=1)
        squares = ((parts @ matrix) * parts).sum(axis=2)
        half = flat.shape[1]
        total = squares[:, :half] + squares[:, half:]
    else:
        total = ((flat @ matrix) * flat.conj()).sum(axis=2).real
    return total.reshape(rows.shape[:-1])


def _chunks(count: int) -> Iterator[slice]:
    return (slice(start, start + LINES_AT_ONCE) for start in range(0, count, LINES_AT_ONCE))
