"""Dampers on the panel: exact attachment to its patches, see `receptances`.

A damper on patch p pulls with −s_p, s = iω C_e − ω² m_a, at the motions that the patch feels, all
dampers together at u with −S u, S = Σ_p s_p Δ_p. The paper keeps only the diagonal of D
(`modal.panel_in_shapes`); here the matrix is full.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.modal import BarePanel, chunks_of_lines
from pidpanel.solve.model import PanelResponse, UnstableDamping, checked_array
from pidpanel.solve.receptances import Reaction, patch_stiffness, times


def checked_dampers(
    patches: int, frequency: Array, equivalent_damping: ArrayLike, apparent_mass: ArrayLike
) -> Complexes:
    """Return s (n_patches, nf) [N/m³] of finite C_e, not negative, and m_a (n_patches, nf)."""
    shape = (patches, frequency.size)
    damping = checked_array("equivalent_damping", equivalent_damping, shape)
    check_stable(damping)
    return patch_stiffness(frequency, damping, checked_array("apparent_mass", apparent_mass, shape))


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
    n_points, m = bare.point_psd.shape[1:3]
    weight, cross_psd = bare.coordinates.weight, np.empty_like(bare.point_psd)
    slope = np.empty((len(weight), *cross_psd.shape[:2]), complex) if with_slope else None
    for lines, part, reaction in _reactions(bare, equivalent_damping, apparent_mass, with_slope):
        by_point = (len(reaction.B), n_points, m, reaction.B.shape[2])
        Y, B = reaction.Y.reshape(by_point), reaction.B.reshape(by_point)
        drop = Y @ B.conj().swapaxes(2, 3)
        cross_psd[lines] = part.point_psd - drop - drop.conj().swapaxes(2, 3)
        if slope is None:
            continue
        covariance = 2 * reaction.Y[:, ::m] - part.receptances.across_psd[:, ::m]
        psd = reaction.solve(covariance.conj().swapaxes(1, 2))  # S_uw
        scale = (2 * np.pi * part.frequency[:, None]) ** 4
        for patch, share in enumerate(weight):
            pulled = times(share[None], psd)
            slope[patch, lines] = scale * np.sum(reaction.receptance[:, :, ::m] * pulled, axis=1)
    return PanelResponse(bare.frequency, cross_psd, slope)


def covariance_taken(
    bare: BarePanel, equivalent_damping: ArrayLike, apparent_mass: ArrayLike, weight: Array
) -> Array:
    """Return what dampers take from sums of Re S_ww over frequency."""
    m = bare.point_psd.shape[2]
    total = np.zeros((len(weight), m, m))
    for lines, _, (_, _, B, Y) in _reactions(bare, equivalent_damping, apparent_mass):
        # all lines in one product, real and imaginary parts side by side
        right = np.ascontiguousarray(B.swapaxes(0, 1)).reshape(m, -1).view(np.float64)
        for part, shares in zip(total, weight[:, lines], strict=True):
            left = np.ascontiguousarray((shares[:, None, None] * Y).swapaxes(0, 1))
            product = left.reshape(m, -1).view(np.float64) @ right.T
            part += product + product.T
    return total


def _reactions(
    bare: BarePanel,
    equivalent_damping: ArrayLike,
    apparent_mass: ArrayLike,
    with_slope: bool = False,
) -> Iterator[tuple[slice, BarePanel, Reaction]]:
    """Yield what dampers do on some lines after others."""
    weight, frequency = bare.coordinates.weight, bare.frequency
    s = checked_dampers(len(weight), frequency, equivalent_damping, apparent_mass)
    for lines in chunks_of_lines(frequency.size, 2 * weight.shape[1]):
        part = bare.on_lines(lines)
        yield lines, part, part.receptances.reaction(part.pull(s[:, lines]), reuse=with_slope)


def check_stable(damping: Array) -> None:
    """Refuse C_e < 0 (n_patches, nf)."""
    if not np.any(damping < 0):
        return
    patch, line = np.unravel_index(np.argmin(damping), damping.shape)
    raise UnstableDamping(
        f"equivalent_damping = {damping[patch, line]:g} N s/m³ (patch {patch}, line {line}): "
        "must be at least 0; negative damping feeds energy to the panel, which would be unstable"
    )
