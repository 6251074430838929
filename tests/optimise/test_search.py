"""Searches within limits against all layouts, and the gap that they state."""

import numpy as np
from random_panels import RandomPanel, exhaustive

from pidpanel.optimise.search import branch_and_bound, greedy, sample_property

PANELS = 20


def test_the_best_layout_is_within_1_percent_and_the_gap_holds_on_20_random_panels():
    optimal = bounded = 0
    for seed in range(PANELS):
        panel, is_largest = RandomPanel(seed, heavy=seed % 4 == 3), seed % 2 == 0
        problem, whole = (panel.problem(most=2, is_largest=is_largest) for _ in range(2))
        optimum = exhaustive(whole)
        sampling = sample_property(problem)
        proof = branch_and_bound(problem, greedy(problem), sampling.ratio, nodes=100)
        optimal += proof.value <= 1.01 * optimum
        bounded += proof.bound <= optimum * (1 + 1e-5)  # single precision
    assert (optimal, bounded) == (PANELS, PANELS)


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
