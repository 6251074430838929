"""The first natural frequencies of a panel, quickly: for a look before a run."""

import numpy as np
import scipy.linalg as la
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array
from pidpanel.panel.eigen import factors
from pidpanel.panel.matrices import PlateMatrices

# Shift of Lanczos below zero [Hz]: lower than any first mode, and no singular matrix.
SHIFT = 1.0
# Share of the highest frequency below which a mode is that of a rigid body, except for rounding.
RIGID = 1e-3


def first_frequencies(plate: PlateMatrices, count: int) -> tuple[int, Array]:
    """Return the number of rigid-body modes and the first natural frequencies above [Hz].

    There is no check for missed modes as in `modes.normal_modes`. Rigid-body modes are included; a
    small mesh may have fewer than ``count``.
    """
    n_free = plate.stiffness.shape[0]
    shift = (2 * np.pi * SHIFT) ** 2
    if n_free > 4 * count:
        solve = factors(plate.stiffness + shift * plate.mass).solve
        eigenvalue = spla.eigsh(
            plate.stiffness,
            k=count,
            M=plate.mass,
            sigma=-shift,
            OPinv=spla.LinearOperator((n_free, n_free), solve),
            v0=np.random.default_rng(0).standard_normal(n_free),
            return_eigenvectors=False,
        )
    else:
        eigenvalue = la.eigvalsh(plate.stiffness.toarray(), plate.mass.toarray())[:count]
    frequency = np.sqrt(np.maximum(np.sort(eigenvalue), 0.0)) / (2 * np.pi)
    rigid = int(np.sum(frequency < RIGID * frequency[-1]))
    return rigid, frequency[rigid:]
