"""The panel without dampers, in modal coordinates, seen from its patches and points.

For each frequency, with one-sided PSDs per Hz throughout,

    Z(ω) = K − ω² (M + M_air + Σ_p m_a,p D_p) + iω (C + R + Σ_p C_e,p D_p),      H = Z⁻¹,
    S_q  = H (S_p G) Hᴴ,      S_a = ω⁴ φ S_q φᵀ   (paper, Eq. 25 with H_j* for H_i*),

where M = diag(m_i), K = diag(m_i ω_i²), C = diag(2 ζ_i m_i ω_i), D_p = ∫_p φ φᵀ dA is the overlap
of the shapes on patch p, C_e,p(ω) and m_a,p(ω) its equivalent damping and apparent mass per area,
G the modal force of the excitation, R and M_air an optional radiation resistance and added mass.

Patches are known to the panel only by a few numbers: D_p = E Δ_p Eᵀ with about 35 columns E of all
of them for each patch of 0.2 m. So the bare panel is solved once for the motions of the patches
(columns E) and of the points (columns φᵀ), R_wu = Wᵀ Z₀⁻¹ E and S_wu = Wᵀ Z₀⁻¹ (S_p G) Z₀⁻ᴴ E,
and any dampers are then attached exactly (`receptances`).

Twenty patches together have as many columns as there are shapes. Then nothing is gained by the
solution in air, and dampers and air pull together at the shapes themselves (`panel_in_shapes`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.excitation import (
    Excitation,
    Matrices,
    MatrixInput,
    air_at,
    matrices_at,
    mixed_product,
)
from pidpanel.solve.model import ModalBasis, PatchCoordinates, Patches, ResponseError, checked_array
from pidpanel.solve.moved_panel import MovedPanel, coupled_shapes
from pidpanel.solve.receptances import Receptances, weighted_sum

# Eigenvalues of D below this share of the largest are dropped, see `bare_panels`.
OVERLAP_CUTOFF = 1e-8

# Frequency lines solved together, so that memory does not grow with the number of lines.
LINES_AT_ONCE = 32

# Size of one real matrix of all shapes on the lines solved together [bytes].
#
# Three times as much is not faster.
CHUNK_BYTES = 20e6

LEAST_LINES = 8  # lines solved together at least: a table of G is read whole for them


@dataclass(frozen=True)
class BarePanel:
    """Motions of the panel without dampers at some patches and points, ready to carry dampers.

    Dampers feel u = Eᵀ q, whose mean square over a patch is uᵀ Δ_p u/A_p; m motions are observed at
    each point.
    """

    frequency: Array  # (nf,) [Hz]
    coordinates: PatchCoordinates  # E and Δ
    receptances: Receptances
    point_psd: Complexes  # (nf, n_points, m, m) S_ww among the motions of one point
    # (nf, r, r) −ω²M_air + iωR where the air pulls at u together with the dampers [N/m]
    air: Matrices | None = None

    def on_lines(self, lines: slice) -> BarePanel:
        """Return the same on some lines."""
        air = None if self.air is None else self.air[lines]
        parts = self.receptances.on_lines(lines), self.point_psd[lines], air
        return BarePanel(self.frequency[lines], self.coordinates, *parts)

    def pull(self, stiffness: Complexes) -> Complexes:
        """Return S of dampers s (n_patches, nf) [N/m³]."""
        pull = weighted_sum(stiffness, self.coordinates.weight)
        return pull if self.air is None else pull + self.air


def bare_panels(
    frequency: ArrayLike,
    basis: ModalBasis,
    carriers: Sequence[Patches],
    motion_at_points: ArrayLike | None,
    spectrum: ArrayLike,
    modal_force: MatrixInput,
    air_stiffness: MatrixInput | None = None,
    overlap_cutoff: float = OVERLAP_CUTOFF,
) -> list[BarePanel]:
    """Solve the panel without dampers, once for every set of patches that may carry some.

    Parameters
    ----------
    frequency
        (nf,) rising [Hz], positive.
    basis
        Modes and residual vectors of the bare panel.
    carriers
        Sets of patches; each makes one `BarePanel`. The panel is solved once for all.
    motion_at_points
        (n_points, m, n) m motions at each point as rows over the shapes, the deflection φ [1]
        first, then such as curvatures [1/m]; or (n_points, n), φ alone; or None for the shapes
        themselves, as one point of n motions.
    spectrum
        (nf,) one-sided S of the excitation per Hz; [Pa²/Hz] under sound.
    modal_force
        G: (n, n), (nf, n, n) or a function of frequencies, such as an `Excitation`; symmetric or
        Hermitian.
    air_stiffness
        −ω²M_air + iωR of the air [N/m] in the same forms, symmetric, or None for a panel in
        vacuum.
    overlap_cutoff
        Share of the largest eigenvalue of D below which eigenvalues are dropped. On 124 shapes of
        the paper's panel with C_e = 3000 √(f/100 Hz) N s/m³ and m_a = 5 kg/m² on PID-1:
        1e-8 keeps 45 and errs by 2e-8 in the PSD of any line (7e-8 with ten times the damper);
        1e-4 keeps 29, 5e-4, and is enough for the search of a Γ.

    Raises
    ------
    ResponseError
        If shapes disagree, frequencies are not positive or do not rise, or a value is not finite.
    """
    frequency = checked_frequency(frequency)
    spectrum = checked_array("spectrum", spectrum, frequency.shape)
    if np.any(spectrum < 0):
        raise ResponseError(f"spectrum = {spectrum.min():g} must not be negative")
    n = basis.natural_frequency.size
    points = None if motion_at_points is None else checked_motions(motion_at_points, n)
    n_points, m = (1, n) if points is None else points.shape[:2]
    for patches in carriers:
        if patches.shapes != n:
            shape = (patches.count, patches.shapes, patches.shapes)
            raise ResponseError(f"overlap has shape {shape}: (n_patches, {n}, {n}) is needed")
    coordinates = [patches.coordinates(overlap_cutoff) for patches in carriers]
    at_points = None if points is None else points.reshape(-1, n).T
    sets = [at_points, *(part.columns for part in coordinates)]
    point_psd = np.empty((frequency.size, n_points, m, m), complex)
    parts: list[list[list[Complexes]]] = [[] for _ in carriers]
    for lines in chunks_of_lines(frequency.size, n):
        air = coupled_shapes(air_stiffness, frequency[lines], basis)
        moved = MovedPanel(frequency[lines], basis, air, sets)
        level = spectrum[lines, None, None]
        factors = (
            modal_force.factors(frequency[lines]) if isinstance(modal_force, Excitation) else None
        )
        force = matrices_at(modal_force, frequency, lines, n) if factors is None else factors
        (among,) = moved.psds(0, [0], force, is_factor=factors is not None)
        point_psd[lines] = level[..., None] * _by_point(among, n_points, m)
        for patch, values in enumerate(parts, 1):
            psds = moved.psds(patch, [patch, 0], force, is_factor=factors is not None)
            values.append([*moved.receptances(patch, [patch, 0]), *(level * psd for psd in psds)])
    receptances = (
        Receptances(*(_joined(part) for part in zip(*values, strict=True))) for values in parts
    )
    carried = zip(coordinates, receptances, strict=True)
    return [BarePanel(frequency, *values, point_psd) for values in carried]


def panel_in_shapes(
    frequency: Array,
    basis: ModalBasis,
    weight: Array,
    motion_at_points: Array,
    spectrum: Array,
    modal_force: MatrixInput,
    air_stiffness: MatrixInput | None = None,
) -> BarePanel:
    """Return the panel whose dampers feel all shapes: a dense solve a line with them.

    The paper keeps only the diagonal of D, so that its modes stay uncoupled, and takes C_e(ω)
    through a Laplace transform as a constant (Eq. 9-15); here C_e is that of each line,

        H_i = 1/(m_i (ω_i² − ω² + 2iζ_i ω_i ω) + (iω C_e − ω² m_a) D_ii),

    though a patch couples all modes: with a strong patch the full matrix differs by several dB
    above 1 kHz. The modal forces stay correlated. C_e is evaluated at the motion of the full form.

    Parameters
    ----------
    weight
        D (n_patches, n, n) of the patches, or its diagonal (n_patches, n).
    frequency, basis, motion_at_points, spectrum, modal_force, air_stiffness
        Same as in `bare_panels`.
    """
    n_points, m, n = motion_at_points.shape
    rows, lines = motion_at_points.reshape(-1, n), slice(None)
    transfer = 1 / basis.dynamic_stiffness(frequency)
    force = matrices_at(modal_force, frequency, lines, n)
    force = spectrum[:, None, None] * force
    felt_psd = transfer[:, :, None] * force * transfer[:, None].conj()
    across_psd = mixed_product(rows, felt_psd)
    among = mixed_product(across_psd, rows.T)
    air = air_at(air_stiffness, frequency, lines, n)
    return BarePanel(
        frequency,
        shape_coordinates(weight),
        Receptances(
            transfer,
            rows * transfer[:, None],
            felt_psd,
            across_psd,
            force if np.isrealobj(force) else None,
        ),
        _by_point(among, n_points, m),
        None if air is None else np.asarray(np.broadcast_to(air, felt_psd.shape), complex),
    )


def _joined(chunks: Sequence[Complexes]) -> Complexes:
    """Return values on all lines, without a copy of a single chunk."""
    return chunks[0] if len(chunks) == 1 else np.concatenate(chunks)


def shape_coordinates(weight: Array) -> PatchCoordinates:
    """Return the shapes as coordinates of patches, from D or its diagonal."""
    unit = np.eye(weight.shape[1])
    return PatchCoordinates(unit, weight, unit)


def _by_point(psd: Complexes, n_points: int, m: int) -> Complexes:
    """Return (nf, n_points, m, m) of the motions of each point from those of all."""
    blocks = psd.reshape(len(psd), n_points, m, n_points, m)
    return np.moveaxis(np.diagonal(blocks, axis1=1, axis2=3), -1, 1)


def patch_motions_in_vacuum(
    frequency: Array, basis: ModalBasis, patches: Patches, spectrum: Array, modal_force: MatrixInput
) -> Array:
    """Return the mean PSD of the deflection over each patch of the bare panel.

    Parameters are those of `bare_panels`.
    """
    n, count = patches.shapes, patches.count
    overlap = [U @ U.T for U in patches.factors(OVERLAP_CUTOFF)]
    weight = np.array(overlap).reshape(count, n * n) / patches.area[:, None]
    mean = np.empty((frequency.size, count))
    for lines in chunks_of_lines(frequency.size, n):
        transfer = 1 / basis.dynamic_stiffness(frequency[lines])
        force = matrices_at(modal_force, frequency, lines, n)
        for line, H, G in zip(range(lines.start, lines.stop), transfer, cycle(force)):
            # tr(D H G Hᴴ), of the real part alone since D is real and symmetric
            parts = H.view(np.float64).reshape(n, 2)  # Re H Hᴴ is their product
            psd = (np.outer(H, H.conj()) * G).real if np.iscomplexobj(G) else parts @ parts.T * G
            mean[line] = spectrum[line] * (weight @ psd.ravel())
    return mean


def dense_stiffness(frequency: Array, basis: ModalBasis, air: Matrices | None) -> Complexes:
    """Return Z₀ (nf, n, n) of the bare panel."""
    diagonal = basis.dynamic_stiffness(frequency)
    stiffness = np.zeros((*diagonal.shape, diagonal.shape[1]), dtype=np.complex128)
    index = np.arange(diagonal.shape[1])
    stiffness[:, index, index] = diagonal
    if air is not None:
        stiffness += air
    return stiffness


def chunks_of_lines(count: int, shapes: int = 0) -> list[slice]:
    """Return slices that cover ``count`` lines, each of lines to be solved together."""
    fitting = int(CHUNK_BYTES / (8 * max(shapes, 1) ** 2))
    size = max(LEAST_LINES, min(LINES_AT_ONCE, fitting))
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def checked_frequency(frequency: ArrayLike) -> Array:
    """Return (nf,) frequencies [Hz]; `ResponseError` unless finite, positive and rising."""
    array = np.asarray(frequency, dtype=np.float64)
    if array.ndim != 1 or array.size == 0:
        raise ResponseError(f"frequency has shape {array.shape}: (nf,) with nf > 0 is needed")
    if not (np.all(np.isfinite(array)) and array[0] > 0 and np.all(np.diff(array) > 0)):
        raise ResponseError("frequency must be finite, positive and rising")
    return array


def checked_motions(motion_at_points: ArrayLike, n: int) -> Array:
    """Return (n_points, m, n), of (n_points, n) with m = 1."""
    motion = np.asarray(motion_at_points, dtype=np.float64)
    if motion.ndim not in (2, 3) or motion.shape[-1] != n:
        raise ResponseError(
            f"motion_at_points has shape {motion.shape}: (n_points, {n}) or (n_points, m, {n}) "
            "is needed"
        )
    if not np.all(np.isfinite(motion)):
        raise ResponseError("motion_at_points has values that are not finite")
    return motion[:, None] if motion.ndim == 2 else motion
