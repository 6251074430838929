"""The panel without dampers, in modal coordinates, seen from its patches and points.

For each frequency, with one-sided PSDs per Hz throughout,

    Z(ω) = K − ω² (M + M_air + Σ_p m_a,p D_p) + iω (C + R + Σ_p C_e,p D_p),      H = Z⁻¹,
    S_q  = H (S_p G) Hᴴ,      S_a = ω⁴ φ S_q φᵀ   (paper, Eq. 25 with H_j* for H_i*),

where M = diag(m_i), K = diag(m_i ω_i²), C = diag(2 ζ_i m_i ω_i), D_p = ∫_p φ φᵀ dA is the overlap
of the shapes on patch p, C_e,p(ω) and m_a,p(ω) its equivalent damping and apparent mass per area,
G the modal force of the excitation, R and M_air an optional radiation resistance and added mass.

Patches are known to the panel only by a few numbers: D_p = E Δ_p Eᵀ with about 35 columns E of all
of them for each patch of 0.2 m. So the bare panel is solved once for the motions w = Wᵀq of the
patches (columns E) and of the points (columns φᵀ),

    R_wu = Wᵀ Z₀⁻¹ E,      S_wu = Wᵀ Z₀⁻¹ (S_p G) Z₀⁻ᴴ E,

and any dampers are then attached exactly (`dampers`). Patches whose columns are nearly as many as
the shapes are better solved directly (`direct`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle, pairwise

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.bare_motions import (
    InAir,
    InVacuum,
    MatrixInput,
    MovedPanel,
    ShapesInVacuum,
    matrices_at,
)
from pidpanel.solve.excitation import Matrices
from pidpanel.solve.model import ModalBasis, PatchCoordinates, Patches, ResponseError, checked_array

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

    Of the motions w = Wᵀq the first r are those of the patches (u = Eᵀ q, mean square over a
    patch = uᵀ Δ_p u/A_p), then come m motions at each point.
    """

    frequency: Array  # (nf,) [Hz]
    patches: Patches
    coordinates: PatchCoordinates  # E and Δ
    receptance: Complexes  # (nf, nw, r) R_wu = Wᵀ Z₀⁻¹ E
    patch_psd: Complexes  # (nf, nw, r) S_wu = Wᵀ Z₀⁻¹ (S_p G) Z₀⁻ᴴ E
    point_psd: Complexes  # (nf, n_points, m, m) the same among the motions of one point


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
    of_shapes = motion_at_points is None
    points = np.eye(n)[None] if motion_at_points is None else checked_motions(motion_at_points, n)
    for patches in carriers:
        if patches.shapes != n:
            shape = (patches.count, patches.shapes, patches.shapes)
            raise ResponseError(f"overlap has shape {shape}: (n_patches, {n}, {n}) is needed")

    n_points, m = points.shape[:2]
    coordinates = [patches.coordinates(overlap_cutoff) for patches in carriers]
    columns = [part.columns for part in coordinates]
    ends = np.cumsum([n_points * m] + [part.shape[1] for part in columns]).tolist()
    observed = np.concatenate([points.reshape(-1, n).T, *columns], axis=1)

    count = frequency.size
    receptance, patch_psd = (
        [np.empty((count, n_points * m + u.shape[1], u.shape[1]), complex) for u in columns]
        for _ in range(2)
    )
    point_psd = np.empty((count, n_points, m, m), complex)
    at_points = slice(0, n_points * m)
    for lines in chunks_of_lines(count, n):
        moved = moved_panel(frequency, lines, basis, observed, air_stiffness, of_shapes)
        psd = moved.psd(modal_force, frequency, lines)
        level = spectrum[lines, None, None]
        for point in range(n_points):
            motions = slice(point * m, (point + 1) * m)
            point_psd[lines, point] = level * psd(motions, motions)
        for index, (start, stop) in enumerate(pairwise(ends)):
            patch, width = slice(start, stop), stop - start
            patch_psd[index][lines, :width] = level * psd(patch, patch)
            patch_psd[index][lines, width:] = level * psd(at_points, patch)
            receptance[index][lines] = moved.receptance(np.r_[patch, at_points], patch)
    patch_parts = zip(carriers, coordinates, receptance, patch_psd, strict=True)
    return [BarePanel(frequency, *values, point_psd) for values in patch_parts]


def moved_panel(
    frequency: Array,
    lines: slice,
    basis: ModalBasis,
    observed: Array,
    air_stiffness: MatrixInput | None,
    of_shapes: bool = False,
) -> MovedPanel:
    """Return the panel on some lines, with motions W, the first of which may be the shapes."""
    if air_stiffness is None:
        form = ShapesInVacuum if of_shapes else InVacuum
        return form(basis.dynamic_stiffness(frequency[lines]), observed)
    air = matrices_at(air_stiffness, frequency, lines, len(observed))
    stiffness = dense_stiffness(frequency[lines], basis, air)
    return InAir(np.linalg.solve(stiffness, observed[None]), observed)


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
