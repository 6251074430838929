"""Closed forms side by side: constants found, and the right one told from the wrong ones."""

import numpy as np
import pytest

from pidpanel.damping import forms
from pidpanel.damping.forms import FORMS, Points

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
