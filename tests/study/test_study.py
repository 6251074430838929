"""A mistake in a study is answered by one line with file, line, key, value and what is allowed."""

import copy
from pathlib import Path

import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.study import StudyError, load_any_study, load_study

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
TEMPLATES = Path(__file__).parents[2] / "templates"
SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())


def written(tmp_path, change):
    """smoke.yaml with one change, as a file."""
    values = copy.deepcopy(SMOKE)
    change(values)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False))
    return path


def refused(tmp_path, change):
    with pytest.raises(StudyError) as caught:
        load_study(written(tmp_path, change))
    text = str(caught.value)
    assert "\n" not in text, text
    assert "mine.yaml" in text
    return text


def setter(path, value):
    def change(values):
        *parents, last = path.split(".")
        for key in parents:
            values = values[key]
        values[last] = value

    return change


@pytest.mark.parametrize("name", sorted(p.name for p in STUDIES.glob("*.yaml")))
def test_every_shipped_study_is_accepted(name):
    assert load_any_study(STUDIES / name).name == name.removesuffix(".yaml")


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("coupon.sweep.fill_fraction", [0.4, 1.4], "coupon.sweep.fill_fraction[1] = 1.4: less than or equal to 1"),
        ("coupon.sweep.frequency_hz", [100, 100.0], "frequency_hz = 100 stands twice: two cases would carry one label"),
        ("coupon.cell.shape", "triangle", "coupon.cell.shape = triangle: 'hexagon', 'square' or 'circle'"),
        ("coupon.particles.distribution", {"kind": "normal"}, "coupon.particles.distribution.deviation_mm: missing"),
        ("coupon.particles.distribution", {"kind": "binary", "second_mm": 0.5, "second_share": 0.5},
         "the smallest sphere, 0.5 mm, is below 0.4 of the largest, 2.5 mm"),
        ("coupon.particles.shell_mm", 1.5, "shell_mm = 1.5: below half of diameter_mm = 2.5"),
        ("coupon.gravity_direction", [0, 0, 0], "gravity_direction = [0, 0, 0]: a direction"),
        ("coupon.sweep.displacement_mm", [0.1], "acceleration_g or displacement_mm: one of them"),
        ("coupon.vary", {"particles.friction": [0.1]}, "coupon.vary: for a study of the coupon alone"),
        ("coupon.vary", {"particles.colour": ["red"]}, "vary.particles.colour: no such key of the coupon; there are diameter_mm"),
        ("coupon.vary", {"particles.friction": [0.1, 7]}, "vary: particles.friction = 7: less than or equal to 5"),
        ("coupon.vary", {"sweep.fill_fraction": [0.1]}, "vary.sweep.fill_fraction: not this one"),
        ("coupon.deck", "mine.in.j2", "coupon.deck = mine.in.j2: no such file; a file beside the study or one of"),
        ("coupon.particles.diameter_mm", 8, "particles.diameter_mm = 8: at most 0.9 of the cell's"),
        ("panel.patches", {"PID-1": {"centre_m": [1.45, 0.5], "size_m": [0.3, 0.2]}},
         "patches.PID-1 covers x 1.3…1.6 m, y 0.4…0.6 m: it must lie on the panel, x 0…1.5 m"),
        ("panel.points", {"7": [2.0, 0.5]}, "points.7 = (2, 0.5) m: it must lie on the panel"),
        ("panel.damping_ratio", "much", "panel.damping_ratio = much: a valid number"),
        ("sound.spectrum", "nowhere.csv", "sound.spectrum = nowhere.csv: no such file"),
        ("sound.oaspl_db", float("nan"), "sound.oaspl_db = .nan: a finite number"),
        ("sound.shift_db", 3, "oaspl_db = 150 and shift_db = 3: one of the two"),
        ("sound.field", "plane_wave", "incidence_deg goes with field: plane_wave"),
        ("sound.incidence_deg", -10, "sound.incidence_deg = -10: greater than or equal to 0"),
        ("sound.azimuth_deg", 45, "azimuth_deg goes with field: plane_wave or progressive_wave"),
        ("sound.loaded_sides", 3, "sound.loaded_sides = 3: 1 or 2"),
        ("response.radiation", "both", "response.radiation = both: 'none', 'one_side' or 'two_sides'"),
        ("response.maps", ["PID-1"], "response.maps: PID-1: one of bare_150dB, PID-1_r0.4_150dB"),
        ("response.frequency_hz", [400, 100], "the second above the first"),
        ("scenarios.fill.patch", "PID-9", "scenarios.fill.patch = PID-9: one of panel.patches, PID-1"),
        ("scenarios.fill.fill_fraction", [0.4, 0.95], "scenarios.fill.fill_fraction = 0.95: within the fills of coupon.sweep, 0.4 to 0.8"),
        ("scenarios.fill.oaspl_db", [140, 150], "2 of patch, fill_fraction and oaspl_db are lists: exactly one may be"),
        ("damping.readings", ["dem", "dem"], "each one once"),
        ("damping.readings", ["paper"], "damping.readings[0] = paper: 'dem', 'paper_corrected', 'paper_printed' or 'table'"),
        ("damping.level", {"kind": "stated"}, "acceleration_g goes with kind: stated"),
        ("coupon.accuracy.max_cycles", 8, "max_cycles = 8: at least min_cycles = 10"),
        ("name", "a/b", "name = a/b: "),
    ],
)  # fmt: skip
def test_a_wrong_value_is_named_with_what_is_allowed(tmp_path, key, value, says):
    assert says in refused(tmp_path, setter(key, value))


