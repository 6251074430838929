"""An error that covers only some of the dampers of a scenario is none."""

import re

import numpy as np
import pytest

from pidpanel.report.from_study import partly_known
from pidpanel.report.inputs import without_errors
from pidpanel.study import load_study

DAMPERS = """
dampers:
  known: {equivalent_damping_n_s_m3: 100, equivalent_damping_error_n_s_m3: 5}
  unknown: {equivalent_damping_n_s_m3: 100}
  weight: {equivalent_damping_n_s_m3: 0, apparent_mass_kg_m2: 3}
"""
SCENARIOS = """
scenarios:
  both: {layout: {A: {damper: known}, B: {damper: unknown}}}
  sure: {layout: {A: {damper: known}, B: {damper: weight}}}
"""


@pytest.fixture(scope="module")
def mixed(tmp_path_factory, study_text):
    path = tmp_path_factory.mktemp("mixed") / "trial.yaml"
    head = study_text.partition("\nscenarios:")[0] + "\n"
    head = re.sub("^(dampers|claims):.*\\n(  .*\\n)*", "", head, flags=re.MULTILINE)
    path.write_text(head + DAMPERS + SCENARIOS)
    return load_study(path)


def test_a_damper_without_an_error_leaves_none_to_its_scenario(mixed, respond_to):
    assert partly_known(mixed) == ["both"]
    summary, psd = respond_to(mixed, {}, error_db=0.1)
    frame, curves = without_errors(partly_known(mixed), summary, psd)
    error = frame.set_index(["scenario", "point"])["acceleration_rms_error_g"]
    assert np.isnan(error["both", "middle"]) and error["sure", "middle"] > 0
    of = curves["acceleration_psd_log_error"].sel(point="middle")
    assert bool(of.sel(scenario="both").isnull().all())
    assert bool(of.sel(scenario="sure").notnull().all())
    # what was read stays as it was
    assert np.isfinite(summary.loc[summary["scenario"] == "both", "reduction_error_db"]).all()
