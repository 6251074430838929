"""Mass of the air that moves along with a baffled panel, on one side.

Rayleigh's integral for the pressure on a plate in a rigid baffle has, in phase with the
acceleration, the kernel cos(kR)/(2πR):

    M_air,ij = ρ₀ V_ij(k),    V_ij = (1/2π) ∬ φ_i φ_j cos(kR)/R dA dA′    [m³ for plain shapes].

Its two-dimensional Fourier transform is 1/√(κ² − k²) for κ > k and 0 below, so with Φ the
transform of the shapes and κ² = k² + t²

    V(k) = (1/2π) ∫₀^∞ Ā(√(k² + t²)) dt,    Ā(κ) = (1/2π) ∮ Re Φ Φᴴ dα:

no singular integral is left (Junger and Feit, Sound, Structures, and Their Interaction, 4.3 and
5.1). Ā too is even and entire, so it is computed at Chebyshev nodes once for all k.
"""

import numpy as np

from pidpanel.arrays import Array
from pidpanel.sound.field import PanelQuadrature, half_circle, sum_of_plane_waves, transform
from pidpanel.sound.wavenumber_table import (
    FieldError,
    WavenumberTable,
    chebyshev_nodes,
    checked_maximum,
    even_interpolation,
    node_count,
)

TAIL = 0.01
"""Share of each shape's V at k = 0 that may lie beyond the wavenumbers integrated over.

A tenth of the panel's mass is air: 1 % of it is 0.05 % of a natural frequency.
"""

FINEST = 3.0
"""Largest κ over the mean distance of the quadrature points: finer waves are not resolved."""


def tabulate_added_mass(wavenumber_max: float, panel: PanelQuadrature) -> WavenumberTable:
    """Tabulate V for 0 ≤ k ≤ k_max.

    The integral over κ goes as far as the shapes have content: Ā of a supported panel falls like
    κ⁻⁵, so that ¼ κ Ā/2π is left beyond κ.

    Parameters
    ----------
    wavenumber_max
        k_max [rad/m] > 0.
    panel
        Shapes at quadrature points.

    Returns
    -------
    WavenumberTable of V [m³], symmetric positive semidefinite.

    Raises
    ------
    FieldError
        Where k_max is not positive, or the quadrature is too coarse for the shapes.
    """
    k_max = checked_maximum(wavenumber_max)
    finest = FINEST / np.sqrt(panel.weight.sum() / panel.weight.size)
    reach = 2 * k_max
    while True:
        count = node_count(reach, panel.diameter)
        nodes = chebyshev_nodes(reach, count)
        content = np.array([_azimuthal_mean(kappa, panel) for kappa in nodes])
        static = _integrated(0.0, reach, content)
        own = np.maximum(np.diagonal(static), np.finfo(float).tiny)
        beyond = float(np.max(reach / 4 * np.diagonal(content[0]) / (2 * np.pi) / own))
        if beyond < TAIL:
            break
        reach *= 1.5
        if reach > finest:
            raise FieldError(
                f"{panel.weight.size} quadrature points leave {beyond:.1%} of the added mass of a "
                f"shape beyond {reach / 1.5:.0f} rad/m; use smaller elements"
            )
    k = chebyshev_nodes(k_max, node_count(k_max, panel.diameter))
    return WavenumberTable(k_max, k, np.array([_integrated(one, reach, content) for one in k]))


def _azimuthal_mean(kappa: float, panel: PanelQuadrature) -> Array:
    """Return Ā(κ), (n, n) [m⁴]."""
    even, odd = transform(np.array([kappa]), half_circle(kappa, panel.diameter), panel)
    return sum_of_plane_waves(even, odd, np.ones(1))


def _integrated(k: float, reach: float, content: Array) -> Array:
    """Return V(k) from Ā at the Chebyshev nodes up to `reach`."""
    count = len(content)
    node, weight = np.polynomial.legendre.leggauss(4 * count)
    longest = np.sqrt(reach**2 - k**2)
    t = longest / 2 * (1 + node)
    to_content = longest / 2 * weight @ even_interpolation(np.hypot(k, t), reach, count)
    integral: Array = np.tensordot(to_content, content, axes=1) / (2 * np.pi)
    return integral