def test_the_papers_diagonal_form_has_no_air(tmp_path):
    # red: the validator without its raise
    def change(values):
        values["response"] |= {"modal_damping": "diagonal", "radiation": "one_side"}

    assert "modal_damping: diagonal is the paper's form" in refused(tmp_path, change)


def test_an_unknown_key_is_refused_with_the_nearest_right_one_and_its_line(tmp_path):
    def change(values):
        values["coupon"]["cell"]["dept_mm"] = 3

    text = refused(tmp_path, change)
    line = written(tmp_path, change).read_text().splitlines().index("    dept_mm: 3") + 1
    assert f"mine.yaml:{line}: coupon.cell.dept_mm = 3: unknown key; did you mean depth_mm?" in text


def test_a_missing_key_is_named(tmp_path):
    text = refused(tmp_path, lambda values: values["panel"].pop("section"))
    assert "panel.section: missing" in text


def test_a_key_that_stands_twice_is_refused(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("title: a\ntitle: b\n")
    with pytest.raises(StudyError, match=r"mine\.yaml:2: title: stands twice"):
        load_study(path)


@pytest.mark.parametrize(
    ("text", "says"), [("", "empty"), ("a: [1,", "not YAML"), ("- 1", "a mapping")]
)
def test_what_is_no_mapping_is_refused(tmp_path, text, says):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    with pytest.raises(StudyError, match=says):
        load_study(path)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(StudyError, match="cannot be read"):
        load_study(tmp_path / "none.yaml")


def test_the_dem_reading_needs_a_coupon(tmp_path):
    text = refused(tmp_path, lambda values: values.pop("coupon"))
    assert "the section 'coupon' must be there" in text


def test_the_units_of_the_file_become_si():
    study = load_study(STUDIES / "paper.yaml")
    assert study.coupon.cell.depth == 0.025
    assert study.coupon.particles.youngs_modulus == 3.2e9
    assert study.panel.section.thickness == 0.025
    assert study.panel.patches["PID-1"].bounds == (0.65, 0.85, 0.4, 0.6)


def test_the_first_bare_panel_is_mapped_unless_others_are_named():
    # red: `or` the last label
    assert [s.label for s in load_study(STUDIES / "smoke.yaml").mapped_scenarios()] == [
        "bare_150dB"
    ]
    named = load_study(STUDIES / "paper.yaml").mapped_scenarios()
    assert [s.label for s in named] == ["bare_162dB", "PID-1_r0.5_162dB"]


def test_every_level_brings_its_bare_panel_first():
    scenarios = load_study(STUDIES / "paper.yaml").all_scenarios()
    bare = [s.label for s in scenarios if s.patch is None]
    assert bare == ["bare_162dB", "bare_142dB", "bare_152dB"]
    assert [s.patch for s in scenarios[:3]] == [None] * 3
    assert len({s.label for s in scenarios}) == len(scenarios)


def test_a_study_of_the_coupon_alone_needs_no_panel(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"coupon": SMOKE["coupon"]}))
    study = load_any_study(path)
    assert study.name == "mine"
    assert study.coupon is not None
    with pytest.raises(StudyError, match="a study of the coupon alone"):
        load_study(path)


def with_deck(tmp_path, text):
    (tmp_path / "own.in.j2").write_text(text)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"coupon": {**SMOKE["coupon"], "deck": "own.in.j2"}}))
    return path


def test_a_deck_of_ones_own_is_found_beside_the_study(tmp_path):
    text = (TEMPLATES / "shake.in.j2").read_text()
    study = checked_study(with_deck(tmp_path, text))
    assert study.coupon.deck == tmp_path / "own.in.j2"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("{{ cycles_file }} {{ steps_per_cycle }} {{ viscosity }}", "no variable viscosity; there"),
        ("{{ cycles_file }}", "steps_per_cycle is not used; the deck must write one row per cycle"),
        ("\n{% if %}", r"own.in.j2:2: "),
    ],
)
def test_a_deck_of_ones_own_is_checked_at_once(tmp_path, text, says):
    with pytest.raises(StudyError, match=says) as caught:
        checked_study(with_deck(tmp_path, text))
    assert "coupon.deck = " in str(caught.value)
    assert "\n" not in str(caught.value)
