"""Layouts within limits: greedy search with exchange, branch and bound, checks of the bound.

The search uses frozen damping. The reduction of the mean square at a point is nearly submodular:
each damper removes less, the more others there are. Where this holds, the sum of the individual
reductions bounds the joint one (Nemhauser, Wolsey, Fisher 1978). Dampers with mass may violate it,
so it is sampled: violations are counted, and the bound is enlarged by the largest ratio found.

For a limited number of dampers on different groups of places with a total mass M, the sum of the
individual reductions is bounded for any price μ ≥ 0 of mass by Lagrange's relaxation:

    Σ gain ≤ μ M + Σ over the best groups of max over their dampers (gain − μ mass)₊.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags, Index
from pidpanel.optimise.options import Options
from pidpanel.optimise.places import Places
from pidpanel.optimise.reduced_panel import JointPanel
from pidpanel.progress import with_progress

CHAINS = 5  # random layouts on which submodularity is sampled, one damper after another

TOLERANCE = 1e-4  # of the bare mean square: smaller violations are rounding in single precision

CLOSE = 0.005  # improvement of the objective below which branches are not searched, 0.02 dB

Layout = tuple[int, ...]  # indices of options, rising


@dataclass
class Problem:
    """Layouts of options within limits of mass and number."""

    panel: JointPanel
    options: Options
    places: Places
    budget: float  # largest mass [kg]
    max_patches: int  # largest number of patches
    # Objective of every evaluated layout, such as [m²/s⁴]
    evaluated: dict[Layout, float] = field(default_factory=dict)

    def on_places(self, used: Index, layouts: Sequence[Layout]) -> tuple[Problem, list[Layout]]:
        """Return the problem on some of its places, and layouts in the options of those."""
        index = np.flatnonzero(np.isin(self.options.place, used))
        position = {option: number for number, option in enumerate(index.tolist())}
        options = self.options.subset(index, used)
        fewer = replace(self, options=options, places=self.places.subset(used), evaluated={})
        return fewer, [tuple(position[option] for option in layout) for layout in layouts]

    def objective(self, mean_square: Array) -> Array:
        """Return the objective, the largest of mean squares (…, n_points)."""
        return np.asarray(mean_square.max(axis=-1))

    def mass(self, layout: Layout) -> float:
        """Return the mass of a layout [kg]."""
        return float(self.options.mass[list(layout)].sum())

    def feasible(self, layout: Layout) -> Flags:
        """Return which further dampers the limits allow, (n_options,)."""
        options, remaining_mass = self.options, self.budget * (1 + 1e-9) - self.mass(layout)
        is_covered = self.places.overlap[options.place[list(layout)]].sum(axis=0) > 0
        fits = (options.mass <= remaining_mass) & (len(layout) < self.max_patches)
        return np.asarray(fits & ~is_covered[options.place])

    def additions(self, layout: Layout, allowed: Flags | None = None) -> Array:
        """Return mean squares (n_options, n_points) with each further damper; ∞ if not allowed."""
        usable = self.feasible(layout) if allowed is None else self.feasible(layout) & allowed
        square = np.full((usable.size, self.panel.points), np.inf)
        if not usable.any():
            return square
        options, loaded, index = self.options, list(layout), np.flatnonzero(usable)
        square[index] = self.panel.mean_square(
            options.place[loaded].tolist(), options.stiffness[loaded],
            options.place[index], options.stiffness[index],
        )  # fmt: skip
        values = self.objective(square[index]).tolist()
        for option, value in zip(index.tolist(), values, strict=True):
            self.evaluated[tuple(sorted((*layout, option)))] = value
        return square

    def mean_square(self, layout: Layout) -> Array:
        """Return the mean squares (n_points,) of a layout."""
        if not layout:
            return self.panel.bare
        last = np.arange(self.options.mass.size) == layout[-1]
        return np.asarray(self.additions(layout[:-1], last)[layout[-1]])


def largest_difference(
    problem: Problem, layouts: Sequence[Layout], other: Problem, same: Sequence[Layout]
) -> float:
    """Return the largest difference of reductions of layouts in two problems [dB]."""
    logs = []
    for each, several in ((problem, layouts), (other, same)):
        values = [float(each.objective(each.mean_square(layout))) for layout in several]
        logs.append(10 * np.log10(values) - 10 * np.log10(float(each.objective(each.panel.bare))))
    return float(np.abs(logs[1] - logs[0]).max())


def greedy(problem: Problem) -> Layout:
    """Return the best layout of greedy searches with exchange.

    Each number of patches n is tried with fillings no heavier than budget/n.
    """
    best: Layout = ()
    value = float(problem.objective(problem.panel.bare))
    counts = range(1, problem.max_patches + 1)
    for count in with_progress(counts, "numbers of patches in greedy search"):
        affordable = problem.options.mass <= problem.budget / count * (1 + 1e-9)
        if not affordable.any():
            break
        layout: Layout = ()
        for _ in range(count):
            values = problem.objective(problem.additions(layout, affordable))
            option = int(np.argmin(values))
            if not np.isfinite(values[option]):
                break
            layout = tuple(sorted((*layout, option)))
        layout = improve_by_exchange(problem, layout)
        if problem.evaluated.get(layout, np.inf) < value:
            best, value = layout, problem.evaluated[layout]
    return best


def improve_by_exchange(problem: Problem, layout: Layout) -> Layout:
    """Return a layout improved by exchanging and adding dampers until no single change helps."""
    value = problem.evaluated.get(layout, np.inf)
    improved = True
    while improved:
        improved = False
        reduced = [tuple(option for option in layout if option != removed) for removed in layout]
        for base in [*reduced, layout]:
            values = problem.objective(problem.additions(base))
            option = int(np.argmin(values))
            if values[option] < value * (1 - 1e-6):
                layout, value = tuple(sorted((*base, option))), float(values[option])
                improved = True
                break
    return layout


@dataclass(frozen=True)
class Sampling:
    """Submodularity sampled on random layouts."""

    # Numbers of comparisons, and of those in which a damper removes more among others
    checks: int
    violations: int
    largest: float  # largest violation, as a share of the bare mean square
    # Largest ratio of a joint reduction to the sum of the individual ones; at least 1
    ratio: float
    # Largest excess of a reduction next to another damper over ``ratio`` times the sum of the
    # individual ones without it, as a share of the bare mean square; at least 0
    excess: float


def sample_submodularity(problem: Problem, seed: int = 0) -> Sampling:
    """Sample submodularity on random layouts, built one damper after another."""
    generator, bare = np.random.default_rng(seed), problem.panel.bare
    checks, violations, largest, ratio, chains = 0, 0, 0.0, 1.0, []
    for _ in with_progress(range(CHAINS), "random layouts"):
        chain = _chain(problem, generator)
        chains.append(chain)
        gains = [start - square for start, square in chain.states]
        for earlier, later in itertools.pairwise(gains):
            is_finite = np.isfinite(later).all(axis=1) & np.isfinite(earlier).all(axis=1)
            excess = (later[is_finite] - earlier[is_finite]) / bare
            checks += excess.size
            violations += int(np.count_nonzero(excess > TOLERANCE))
            largest = max(largest, float(excess.max(initial=0.0)))
        for index, (start, _) in enumerate(chain.states):
            single = np.maximum(gains[index][chain.drawn[index:]], 0).sum(axis=0)
            joint = start - chain.last
            large = single > 100 * TOLERANCE * bare
            ratio = max(ratio, float((joint[large] / single[large]).max(initial=1.0)))
    worst = max(_excess(bare, chain, ratio) for chain in chains)
    return Sampling(checks, violations, largest, ratio, worst if worst > TOLERANCE else 0.0)


class _Chain(NamedTuple):
    """Dampers added one after another."""

    states: list[tuple[Array, Array]]  # mean squares before each, and with each option in its place
    drawn: list[int]
    last: Array  # mean squares with all of them


def _chain(problem: Problem, generator: np.random.Generator) -> _Chain:
    layout: Layout = ()
    light = problem.options.mass <= problem.budget / problem.max_patches * generator.uniform(1, 2)
    states: list[tuple[Array, Array]] = []
    drawn: list[int] = []
    current = problem.panel.bare
    while (allowed := problem.feasible(layout) & light).any():
        states.append((current, problem.additions(layout)))
        drawn.append(int(generator.choice(np.flatnonzero(allowed))))
        layout = tuple(sorted((*layout, drawn[-1])))
        current = states[-1][1][drawn[-1]]
    return _Chain(states, drawn, current)


def _excess(bare: Array, chain: _Chain, ratio: float) -> float:
    """Return `Sampling.excess` of a chain."""
    excess, (states, drawn, _) = 0.0, chain
    for index, (start, square) in enumerate(states):
        removal = np.maximum(start - square, 0)  # 0 where not allowed
        single = np.zeros_like(bare)
        for further in range(index + 1, len(states)):
            removed = states[index + 1][0] - states[further][1]
            surplus = (removed - ratio * (single + removal)) / bare
            allowed = np.isfinite(square) & np.isfinite(removed)
            excess = max(excess, float(np.max(surplus, initial=0.0, where=allowed)))
            single = single + removal[drawn[further]]
    return excess


@dataclass(frozen=True)
class Proof:
    """The best layout, and a bound on all others for the frozen damping."""

    layout: Layout
    # Objective of the layout, and lower bound on that of any layout, such as [m²/s⁴]
    value: float
    bound: float
    nodes: int  # number of expanded layouts: those with every further damper evaluated
    is_exhaustive: bool = False  # whether every layout was evaluated, so that no bound is needed

    @property
    def gap_db(self) -> float:
        """Largest possible improvement by any other layout [dB]; ∞ if the bound is not positive."""
        if self.bound <= 0:
            return float("inf")
        return float(10 * np.log10(self.value / min(self.bound, self.value)))


def branch_and_bound(problem: Problem, start: Layout, sampling: Sampling, nodes: int) -> Proof:
    """Return the best layout with a bound on all others.

    If submodularity is violated, pruning is disabled and the search continues until ``nodes``
    layouts are expanded.

    Parameters
    ----------
    problem
        Options, places and limits; its ``evaluated`` layouts are extended.
    start
        Good layout to start from, such as that of `greedy`.
    sampling
        Sampled ratio and excess by which reductions are enlarged in the bounds.
    nodes
        Maximum number of expanded layouts.
    """
    best = start
    value = float(problem.objective(problem.mean_square(start)))
    counter = itertools.count()
    all_options = np.ones(problem.options.mass.size, np.bool_)
    heap: list[tuple[float, int, Layout, Flags]] = [(0.0, next(counter), (), all_options)]
    expanded, closed_bound = 0, value
    for _ in with_progress(range(nodes), "nodes of branch and bound"):
        if not heap:
            break
        bound, _, layout, allowed = heapq.heappop(heap)
        if bound >= value * (1 - CLOSE) and not sampling.violations:
            closed_bound = min(closed_bound, bound)
            heap.clear()
            break
        expanded += 1
        square = problem.additions(layout, allowed)
        values = problem.objective(square)
        if (option := int(np.argmin(values))) >= 0 and values[option] < value:
            best, value = tuple(sorted((*layout, option))), float(values[option])
        for child_bound, option, further in _children(problem, layout, square, sampling):
            if child_bound < value * (1 - CLOSE) or sampling.violations:
                child = tuple(sorted((*layout, option)))
                heapq.heappush(heap, (child_bound, next(counter), child, further))
            else:
                closed_bound = min(closed_bound, child_bound)
    bounds = [entry[0] for entry in heap]
    is_exhaustive = not heap and sampling.violations > 0  # otherwise branches are cut
    return Proof(best, value, min([value, closed_bound, *bounds]), expanded, is_exhaustive)


def _children(
    problem: Problem, layout: Layout, square: Array, sampling: Sampling
) -> Iterator[tuple[float, int, Flags]]:
    """Yield bound, option and further options of each branch; each layout is in one branch."""
    free = problem.max_patches - len(layout) - 1
    finite = np.isfinite(square[:, 0])
    if not finite.any() or free == 0:
        return
    options, places = problem.options, problem.places
    start = problem.mean_square(layout)
    weights = weights_of_points(problem.panel.points)
    gains = np.where(finite[:, None], start - np.where(finite[:, None], square, 0), 0) @ weights.T
    excess = sampling.excess * (weights @ problem.panel.bare)
    prices = PriceOfMass(sampling.ratio * gains, options.mass, places.group[options.place], free)
    remaining_mass = problem.budget - problem.mass(layout) - options.mass
    order = np.flatnonzero(finite)
    order = order[np.argsort(problem.objective(square[order]))]
    allowed = finite.copy()
    for option in order.tolist():
        allowed[option] = False
        further = allowed & ~places.overlap[options.place[option]][options.place]
        further &= options.mass <= remaining_mass[option] + 1e-12
        if further.any():
            removed = prices.largest_reduction(further, remaining_mass[option])
            yield float(np.max(weights @ square[option] - removed - excess)), option, further


PRICES = 12  # prices of mass that are tried, besides 0


def weights_of_points(points: int) -> Array:
    """Return weights (k, n_points) whose means bound the objective from below.

    The largest of some values is at least any mean of them: each alone, pairs, and all.
    """
    mean = np.full((1, points), 1 / points)
    if points == 1:
        return mean
    single = np.eye(points)
    first, second = np.triu_indices(points, 1)
    mixed = [share * single[first] + (1 - share) * single[second] for share in (0.25, 0.5, 0.75)]
    return np.concatenate([mean, single, *mixed])


class PriceOfMass:
    """The relaxation over some prices.

    Each damper removes ``gain`` (n_options, k) for k weights and has a mass (n_options,) [kg]. A
    layout has at most ``count`` dampers, and one of a ``group`` (n_options,), its place.
    """

    def __init__(self, gain: Array, mass: Array, group: Index, count: int) -> None:
        self._order = np.argsort(group, kind="stable")
        sorted_group = group[self._order]
        self._starts = np.flatnonzero(np.r_[True, sorted_group[1:] != sorted_group[:-1]])
        self._count = count
        steepest = float((gain.max(axis=1) / mass).max(initial=0.0))
        self._prices = steepest * np.concatenate([[0.0], np.geomspace(1e-3, 1, PRICES)])
        net = gain[:, :, None] - mass[:, None, None] * self._prices
        self._net = np.maximum(net, 0)[self._order]  # (n_options, k, n_prices)

    def largest_reduction(self, allowed: Flags, mass: float) -> Array:
        """Return (k,) the most that allowed dampers within a mass [kg] can remove."""
        net = np.where(allowed[self._order, None, None], self._net, 0)
        groups = np.maximum.reduceat(net, self._starts, axis=0)
        count = min(self._count, len(groups))
        largest = np.partition(groups, len(groups) - count, axis=0)[len(groups) - count :]
        return np.asarray((self._prices * mass + largest.sum(axis=0)).min(axis=1))
