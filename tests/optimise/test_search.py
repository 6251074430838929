"""Searches within limits against all layouts, and the gap that they state."""

from types import SimpleNamespace

import numpy as np
import pytest
from random_panels import RandomPanel, exhaustive, problems

from pidpanel.optimise.search import (
    Problem,
    Proof,
    Sampling,
    branch_and_bound,
    greedy,
    sample_submodularity,
)

PANELS = 12
HOLDS = Sampling(100, 0, 0.0, 1.0, 0.0)


@pytest.fixture(scope="module")
def drawn():
    """The problems of random panels: under sound, on a base, under both."""
    return [
        problems(
            *(RandomPanel(seed, seed % 4 == 3, moving, 40) for moving in (False, True)),
            is_largest=seed % 2 == 0,
        )
        for seed in range(PANELS)
    ]


@pytest.mark.parametrize("excitation", [0, 1, 2], ids=["sound", "base", "both"])
def test_the_best_layout_is_within_1_percent_and_the_gap_holds_on_random_panels(drawn, excitation):
    optimal = bounded = 0
    for problem in (each[excitation] for each in drawn):
        sampling = sample_submodularity(problem)
        proof = branch_and_bound(problem, greedy(problem), sampling, nodes=100)
        optimum = exhaustive(problem)
        optimal += proof.value <= 1.01 * optimum
        bounded += proof.bound <= optimum * (1 + 1e-5)  # single precision
    assert (optimal, bounded) == (PANELS, PANELS)


def test_of_both_excitations_the_smaller_reduction_counts():
    *alone, joint = problems(RandomPanel(2), RandomPanel(2, moving=True))
    shares = []
    for problem in alone:
        np.testing.assert_array_equal(problem.panel.bare, problem.panel.parts[0].bare)
        square = problem.additions((0,)).max(axis=1)
        shares.append(square / problem.panel.bare.max())
    values = joint.objective(joint.additions((0,)))
    feasible = np.isfinite(values)
    np.testing.assert_allclose(values[feasible], np.max(shares, axis=0)[feasible], rtol=1e-5)
    assert joint.objective(joint.panel.bare) == pytest.approx(1)


def test_a_search_that_is_cut_short_states_a_larger_gap():
    panel = RandomPanel(4)
    start = greedy(panel.problem())
    gaps = [branch_and_bound(panel.problem(), start, HOLDS, nodes).gap_db for nodes in (1, 40)]
    assert gaps[0] > gaps[1] >= 0


def test_layouts_stay_within_mass_number_and_free_cells():
    problem = RandomPanel(5).problem()
    branch_and_bound(problem, greedy(problem), HOLDS, 20)
    for layout in problem.evaluated:
        place = problem.options.place[list(layout)]
        assert problem.mass(layout) <= problem.budget * (1 + 1e-9)
        assert len(layout) <= problem.max_patches
        assert problem.places.overlap[np.ix_(place, place)].sum() == len(layout)


def test_violations_of_the_property_are_counted_and_enlarge_the_bound():
    light, heavy = (
        sample_submodularity(RandomPanel(6, heavy=heavy).problem()) for heavy in (False, True)
    )
    assert light.checks > 100
    assert heavy.violations > 0
    assert heavy.largest > light.largest
    assert heavy.ratio >= light.ratio >= 1
    assert heavy.excess > light.excess >= 0


def test_where_the_property_fails_the_bound_is_lower_and_branches_beyond_it_are_looked_at():
    # single dampers do harm on panel 5, two together do not
    problem = RandomPanel(5, moving=True).problem(most=2, is_largest=False)
    sampling, start = sample_submodularity(problem), greedy(problem)
    assert sampling.excess > 0.01
    proofs = [branch_and_bound(problem, start, each, 50) for each in (HOLDS, sampling)]
    assert proofs[1].value < 0.99 * proofs[0].value
    assert proofs[1].is_exhaustive and not proofs[0].is_exhaustive
    gaps = [branch_and_bound(problem, start, each, 1).gap_db for each in (HOLDS, sampling)]
    assert gaps[1] > gaps[0] + 0.05


class StatedProblem:
    """A problem of one point, with the mean squares of its layouts stated; others have 9."""

    def __init__(self, mass, budget, stated):
        self.options, self.budget, self.max_patches = (
            SimpleNamespace(mass=np.array(mass)),
            budget,
            2,
        )
        self.panel = SimpleNamespace(bare=np.array([10.0]))
        self.stated, self.evaluated = stated, {}

    def objective(self, square):
        return square.max(axis=-1)

    def additions(self, layout, allowed=None):
        mass = self.options.mass
        square = np.full((len(mass), 1), np.inf)
        for option in set(range(len(mass))).difference(layout):
            further = tuple(sorted((*layout, option)))
            fits = len(further) <= self.max_patches and mass[list(further)].sum() <= self.budget
            if fits and (allowed is None or allowed[option]):
                self.evaluated[further] = square[option] = self.stated.get(further, 9.0)
        return square


def test_dampers_are_exchanged_until_none_makes_the_layout_better():
    # from (0, 3) over (1, 3) to (1, 2), a damper at a time
    stated = {(0,): 5.0, (0, 3): 4.4, (1, 3): 4.0, (1, 2): 3.0}
    assert greedy(StatedProblem([1.0] * 4, 2.0, stated)) == (1, 2)


@pytest.mark.parametrize(("heavy", "best"), [(4.0, (1, 2)), (2.0, (0,))])
def test_one_heavy_damper_is_compared_with_several_light_ones(heavy, best):
    stated = {(0,): heavy, (1,): 6.0, (2,): 7.0, (1, 2): 3.0}
    assert greedy(StatedProblem([2.0, 1.0, 1.0, 1.0], 2.0, stated)) == best


