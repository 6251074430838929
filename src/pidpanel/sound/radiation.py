"""Effect of the air on the panel: radiation damping and added mass.

The pressure on a baffled plate that moves at the velocity v (Rayleigh's integral) is

    p(x) = (iωρ₀/2π) ∫ v(x′) exp(−ikR)/R dA′,

so that the air on one side adds iωR − ω²M_air to the dynamic stiffness of the shapes, with

    R = ρ₀ω²/(2πc₀) G,    M_air,ij = (ρ₀/2π) ∬ φ_i φ_j cos(kR)/R dA dA′

and G that of the diffuse field (`sound.field`), by reciprocity, whatever field drives the panel.
The baffle is an assumption: at the edges of a panel that stands free the air flows round, so that R
of the lowest modes, and with it their radiation damping, is less than computed here.

The kernel of M_air = ρ₀ V(k), V in m³ for plain shapes, is in phase with the acceleration. Its
two-dimensional Fourier transform is 1/√(κ² − k²) for κ > k and 0 below, so with Φ the transform of
the shapes and κ² = k² + t²

    V(k) = (1/2π) ∫₀^∞ Ā(√(k² + t²)) dt,    Ā(κ) = (1/2π) ∮ Re Φ Φᴴ dα:

no singular integral is left (Junger and Feit, Sound, Structures, and Their Interaction, 4.3 and
5.1). Ā too is even and entire, so it is computed at Chebyshev nodes once for all k.

Shapes with free edges, rigid feet or forces of a patch reach far: Ā falls like κ⁻³ only where the
deflection ends with a jump. What lies beyond the wavenumber K integrated to is known all the same,
by Parseval:

    Q_ij(K) = (1/2π) ∫_K^∞ Ā κ dκ = ∫ φ_i φ_j dA − (1/2π) ∫₀^K Ā κ dκ,

and the rest of V lies between 0 and Q/K. Where Ā falls like κ⁻ᵖ it is (p − 2)/(p − 1) Q/K: half of
it behind a jump (p = 3), five sixths for p = 7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.progress import with_progress
from pidpanel.sound.face import FoldedFace
from pidpanel.sound.field import wavenumber
from pidpanel.sound.wavenumber_table import (
    FieldError,
    Table,
    WavenumberTable,
    chebyshev_nodes,
    even_interpolation,
    node_count,
)

# Largest κ over the mean distance of points of a mesh, to which they serve: half of what they
# resolve.
FINEST = 1.5

SHORTEST_REACH = 2.0  # least wavenumber integrated to, over that of the sound

# Exponents p between which the fall of Ā is read: that of a jump, that of a clamped edge.
FALL = (3.0, 7.0)

NODES_AT_ONCE = 16  # nodes at which Ā is summed together

# Values of Ā at those nodes that are summed together, so that they stay in the processor's own
# memory.
VALUES_AT_ONCE = 2**14


@dataclass(frozen=True)
class Air:
    """The air on the wetted sides (1 or 2) of a panel: ρ₀ [kg/m³], c₀ [m/s].

    ``diffuse`` is G of the diffuse field [m⁴] over wavenumber, ``added_volume`` V = M_air/ρ₀ of one
    side [m³]; without it the air has resistance alone.
    """

    density: float
    speed_of_sound: float
    wetted_sides: int
    diffuse: Table
    added_volume: Table | None

    def __call__(self, frequency: Array) -> Complexes:
        """Return iωR − ω²M_air at the frequencies (nf,) [Hz], (nf, n, n) [N/m]."""
        return self.columns(frequency, None)

    def columns(self, frequency: Array, shapes: Index | None) -> Complexes:
        """Return the columns of some shapes, (nf, n, k); None for all."""
        k = wavenumber(frequency, self.speed_of_sound)
        omega = 2 * np.pi * frequency[:, None, None]
        mass = -(omega**2) * self.wetted_sides * self.density
        modal_force = self.diffuse.matrix(k, shapes)
        stiffness = np.zeros(modal_force.shape, dtype=np.complex128)
        np.multiply(
            -omega * mass / (2 * np.pi * self.speed_of_sound), modal_force, out=stiffness.imag
        )
        if self.added_volume is not None:
            np.multiply(mass, self.added_volume.matrix(k, shapes), out=stiffness.real)
        return stiffness


def tabulate_added_mass(wavenumber_max: float, panel: PanelQuadrature) -> WavenumberTable:
    """Tabulate V [m³], symmetric positive semidefinite, for 0 ≤ k ≤ k_max [rad/m].

    The integral extends to the largest wavenumber K of the face; raises `FieldError` if K is less
    than 2 k_max. The part of a shape beyond K is wrong by at most Q_ii/2K if it falls with κ⁻³ or
    faster, and by Q_ii/K in any case. Q_ii is a share of ∫ φ_i² dA, so the error of M_air is less
    than ρ₀/K kg/m² for a shape that lies wholly beyond K, 0.02 kg/m² for sound up to 2 kHz, and
    proportionally less for the shapes of the range.
    """
    k_max = float(wavenumber_max)
    reach = panel.wavenumber
    if not np.isfinite(reach):
        reach = FINEST / np.sqrt(panel.weight.sum() / panel.weight.size)
    if reach < SHORTEST_REACH * k_max * (1 - 1e-9):
        raise FieldError(
            f"{panel.weight.size} quadrature points serve waves to {reach:.0f} rad/m;"
            f" {SHORTEST_REACH * k_max:.0f} are needed: use smaller elements"
        )
    count = node_count(reach, panel.diameter)
    k = chebyshev_nodes(k_max, node_count(k_max, panel.diameter))
    rows = [_reactive(wavenumber, reach, count) for wavenumber in k]
    rows += [_content(upper, reach, count) for upper in (reach / np.sqrt(2), reach)]
    node_values = np.array(rows) / (2 * np.pi)

    face = FoldedFace.from_panel(panel, reach)
    nodes = chebyshev_nodes(reach, count)
    n = panel.shape.shape[1]
    sums = np.zeros((len(rows), n * n))
    starts = range(0, count, NODES_AT_ONCE)
    for start in with_progress(starts, "parts of the air's wavenumbers"):
        part = slice(start, start + NODES_AT_ONCE)
        means = np.array([face.azimuthal_mean(q, panel.diameter).ravel() for q in nodes[part]])
        for first in range(0, n * n, VALUES_AT_ONCE):
            values = slice(first, first + VALUES_AT_ONCE)
            sums[:, values] += node_values[:, part] @ means[:, values]
    volume = sums[:-2].reshape(-1, n, n)
    nearer, farther = (panel.product_integral - content.reshape(n, n) for content in sums[-2:])
    for volume_at, k_at in zip(volume, k, strict=True):
        volume_at += _rest(k_at, reach, farther, np.diagonal(nearer))
    return WavenumberTable(k_max, k, volume)


def _reactive(k: float, reach: float, count: int) -> Array:
    """Return the weights (count,) of Ā at its nodes in ∫ Ā(√(k² + t²)) dt up to κ = `reach`."""
    node, weight = np.polynomial.legendre.leggauss(4 * count)
    longest = np.sqrt(reach**2 - k**2)
    t = longest / 2 * (1 + node)
    return longest / 2 * weight @ even_interpolation(np.hypot(k, t), reach, count)


def _content(upper: float, reach: float, count: int) -> Array:
    """Return the weights (count,) of Ā at its nodes in ∫ Ā κ dκ up to `upper`."""
    node, weight = np.polynomial.legendre.leggauss(4 * count)
    kappa = upper / 2 * (1 + node)
    return (upper / 2 * weight * kappa) @ even_interpolation(kappa, reach, count)


def _rest(k: float, reach: float, farther: Array, nearer: Array) -> Array:
    """Return the part of V(k) beyond K, (n, n), from Q(K) and the fall p by Q_ii(K/√2)."""
    diagonal = np.maximum(np.diagonal(farther), np.finfo(float).tiny)
    fall = 2 + np.log(np.maximum(nearer / diagonal, 1.0)) / np.log(np.sqrt(2))
    p = np.clip(fall, *FALL)
    # ∫_K^∞ κ^(1−p)/√(κ² − k²) dκ, in powers of (k/K)²
    ratio = (k / reach) ** 2
    share = (p - 2) * (
        1 / (p - 1) + ratio / 2 / (p + 1) + 3 / 8 * ratio**2 / (p + 3) + 5 / 16 * ratio**3 / (p + 5)
    )
    root = np.sqrt(share / reach)
    return root[:, None] * farther * root
