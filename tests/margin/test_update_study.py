"""Tests of a panel with other inputs than the study has lead to its inputs, through the files."""

import copy

import numpy as np
import pandas as pd
import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.margin.from_study import SpreadStudy, write_margin
from pidpanel.provenance.files import stage_files

SPREADS = {
    "panel.damping_ratio": {"lognormal": [0.008, 0.016], "source": "assumed"},
    "panel.supports.rotational_stiffness_n_rad": {"lognormal": [100, 3000], "source": "assumed"},
    "dampers.blanket.equivalent_damping_n_s_m3": {"normal": [300, 500], "source": "assumed"},
    "sound.shift_db": {"normal": [-2, 2], "source": "assumed"},
}
BLANKET = {"layout": {"A": {"damper": "blanket"}}}
STUDY = {
    "panel": {
        "outline_m": [1.0, 0.8],
        "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.0},
        "supports": {"outline": "simply_supported", "rotational_stiffness_n_rad": 500},
        "damping_ratio": 0.012,
        "mesh": {"kind": "quadrilaterals", "elements": [8, 6]},
        "patches": {"A": {"centre_m": [0.45, 0.4], "size_m": [0.2, 0.2]}},
        "points": {"P": [0.5, 0.4]},
    },
    "dampers": {"blanket": {"equivalent_damping_n_s_m3": 400, "apparent_mass_kg_m2": 2.0}},
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "level": "median"},
    "response": {"frequency_hz": [60, 180]},
    "scenarios": {"A": BLANKET, "hall": {**BLANKET, "oaspl_db": 133}},
    "uncertain": SPREADS,
    "margin": {"runs_at_most": 64},
}  # fmt: skip
TRUTH = np.array([1.2, -1.0, -1.5, 1.0])
SHIFT_DB = 5.0  # of the sound of the hall over that of its scenario


def write(folder, values):
    file = folder / "study.yaml"
    file.write_text(yaml.safe_dump(values, sort_keys=False))
    return checked_study(file)


@pytest.fixture(scope="module")
def updated(tmp_path_factory):
    """Tables of the margin after three tests of the panel with the scores `TRUTH`."""
    folder = tmp_path_factory.mktemp("update")
    values = copy.deepcopy(STUDY)
    first = write(folder, values)
    # the layouts of this study are A and hall, then both 12 dB lower
    truth = SpreadStudy(first, None, TRUTH[None])
    (answer, inputs, layouts), edges = truth.run(0), truth.uncertain.band_edges
    frequency = np.unique(np.concatenate([edges.ravel(), edges.ravel() * (1 + 1e-9)]))
    for name, row, factor in (("bare", 0, layouts[1].factor), ("damped", 2, 1.0)):
        # without the shift of the launch, with the sound of the hall
        factor *= 10 ** ((SHIFT_DB - first.uncertain["sound.shift_db"].value(1.0)) / 10)
        psd = factor * answer.band_rms[row, 0] ** 2 / np.diff(edges, axis=1)[:, 0]
        place = np.clip(np.searchsorted(edges[:, 1], frequency, "left"), 0, len(edges) - 1)
        lines = {"frequency_hz": frequency, "acceleration_psd_g2_hz": psd[place]}
        pd.DataFrame(lines).to_csv(folder / f"{name}.csv", index=False, float_format="%.12g")
    levels = pd.read_csv(first.acoustics.spectrum, comment="#")
    power = 10 * np.log10(np.sum(10 ** (levels["spl_db"] / 10)))
    levels["spl_db"] += 133 - power + SHIFT_DB
    levels.to_csv(folder / "hall.csv", index=False)
    values["measurements"] = {
        "bare": {"file": "bare.csv", "point": "P", "scenario": "bare_133dB"},
        "damped": {"file": "damped.csv", "point": "P", "scenario": "hall"},
    }
    natural = inputs.basis.natural_frequency[:1].tolist()  # the others are residual vectors
    values["update"] = {
        "modal_survey": {"frequency_hz": dict(enumerate(natural, 1)), "frequency_error": 0.005},
        "acoustic": {
            "hall": {"measurements": ["bare", "damped"], "spectrum": "hall.csv",
                     "error_db": 0.3, "common_db": 0.1},
        },
    }  # fmt: skip
    study = write(folder, values)
    output = stage_files(study, folder)["margin"]
    (folder / "margin").mkdir()
    write_margin(study, None, output)
    tables = {name: pd.read_csv(getattr(output, name)) for name in ("ranges", "inputs", "tests")}
    return study, tables


def test_no_test_of_a_panel_within_the_spreads_is_refused(updated):
    assert updated[1]["tests"]["probability"].min() > 0.01
    assert updated[1]["tests"]["probability_together"].min() > 0.01


def test_tests_lead_to_the_inputs_that_they_show(updated):
    study, tables = updated
    inputs = tables["inputs"].set_index("input")
    keys = list(study.uncertain)
    for number in (0, 1, 2):  # ζ, the edges and the damper
        spread, row = study.uncertain[keys[number]], inputs.loc[keys[number]]
        assert row["updated_p05"] < spread.value(TRUTH[number]) < row["updated_p95"], keys[number]
        narrowed = np.log(row["updated_p95"] / row["updated_p05"])
        assert narrowed < 0.85 * np.log(row["stated_p95"] / row["stated_p05"]), keys[number]
    # tests have their own sound: they tell nothing of the level of the launch
    shift = inputs.loc["sound.shift_db"]
    assert shift["updated_p95"] - shift["updated_p05"] == pytest.approx(4.0, rel=0.1)


def test_ranges_after_tests_are_narrower_and_only_the_scenario_of_the_launch_is_judged(updated):
    ranges = updated[1]["ranges"]
    assert set(ranges["scenario"]) == {"A"}
    width = (ranges["p95_g"] - ranges["p05_g"]).groupby(ranges["inputs"]).mean()
    assert width["updated"] < width["stated"]
