"""Modal damping of a treated panel for Nastran: tables TABDMP1, one a scenario.

A damper on a patch adds to mode i, with the overlap D_ii = ∫_patch φ_i² dA,

    ζ_i = ζ + Σ_patches C_e(ω_i) D_ii/(2 m_i ω_i),

the diagonal of the modal damping matrix (paper, Eq. 12). What couples the modes is left out, as
modal damping does: 4 to 5 dB off the patch at high frequency in the paper's panel.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.response.nastran import large_field_table


def modal_damping_ratio(
    damping_ratio: float | Array,
    natural_frequency: Array,
    modal_mass: Array,
    overlap: Array,
    equivalent_damping: Array,
) -> Array:
    """Return ζ_i (n,) of the modes with one damper more.

    Examples
    --------
    >>> modal_damping_ratio(0.01, np.array([100.0]), np.array([1.5]), np.array([0.04]),
    ...                     np.array([300 * np.pi]))
    array([0.03])
    """
    omega = 2 * np.pi * natural_frequency
    return damping_ratio + equivalent_damping * overlap / (2 * modal_mass * omega)


def write_tabdmp1(path: Path, frequency: Array, ratios: Mapping[str, Array], title: str) -> None:
    """Write bulk data cards TABDMP1, large field, shares of critical damping over Hz.

    Tables are numbered from 1 in the order given. Modes of the same frequency, which a table cannot
    distinguish, have the mean of their values.
    """
    distinct, index = np.unique(np.round(frequency, 6), return_inverse=True)
    with path.open("w", encoding="ascii", errors="replace") as file:
        file.write(f"$ {title}\n$ modal damping, share of critical, over natural frequency, Hz\n")
        for number, (name, ratio) in enumerate(ratios.items(), start=1):
            mean = np.bincount(index, ratio) / np.bincount(index)
            file.write(f"$ {name}\n")
            file.writelines(large_field_table("TABDMP1", number, ["CRIT"], distinct, mean))
