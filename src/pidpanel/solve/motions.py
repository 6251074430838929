"""Mean motion of every loaded patch as a function of all dampers, on the lines of the search.

With the dampers on, R = (R_uu⁻¹ + S)⁻¹ and S_uu are the receptance and the PSDs of the motions u
that the patches feel (`receptances`). The mean over patch q of S_a and how it follows the damper on
patch p, δS_a,q = −2 Re(δs_p T_qp), are

    S_a,q = (ω⁴/A_q) tr(Δ_q S_uu),      T_qp = (ω⁴/A_q) tr(Δ_q R Δ_p S_uu).

With R_uu = V Λ V⁻¹ a damper on the only patch acts on each column of V alone, u = V d V⁻¹ u₀ with
d = 1/(1 + sλ), so that any number of dampers costs one decomposition a line:

    S_a = (ω⁴/A) Σ_jk d_j Q_jk d_k*,      Q_jk = (V⁻¹ S_uu V⁻ᴴ)_jk (VᴴV)_kj.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.progress import map_in_forks
from pidpanel.solve.dampers import check_stable
from pidpanel.solve.excitation import Excitation, MatrixInput, matrices_at
from pidpanel.solve.lines import root_mean_square, trapezoid_weights
from pidpanel.solve.modal import BarePanel, chunks_of_lines, panel_in_shapes, shape_coordinates
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.receptances import patch_stiffness, times, traces

# In the search for Γ, shapes above this times a line's frequency are left out there. With twenty
# dampers of 8 kg/m² on 40 % of a panel of 4 kg/m², rms values of patches are within 6e-4 (3e-3 with
# shapes up to three times, 2e-4 up to eight times).
SHAPES_TO = 5.0

FEW_SHAPES_TO = 2.5  # the same where the search only draws near, on few lines

FEWEST_SHAPES = 10  # that the search takes at the lowest lines

# Lines of the search solved together in all shapes: within them the frequency rises by a third.
LINES_OF_SEARCH = 48

KEPT_BYTES = 400e6  # most memory for matrices of all shapes on the lines of a search


class Motions:
    """Mean motions of some patches with dampers on all of them.

    Parameters
    ----------
    bare
        The panel seen from the patches alone.
    area
        (n_patches,) [m²].
    """

    def __init__(self, bare: BarePanel, area: Array) -> None:
        self._bare, self.area, self.frequency = bare, area, bare.frequency
        self.coordinates = bare.coordinates

    def subsampled(self, step: int) -> Motions:
        """Return the same on every n-th line."""
        return Motions(self._bare.on_lines(slice(None, None, step)), self.area)

    def prepare(self) -> None:
        """Compute what all dampers share."""
        if self._is_single:
            _ = self._decomposed

    def acceleration_psd(self, damping: Array, mass: Array) -> Array:
        """Return the mean acceleration PSD of each patch (n_patches, nf) [(m/s²)²/Hz]."""
        check_stable(damping)
        if self._is_single:
            _, d, pushed = self._of_one_patch(damping, mass)
            return np.sum(d * pushed, axis=1).real[None]
        psd = np.empty(damping.shape)
        for lines in self._lines():
            part, pull = self._pulled(lines, damping, mass)
            moved = part.receptances.felt_psd_with(pull)
            psd[:, lines] = traces(part.coordinates.weight, moved) * self._scale(lines)
        return psd

    def acceleration_slope(self, damping: Array, mass: Array) -> Complexes:
        """Return T (n_patches, n_patches, nf): the patch that moves, that of the damper, lines.

        Parameters are those of `acceleration_psd`.
        """
        check_stable(damping)
        if self._is_single:
            eigenvalue, d, pushed = self._of_one_patch(damping, mass)
            return np.sum(eigenvalue * d**2 * pushed, axis=1)[None, None]
        slope = np.empty((len(damping), *damping.shape), dtype=np.complex128)
        for lines in self._lines():
            part, pull = self._pulled(lines, damping, mass)
            receptance, moved = part.receptances.felt_with(pull)
            for patch, weight in enumerate(part.coordinates.weight):
                pushed = receptance @ times(weight[None], moved)
                trace = traces(part.coordinates.weight, pushed)
                slope[:, patch, lines] = trace * self._scale(lines)
        return slope

    def acceleration_rms(self, damping: Array, mass: Array) -> Array:
        """Return the rms over time and patch of the acceleration (n_patches,) [m/s²].

        Parameters are those of `acceleration_psd`.
        """
        return root_mean_square(self.frequency, self.acceleration_psd(damping, mass).T)

    def bare_acceleration_rms(self) -> Array:
        """Return that rms (n_patches,) without any damper [m/s²]."""
        psd = np.empty((len(self.area), self.frequency.size))
        for lines in self._lines():
            part = self._part(lines)
            alone = part.receptances
            moved = alone.felt_psd.real if part.air is None else alone.felt_psd_with(part.air)
            psd[:, lines] = traces(part.coordinates.weight, moved) * self._scale(lines)
        return root_mean_square(self.frequency, psd.T)

    def acceleration_covariance(self, damping: Array, mass: Array) -> Array:
        """Return ∫ ω⁴ Re S_uu df (r, r) [m²/s⁴ times the square of the unit of u over w].

        Parameters are those of `acceleration_psd`.
        """
        total = np.zeros(2 * self.coordinates.columns.shape[1:])
        weight = trapezoid_weights(self.frequency) * (2 * np.pi * self.frequency) ** 4
        for lines in self._lines():
            part, pull = self._pulled(lines, damping, mass)
            moved = part.receptances.felt_psd_with(pull)
            counts = self._counts(lines)
            total[np.ix_(counts, counts)] += np.tensordot(weight[lines], moved, axes=1)
        return total

    def _lines(self) -> Sequence[slice]:
        """Return lines to be taken together."""
        return chunks_of_lines(self.frequency.size, 2 * self.coordinates.columns.shape[1])

    def _part(self, lines: slice) -> BarePanel:
        return self._bare.on_lines(lines)

    def _counts(self, lines: slice) -> Index:
        """Return which of the motions u are used on some lines."""
        return np.arange(self.coordinates.columns.shape[1])

    def _pulled(self, lines: slice, damping: Array, mass: Array) -> tuple[BarePanel, Complexes]:
        """Return the panel and S on some lines."""
        part = self._part(lines)
        s = patch_stiffness(self.frequency[lines], damping[:, lines], mass[:, lines])
        return part, part.pull(s)

    def _scale(self, lines: slice) -> Array:
        """Return (n_patches, nf) ω⁴/A."""
        return (2 * np.pi * self.frequency[lines]) ** 4 / self.area[:, None]

    @property
    def _is_single(self) -> bool:
        return self.coordinates.weight.ndim == 2

    @cached_property
    def _decomposed(self) -> tuple[Complexes, Complexes]:
        """λ (nf, r) of R_uu [m³/N] and ω⁴ Q/A (nf, r, r) [(m/s²)²/Hz] of a patch alone."""
        receptances = self._bare.receptances

        def at_lines(lines: slice) -> tuple[Complexes, Complexes]:
            eigenvalue, V = np.linalg.eig(receptances.felt[lines])
            inverse = np.linalg.inv(V)
            psd = inverse @ receptances.felt_psd[lines] @ inverse.conj().swapaxes(1, 2)
            Q = psd * (V.conj().swapaxes(1, 2) @ V).swapaxes(1, 2)
            return eigenvalue, Q * self._scale(lines)[0, :, None, None]

        chunks = chunks_of_lines(self.frequency.size, receptances.felt.shape[1])
        eigenvalues, weights = zip(*map_in_forks(at_lines, chunks), strict=True)
        return np.concatenate(eigenvalues), np.concatenate(weights)

    def _of_one_patch(self, damping: Array, mass: Array) -> tuple[Complexes, Complexes, Complexes]:
        """Return λ_j, d_j and ω⁴/A Σ_k Q_jk d_k*, (nf, r) each."""
        eigenvalue, weight = self._decomposed
        (s,) = patch_stiffness(self.frequency, damping, mass)
        d = 1 / (1 + s[:, None] * eigenvalue)
        return eigenvalue, d, (weight @ d.conj()[:, :, None])[:, :, 0]


class ShapeMotions(Motions):
    """Mean motions of patches from all shapes used on a line, see `modal.panel_in_shapes`.

    Parameters
    ----------
    excitation, air
        G and the stiffness of the air, see `modal.bare_panels`.
    kept_bytes
        Most memory for matrices that are kept; where it is not enough, they are computed again.
    shapes_to
        Highest natural frequency of the shapes used on a line, over that of the line.
    """

    def __init__(
        self,
        frequency: Array,
        basis: ModalBasis,
        patches: Patches,
        excitation: Excitation,
        air: MatrixInput | None = None,
        kept_bytes: float = KEPT_BYTES,
        shapes_to: float = SHAPES_TO,
    ) -> None:
        self.frequency, self.area = frequency, patches.area
        self.coordinates = shape_coordinates(patches.overlap)
        self._inputs = basis, patches, excitation, air
        self._kept_bytes, self._shapes_to = kept_bytes, shapes_to
        self._kept: dict[int, BarePanel] = {}

    def subsampled(self, step: int) -> Motions:
        """Return the same on every n-th line."""
        return ShapeMotions(self.frequency[::step], *self._inputs, self._kept_bytes, FEW_SHAPES_TO)

    def _lines(self) -> Sequence[slice]:
        starts = range(0, self.frequency.size, LINES_OF_SEARCH)
        return [slice(start, min(start + LINES_OF_SEARCH, self.frequency.size)) for start in starts]

    def _counts(self, lines: slice) -> Index:
        natural = self._inputs[0].natural_frequency
        fewest = np.sort(natural)[min(FEWEST_SHAPES, natural.size) - 1]
        return np.flatnonzero(natural <= max(self._shapes_to * self.frequency[lines][-1], fewest))

    def _part(self, lines: slice) -> BarePanel:
        if lines.start in self._kept:
            return self._kept[lines.start]
        basis, patches, excitation, air = self._inputs
        counts, frequency = self._counts(lines), self.frequency[lines]
        few = ModalBasis(
            basis.natural_frequency[counts], basis.modal_mass[counts], basis.damping_ratio[counts]
        )
        square = ..., counts[:, None], counts

        def of_shapes(matrix: MatrixInput) -> MatrixInput:
            return matrices_at(matrix, frequency, slice(None), patches.shapes)[square]

        part = panel_in_shapes(
            frequency, few, patches.overlap[square], np.zeros((0, 1, counts.size)),
            excitation.spectrum(frequency), of_shapes(excitation),
            None if air is None else of_shapes(air),
        )  # fmt: skip
        force = part.receptances.force
        size = part.receptances.felt_psd.nbytes + part.coordinates.weight.nbytes
        size += 0 if force is None else force.nbytes
        size += 0 if part.air is None else part.air.nbytes
        if len(self._lines()) * size <= self._kept_bytes:
            self._kept[lines.start] = part
        return part
