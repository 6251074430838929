"""A study in; damping, modes and responses out, as xarray: what notebooks and examples use."""

import re
import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import pidpanel
from pidpanel.damping.laws import paper_corrected
from pidpanel.provenance.results import read_csv
from pidpanel.study.writing import plain

STUDIES = Path(__file__).parents[1] / "workflow" / "studies"
EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


@pytest.fixture(scope="module")
def model(law_values):
    """The small panel with the paper's law, as a mapping."""
    values = law_values()
    values["dampers"] = {"paper": values["dampers"]["paper"]}
    values["scenarios"] = {"fill": values["scenarios"]["fill"] | {"damper": "paper"}}
    return pidpanel.Model(values)


def test_the_damping_is_that_of_the_law(model):
    found = model.damping(fill_fraction=[0.3, 0.8], frequency_hz=[50, 100, 140], acceleration_g=[5])
    assert dict(found.sizes) == {"fill_fraction": 2, "frequency": 3, "acceleration": 1}
    for fill in (0.3, 0.8):
        expected = paper_corrected(np.array([50.0, 100.0, 140.0]), fill)
        read = found["equivalent_damping"].sel(fill_fraction=fill).squeeze().to_numpy()
        np.testing.assert_allclose(read, expected)
    assert {name: one.attrs["units"] for name, one in found.items()} == {
        "equivalent_damping": "N s m-3",
        "equivalent_damping_error": "N s m-3",
        "apparent_mass": "kg m-2",
        "inside": "1",
    }


def test_modes_are_those_of_the_panel_in_order(model):
    modes = model.modes()
    frequency = modes["natural_frequency"]
    assert frequency.attrs["units"] == "Hz" and bool((frequency.diff("mode") >= 0).all())
    # Navier: f = π/2 √(D/m″) ((m/a)² + (n/b)²)
    orders = np.array([(1, 1), (2, 1), (1, 2)]) / (1.5, 1.0)
    exact = np.pi / 2 * np.sqrt(3273.07 / 4.0) * (orders**2).sum(axis=1)
    np.testing.assert_allclose(frequency[:3], exact, rtol=2e-3)
    assert modes.sizes["mode"] == len(pd.read_csv(model._stages.files("panel").table))
    assert list(modes["point"].to_numpy()) == ["centre", "Edge"]


def test_the_response_has_its_rms_values_with_units(model):
    found = model.response()
    one = found.sel(scenario="PID-1_r0.8_150dB", point="centre")
    psd = one["acceleration_psd"].to_numpy()
    rms = np.sqrt(np.trapezoid(psd, found["frequency"].to_numpy()))
    assert float(one["acceleration_rms"]) == pytest.approx(rms, rel=1e-3)
    assert found["acceleration_rms"].attrs["units"] == "m s-2"
    summary = model.summary().set_index(["scenario", "point"])
    assert float(one["reduction"]) == summary.loc[("PID-1_r0.8_150dB", "centre"), "reduction_db"]


def test_a_summary_judges_the_rms_values_by_their_limits(model):
    loudest = model.summary()["acceleration_rms_g"].max()
    judged = model.changed({"limits": {"centre": {"rms_g": 2 * loudest}}}).summary()
    rows = judged[judged["point"] == "centre"]
    assert set(rows["rms_verdict"]) == {"met"}
    assert (rows["rms_margin_db"] >= 20 * np.log10(2) - 1e-9).all()


# ------------------------------------------------------------------ stress, base motion, layouts


@pytest.fixture(scope="module")
def shaken(model):
    """The small panel on a shaker too, with a search of layouts."""
    return model.changed(
        {
            "base": {"random": {"spectrum": "gevs_acceptance.csv"}},
            "dampers": {"paper": {"equivalent_damping_n_s_m3": 1000, "apparent_mass_kg_m2": 1}},
            "scenarios": {"pot": {"layout": {"PID-1": {"damper": "paper"}}}},
            "optimise": {
                "mass_kg": 0.1, "patch_size_m": [0.3, 0.25], "spacing_m": [0.5, 0.5], "points": ["centre"]
            },
        }
    )  # fmt: skip


