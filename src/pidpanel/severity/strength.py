"""Failure indices of stresses whose signs are random: 1 is failure.

`maximum_stress_index` is the largest of the stresses over their strengths. `tsai_wu_index` is the
criterion of Tsai and Wu (J. Compos. Mater. 5 (1971) 58-80) with F₁₂ = −½ √(F₁₁ F₂₂). Stresses of
3σ are not reached together, and how they go together is not known here: the index is that of the
worst signs with all three reached, which no stress within these bounds exceeds, since the criterion
is convex.
"""

import itertools
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array


class LayerStrength(NamedTuple):
    """Strengths of a ply [Pa], all positive."""

    # Along (1) and across (2) the fibres
    tension_1: float
    compression_1: float
    tension_2: float
    compression_2: float
    shear: float  # in the plane


def maximum_stress_index(stress: Array, strength: LayerStrength) -> Array:
    """Return the largest of σ₁, σ₂ and τ₁₂ (…, 3) [Pa] over its strength, whatever its sign.

    Examples
    --------
    >>> ply = LayerStrength(1500.0, 1200.0, 50.0, 200.0, 70.0)
    >>> float(maximum_stress_index(np.array([300.0, 10.0, 35.0]), ply))
    0.5
    """
    tension_1, compression_1, tension_2, compression_2, shear = strength
    weakest = np.array([min(tension_1, compression_1), min(tension_2, compression_2), shear])
    return np.max(np.abs(stress) / weakest, axis=-1)


def tsai_wu_index(stress: Array, strength: LayerStrength) -> Array:
    """Return the index of failure by Tsai and Wu: 1/R, 1 at failure.

    R solves F_ij σ_i σ_j R² + F_i σ_i R = 1; see the module for the signs.

    Parameters and result are those of `maximum_stress_index`.
    """
    tension_1, compression_1, tension_2, compression_2, shear = strength
    f1, f2 = 1 / tension_1 - 1 / compression_1, 1 / tension_2 - 1 / compression_2
    f11, f22 = 1 / (tension_1 * compression_1), 1 / (tension_2 * compression_2)
    f12 = -np.sqrt(f11 * f22) / 2
    indices = []
    for signs in itertools.product((1.0, -1.0), repeat=2):
        s1, s2 = (sign * stress[..., axis] for axis, sign in enumerate(signs))
        square = f11 * s1**2 + f22 * s2**2 + 2 * f12 * s1 * s2 + (stress[..., 2] / shear) ** 2
        slope = f1 * s1 + f2 * s2
        indices.append((slope + np.sqrt(slope**2 + 4 * square)) / 2)  # 1/R
    return np.max(indices, axis=0)


def core_index(stress: Array, strength: tuple[float, float]) -> Array:
    """Return the largest of τ_xz and τ_yz (…, 2) of a core over its strength."""
    return np.max(np.abs(stress) / np.array(strength), axis=-1)
