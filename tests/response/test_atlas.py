"""Responses with damping from the atlas: no runs, the study's own coupon, C_e as under sound."""

import numpy as np
import pytest

from pidpanel import Model
from pidpanel.damping.broadband import broadband_share, broadband_stroke
from pidpanel.paths import STUDIES
from pidpanel.study.writing import values_of

POINT = {"fill_fraction": 0.5, "frequency_hz": [120.0, 380.0], "acceleration_g": 20.0}


@pytest.fixture(scope="module")
def model():
    study = values_of(STUDIES / "smoke.yaml")
    cell = {"across_flats_mm": 6.35, "depth_mm": 25}
    study["dampers"] = {
        "acrylic": {"cell": cell, "particles": {"diameter_mm": 2}, "model": "atlas"}
    }
    study["sound"] = {"spectrum": study["sound"]["spectrum"]}
    study["scenarios"] = {"place": {"patch": "PID-1", "fill_fraction": 0.5}}
    study["base"] = {"sine": {"acceleration_g": 1.0, "frequency_hz": [100, 400]}}
    return Model(study)


def test_a_coupon_answers_without_a_run(model):
    rows = model.summary().set_index("scenario")
    filled = rows.loc["PID-1_r0.5"]
    assert filled["damping_source"] == "atlas of particle beds"
    assert filled["reduction_db"] > filled["dead_weight_reduction_db"]
    assert 0 < filled["reduction_error_db"] and 0 <= filled["between_share"] <= 1
    assert rows["added_mass_kg"].max() == pytest.approx(0.5 * 0.06 * 0.458 * 1190 * 0.025, rel=0.1)


def test_under_sound_its_damping_is_that_of_tones_of_the_broadband_stroke(model):
    gamma = model.summary().set_index("scenario").loc["PID-1_r0.5", "damping_read_at_g"]
    psd = model.response().sel(scenario="PID-1_r0.5", patch="PID-1")
    f = psd["frequency"].to_numpy()
    stroke = gamma * 9.80665 / (2 * np.pi * f) ** 2 / (0.025 * (1 - 0.94 * 0.5))
    shorter = broadband_stroke(stroke)
    tone = f * np.sqrt(stroke / shorter)
    tones = model.damping("acrylic", fill_fraction=0.5, frequency_hz=tone, acceleration_g=gamma)
    expected = broadband_share(shorter, 0.5) * tones["equivalent_damping"].to_numpy().ravel()
    np.testing.assert_allclose(psd["equivalent_damping"], expected, rtol=1e-3)


def test_a_damper_is_chosen_by_its_name(model):
    values = model.damping(**POINT)
    assert (values["equivalent_damping"] > 0).all() and (values["inside"] == 1).all()
    with pytest.raises(ValueError, match="source = atlas: must be one of acrylic"):
        model.damping("atlas", **POINT)


@pytest.mark.parametrize(("modulus", "is_soft"), [(3200, False), (5, True)])
def test_beds_softer_than_those_of_the_atlas_are_extrapolated(model, modulus, is_soft):
    # contacts of rubber last longer than 0.02 periods from 60 Hz on
    soft = model.changed({"dampers.acrylic.particles.youngs_modulus_mpa": modulus})
    row = soft.summary().set_index("scenario").loc["PID-1_r0.5"]
    assert (row["extrapolated_share"] > 0.05) == is_soft
    message = "extrapolated, extend the atlas to particles as soft as acrylic from "
    assert (message in str(row["doubts"])) == is_soft and (row["trusted"] == "no") >= is_soft
