"""Eigenpairs (K − λM) φ = 0 of sparse matrices, slice by slice of the spectrum.

Each slice has a shift σ in its middle: (K − σM)⁻¹ M has its eigenvalues 1/(λ − σ) far apart there.
Block Lanczos finds them (Grimes, Lewis and Simon 1994): columns are solved for and orthogonalised
together, which takes a tenth of the time of one at a time. One block in three is orthogonal to
those before the last two by the recurrence alone; the next two blocks mend what that loses.
"""

from collections.abc import Iterator

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array
from pidpanel.progress import map_in_forks

BLOCK = 8  # columns at once, more than the multiplicity of any eigenvalue

# Eigenvalues sought from one shift, at most about: 968 of a large wing take 186 CPU-s from four
# shifts and 217 from seven.
SLICE = 250

# Vectors for which memory is kept: those of a slice are up to 2.6 times its eigenvalues.
ROOM = 3 * SLICE

# Share of a block that may lie within earlier ones; above it all blocks are orthogonalised.
# On a wing it is 2e-7, and eigenvalues err by its square: they are the same within 4e-12, in 11.8
# CPU-s in place of 13.8.
LOST = 1e-6

CONVERGED = 1e-9  # residual of an eigenvalue 1/(λ − σ), over that eigenvalue; λ errs by its square


def factors(matrix: sp.sparray) -> spla.SuperLU:
    """Factorise a symmetric matrix in the order of minimum degree, without pivoting."""
    return spla.splu(
        sp.csc_array(matrix),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


def eigenpairs(
    stiffness: sp.csr_array, mass: sp.csr_array, limit: float, count: int
) -> tuple[Array, Array]:
    """Return all eigenpairs below a limit."""
    slices = list(_slices(limit, count))
    parts = list(map_in_forks(lambda part: _near(stiffness, mass, *part), slices))
    values = np.concatenate([eigenvalues for eigenvalues, _ in parts])
    modes = np.empty((stiffness.shape[0], len(values)))
    start = 0
    while parts:  # each is let go once it is copied
        _, vectors = parts.pop(0)
        modes[:, start : start + vectors.shape[1]] = vectors
        start += vectors.shape[1]
    return values, modes


def _slices(limit: float, count: int) -> Iterator[tuple[float, float, float]]:
    """Yield lower end, upper end and shift of each slice below a limit.

    A panel has nearly as many modes below a frequency as in proportion to it. The first shift
    lies below zero, since a panel that can move as a rigid body has λ = 0.
    """
    number = max(1, int(np.ceil(count / SLICE)))
    frequency = np.linspace(0.0, np.sqrt(limit), number + 1)
    edges = frequency**2
    edges[0] = -np.inf
    for index in range(number):
        middle = ((frequency[index] + frequency[index + 1]) / 2) ** 2
        yield edges[index], edges[index + 1], -1e-4 * limit if index == 0 else middle


def _near(
    stiffness: sp.csr_array, mass: sp.csr_array, low: float, high: float, shift: float
) -> tuple[Array, Array]:
    """Return the eigenpairs with low ≤ λ < high by block Lanczos about a shift."""
    size = stiffness.shape[0]
    solve = factors(stiffness - shift * mass).solve
    start = np.random.default_rng(0).standard_normal((size, BLOCK))
    step, mass_step, coupling = _orthonormal(solve(mass @ start), mass)
    basis, mass_basis, projected = (np.empty((rows, 0), order="F") for rows in (size, size, 0))
    count, next_check, sparing = 0, 4 * BLOCK, True
    while True:  # `_orthonormal` refuses more vectors than there are
        if count + BLOCK > basis.shape[1]:
            room = min(size, count + ROOM)
            basis, mass_basis = _wider(basis, room), _wider(mass_basis, room)
            projected = np.pad(projected, (0, room - len(projected)))
        last = slice(count, count + BLOCK)
        basis[:, last], mass_basis[:, last] = step, mass_step
        count += BLOCK
        new = solve(mass_basis[:, last])
        # the recurrence of Lanczos, then the correction of rounding errors
        projected[last, last] = mass_basis[:, last].T @ new
        new -= basis[:, last] @ projected[last, last]
        if count > BLOCK:
            previous = slice(count - 2 * BLOCK, count - BLOCK)
            projected[last, previous], projected[previous, last] = coupling, coupling.T
            new -= basis[:, previous] @ coupling.T
        lost = np.zeros(0)
        if not sparing or count // BLOCK % 3:
            lost = mass_basis[:, :count].T @ new
            new -= basis[:, :count] @ lost
        step, mass_step, coupling = _orthonormal(new, mass)
        if np.abs(lost).max(initial=0.0) > LOST * np.abs(coupling.diagonal()).min():
            sparing = False
        if count < next_check:
            continue
        next_check = int(1.1 * count)
        theta, rotation = la.eigh(projected[:count, :count])
        good = np.linalg.norm(coupling @ rotation[last], axis=0) < CONVERGED * np.abs(theta)
        value = shift + 1 / theta
        inside = np.flatnonzero((value >= low) & (value < high))
        if good.any() and good[inside].all():
            inside = inside[np.argsort(value[inside])]
            return value[inside], basis[:, :count] @ rotation[:, inside]


def _wider(columns: Array, width: int) -> Array:
    """Return the columns with room for more behind them."""
    wider = np.empty((len(columns), width), order="F")
    wider[:, : columns.shape[1]] = columns
    return wider


def _orthonormal(columns: Array, mass: sp.csr_array) -> tuple[Array, Array, Array]:
    """Return columns orthonormal in M, M times these, and the triangle to the given ones."""
    transform = np.eye(columns.shape[1])
    for _ in range(2):
        mass_columns = mass @ columns
        try:
            triangle = la.cholesky(columns.T @ mass_columns)
        except la.LinAlgError:
            raise RuntimeError("the Lanczos iteration ended before all modes were found") from None
        columns, mass_columns = (
            la.solve_triangular(triangle, part.T, trans="T").T for part in (columns, mass_columns)
        )
        transform = triangle @ transform
    return columns, mass_columns, transform
