"""The motion at which panel and dampers are consistent.

The panel sets the motion of a patch, and the motion sets the damping: C_e(f, Γ) peaks near
Γ = 2.5 and falls on both sides. Equivalent linearisation replaces the random motion of a patch by
the sine of the same rms,

    Γ = √2 a_rms / g,

where a_rms is the rms over time, over the patch and over the whole range of frequency. The unknowns
are x = ln Γ of every load, F(x) is the ln Γ that results when damping is evaluated at x, and
F(x) = x is solved.

Where damping falls with Γ, as beyond its peak, more motion of any patch leads to more motion of
all: F is then increasing in all its arguments, every solution lies between the one that is reached
from far below and the one that is reached from far above, and if those two agree there is no other
(Tarski). So the search starts below and above all possible solutions, and for few loads also with
one load high and the others low. In other cases a further solution may be missed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array


class LinearisationError(RuntimeError):
    """No Γ was found at which motion and damping agree."""


class NotConverged(LinearisationError):
    """The search for Γ ended before its tolerance."""


Map = Callable[[Array], Array]  # x (n,) → F (n,)

# Solutions that differ by less in every ln Γ are one: the accuracy of the rms accelerations.
DISTINCT = 1e-3

DEPTH = 6  # depth of Anderson's method: more does not help within the twenty steps it takes

LARGEST_STEP = math.log(2)  # largest step of ln Γ: longer ones jump over solutions near a start

STEPS = 60  # most steps of Anderson's method

STEP = 0.02  # step of ln Γ in the Jacobian for stability


@dataclass(frozen=True)
class Solution:
    """A set of Γ that reproduces itself."""

    log_gamma: Array  # (n,) ln Γ
    residual: float  # largest |F(x) − x|
    # Whether a small surplus of motion dies away: the eigenvalues of ∂F/∂x have real parts below 1
    stable: bool


def governing(solutions: Sequence[Solution]) -> Solution:
    """Return the stable solution of largest motion.

    Which one occurs depends on history, so a design uses the largest.
    """
    return ([solution for solution in solutions if solution.stable] or solutions)[-1]


def starts_between(low: Array, high: Array) -> list[Array]:
    """Return starts: all high, all low, and for two to four loads each of them alone high."""
    starts = [high, low]
    if 2 <= len(low) <= 4:
        starts += [np.where(is_high, high, low) for is_high in np.eye(len(low), dtype=bool)]
    return starts


def find_motions(
    maps: Sequence[Map],
    starts: Sequence[Array],
    tolerance: float = 1e-6,
    aim: float | None = None,
) -> list[Solution]:
    """Return the distinct solutions of F(x) = x found from the starts, smallest motion first.

    They are sorted by the sum of ln Γ, which agrees with the order of all Γ if solutions are
    ordered.

    The starts are followed on the fewest lines, F_k. Each distinct end is then moved to satisfy F
    on more and more lines and finally on all: F_k(x) + [F(x₀) − F_k(x₀)] = x is solved from x₀,
    repeatedly until F agrees. One evaluation of F then gains about two digits.
    """
    coarse = maps[-1]
    enough = aim or (tolerance / 10 if len(maps) == 1 else DISTINCT / 10)
    ends = [iterate(coarse, approach(coarse, start), enough) for start in starts]
    near = [x for x, residual in ends if residual <= max(enough, tolerance)]
    solved_ends = [_on_more_lines(maps[0], maps[1:], x, tolerance) for x in _distinct(near)]
    x, residual = min(solved_ends or ends, key=lambda end: end[1])
    solved_ends = [end for end in solved_ends if end[1] <= tolerance]
    if not solved_ends:
        raise NotConverged(
            f"the largest |ln(Γ_out/Γ)| of {x.size} loads is {residual:.3g} near Γ = "
            f"{math.exp(x.min()):.3g} to {math.exp(x.max()):.3g} after {STEPS} steps from "
            f"each of {len(starts)} starts, more than {tolerance:g}: does C_e or m_a jump with Γ?"
        )
    distinct = _distinct([x for x, _ in solved_ends])
    residuals = {id(x): residual for x, residual in solved_ends}
    stable = [True] if len(distinct) == 1 else [_is_stable(coarse, x) for x in distinct]
    return sorted(
        (
            Solution(x, residuals[id(x)], is_stable)
            for x, is_stable in zip(distinct, stable, strict=True)
        ),
        key=lambda solution: float(solution.log_gamma.sum()),
    )


def approach(F: Map, start: Array, near: float = 0.1) -> Array:
    """Return an x near the solution that is next to a start, where |F(x) − x| is small.

    Each load takes a secant step of its own, at most a factor of two of Γ, so that a load which
    starts high comes down to its highest motion whatever the others do. Coupling is left to
    `iterate`.
    """
    x = np.asarray(start, dtype=np.float64)
    value, slope = F(x), np.zeros(x.shape)
    for _ in range(20):
        surplus = value - x
        if np.max(np.abs(surplus)) < near:
            break
        move = np.clip(surplus / (1 - slope), -LARGEST_STEP, LARGEST_STEP)
        moved = F(x + move)
        moving = np.abs(move) > 1e-9
        rise = np.divide(moved - value, move, out=slope, where=moving)
        x, value, slope = x + move, moved, np.clip(rise, -20.0, 0.9)
    return x


def iterate(F: Map, start: Array, tolerance: float) -> tuple[Array, float]:
    """Return x and the largest |F(x) − x| where Anderson's method ends.

    Each step combines the ones before so that the surplus F(x) − x is least, and is cut to a
    factor e² of Γ; where a step doubles the surplus, it restarts from the best with half the
    plain step. No derivative is needed.
    """
    x = np.asarray(start, dtype=np.float64)
    surplus = F(x) - x
    best_x, best_surplus, damped = x, surplus, 1.0
    steps: list[tuple[Array, Array]] = []  # differences of x and of the surplus
    for _ in range(STEPS):
        if np.max(np.abs(surplus)) <= tolerance:
            break
        move = damped * surplus
        if steps:
            x_steps, surplus_steps = (np.stack(part, axis=1) for part in zip(*steps, strict=True))
            share = np.linalg.lstsq(surplus_steps, surplus, rcond=1e-10)[0]
            move = surplus - (x_steps + surplus_steps) @ share
        move *= min(1.0, 2.0 / max(np.max(np.abs(move)), 1e-300))
        onward = x + move
        following = F(onward) - onward
        if np.linalg.norm(following) > 2 * np.linalg.norm(best_surplus) and steps:
            x, surplus, steps, damped = best_x, best_surplus, [], damped / 2
            continue
        steps = [*steps[1 - DEPTH :], (onward - x, following - surplus)]
        x, surplus = onward, following
        if np.linalg.norm(surplus) < np.linalg.norm(best_surplus):
            best_x, best_surplus = x, surplus
    return best_x, float(np.max(np.abs(best_surplus)))


def _on_more_lines(F: Map, fewer: Sequence[Map], x: Array, tolerance: float) -> tuple[Array, float]:
    """Return x and the largest |F(x) − x| from an x near a solution, with maps close to F."""
    if not fewer:
        return iterate(F, x, tolerance)
    residual = math.inf
    for _ in range(8):
        value = F(x)
        last, residual = residual, float(np.max(np.abs(value - x)))
        if residual <= tolerance:
            return x, residual
        if residual > last:
            break
        coarse, offset = fewer[0], value - fewer[0](x)

        def moved(x_near: Array, coarse: Map = coarse, offset: Array = offset) -> Array:
            return coarse(x_near) + offset

        x, _ = _on_more_lines(moved, fewer[1:], x, max(tolerance, residual / 100) / 3)
    return iterate(F, x, tolerance)


def _distinct(solutions: Sequence[Array]) -> list[Array]:
    distinct: list[Array] = []
    for x in solutions:
        if all(np.max(np.abs(x - previous)) > DISTINCT for previous in distinct):
            distinct.append(x)
    return distinct


def _is_stable(F: Map, x: Array) -> bool:
    columns = [(F(x + STEP * unit) - F(x - STEP * unit)) / (2 * STEP) for unit in np.eye(len(x))]
    return bool(np.max(np.linalg.eigvals(np.stack(columns, axis=1)).real) < 1)
