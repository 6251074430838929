"""Simply supported rectangles in a diffuse field, mode by mode in closed form.

The area mean is Σ_i |ω² H_i|² G_ii (4/A)/(m″² A), since the shapes are orthogonal, and G of
sin(mπx/a) sin(nπy/b) is a mean over directions of products of one-dimensional transforms.
"""

import numpy as np

SPEED = 343.0
HALF = 10**0.05  # of a third octave


def orders(size, wavenumber):
    """(n, 2) half waves of the modes below a wavenumber, and that of each."""
    pairs = np.indices([int(wavenumber * side / np.pi) + 1 for side in size]).reshape(2, -1).T + 1
    kappa = np.hypot(*(np.pi * pairs / size).T)
    return pairs[kappa < wavenumber], kappa[kappa < wavenumber]


def _square(order, side, b):
    """|∫ sin(mπx/a) exp(ibx) dx|² (n, nb)."""
    a = np.pi * order[:, None] / side
    ends = [np.exp(s * 1j * (a + s * b) * side / 2) * np.sinc((a + s * b) * side / 2 / np.pi)
            for s in (1, -1)]  # fmt: skip
    return np.abs(ends[0] - ends[1]) ** 2 * side**2 / 4


def modal_forces(size, pairs, k):
    """G_ii (n,) [m⁴]."""
    reach = k * np.hypot(*size)
    mu, w_mu = np.polynomial.legendre.leggauss(2 * (int(reach / 4) + 30))
    alpha, w_alpha = np.polynomial.legendre.leggauss(int(reach / 2) + 40)
    half = len(mu) // 2
    radial = k * np.sqrt(1 - mu[half:] ** 2)[:, None]
    alpha = np.pi / 4 * (1 + alpha)
    weight = (w_mu[half:, None] * w_alpha / 2).ravel()
    parts = []
    for axis, along in enumerate((np.cos(alpha), np.sin(alpha))):
        numbers = np.arange(1, pairs[:, axis].max() + 1)
        parts.append(_square(numbers, size[axis], (radial * along).ravel()))
    table = parts[0] * weight @ parts[1].T
    return table[pairs[:, 0] - 1, pairs[:, 1] - 1]


def band_mean(size, mass, frequency_of, loss, centre, kappa):
    """Mean of S_a/S_p over a third octave, of modes to 1.7 times the wavenumber there.

    ``frequency_of`` gives the natural frequencies [Hz] of orders (n, 2), ``loss`` is η = 2ζ.
    """
    pairs, _ = orders(size, 1.7 * kappa + 8)
    natural, area = frequency_of(pairs), np.prod(size)
    f = np.linspace(centre / HALF, centre * HALF, 201)[1::2]
    nodes = centre * np.array([1 / HALF, 1, HALF])
    force = np.array([modal_forces(size, pairs, 2 * np.pi * x / SPEED) for x in nodes])
    quadratic = np.linalg.inv(np.vander(nodes / centre, 3)).T
    force = np.vander(f / centre, 3) @ quadratic.T @ force
    square = f[:, None] ** 4 / ((natural**2 - f[:, None] ** 2) ** 2
                                + (loss * natural * f[:, None]) ** 2)  # fmt: skip
    return np.mean(np.sum(force * square, axis=1)) * 4 / (area * mass) ** 2


def modes_in_band(size, frequency_of, centre, kappa):
    """(n,) orders of the modes in a third octave."""
    pairs, _ = orders(size, 1.7 * kappa + 8)
    natural = frequency_of(pairs)
    return pairs[(natural > centre / HALF) & (natural < centre * HALF)]
