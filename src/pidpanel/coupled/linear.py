"""The panel with linear dampers over frequency, seen from its stations or its patches.

With the motions u = Eᵀq that the dampers feel, and the force iωL u that they exert on them,

    q = Z₀⁻¹ (f − E iωL u),   u = (I + R iωL)⁻¹ Eᵀ Z₀⁻¹ f,   R = Eᵀ Z₀⁻¹ E.

At the stations E has their shapes as columns and L = diag(a_k Z_k); of whole patches E and Δ_p are
those of D_p = E Δ_p Eᵀ, and L = Σ_p Z_p Δ_p. A bed's own force n beside its impedance acts on the
modes as −Σ φ n a.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from pidpanel.arrays import Array, Complexes

LINES_AT_ONCE = 32
"""Frequency lines solved together."""


def motion(
    frequency: Array,
    stiffness: Complexes,
    felt: Array,
    load: Complexes,
    seen: Array,
    amplitude: Complexes,
) -> Complexes:
    """Return the motion Wᵀq under given modal forces.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    stiffness
        (nf, n) diagonal of Z₀ of the bare panel [N/m].
    felt
        (n, r) E.
    load
        (nf, r, r) L.
    seen
        (s, n) Wᵀ: the shapes where the motion is wanted [1].
    amplitude
        (nf, n) f [N].

    Returns
    -------
    (nf, s) [m].
    """
    found = np.empty((len(frequency), len(seen)), complex)
    for lines in _chunks(len(frequency)):
        free = amplitude[lines] / stiffness[lines]
        across, force, own = _parts(frequency[lines], stiffness[lines], felt, load[lines], seen)
        felt_motion = np.linalg.solve(own, (free @ felt)[:, :, None])
        found[lines] = free @ seen.T - (across @ force @ felt_motion)[:, :, 0]
    return found


def point_psds(
    frequency: Array,
    stiffness: Complexes,
    felt: Array,
    loads: Sequence[Complexes],
    seen: Array,
    pressure_psd: Array,
    modal_force: Callable[[Array], Array | Complexes],
    own_psds: Sequence[Callable[[slice], Array]],
) -> Iterator[Array]:
    """Yield the PSDs of the motions Wᵀq under sound and the beds' own forces, for several dampers.

    Parameters
    ----------
    frequency, stiffness, felt, seen
        As of `motion`.
    loads
        L of each.
    pressure_psd
        (nf,) S_p [Pa²/Hz].
    modal_force
        G over frequency: (k,) [Hz] to (k, n, n) [m⁴].
    own_psds
        Of each the PSDs of the modal forces of the beds' own, at some lines, (k, n, n) [N²/Hz].

    Yields
    ------
    (nf, s) [m²/Hz] for each.
    """
    found = [np.empty((len(frequency), len(seen))) for _ in loads]
    for lines in _chunks(len(frequency)):
        inverse = 1 / stiffness[lines]
        pushed = felt.T[None] * inverse[:, None, :]
        sound = pressure_psd[lines, None, None] * modal_force(frequency[lines])
        for load, own_psd, psd in zip(loads, own_psds, found, strict=True):
            across, force, own = _parts(frequency[lines], stiffness[lines], felt, load[lines], seen)
            row = seen[None] * inverse[:, None, :] - across @ force @ np.linalg.solve(own, pushed)
            total = sound + own_psd(lines)
            psd[lines] = np.einsum("fsn,fsn->fs", row @ total, row.conj()).real
    yield from found


def _parts(
    frequency: Array, stiffness: Complexes, felt: Array, load: Complexes, seen: Array
) -> tuple[Complexes, Complexes, Complexes]:
    """Return Wᵀ Z₀⁻¹ E, iωL and I + R iωL."""
    inverse = 1 / stiffness[:, None, :]
    force = 2j * np.pi * frequency[:, None, None] * load
    across = np.asarray((seen[None] * inverse) @ felt, dtype=np.complex128)
    receptance = np.asarray((felt.T[None] * inverse) @ felt, dtype=np.complex128)
    own = np.eye(felt.shape[1], dtype=np.complex128) + receptance @ force
    return across, force, own


def _chunks(count: int) -> Iterator[slice]:
    return (slice(start, start + LINES_AT_ONCE) for start in range(0, count, LINES_AT_ONCE))
