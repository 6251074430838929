"""Closed forms of Navier for the simply supported rectangle, and mode orders by comparison.

The shapes are products of sines, φ_mn = sin(mπx/a) sin(nπy/b), with the wave number
k² = (mπ/a)² + (nπ/b)².
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from pidpanel.arrays import Array, Index
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.section import ShearSection, ThinSection


def thin_plate_frequency(
    m: ArrayLike, n: ArrayLike, size: tuple[float, float], section: ThinSection
) -> Array:
    """Return the natural frequency of a thin rectangle [Hz], ω² = D k⁴ / m″.

    ``m``, ``n`` are half waves along the edges ``size`` [m].

    Examples
    --------
    The first two rows of Table 1 of the paper:

    >>> thin_plate_frequency([1, 2], [1, 1], (1.5, 1.0), ThinSection(3273.07, 4.0)).round(2)
    array([ 64.9 , 124.81])
    """
    k2 = (np.asarray(m) * np.pi / size[0]) ** 2 + (np.asarray(n) * np.pi / size[1]) ** 2
    return np.sqrt(section.bending_stiffness * k2**2 / section.mass_per_area) / (2 * np.pi)


def shear_plate_frequency(
    m: ArrayLike, n: ArrayLike, size: tuple[float, float], section: ShearSection
) -> Array:
    """Return the first natural frequency [Hz] of each order of a rectangle with transverse shear.

    Hard simple support. With w = W sin(px) sin(qy), b_x = X cos(px) sin(qy) and b_y = Y sin(px)
    cos(qy), p = mπ/a and q = nπ/b, the equations of motion are a 3 × 3 eigenproblem K (W, X, Y) =
    ω² M (W, X, Y) with M = diag(m″, I, I) and I the rotary inertia (Whitney and Pagano, J. Appl.
    Mech. 37, 1970). There is no closed form, and a `ValueError`, unless D_16, D_26 and S_12 are
    zero.
    """
    D, S = section.bending, section.shear
    if not is_aligned(section):
        raise ValueError(
            "bending and twist or both shears couple; allowed is D_16 = D_26 = S_12 = 0"
        )
    m, n = np.broadcast_arrays(m, n)
    mass = np.array([section.mass_per_area, section.rotary_inertia, section.rotary_inertia])
    frequency = np.empty(m.shape)
    for index in np.ndindex(m.shape):
        p, q = m[index] * np.pi / size[0], n[index] * np.pi / size[1]
        twist = (D[0, 1] + D[2, 2]) * p * q
        K = np.array(
            [
                [S[0, 0] * p**2 + S[1, 1] * q**2, -S[0, 0] * p, -S[1, 1] * q],
                [-S[0, 0] * p, D[0, 0] * p**2 + D[2, 2] * q**2 + S[0, 0], twist],
                [-S[1, 1] * q, twist, D[2, 2] * p**2 + D[1, 1] * q**2 + S[1, 1]],
            ]
        )
        lowest = np.linalg.eigvalsh(K / np.sqrt(np.outer(mass, mass)))[0]
        frequency[index] = np.sqrt(lowest) / (2 * np.pi)
    return frequency


def is_aligned(section: ShearSection) -> bool:
    """Return whether bending does not couple to twist, nor one shear to the other."""
    D, S = section.bending, section.shear
    return bool(np.abs(D[:2, 2]).max() < 1e-9 * D.max() and abs(S[0, 1]) < 1e-9 * S.max())


def sine_shapes(m: ArrayLike, n: ArrayLike, size: tuple[float, float], position: Array) -> Array:
    """Return the shapes sin(mπx/a) sin(nπy/b) at positions (n_positions, 2) [m]."""
    along_x, along_y = (
        np.sin(np.arange(np.max(order) + 1) * np.pi * x / edge)
        for order, x, edge in zip((m, n), np.hsplit(position, 2), size, strict=True)
    )
    return along_x[:, np.asarray(m)] * along_y[:, np.asarray(n)]


def mode_orders(
    basis: PanelBasis, size: tuple[float, float], pair_tolerance: float = 2e-3
) -> tuple[Index, Array]:
    """Assign each computed mode of a rectangle the order (m, n) of its sine.

    Modes of one frequency, such as (3, 4) and (6, 2) of the paper's panel, are computed as an
    arbitrary basis of their common subspace. So modes whose frequencies (nearly) coincide are
    compared as subspaces: together they get the sines that lie most in their span, and each of them
    the one that it resembles most. Returns (n_modes, 2) orders and the share (n_modes,) of ∫ sine²
    dA in the subspace: a low share means that the panel is no such rectangle.
    """
    modes = ~basis.is_residual
    frequency = basis.natural_frequency[modes]
    root_weight = np.sqrt(basis.quadrature_weight)[:, None]
    shapes = root_weight * basis.shape_at_quadrature[:, modes]

    # All (m' ≤ m, n' ≤ n) lie below (m, n), so the i-th mode has m n ≤ i.
    n_modes = len(frequency)
    m, n = np.array([(m, n) for m in range(1, n_modes + 1) for n in range(1, n_modes // m + 1)]).T
    sines = root_weight * sine_shapes(m, n, size, basis.quadrature_position)
    sines /= np.linalg.norm(sines, axis=0)
    products = shapes.T @ sines

    orders = np.zeros((n_modes, 2), dtype=np.int64)
    share = np.zeros(n_modes)
    gaps = np.flatnonzero(np.diff(frequency) > pair_tolerance * frequency[1:]) + 1
    for members in np.split(np.arange(n_modes), gaps):
        triangle = np.linalg.qr(shapes[:, members]).R
        in_subspace = np.sum(np.linalg.solve(triangle.T, products[members]) ** 2, axis=0)
        chosen = np.sort(np.argsort(in_subspace)[-len(members) :])
        projection = products[members][:, chosen] ** 2 / np.sum(triangle**2, axis=0)[:, None]
        _, sine = linear_sum_assignment(projection, maximize=True)
        orders[members] = np.column_stack([m, n])[chosen[sine]]
        share[members] = in_subspace[chosen[sine]]
    return orders, share