def test_responses_of_varied_models_on_the_same_lines_join_without_gaps(model):
    lines = model.response()["frequency"]
    stiffer = model.changed({"panel.damping_ratio": 0.03, "panel.section.thickness_mm": 20})
    joined = xr.concat([model.response(), stiffer.response(lines)], "ratio", join="exact")
    assert joined.sizes["frequency"] == lines.size and not bool(
        joined["acceleration_psd"].sel(scenario=["bare_150dB"]).isnull().any()
    )
    # computed there, not read between other lines: to the rms on lines of its own
    rms = [one["acceleration_rms"] for one in (stiffer.response(lines), stiffer.response())]
    np.testing.assert_allclose(rms[0], rms[1], rtol=1e-3)
    lighter = model.changed({"panel.damping_ratio": 0.01})
    with pytest.raises(ValueError, match=r"lines: up to .* apart; must be at most"):
        lighter.response(lines)
    with pytest.raises(ValueError, match="lines: from 50 to 150 Hz; must be from 40 to 150 Hz"):
        model.response(np.geomspace(50, 150, 1000))


def test_stresses_have_the_rms_of_the_table_of_stresses(model):
    stress = model.stress()
    table = read_csv(model._stages.files("response").stress_table, dtype={"point": str})
    row = table.query("scenario == 'bare_150dB' and point == 'centre' and quantity == 'stress_xx'")
    place = {"scenario": "bare_150dB", "point": "centre", "layer": row["layer"].iloc[0]}
    rms = stress["stress_xx_rms"].sel(place)
    assert stress["stress_xx_rms"].attrs["units"] == "Pa" and row["unit"].iloc[0] == "MPa"
    assert float(rms) == pytest.approx(1e6 * row["rms"].iloc[0], rel=1e-4)


def test_base_motion_shakes_a_point_with_the_rms_of_its_psd(shaken):
    motion = shaken.base()
    assert motion["absolute_acceleration_psd"].attrs["units"] == "m2 s-4 Hz-1"
    psd = motion["absolute_acceleration_psd"].sel(scenario="bare", point="centre", input="stated")
    table = read_csv(shaken._stages.files("base").summary, dtype={"point": str})
    row = table.query("scenario == 'bare' and point == 'centre' and input == 'stated'")
    rms = float(np.sqrt(psd.integrate("frequency"))) / 9.80665
    assert rms == pytest.approx(row["acceleration_rms_g"].iloc[0], rel=1e-3)
    with pytest.raises(pidpanel.StudyError, match="motion = sine: must be a part of base"):
        shaken.base("sine")


def test_proposed_layouts_keep_the_budget(shaken):
    front = shaken.optimise()
    assert len(front) > 0 and (front["mass_kg"] <= 0.1).all()


def test_a_study_without_a_section_says_which(model):
    for ask, section in ((model.base, "base"), (model.optimise, "optimise")):
        with pytest.raises(pidpanel.StudyError, match=f"{section}: missing"):
            ask()


def test_a_figure_has_the_psd_of_every_scenario_in_g(model):
    (axes,) = model.plot("Edge").axes
    response = model.response().sel(point="Edge")
    curves = {line.get_label().split(":")[0]: line for line in axes.get_lines()}
    assert set(curves) == set(response["scenario"].to_numpy())
    shown = curves["bare_150dB"].get_ydata() * 9.80665**2
    np.testing.assert_allclose(shown, response["acceleration_psd"].sel(scenario="bare_150dB"))
    with pytest.raises(pidpanel.StudyError, match="point = edge: must be one of centre, Edge"):
        model.plot("edge")


# ------------------------------------------------------------------ mistakes


def test_the_sound_sums_up_to_its_level(model):
    levels = model.sound()["band_spl"]
    assert 10 * np.log10((10 ** (levels / 10)).sum()) == pytest.approx(150, abs=1e-3)


def test_a_mistake_in_a_mapping_is_told_without_a_file(law_values):
    values = law_values()
    values["sound"]["sped_m_s"] = 343
    with pytest.raises(pidpanel.StudyError, match=r"^sound\.sped_m_s = 343: unknown key"):
        pidpanel.Model(values)


def test_what_rests_on_liggghts_asks_for_a_run(tmp_path):
    model = pidpanel.Model("smoke.yaml", tmp_path)
    for ask in (model.response, model.cases, lambda: model.damping("acrylic")):
        with pytest.raises(pidpanel.ResultsError, match=r"missing; .* call run\(\) first"):
            ask()
    with pytest.raises(pidpanel.StudyError, match="must be one of acrylic, paper"):
        model.damping()
    with pytest.raises(pidpanel.StudyError, match="panel: missing"):
        pidpanel.Model("coupon_friction.yaml").modes()


