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


def atlas(values):
    for damper in values["dampers"].values():
        damper["model"] = "atlas"


def test_no_bed_of_the_atlas_is_simulated_and_none_needs_a_sweep(tmp_path):
    def change(values):
        atlas(values)
        for damper in values["dampers"].values():
            del damper["sweep"]

    study = studied(tmp_path, change)
    assert sorted(study.beds("atlas")) == ["acrylic", "steel"]
    assert not study.coupons and not study.is_coupled


@pytest.mark.parametrize(
    ("keys", "across"),
    [
        ({}, 0),
        ({"gravity_direction": [0, 0, 1]}, 0),
        ({"gravity_direction": [1, 2, 0]}, 1),
        ({"gravity_direction": [0, 1, 3**0.5]}, pytest.approx(0.25)),  # 30 degrees from the motion
        ({"gravity_direction": [1, 0, 0], "steady_acceleration_g": [0, 0, -1]}, pytest.approx(0.5)),
        ({"steady_acceleration_g": [2, 0, 1]}, 1),
    ],
)
def test_the_atlas_takes_gravity_at_any_angle_to_the_motion(tmp_path, keys, across):
    def change(values):
        values["dampers"]["steel"].update(keys)

    study = studied(tmp_path, change)
    assert study.dampers["steel"].transverse_share == across


def test_ranges_are_those_of_the_table():
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
