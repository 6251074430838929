"""Errors from records left out, and what a residual says."""

import numpy as np
import pytest

from pidpanel.coupled.estimation import (
    jackknife_error,
    leave_one_out,
    mean_impedances,
    mean_own_forces,
    residual,
)
from pidpanel.coupled.identification import BandImpedance, OwnForce


def test_the_error_of_a_mean_is_its_own():
    # red: (n − 1)/n → 1/n in `jackknife_error`
    x = np.random.default_rng(1).standard_normal((6, 4))
    left = np.array(leave_one_out(list(x))[1:]) / 5
    assert jackknife_error(left) == pytest.approx(x.std(axis=0, ddof=1) / np.sqrt(6), rel=1e-12)


def test_stated_errors_of_a_ratio_are_true():
    # 4 records each, 400 times: true error over stated one has the spread of Student's t with
    # 3 degrees of freedom, √3; its mean square is known badly, so its median: 0.765 ± 0.06
    # red: jackknife_error of a plain mean of ratios
    rng = np.random.default_rng(2)
    scores = []
    for _ in range(400):
        y = rng.exponential(1.0, (4, 50)).sum(axis=1)
        x = 3 * y + rng.standard_normal(4) * 5
        total = [a / b for a, b in zip(leave_one_out(list(x)), leave_one_out(list(y)), strict=True)]
        scores.append(abs(total[0] - 3) / jackknife_error(np.array(total[1:])))
    assert np.median(scores) == pytest.approx(0.765, abs=0.15)


def test_of_a_single_record_no_error_is_known():
    # red: the branch left out, after which it would be 0
    assert np.isnan(jackknife_error(np.zeros((1, 2)))).all()


def test_sums_leave_out_one_record_each():
    # red: `parts` for all in `mean_impedances`
    ones = np.ones(2)
    parts = [BandImpedance(k * ones, ones, ones, ones, ones, ones) for k in (1.0, 2.0, 6.0)]
    found = [one.force[0] / one.velocity[0] for one in mean_impedances(parts)]
    assert found == pytest.approx([3.0, 4.0, 3.5, 1.5])
    own = mean_own_forces([OwnForce(k * ones, -k * ones, ones) for k in (1.0, 2.0, 6.0)])
    assert [one.independent[0] for one in own] == pytest.approx([3.0, 4.0, 3.5, 1.5])
    # red: variance / n
    assert [one.common_variance[0] for one in own] == pytest.approx([1 / 3, 1 / 2, 1 / 2, 1 / 2])
    assert [one.common[0] for one in own] == pytest.approx([-3.0, -4.0, -3.5, -1.5])


def test_a_residual_beyond_its_scatter_remains():
    # red: excess = |value|
    apart = residual([np.array([2.0]), np.array([2.2])], [np.array([1.0]), np.array([1.1])])
    assert apart.value == pytest.approx([np.log(2)])
    assert apart.excess == pytest.approx([np.log(2)])
    scattered = residual([np.array([2.0]), np.array([1.0])], [np.array([1.0]), np.array([2.1])])
    assert scattered.excess.tolist() == [0.0]
