"""What runs a study has, and what they cost."""

import copy

import numpy as np
import pytest
import yaml

from pidpanel.coupled.beds import cell_of
from pidpanel.coupled.from_study import coupled_runs, estimated_cpu_seconds, modulus_for
from pidpanel.paths import WORKFLOW
from pidpanel.study import StudyError, load_study

LAUNCH = yaml.safe_load((WORKFLOW / "studies" / "launch.yaml").read_text())


@pytest.fixture
def study(tmp_path):
    def made(of, /, **keys):
        values = copy.deepcopy(LAUNCH) | {"scenarios": of}
        values["damping"] = {"readings": ["dem", "coupled"], "coupled": keys}
        values["response"].pop("maps")
        path = tmp_path / "mine.yaml"
        path.write_text(yaml.safe_dump(values))
        return load_study(path)

    return made


def test_every_filled_scenario_has_its_seeds_and_every_patch_its_bed(study):
    # red: bare scenarios not left out; one seed for all beds
    found = coupled_runs(
        study(
            {
                "level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [130, 136.7]},
                "two": {
                    "layout": {"PID-2": {"fill_fraction": 0.3}, "PID-3": {"fill_fraction": 0.5}}
                },
            },
            seeds=2,
            cells=32,
        )
    )
    assert list(found) == [
        f"{name}/seed{seed}"
        for name in ("PID-1_r0.5_130dB", "PID-1_r0.5_136.7dB", "two")
        for seed in (1, 2)
    ]
    one, other = found["two/seed2"].beds
    assert (one.fill_fraction, other.fill_fraction) == (0.3, 0.5)
    assert (one.packing.seed, one.packing.count) == (2, 32)
    # the beds of a fill are those of every level
    levels = [found[f"PID-1_r0.5_{level}dB/seed1"].beds for level in ("130", "136.7")]
    assert levels[0] == levels[1]


def test_the_cost_is_that_of_a_run_that_was_measured(study):
    # 752 spheres, 463440 steps at 50 MPa: 50 to 66 CPU-seconds, four runs
    # red: settle_s left out; 1e6 left out of the modulus
    keys = {"youngs_modulus_mpa": 50}
    scenarios = {"level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [136.7]}}
    assert 180 < estimated_cpu_seconds(study(scenarios, **keys)) < 280
    stiff = study(scenarios, youngs_modulus_mpa=800)
    assert estimated_cpu_seconds(stiff) == pytest.approx(
        4 * estimated_cpu_seconds(study(scenarios, **keys)), rel=1e-9
    )


def test_contacts_are_stiffer_where_a_bed_may_ride_or_cross(study):
    # red: limits(0.0) in modulus_for; np.sqrt(2) left out makes W/L = 0.08 of 0.11
    scenarios = {"one": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [130]}}
    one = study(scenarios)
    (bed,) = coupled_runs(one)["PID-1_r0.5_130dB/seed1"].beds
    gap = 0.5 * bed.packing.depth

    def modulus(stroke_per_gap):
        speed = 1.0
        amplitude = stroke_per_gap * gap
        return modulus_for(one.coupon, bed, speed, speed * np.sqrt(2) * speed / amplitude)

    assert [modulus(x) / 1e6 for x in (0.09, 0.11, 0.4, 0.6)] == [50, 200, 200, 50]


def test_spheres_belong_to_the_nearest_cell():
    # red: axis=1
    centres = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    position = np.array([[0.1, 0.9], [0.8, 0.1], [-0.2, 0.0]])
    assert cell_of(position, centres).tolist() == [2, 1, 0]


def test_only_the_scenarios_asked_for_are_run_and_others_need_a_neighbour(study):
    # red: the list left out of `coupled_runs`; `_are_neighbours` always true; labels not looked at
    family = {"level": {"patch": "PID-1", "fill_fraction": 0.5, "oaspl_db": [130, 132, 136.7]}}
    one, other, far = (f"PID-1_r0.5_{level}dB" for level in ("130", "132", "136.7"))
    assert list(coupled_runs(study(family, scenarios=[one, far], seeds=2))) == [
        f"{label}/seed{seed}" for label in (one, far) for seed in (1, 2)
    ]
    with pytest.raises(StudyError, match=f"must contain {far}, or its layout within 3 dB"):
        study(family, scenarios=[other])
    with pytest.raises(StudyError, match="'PID-2' is no scenario"):
        study(family, scenarios=[one, far, "PID-2"])
