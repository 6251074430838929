"""The stage on a small panel: both answers, one PSD, its interval, and refusals."""

import re

import numpy as np
import pandas as pd
import pytest

from pidpanel.api import Model
from pidpanel.panel.section import ThinSection
from pidpanel.study import StudyError
from tests.energy.panels import energy_panel

STUDY = {
    "panel": {
        "outline_m": [1.5, 1.0],
        "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.07},
        "mesh": {"elements": [30, 20]},
        "patches": {"A": {"centre_m": [0.95, 0.6], "size_m": [0.4, 0.4]}},
        "points": {"P": [0.31, 0.27], "edge": [0.0, 0.5]},
    },
    "dampers": {
        "light": {"equivalent_damping_n_s_m3": 3000, "apparent_mass_kg_m2": 0.4},
        "heavy": {"equivalent_damping_n_s_m3": 400, "apparent_mass_kg_m2": 2.2},
    },
    "scenarios": {"s": {"patch": "A", "damper": ["light", "heavy"]}},
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
    "response": {"frequency_hz": [700, 2000]},
    "energy": {"highest_hz": 6000},
}


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    return Model(STUDY, tmp_path_factory.mktemp("energy"))


@pytest.fixture(scope="module")
def found(model):
    return model.energy()


@pytest.mark.slow
def test_the_psd_is_modal_below_the_octave_and_energy_above(model, found):
    modal = model.response()
    assert found["status"].sel(scenario="bare", point="P") == "ok"
    low = found.sel(frequency=slice(700, 885))
    np.testing.assert_allclose(
        low["acceleration_psd"], modal["acceleration_psd"].sel(frequency=slice(700, 885))
    )
    high = found["acceleration_psd"].sel(scenario="bare", point="P", frequency=slice(2000, 6000))
    f = high["frequency"].to_numpy()
    pressure = 2e-5**2 * 10 ** (110.1 / 10)  # 3150 Hz in the table, of SMC-S-016
    panel = energy_panel(ThinSection(3273.07, 4.0), [1.5, 1.0])
    at = int(np.abs(f - 3150).argmin())
    expected = panel.response(f[at : at + 1]).acceleration[0]
    band = 10 ** (35.5 / 10) - 10 ** (34.5 / 10)
    assert high.to_numpy()[at] == pytest.approx(expected * pressure / band, rel=0.02)


@pytest.mark.slow
def test_rms_values_are_those_of_the_psd_and_a_support_rests(found):
    case = found.sel(scenario="A_light", point="P")
    mean_square = np.trapezoid(case["acceleration_psd"], case["frequency"])
    assert float(case["acceleration_rms"]) == pytest.approx(np.sqrt(mean_square), rel=1e-4)
    assert 0 < float(case["acceleration_rms_error"]) < 0.2 * float(case["acceleration_rms"])
    assert float(found["acceleration_rms"].sel(scenario="bare", point="edge")) == 0


@pytest.mark.slow
def test_a_heavy_damper_keeps_its_modal_answer_with_the_reason(model, found):
    case = found.sel(scenario="A_heavy", point="P")
    assert "m_a/m″ = 0.55" in str(case["status"].item())
    assert float(case["highest"]) == 2000
    rms = float(model.response()["acceleration_rms"].sel(scenario="A_heavy", point="P"))
    assert float(case["acceleration_rms"]) == pytest.approx(rms, rel=1e-4)
    assert np.isnan(case["acceleration_psd"].sel(frequency=slice(2001, None))).all()


@pytest.mark.slow
def test_the_damper_lowers_both_answers_alike(model, found):
    bands = pd.read_csv(model._stages.files("energy").bands).set_index(["scenario", "center_hz"])
    last = bands.loc["bare"].dropna(subset="difference_db").index[-3:]
    # η_d = C_e A_d/(ω m A) beside 2ζ; the mass of the panel and what it moves, and its waves
    mass = 4.0 + 0.4 * 0.16 / 1.5
    loss = 3000 * 0.16 / (2 * np.pi * last.to_numpy() * mass * 1.5)
    expected = 10 * np.log10((1 + loss / 0.02) * (mass / 4.0) ** 1.5)
    for name, error in (("energy_psd_g2_hz", 0.05), ("modal_psd_g2_hz", 0.35)):
        bare, light = (bands.loc[s].loc[last, name] for s in ("bare", "A_light"))
        np.testing.assert_allclose(10 * np.log10(bare / light), expected, atol=error, err_msg=name)
    assert (bands.loc["bare"].loc[last, "difference_db"].abs() < 0.6).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"sound.field": "uniform"},
            "energy = {highest_hz: 6000}: only allowed with sound.field: diffuse",
        ),
        ({"energy.highest_hz": 2000}, "energy.highest_hz = 2000: must be above"),
        (
            {"energy.highest_hz": 12000},
            "energy.highest_hz = 12000: must be at most 11220, the end of the sound",
        ),
        (
            {"sound.surroundings": {"wall_m": 0.1}},
            "energy = {highest_hz: 6000}: not allowed with a wall",
        ),
    ],
)
def test_what_has_no_statistical_energy_is_refused(model, changes, message):
    with pytest.raises(StudyError, match=re.escape(message)):
        model.changed(changes)
