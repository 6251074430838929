"""Normal modes of the panel, bare and with mass on its patches."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array, Flags
from pidpanel.panel.eigen import BLOCK, eigenpairs, factors
from pidpanel.panel.matrices import PlateMatrices

# A mesh with fewer coordinates than this times its modes is solved as dense matrices.
WHOLE = 4
# A mode whose elastic energy is this small a share of what its terms add up to, signs left out,
# is a rigid body's: what is left is rounding. A fine mesh in a corner makes it 1e-8 for others.
RIGID = 1e-12
# A plate has at most three rigid modes; they are searched among this number of lowest modes.
MOST_RIGID = 16
# Columns whose energies are computed together, so that no copy of all is made.
COLUMNS_AT_ONCE = 64
# A shape whose w at the vertices is below this share of that between them is not seen by them.
HIDDEN = 0.1
# `first_modes` are found about this frequency below zero [Hz]: low beside any first mode, and
# no singular matrix. What is below a share of the highest of them is a rigid body's.
SHIFT, RIGID_SHARE = 1.0, 1e-3


def count_modes_below(plate: PlateMatrices, frequency: float) -> int:
    """Count the modes below a frequency [Hz], itself no eigenfrequency, without computing them.

    By Sylvester's law of inertia, the eigenvalues of (K, M) below (2πf)² are as many as the
    negative pivots of K − (2πf)² M, if rows and columns are permuted alike. Raises `RuntimeError`
    if they had to be permuted differently, because a pivot vanished.
    """
    shifted = plate.stiffness - (2 * np.pi * frequency) ** 2 * plate.mass
    # Units of the free coordinates differ (w, w_x, w_xy); a symmetric scaling keeps the inertia.
    scale = sp.diags_array(1 / np.sqrt(plate.stiffness.diagonal()))
    factor = factors(scale @ shifted @ scale)
    if not np.array_equal(factor.perm_r, factor.perm_c):
        raise RuntimeError(
            f"modes below {frequency:g} Hz cannot be counted: a pivot vanished there; change the"
            " frequency by a little"
        )
    return int(np.sum(factor.U.diagonal() < 0))


def normal_modes(
    plate: PlateMatrices, frequency_limit: float, at_least: int = 0
) -> tuple[Array, Array]:
    """Compute all modes below a frequency [Hz], (K − (2πf_i)² M) φ_i = 0, rigid-body modes first.

    Block Lanczos from fixed vectors (`pidpanel.panel.eigen`), so that the same plate always gives
    the same modes, also where two frequencies coincide; none is missed, by Sylvester's count (else
    a `RuntimeError`). A mesh with hardly more coordinates than modes is solved as dense matrices.
    ``at_least`` is the number of modes if fewer lie below. Frequencies are (n,) [Hz], ascending,
    and shapes (n_free, n) with max |w| = 1 over the vertices.
    """
    count = count_modes_below(plate, frequency_limit)
    if WHOLE * (max(count, at_least) + BLOCK) < plate.stiffness.shape[0]:
        limit, n = frequency_limit, count
        while n < at_least:
            limit *= 1.5
            n = count_modes_below(plate, limit)
        eigenvalue, modes = eigenpairs(plate.stiffness, plate.mass, (2 * np.pi * limit) ** 2, n)
    else:
        eigenvalue, modes = la.eigh(plate.stiffness.toarray(), plate.mass.toarray())
    lowest = slice(MOST_RIGID)
    eigenvalue[lowest][is_rigid(plate, modes[:, lowest])] = 0.0
    frequency = np.sqrt(eigenvalue) / (2 * np.pi)
    counted = int(np.sum(frequency < frequency_limit))
    if counted != count:
        raise RuntimeError(
            f"{counted} modes were found below {frequency_limit:g} Hz, where"
            f" {count} exist by Sylvester's count"
        )
    lowest_modes = slice(max(count, at_least))
    return frequency[lowest_modes], normalise(plate, modes[:, lowest_modes])


def is_rigid(plate: PlateMatrices, modes: Array) -> Flags:
    """Return whether the elastic energy of each mode is rounding error only."""
    return quadratic_form(plate.stiffness, modes) < RIGID * quadratic_form(
        abs(plate.stiffness), abs(modes)
    )


def quadratic_form(matrix: sp.csr_array, vectors: Array) -> Array:
    """Return vᵀ A v (n,) of columns (n_free, n)."""
    values = np.empty(vectors.shape[1])
    for start in range(0, values.size, COLUMNS_AT_ONCE):
        part = slice(start, start + COLUMNS_AT_ONCE)
        values[part] = np.einsum("ki,ki->i", vectors[:, part], matrix @ vectors[:, part])
    return values


def loaded_modes(
    plate: PlateMatrices, damper_mass: Mapping[str, float], frequency_limit: float
) -> tuple[Array, Array]:
    """Return the modes below a frequency of the panel with mass on its patches."""
    mass = plate.mass
    for name, value in damper_mass.items():
        mass = mass + value * plate.patch_overlap[name]
    heavy = replace(plate, mass=sp.csr_array(mass))
    return normal_modes(heavy, frequency_limit)


def normalise(plate: PlateMatrices, vectors: Array) -> Array:
    """Scale each column to max |w| = 1 over the vertices, w > 0 there; of a shell to max |u| = 1.

    A shape whose half-waves are the elements rests at all vertices, but for rounding: one that
    hardly moves there is scaled by w at the quadrature points.
    """
    at_vertices = plate.at_vertices @ vectors
    peak = _peaks(at_vertices)
    if plate.motion_at_vertices:
        size = np.sqrt(sum((rows @ vectors) ** 2 for rows in plate.motion_at_vertices))
        return vectors / np.where(peak < 0, -size.max(axis=0), size.max(axis=0))
    step = max(1, plate.at_quadrature.shape[0] // (2 * len(at_vertices)))
    inner = np.abs(plate.at_quadrature[::step] @ vectors).max(axis=0, initial=0.0)
    hidden = np.abs(peak) < HIDDEN * inner
    if hidden.any():
        peak[hidden] = _peaks(plate.at_quadrature @ vectors[:, hidden])
    return vectors / peak


def _peaks(w: Array) -> Array:
    """Return of each column the w (n,) of largest |w|.

    A symmetric shape has several with the same |w|: the first of them, to within rounding.
    """
    size = np.abs(w)
    first = np.argmax(size > (1 - 1e-6) * size.max(axis=0), axis=0)
    return np.sign(w[first, np.arange(w.shape[1])]) * size.max(axis=0)


def first_modes(plate: PlateMatrices, count: int) -> tuple[int, Array, Array]:
    """Return the number of rigid-body modes, the first frequencies above [Hz] and their shapes.

    No check that none is missed; `normal_modes` has it. Rigid-body modes count; a small mesh
    may have fewer than ``count``.
    """
    n_free = plate.stiffness.shape[0]
    shift = (2 * np.pi * SHIFT) ** 2
    if n_free > 4 * count:
        solve = factors(plate.stiffness + shift * plate.mass).solve
        eigenvalue, modes = spla.eigsh(
            plate.stiffness,
            k=count,
            M=plate.mass,
            sigma=-shift,
            OPinv=spla.LinearOperator((n_free, n_free), solve),
            v0=np.random.default_rng(0).standard_normal(n_free),
        )
    else:
        eigenvalue, modes = la.eigh(plate.stiffness.toarray(), plate.mass.toarray())
    order = np.argsort(eigenvalue)[:count]
    frequency = np.sqrt(np.maximum(eigenvalue[order], 0.0)) / (2 * np.pi)
    rigid = int(np.sum(frequency < RIGID_SHARE * frequency[-1]))
    return rigid, frequency[rigid:], modes[:, order[rigid:]]
