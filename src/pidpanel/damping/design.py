"""Which cases to run next: those that reduce the variance of what is wanted of a panel most.

What is wanted, such as the rms acceleration of a point in a scenario, reads the surface along one
fill and Γ, and moves by d_b for a unit of ln C_e or m_a at each node of frequency. Its variance is
dᵀ Σ d, and a further case at x, with a standard error e and the scatter t, takes away

    (d_Cᵀ c_C(x))²/(v_C(x) + e² + t²) + (d_mᵀ c_m(x))²/(v_m(x) + e_m² + t_m²),

with c(x) the covariance of the nodes with the case and v(x) its variance: no case needs to be run
to know what it is worth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.gaussian_process import GaussianProcess
from pidpanel.damping.surface import DampingSurface, groups


@dataclass(frozen=True)
class Wanted:
    """What a scenario reads from the surface.

    Attributes
    ----------
    fill_fraction, acceleration_g
        Where.
    derivative
        (2n, k) of k quantities with respect to ln C_e, then m_a [kg/m²], at the nodes of the
        surface.
    """

    fill_fraction: float
    acceleration_g: float
    derivative: Array


def spread(points: Array, count: int) -> list[int]:
    """Return the numbers of so many of the points (n, 3) of r, f [Hz], Γ, spread as far as they go.

    The first is the one nearest to the middle; each further one is farthest from those before it,
    in r, ln f and ln Γ, each over its range.
    """
    at = np.column_stack([points[:, 0], np.log(points[:, 1:])])
    at = (at - at.mean(axis=0)) / np.maximum(np.ptp(at, axis=0), 1e-12)
    chosen = [int(np.argmin((at**2).sum(axis=1)))]
    nearest = np.full(len(at), np.inf)
    while len(chosen) < min(count, len(at)):
        nearest = np.minimum(nearest, ((at - at[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(np.argmax(nearest)))
    return chosen


def variances(surface: DampingSurface, wanted: Sequence[Wanted]) -> list[Array]:
    """Return the variance (k,) of the quantities of each scenario."""
    return [
        np.einsum(
            "ik,ij,jk->k", w.derivative,
            surface.covariance(surface.nodes, w.fill_fraction, w.acceleration_g), w.derivative,
        )
        for w in wanted
    ]  # fmt: skip


def gains(
    surface: DampingSurface, wanted: Sequence[Wanted], cases: Array, relative_error: float
) -> list[Array]:
    """Return the variance (m, k) of each quantity that a further case would take away.

    Parameters
    ----------
    surface, wanted
        As they stand.
    cases
        (m, 3) r, f [Hz], Γ.
    relative_error
        Standard error of C_e that a case is run to, over C_e; m_a is taken to be as well known
        as the cases are that there are.
    """
    processes = [surface.damping] + ([surface.mass] if surface.mass is not None else [])
    noise = [relative_error**2 + processes[0].scatter ** 2]
    noise += [float(np.median(p.error)) ** 2 + p.scatter**2 for p in processes[1:]]
    found = []
    for w in wanted:
        n = len(w.derivative) // 2
        cross, variance = surface.covariance_with(
            cases, surface.nodes, w.fill_fraction, w.acceleration_g
        )
        total = np.zeros((len(cases), w.derivative.shape[1]))
        for half, own in enumerate(noise):
            part = slice(half * n, (half + 1) * n)
            known = cross[part].T @ w.derivative[part]
            total += known**2 / (variance[half] + own)[:, None]
        found.append(total)
    return found


def next_cases(
    surface: DampingSurface,
    wanted: Sequence[Wanted],
    cases: Array,
    relative_error: float,
    target: float,
    count: int,
) -> list[int]:
    """Return the numbers of the cases to run next, at most ``count``, best first.

    Each is the one that takes most, as a share, from the variances above ``target`` squared, once
    those before it are counted as run; none where all are below it.
    """
    chosen: list[int] = []
    for _ in range(min(count, len(cases))):
        share = np.zeros(len(cases))
        above = False
        for variance, gain in zip(
            variances(surface, wanted), gains(surface, wanted, cases, relative_error), strict=True
        ):
            over = variance > target**2
            above = above or bool(over.any())
            share += (gain[:, over] / variance[over]).sum(axis=1)
        if not above:
            break
        share[chosen] = -1.0
        chosen.append(int(np.argmax(share)))
        surface = _as_if_run(surface, cases[chosen[-1:]], relative_error)
    return chosen


def _as_if_run(surface: DampingSurface, case: Array, relative_error: float) -> DampingSurface:
    """Return the surface with one case more, at the value that it predicts there."""
    at = groups(*case.T)

    def more(process: GaussianProcess, error: float) -> GaussianProcess:
        return replace(
            process,
            points=np.vstack([process.points, at]),
            values=np.append(process.values, process.mean(at)),
            error=np.append(process.error, error),
        )

    mass = surface.mass
    return DampingSurface(
        surface.cases,
        surface.onset_g,
        surface.mass_per_fill,
        more(surface.damping, relative_error),
        None if mass is None else more(mass, float(np.median(mass.error))),
    )
