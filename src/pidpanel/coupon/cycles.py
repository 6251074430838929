"""From the rows of a run, one per cycle, to dissipated energy, damping and apparent mass.

The shaker moves the coupon as w = W sin ωt. In the frame of the coupon the spheres have the
momentum p(t) along w, and Newton's law for all of them gives the wall force. Over one cycle:

    p_c = 2⟨p cos ωt⟩,  p_s = 2⟨p sin ωt⟩                                  [kg m/s]
    E_d = π ω W p_s / A_c           work of the shaker per cycle and area   [J/m²]
    C_e = E_d / (π ω W²) = p_s / (W A_c)                                   [N s/m³]
    m_a = (M + p_c / (ω W)) / A_c                                          [kg/m²]

so the wall force per area is Z ẇ with Z = C_e + iω m_a, the first harmonic of the coupon.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Flags

# Fewest blocks from which an error is taken: its own relative error is then 1/√14 = 27 %.
MIN_BLOCKS = 8

# Fewest rows from which `without_storage` takes its multiples. Not fewer: in what is left the
# error is small at once, and a run would end in a state that does not last (100 Hz, 80 g, μ = 0.1:
# C_e = 1250 N s/m³ for 60 cycles, 190 ever after).
ROWS_FOR_STORAGE = 60


@dataclass(frozen=True)
class Estimate:
    """Mean of a correlated series and the standard error of that mean."""

    # In the unit of the series
    mean: float
    error: float
    start: int  # first row used; the rows before it are the transient
    used: int
    # Difference of the means of the second and first half, over its standard error [1]
    drift: float


def first_harmonic(
    p_sin: Array, p_cos: Array, *, amplitude: float, frequency: float, mass: float, area: float
) -> tuple[Array, Array]:
    """Return C_e [N s/m³] and m_a [kg/m²] of each cycle (n,) from ⟨p sin ωt⟩ and ⟨p cos ωt⟩.

    The coupon moves by W sin 2πft ([m], [Hz]); M is that of all spheres [kg], A_c of all cells
    [m²].
    """
    equivalent_damping = 2 * p_sin / (amplitude * area)
    apparent_mass = (mass + 2 * p_cos / (2 * math.pi * frequency * amplitude)) / area
    return equivalent_damping, apparent_mass


def dissipated_energy(
    equivalent_damping: Array | float, amplitude: float, frequency: float
) -> Array | float:
    """Return E_d = π C_e ω W² per cycle [J/m²] (the paper's Eq. 4 with ẇ² in place of ẇ)."""
    return math.pi * equivalent_damping * 2 * math.pi * frequency * amplitude**2


def loss_factor(
    equivalent_damping: Array | float, mass_per_area: float, frequency: float
) -> Array | float:
    """Return η = E_d / (π m″ (ωW)²) = C_e / (m″ ω) [1]: loss over the spheres' kinetic energy."""
    return equivalent_damping / (mass_per_area * 2 * math.pi * frequency)


def inelastic_bound(mass_per_area: float, frequency: float) -> float:
    """Return C_e ≤ 4 m″ ω / π [N s/m³]: perfectly inelastic mass thrown from wall to wall.

    Reached at a clear gap L = πW without gravity, where E_d = 4 m″ (ωW)². A bed that keeps some of
    its energy from one wall to the next can exceed it.
    """
    return 4 * mass_per_area * 2 * math.pi * frequency / math.pi


def transient_end(series: Array) -> int:
    """Return the row of a series (n,) where the transient ends, by marginal standard errors.

    Of all truncation points d the one that minimises Σ_{i≥d}(x_i − x̄_d)² / (n − d)², on batches of
    five rows (of fewer where there are fewer than fifty). The search ends at half the series: a
    minimum there means that the end was not seen, and the caller must run on.

    References
    ----------
    White, *Simulation* 69, 323 (1997).
    """
    batch = max(1, min(5, len(series) // 10))
    n = len(series) // batch
    batches = series[: batch * n].reshape(n, batch).mean(axis=1)
    remaining = np.arange(n, 0, -1)
    mean = np.cumsum(batches[::-1])[::-1] / remaining
    square = np.cumsum(batches[::-1] ** 2)[::-1] / remaining
    marginal = np.maximum(square - mean**2, 0.0) / remaining
    return batch * int(np.argmin(marginal[: n // 2 + 1]))


def block_error(series: Array) -> float:
    """Return the standard error of the mean of a correlated series (n,), by blocking.

    Neighbours are averaged in pairs again and again; the error from the blocks rises until they are
    independent. The largest error from at least `MIN_BLOCKS` blocks is taken, which is on the safe
    side; infinity for shorter series.

    References
    ----------
    Flyvbjerg & Petersen, *J. Chem. Phys.* 91, 461 (1989).
    """
    blocks = np.asarray(series, float)
    error = 0.0
    while len(blocks) >= MIN_BLOCKS:
        error = max(error, float(np.std(blocks, ddof=1)) / math.sqrt(len(blocks)))
        half = len(blocks) // 2
        blocks = blocks[len(blocks) - 2 * half :].reshape(half, 2).mean(axis=1)
    return error if error > 0 else math.inf


def estimate(series: Array, start: int | None = None, stored: Array | None = None) -> Estimate:
    """Return the mean of a series (n,) after the transient with its standard error and drift.

    ``start`` defaults to `transient_end`; ``stored`` is the energy that the bed stores (n,) [J],
    used where `ROWS_FOR_STORAGE` rows are left (`without_storage`).
    """
    first = transient_end(series) if start is None else start
    steady, freedom = series[first:], 1
    if stored is not None and len(steady) >= ROWS_FOR_STORAGE:
        quiet = without_storage(series, stored, first)
        if start is None:
            first = 1 + transient_end(quiet[1:-1])
        if len(series) - first < ROWS_FOR_STORAGE:
            steady = series[first:]
        else:
            steady, freedom = without_storage(series, stored, first)[max(first, 1) : -1], 3
    halves = np.array_split(steady, 2)
    lost = math.sqrt((len(steady) - 1) / (len(steady) - freedom))
    spread = lost * math.hypot(*(block_error(half) for half in halves))
    drift = halves[1].mean() - halves[0].mean()
    drift = drift / spread if math.isfinite(spread) and spread > 0 else 0.0
    error = lost * block_error(steady)
    return Estimate(float(steady.mean()), error, first, len(steady), float(drift))


# Cycles after which motions with a period of 1, 2, 3 and 6 cycles repeat: C_e of single cycles of
# one cell is −0.55, 0.03, 0.86 times m″ω in turn round a mean of 0.11 (100 Hz, 80 g, half full).
COMMON_PERIOD = 6


def settled(series: Array) -> tuple[float, float]:
    """Return mean and error of a series (n,) without transient, from blocks of a common period.

    In fewer than two blocks the error is infinite.
    """
    count = len(series) // COMMON_PERIOD
    if count < 2:
        return float(series.mean()), math.inf
    blocks = series[len(series) - count * COMMON_PERIOD :].reshape(count, -1).mean(axis=1)
    return float(series.mean()), float(blocks.std(ddof=1)) / math.sqrt(count)


def without_storage(series: Array, stored: Array, start: int) -> Array:
    """Return the series (n,) less its part that follows the stored energy of the bed (n,) [J].

    What the shaker gives in one cycle and the bed gives back in the next is no loss and has no
    mean. A bed whose flight takes several cycles does so always: at 100 Hz, 80 g, half full, it
    lands every third cycle, and C_e of single cycles is −2000, 200, 3700 N s/m³ round a mean of
    600. The increments of the stored energy to the cycle before and after have the mean zero in a
    steady run, so any multiple of them may be taken off (control variates); the multiples are those
    of least squares from row ``start`` on. There the scatter falls by ten, elsewhere by a tenth.
    The first and last row have no such neighbours and stay.
    """
    rise = np.diff(stored)
    controls = np.column_stack([rise[1:], rise[:-1]])
    scale = np.abs(controls).max()
    if scale == 0:
        return series
    controls /= scale
    used = slice(max(start - 1, 0), None)
    steady = series[1:-1][used]
    regressors = np.column_stack([np.ones(len(steady)), controls[used]])
    multiples = np.linalg.lstsq(regressors, steady, rcond=None)[0][1:]
    result = series.copy()
    result[1:-1] -= controls @ multiples
    return result


def packed(means: Array, errors: Array, scatter: float) -> float:
    """Return the error of the mean over seeds, √Σ(σ² + s²c²)/n; s is the scatter of packings."""
    variance = np.square(errors) + (scatter * np.mean(means)) ** 2
    return float(np.sqrt(np.sum(variance))) / len(means)


def combine(means: Array, errors: Array) -> tuple[float, float]:
    """Return the mean over seeds (n,) and its standard error, from within and between.

    The error is the larger of the errors within the runs, √Σσ²/n, and that of their scatter, s/√n.
    With two or three seeds the scatter alone is too uncertain (one or two degrees of freedom); the
    runs alone miss the differences between packings.
    """
    n = len(means)
    within_seeds = float(np.sqrt(np.sum(np.square(errors)))) / n
    between_seeds = float(np.std(means, ddof=1)) / math.sqrt(n) if n > 1 else 0.0
    return float(np.mean(means)), max(within_seeds, between_seeds)


# Degrees of freedom from which a fill is looked at alone: its s² is then known to 60 %.
FEWEST_FREEDOM = 6

SCATTERS = 1e-6, 1.0  # ends between which s is looked for


def scatter_of_packings(means: Sequence[Array], errors: Sequence[Array]) -> float:
    """Return s [1], the standard deviation of C_e between packings of one bed over the mean.

    Each seed is a packing of its own, and stays what it is however long it is shaken: two beds
    differ by 3 to 7 % where two long runs state 0.5 %. Two or three seeds of a case are too few to
    tell; those of all cases of a fill together are not. With c_ij the C_e of seed j of case i, e_ij
    its error and c_i the mean, the scatter s is that for which

        Σ_ij (c_ij − c_i)²/(e_ij² + s² c_i²) = Σ_i (n_i − 1)

    (Mandel and Paule, *Analytical Chemistry* 42, 1194 (1970), each case with a mean of its own),
    and 0 where the left side is smaller without it.

    Parameters
    ----------
    means, errors
        C_e and its standard error for the seeds (n_i,) of each case.

    Examples
    --------
    >>> import numpy as np
    >>> pairs = [np.array([0.95, 1.05]), np.array([1.9, 2.1])]
    >>> round(scatter_of_packings(pairs, [np.zeros(2), np.zeros(2)]), 4)
    0.0707
    """
    square = [((c - c.mean()) / c.mean()) ** 2 for c in means]
    variances = [(e / c.mean()) ** 2 for c, e in zip(means, errors, strict=True)]
    freedom = sum(len(c) - 1 for c in means)

    def left(s: float) -> float:
        terms = (float((a / (e + s**2)).sum()) for a, e in zip(square, variances, strict=True))
        return sum(terms) - freedom

    low, high = SCATTERS
    if freedom == 0 or left(low) <= 0:
        return 0.0
    from scipy.optimize import brentq  # slow to import, and a check of a study needs none of it

    return float(brentq(left, low, high)) if left(high) < 0 else high


def scatter_by_group(
    groups: Sequence[object], means: Sequence[Array], errors: Sequence[Array], alike: Flags
) -> dict[object, float]:
    """Return `scatter_of_packings` of the cases of each group, or of all where a group has few."""

    def pooled_scatter(chosen: list[int]) -> float:
        return scatter_of_packings([means[i] for i in chosen], [errors[i] for i in chosen])

    counted = [i for i in range(len(groups)) if alike[i]]
    overall, scatters = pooled_scatter(counted), {}
    for group in dict.fromkeys(groups):
        own = [i for i in counted if groups[i] == group]
        has_many = sum(len(means[i]) - 1 for i in own) >= FEWEST_FREEDOM
        scatters[group] = pooled_scatter(own) if has_many else overall
    return scatters
