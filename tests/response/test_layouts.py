"""What the files of the stage say of layouts: masses, dead weight, errors, patches, supports."""

import copy

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.panel.files import read_basis
from pidpanel.response.exports import modal_damping
from pidpanel.response.from_study import scenarios_of, write_response
from pidpanel.response.psd_files import read_psd
from pidpanel.study import load_study
from tests.jobs import PANEL, RESPONSE, SOUND, make_panel, make_sound, within
from tests.jobs import files as named

AREA = 0.3 * 0.25
DAMPERS = {
    "pot": {
        "equivalent_damping_n_s_m3": 900,
        "equivalent_damping_error_n_s_m3": 90,
        "apparent_mass_kg_m2": 2,
        "particle_mass_per_area_kg_m2": 3,
    },
    "mass": {"equivalent_damping_n_s_m3": 0, "apparent_mass_kg_m2": 6},
    "nothing": {"equivalent_damping_n_s_m3": 0, "apparent_mass_kg_m2": 0},
    "law": {"law": "paper_corrected"},
    "lab": {"table": "lab.csv"},
}
LAYOUTS = {
    "both": {"PID-1": {"damper": "pot"}, "Left wing": {"damper": "mass"}},
    "heavy": {"PID-1": {"damper": "mass"}, "Left wing": {"damper": "mass"}},
    "alone": {"PID-1": {"damper": "pot"}},
    "beside": {"PID-1": {"damper": "pot"}, "Left wing": {"damper": "nothing"}},
    "unknown": {"PID-1": {"damper": "law", "fill_fraction": 0.5}, "Left wing": {"damper": "mass"}},
    "labs": {
        "PID-1": {"damper": "lab", "fill_fraction": 0.5},
        "Left wing": {"damper": "lab", "fill_fraction": 0.8},
    },
}


@pytest.fixture(scope="module")
def files_of(tmp_path_factory, write_study, law_values):
    """The files of the stage for the layouts above, with a change."""

    def make(name, change=lambda values: None):
        values = law_values()
        values["dampers"] = copy.deepcopy(DAMPERS)
        values["panel"]["masses"] = {"box": {"mass_kg": 0.6, "at_m": [1.2, 0.25]}}
        values["panel"]["points"]["rim"] = [0.75, 0.0]
        values["scenarios"] = {key: {"layout": one} for key, one in LAYOUTS.items()}
        values["scenarios"]["place"] = {"patch": ["PID-1"], "damper": "pot"}
        change(values)
        folder = tmp_path_factory.mktemp(name)
        path = write_study(folder, name, values)
        study = load_study(path)
        make_panel(path, folder)
        make_sound(path, folder)
        upstream = named(within(folder, PANEL | SOUND))
        files = named(within(folder, RESPONSE))
        write_response(study, upstream, files, None, None)
        return files

    return make


@pytest.fixture(scope="module")
def files(files_of):
    return files_of("layouts")


@pytest.fixture(scope="module")
def summary(files):
    return pd.read_csv(files.summary).set_index(["scenario", "point"])


def test_a_layout_weighs_what_its_dampers_weigh_on_their_areas(summary):
    at = summary.xs("centre", level="point")["added_mass_kg"]
    assert at["both"] == pytest.approx(AREA * (3 + 6), rel=1e-5)
    assert at["heavy"] == pytest.approx(AREA * 12, rel=1e-5)
    assert at["bare_150dB"] == 0
    percent = summary["added_mass_percent"]["both", "centre"]
    assert percent == pytest.approx(100 * AREA * 9 / (1.5 * 1.0 * 4 + 0.6), rel=1e-5)


def test_dead_weight_is_the_same_mass_in_the_same_places(summary):
    heavy = summary.loc["heavy"].loc[["centre", "Edge"]]
    np.testing.assert_allclose(
        heavy["dead_weight_acceleration_rms_g"], heavy["acceleration_rms_g"], rtol=1e-5
    )
    np.testing.assert_allclose(
        heavy["dead_weight_reduction_db"], heavy["reduction_db"], rtol=1e-4, atol=1e-5
    )
    both = summary.loc["both"].loc[["centre", "Edge"]]
    assert (both["reduction_db"] - both["dead_weight_reduction_db"] > 0.5).all()


def test_a_mass_that_is_not_known_has_no_dead_weight(summary):
    unknown = summary.loc["unknown"]
    assert unknown[["added_mass_kg", "added_mass_percent"]].isna().all(axis=None)
    assert unknown["dead_weight_reduction_db"].isna().all()
    assert unknown["acceleration_rms_g"].notna().all()


def test_a_layout_of_one_patch_is_the_scenario_of_a_family(summary):
    values = ["acceleration_rms_g", "reduction_db", "acceleration_rms_error_g", "patch_motion_g"]
    alone, place = summary.loc["alone"], summary.loc["PID-1_pot_150dB"]
    np.testing.assert_allclose(alone[values], place[values], rtol=1e-5)
    beside = summary.loc["beside"]
    np.testing.assert_allclose(alone["acceleration_rms_g"], beside["acceleration_rms_g"], rtol=1e-4)
    assert beside["patch"].iloc[0] == "PID-1+Left wing"
    assert beside[["fill_fraction", "damping_read_at_g", "patch_motion_g"]].isna().all(axis=None)


