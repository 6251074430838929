"""Response of a panel with damper patches, in modal coordinates.

For each frequency, with one-sided PSDs per Hz throughout,

    Z(ω) = K − ω² (M + Σ_p m_a,p D_p) + iω (C + R + Σ_p C_e,p D_p),      H = Z⁻¹,
    S_q  = H (S_p G) Hᴴ,      S_a = ω⁴ φ S_q φᵀ   (paper, Eq. 25 with H_j* for H_i*),

where M = diag(m_i), K = diag(m_i ω_i²), C = diag(2 ζ_i m_i ω_i), D_p = ∫_p φ φᵀ dA is the overlap
of the shapes on patch p, C_e,p(ω) and m_a,p(ω) its equivalent damping and apparent mass per area,
G the modal force of the sound field and R an optional radiation resistance.

The paper keeps only the diagonal of D and takes C_e(ω) through a Laplace transform as a constant
(Eq. 9-15); here the matrix is full and C_e is that of each line. `diagonal_response` is the
paper's form.

A patch is known to the panel only by a few numbers: D = U Uᵀ with about 35 columns. So the bare
panel is solved once for the motions w = Wᵀq of the patches (columns U) and of the points
(columns φᵀ),

    R_w = Wᵀ Z₀⁻¹ W,      S_w = Wᵀ Z₀⁻¹ (S_p G) Z₀⁻ᴴ W,

and any damper is then attached exactly by its force −s u on the patch motions u, with
s = iω C_e − ω² m_a (Woodbury's identity):

    u = (I + R_uu s)⁻¹ u₀,      w = w₀ − R_wu s u.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pidpanel.response.model import (
    Complexes,
    Floats,
    ModalBasis,
    Patches,
    Response,
    ResponseError,
    UnstableDamping,
    checked_array,
)

Matrices = Floats | Complexes
MatrixInput = Matrices | Callable[[Floats], Matrices]
"""(n, n) for all frequencies, (nf, n, n), or a function of frequencies that returns (nf, n, n)."""

OVERLAP_CUTOFF = 1e-8
"""Eigenvalues of D below this share of the largest are dropped, see `bare_panel`."""

LINES_AT_ONCE = 128
"""Frequency lines solved together, so that memory does not grow with the number of lines."""


@dataclass(frozen=True)
class BarePanel:
    """Motions of the panel without dampers at its patches and points, ready to carry dampers.

    The columns of w = Wᵀq are first those of the patches (u_p = U_pᵀ q, mean square over the
    patch = Σ u²/A_p), then the points.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    patches
        The patches, in order.
    patch_columns
        For each patch its columns in w.
    point_columns
        The columns of the points.
    receptance
        (nf, nw, n_patch_columns) R_wu = Wᵀ Z₀⁻¹ U.
    displacement_psd
        (nf, nw, nw) S_w = Wᵀ Z₀⁻¹ (S_p G) Z₀⁻ᴴ W.
    damping_norm
        (n_patches,) largest eigenvalue of C⁻¹ᐟ² D_p C⁻¹ᐟ² [m³/(N s)]: what a negative C_e takes
        from the panel's own damping.
    """

    frequency: Floats
    patches: Patches
    patch_columns: list[slice]
    point_columns: slice
    receptance: Complexes
    displacement_psd: Complexes
    damping_norm: Floats


def bare_panel(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    shape_at_points: ArrayLike,
    pressure_psd: ArrayLike,
    modal_force: MatrixInput,
    radiation_resistance: MatrixInput | None = None,
    overlap_cutoff: float = OVERLAP_CUTOFF,
) -> BarePanel:
    """Solve the panel without dampers for the motions of its patches and points.

    Parameters
    ----------
    frequency
        (nf,) rising [Hz], positive.
    basis
        Modes and residual vectors of the bare panel.
    patches
        Patches whose motion is wanted, with or without a damper.
    shape_at_points
        (n_points, n) φ at the points of interest [1].
    pressure_psd
        (nf,) one-sided S_p on the face [Pa²/Hz].
    modal_force
        G [m⁴]: (n, n), (nf, n, n) or a function of frequencies; symmetric or Hermitian.
    radiation_resistance
        R [N s/m], in the same forms, or None for a panel in vacuum; R = ρ₀ω²/(2πc₀) G for each
        wetted side, with G of the diffuse field (`air_resistance`).
    overlap_cutoff
        Share of the largest eigenvalue of D below which eigenvalues are dropped. On 90 shapes of
        the paper's panel with C_e = 3000 √(f/100 Hz) N s/m³ and m_a = 5 kg/m² on PID-1:
        1e-12 keeps 53 and errs by 1e-11 in the PSD of any line; 1e-8 keeps 34, 8e-8 (8e-7 with
        a hundred times the damping); 1e-4 keeps 17, 2e-4, seven times faster than 1e-12 and
        enough for the search of a level.

    Returns
    -------
    BarePanel

    Raises
    ------
    ResponseError
        Where shapes disagree, a frequency is not positive or they do not rise, or a value is not
        finite.
    """
    frequency = checked_frequency(frequency)
    pressure_psd = _checked_pressure_psd(pressure_psd, frequency)
    n = basis.natural_frequency.size
    points = _checked_points(shape_at_points, n)
    _check_patches(patches, n)

    factors = patches.factors(overlap_cutoff)
    ends = np.cumsum([0] + [factor.shape[1] for factor in factors]).tolist()
    patch_columns = [slice(start, stop) for start, stop in pairwise(ends)]
    patch_width = ends[-1]
    observed = np.concatenate([*factors, points.T], axis=1)  # W

    count, width = frequency.size, observed.shape[1]
    receptance = np.empty((count, width, patch_width), dtype=np.complex128)
    displacement_psd = np.empty((count, width, width), dtype=np.complex128)
    for lines in chunks_of_lines(count):
        resistance = None
        if radiation_resistance is not None:
            resistance = matrices_at(radiation_resistance, frequency, lines, n)
        inverse_times_observed = _solve_bare(frequency[lines], basis, observed, resistance)
        receptance[lines] = observed.T @ inverse_times_observed[:, :, :patch_width]
        displacement_psd[lines] = pressure_psd[lines, None, None] * _congruence(
            inverse_times_observed, matrices_at(modal_force, frequency, lines, n)
        )
    return BarePanel(
        frequency=frequency,
        patches=patches,
        patch_columns=patch_columns,
        point_columns=slice(patch_width, width),
        receptance=receptance,
        displacement_psd=displacement_psd,
        damping_norm=np.array(
            [np.linalg.norm(u / np.sqrt(basis.damping)[:, None], 2) ** 2 for u in factors]
        ),
    )


def attach_dampers(
    bare: BarePanel,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    allow_negative_damping: bool = False,
) -> Response:
    """Return the response of a panel whose patches carry dampers.

    Parameters
    ----------
    bare
        The panel without dampers.
    equivalent_damping
        (n_patches, nf) C_e [N s/m³]; 0 for a patch without damper.
    apparent_mass
        (n_patches, nf) m_a [kg/m²], of either sign.
    allow_negative_damping
        Accept C_e < 0 as long as the panel's own structural damping outweighs it.

    Returns
    -------
    Response

    Raises
    ------
    UnstableDamping
        Where C_e < 0 and this is not allowed, or is not outweighed: C + Σ C_e D must stay
        positive definite. The law of the paper as printed (Eq. 5-6) is such a case.
    ResponseError
        Where shapes disagree or a value is not finite.
    """
    shape = (len(bare.patch_columns), bare.frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    mass = checked_array("apparent_mass", apparent_mass, shape)
    _check_stable(damping, bare.damping_norm, allow_negative_damping)

    acceleration_psd = np.empty((shape[1], bare.point_columns.stop - bare.point_columns.start))
    patch_psd = np.empty((shape[1], shape[0]))
    omega = 2 * np.pi * bare.frequency
    for lines in chunks_of_lines(bare.frequency.size):
        motion = attached_motion(bare, damping, mass, lines)
        psd = motion @ bare.displacement_psd[lines]
        auto = np.sum((psd * motion.conj()).real, axis=2) * omega[lines, None] ** 4
        acceleration_psd[lines] = auto[:, bare.point_columns]
        for index, columns in enumerate(bare.patch_columns):
            patch_psd[lines, index] = auto[:, columns].sum(axis=1) / bare.patches.area[index]
    return Response(bare.frequency, acceleration_psd, patch_psd)


def diagonal_response(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    shape_at_points: ArrayLike,
    pressure_psd: ArrayLike,
    modal_force: MatrixInput,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    allow_negative_damping: bool = False,
) -> Response:
    """Return the response with modes uncoupled by the dampers, as the paper has it (Eq. 9-15).

    Only the diagonal of D_p enters the equations of motion,

        H_i = 1/(m_i (ω_i² − ω² + 2iζ_i ω_i ω) + (iω C_e − ω² m_a) D_ii),

    though a patch couples all modes: beside a strong patch the full matrix differs by several dB
    above 1 kHz. The modal forces stay correlated. It is here to repeat the paper, whose m_a is 0.

    Parameters, returns and errors are those of `bare_panel` and `attach_dampers`.
    """
    frequency = checked_frequency(frequency)
    pressure_psd = _checked_pressure_psd(pressure_psd, frequency)
    n = basis.natural_frequency.size
    points = _checked_points(shape_at_points, n)
    _check_patches(patches, n)
    shape = (patches.area.size, frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    mass = checked_array("apparent_mass", apparent_mass, shape)
    overlap = np.diagonal(patches.overlap, axis1=1, axis2=2)  # (n_patches, n)
    _check_stable(damping, np.max(overlap / basis.damping, axis=1), allow_negative_damping)

    omega = 2 * np.pi * frequency
    patch_stiffness = (1j * omega * damping - omega**2 * mass).T @ overlap
    transfer = 1 / (basis.dynamic_stiffness(frequency) + patch_stiffness)  # (nf, n) H_i
    acceleration_psd = np.empty((frequency.size, points.shape[0]))
    patch_psd = np.empty((frequency.size, patches.area.size))
    for lines in chunks_of_lines(frequency.size):
        force = matrices_at(modal_force, frequency, lines, n)
        modal_psd = transfer[lines, :, None] * force * transfer[lines, None, :].conj()
        scale = (omega**4 * pressure_psd)[lines, None]
        acceleration_psd[lines] = scale * np.einsum(
            "ai,fij,aj->fa", points, modal_psd.real, points, optimize=True
        )
        patch_psd[lines] = scale * np.einsum("pij,fij->fp", patches.overlap, modal_psd.real)
    return Response(frequency, acceleration_psd, patch_psd / patches.area)


def air_resistance(
    frequency: ArrayLike,
    diffuse_modal_force: ArrayLike,
    density: float,
    speed_of_sound: float,
    wetted_sides: int = 1,
) -> Floats:
    """Return the radiation resistance R = sides · ρ₀ω²/(2πc₀) G of a baffled panel.

    By reciprocity the resistance is that of the diffuse field's G, whatever field drives the panel.
    The mass of the air that moves along (−6 % on the first frequency of the paper's panel per
    side) is not in it.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    diffuse_modal_force
        (nf, n, n) G of the diffuse field [m⁴].
    density
        ρ₀ [kg/m³].
    speed_of_sound
        c₀ [m/s].
    wetted_sides
        1 or 2.

    Returns
    -------
    (nf, n, n) R [N s/m].
    """
    if wetted_sides not in (1, 2):
        raise ResponseError(f"wetted_sides = {wetted_sides!r}: allowed are 1 and 2")
    for name, value in (("density", density), ("speed_of_sound", speed_of_sound)):
        if not (np.isfinite(value) and value > 0):
            raise ResponseError(f"{name} = {value!r} must be finite and positive")
    omega = 2 * np.pi * np.asarray(frequency, dtype=np.float64)[:, None, None]
    resistance: Floats = (
        wetted_sides * density * omega**2 / (2 * np.pi * speed_of_sound)
    ) * np.asarray(diffuse_modal_force, dtype=np.float64)
    return resistance


def attached_motion(bare: BarePanel, damping: Floats, mass: Floats, lines: slice) -> Complexes:
    """Return T (n_lines, nw, nw) with w = T w₀, the motions with dampers from those without.

    u = (I + R_uu s)⁻¹ u₀ and w = w₀ − R_wu s u; the rows of u are taken from the first form, which
    does not cancel when a strong patch pins the panel.
    """
    omega = 2 * np.pi * bare.frequency[lines]
    width, patch_width = bare.receptance.shape[1:]
    stiffness = np.empty((omega.size, 1, patch_width), dtype=np.complex128)  # s, one per column
    for index, columns in enumerate(bare.patch_columns):
        patch = 1j * omega * damping[index, lines] - omega**2 * mass[index, lines]
        stiffness[:, :, columns] = patch[:, None, None]
    receptance_times_s = bare.receptance[lines] * stiffness
    pinned = np.linalg.inv(np.eye(patch_width) + receptance_times_s[:, :patch_width])
    motion = np.zeros((omega.size, width, width), dtype=np.complex128)
    motion[:, :patch_width, :patch_width] = pinned
    motion[:, patch_width:, :patch_width] = -receptance_times_s[:, patch_width:] @ pinned
    points = np.arange(patch_width, width)
    motion[:, points, points] = 1.0
    return motion


def dense_stiffness(frequency: Floats, basis: ModalBasis, resistance: Matrices | None) -> Complexes:
    """Return Z₀ (nf, n, n) of the bare panel."""
    diagonal = basis.dynamic_stiffness(frequency)
    stiffness = np.zeros((*diagonal.shape, diagonal.shape[1]), dtype=np.complex128)
    index = np.arange(diagonal.shape[1])
    stiffness[:, index, index] = diagonal
    if resistance is not None:
        stiffness += 2j * np.pi * frequency[:, None, None] * resistance
    return stiffness


def _solve_bare(
    frequency: Floats, basis: ModalBasis, observed: Floats, resistance: Matrices | None
) -> Complexes:
    """Return Z₀⁻¹ W, (nf, n, nw); Z₀ is diagonal in vacuum."""
    if resistance is None:
        in_vacuum: Complexes = observed / basis.dynamic_stiffness(frequency)[:, :, None]
        return in_vacuum
    stiffness = dense_stiffness(frequency, basis, resistance)
    right = np.broadcast_to(observed, (frequency.size, *observed.shape))
    return np.linalg.solve(stiffness, right)


def _congruence(x: Complexes, force: Matrices) -> Complexes:
    """Return xᵀ G x*, (nf, nw, nw)."""
    if np.iscomplexobj(force):
        right = force @ x.conj()
    else:  # two real products cost half of one complex product
        width = x.shape[2]
        parts = force @ np.concatenate([x.real, x.imag], axis=2)
        right = parts[:, :, :width] - 1j * parts[:, :, width:]
    product: Complexes = x.swapaxes(1, 2) @ right
    return product


def matrices_at(matrix: MatrixInput, frequency: Floats, lines: slice, n: int) -> Matrices:
    """Return the matrices of some lines, (n_lines, n, n), or (1, n, n) where all are equal."""
    if callable(matrix):
        values: NDArray[Any] = matrix(frequency[lines])
    else:
        given: NDArray[Any] = np.asarray(matrix)
        values = given[None] if given.ndim == 2 else given
        if values.shape[0] == frequency.size:
            values = values[lines]
    if values.shape not in [(1, n, n), (frequency[lines].size, n, n)]:
        raise ResponseError(
            f"a modal matrix for {frequency.size} lines has shape {values.shape}: "
            f"({n}, {n}) or one such matrix a line is needed"
        )
    if not np.all(np.isfinite(values)):
        raise ResponseError("a modal matrix has values that are not finite")
    return values


def chunks_of_lines(count: int) -> list[slice]:
    return [
        slice(start, min(start + LINES_AT_ONCE, count)) for start in range(0, count, LINES_AT_ONCE)
    ]


def checked_frequency(frequency: ArrayLike) -> Floats:
    array = np.asarray(frequency, dtype=np.float64)
    if array.ndim != 1 or array.size == 0:
        raise ResponseError(f"frequency has shape {array.shape}: (nf,) with nf > 0 is needed")
    if not (np.all(np.isfinite(array)) and array[0] > 0 and np.all(np.diff(array) > 0)):
        raise ResponseError("frequency must be finite, positive and rising")
    return array


def _checked_pressure_psd(pressure_psd: ArrayLike, frequency: Floats) -> Floats:
    array = checked_array("pressure_psd", pressure_psd, frequency.shape)
    if np.any(array < 0):
        raise ResponseError(f"pressure_psd = {array.min():g} Pa²/Hz must not be negative")
    return array


def _checked_points(shape_at_points: ArrayLike, n: int) -> Floats:
    points = np.asarray(shape_at_points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != n:
        raise ResponseError(f"shape_at_points has shape {points.shape}: (n_points, {n}) is needed")
    if not np.all(np.isfinite(points)):
        raise ResponseError("shape_at_points has values that are not finite")
    return points


def _check_patches(patches: Patches, n: int) -> None:
    if patches.overlap.shape[1] != n:
        raise ResponseError(
            f"overlap has shape {patches.overlap.shape}: (n_patches, {n}, {n}) is needed"
        )


def _check_stable(damping: Floats, damping_norm: Floats, allow_negative: bool) -> None:
    """Refuse C_e < 0 unless allowed and outweighed.

    D_p ≤ norm_p C as quadratic forms, so Σ_p max(−C_e,p, 0) norm_p < 1 keeps C + Σ C_e D positive.
    """
    taken = damping_norm @ np.maximum(-damping, 0)
    if not np.any(taken > 0) or (allow_negative and np.max(taken) < 1):
        return
    patch, line = np.unravel_index(np.argmin(damping), damping.shape)
    raise UnstableDamping(
        f"equivalent_damping = {damping[patch, line]:g} N s/m³ (patch {patch}, line {line}): "
        "must be at least 0; negative damping feeds energy to the panel, which would be unstable"
        + (
            f" (it takes {np.max(taken):.3g} times the panel's own damping)"
            if allow_negative
            else ""
        )
    )
