"""Polynomial chaos against Sobol' indices by Saltelli's method in SciPy."""

import numpy as np
import pytest
from scipy.stats import norm, qmc, sobol_indices

from pidpanel.margin.chaos import BandPower, fitted

GROUPS = [slice(k, k + 1) for k in range(4)]


def answer(z):
    """g rms of a lightly damped panel: near products of powers, with an interaction."""
    return 20 * np.exp(-0.25 * z[0] + 0.15 * z[1]) * (1 + 0.1 * np.tanh(z[2]) + 0.05 * z[0] * z[3])


def samples(count):
    uniform = qmc.Sobol(4, rng=np.random.default_rng(3)).random(count)
    return norm.ppf(np.clip(uniform, 1e-9, 1 - 1e-9))


@pytest.mark.parametrize("is_log", [False, True])
def test_shares_are_sobol_indices_by_scipy(is_log):
    """Also those of a fitted logarithm are shares of the variance of the answer."""
    z = samples(128)
    first, total = fitted(z, answer(z.T), is_log).shares(GROUPS)
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


def test_what_is_of_a_panel_alone_is_not_learnt_from_its_other_run():
    """Two runs have a panel in common, also its noise: both are left out together."""
    rng = np.random.default_rng(1)
    panel, level = np.repeat(rng.standard_normal((64, 3)), 2, axis=0), rng.standard_normal(128)
    values = 20 + level + np.repeat(rng.standard_normal(64), 2)
    assert fitted(np.column_stack([panel, level]), values, draws=2).q2 < 0.55


def test_levels_of_bands_need_few_runs_where_their_powers_are_added():
    """The mean square is a sum over bands, with levels of 3 dB; a panel's input scales it."""
    rng = np.random.default_rng(7)
    z, weight = rng.standard_normal((96, 12)), np.arange(1, 12) / 66
    mixing = np.hstack([3.0 * np.eye(11), np.zeros((11, 1))])
    g = np.exp(0.2 * z[:, 11]) * np.sqrt(10 ** (z[:, :11] * 0.3) @ weight)
    chaos = fitted(z, g, is_log=True, base=BandPower(weight, mixing))
    assert chaos.q2 > 0.9999
    assert chaos(z) == pytest.approx(g, rel=1e-6)
    assert fitted(z, g, is_log=True).q2 < 0.99


def test_groups_of_scores_share_their_interactions():
    z = samples(64)
    first, total = fitted(z, z[:, 0] * z[:, 1] + z[:, 2]).shares([slice(0, 2), slice(2, 4)])
    assert first == pytest.approx([0.5, 0.5], abs=0.01)  # of 4096 samples
    assert total == pytest.approx([0.5, 0.5], abs=0.01)


def test_a_product_of_powers_needs_few_runs_in_its_logarithm():
    """The logarithm is linear; the answer itself has products of all scores."""
    rng = np.random.default_rng(6)
    z, power = np.clip(rng.standard_normal((64, 12)), -3, 3), np.linspace(0.02, 0.2, 12)
    g = 20 * np.exp(z @ power)
    assert fitted(z, g, is_log=True).q2 > 0.9999
    assert fitted(z, g).q2 < 0.98


def test_a_chaos_does_not_extrapolate_beyond_three_standard_deviations():
    z = np.random.default_rng(7).standard_normal((64, 1)).clip(-3, 3)
    chaos = fitted(z, np.tanh(z[:, 0]))
    assert chaos(np.array([[5.0]])) == chaos(np.array([[3.0]]))
