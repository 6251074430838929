"""Dampers on the panel: exact attachment to its patches.

A damper on patch p pulls with −s_p, s = iω C_e − ω² m_a, at the motions that the patch feels, all
dampers together at u with −S u, S = Σ_p s_p Δ_p (Woodbury's identity):

    u = (I + R_uu S)⁻¹ u₀,      w = w₀ − B u₀,      B = R_wu S (I + R_uu S)⁻¹.

The paper keeps only the diagonal of D (`direct`); here the matrix is full.
"""

from collections.abc import Callable, Iterator

import numpy as np
import scipy.linalg as la
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.modal import BarePanel, chunks_of_lines
from pidpanel.solve.model import PanelResponse, Patches, UnstableDamping, checked_array


def patch_stiffness(frequency: Array, damping: Array, mass: Array) -> Complexes:
    """Return s = iω C_e − ω² m_a (n_patches, nf) [N/m³] from C_e and m_a (n_patches, nf)."""
    omega = 2 * np.pi * frequency
    return 1j * omega * damping - omega**2 * mass


def weighted_sum(stiffness: Complexes, weight: Array) -> Complexes:
    """Return Σ_p s_p Δ_p (nf, r, r) from s (n_patches, nf) and Δ (n_patches, r, r)."""
    r = weight.shape[1]
    flat = weight.reshape(len(weight), r * r)
    total = np.empty((stiffness.shape[1], r * r), dtype=np.complex128)
    total.real = np.ascontiguousarray(stiffness.real.T) @ flat
    total.imag = np.ascontiguousarray(stiffness.imag.T) @ flat
    return total.reshape(len(total), r, r)


