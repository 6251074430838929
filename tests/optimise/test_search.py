"""Searches within limits against all layouts, and the gap that they state."""

import numpy as np
import pytest
from random_panels import RandomPanel, exhaustive

from pidpanel.optimise.search import branch_and_bound, greedy, sample_property


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("is_largest", [True, False])
def test_the_best_layout_is_within_1_percent_and_the_gap_holds(seed, is_largest):
    problem = RandomPanel(seed).problem(most=2, is_largest=is_largest)
    optimum = exhaustive(RandomPanel(seed).problem(most=2, is_largest=is_largest))
    sampling = sample_property(problem)
    proof = branch_and_bound(problem, greedy(problem), sampling.ratio, nodes=200)
    assert proof.value <= 1.01 * optimum
    assert proof.bound <= optimum * (1 + 1e-5)  # single precision


def test_a_search_that_is_cut_short_states_a_larger_gap():
    # red: without the branches that are left in the bound
    panel = RandomPanel(4)
    start = greedy(panel.problem())
    gaps = [branch_and_bound(panel.problem(), start, 1.0, nodes).gap_db for nodes in (1, 40)]
    assert gaps[0] > gaps[1] >= 0


def test_layouts_stay_within_mass_number_and_free_cells():
    problem = RandomPanel(5).problem()
    branch_and_bound(problem, greedy(problem), 1.0, 20)
    for layout in problem.evaluated:
        place = problem.options.place[list(layout)]
        assert problem.mass(layout) <= problem.budget * (1 + 1e-9)
        assert len(layout) <= problem.most
        assert problem.places.overlap[np.ix_(place, place)].sum() == len(layout)


def test_violations_of_the_property_are_counted_and_enlarge_the_bound():
    light, heavy = (
        sample_property(RandomPanel(6, heavy=heavy).problem()) for heavy in (False, True)
    )
    assert light.checks > 100
    assert heavy.violations > 0
    assert heavy.largest > light.largest
    assert heavy.ratio >= light.ratio >= 1
