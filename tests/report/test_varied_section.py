"""What is said of the keys that a study of the coupon varies."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report.from_study import varied_keys
from pidpanel.report.varied_section import (
    comparison,
    findings,
)
from pidpanel.study import CouponStudy


@pytest.fixture
def varied(cases):
    """The cases at three frictions; C_e grows like the root of μ."""
    frames = []
    for friction in (0.1, 0.4, 0.9):
        frame = cases.copy()
        frame["particles.friction"] = friction
        frame["equivalent_damping_n_s_m3"] *= np.sqrt(friction / 0.1)
        frames.append(frame)
    return pd.concat(frames, ignore_index=True)


def test_a_case_is_compared_with_that_at_the_first_value_all_else_equal(varied):
    found = comparison(varied, "particles.friction")
    assert len(found) == 2 * 12
    assert set(found["from"]) == {0.1}
    assert found["ratio"][found["to"] == 0.9].tolist() == pytest.approx([3.0] * 12)
    first = found.iloc[0]
    value = 500 * 0.3  # r = 0.3, 100 Hz
    assert first["deviation"] == pytest.approx(value / np.hypot(20, 20))


def test_the_bias_of_soft_contacts_counts_where_the_moduli_differ(varied):
    varied["equivalent_damping_error_n_s_m3"] = 30.0
    same = comparison(varied, "particles.friction")["deviation"]
    varied.loc[varied["particles.friction"] > 0.1, "youngs_modulus_mpa"] = 500.0
    other = comparison(varied, "particles.friction")["deviation"]
    assert (same / other).tolist() == pytest.approx([1.5] * 24)


def test_the_finding_names_the_largest_change_with_its_point(varied):
    (said,) = findings(varied, ["particles.friction"])
    assert said.startswith("Friction coefficient μ: from 0.1 to 0.9 Cₑ rises from 150 ± 20 to 450")
    assert "24 of 24 differences are beyond two standard errors" in said


def test_sizes_are_varied_only_where_there_are_several():
    sweep = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [5]}
    study = CouponStudy.model_validate({"name": "x", "coupon": {"sweep": sweep}})
    assert varied_keys(study) == []
    sweep["diameter_mm"] = [1, 2]
    study = CouponStudy.model_validate(
        {"name": "x", "coupon": {"sweep": sweep, "vary": {"particles.friction": [0.1]}}}
    )
    assert varied_keys(study) == ["particles.friction", "diameter_mm"]