def checked_dampers(
    patches: Patches, frequency: Array, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
) -> tuple[Array, Array]:
    """Return C_e and m_a, each (n_patches, nf), finite, and C_e not negative."""
    shape = (patches.count, frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    check_stable(damping)
    return damping, checked_array("apparent_mass", apparent_mass, shape)


def attach_dampers(
    bare: BarePanel,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    with_slope: bool = False,
) -> PanelResponse:
    """Return the response of a panel whose patches carry dampers.

    A change δs of s = iω C_e − ω² m_a on patch p pulls at the damped motion u with δs Δ_p u, so
    that the acceleration PSD at the points changes by

        δS_a = −2 Re(δs t_p),      t_p = ω⁴ (R_wu Δ_p S_uw)_ww,

    with R_wu and S_wu = (S_wu − B S_uu)(I + R_uu S)⁻ᴴ of the panel that carries the dampers.

    Parameters
    ----------
    equivalent_damping
        (n_patches, nf) C_e [N s/m³]; 0 for a patch without damper.
    apparent_mass
        (n_patches, nf) m_a [kg/m²], of either sign.
    with_slope
        Whether to return t.

    Raises
    ------
    UnstableDamping
        If C_e < 0, as with the law of the paper as printed (Eq. 5-6).
    ResponseError
        If shapes disagree or a value is not finite.
    """
    damping, mass = checked_dampers(bare.patches, bare.frequency, equivalent_damping, apparent_mass)
    n_points, m = bare.point_psd.shape[1:3]
    cross_psd = np.empty_like(bare.point_psd)
    slope = np.empty((len(damping), *bare.point_psd.shape[:2]), complex) if with_slope else None
    for lines, Y, B, t in _updates(bare, damping, mass, with_slope):
        by_point = (len(B), n_points, m, B.shape[2])
        drop = Y.reshape(by_point) @ B.conj().reshape(by_point).swapaxes(2, 3)
        cross_psd[lines] = bare.point_psd[lines] - drop - drop.conj().swapaxes(2, 3)
        if slope is not None:
            slope[:, lines] = t
    return PanelResponse(bare.frequency, cross_psd, slope)


def covariance_taken(
    bare: BarePanel, equivalent_damping: ArrayLike, apparent_mass: ArrayLike, weight: Array
) -> Array:
    """Return what dampers take from sums of Re S_ww over frequency."""
    damping, mass = checked_dampers(bare.patches, bare.frequency, equivalent_damping, apparent_mass)
    m = bare.point_psd.shape[2]
    total = np.zeros((len(weight), m, m))
    for lines, Y, B, _ in _updates(bare, damping, mass):
        # all lines in one product, real and imaginary parts side by side
        right = np.ascontiguousarray(B.swapaxes(0, 1)).reshape(m, -1).view(np.float64)
        for part, shares in zip(total, weight[:, lines], strict=True):
            left = np.ascontiguousarray((shares[:, None, None] * Y).swapaxes(0, 1))
            product = left.reshape(m, -1).view(np.float64) @ right.T
            part += product + product.T
    return total


def _updates(
    bare: BarePanel, damping: Array, mass: Array, with_slope: bool = False
) -> Iterator[tuple[slice, Complexes, Complexes, Complexes | None]]:
    """Yield Y and B (nf, nw, r) on some lines after others: S_ww falls by Y Bᴴ + B Yᴴ; and t.

    S_ww − B S_uw − S_wu Bᴴ + B S_uu Bᴴ = S_ww − (Y Bᴴ + B Yᴴ) with Y = S_wu − B S_uu/2.
    """
    m, width = bare.point_psd.shape[2], bare.receptance.shape[2]
    for lines in chunks_of_lines(bare.frequency.size, 2 * width):
        s = patch_stiffness(bare.frequency[lines], damping[:, lines], mass[:, lines])
        # R_uu S, since Z₀ and with it R_uu is symmetric
        loop = pulled(bare, s, bare.receptance[lines, :width]).swapaxes(1, 2)
        loop[:, range(width), range(width)] += 1
        solve = solution(loop, again=with_slope)
        receptance = solve(bare.receptance[lines, width:].swapaxes(1, 2))  # R_uw with the dampers
        B = pulled(bare, s, receptance).swapaxes(1, 2)
        pushed, t = B @ bare.patch_psd[lines, :width], None
        if with_slope:
            covariance = bare.patch_psd[lines, width::m] - pushed[:, ::m]
            psd = solve(covariance.conj().swapaxes(1, 2))  # S_uw
            scale = (2 * np.pi * bare.frequency[lines, None]) ** 4
            moved = receptance[:, :, ::m]
            t = np.empty((len(s), *moved.shape[::2]), complex)
            for patch, weight in enumerate(bare.coordinates.weight):
                t[patch] = scale * np.sum(moved * (weight @ psd), axis=1)
        yield lines, bare.patch_psd[lines, width:] - pushed / 2, B, t


def solution(matrix: Complexes, *, again: bool) -> Callable[[Complexes], Complexes]:
    """Return what solves with matrices (nf, n, n), factorised once where it is called again."""
    if not again:
        return lambda force: np.asarray(np.linalg.solve(matrix, force), np.complex128)
    factors = la.lu_factor(matrix, check_finite=False)
    return lambda force: np.asarray(la.lu_solve(factors, force, check_finite=False), np.complex128)


def pulled(bare: BarePanel, stiffness: Complexes, motion: Complexes) -> Complexes:
    """Return S times motions (nf, r, k); for one patch S is s times the unit matrix."""
    if bare.patches.count == 1:
        return stiffness[0, :, None, None] * motion
    return weighted_sum(stiffness, bare.coordinates.weight) @ motion


def check_stable(damping: Array) -> None:
    """Refuse C_e < 0 (n_patches, nf)."""
    if not np.any(damping < 0):
        return
    patch, line = np.unravel_index(np.argmin(damping), damping.shape)
    raise UnstableDamping(
        f"equivalent_damping = {damping[patch, line]:g} N s/m³ (patch {patch}, line {line}): "
        "must be at least 0; negative damping feeds energy to the panel, which would be unstable"
    )