def test_coupled_runs_ask_for_a_run_and_have_no_damping_of_any_motion(tmp_path):
    model = pidpanel.Model("layouts.yaml", tmp_path)
    with pytest.raises(pidpanel.ResultsError, match=r"missing; .* call run\(\) first"):
        model.response()
    with pytest.raises(
        pidpanel.StudyError, match=r"has no damping .* are in results/layouts/coupled"
    ):
        model.damping("acrylic")


def test_a_study_with_another_value_is_the_same_study_otherwise(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "levels.csv").write_text("center_hz,spl_db\n31.5,120\n63,126\n125,130\n")
    text = (STUDIES / "l_panel.yaml").read_text(encoding="utf-8")
    text = text.replace("smc_s_016_2014_min_third.csv", "levels.csv")
    text = re.sub(r"frequency_hz: \[.*\]", "frequency_hz: [30, 1.3e+2]", text)
    text = text.replace("    A: ", "    1.50: ")
    (tmp_path / "mine" / "mine.yaml").write_text(text, encoding="utf-8")
    first = pidpanel.Model("mine/mine.yaml")
    second = first.changed({"panel.damping_ratio": np.float64(0.02)})
    third = second.changed({"sound.oaspl_db": 140})
    assert [m.study.panel.damping_ratio for m in (first, second, third)] == [0.01, 0.02, 0.02]
    assert third.study.oaspl_db == 140 and second.study.name == "mine"
    assert "1.50" in second.study.panel.points
    assert second.study.sound.spectrum == first.study.sound.spectrum
    same = first.changed({"panel.damping_ratio": 0.01}).study
    assert same.model_dump() == first.study.model_dump()
    with pytest.raises(pidpanel.StudyError, match=r"panel\.damping_ratio = 2: must be above 0"):
        first.changed({"panel.damping_ratio": 2})
    with pytest.raises(pidpanel.StudyError, match=r"panel\.damping = 2: unknown key"):
        first.changed({"panel.damping": 2})
    with pytest.raises(pidpanel.StudyError, match=r"panel\.damping_ratio\.x: damping_ratio is not"):
        first.changed({"panel.damping_ratio.x": 2})


def test_values_of_numpy_and_paths_are_those_of_a_file():
    values = {"a": np.float64(1.5), "b": (np.arange(2), Path("x")), 3: {"c": None}}
    assert plain(values) == {"a": 1.5, "b": [[0, 1], "x"], "3": {"c": None}}


SAYS = {
    "damper_on_a_plate": "damped",
    "identify_particles": "These particles explain the measurement",
    "measured_table": "middle_r0.8_145dB",
    "own_bdf": "mode 5",
    "own_bead": "equivalent_damping_n_s_m3",
    "own_modes": "m s-2 rms",
    "own_spectrum": "137.0 dB overall",
    "two_layouts": "the lower rms at the worst point has: one",
}


def test_a_study_without_a_coupon_has_no_cases(model):
    with pytest.raises(pidpanel.StudyError, match="no tones are simulated"):
        model.cases()


def test_every_example_is_run_here():
    assert [path.stem for path in EXAMPLES] == sorted(SAYS)


@pytest.mark.liggghts
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs_and_says_what_it_should(path, capsys, monkeypatch):
    monkeypatch.setenv("PIDPANEL_WORKFLOW_PROCESS", "1")
    with pd.option_context("display.width", 200):
        runpy.run_path(str(path), run_name="__main__")
    said = capsys.readouterr()
    assert SAYS[path.stem] in said.out
    assert re.search(r"m s-2|N s/m³|\bHz\b|\bdB\b", said.out)
    assert "Traceback" not in said.err


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("fill_fraction", 7, "fill_fraction = 7: must be above 0 and at most 1"),
        ("frequency_hz", -1, "frequency_hz = -1: must be above 0"),
        ("frequency_hz", [100, np.inf], "frequency_hz = inf: must be above 0"),
        ("acceleration_g", [1, np.nan], "acceleration_g = nan: must be above 0"),
    ],
)
def test_damping_is_read_at_values_that_there_are(key, value, message):
    with pytest.raises(pidpanel.StudyError) as caught:
        pidpanel.Model("l_panel.yaml").damping(**{key: value})
    assert str(caught.value) == message
