"""A study of several coupons: its jobs, and what a change of one damper makes run again."""

import copy
from pathlib import Path

import pytest
import yaml
from reference_pages import untold

from tests.commands import jobs, said, snakemake
from tests.workflow.test_workflow import STUDIES

SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())


def values(seeds=1):
    """Two beads on two patches, and constants; a third coupon that no scenario names."""
    found = copy.deepcopy({key: SMOKE[key] for key in ("panel", "sound", "response")})
    light = copy.deepcopy(SMOKE["dampers"]["acrylic"])
    light["sweep"]["frequency_hz"] = [400]
    light["accuracy"] |= {"seeds": seeds, "coverage": 0.5}
    heavy = copy.deepcopy(light)
    heavy["particles"]["density_kg_m3"] = 7850
    heavy["sweep"]["fill_fraction"] = [0.4]
    found["panel"]["patches"]["PID-2"] = {"centre_m": [0.25, 0.5], "size_m": [0.3, 0.2]}
    found["dampers"] = {
        "light": light,
        "heavy": heavy,
        "spare": copy.deepcopy(heavy) | {"gravity_g": 0},
        "pot": {"equivalent_damping_n_s_m3": 900},
    }
    found["scenarios"] = {
        "both": {
            "layout": {
                "PID-1": {"damper": "light", "fill_fraction": 0.6},
                "PID-2": {"damper": "heavy", "fill_fraction": 0.4},
            }
        },
        "pots": {"patch": ["PID-1", "PID-2"], "damper": "pot"},
    }
    return found


def written(folder, found, name="two.yaml"):
    path = Path(folder) / name
    path.write_text(yaml.safe_dump(found, sort_keys=False))
    return path


def test_every_coupon_that_a_scenario_names_has_its_cases_and_its_surface(tmp_path):
    found = jobs(snakemake(tmp_path, written(tmp_path, values(seeds=2)), "-n"))
    assert found["cases"] == found["damping"] == 2
    # a packing for each bead and seed; beds of two fills and of one
    assert (found["pour"], found["loosen"]) == (4, 6)


def test_coupons_of_one_bead_share_their_packings_beds_and_runs(tmp_path):
    study = values()
    study["dampers"]["heavy"] = copy.deepcopy(study["dampers"]["light"])
    found = jobs(snakemake(tmp_path, written(tmp_path, study), "-n"))
    alone = values()
    del alone["scenarios"]["both"]["layout"]["PID-2"]
    once = jobs(snakemake(tmp_path, written(tmp_path, alone), "-n"))
    assert {key: found[key] for key in ("pour", "loosen", "shake")} == {
        key: once[key] for key in ("pour", "loosen", "shake")
    }
    assert found["cases"] == 2


def test_a_study_without_a_coupon_needs_neither_liggghts_nor_damping(tmp_path):
    study = values()
    del study["scenarios"]["both"]
    found = jobs(snakemake(tmp_path, written(tmp_path, study), "-n"))
    assert set(found) == {"panel", "sound", "response", "maps", "export", "report"}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """Folder in which the study of two beads was run to its page."""
    folder = tmp_path_factory.mktemp("two")
    result = snakemake(folder, written(folder, values()))
    assert result.returncode == 0, said(result)
    return folder


@pytest.mark.liggghts
def test_the_files_of_a_damper_are_in_its_folders(ran):
    results = ran / "results" / "two"
    for damper in ("light", "heavy"):
        assert (results / "coupon" / damper / "cases.csv").is_file()
        for name in ("surface.nc", "surface.csv", "law.csv"):
            assert (results / "damping" / damper / name).is_file()
    page = (results / "report.html").read_text()
    assert "Coupon: light" in page and "Coupon: heavy" in page


@pytest.mark.liggghts
@pytest.mark.parametrize(
    ("change", "runs"),
    [
        (lambda v: v["dampers"]["spare"].update(gravity_g=2), {"report"}),
        (lambda v: v["dampers"]["pot"].update(equivalent_damping_n_s_m3=800),
         {"response", "maps", "export", "report"}),
        (lambda v: v["dampers"]["heavy"]["particles"].update(restitution=0.7),
         {"loosen", "shake", "cases", "film", "damping", "response", "maps",
          "export", "report"}),
        (lambda v: v["scenarios"]["both"]["layout"]["PID-1"].update(fill_fraction=0.5),
         {"response", "maps", "export", "report"}),
        (lambda v: v.update(title="Another"), {"report"}),
    ],
)  # fmt: skip
def test_a_change_of_one_damper_runs_nothing_of_another(ran, change, runs):
    study = values()
    change(study)
    found = jobs(snakemake(ran, written(ran, study), "-n"))
    written(ran, values())
    assert set(found) == runs
    assert found.get("cases", 1) == found.get("damping", 1) == 1
    assert "pour" not in found


@pytest.mark.liggghts
def test_every_column_of_several_dampers_is_described(ran):
    assert untold(ran / "results" / "two")[0] == []
