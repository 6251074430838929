"""Modal forces as a record: a sum of tones with the cross-PSDs of an excitation.

Phases are drawn, sizes are not: over its period a record then has the mean square that the field
has on average, in each resonance. With drawn sizes too, the rms velocity of a patch with a fill of
0.1 scatters by 20 % in records of 1.6 s.
"""

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.excitation import Excitation

# Spacing of the nodes of G over 1/L in wavenumber, L the diameter of the panel: linear between
# them, G errs by (0.2)²/24 = 0.2 % of its largest value.
NODE_SPACING = 0.2

# Largest relative spacing of the nodes: G ∝ k^p errs by p (p − 1)/8 of its square.
NODE_RATIO = 0.05

FLOOR = 1e-3  # least √G_ii over the largest to which a shape's own force is resolved [1]

# Added to the diagonal of G over √(G_ii G_jj), which is not of full rank where waves are long:
# far below the 0.2 % of the nodes.
RIDGE = 1e-6


def force_nodes(low: float, high: float, wave_speed: float, diameter: float) -> Array:
    """Return frequencies between which G is taken as linear, from ``low`` to ``high`` [Hz]."""
    widest = NODE_SPACING * wave_speed / (2 * np.pi * diameter)
    nodes = [low]
    while nodes[-1] < high:
        nodes.append(nodes[-1] + min(widest, NODE_RATIO * nodes[-1]))
    nodes[-1] = high
    return np.array(nodes)


def draw_modal_force(
    frequency: Array, excitation: Excitation, nodes: Array, rng: np.random.Generator
) -> Complexes:
    """Draw the amplitudes of tones whose modal forces have the PSDs S_p G.

    f(t) = Re Σ_j X_j exp(iω_j t), X_j = √(2 S_p(f_j) Δf) L(f_j) ξ_j with G = L Lᴴ and ξ of random
    phases and size 1, so that E[X_j X_jᴴ] = 2 S_p G Δf. L is that of the excitation, or linear
    between nodes.
    """
    step = float(frequency[1] - frequency[0])
    columns = excitation.factors(frequency)
    if columns is not None:
        turned = np.exp(2j * np.pi * rng.random(columns.shape[::2]))
        exact: Complexes = (columns @ turned[:, :, None])[:, :, 0]
        return exact * np.sqrt(2 * excitation.spectrum(frequency) * step)[:, None]
    upper = np.clip(np.searchsorted(nodes, frequency, side="right"), 1, len(nodes) - 1)
    factor_below: Array | Complexes = _factor(excitation(nodes[:1])[0])
    amplitude = np.empty((len(frequency), len(factor_below)), complex)
    for index in range(1, len(nodes)):
        factor_above = _factor(excitation(nodes[index : index + 1])[0])
        lines = upper == index
        part = (frequency[lines] - nodes[index - 1]) / (nodes[index] - nodes[index - 1])
        part = np.clip(part, 0, 1)[:, None]
        turned = np.exp(2j * np.pi * rng.random((int(lines.sum()), len(factor_above))))
        amplitude[lines] = (1 - part) * (turned @ factor_below.T) + part * (turned @ factor_above.T)
        factor_below = factor_above
    return amplitude * np.sqrt(2 * excitation.spectrum(frequency) * step)[:, None]


def _factor(matrix: Array | Complexes) -> Array | Complexes:
    """Return L with L Lᴴ = G, whose eigenvalues below zero are errors of its table."""
    size = np.sqrt(np.maximum(np.diagonal(matrix).real, 0.0))
    size = np.maximum(size, FLOOR * size.max())
    scaled = matrix / np.outer(size, size)
    factor: Array | Complexes
    try:
        factor = size[:, None] * np.linalg.cholesky(scaled + RIDGE * np.eye(len(matrix)))
    except np.linalg.LinAlgError:  # more costly
        value, vector = np.linalg.eigh(scaled)
        factor = size[:, None] * vector * np.sqrt(np.maximum(value, 0.0))
    return factor


def samples(amplitude: Complexes, first: int, count: int) -> Array:
    """Return Re Σ_j X_j exp(2πi j m/count) of tones j = first, first + 1, …, (count, n)."""
    spectrum = np.zeros((count // 2 + 1, amplitude.shape[1]), complex)
    spectrum[first : first + len(amplitude)] = amplitude
    return np.fft.irfft(spectrum, count, axis=0) * (count / 2)


def before_hold(frequency: Array, interval: float) -> Array:
    """Return 1/sinc²(f Δ), the factor for tones with linear interpolation between samples."""
    return 1 / np.sinc(frequency * interval) ** 2