def test_the_stated_error_of_a_layout_is_that_of_a_changed_damper(files_of, summary):
    def stronger(values):
        values["dampers"]["pot"]["equivalent_damping_n_s_m3"] = 909

    changed = pd.read_csv(files_of("stronger", stronger).summary)
    changed = changed.set_index(["scenario", "point"])
    at = [("both", "centre"), ("both", "Edge"), ("alone", "Edge")]
    for one in at:
        before, after = (of["acceleration_rms_g"][one] for of in (summary, changed))
        # 1 % of C_e for a tenth of its standard error; first order within some percent
        expected = 10 * abs(after - before)
        assert summary["acceleration_rms_error_g"][one] == pytest.approx(expected, rel=0.05)


def test_a_point_on_a_support_says_so_and_has_no_nan(summary):
    rim = summary.xs("rim", level="point").drop("unknown")
    assert (rim["status"] == "held").all()
    for column in ("acceleration_rms_g", "reduction_db", "dead_weight_reduction_db"):
        assert (rim[column] == 0).all(), column
    assert (rim.loc["both", ["acceleration_rms_error_g", "reduction_error_db"]] == 0).all()
    others = summary.drop("rim", level="point")
    assert (others["status"] == "ok").all()


def test_every_filled_patch_has_a_row_with_its_motion_and_that_of_its_elements(files):
    rows = pd.read_csv(files.layouts).set_index(["scenario", "patch"])
    assert len(rows) == 2 * 5 + 2
    assert rows["area_m2"].to_numpy() == pytest.approx(AREA)
    assert rows["damper"]["both", "Left wing"] == "mass"
    assert rows["mass_kg"]["labs", "PID-1"] == pytest.approx(12 * 0.5 * AREA, rel=1e-4)
    labs = rows.loc["labs"]
    np.testing.assert_allclose(labs["damping_read_at_g"], labs["patch_motion_g"], rtol=1e-4)
    assert (rows["lowest_element_motion_g"] < rows["patch_motion_g"]).all()
    assert (rows["patch_motion_g"] < rows["highest_element_motion_g"]).all()
    assert rows["damping_read_at_g"]["both", "PID-1"] != rows["damping_read_at_g"]["labs", "PID-1"]


def test_the_damping_of_a_patch_is_none_where_it_is_not_filled(files):
    with xr.open_dataset(files.psd, engine="scipy") as psd:
        damping = psd["equivalent_damping"].load()
        weight = psd["dead_weight_acceleration_psd"].load()
        own = psd["acceleration_psd"].load()
    assert (damping.sel(scenario="alone", patch="PID-1") == 900).all()
    assert (damping.sel(scenario="alone", patch="Left wing") == 0).all()
    assert (damping.sel(scenario="bare_150dB") == 0).all()
    heavy = {"scenario": "heavy", "point": "centre"}
    np.testing.assert_allclose(weight.sel(heavy), own.sel(heavy), rtol=1e-6)


def test_elements_as_loads_of_their_own_are_the_patch_where_motion_plays_no_part(files_of, summary):
    def by_element(values):
        values["damping"] = {"level": {"by": "element"}}
        for name in ("heavy", "beside", "unknown", "place"):
            values["scenarios"].pop(name)

    files = files_of("elements", by_element)
    found = pd.read_csv(files.summary).set_index(["scenario", "point"])
    at = [("both", "centre"), ("both", "Edge"), ("alone", "Edge")]
    for column in ("acceleration_rms_g", "acceleration_rms_error_g", "added_mass_kg"):
        # quadrature of the elements is of order 5, of the patch exact
        np.testing.assert_allclose(found[column][at], summary[column][at], rtol=1e-3)
    rows = pd.read_csv(files.layouts).set_index(["scenario", "patch"])
    # a dry bed damps less where it moves more: the patch ends up with another motion
    labs = found["acceleration_rms_g"]["labs", "centre"]
    assert labs != summary["acceleration_rms_g"]["labs", "centre"]
    assert labs == pytest.approx(summary["acceleration_rms_g"]["labs", "centre"], rel=0.02)
    assert (found["motion_residual"] < 1e-5).all()
    np.testing.assert_allclose(
        rows.loc["labs"]["damping_read_at_g"], rows.loc["labs"]["patch_motion_g"], rtol=1e-4
    )


def test_the_modal_damping_of_a_layout_is_the_sum_over_its_patches(files):
    basis = read_basis(files.psd.with_name("modes.nc"))
    study = load_study(files.psd.with_name("layouts.yaml"))
    own, ratios = modal_damping(
        basis,
        study.panel.modal_damping,
        scenarios_of(study),
        read_psd(files.psd),
    )
    modes = np.isin(basis.natural_frequency, own) & ~basis.is_residual
    omega = 2 * np.pi * basis.natural_frequency[modes]
    patch = basis.patch_names.index("PID-1")
    D = np.diagonal(basis.patch_overlap[patch])[modes]
    alone = 0.02 + 900 * D / (2 * basis.modal_mass[modes] * omega)
    np.testing.assert_allclose(ratios["alone"], alone, rtol=1e-9)
    np.testing.assert_allclose(ratios["beside"], alone, rtol=1e-9)
    assert (ratios["labs"] > 0.02).all() and (ratios["heavy"] == 0.02).all()