class StatedPanel:
    """A panel from which each option removes a stated mean square, and pairs some more."""

    def __init__(self, removed, together):
        removed = np.asarray(removed, float)
        self.removed, self.together = removed.reshape(len(removed), -1), together
        self.points = self.removed.shape[1]
        self.bare = np.full(self.points, 10.0)

    def mean_square(self, _, loaded, __, further):
        alone = self.removed[loaded].sum(axis=0) + self.removed[further]
        pairs = len(loaded) * (len(loaded) + 1) / 2
        return self.bare - alone - self.together * pairs


def stated_problem(removed, most=2, mass=None, budget=10.0, together=0.0):
    """A problem with an option on each of some places."""
    number = np.arange(len(removed))
    mass = np.ones(len(removed)) if mass is None else np.array(mass)
    options = SimpleNamespace(place=number, stiffness=number, mass=mass)
    places = SimpleNamespace(overlap=np.eye(len(removed), dtype=bool), group=number)
    return Problem(StatedPanel(removed, together), options, places, budget, most)


def test_what_adds_up_violates_nothing():
    # three dampers of four at two points: 3 and 2 further ones are compared, in five chains
    problem = stated_problem([[1, 2], [3, 1], [2, 2], [0.5, 4]], most=3)
    sampling = sample_submodularity(problem)
    assert (sampling.checks, sampling.violations, sampling.excess) == (50, 0, 0.0)
    assert sampling.ratio == pytest.approx(1) and sampling.largest == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("alone", "together", "most", "expected"),
    [
        # 2.3 in place of 2; a second removes 1.3, of which 1.15 are allowed for
        ([1.0] * 3, 0.3, 2, (10, 10, 0.03, 1.15, 0.015)),
        # 1 + 1.3 + 1.6 in place of 3; the second and the third 2.9 in place of 1.3 · 2
        ([1.0] * 4, 0.3, 3, (25, 25, 0.03, 1.3, 0.03)),
        # too little for a ratio: 0.34 in place of 0.04 all counts
        ([0.04] * 3, 0.3, 2, (10, 10, 0.03, 1.0, 0.03)),
        # below single precision
        ([1.0] * 3, 8e-4, 2, (10, 0, 8e-5, 1.0004, 0.0)),
    ],
)  # fmt: skip
def test_dampers_that_remove_more_together_are_counted(alone, together, most, expected):
    sampling = sample_submodularity(stated_problem(alone, most, together=together))
    values = [getattr(sampling, name) for name in ("checks", "violations", "largest", "ratio")]
    assert [*values, sampling.excess] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_the_gap_is_that_of_the_bound_in_decibels():
    gaps = [Proof((), 10.0, bound, 1).gap_db for bound in (5.0, 1.0, 0.5, 12.0, 0.0)]
    np.testing.assert_allclose(gaps, [3.0103, 10, 13.0103, 0, np.inf], atol=1e-4)


@pytest.mark.parametrize(
    ("nodes", "violations", "expected"),
    [
        # single dampers alone: the first and the second may leave 10 − 4 − 3
        (1, 0, ((0,), 6.0, 3.0, 1, False)),
        # the second branch, 7 − 2, is closed by its bound
        (2, 0, ((0, 1), 3.0, 3.0, 2, False)),
        (9, 0, ((0, 1), 3.0, 3.0, 2, False)),
        # no bound counts: every branch with two dampers is looked at
        (9, 1, ((0, 1), 3.0, 3.0, 4, True)),
        (3, 1, ((0, 1), 3.0, 3.0, 3, False)),
    ],
)  # fmt: skip
def test_branches_are_searched_by_their_bounds(nodes, violations, expected):
    problem = stated_problem([4.0, 3.0, 2.0, 1.0])
    proof = branch_and_bound(problem, (3,), Sampling(100, violations, 0.0, 1.0, 0.0), nodes)
    assert (proof.layout, proof.value, proof.bound, proof.nodes, proof.is_exhaustive) == expected


def test_branches_of_three_dampers_fit_into_the_mass():
    removed = [4.0, 3.0, 2.0, 1.0]
    proof = branch_and_bound(stated_problem(removed, most=3), (), HOLDS, 9)
    assert (proof.layout, proof.value) == ((0, 1, 2), 1.0)
    # the third is too heavy beside the first two, 2 + 1 + 1.5 of 4, but not the fourth
    problem = stated_problem(removed, most=3, mass=[2.0, 1.0, 1.5, 1.0], budget=4.0)
    proofs = [branch_and_bound(problem, (), HOLDS, nodes) for nodes in (2, 9)]
    assert [(proof.layout, proof.value) for proof in proofs] == [((0, 1), 3.0), ((0, 1, 3), 2.0)]
    assert [proof.bound for proof in proofs] == [2.0, 2.0]


def test_the_bound_allows_for_what_the_samples_violate():
    # 10 − 4 − 1.5 · 3 − 0.02 · 10
    problem = stated_problem([4.0, 3.0, 2.0, 1.0])
    proof = branch_and_bound(problem, (), Sampling(100, 0, 0.0, 1.5, 0.02), 1)
    assert proof.bound == pytest.approx(1.3)


def test_only_what_fits_beside_a_damper_is_in_its_bound():
    problem = stated_problem([2.0, 1.0, 5.0], mass=[1.0, 1.0, 3.0], budget=3.0)
    proof = branch_and_bound(problem, (), HOLDS, 1)
    assert (proof.layout, proof.value, proof.bound) == ((2,), 5.0, 5.0)


def test_the_empty_layout_has_the_bare_mean_square():
    problem = stated_problem([4.0, 3.0])
    np.testing.assert_array_equal(problem.mean_square(()), [10.0])
    np.testing.assert_array_equal(problem.mean_square((0, 1)), [3.0])
