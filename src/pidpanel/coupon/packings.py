"""Scatter between packings of one bed, pooled over the cases of a sweep.

Each seed is a different packing, and remains so however long it is shaken: two beds differ by 3 to
7 % where two long runs state 0.5 %. Two or three seeds of a case are too few for their scatter;
those of all cases of a fill are enough. With c_ij the C_e of seed j of case i, e_ij its error and
c_i the mean, the scatter s is that for which

    Σ_ij (c_ij − c_i)²/(e_ij² + s² c_i²) = Σ_i (n_i − 1)

(Mandel and Paule, *Analytical Chemistry* 42, 1194 (1970), each case with a mean of its own), and
0 where the left side is smaller without it.
"""

from collections.abc import Sequence

from pidpanel.arrays import Array, Flags

FEWEST = 6  # degrees of freedom from which a fill is evaluated alone: s² is then known to 60 %

LOWEST, HIGHEST = 1e-6, 1.0  # between which s is looked for


def scatter(means: Sequence[Array], errors: Sequence[Array]) -> float:
    """Return s [1], the standard deviation between packings over the mean.

    Parameters
    ----------
    means, errors
        C_e and its standard error for the seeds (n_i,) of each case.

    Examples
    --------
    >>> import numpy as np
    >>> pairs = [np.array([0.95, 1.05]), np.array([1.9, 2.1])]
    >>> round(scatter(pairs, [np.zeros(2), np.zeros(2)]), 4)
    0.0707
    """
    square = [((c - c.mean()) / c.mean()) ** 2 for c in means]
    variances = [(e / c.mean()) ** 2 for c, e in zip(means, errors, strict=True)]
    freedom = sum(len(c) - 1 for c in means)

    def left(s: float) -> float:
        terms = (float((a / (e + s**2)).sum()) for a, e in zip(square, variances, strict=True))
        return sum(terms) - freedom

    if freedom == 0 or left(LOWEST) <= 0:
        return 0.0
    from scipy.optimize import brentq  # slow to import, and a check of a study needs none of it

    return float(brentq(left, LOWEST, HIGHEST)) if left(HIGHEST) < 0 else HIGHEST


def scatter_by(
    groups: Sequence[object], means: Sequence[Array], errors: Sequence[Array], alike: Flags
) -> dict[object, float]:
    """Return `scatter` of the cases of each group, or of all where a group has few."""

    def pooled_scatter(chosen: list[int]) -> tuple[float, int]:
        pooled = [means[i] for i in chosen]
        return scatter(pooled, [errors[i] for i in chosen]), sum(len(c) - 1 for c in pooled)

    counted = [i for i in range(len(groups)) if alike[i]]
    overall, _ = pooled_scatter(counted)
    scatters = {}
    for group in dict.fromkeys(groups):
        s, freedom = pooled_scatter([i for i in counted if groups[i] == group])
        scatters[group] = s if freedom >= FEWEST else overall
    return scatters
