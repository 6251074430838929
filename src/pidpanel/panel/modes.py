"""Modes of the panel, and the shapes that dampers need beside them.

A strong or heavy patch moves the panel in shapes that are no sum of the modes below some
frequency:

- the many modes above it respond statically: their response to the forces of the patches is
  spanned by the residual vectors K⁻¹ D_patch Φ;
- with a mass on a patch waves are shorter there: m″ + m_a in place of m″. These shapes are the
  modes of the loaded panel, with the heaviest damper of each patch attached, all at once.

Measured on the paper's panel, C_e = 2000 N s/m³, up to 1000 Hz, largest error of the PSD of three
points against all elements, at seven lines (this module: at twelve):

=============================================  ======================  ===================
shapes beside the modes below 2 kHz            0.2 × 0.2, 150 kg/m²    1.4 × 0.9, 30 kg/m²
=============================================  ======================  ===================
residual vectors                               1.2 %                   270 %
modes of the loaded panel below 1.5 kHz        0.25 %                  0.8 %
both (this module)                             0.3 %                   0.6 %
=============================================  ======================  ===================

Masses between none and the heaviest, and single patches of several, are no worse; 150 kg/m² on
the whole panel leaves 2.4 %. What is left is found and mended in the response (`basis_error`).
Cleared of the modes and diagonalised among themselves, these shapes join the modes in one basis
in which M and K are diagonal.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array, Flags, Index
from pidpanel.panel.eigen import eigenpairs, factors
from pidpanel.panel.plate import AssembledPlate

# Modes are kept up to this times the highest frequency asked for; residual vectors do the rest.
MODES_BEYOND = 2.0
# A stiff panel may have no mode below that: it then responds as the first modes above, all but
# statically.
LEAST_MODES = 12
# A panel of more coordinates than these is solved slice by slice of its frequencies.
LARGE = 20_000
# Modes requested beyond those counted, so that the last ones counted converge quickly.
SPARE_MODES = 8
# The shift of the eigenvalue problem lies below zero by the square of this share of the highest
# frequency, so that a panel that can move as a rigid body has no singular matrix.
SHIFT = 0.01
# A force of a patch is dropped where it is smaller than this share of the largest: far below the
# tolerances of residual vectors.
FORCES = 1e-8
# Modes of the loaded panel are kept up to this times the highest frequency asked for.
LOADED_BEYOND = 1.5
# A direction of these modes is dropped where the share of its elastic energy that the other
# shapes leave is below the square of this.
LOADED_TOLERANCE = 1e-4
# A mode whose elastic energy is this small a share of what its terms add up to, signs left out,
# is a rigid body's: what is left is rounding. A fine mesh in a corner makes it 1e-8 for others.
RIGID = 1e-12
# A plate has at most three rigid modes; they are looked for among so many of the lowest.
MOST_RIGID = 16
# Columns of which the energies are computed together, so that no copy of all is made.
COLUMNS_AT_ONCE = 64
# A shape whose w at the vertices is below this share of that between them is not seen by them.
HIDDEN = 0.1
# Of the elastic energy of a static answer: what the modes leave below it is rounding.
ROUNDING = 1e-16


class Matrices(Protocol):
    """Of a plate, as much as its modes need; see `AssembledPlate`."""

    @property
    def stiffness(self) -> sp.csr_array:
        """(n, n) K."""

    @property
    def mass(self) -> sp.csr_array:
        """(n, n) M."""

    @property
    def at_vertices(self) -> sp.csr_array:
        """(n_vertices, n) w at the vertices."""

    @property
    def at_quadrature(self) -> sp.csr_array:
        """(n_quadrature, n) w at the quadrature points."""


class Plate(Matrices, Protocol):
    """A plate with all that its basis needs; see `AssembledPlate`."""

    @property
    def patch_overlap(self) -> dict[str, sp.csr_array]:
        """(n, n) D of each patch."""

    @property
    def curvature_at_vertices(self) -> tuple[sp.csr_array, ...]:
        """Three matrices (n_vertices, n)."""

    @property
    def shear_at_vertices(self) -> tuple[sp.csr_array, ...]:
        """Two matrices (n_vertices, n)."""

    @property
    def quadrature_position(self) -> Array:
        """(n_quadrature, 2) [m]."""

    @property
    def quadrature_weight(self) -> Array:
        """(n_quadrature,) [m²]."""


@dataclass(frozen=True)
class Loaded:
    """Matrices of a plate with mass on its patches; see `Matrices`."""

    stiffness: sp.csr_array
    mass: sp.csr_array
    at_vertices: sp.csr_array
    at_quadrature: sp.csr_array


@dataclass(frozen=True)
class Shapes:
    """Modes and the shapes that dampers need beside them, in the free coordinates.

    Attributes
    ----------
    frequency
        (n_modes,) of the modes [Hz], ascending.
    residual_frequency
        (n_residual,) of the others [Hz], ascending.
    vectors
        (n_free, n_modes + n_residual) max |w| = 1 over the vertices, or at the quadrature points
        where the vertices rest; M and K are diagonal.
    """

    frequency: Array
    residual_frequency: Array
    vectors: Array

    @property
    def modes(self) -> Array:
        """(n_free, n_modes)."""
        return self.vectors[:, : len(self.frequency)]

    @property
    def residuals(self) -> Array:
        """(n_free, n_residual)."""
        return self.vectors[:, len(self.frequency) :]

    def joined_by(self, plate: Plate, more: Array) -> "Shapes":
        """Return the shapes with what further shapes (n_free, n_more), of any size, add to them.

        What modes and residual vectors span already is dropped; the rest and the residual vectors
        are diagonalised in M and K among themselves.
        """
        K, M = plate.stiffness, plate.mass
        modes, residuals = self.modes, self.residuals
        modal_mass = _squares(M, modes)
        unit = residuals / np.sqrt(np.einsum("ki,ki->i", residuals, K @ residuals))
        rest = more[:, ~_is_rigid(plate, more)]
        rest = rest / np.sqrt(np.einsum("ki,ki->i", rest, K @ rest))
        for _ in range(2):  # twice, as in `residual_vectors`
            rest = rest - modes @ ((modes.T @ (M @ rest)) / modal_mass[:, None])
            rest = rest - unit @ (unit.T @ (K @ rest))
        energy, V = la.eigh(rest.T @ (K @ rest))
        kept = energy > LOADED_TOLERANCE**2
        Q = np.hstack([unit, rest @ (V[:, kept] / np.sqrt(energy[kept]))])
        eigenvalue, rotation = la.eigh(Q.T @ (K @ Q), Q.T @ (M @ Q))
        vectors = np.hstack([modes, _normalise(plate, Q @ rotation)])
        return Shapes(self.frequency, np.sqrt(eigenvalue) / (2 * np.pi), vectors)


def panel_shapes(
    plate: AssembledPlate,
    frequency_limit: float,
    residual_tolerance: float = 1e-4,
    damper_mass: Mapping[str, float] | None = None,
) -> Shapes:
    """Compute the modes below a frequency and the shapes that the patches of the plate need.

    Parameters
    ----------
    plate
        The supported plate.
    frequency_limit
        All modes below this frequency [Hz] are kept, and at least `LEAST_MODES`: twice the
        highest frequency of the analysis leaves PSDs within 0.5 %.
    residual_tolerance
        Which residual vectors to keep, see `residual_vectors`. With 1e-4 each patch of 4 × 4
        elements brings about 20; 1 keeps none.
    damper_mass
        Heaviest damper of each patch by name [kg/m²]; patches without one carry no mass. Modes of
        the panel with all of them are kept below `LOADED_BEYOND` / `MODES_BEYOND` times
        `frequency_limit`.

    Raises
    ------
    ValueError
        If `frequency_limit` is not positive, or `residual_tolerance` is negative.
    RuntimeError
        If the modes found are not as many as Sylvester's count.
    """
    frequency, modes = normal_modes(plate, frequency_limit, LEAST_MODES)
    residual_frequency, residuals = residual_vectors(plate, modes, residual_tolerance)
    shapes = Shapes(frequency, residual_frequency, np.hstack([modes, residuals]))
    del modes
    mass = {name: value for name, value in (damper_mass or {}).items() if value > 0}
    if not mass:
        return shapes
    limit = frequency_limit * LOADED_BEYOND / MODES_BEYOND
    return shapes.joined_by(plate, loaded_modes(plate, mass, limit))


def count_modes_below(plate: Matrices, frequency: float) -> int:
    """Count the modes below a frequency without computing them.

    By Sylvester's law of inertia, the eigenvalues of (K, M) below (2πf)² are as many as the
    negative pivots of K − (2πf)² M, if rows and columns are permuted alike.

    Parameters
    ----------
    plate
        The supported plate.
    frequency
        Frequency [Hz]; not itself an eigenfrequency.

    Returns
    -------
    int

    Raises
    ------
    RuntimeError
        If the factorisation had to permute rows and columns differently, because a pivot
        vanished: `frequency` hits an eigenfrequency of the plate or of a part of it.
    """
    shifted = plate.stiffness - (2 * np.pi * frequency) ** 2 * plate.mass
    # Units of the free coordinates differ (w, w_x, w_xy); a symmetric scaling keeps the inertia.
    scale = sp.diags_array(1 / np.sqrt(plate.stiffness.diagonal()))
    found = factors(scale @ shifted @ scale)
    if not np.array_equal(found.perm_r, found.perm_c):
        raise RuntimeError(
            f"modes below {frequency:g} Hz cannot be counted: a pivot vanished there; change the"
            " frequency by a little"
        )
    return int(np.sum(found.U.diagonal() < 0))


def normal_modes(plate: Matrices, frequency_limit: float, at_least: int = 0) -> tuple[Array, Array]:
    """Compute all modes below a frequency, (K − (2πf_i)² M) φ_i = 0, rigid-body modes first.

    Shift-invert Lanczos from fixed vectors (of a large panel by blocks, `pidpanel.panel.eigen`), so
    that the same plate always gives the same modes, also where two frequencies coincide; none is
    missed, by Sylvester's count. A mesh with hardly more coordinates than modes is solved whole.

    Parameters
    ----------
    plate
        The supported plate.
    frequency_limit
        [Hz].
    at_least
        So many modes, also where fewer lie below the limit; of a small mesh, all that it has.

    Returns
    -------
    frequency
        (n,) [Hz], ascending.
    modes
        (n_free, n) normalised to max |w| = 1 over the vertices.

    Raises
    ------
    ValueError
        If `frequency_limit` is not positive.
    RuntimeError
        If the modes found are not as many as Sylvester's count.
    """
    if not frequency_limit > 0:
        raise ValueError(f"frequency_limit is {frequency_limit:g} Hz; it must be positive")
    count = count_modes_below(plate, frequency_limit)
    n_free = plate.stiffness.shape[0]
    wanted = max(count, at_least) + SPARE_MODES
    if count >= at_least and n_free > LARGE:
        eigenvalue, modes = eigenpairs(
            plate.stiffness, plate.mass, (2 * np.pi * frequency_limit) ** 2, count
        )
    elif 3 * wanted < n_free:
        shift = (2 * np.pi * SHIFT * frequency_limit) ** 2
        eigenvalue, modes = spla.eigsh(
            plate.stiffness,
            k=wanted,
            M=plate.mass,
            sigma=-shift,
            OPinv=spla.LinearOperator(
                plate.stiffness.shape, factors(plate.stiffness + shift * plate.mass).solve
            ),
            v0=np.random.default_rng(0).standard_normal(n_free),
            # a Krylov space this wide finds both modes of a pair before it stops
            ncv=3 * wanted,
        )
    else:
        eigenvalue, modes = la.eigh(plate.stiffness.toarray(), plate.mass.toarray())
    order = np.argsort(eigenvalue)
    if np.any(np.diff(order) < 0):  # those of slices are in order, and many
        eigenvalue, modes = eigenvalue[order], modes[:, order]
    lowest = slice(MOST_RIGID)
    eigenvalue[lowest][_is_rigid(plate, modes[:, lowest])] = 0.0
    frequency = np.sqrt(eigenvalue) / (2 * np.pi)
    found = int(np.sum(frequency < frequency_limit))
    if found != count:
        raise RuntimeError(
            f"{found} modes were found below {frequency_limit:g} Hz, where"
            f" {count} exist by Sylvester's count"
        )
    kept = slice(max(count, at_least))
    return frequency[kept], _normalise(plate, modes[:, kept])


def _is_rigid(plate: Matrices, modes: Array) -> Flags:
    """Return whether the elastic energy of each mode is rounding error only."""
    return _squares(plate.stiffness, modes) < RIGID * _squares(abs(plate.stiffness), abs(modes))


def _squares(matrix: sp.csr_array, vectors: Array) -> Array:
    """Return vᵀ A v (n,) of columns (n_free, n)."""
    found = np.empty(vectors.shape[1])
    for start in range(0, found.size, COLUMNS_AT_ONCE):
        some = slice(start, start + COLUMNS_AT_ONCE)
        found[some] = np.einsum("ki,ki->i", vectors[:, some], matrix @ vectors[:, some])
    return found


def residual_vectors(plate: AssembledPlate, modes: Array, tolerance: float) -> tuple[Array, Array]:
    """Compute the static response to the forces of the patches that the modes lack.

    X = K⁻¹ [D₁Φ, D₂Φ, …] is made M-orthogonal to the modes (and with that K-orthogonal),
    reduced to its strongest directions in elastic energy and diagonalised in M and K. Where the
    panel can move as a rigid body, K + (2πf)² M takes the place of the singular K, with f its
    first frequency above 0 Hz.

    Parameters
    ----------
    plate
        The supported plate.
    modes
        (n_free, n_modes) normal modes Φ, M-orthogonal.
    tolerance
        A direction is dropped if its singular value, in the norm of elastic energy, is not
        above this fraction of the largest. 0 drops only what rounding made; 1 drops all.

    Returns
    -------
    frequency
        (n_residual,) [Hz], ascending.
    residuals
        (n_free, n_residual) normalised to max |w| = 1 over the vertices. Empty if the panel has no
        patches.

    Raises
    ------
    ValueError
        If `tolerance` is negative.
    """
    if tolerance < 0:
        raise ValueError(f"residual tolerance is {tolerance:g}; it must not be negative")
    n_free = plate.stiffness.shape[0]
    if not plate.patch_overlap:
        return np.zeros(0), np.zeros((n_free, 0))
    forces = np.hstack([_forces(overlap, modes) for overlap in plate.patch_overlap.values()])
    modal_mass = _squares(plate.mass, modes)
    invertible = plate.stiffness
    lowest = modes[:, : MOST_RIGID + 1]
    if (rigid := _is_rigid(plate, lowest)).any():
        elastic = lowest[:, ~rigid][:, :1]
        first = (elastic.T @ (plate.stiffness @ elastic)) / (elastic.T @ (plate.mass @ elastic))
        invertible = invertible + first.item() * plate.mass
    static = factors(invertible).solve(forces)
    whole = np.einsum("ki,ki->i", static, plate.stiffness @ static).max(initial=0.0)

    # twice: one pass of Gram-Schmidt leaves cancellation errors where X is nearly all modes
    for _ in range(2):
        static -= modes @ ((modes.T @ (plate.mass @ static)) / modal_mass[:, None])

    # X = Q diag(s) Vᵀ in the energy norm, from the Gram matrix Xᵀ K X = V diag(s²) Vᵀ
    energy, V = la.eigh(static.T @ (plate.stiffness @ static))
    # Rounding of the Gram matrix leaves about 1e-16 of the largest s² in every other.
    # Of a patch on the whole panel it is all: its forces are the modes' own.
    kept = energy > max(tolerance**2 * energy[-1], 1e-13 * energy[-1], ROUNDING * whole)
    Q = static @ (V[:, kept] / np.sqrt(energy[kept]))

    eigenvalue, rotation = la.eigh(Q.T @ (plate.stiffness @ Q), Q.T @ (plate.mass @ Q))
    return np.sqrt(eigenvalue) / (2 * np.pi), _normalise(plate, Q @ rotation)


def on_patch(overlap: sp.csr_array, vectors: Array) -> tuple[Index, sp.csr_array, Array]:
    """Return the coordinates (k,) of a patch, few of a large panel, and D and vectors there.

    Parameters
    ----------
    overlap
        (n_free, n_free) D.
    vectors
        (n_free, n); they come back in double precision.
    """
    rows: Index = np.unique(overlap.nonzero()[0])
    return rows, overlap[rows][:, rows], vectors[rows].astype(np.float64)


def _forces(overlap: sp.csr_array, modes: Array) -> Array:
    """Return the forces D Φ of a patch on the modes, (n_free, n), as few as there are.

    D Φ = U diag(s) Vᵀ; what follows does not ask for V. A patch is small beside most waves, so that
    many forces are nearly sums of others.
    """
    on, D, few = on_patch(overlap, modes)
    U, s, _ = la.svd(D @ few, full_matrices=False)
    kept = s > FORCES * s[:1]
    forces = np.zeros((len(modes), int(kept.sum())))
    forces[on] = U[:, kept] * s[kept]
    return forces


def loaded_modes(plate: Plate, damper_mass: Mapping[str, float], frequency_limit: float) -> Array:
    """Return the modes (n_free, n) below a frequency of the panel with mass on its patches.

    Parameters
    ----------
    plate
        The supported plate.
    damper_mass
        By the name of the patch [kg/m²].
    frequency_limit
        [Hz].
    """
    mass = plate.mass
    for name, value in damper_mass.items():
        mass = mass + value * plate.patch_overlap[name]
    heavy = Loaded(plate.stiffness, sp.csr_array(mass), plate.at_vertices, plate.at_quadrature)
    return normal_modes(heavy, frequency_limit)[1]


def _normalise(plate: Matrices, vectors: Array) -> Array:
    """Scale each column to max |w| = 1 over the vertices, w > 0 there.

    A shape whose half-waves are the elements rests at all vertices, but for rounding: one that
    hardly moves there is scaled by w at the quadrature points.
    """
    at_vertices = plate.at_vertices @ vectors
    peak = _peaks(at_vertices)
    step = max(1, plate.at_quadrature.shape[0] // (2 * len(at_vertices)))
    between = np.abs(plate.at_quadrature[::step] @ vectors).max(axis=0, initial=0.0)
    hidden = np.abs(peak) < HIDDEN * between
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
