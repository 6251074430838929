"""What may be read from the atlas, and which coupons then need no runs."""

import json

import pytest
import yaml

from pidpanel.atlas.table import PACKAGE_FILE
from pidpanel.paths import ATLAS_CASES, STUDIES
from pidpanel.study import load_study, requirements


def studied(tmp_path, change):
    values = yaml.safe_load((STUDIES / "layouts.yaml").read_text())
    change(values)
    file = tmp_path / "mine.yaml"
    file.write_text(yaml.safe_dump(values))
    return load_study(file)


def read_as(*readings):
    return lambda values: values.update(damping={"readings": list(readings)})


@pytest.mark.parametrize(
    ("readings", "read", "simulated"),
    [
        (["atlas"], ["acrylic", "steel"], []),
        (["atlas", "coupled"], ["acrylic", "steel"], []),
        (["stated", "atlas"], ["acrylic", "steel"], ["acrylic", "steel"]),
        (["coupled"], [], []),
    ],
)
def test_coupons_of_the_atlas_are_simulated_for_other_models_alone(
    tmp_path, readings, read, simulated
):
    # red: ATLAS left out of BY_DAMPER, or among the models of `stated_dampers`
    study = studied(tmp_path, read_as(*readings))
    assert sorted(study.atlas_coupons) == read and sorted(study.coupons) == simulated


def test_no_sweep_is_needed(tmp_path):
    # red: `sweep: Sweep` without a default
    def change(values):
        read_as("atlas")(values)
        for damper in values["dampers"].values():
            del damper["coupon"]["sweep"]

    assert len(studied(tmp_path, change).atlas_coupons) == 2


@pytest.mark.parametrize(
    ("keys", "direction"),
    [
        ({}, "flat"),
        ({"gravity_direction": [0, 0, 1]}, "flat"),
        ({"gravity_direction": [1, 2, 0]}, "upright"),
        ({"gravity_direction": [1, 0, 1]}, None),
    ],
)
def test_gravity_is_along_or_across_the_motion(tmp_path, keys, direction):
    # red: the y component forgotten
    def change(values):
        values["dampers"]["steel"]["coupon"].update(keys)

    study = studied(tmp_path, change)
    assert requirements.direction_of(study.all_dampers["steel"].coupon) == direction


def test_ranges_are_those_of_the_table():
    # red: RESTITUTION = (0.2, 0.95)
    import pandas as pd

    cases = pd.read_csv(ATLAS_CASES)
    for column, allowed in (
        ("fill_fraction", requirements.FILLS),
        ("restitution", requirements.RESTITUTION),
        ("friction", requirements.FRICTION),
        ("width_per_diameter", requirements.WIDTH),
        ("depth_per_diameter", requirements.DEPTH),
    ):
        low, high = cases[column].min(), cases[column].max()
        assert 0.95 * allowed[0] <= low <= allowed[0] * 1.3, column
        assert allowed[1] / 1.3 <= high <= 1.05 * allowed[1], column
    assert json.loads(PACKAGE_FILE.read_text())["version"]
