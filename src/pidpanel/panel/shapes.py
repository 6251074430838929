"""Modes of the panel, and further shapes that dampers need.

A strong or heavy patch moves the panel in shapes that are no sum of the modes below some
frequency:

- the many modes above it respond statically: their response to the forces of the patches is
  spanned by the residual vectors K⁻¹ D_patch Φ;
- with a mass on a patch waves are shorter there: m″ + m_a in place of m″. These shapes are the
  modes of the loaded panel, with the heaviest damper of each patch attached, all at once.

Measured on the paper's panel, C_e = 2000 N s/m³, up to 1000 Hz, largest error of the PSD of three
points against all elements, at seven lines (this module: at twelve):

=============================================  ======================  ===================
shapes besides the modes below 2 kHz           0.2 × 0.2, 150 kg/m²    1.4 × 0.9, 30 kg/m²
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

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.arrays import Array, Index
from pidpanel.panel.eigen import factors
from pidpanel.panel.matrices import PlateMatrices
from pidpanel.panel.modes import (
    MOST_RIGID,
    is_rigid,
    loaded_modes,
    normal_modes,
    normalise,
    quadratic_form,
)
from pidpanel.panel.plate import AssembledPlate
from pidpanel.progress import map_in_forks

# Modes are kept up to this times the highest frequency; residual vectors replace the rest.
MODES_BEYOND = 2.0
# A stiff panel may have no mode below that: it then responds as the first modes above, all but
# statically.
LEAST_MODES = 12
# Dampers that weigh more than the panel, over the modes, take its resonances from bare modes far
# above: those are kept too, up to a number that costs little, and keep their damping ratio.
HEAVY, MOST_MODES = 1.0, 150
# A force of a patch is dropped where it is smaller than this share of the largest: far below the
# tolerances of residual vectors.
FORCES = 1e-8
# Modes of the loaded panel are kept up to this times the highest frequency.
LOADED_BEYOND = 1.5
# A direction of these modes is dropped where the share of its elastic energy that the other
# shapes leave is below the square of this.
LOADED_TOLERANCE = 1e-4
# Share of the elastic energy of a static response below which the remainder is rounding.
ROUNDING = 1e-16


@dataclass(frozen=True)
class Shapes:
    """Modes and further shapes that dampers need, in the free coordinates."""

    frequency: Array  # (n_modes,) of the modes [Hz], ascending
    residual_frequency: Array  # (n_residual,) of the others [Hz], ascending
    # (n_free, n_modes + n_residual) max |w| = 1 over the vertices, or at the quadrature points
    # where the vertices rest; M and K are diagonal
    vectors: Array

    @property
    def modes(self) -> Array:
        """(n_free, n_modes)."""
        return self.vectors[:, : len(self.frequency)]

    @property
    def residuals(self) -> Array:
        """(n_free, n_residual)."""
        return self.vectors[:, len(self.frequency) :]

    def joined_by(self, plate: PlateMatrices, further: Array) -> "Shapes":
        """Return the shapes with what further shapes (n_free, n_more), of any size, add to them.

        What modes and residual vectors span already is dropped; the rest and the residual vectors
        are diagonalised in M and K among themselves.
        """
        K, M = plate.stiffness, plate.mass
        modes, residuals = self.modes, self.residuals
        modal_mass = quadratic_form(M, modes)
        unit = residuals / np.sqrt(np.einsum("ki,ki->i", residuals, K @ residuals))
        elastic = further[:, ~is_rigid(plate, further)]
        elastic = elastic / np.sqrt(np.einsum("ki,ki->i", elastic, K @ elastic))
        for _ in range(2):  # twice, as in `residual_vectors`
            elastic = elastic - modes @ ((modes.T @ (M @ elastic)) / modal_mass[:, None])
            elastic = elastic - unit @ (unit.T @ (K @ elastic))
        energy, V = la.eigh(elastic.T @ (K @ elastic))
        significant = energy > LOADED_TOLERANCE**2
        Q = np.hstack([unit, elastic @ (V[:, significant] / np.sqrt(energy[significant]))])
        eigenvalue, rotation = la.eigh(Q.T @ (K @ Q), Q.T @ (M @ Q))
        vectors = np.hstack([modes, normalise(plate, Q @ rotation)])
        return Shapes(self.frequency, np.sqrt(eigenvalue) / (2 * np.pi), vectors)


def panel_shapes(
    plate: AssembledPlate,
    frequency_limit: float,
    residual_tolerance: float = 1e-4,
    damper_mass: Mapping[str, float] | None = None,
) -> Shapes:
    """Compute the modes below a frequency [Hz] and the shapes that the patches of the plate need.

    Parameters
    ----------
    frequency_limit
        All modes below are kept, and at least `LEAST_MODES`: twice the highest frequency of the
        analysis leaves PSDs within 0.5 %.
    residual_tolerance
        See `residual_vectors`. With 1e-4 each patch of 4 × 4 elements brings about 20; 1 keeps
        none.
    damper_mass
        Heaviest damper of each patch by name [kg/m²]. Modes of the panel with all of them are kept
        below `LOADED_BEYOND` / `MODES_BEYOND` times `frequency_limit`. Where they weigh more than
        the panel, modes of the bare panel are kept up to √(1 + m_a/m″) times `frequency_limit`.

    Raises
    ------
    RuntimeError
        If the modes found are not as many as Sylvester's count.
    """
    mass = {name: value for name, value in (damper_mass or {}).items() if value > 0}
    loaded_limit = frequency_limit * LOADED_BEYOND / MODES_BEYOND

    def modes_of(is_loaded: bool) -> tuple[Array, Array]:
        if is_loaded:
            return loaded_modes(plate, mass, loaded_limit)
        return normal_modes(plate, frequency_limit, LEAST_MODES)

    (frequency, modes), *loaded = map_in_forks(modes_of, [False, True] if mass else [False])
    added = sum(
        value * quadratic_form(plate.patch_overlap[name], modes[:, :LEAST_MODES])
        for name, value in mass.items()
    )
    heavier = float(np.mean(added / quadratic_form(plate.mass, modes[:, :LEAST_MODES])))
    further = min(np.sqrt(1 + heavier), MOST_MODES / len(frequency))
    if heavier > HEAVY and further > 1:
        frequency, modes = normal_modes(plate, frequency_limit * further, LEAST_MODES)
    residual_frequency, residuals = residual_vectors(plate, modes, residual_tolerance)
    shapes = Shapes(frequency, residual_frequency, np.hstack([modes, residuals]))
    del modes
    return shapes.joined_by(plate, loaded[0][1]) if loaded else shapes


def residual_vectors(
    plate: PlateMatrices, modes: Array, tolerance: float, most_forces: int | None = None
) -> tuple[Array, Array]:
    """Compute the static response to the forces of the patches that the modes lack.

    X = K⁻¹ [D₁Φ, D₂Φ, …] is made M-orthogonal to the modes (and with that K-orthogonal), reduced to
    its strongest directions in elastic energy and diagonalised in M and K. Where the panel can move
    as a rigid body, K + (2πf)² M takes the place of the singular K, with f its first frequency
    above 0 Hz. A direction is dropped if its singular value, in the norm of elastic energy, is not
    above ``tolerance`` of the largest: 0 drops only what rounding made, 1 drops all. Each patch has
    at most ``most_forces``, its strongest; None for all. Frequencies (n_residual,) [Hz] ascend;
    vectors (n_free, n_residual) have max |w| = 1.
    """
    n_free = plate.stiffness.shape[0]
    if not plate.patch_overlap:
        return np.zeros(0), np.zeros((n_free, 0))
    forces = np.hstack(
        [_forces(overlap, modes)[:, :most_forces] for overlap in plate.patch_overlap.values()]
    )
    modal_mass = quadratic_form(plate.mass, modes)
    invertible = plate.stiffness
    lowest = modes[:, : MOST_RIGID + 1]
    if (rigid := is_rigid(plate, lowest)).any():
        elastic = lowest[:, ~rigid][:, :1]
        first = (elastic.T @ (plate.stiffness @ elastic)) / (elastic.T @ (plate.mass @ elastic))
        invertible = invertible + first.item() * plate.mass
    static = factors(invertible).solve(forces)
    work = np.einsum("ki,ki->i", static, plate.stiffness @ static).max(initial=0.0)

    # twice: one pass of Gram-Schmidt leaves cancellation errors where X is nearly all modes
    for _ in range(2):
        static -= modes @ ((modes.T @ (plate.mass @ static)) / modal_mass[:, None])

    # X = Q diag(s) Vᵀ in the energy norm, from the Gram matrix Xᵀ K X = V diag(s²) Vᵀ
    energy, V = la.eigh(static.T @ (plate.stiffness @ static))
    # Rounding of the Gram matrix leaves about 1e-16 of the largest s² in every other.
    # Of a patch on the whole panel it is all: its forces are the modes' own.
    significant = energy > max(tolerance**2 * energy[-1], 1e-13 * energy[-1], ROUNDING * work)
    Q = static @ (V[:, significant] / np.sqrt(energy[significant]))

    eigenvalue, rotation = la.eigh(Q.T @ (plate.stiffness @ Q), Q.T @ (plate.mass @ Q))
    return np.sqrt(eigenvalue) / (2 * np.pi), normalise(plate, Q @ rotation)


def on_patch(overlap: sp.csr_array, vectors: Array) -> tuple[Index, sp.csr_array, Array]:
    """Return the coordinates (k,) of a patch, few of a large panel, and D and vectors there."""
    rows: Index = np.unique(overlap.nonzero()[0])
    return rows, overlap[rows][:, rows], vectors[rows].astype(np.float64)


def _forces(overlap: sp.csr_array, modes: Array) -> Array:
    """Return the forces D Φ of a patch on the modes, (n_free, n), as few as there are.

    D Φ = U diag(s) Vᵀ; what follows does not ask for V. A patch is small beside most waves, so that
    many forces are nearly sums of others.
    """
    dofs, D, vectors = on_patch(overlap, modes)
    U, s, _ = la.svd(D @ vectors, full_matrices=False)
    significant = s > FORCES * s[:1]
    forces = np.zeros((len(modes), int(significant.sum())))
    forces[dofs] = U[:, significant] * s[significant]
    return forces
