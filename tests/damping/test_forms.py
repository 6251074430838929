"""The closed form of two regimes, its constants and their intervals."""

import numpy as np
import pytest
import scipy

from pidpanel.damping import forms
from pidpanel.damping.forms import Points

TRUE = np.array([0.5, 0.2, 0.85, 0.8, 1.9, -0.2, 3.5])


@pytest.fixture(scope="module")
def points():
    r, f, level = (
        g.ravel()
        for g in np.meshgrid([0.1, 0.3, 0.5, 0.7, 0.9], [30, 80, 250, 700, 2000], [4, 20, 120, 700],
                             indexing="ij")
    )  # fmt: skip
    stroke = level * 9.80665 / (2 * np.pi * f) ** 2 / (0.025 * (1 - 0.94 * r))
    return Points(r, level.astype(float), stroke, 1 - 1 / level**2)


@pytest.fixture(scope="module")
def log_eta(points):
    noise = 0.1 * np.random.default_rng(2).normal(size=100)
    return forms.two_regimes(TRUE, points) + noise


def test_the_constants_of_two_regimes_are_found_within_their_intervals(points, log_eta):
    found = forms.fit(points, log_eta)
    # 95 % intervals of seven constants: all but one hold in all but 4 % of such draws
    assert ((found.low <= TRUE) & (found.high >= TRUE)).sum() >= 6
    assert (found.high - found.low < 1.0).all()
    assert found.rms == pytest.approx(0.1, rel=0.2)


def test_the_intervals_are_students_of_the_linearised_problem(points, log_eta):
    # red: n - count → n + count; 0.975 → 0.95; variance without its freedom
    found = forms.fit(points, log_eta)
    steps = 1e-6 * np.eye(7)
    slope = np.stack(
        [(forms.two_regimes(found.constants + step, points)
          - forms.two_regimes(found.constants - step, points)) / 2e-6 for step in steps], axis=1
    )  # fmt: skip
    left = forms.two_regimes(found.constants, points) - log_eta
    error = np.sqrt(np.diag(np.linalg.inv(slope.T @ slope)) * (left @ left) / 93)
    half = scipy.stats.t.ppf(0.975, 93) * error
    np.testing.assert_allclose(found.high - found.constants, half, rtol=1e-4)
    np.testing.assert_allclose(found.constants - found.low, half, rtol=1e-4)
    assert found.rms == pytest.approx(np.sqrt(np.mean(left**2)))


def test_few_cases_have_no_fit(points, log_eta):
    # red: FEWEST = 11
    some = Points(*(values[:11] for values in vars(points).values()))
    assert forms.fit(some, log_eta[:11]) is None


RNG = np.random.default_rng(6)
COUNT = 23
POINTS = Points(
    RNG.uniform(0.1, 0.9, COUNT),
    np.exp(RNG.uniform(1, 6, COUNT)),
    np.exp(RNG.uniform(-4, 1, COUNT)),
    RNG.uniform(0.3, 1, COUNT),
)


def test_two_regimes_add():
    # η = h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)]; red: any sign of `_two_regimes`
    c = np.array([0.5, 0.2, 0.85, -0.3, 1.4, -0.7, 2.3])
    p, x = POINTS, POINTS.stroke_over_gap
    eta = np.exp(0.5) * p.fill_fraction**0.2 / p.acceleration_g**0.85
    eta = p.onset * (eta + np.exp(-0.3) * x**1.4 / (1 + (x / np.exp(-0.7)) ** 2.3))
    np.testing.assert_allclose(np.exp(forms.two_regimes(c, p)), eta, rtol=1e-10)
