"""Dampers that the panel feels with nearly all its shapes: one dense solve a line.

Twenty patches together have as many columns (`model.PatchCoordinates`) as there are shapes. Then
nothing is gained by the bare panel's solution, and

    H = (Z₀ + Σ_p s_p D_p)⁻¹,      S_w = cᵀ H (S_p G) Hᴴ c

is used unchanged: x = H c for the motions c at the points, since H is symmetric.

The paper keeps only the diagonal of D, so that its modes stay uncoupled, and takes C_e(ω) through a
Laplace transform as a constant (Eq. 9-15); here C_e is that of each line,

    H_i = 1/(m_i (ω_i² − ω² + 2iζ_i ω_i ω) + (iω C_e − ω² m_a) D_ii),

though a patch couples all modes: with a strong patch the full matrix differs by several dB above
1 kHz. The modal forces stay correlated. C_e is evaluated at the motion of the full form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.bare_motions import MatrixInput, air_at, matrices_at, product
from pidpanel.solve.dampers import checked_dampers, patch_stiffness, solution, weighted_sum
from pidpanel.solve.excitation import Matrices
from pidpanel.solve.modal import chunks_of_lines, dense_stiffness
from pidpanel.solve.model import ModalBasis, PanelResponse, Patches
from pidpanel.solve.motions import Motions, Reals

# In the search for Γ, shapes above this times a line's frequency are left out there. With twenty
# dampers of 8 kg/m² on 40 % of a panel of 4 kg/m², rms values of patches are within 6e-4 (3e-3 with
# shapes up to three times, 2e-4 up to eight times).
SHAPES_TO = 5.0

FEW_SHAPES_TO = 2.5  # the same where the search only draws near, on few lines

FEWEST_SHAPES = 10  # that the search takes at the lowest lines

# Lines of the search solved together: within them the frequency rises by a third.
LINES_OF_SEARCH = 48


# Modal forces (nf, n, k) [N] → motions H F (nf, n, k) [m].
Receptance = Callable[[Complexes], Complexes]


@dataclass(frozen=True)
class DirectPanel:
    """The panel with all its shapes, on some lines."""

    frequency: Array  # (nf,) [Hz]
    basis: ModalBasis
    patches: Patches
    points: Array  # (n_points, m, n) see `modal.bare_panels`
    spectrum: Array  # (nf,) S of the excitation
    # See `modal.bare_panels`
    modal_force: MatrixInput
    air_stiffness: MatrixInput | None = None

    def response(
        self, equivalent_damping: ArrayLike, apparent_mass: ArrayLike, with_slope: bool = False
    ) -> PanelResponse:
        """Return the response with dampers, with t of `dampers.attach_dampers` if requested."""
        stiffness = patch_stiffness(
            self.frequency,
            *checked_dampers(self.patches, self.frequency, equivalent_damping, apparent_mass),
        )
        n_points, m, n = self.points.shape
        cross_psd = np.empty((self.frequency.size, n_points, m, m), dtype=np.complex128)
        slope = np.empty((*stiffness.shape, n_points), complex) if with_slope else None
        columns = self.points.reshape(-1, n).T.astype(complex)
        for lines in chunks_of_lines(self.frequency.size, 2 * n):
            receptance = self._receptance(lines, stiffness[:, lines], again=with_slope)
            moved = receptance(columns[None])
            moved = moved.reshape(len(moved), n, n_points, m)
            force = matrices_at(self.modal_force, self.frequency, lines, n)
            level = self.spectrum[lines, None, None]
            for point in range(n_points):
                motion = moved[:, :, point]
                cross_psd[lines, point] = level * product(motion, force, motion)
            if slope is None:
                continue
            deflection = moved[..., 0]
            psd = level * receptance(force @ deflection.conj())
            scale = (2 * np.pi * self.frequency[lines, None]) ** 4
            for patch in range(self.patches.count):
                pulled = self._pulled(patch, psd)
                slope[patch, lines] = scale * np.sum(deflection * pulled, axis=1)
        return PanelResponse(self.frequency, cross_psd, slope)

    def _pulled(self, patch: int, motion: Complexes) -> Complexes:
        """Return D_p times motions (nf, n, k)."""
        return self.patches.overlap[patch] @ motion

    def _receptance(self, lines: slice, stiffness: Complexes, *, again: bool) -> Receptance:
        """Return H of the panel with the dampers, see `dampers.solution`."""
        air = air_at(self.air_stiffness, self.frequency, lines, self.patches.shapes)
        full = dense_stiffness(self.frequency[lines], self.basis, air)
        full += weighted_sum(stiffness, self.patches.overlap)
        return solution(full, again=again)


@dataclass(frozen=True)
class _Matrices:
    """Data of the search on some lines, for the shapes used there."""

    counts: Index  # (k,) the shapes
    basis: ModalBasis
    force: Matrices  # S_p G (nf, k, k)
    air: Matrices | None  # (nf, k, k) of the air, or None
    weight: Array  # (n_patches, k, k) D


class DirectMotions(Motions):
    """Mean motions of patches from all shapes used on a line.

    Parameters
    ----------
    kept_bytes
        Most memory for matrices that are kept; where it is not enough, they are computed again.
    shapes_to
        Highest natural frequency of the shapes used on a line, over that of the line.
    """

    def __init__(self, panel: DirectPanel, kept_bytes: float, shapes_to: float = SHAPES_TO) -> None:
        self._panel = panel
        self._shapes_to = shapes_to
        self._kept_bytes = kept_bytes
        self._kept: dict[int, _Matrices] = {}
        self.frequency = panel.frequency
        self.area = panel.patches.area
        self.weight = panel.patches.overlap

    def subsampled(self, step: int) -> DirectMotions:
        """Return the same on every n-th line."""
        panel, lines = self._panel, slice(None, None, step)
        n = panel.patches.shapes

        def on_some(matrix: MatrixInput) -> MatrixInput:
            return matrix if callable(matrix) else matrices_at(matrix, panel.frequency, lines, n)

        coarse = replace(
            panel,
            frequency=panel.frequency[lines],
            spectrum=panel.spectrum[lines],
            modal_force=on_some(panel.modal_force),
            air_stiffness=None if panel.air_stiffness is None else on_some(panel.air_stiffness),
        )
        return DirectMotions(coarse, self._kept_bytes, FEW_SHAPES_TO)

    def _lines(self) -> Sequence[slice]:
        count = self.frequency.size
        return [
            slice(start, min(start + LINES_OF_SEARCH, count))
            for start in range(0, count, LINES_OF_SEARCH)
        ]

    def _weight(self, lines: slice) -> Array:
        return self._matrices(lines).weight

    def _counts(self, lines: slice) -> Index:
        return self._matrices(lines).counts

    def _motion(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Complexes]:
        receptance, force = self._receptance(lines, stiffness)
        return receptance, product(receptance, force, receptance)

    def _moved(self, lines: slice, stiffness: Complexes) -> Reals:
        receptance, force = self._receptance(lines, stiffness)
        if np.iscomplexobj(force):
            return product(receptance, force, receptance).real
        real, imaginary = receptance.real.copy(), receptance.imag.copy()
        return real @ (np.real(force) @ real) + imaginary @ (
            np.real(force) @ imaginary
        )  # H is symmetric

    def _receptance(self, lines: slice, stiffness: Complexes) -> tuple[Complexes, Matrices]:
        """Return H and S_p G."""
        matrices = self._matrices(lines)
        full = dense_stiffness(self.frequency[lines], matrices.basis, matrices.air)
        full += weighted_sum(stiffness, matrices.weight)
        return np.linalg.inv(full), matrices.force

    def _matrices(self, lines: slice) -> _Matrices:
        if lines.start in self._kept:
            return self._kept[lines.start]
        panel, frequency = self._panel, self.frequency
        natural, n = panel.basis.natural_frequency, panel.patches.shapes
        fewest = np.sort(natural)[min(FEWEST_SHAPES, n) - 1]
        counts = np.flatnonzero(natural <= max(self._shapes_to * frequency[lines][-1], fewest))
        air = air_at(panel.air_stiffness, frequency, lines, n)
        air = None if air is None else _of_shapes(air, counts)
        masses, ratios = panel.basis.modal_mass[counts], panel.basis.damping_ratio[counts]
        basis = ModalBasis(natural[counts], masses, ratios)
        force = _of_shapes(matrices_at(panel.modal_force, frequency, lines, n), counts)
        force = panel.spectrum[lines, None, None] * force
        matrices = _Matrices(counts, basis, force, air, _of_shapes(self.weight, counts))
        size = matrices.force.nbytes + matrices.weight.nbytes + (0 if air is None else air.nbytes)
        if len(self._lines()) * size <= self._kept_bytes:
            self._kept[lines.start] = matrices
        return matrices


def _of_shapes(matrix: Any, counts: Index) -> Any:
    """Return rows and columns of some shapes of (…, n, n)."""
    return matrix[..., counts[:, None], counts]


class DiagonalPanel(DirectPanel):
    """The paper's panel with uncoupled modes, in vacuum; as `DirectPanel`."""

    def _pulled(self, patch: int, motion: Complexes) -> Complexes:
        return self.patches.diagonal[patch][:, None] * motion

    def _receptance(self, lines: slice, stiffness: Complexes, *, again: bool) -> Receptance:
        added = stiffness.T @ self.patches.diagonal
        transfer = 1 / (self.basis.dynamic_stiffness(self.frequency[lines]) + added)
        return lambda force: transfer[:, :, None] * force
