"""C_e and m_a of bands as a reading of the damping, and as a table."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.random_reading import RandomReading, read_random, to_rows
from pidpanel.damping.readings import DampingError

BANDS = LinearApproximation(
    low=np.array([20.0, 100.0, 300.0]),
    high=np.array([100.0, 300.0, 1000.0]),
    frequency=np.array([50.0, 200.0, 800.0]),
    equivalent_damping=np.array([400.0, 900.0, -30.0]),
    equivalent_damping_error=np.array([40.0, 45.0, 200.0]),
    apparent_mass=np.array([3.0, 1.0, -0.5]),
    apparent_mass_error=np.array([0.3, 0.2, 0.1]),
    coherence=np.array([0.9, 0.5, 0.1]),
    common_psd=np.array([10.0, 40.0, 0.0]),
    own_psd=np.array([2.0, 8.0, 8.0]),
    packing_error=0.03,
)
READING = RandomReading(BANDS, weight=6.4, area=1e-4)


def test_between_bands_the_logarithm_of_the_damping_and_the_mass_are_linear_in_log_f():
    # red: `np.exp(hats @ np.log(…))` → `hats @ …`
    values = READING(np.array([10.0, 50.0, 100.0, 200.0]), 0.5, np.nan)
    assert values.equivalent_damping == pytest.approx([400, 400, 600, 900])
    assert values.apparent_mass == pytest.approx([3, 3, 2, 1])
    assert values.inside.tolist() == [False, True, True, True]
    ends = READING(np.array([19.9, 20.0, 1000.0, 1000.1]), 0.5, np.nan)
    assert ends.inside.tolist() == [False, True, True, False]


def test_what_is_not_resolved_does_not_feed_the_panel():
    # red: `np.maximum(bands.equivalent_damping, …)` → the first of both
    (value,) = READING(np.array([800.0]), 0.5, np.nan).equivalent_damping
    assert value == pytest.approx(100)


def test_errors_are_those_of_the_bands_and_of_the_packings():
    # red: `+ self.bands.packing_error**2` left out; `relative**2` → `relative`
    values = READING(np.array([50.0, 100.0]), 0.5, np.nan)
    assert values.equivalent_damping_error[0] == pytest.approx(400 * np.hypot(0.1, 0.03))
    half = np.hypot(np.hypot(0.1, 0.05) / 2, 0.03)
    assert values.equivalent_damping_error[1] == pytest.approx(600 * half)
    covariance = READING.covariance(np.array([50.0, 200.0]), 0.5, 1.0)
    assert covariance[0, 0] == pytest.approx(0.1**2 + 0.03**2)
    assert covariance[0, 1] == pytest.approx(0.03**2)
    assert covariance[2, 2] == pytest.approx(0.3**2 + 0.09**2)
    assert covariance[2, 3] == pytest.approx(0.09 * 0.03)
    assert (covariance[:2, 2:] == 0).all()
    assert (
        READING.cross_covariance(BANDS.frequency, (0.5, 1), (0.3, 2))
        == READING.covariance(BANDS.frequency, 0.5, 1)
    ).all()


def test_without_mass_it_is_a_dashpot_of_the_same_weight():
    # red: `if self.with_mass else` turned round
    dashpot = READING.without_mass()
    assert (dashpot(np.array([50.0, 200.0]), 0.5, 1.0).apparent_mass == 0).all()
    assert (dashpot.covariance(np.array([50.0]), 0.5, 1.0)[1:] == 0).all()
    assert dashpot.mass_per_area(0.3) == READING.mass_per_area(0.5) == 6.4


def test_errors_of_the_packings_alone():
    # red: `equivalent_damping_error=none` left out
    alone = READING.of_packings_alone
    covariance = alone.covariance(BANDS.frequency, 0.5, 1.0)
    assert covariance[:3, :3] == pytest.approx(np.full((3, 3), 0.03**2))
    found, own = (one(BANDS.frequency, 0.5, 1.0).equivalent_damping for one in (alone, READING))
    assert found == pytest.approx(own)


def test_the_force_of_the_cells_is_spread_over_their_area():
    # red: `* self.area` → `/ self.area`
    assert READING.common_force_psd(np.array([50.0, 100.0])) == pytest.approx([10, 20])
    assert READING.own_force_psd(np.array([50.0, 400.0])) == pytest.approx([2e-4, 8e-4])
    assert READING.common_force_psd(np.array([800.0])) < 1e-9


def test_it_comes_back_from_its_table(tmp_path):
    # red: a column of UNITS with the name of another
    rows = to_rows(READING, {"scenario": "both", "patch": "Left wing"})
    pd.DataFrame(rows).to_csv(tmp_path / "impedance.csv", index=False)
    (found,) = read_random(tmp_path / "impedance.csv").items()
    assert found[0] == ("both", "Left wing")
    assert (found[1].weight, found[1].area) == (6.4, 1e-4)
    for name, value in vars(BANDS).items():
        assert np.array_equal(getattr(found[1].bands, name), value), name


def test_a_table_of_one_band_is_a_table(tmp_path):
    # red: `.iloc[0]` → `.iloc[1]` in from_rows
    one = {n: v[:1] if isinstance(v, np.ndarray) else v for n, v in vars(BANDS).items()}
    rows = to_rows(
        RandomReading(LinearApproximation(**one), 6.4, 1e-4), {"scenario": 1, "patch": "b"}
    )
    pd.DataFrame(rows).to_csv(tmp_path / "impedance.csv", index=False)
    found = read_random(tmp_path / "impedance.csv")["1", "b"]
    assert found(np.array([30.0, 900.0]), 0.5, 1.0).equivalent_damping == pytest.approx([400, 400])


def test_a_table_without_a_column_is_named(tmp_path):
    # red: `if missing` → `if not missing`
    frame = pd.DataFrame(to_rows(READING, {"scenario": "a", "patch": "b"}))
    frame.drop(columns="coherence").to_csv(tmp_path / "impedance.csv", index=False)
    with pytest.raises(DampingError, match=r"impedance\.csv: no column coherence"):
        read_random(tmp_path / "impedance.csv")
