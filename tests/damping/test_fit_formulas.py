"""Weights of the fit: only the ratios of the errors count."""

import numpy as np
import pytest

from pidpanel.damping import fit
from pidpanel.damping.laws import equation_5

FREQUENCY = np.array([30.0, 80.0, 250.0, 700.0, 1100.0, 2000.0])
ERROR = np.array([0.02, 0.1, 0.05, 0.05, 0.2, 0.3])
NOISE = np.array([0.3, -1.2, 0.8, 0.1, -0.9, 1.4])


def fields(estimate):
    return np.concatenate([estimate.value, estimate.low, estimate.high, [estimate.scatter]])


def test_errors_in_another_unit_change_nothing():
    # red: weight / np.sqrt(np.mean(weight**2)) → weight in `_weights`
    damping = equation_5(2 * np.pi * FREQUENCY, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    one, other = (fields(fit.fit_at_fill(FREQUENCY, damping, u * ERROR)) for u in (1, 7))
    np.testing.assert_allclose(other, one, rtol=1e-9)


def test_where_one_error_is_unknown_all_count_alike():
    # red: (error > 0).all() → .any() in `_weights`
    damping = equation_5(2 * np.pi * FREQUENCY, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    unknown = fit.fit_at_fill(FREQUENCY, damping, np.where(ERROR == 0.02, 0.0, ERROR))
    alike = fit.fit_at_fill(FREQUENCY, damping, np.ones(6))
    np.testing.assert_array_equal(fields(unknown), fields(alike))


def test_the_scatter_is_that_of_a_value_of_average_weight():
    # weighted least squares by numpy, with weights of mean square 1: s² = Σ(w e)²/(n − 3)
    # red: residual.shape[-1] - constants.shape[-1] → + in `_estimate`
    damping = equation_5(2 * np.pi * FREQUENCY, 2e-3, 1.9, 1e-4) * np.exp(ERROR * NOISE)
    omega = 2 * np.pi * FREQUENCY
    weight = (1 / ERROR) / np.sqrt(np.mean(1 / ERROR**2))
    design = np.stack([np.ones(6), np.log(omega), -omega / 1e4], axis=1) * weight[:, None]
    _, (left,), *_ = np.linalg.lstsq(design, np.log(2 * np.pi * damping * omega) * weight)
    found = fit.fit_at_fill(FREQUENCY, damping, ERROR)
    assert found.scatter == pytest.approx(np.sqrt(left / 3), rel=1e-6)


def test_data_that_ask_for_a_negative_factor_are_fitted_as_well_as_they_can_be():
    # C_e vanishes towards full: the full step from the start leaves a₁ > 0, halved steps do not
    # red: `length / 2` → `length`; np.inf → 0 for a₁ ≤ 0 in `fit_over_fill`
    true = np.array([np.log(2e-2), 3.0, -4.1, 2.1, -0.4, 2e-4, -1e-4])
    r, f = (g.ravel() for g in np.meshgrid(np.linspace(0.05, 0.97, 8), FREQUENCY, indexing="ij"))
    damping = equation_5(2 * np.pi * f, *fit.constants_at(r, true))
    assert (damping > 0).all()
    found = fit.fit_over_fill(f, r, damping, np.ones(r.size))
    np.testing.assert_allclose(found.value, true, rtol=1e-5)
