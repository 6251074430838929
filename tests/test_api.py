"""A study in; damping, modes and responses out, as xarray: what notebooks and examples use."""

import re
import runpy
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import pidpanel
from pidpanel.damping.laws import paper_corrected
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
    assert modes.sizes["mode"] == len(pd.read_csv(model._stages["modes.csv"]))
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
        pidpanel.StudyError, match=r"it has no damping .* are in results/layouts/coupled"
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
