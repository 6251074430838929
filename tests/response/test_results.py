"""What a study asks of the response is done, or refused by name."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.broadband import SINGLE_TONES
from pidpanel.response.from_study import read_response_panel, write_response
from pidpanel.response.results import OutsideSimulatedRange
from pidpanel.study import load_study
from tests.jobs import PANEL, RESPONSE, SOUND, files, make_panel, make_sound, within


@pytest.fixture(scope="module")
def upstream(tmp_path_factory, write_study, table_values):
    """Files of panel and sound."""
    folder = tmp_path_factory.mktemp("upstream")
    study = write_study(folder, "table", table_values())
    make_panel(study, folder)
    make_sound(study, folder, air=True)
    return files(within(folder, PANEL | SOUND | {"air": "air.nc"}))


@pytest.fixture
def summary_of(tmp_path, upstream, write_study, table_values):
    """summary.csv of the table study with a change."""

    def make(name, change):
        values = table_values()
        change(values)
        study = load_study(write_study(tmp_path, name, values))
        made = files({key: tmp_path / f"{name}_{file}" for key, file in RESPONSE.items()})
        write_response(study, upstream, made, None, None)
        return pd.read_csv(made.summary).set_index(["scenario", "point"])

    return make


def test_the_air_lowers_the_bare_panel(summary_of):
    vacuum = summary_of("vacuum", lambda values: None)
    air = summary_of("air", lambda values: values["response"].update(radiation="one_side"))
    for at in [("bare_150dB", "centre"), ("bare_140dB", "Edge")]:
        # one side of air takes 5 dB from the paper's panel over its whole range
        assert air["acceleration_rms_g"][at] < 0.95 * vacuum["acceleration_rms_g"][at]


def test_motion_outside_the_simulated_range_is_marked_or_refused(summary_of):
    def louder(outside):
        def change(values):
            values["sound"]["oaspl_db"] = 175
            values["scenarios"] = {"fill": {"patch": "PID-1", "fill_fraction": [0.3, 0.8]}}
            values["damping"] = {"level": {"kind": "patch", "outside": outside}}

        return change

    marked = summary_of("mark", louder("mark"))
    assert (marked["outside_run_points_share"] == 1).sum() > 0
    with pytest.raises(
        OutsideSimulatedRange, match=r"PID-1_r0\.3_175dB: C_e is evaluated at .* g, "
    ):
        summary_of("refuse", louder("refuse"))


def test_without_damper_mass_the_patch_is_a_dashpot(summary_of):
    heavy = summary_of("heavy", lambda values: None)
    plain = summary_of("plain", lambda values: values["response"].update(damper_mass=False))
    at = ("PID-1_r0.8_150dB", "centre")
    # 3 kg/m² beside 4 kg/m² of the panel
    assert heavy["acceleration_rms_g"][at] != pytest.approx(
        plain["acceleration_rms_g"][at], rel=0.01
    )
    assert plain["acceleration_rms_error_g"][at] < heavy["acceleration_rms_error_g"][at] * 1.5
    assert plain["acceleration_rms_error_g"][at] > 0


def test_the_diagonal_form_says_what_it_costs_and_the_full_one_costs_nothing(summary_of):
    def diagonal(values):
        values["response"]["modal_damping"] = "diagonal"

    full, paper = summary_of("full", lambda values: None), summary_of("diagonal", diagonal)
    assert (full["diagonal_form_error_db"] == 0).all()
    damped = paper[paper["patch"] != "none"]
    assert (damped["diagonal_form_error_db"].abs() > 1e-3).any()


def test_a_stated_motion_is_where_the_damping_is_read(summary_of):
    def stated(values):
        values["damping"] = {"level": {"kind": "stated", "acceleration_g": 12}}

    found = summary_of("stated", stated)
    damped = found[found["patch"] != "none"]
    assert (damped["damping_read_at_g"] == 12).all()


def test_air_without_its_file_is_refused(upstream, tmp_path, write_study, table_values):
    values = table_values()
    values.setdefault("response", {})["radiation"] = "one_side"
    study = load_study(write_study(tmp_path, "table", values))
    with pytest.raises(ValueError, match="the file of the air is required"):
        others = {name: paths for name, paths in upstream.all.items() if name != "air"}
        read_response_panel(study, files(others))


def test_the_error_contains_what_single_tones_leave_out(summary_of):
    found = summary_of("model", lambda values: None)
    rows = found[found["added_mass_kg"] > 0]
    effect = rows["reduction_db"] - rows["dead_weight_reduction_db"]
    assert rows["model_error_db"].to_numpy() == pytest.approx(
        np.hypot(SINGLE_TONES.of_effect * effect, 20 / np.log(10) * SINGLE_TONES.of_rms), rel=1e-4
    )
    assert (rows["reduction_error_db"] >= rows["model_error_db"]).all()
    assert (rows["model_error_db"] > 0).all()


def test_a_panel_that_moves_by_more_than_a_tenth_of_its_thickness_is_stretched(summary_of):
    def loud(values):
        values["sound"]["oaspl_db"] = 168
        values["scenarios"] = {
            "level": {"patch": "PID-1", "fill_fraction": 0.8, "oaspl_db": [120, 168]}
        }

    rows = summary_of("loud", loud)
    quiet = rows[rows["oaspl_db"] == 120.0]
    assert not quiet["beyond_linear_plate"].any()
    assert quiet.filter(like="stretched").isna().all(axis=None)
    loud_rows = rows[(rows["oaspl_db"] == 168.0) & (rows["status"] == "ok")]
    assert loud_rows["beyond_linear_plate"].any()
    at = loud_rows.index.get_level_values("scenario") == "bare_168dB"
    bare, damped = loud_rows[at].droplevel(0), loud_rows[~at].droplevel(0)
    for case in (bare, damped):
        assert (case["frequency_shift_percent"] > 0).all()
        assert (case["frequency_shift_error_percent"] > 0).all()
        ratio = case["stretched_displacement_rms_mm"] / case["displacement_rms_mm"]
        assert (ratio < 1).all()
        assert (case["stretched_displacement_rms_error_mm"] > 0).all()
    column = "stretched_acceleration_rms_g"
    gain = 20 * np.log10(bare[column] / damped[column])
    np.testing.assert_allclose(damped["stretched_reduction_db"], gain, rtol=1e-4, atol=1e-4)
    linear = bare["acceleration_rms_error_g"].fillna(0) / bare["acceleration_rms_g"]
    relative = bare["stretched_acceleration_rms_error_g"] / bare[column]
    assert (relative > linear).all()
