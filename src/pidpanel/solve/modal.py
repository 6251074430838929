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
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.solve.excitation import (
    AirOfShapes,
    Excitation,
    Matrices,
    MatrixInput,
    air_at,
    matrices_at,
    mixed_product,
)
from pidpanel.solve.model import ModalBasis, PatchCoordinates, Patches, ResponseError, checked_array
from pidpanel.solve.receptances import Receptances, weighted_sum

# Eigenvalues of D below this share of the largest are dropped, see `bare_panels`.
OVERLAP_CUTOFF = 1e-8

# Frequency lines solved together, so that memory does not grow with the number of lines.
LINES_AT_ONCE = 32

# Size of one real matrix of all shapes on the lines solved together [bytes].
#
# Three times as much is not faster.
CHUNK_BYTES = 20e6

# Highest natural frequency of the shapes that the air couples with each other, over that of lines
# solved together, and their least number. Those above, which it barely moves, are coupled with them
# but not with each other. On the panel of `pidpanel new`, bare and with dampers, g rms is within
# 2e-5 and rms curvature and shear within 1e-4, on that of `wing.yaml` within 7e-5 and 3e-4.
SHAPES_IN_AIR, LEAST_IN_AIR = 4.0, 40

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


class CoupledShapes(NamedTuple):
    """The shapes that the air couples on some lines, and their columns of −ω²M_air + iωR."""

    shapes: Index  # (k,)
    columns: Matrices  # (nf, n, k), or (1, n, k) where all are equal [N/m]


def coupled_shapes(
    air: MatrixInput | AirOfShapes | None, frequency: Array, basis: ModalBasis
) -> CoupledShapes | None:
    """Return the shapes that the air couples on lines solved together; None in vacuum."""
    if air is None:
        return None
    natural = basis.natural_frequency
    least = np.sort(natural)[min(LEAST_IN_AIR, natural.size) - 1]
    shapes = np.flatnonzero(natural <= max(SHAPES_IN_AIR * frequency[-1], least))
    if isinstance(air, AirOfShapes):
        return CoupledShapes(shapes, air.columns(frequency, shapes))
    matrices = matrices_at(air, frequency, slice(None), natural.size)
    return CoupledShapes(shapes, matrices[:, :, shapes])


class MovedPanel:
    """The bare panel on some lines, seen in motions Xᵀq of several sets of columns X.

    Parameters
    ----------
    air
        The shapes that the air couples; None in vacuum.
    sets
        (n, k) columns each; None for the shapes themselves.
    """

    def __init__(
        self,
        frequency: Array,
        basis: ModalBasis,
        air: CoupledShapes | None,
        sets: Sequence[Array | None],
    ) -> None:
        self._sets, self._is_wet = sets, air is not None
        self._motions: dict[int, Complexes] = {}
        # (nf, n, 1) of the panel in vacuum
        self.transfer = 1 / basis.dynamic_stiffness(frequency)[:, :, None]
        if air is None:
            return
        self._soft, count = air.shapes, air.shapes.size
        self._stiff = np.setdiff1d(np.arange(basis.natural_frequency.size), air.shapes)
        self._across = np.asarray(air.columns[:, self._stiff])
        among = np.zeros((len(frequency), count, count), complex)
        among[:, range(count), range(count)] = 1 / self.transfer[:, self._soft, 0]
        among += self._pushed(air.columns)
        unit = np.broadcast_to(np.eye(count), among.shape)
        right = [unit if part is None else self._pushed(part[None]) for part in sets]
        solved = np.linalg.solve(among, np.concatenate(right, axis=2))
        # Z₀⁻¹ X among the soft shapes, of the shapes themselves the inverse
        ends = np.cumsum([part.shape[2] for part in right])[:-1]
        self._solved = np.split(solved, ends, axis=2)

    def motion(self, part: int) -> Complexes:
        """Return Z₀⁻¹ X (nf, n, k) of a set."""
        if part not in self._motions:
            columns = self._sets[part]
            if columns is None:
                self._motions[part] = self._moved(part, np.eye(self.transfer.shape[1])[None])
            elif self._is_wet:
                self._motions[part] = self._followed(columns[None], self._solved[part])
            else:
                self._motions[part] = self.transfer * columns
        return self._motions[part]

    def receptances(self, pulled: int, observed: Sequence[int]) -> list[Complexes]:
        """Return Xᵀ Z₀⁻¹ Y (nf, n_observed, n_pulled) of sets X."""
        motion = self.motion(pulled)
        columns = (self._sets[part] for part in observed)
        return [motion if part is None else mixed_product(part.T, motion) for part in columns]

    def psds(
        self, pulled: int, observed: Sequence[int], force: Matrices, *, is_factor: bool = False
    ) -> list[Complexes]:
        """Return Xᵀ Z₀⁻¹ G Z₀⁻ᴴ Y (nf, n_observed, n_pulled) of sets X; G or its factor L."""
        if is_factor:
            right = self.under(pulled, force).conj().swapaxes(1, 2)
            return [self.under(part, force) @ right for part in observed]
        if self._sets[pulled] is None:
            pushed = self._moved(pulled, force).conj().swapaxes(1, 2)
        else:
            pushed = mixed_product(force, self.motion(pulled).conj())
        return [self.under(part, pushed) for part in observed]

    def under(self, part: int, force: Matrices) -> Complexes:
        """Return the motions Xᵀ Z₀⁻¹ F (nf, k, r) of a set under forces F (nf, n, r)."""
        columns = self._sets[part]
        if columns is None:
            return self._moved(part, force)
        if self._is_wet:
            return mixed_product(self.motion(part).swapaxes(1, 2), force)
        return mixed_product(columns.T, self.transfer * force)

    def _moved(self, shapes: int, force: Matrices) -> Complexes:
        """Return Z₀⁻¹ F (nf, n, r); ``shapes`` is the number of their set."""
        if not self._is_wet:
            return np.asarray(self.transfer * force)
        return self._followed(force, self._solved[shapes] @ self._pushed(force))

    def _pushed(self, force: Matrices) -> Complexes:
        """Return forces on the soft shapes, with those of the air that stiff ones push."""
        moved = self.transfer[:, self._stiff] * force[:, self._stiff]
        return np.asarray(force[:, self._soft] - self._across.swapaxes(1, 2) @ moved)

    def _followed(self, force: Matrices, soft: Complexes) -> Complexes:
        """Return motions with those of stiff shapes that the soft ones push through the air."""
        moved = np.empty((len(soft), self.transfer.shape[1], soft.shape[2]), complex)
        moved[:, self._soft] = soft
        pushed = force[:, self._stiff] - self._across @ soft
        moved[:, self._stiff] = self.transfer[:, self._stiff] * pushed
        return moved


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
    together = (
        Receptances(*(_joined(part) for part in zip(*values, strict=True))) for values in parts
    )
    carried = zip(coordinates, together, strict=True)
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


def receptances_in_vacuum(
    frequency: Array, basis: ModalBasis, felt: Array, observed: Array
) -> Receptances:
    """Return R of motions felt, columns (n, r), and observed, rows (nw, n), in vacuum."""
    moved = MovedPanel(frequency, basis, None, [felt, observed.T])
    return Receptances(*moved.receptances(0, [0, 1]))


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
