"""Dampers on the panel: exact attachment to its patches, and the paper's diagonal form.

A damper pulls at the patch motions u with −s u, s = iω C_e − ω² m_a (Woodbury's identity):

    u = (I + R_uu s)⁻¹ u₀,      w = w₀ − B u₀,      B = R_wu s (I + R_uu s)⁻¹.

The paper keeps only the diagonal of D and takes C_e(ω) through a Laplace transform as a constant
(Eq. 9-15); here the matrix is full and C_e is that of each line. `diagonal_response` is the
paper's form.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.response.lines import root_mean_square
from pidpanel.response.modal import (
    BarePanel,
    MatrixInput,
    check_patches,
    checked_frequency,
    checked_motions,
    checked_pressure_psd,
    chunks_of_lines,
    matrices_at,
)
from pidpanel.response.model import (
    ModalBasis,
    Patches,
    Response,
    ResponseError,
    UnstableDamping,
    checked_array,
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
    check_stable(damping, bare.damping_norm, allow_negative_damping)

    n_points, m = bare.point_psd.shape[1:3]
    width = bare.receptance.shape[2]
    cross_psd = np.empty_like(bare.point_psd)
    for lines in chunks_of_lines(bare.frequency.size):
        omega = 2 * np.pi * bare.frequency[lines]
        stiffness = np.empty((omega.size, width, 1), dtype=np.complex128)  # s, one per column
        for index, columns in enumerate(bare.patch_columns):
            patch = 1j * omega * damping[index, lines] - omega**2 * mass[index, lines]
            stiffness[:, columns] = patch[:, None, None]
        loop = stiffness * bare.receptance[lines, :width]  # Z₀, and so R_uu, is symmetric
        loop[:, range(width), range(width)] += 1
        from_points = stiffness * bare.receptance[lines, width:].swapaxes(1, 2)
        B = np.linalg.solve(loop, from_points).swapaxes(1, 2)
        # S_ww − B S_uw − S_wu Bᴴ + B S_uu Bᴴ = S_ww − (Y Bᴴ + B Yᴴ), Y = S_wu − B S_uu/2
        Y = bare.patch_psd[lines, width:] - B @ bare.patch_psd[lines, :width] / 2
        by_point = (omega.size, n_points, m, width)
        taken = Y.reshape(by_point) @ B.conj().reshape(by_point).swapaxes(2, 3)
        cross_psd[lines] = bare.point_psd[lines] - taken - taken.conj().swapaxes(2, 3)
    return Response(bare.frequency, cross_psd)


def acceleration_slope(
    bare: BarePanel, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
) -> Complexes:
    """How the acceleration PSD at the points follows the damper on one patch.

    A change δs of s = iω C_e − ω² m_a pulls at the damped patch motion u with δs u, so that

        δS_a = −2 Re(δs t),      t = ω⁴ Σ_k R_wu,k S_wu,k*,

    with R_wu and S_wu of the panel that carries the damper: (I + s R_uu)⁻¹ on the right of R_wu,
    and on that of S_wu − B S_uu its conjugate transpose.

    Parameters are those of `attach_dampers` for a panel with one patch, each (nf,).

    Returns
    -------
    (nf, n_points) t [(m/s²)²/Hz per N/m³].

    Raises
    ------
    ResponseError
        Where there is not one patch.
    """
    if len(bare.patch_columns) != 1:
        raise ResponseError(f"{len(bare.patch_columns)} patches: the slope is that of one")
    damping = checked_array("equivalent_damping", equivalent_damping, bare.frequency.shape)
    mass = checked_array("apparent_mass", apparent_mass, bare.frequency.shape)
    m, width = bare.point_psd.shape[2], bare.receptance.shape[2]
    slope = np.empty(bare.point_psd.shape[:2], complex)
    for lines in chunks_of_lines(bare.frequency.size):
        omega = 2 * np.pi * bare.frequency[lines, None, None]
        s = 1j * omega * damping[lines, None, None] - omega**2 * mass[lines, None, None]
        loop = np.eye(width) + s * bare.receptance[lines, :width]  # symmetric, as R_uu is
        once = np.linalg.solve(loop, bare.receptance[lines, width::m].swapaxes(1, 2))
        twice = np.linalg.solve(loop, once)  # R_wu (I + s R_uu)⁻², transposed
        psd = (
            bare.patch_psd[lines, width::m]
            - s * once.swapaxes(1, 2) @ bare.patch_psd[lines, :width]
        )
        slope[lines] = omega[:, 0] ** 4 * np.sum(twice.swapaxes(1, 2) * psd.conj(), axis=2)
    return slope


@dataclass(frozen=True)
class PatchMotion:
    """Mean motion of one patch as a function of the damper on it, for the search of its Γ.

    With R_uu = V Λ V⁻¹ a damper acts on each column of V alone, u = V d V⁻¹ u₀ with
    d = 1/(1 + sλ), so that any number of dampers costs one decomposition a line:

        mean over the patch of S_a = (ω⁴/A) Σ_jk d_j Q_jk d_k*,
        Q_jk = (V⁻¹ S_uu V⁻ᴴ)_jk (VᴴV)_kj.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    eigenvalue
        (nf, r) λ of R_uu [m³/N].
    weight
        (nf, r, r) ω⁴ Q/A [(m/s²)²/Hz].
    damping_norm
        (1,) as of the `BarePanel`.
    """

    frequency: Array
    eigenvalue: Complexes
    weight: Complexes
    damping_norm: Array

    @staticmethod
    def of(bare: BarePanel) -> "PatchMotion":
        """Decompose the receptance of a panel with one patch.

        Raises
        ------
        ResponseError
            Where there is not one patch.
        """
        if len(bare.patch_columns) != 1:
            raise ResponseError(f"{len(bare.patch_columns)} patches: the motion is that of one")
        width = bare.receptance.shape[2]
        eigenvalue, V = np.linalg.eig(bare.receptance[:, :width])
        inverse = np.linalg.inv(V)
        psd = inverse @ bare.patch_psd[:, :width] @ inverse.conj().swapaxes(1, 2)
        Q = psd * (V.conj().swapaxes(1, 2) @ V).swapaxes(1, 2)
        omega = 2 * np.pi * bare.frequency[:, None, None]
        return PatchMotion(
            bare.frequency, eigenvalue, omega**4 * Q / bare.patches.area[0], bare.damping_norm
        )

    @staticmethod
    def diagonal(
        frequency: ArrayLike,
        basis: ModalBasis,
        patches: Patches,
        pressure_psd: ArrayLike,
        modal_force: MatrixInput,
    ) -> "PatchMotion":
        """Return the motion in the paper's form, see `diagonal_response`.

        The same sum over modes, with λ_i = D_ii/z_i and Q_ij = S_p D_ij G_ij/(z_i z_j*), where
        z_i = m_i (ω_i² − ω² + 2iζ_i ω_i ω).
        """
        frequency = checked_frequency(frequency)
        pressure_psd = checked_pressure_psd(pressure_psd, frequency)
        check_patches(patches, basis.natural_frequency.size)
        (overlap,) = patches.overlap
        receptance = 1 / basis.dynamic_stiffness(frequency)
        weight = np.empty((*receptance.shape, receptance.shape[1]), complex)
        for lines in chunks_of_lines(frequency.size):
            force = matrices_at(modal_force, frequency, lines, receptance.shape[1])
            left = (
                receptance[lines, :, None]
                * (pressure_psd[lines] * (2 * np.pi * frequency[lines]) ** 4 / patches.area[0])[
                    :, None, None
                ]
            )
            weight[lines] = left * (overlap * force) * receptance[lines, None, :].conj()
        own = np.diagonal(overlap)
        norm = np.array([np.max(own / basis.damping)])
        return PatchMotion(frequency, own * receptance, weight, norm)

    def acceleration_psd(self, equivalent_damping: ArrayLike, apparent_mass: ArrayLike) -> Array:
        """Return the mean over the patch of the acceleration PSD (nf,) [(m/s²)²/Hz].

        Parameters and errors are those of `attach_dampers`, each (nf,).
        """
        d, seen = self._followed(equivalent_damping, apparent_mass)
        psd: Array = np.sum(d * seen, axis=1).real
        return psd

    def acceleration_slope(
        self, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
    ) -> Complexes:
        """Return t (nf,) of that PSD, δS_a = −2 Re(δs t), as of `acceleration_slope`."""
        d, seen = self._followed(equivalent_damping, apparent_mass)
        slope: Complexes = np.sum(self.eigenvalue * d**2 * seen, axis=1)
        return slope

    def _followed(
        self, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
    ) -> tuple[Complexes, Complexes]:
        """(nf, r) d_j and ω⁴/A Σ_k Q_jk d_k*."""
        damping = checked_array("equivalent_damping", equivalent_damping, self.frequency.shape)
        mass = checked_array("apparent_mass", apparent_mass, self.frequency.shape)
        check_stable(damping[None], self.damping_norm, False)
        omega = 2 * np.pi * self.frequency
        s = 1j * omega * damping - omega**2 * mass
        d = 1 / (1 + s[:, None] * self.eigenvalue)
        return d, (self.weight @ d.conj()[:, :, None])[:, :, 0]

    def acceleration_rms(self, equivalent_damping: ArrayLike, apparent_mass: ArrayLike) -> float:
        """Return the rms over time and patch of the acceleration [m/s²]."""
        psd = self.acceleration_psd(equivalent_damping, apparent_mass)
        return float(root_mean_square(self.frequency, psd))


def diagonal_response(
    frequency: ArrayLike,
    basis: ModalBasis,
    patches: Patches,
    motion_at_points: ArrayLike,
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

    Parameters, returns and errors are those of `bare_panels` and `attach_dampers`.
    """
    frequency = checked_frequency(frequency)
    pressure_psd = checked_pressure_psd(pressure_psd, frequency)
    n = basis.natural_frequency.size
    points = checked_motions(motion_at_points, n)
    check_patches(patches, n)
    shape = (patches.area.size, frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    mass = checked_array("apparent_mass", apparent_mass, shape)
    overlap = np.diagonal(patches.overlap, axis1=1, axis2=2)  # (n_patches, n)
    check_stable(damping, np.max(overlap / basis.damping, axis=1), allow_negative_damping)

    transfer = _diagonal_transfer(frequency, basis, overlap, damping, mass)
    cross_psd = np.empty((frequency.size, points.shape[0], *points.shape[1:2] * 2), complex)
    for lines in chunks_of_lines(frequency.size):
        force = matrices_at(modal_force, frequency, lines, n)
        sound = pressure_psd[lines, None, None]
        for index, point in enumerate(points):
            motion = point * transfer[lines, None, :]
            cross_psd[lines, index] = sound * (motion @ force @ motion.conj().swapaxes(1, 2))
    return Response(frequency, cross_psd)


def diagonal_slope(
    frequency: Array,
    basis: ModalBasis,
    patch: Patches,
    motion_at_points: ArrayLike,
    pressure_psd: Array,
    modal_force: MatrixInput,
    equivalent_damping: Array,
    apparent_mass: Array,
) -> Complexes:
    """Return t (nf, n_points) of `acceleration_slope` in the paper's form: δH_i = −H_i² D_ii δs.

    Parameters are those of `diagonal_response`, of one patch; C_e and m_a are (nf,).
    """
    n = basis.natural_frequency.size
    deflection = checked_motions(motion_at_points, n)[:, 0]
    overlap = np.diagonal(patch.overlap, axis1=1, axis2=2)
    transfer = _diagonal_transfer(
        frequency, basis, overlap, equivalent_damping[None], apparent_mass[None]
    )
    slope = np.empty((frequency.size, len(deflection)), complex)
    for lines in chunks_of_lines(frequency.size):
        force = matrices_at(modal_force, frequency, lines, n)
        motion = deflection * transfer[lines, None, :]
        pushed = (motion * (overlap[0] * transfer[lines])[:, None, :]) @ force
        sound = (2 * np.pi * frequency[lines]) ** 4 * pressure_psd[lines]
        slope[lines] = sound[:, None] * np.sum(pushed * motion.conj(), axis=2)
    return slope


def _diagonal_transfer(
    frequency: Array, basis: ModalBasis, overlap: Array, damping: Array, mass: Array
) -> Complexes:
    """(nf, n) H_i, with the diagonals (n_patches, n) of D."""
    omega = 2 * np.pi * frequency
    patch_stiffness = (1j * omega * damping - omega**2 * mass).T @ overlap
    transfer: Complexes = 1 / (basis.dynamic_stiffness(frequency) + patch_stiffness)
    return transfer


def check_stable(damping: Array, damping_norm: Array, allow_negative: bool) -> None:
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
