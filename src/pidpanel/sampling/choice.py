"""Which cases to run next: those that reduce the variance of what is wanted of a panel most.

What is wanted, such as the rms acceleration of a point in a scenario, reads the surface along one
fill and Γ, and moves by d_b for a unit of ln C_e or m_a at each node of frequency. Its variance is
dᵀ Σ d, and a further case at x takes away

    kᵀ (V(x) + N)⁻¹ k,   k = c(x)ᵀ d,

with c(x) the covariance (2n, 2) of the nodes with what the case tells, g_C and g_m, V(x) its own
(2, 2) and N that of its noise, e² + t²: no case needs to be run to know what it is worth. Where it
is not known whether beds cross, that is most of all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.surface import DampingSurface

ALIKE = 0.03
"""Of ln Γ: slices nearer than this are read by the same tones; C_e follows Γ to the power −0.8 at
most, and so differs by less than two packings do."""


@dataclass(frozen=True)
class Demand:
    """What a scenario reads from the surface."""

    fill_fraction: float
    acceleration_g: float
    # (2n, k) of k quantities with respect to ln C_e, then m_a [kg/m²], at the nodes of the surface
    derivative: Array


def variances(surface: DampingSurface, demands: Sequence[Demand]) -> list[Array]:
    """Return the variance (k,) of the quantities of each scenario."""
    return [
        np.einsum(
            "ik,ij,jk->k", w.derivative,
            surface.covariance(surface.nodes, w.fill_fraction, w.acceleration_g), w.derivative,
        )
        for w in demands
    ]  # fmt: skip


def gains(
    surface: DampingSurface, demands: Sequence[Demand], cases: Array, relative_error: float
) -> list[Array]:
    """Return the variance (m, k) of each quantity that a further case would take away."""
    prospect = surface.prospect(cases, relative_error)
    reductions = []
    for w in demands:
        cross = surface.covariance_with(prospect, surface.nodes, w.fill_fraction, w.acceleration_g)
        covariance = (w.derivative.T @ cross).reshape(-1, 2, len(cases))
        reductions.append(_explained(covariance, prospect.covariance))
    return reductions


def distinct(demands: Sequence[Demand]) -> list[Demand]:
    """Return one of all scenarios that read the surface at nearly the same fill and Γ.

    Its quantities are those of all of them.
    """
    merged: list[Demand] = []
    for candidate in demands:
        for i, previous in enumerate(merged):
            distance = abs(np.log(candidate.acceleration_g / previous.acceleration_g))
            if candidate.fill_fraction == previous.fill_fraction and distance < ALIKE:
                derivative = np.hstack([previous.derivative, candidate.derivative])
                merged[i] = replace(previous, derivative=derivative)
                break
        else:
            merged.append(candidate)
    return merged


def slice_points(
    surface: DampingSurface, demand: Demand, fastest: float | None
) -> tuple[Array, Index]:
    """Return tones at the very fill and motion of a scenario, and the nodes at which they are."""
    rounded = np.array([float(f"{f:.3g}") for f in surface.nodes])
    gamma = float(f"{demand.acceleration_g:.3g}")
    speed = gamma * STANDARD_GRAVITY / (2 * np.pi * rounded)
    node = np.flatnonzero(speed <= (np.inf if fastest is None else fastest))
    if gamma <= surface.onset_g:
        node = node[:0]
    fill = np.full(len(node), demand.fill_fraction)
    return np.column_stack([fill, rounded[node], np.full(len(node), gamma)]), node


def with_damping_along(demand: Demand, node: Index, scale: float) -> Demand:
    """Return a scenario of which C_e at some nodes is wanted too, ``scale`` ln C_e at each."""
    along = np.zeros((len(demand.derivative), len(node)))
    along[node, np.arange(len(node))] = scale
    return replace(demand, derivative=np.hstack([demand.derivative, along]))


def next_cases(
    surface: DampingSurface,
    demands: Sequence[Demand],
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
        is_unmet = False
        for variance, gain in zip(
            variances(surface, demands), gains(surface, demands, cases, relative_error), strict=True
        ):
            above_target = variance > target**2
            is_unmet = is_unmet or bool(above_target.any())
            share += (gain[:, above_target] / variance[above_target]).sum(axis=1)
        if not is_unmet:
            break
        share[chosen] = -1.0
        chosen.append(int(np.argmax(share)))
        surface = surface.with_case(cases[chosen[-1:]], relative_error)
    return chosen


def _explained(covariance: Array, joint: Array) -> Array:
    """kᵀV⁻¹k (m, q) of k (q, 2, m) and V (2, 2, m); m_a may have no variance."""
    (a, b), (_, d) = joint
    first_term = covariance[:, 0] ** 2 / a
    left = d - b**2 / a
    rest = (covariance[:, 1] - covariance[:, 0] * b / a) ** 2
    second_term = np.divide(
        rest, left, out=np.zeros_like(rest), where=np.broadcast_to(left > 0, rest.shape)
    )
    return np.asarray((first_term + second_term).T)
