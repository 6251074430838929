"""What runs a study has, and what they cost."""

import copy

import numpy as np
import pytest
import yaml

from pidpanel.coupled.beds import cell_of
from pidpanel.coupled.from_study import coupled_scenarios, estimated_cpu_seconds
from pidpanel.paths import WORKFLOW
from pidpanel.study import load_study

LAUNCH = yaml.safe_load((WORKFLOW / "studies" / "launch.yaml").read_text())


@pytest.fixture
def study(tmp_path):
    def made(of, /, **keys):
        values = copy.deepcopy(LAUNCH) | {"scenarios": of}
        values["damping"] = {"coupled": keys}
        values["response"].pop("maps")
        values["sound"].pop("levels")
        path = tmp_path / "mine.yaml"
        path.write_text(yaml.safe_dump(values))
        return load_study(path)

    return made


def test_every_filled_scenario_has_its_runs_and_every_patch_its_bed(study):
    found = coupled_scenarios(
        study(
            {
                "level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [130, 136.7]},
                "two": {
                    "layout": {"PID-2": {"fill_fraction": 0.3}, "PID-3": {"fill_fraction": 0.5}}
                },
            },
            runs=2,
            cells=32,
        )
    )
    assert list(found) == ["PID-1_r0.5_130dB", "PID-1_r0.5_136.7dB", "two"]
    one, other = found["two"].beds[1]
    assert (one.fill_fraction, other.fill_fraction) == (0.3, 0.5)
    assert (one.packing.seed, one.packing.count) == (2, 32)
    # the beds of a fill are those of every level
    levels = [found[f"PID-1_r0.5_{level}dB"].beds for level in ("130", "136.7")]
    assert levels[0] == levels[1]


def test_the_cost_is_that_of_a_run_that_was_measured(study):
    # 752 spheres, 240000 steps at 50 MPa: 35 to 50 CPU-seconds, a fifth less with larger bins
    scenarios = {"level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [136.7]}}
    soft = estimated_cpu_seconds(study(scenarios, youngs_modulus_mpa=50))
    assert 25 < soft < 60
    assert 1.8 < estimated_cpu_seconds(study(scenarios, youngs_modulus_mpa=800)) / soft < 4
    assert estimated_cpu_seconds(study({**scenarios, "other": {**scenarios["level"],
        "oaspl_db": [130]}}, youngs_modulus_mpa=50)) == pytest.approx(2 * soft)  # fmt: skip


def test_beds_of_the_atlas_cost_as_much_as_if_they_were_coupled(study):
    scenarios = {"level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [136.7]}}
    values = study(scenarios, youngs_modulus_mpa=50)
    atlas = values.model_copy(
        update={
            "dampers": {
                name: damper.model_copy(update={"model": "atlas"})
                for name, damper in values.dampers.items()
            }
        }
    )
    filled = [scenario for scenario in atlas.all_scenarios() if not scenario.is_bare]
    assert estimated_cpu_seconds(atlas) == 0
    assert estimated_cpu_seconds(atlas, filled) == pytest.approx(estimated_cpu_seconds(values))
    assert estimated_cpu_seconds(values, filled) == 0


def test_spheres_belong_to_the_nearest_cell():
    centres = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    position = np.array([[0.1, 0.9], [0.8, 0.1], [-0.2, 0.0]])
    assert cell_of(position, centres).tolist() == [2, 1, 0]
