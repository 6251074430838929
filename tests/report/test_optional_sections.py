"""Every optional section of a study, alone and empty: its page is written, or one line refuses it.

The stages run as they do in the workflow, without LIGGGHTS.
"""

import numpy as np
import pandas as pd
import pytest

from pidpanel.api import Model
from pidpanel.check import checked_study
from pidpanel.report.margins_section import levels_fragment, margin_lines
from pidpanel.severity.from_study import rms_margins
from pidpanel.study import StudyError
from pidpanel.workflow.in_process import compute

STUDY = """
panel:
  outline_m: [0.9, 0.6]
  section: {mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07}
  mesh: {elements: [6, 4]}
  patches: {A: {centre_m: [0.45, 0.3], size_m: [0.3, 0.3]}}
  points: {middle: [0.45, 0.3]}
dampers: {D: {equivalent_damping_n_s_m3: 500, apparent_mass_kg_m2: 3}}
scenarios: {s: {patch: A, damper: D}}
response: {frequency_hz: [50, 200]}
"""
SOUND = "sound: {spectrum: smc_s_016_2014_min_third.csv}\n"
SHAKER = "base: {random: {spectrum: gevs_qualification.csv}}\n"

WRITTEN = {
    "severity, empty": SOUND + "severity: {}",
    "strength of layers alone": SOUND + "severity: {strength: {layers: {tension_1_mpa: 300, "
    "compression_1_mpa: 300, tension_2_mpa: 300, compression_2_mpa: 300, shear_mpa: 170}}}",
    "energy, empty": SOUND + "energy: {}",
    "an envelope at named levels": (
        "sound: {spectrum: [smc_s_016_2014_min_third.csv, falcon9_cape_blankets_octave.csv], "
        "oaspl_db: 137, levels: {acceptance: 0, qualification: 6}}"
    ),
    "limits alone": SOUND + "limits: {middle: {psd: limit.csv}}",
    "notching of base motion, empty": SHAKER.replace("}}", "}, notching: {}}"),
    "limits of an rms value on a shaker": SHAKER + "limits: {middle: {rms_g: 20}}",
    "a sine sweep alone": "base: {sine: {frequency_hz: [60, 180], acceleration_g: 0.5}}",
}


def checked(folder, text):
    (folder / "limit.csv").write_text("frequency_hz,acceleration_psd_g2_hz\n60,1\n180,1\n")
    path = folder / "trial.yaml"
    path.write_text(STUDY + text)
    return checked_study(path), path


@pytest.mark.slow
@pytest.mark.parametrize("section", WRITTEN)
def test_a_section_alone_has_its_page(tmp_path, section):
    compute(*checked(tmp_path, WRITTEN[section]), tmp_path, 1)
    assert (tmp_path / "results" / "trial" / "report.html").is_file()


@pytest.mark.slow
def test_margins_are_those_of_the_summary_and_the_page_begins_with_the_best(tmp_path):
    notched = SHAKER.replace("}}", "}, notching: {points: {middle: {rms_g: 12}}}}")
    study, path = checked(tmp_path, SOUND + notched + "limits: {middle: {rms_g: 20}}")
    compute(study, path, tmp_path, 1)
    folder = tmp_path / "results" / "trial"
    base = pd.read_csv(folder / "base" / "summary.csv")
    tables = {
        "sound": pd.read_csv(folder / "response" / "summary.csv"),
        "base": base[base["input"] == "stated"],
        "notched base": base[base["input"] == "notched"],
    }
    margins = pd.read_csv(folder / "severity" / "margins.csv").set_index("excitation")
    for excitation, table in tables.items():
        rms = table.set_index("scenario")["acceleration_rms_g"]
        rows = margins.loc[excitation].set_index("scenario")
        np.testing.assert_allclose(rows["margin_db"], 20 * np.log10(20 / rms), atol=1e-4)
        assert (rows["verdict"] == np.where(rms <= 20, "met", "exceeded")).all()
    summary = Model(path, tmp_path).summary().set_index("scenario")
    expected = margins.loc["sound"].set_index("scenario")["margin_db"]
    np.testing.assert_allclose(summary["rms_margin_db"], expected, atol=1e-4)
    page = (folder / "report.html").read_text()
    assert all(line in page for line in margin_lines(study, margins.reset_index()))


def test_each_named_level_is_a_row_with_its_own_solution_and_margin(tmp_path):
    levels = "oaspl_db: 136, levels: {acceptance: 0, qualification: 6}}"
    study, _ = checked(
        tmp_path, SOUND.replace("}", f", {levels}") + "limits: {middle: {rms_g: 20}}"
    )
    rows = []
    for scenario in study.all_scenarios():
        for point, rms in (("middle", 10.0), ("edge", 12.0)):
            factor = (1 if scenario.is_bare else 0.8) * 10 ** ((scenario.oaspl_db - 136) / 20)
            rows.append({"scenario": scenario.label, "point": point, "status": "ok",
                         "acceleration_rms_g": rms * factor, "acceleration_rms_error_g": 0.1,
                         "reduction_db": 1.9, "reduction_error_db": 0.1, "doubts": ""})  # fmt: skip
    summary = pd.DataFrame(rows)
    margins = rms_margins(study, summary).assign(excitation="sound", doubts="")
    judged = levels_fragment(study, summary, margins).values["rows"]
    assert [(row["level"], row["point"]) for row in judged] == [
        ("acceptance (136 dB)", "middle"), ("qualification (142 dB)", "middle"),
    ]  # fmt: skip
    np.testing.assert_allclose(
        [[row["margin_db"], row["bare"]["margin_db"]] for row in judged],
        20 * np.log10(2) - np.array([[20 * np.log10(0.8), 0], [20 * np.log10(0.8) + 6, 6]]),
    )
    assert [row["point"] for row in levels_fragment(study, summary, None).values["rows"]] == [
        "edge", "edge",
    ]  # fmt: skip


def test_limits_without_a_random_motion_are_refused_in_one_line(tmp_path):
    sweep = "base: {sine: {frequency_hz: [60, 180], acceleration_g: 0.5}}\n"
    with pytest.raises(StudyError, match=r"limits.*: only allowed with a section sound"):
        checked(tmp_path, sweep + "limits: {middle: {rms_g: 20}}")


@pytest.mark.parametrize("section", ["base", "optimise", "sound"])
def test_a_section_that_cannot_be_empty_is_refused_in_one_line(tmp_path, section):
    with pytest.raises(StudyError) as raised:
        checked(tmp_path, SOUND * (section != "sound") + f"{section}: {{}}")
    assert all(f"{section}." in line for line in str(raised.value).split("\n"))
