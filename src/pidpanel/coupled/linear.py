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
        Z₀ [N/m] at frequencies (k,) [Hz]: its diagonal (k, n), or (k, n, n).
    felt, observed
        (n, r) E and (s, n) Wᵀ [1].
    """

    def __init__(
        self,
        frequency: Array,
        stiffness: Callable[[Array], Complexes],
        felt: Array,
        observed: Array,
    ) -> None:
        self.frequency, self.stiffness = frequency, stiffness
        self.felt, self.observed = felt, observed

    def motion(self, load: Complexes, amplitude: Complexes) -> Complexes:
        """Return the motions Wᵀq (nf, s) [m] under given modal forces."""
        moved = [
            self._rows([load], lines)[:, 0] @ amplitude[lines, :, None]
            for lines in _chunks(len(self.frequency))
        ]
        return np.concatenate(moved)[:, :, 0]

    def psds(
        self,
        loads: Sequence[Complexes],
        excitation: Callable[[slice], Array | Complexes] | None,
        forces: Sequence[Callable[[slice], Array] | None],
    ) -> Array:
        """Return the PSDs (dampers, nf, s) [m²/Hz] of the motions Wᵀq, for several dampers."""
        psds = np.zeros((len(loads), len(self.frequency), len(self.observed)))
        for lines in _chunks(len(self.frequency)):
            rows = self._rows(loads, lines)
            if excitation is not None:
                psds[:, lines] += _quadratic(rows, excitation(lines)).swapaxes(0, 1)
            for k, force in enumerate(forces):
                if force is not None:
                    psds[k, lines] += _quadratic(rows[:, k], force(lines))
        return psds

    def _rows(self, loads: Sequence[Complexes], lines: slice) -> Complexes:
        """Return Wᵀ times the receptance of the panel with each of some dampers, (nf, k, s, n)."""
        frequency, count = self.frequency[lines], len(self.observed)
        stiffness, motions = self.stiffness(frequency), np.concatenate([self.observed, self.felt.T])
        bare: Complexes
        if stiffness.ndim == 2:
            bare = motions / stiffness[:, None]
        else:  # Z₀ is symmetric
            bare = np.linalg.solve(stiffness, motions.T[None]).swapaxes(1, 2)
        receptance, unit = bare @ self.felt, np.eye(self.felt.shape[1])
        rows = []
        for load in loads:
            force = 2j * np.pi * frequency[:, None, None] * load[lines, None]
            closed = unit + receptance[:, count:] * force  # I + R iωL
            felt = np.linalg.solve(closed, bare[:, count:])
            rows.append(bare[:, :count] - (receptance[:, :count] * force) @ felt)
        return np.stack(rows, axis=1)


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
