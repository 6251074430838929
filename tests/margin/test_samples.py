"""Samples of scores: runs with the same panel, and their distribution."""

import numpy as np
import pytest

from pidpanel.margin.samples import DRAWS, Group, scores

GROUPS = [
    Group("panel", "", np.eye(2), changes_panel=True),
    Group("level", "", np.eye(3)),
    Group("air", "", np.eye(1), changes_panel=True),
]
OF_PANEL = [0, 1, 5]


def test_runs_after_one_another_have_the_same_panel_and_other_levels():
    z = scores(GROUPS, 64).reshape(-1, DRAWS, 6)
    assert (z[:, 1:, OF_PANEL] == z[:, :1, OF_PANEL]).all()
    assert np.unique(z[:, :, 2:5]).size == z[:, :, 2:5].size


def test_scores_are_standard_normal_and_independent_of_each_other():
    z = scores(GROUPS, 2048)
    assert z.mean(axis=0) == pytest.approx(np.zeros(6), abs=0.01)
    # chance would leave 1/√1024 = 0.03 between scores of which panels have one
    assert np.cov(z.T) == pytest.approx(np.eye(6), abs=0.03)


def test_more_runs_continue_fewer():
    assert (scores(GROUPS, 64)[:32] == scores(GROUPS, 32)).all()
