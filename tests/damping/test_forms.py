"""Closed forms side by side: constants found, and the right one told from the wrong ones."""

import numpy as np
import pytest
import scipy

from pidpanel.damping import forms
from pidpanel.damping.forms import FORMS, Points, information
from pidpanel.damping.laws import equation_5

BY_NAME = {form.name: form for form in FORMS}
TRUE = np.array([0.5, 0.2, 0.85, 0.8, 1.9, -0.2, 3.5])


@pytest.fixture(scope="module")
def points():
    r, f, level = (
        g.ravel()
        for g in np.meshgrid([0.1, 0.3, 0.5, 0.7, 0.9], [30, 80, 250, 700, 2000], [4, 20, 120, 700],
                             indexing="ij")
    )  # fmt: skip
    omega = 2 * np.pi * f
    stroke = level * 9.80665 / omega**2 / (0.025 * (1 - 0.94 * r))
    return Points(r, omega, level.astype(float), stroke, 1 - 1 / level**2, 13.9)


@pytest.fixture(scope="module")
def log_eta(points):
    noise = 0.1 * np.random.default_rng(2).normal(size=100)
    return BY_NAME["two_regimes"].function(TRUE, points) + noise


def test_the_constants_of_two_regimes_are_found_within_their_intervals(points, log_eta):
    found = forms.fit(BY_NAME["two_regimes"], points, log_eta)
    # 95 % intervals of seven constants: all but one hold in all but 4 % of such draws
    assert ((found.low <= TRUE) & (found.high >= TRUE)).sum() >= 6
    assert (found.high - found.low < 1.0).all()
    assert found.rms == pytest.approx(0.1, rel=0.2)


def test_cases_left_out_and_information_both_point_to_the_form_that_made_the_data(points, log_eta):
    fits = {form.name: forms.fit(form, points, log_eta) for form in FORMS}
    for name, other in fits.items():
        assert other.held_out_rms > other.rms
        if name != "two_regimes":
            assert other.held_out_rms > 2 * fits["two_regimes"].held_out_rms, name
            assert other.information > fits["two_regimes"].information + 10, name


def test_a_form_in_amplitude_alone_is_the_law_of_its_data(points):
    # η = h e² r^0.3 Γ^−0.8 x^0.1 exactly
    form = BY_NAME["groups"]
    found = forms.fit(form, points, form.function(np.array([2, 0.3, 0.8, 0.1]), points))
    np.testing.assert_allclose(found.constants, [2, 0.3, 0.8, 0.1], rtol=1e-6)


def test_two_cases_have_no_corrected_criterion():
    # red: `n < k + 1`, which divides by nothing
    assert np.isnan(forms.information(np.array([0.5, -0.5]), 0))
    assert np.isfinite(forms.information(np.array([0.5, -0.5, 0.1]), 0))


def test_the_information_criterion_is_akaikes_by_hand():
    # n = 4, mean square 0.25, one constant and the variance: 4 ln 0.25 + 4 + 12/1
    assert forms.information(np.array([0.5, -0.5, 0.5, -0.5]), 1) == pytest.approx(
        4 * np.log(0.25) + 4 + 12
    )


def test_every_case_is_left_out_once():
    assert sorted(np.concatenate(forms.folds(37))) == list(range(37))


FORMS_BY_NAME = {form.name: form for form in forms.FORMS}
RNG = np.random.default_rng(6)
COUNT = 23
POINTS = forms.Points(
    RNG.uniform(0.1, 0.9, COUNT),
    np.exp(RNG.uniform(5, 9, COUNT)),
    np.exp(RNG.uniform(1, 6, COUNT)),
    np.exp(RNG.uniform(-4, 1, COUNT)),
    RNG.uniform(0.3, 1, COUNT),
    13.0,
)


def test_the_papers_form_is_equation_5_with_the_constants_of_equation_6():
    # C_e/(r ω) of a₁ = 2π r 1000^(2 − a₂) (b₀ + b₁ r + b₂ r²), a₂ = c₀ + c₁ r, and
    # a₃ = r (d₀ + d₁ r)/1000: ω counted in krad/s
    # red: any sign or power of `_paper`
    b0, b1, b2, c0, c1, d0, d1 = c = np.array([2.0, -1.5, 0.7, 1.8, 0.4, 0.3, -0.2])
    r, omega = POINTS.fill_fraction, POINTS.omega
    a2 = c0 + c1 * r
    a1 = 2 * np.pi * r * 1000 ** (2 - a2) * (b0 + b1 * r + b2 * r**2)
    damping = equation_5(omega, a1, a2, r * (d0 + d1 * r) / 1000)
    found = FORMS_BY_NAME["paper"].function(c, POINTS)
    # the factor of the unit, 1000 for one power of ω
    np.testing.assert_allclose(np.exp(found), damping / (r * omega), rtol=1e-10)


