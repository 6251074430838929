"""The constants of a whole sweep: at every acceleration, at every fill and over fill."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.fit import AT_FILL, OVER_FILL, fit_accelerations, fit_at_fill
from pidpanel.damping.laws import equation_5
from pidpanel.damping.surface_cases import AXES, ERROR, VALUE

FREQUENCY = np.geomspace(40, 1500, 6)
OVER = {"ln_alpha": -6.0, "beta1": -0.5, "beta2": 0.8, "gamma0": 3.4, "gamma1": -0.4,
        "delta0": 2e-5, "delta1": 3e-5}  # fmt: skip


def constants(r, factor):
    """a₁, a₂, a₃ in the structure of Eq. 6, a₁ times a factor."""
    a1 = factor * np.exp(OVER["ln_alpha"]) * r * (1 + OVER["beta1"] * r + OVER["beta2"] * r**2)
    return a1, OVER["gamma0"] + OVER["gamma1"] * r, r * (OVER["delta0"] + OVER["delta1"] * r)


def sweep(miss=0.0, error=0.05, fills=(0.2, 0.5, 0.9)):
    rows = [
        (r, f, gamma, equation_5(2 * np.pi * f, *constants(r, factor)) * np.exp(miss * (-1) ** k))
        for gamma, factor in ((10.0, 1.0), (50.0, 0.4))
        for r in fills
        for k, f in enumerate(FREQUENCY)
    ]
    frame = pd.DataFrame(rows, columns=[*AXES, VALUE])
    return frame.assign(**{ERROR: error * frame[VALUE]})


def test_the_constants_of_a_sweep_that_has_the_form_come_back():
    table = fit_accelerations(sweep())
    assert len(table) == 2 * (len(OVER_FILL) + 3 * len(AT_FILL))
    for gamma, factor in ((10.0, 1.0), (50.0, 0.4)):
        of = table[table["acceleration_g"] == gamma]
        over = of[of["fill_fraction"].isna()].set_index("constant")
        expected = OVER | {"ln_alpha": OVER["ln_alpha"] + np.log(factor)}
        for name, value in expected.items():
            assert over["value"][name] == pytest.approx(value, rel=1e-5)
        assert (over["points"] == 18).all()
        at = of[of["fill_fraction"] == 0.5].set_index("constant")
        a1, a2, a3 = constants(0.5, factor)
        np.testing.assert_allclose(at["value"][list(AT_FILL)], [np.log(a1), a2, a3], rtol=1e-6)
        assert (at["points"] == 6).all()


def at_half(frame):
    table = fit_accelerations(frame)
    rows = table[(table["acceleration_g"] == 10) & (table["fill_fraction"] == 0.5)]
    return rows.set_index("constant")["value"][list(AT_FILL)].to_numpy()


def values_at_half(frame):
    of = frame[(frame["acceleration_g"] == 10) & (frame["fill_fraction"] == 0.5)]
    return of[VALUE].to_numpy(), (of[ERROR] / of[VALUE]).to_numpy()


def test_where_the_form_misses_by_more_than_the_errors_all_cases_count_alike():
    frame = sweep(miss=0.3, error=1e-3)
    frame.loc[::6, ERROR] /= 1000  # one of six known a thousand times better
    value, _ = values_at_half(frame)
    alike = fit_at_fill(FREQUENCY, value, np.ones(6)).value
    # the errors are 3e-3 of the miss, and count squared
    np.testing.assert_allclose(at_half(frame), alike, rtol=1e-4)


def test_where_the_errors_explain_the_miss_they_weigh_the_cases():
    frame = sweep(miss=0.01, error=0.5)
    frame.loc[::6, ERROR] /= 20
    value, error = values_at_half(frame)
    weighed = fit_at_fill(FREQUENCY, value, error).value
    np.testing.assert_allclose(at_half(frame), weighed, rtol=1e-9)


def test_half_explained_misses_leave_what_the_errors_do_not_explain():
    frame = sweep(miss=0.2, error=0.1)
    frame.loc[::6, ERROR] /= 4
    value, error = values_at_half(frame)
    scatter = fit_at_fill(FREQUENCY, value, np.ones(6)).scatter
    variance = error**2 + (scatter**2 - np.mean(error**2))
    np.testing.assert_allclose(
        at_half(frame), fit_at_fill(FREQUENCY, value, np.sqrt(variance)).value, rtol=1e-9
    )
