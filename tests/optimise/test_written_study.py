"""The study of proposed layouts that `pidpanel optimise --write` makes."""

import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.cli.layouts import check_target, write_study
from pidpanel.paths import STUDIES
from pidpanel.study import StudyError

LAYOUTS = """layout,centre_x_m,centre_y_m,size_x_m,size_y_m,patch,damper,fill_fraction,mass_kg,acceleration_g
1,0.9,0.5,0.2,0.2,,acrylic,0.9,0.493,21.4
2,0.4,0.5,0.2,0.2,,acrylic,0.2,0.11,20.1
2,0.8,0.5,0.2,0.2,,acrylic,0.45,0.247,20.3
3,0.5,0.5,0.2,0.2,,acrylic,0.9,0.493,21.7
4,0.6,0.5,0.2,0.2,,acrylic,0.9,0.493,21.7
"""


@pytest.fixture
def design(tmp_path):
    file = tmp_path / "design.yaml"
    file.write_text((STUDIES / "design_launch.yaml").read_text())
    (tmp_path / "layouts.csv").write_text(LAYOUTS)
    return file


def test_the_study_of_the_best_layouts_has_their_patches_and_passes_its_check(design):
    file = design.with_name("best.yaml")
    write_study(design, design.with_name("layouts.csv"), file)
    study = checked_study(file)
    assert study.optimise is None and study.name == "best"
    assert list(study.scenarios) == ["layout_1", "layout_2", "layout_3"]
    filled = [scenario for scenario in study.all_scenarios() if not scenario.is_bare]
    fills = [tuple(filling.fill_fraction for filling in s.fillings.values()) for s in filled]
    assert fills == [(0.9,), (0.2, 0.45), (0.9,)]
    places = yaml.safe_load(file.read_text())["panel"]["patches"]
    assert [patch["centre_m"][0] for patch in places.values()] == [0.9, 0.4, 0.8, 0.5]


def test_a_study_is_written_beside_the_first_and_over_nothing(design):
    for name, force, message in (
        ("design.yaml", False, "exists; --force"),
        ("design.yaml", True, "exists; --force"),
        ("best.txt", False, "must end in .yaml"),
        ("folder/best.yaml", False, "must be in the folder of"),
    ):
        with pytest.raises(StudyError, match=message):
            check_target(design.parent / name, design, force=force)
    check_target(design.with_name("best.yaml"), design, force=False)