def test_the_papers_form_with_a_level_follows_a_power_of_it():
    # red: c[7] * → c[7] / in `_paper_level`
    c = np.array([2.0, -1.5, 0.7, 1.8, 0.4, 0.3, -0.2, -0.8])
    ratio = np.exp(
        FORMS_BY_NAME["paper_level"].function(c, POINTS)
        - FORMS_BY_NAME["paper"].function(c, POINTS)
    )
    np.testing.assert_allclose(ratio, POINTS.acceleration_g**-0.8, rtol=1e-10)


def test_the_groups_multiply_as_powers():
    # η = h A r^p Γ^−q x^s; red: any sign of `_groups`
    c = np.array([0.7, 0.4, 0.8, 0.3])
    p = POINTS
    eta = p.onset * np.exp(0.7) * p.fill_fraction**0.4 / p.acceleration_g**0.8
    eta *= p.stroke_over_gap**0.3
    np.testing.assert_allclose(np.exp(FORMS_BY_NAME["groups"].function(c, p)), eta, rtol=1e-10)


def test_two_regimes_add():
    # η = h [A r^p Γ^−q + B x^s/(1 + (x/x₀)^t)]; red: any sign of `_two_regimes`
    c = np.array([0.5, 0.2, 0.85, -0.3, 1.4, -0.7, 2.3])
    p, x = POINTS, POINTS.stroke_over_gap
    eta = np.exp(0.5) * p.fill_fraction**0.2 / p.acceleration_g**0.85
    eta = p.onset * (eta + np.exp(-0.3) * x**1.4 / (1 + (x / np.exp(-0.7)) ** 2.3))
    np.testing.assert_allclose(np.exp(FORMS_BY_NAME["two_regimes"].function(c, p)), eta, rtol=1e-10)


@pytest.mark.slow
def test_a_linear_form_is_fitted_and_left_out_as_linear_algebra_says():
    # ln η of `groups` is linear: value, Student interval and error over every tenth case left out
    # red: n - count → n + count in `fit`; FOLDS = 11; np.abs(held_out) → held_out
    p, form = POINTS, FORMS_BY_NAME["groups"]
    design = np.stack(
        [np.ones(COUNT), np.log(p.fill_fraction), -np.log(p.acceleration_g),
         np.log(p.stroke_over_gap)], axis=1
    )  # fmt: skip
    noise = 0.2 * np.random.default_rng(7).normal(size=COUNT)
    noise[4] = 1.0  # the largest error is one below the data
    y = design @ [0.7, 0.4, 0.8, 0.3] + noise
    found = forms.fit(form, p, y + np.log(p.onset))
    constants, (left,), *_ = np.linalg.lstsq(design, y)
    np.testing.assert_allclose(found.constants, constants, rtol=1e-6)
    error = np.sqrt(np.diag(np.linalg.inv(design.T @ design)) * left / (COUNT - 4))
    half = scipy.stats.t.ppf(0.975, COUNT - 4) * error
    np.testing.assert_allclose(found.high - found.constants, half, rtol=1e-5)
    np.testing.assert_allclose(found.constants - found.low, half, rtol=1e-5)
    assert found.rms == pytest.approx(np.sqrt(left / COUNT), rel=1e-6)
    away = np.empty(COUNT)
    for k in range(10):
        rest = np.arange(COUNT) % 10 != k
        away[~rest] = design[~rest] @ np.linalg.lstsq(design[rest], y[rest])[0] - y[~rest]
    assert found.held_out_rms == pytest.approx(np.sqrt(np.mean(away**2)), rel=1e-5)
    assert found.held_out_largest == pytest.approx(np.abs(away).max(), rel=1e-5)


def test_an_exact_fit_has_a_finite_criterion():
    # red: np.log(0) of a residual that vanishes on some processors
    with np.errstate(all="raise"):
        assert np.isfinite(information(np.zeros(12), 4))
