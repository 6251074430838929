"""Measured points beside cases and the atlas: amplitudes, values and what is missing."""

import math

import numpy as np
import pandas as pd
import pytest

from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping.from_study import atlas_model, compare_measured
from pidpanel.damping.measured import compare, measured_points
from pidpanel.damping.table_files import read_columns
from pidpanel.study.coupon import Coupon

C, M = "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"
POINTS = f"""fill_fraction,frequency_hz,acceleration_g,{C},equivalent_damping_error_n_s_m3
0.5,100,5,1200,80
0.5,300,20,2500,200
0.3,170,33,600,30
"""


def points_of(folder, text):
    file = folder / "lab.csv"
    file.write_text(text)
    return measured_points(read_columns(file, scattered=True), 0.4)


def case(fill, frequency, gamma, damping, status="ok"):
    return {
        "fill_fraction": fill, "frequency_hz": frequency, "acceleration_g": gamma, C: damping,
        "equivalent_damping_error_n_s_m3": 10.0, M: 1.5, "apparent_mass_error_kg_m2": 0.1,
        "status": status,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "amplitude"),
    [("acceleration_g", 5.0), ("displacement_mm", 5 * STANDARD_GRAVITY / (200 * math.pi) ** 2 * 1e3),
     ("velocity_m_s", 5 * STANDARD_GRAVITY / (200 * math.pi))],
)  # fmt: skip
def test_any_amplitude_of_a_sine_is_an_acceleration(tmp_path, name, amplitude):
    points = points_of(tmp_path, f"frequency_hz,{name},{C}\n100,{amplitude},900\n")
    assert points["acceleration_g"].tolist() == pytest.approx([5.0])
    assert points["fill_fraction"].tolist() == [0.4]
    assert points[f"measured_{C}"].tolist() == [900]
    assert points[[f"measured_{C}_error", f"measured_{M}"]].isna().all(axis=None)


def test_scattered_points_are_no_table_but_can_be_measured(tmp_path):
    assert len(points_of(tmp_path, POINTS)) == 3
    with pytest.raises(ColumnsError, match="share neither amplitude nor frequency"):
        read_columns(tmp_path / "lab.csv")


def test_the_case_at_a_measured_point_is_the_one_that_counts_within_one_per_cent(tmp_path):
    points = points_of(tmp_path, POINTS)
    cases = pd.DataFrame(
        [case(0.5, 100.9, 5.0, 1000), case(0.5, 300, 21, 2000), case(0.35, 170, 33, 700),
         case(0.5, 100, 5, 1, "NotFinite")]
    )  # fmt: skip
    found = compare(points, cases, None)
    np.testing.assert_array_equal(found[f"simulated_{C}"], [1000, np.nan, np.nan])
    assert found[f"simulated_{M}"].iloc[0] == 1.5
    assert found[f"atlas_{C}"].isna().all()


def test_the_atlas_is_read_under_a_tone_where_it_holds(tmp_path):
    (tmp_path / "lab.csv").write_text(f"{POINTS}0.5,100,1900,1,0.1\n")
    coupon, file = Coupon.model_validate({"cell": {"depth_mm": 25}}), tmp_path / "lab.csv"
    found = compare_measured(coupon, file, pd.DataFrame([case(0.5, 100, 5, 1000)]))
    atlas = atlas_model(coupon, is_broadband=False)
    tone = atlas(np.array([300.0]), 0.5, 20.0)
    assert found[f"atlas_{C}"].iloc[1] == pytest.approx(tone.equivalent_damping[0])
    assert found[f"atlas_{C}_error"].iloc[1] == pytest.approx(tone.equivalent_damping_error[0])
    variance = atlas.covariance(np.array([300.0]), 0.5, 20.0)[1, 1]
    assert found[f"atlas_{M}_error"].iloc[1] ** 2 == pytest.approx(variance)
    assert np.isnan(found[f"atlas_{C}"].iloc[3])
    squares = coupon.model_copy(update={"cell": coupon.cell.model_copy(update={"shape": "square"})})
    assert (
        compare_measured(squares, file, pd.DataFrame([case(0.5, 100, 5, 1)]))[f"atlas_{C}"]
        .isna()
        .all()
    )
