"""Polynomial chaos against Sobol' indices by Saltelli's method in SciPy."""

import numpy as np
import pytest
from scipy.stats import norm, qmc, sobol_indices

from pidpanel.margin.chaos import fitted

GROUPS = [slice(k, k + 1) for k in range(4)]


def answer(z):
    """g rms of a lightly damped panel: near products of powers, with an interaction."""
    return 20 * np.exp(-0.25 * z[0] + 0.15 * z[1]) * (1 + 0.1 * np.tanh(z[2]) + 0.05 * z[0] * z[3])


def samples(count):
    uniform = qmc.Sobol(4, rng=np.random.default_rng(3)).random(count)
    return norm.ppf(np.clip(uniform, 1e-9, 1 - 1e-9))


def test_shares_are_sobol_indices_by_scipy():
    z = samples(128)
    first, total = fitted(z, answer(z.T)).shares(GROUPS)
    referee = sobol_indices(func=answer, n=2**14, dists=[norm()] * 4, rng=np.random.default_rng(0))
    assert first == pytest.approx(referee.first_order, abs=0.02)
    assert total == pytest.approx(referee.total_order, abs=0.02)


def test_q2_is_that_of_runs_the_chaos_has_not_seen_also_among_many_inputs():
    """Terms are selected of many: what they explain by chance does not count."""
    rng = np.random.default_rng(5)
    z, further = rng.standard_normal((128, 30)), rng.standard_normal((20000, 30))
    values, truth = (
        answer(part.T) + 3 * rng.standard_normal(len(part)) for part in (z, further)
    )  # noise cannot be learnt
    chaos = fitted(z, values)
    unseen = 1 - np.mean((truth - chaos(further)) ** 2) / np.var(truth)
    assert chaos.q2 == pytest.approx(unseen, abs=0.1)


def test_groups_of_scores_share_their_interactions():
    z = samples(64)
    first, total = fitted(z, z[:, 0] * z[:, 1] + z[:, 2]).shares([slice(0, 2), slice(2, 4)])
    assert first == pytest.approx([0.5, 0.5], abs=1e-9)
    assert total == pytest.approx([0.5, 0.5], abs=1e-9)
