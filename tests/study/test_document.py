"""What is no study at all, and what YAML allows beside plain keys and values."""

from pathlib import Path

import pytest
import yaml

from pidpanel.study import StudyError, load_any_study, load_study
from pidpanel.study.document import Document
from pidpanel.study.loader import Content

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
BED = yaml.safe_load((STUDIES / "smoke.yaml").read_text())["dampers"]["acrylic"]
del BED["model"]


def refused(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(StudyError) as caught:
        load_any_study(path)
    return str(caught.value).replace(f"{tmp_path}/", "")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "mine.yaml: is empty; must be a mapping with keys such as name, coupon, panel"),
        ("- 1", "mine.yaml: must be a mapping with keys such as name, coupon, panel"),
        ("a: [1,", "mine.yaml:1: not YAML: a list or a mapping is not closed"),
        ("a: [1\n", "mine.yaml:1: not YAML: a list is not closed"),
        ("a: 'b\n", "mine.yaml:1: not YAML: a quote is not closed"),
        ("a:\n\tb: 1\n", "mine.yaml:2: not YAML: a tab"),
        ("a: b: c\n", "mine.yaml:1: not YAML: a ':' within a value"),
        ("a:\n  b: 1\n c: 1\n", "mine.yaml:3: not YAML: the indentation differs"),
        ("a: 1\n---\nb: 1\n", "mine.yaml:2: not YAML: a second document"),
        ("a: !!python/object/apply:os.system [ls]", "mine.yaml:1: not YAML: the tag !!python"),
        ("a: 1\nb: *c\n", "mine.yaml:2: not YAML: found undefined alias 'c'"),
        ("a: 1\n[b, c]: 1\n", "mine.yaml:2: not YAML: a key must be text"),
        ("a: {<<: 1}\n", "mine.yaml:1: not YAML: << must be a mapping or a list of mappings"),
        ("a: \x01", "mine.yaml: not YAML: the character U+0001 is not allowed"),
        ('a: "\\ud800"', "mine.yaml:1: not YAML: the character U+D800 is not allowed"),
        (b"a: \xe4", "mine.yaml:1: must be text in UTF-8; the byte 0xe4 is ä in Latin-1"),
        ("a: ä".encode("utf-16"), "mine.yaml: must be text in UTF-8; it is in UTF-16"),
    ],
)  # fmt: skip
def test_what_is_no_mapping_is_refused_in_one_line(tmp_path, text, message):
    told = refused(tmp_path, text)
    assert told.startswith(message)
    assert "\n" not in told


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(StudyError, match=r"none\.yaml: cannot be read: No such file or directory"):
        load_study(tmp_path / "none.yaml")


def test_every_duplicate_key_is_refused_with_its_line(tmp_path):
    told = refused(tmp_path, "name: a\ntitle: b\nname: c\ncoupon:\n  cell: {count: 1, count: 2}\n")
    assert told.split("\n")[:2] == [
        "mine.yaml:3: name: duplicate key; already in line 1",
        "mine.yaml:5: coupon.cell.count: duplicate key; already in line 5",
    ]


def test_a_duplicate_key_is_refused_though_all_values_are_good(tmp_path):
    text = yaml.safe_dump({"title": "once", "coupon": BED}) + "title: once more\n"
    last = text.count("\n")
    first = text.split("\n").index("title: once") + 1
    message = f"mine.yaml:{last}: title: duplicate key; already in line {first}"
    assert refused(tmp_path, text) == message


def test_a_number_and_the_same_text_are_one_key(tmp_path):
    told = refused(tmp_path, "panel:\n  points: {7: [0, 0], '7': [1, 1]}\n")
    assert "\nmine.yaml:2: panel.points.7: duplicate key; already in line 2" in told


def test_a_mistake_in_a_merged_mapping_is_told_where_it_is(tmp_path):
    text = (
        "coupon:\n"
        "  cell: &cell\n"
        "    depth_mm: 20\n"
        "    count: 2\n"
        "  walls:\n"
        "    <<: *cell\n"
        "    count: 3\n"
        "  sweep: {frequency_hz: [100], acceleration_g: [1]}\n"
    )
    told = refused(tmp_path, text).split("\n")
    allowed = "youngs_modulus_mpa, poissons_ratio, restitution, friction, rolling_friction"
    assert told == [
        f"mine.yaml:3: coupon.walls.depth_mm = 20: unknown key; allowed are {allowed}",
        f"mine.yaml:7: coupon.walls.count = 3: unknown key; allowed are {allowed}",
    ]


def test_a_merged_mapping_has_the_values_of_both(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("a: &a {x: 1, y: 2}\nb: {<<: *a, y: 3}\n")
    assert Document(path).data["b"] == {"x": 1, "y": 3}


@pytest.mark.parametrize("text", ["&a [*a]", "&a {b: *a}", "&a {<<: *a}"])
def test_a_value_that_holds_itself_is_refused(tmp_path, text):
    told = refused(tmp_path, f"coupon: {text}\n")
    assert told == "mine.yaml: lists and mappings are nested too deeply"


def test_a_study_of_the_coupon_alone_has_the_name_of_its_file(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"coupon": BED}))
    study = load_any_study(path)
    assert study.name == "mine"
    assert study.coupon is not None
    with pytest.raises(StudyError, match=r"mine\.yaml: panel: missing; this is a study of the cou"):
        load_study(path)


def test_an_unknown_key_beside_a_coupon_is_no_panel(tmp_path):
    told = refused(tmp_path, yaml.safe_dump({"coupon": BED, "titel": "x"}))
    assert told.endswith("titel = x: unknown key; did you mean title?")
    assert "\n" not in told


def test_a_file_named_by_its_place_beside_the_study_or_in_the_working_folder(tmp_path, monkeypatch):
    study = tmp_path / "mine.yaml"
    study.write_text(yaml.safe_dump({"coupon": {**BED, "deck": "shake.in.j2"}}))
    working = tmp_path / "working"
    working.mkdir()
    monkeypatch.chdir(working)
    assert load_any_study(study).coupon.deck == STUDIES.parents[1] / "templates" / "shake.in.j2"
    (working / "shake.in.j2").touch()
    assert load_any_study(study).coupon.deck == working / "shake.in.j2"
    (tmp_path / "shake.in.j2").touch()
    assert load_any_study(study).coupon.deck == tmp_path / "shake.in.j2"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<<: [*a, *b]", {"x": 1, "y": 2, "z": 3}),
        ("<<: [*b, *a]", {"x": 10, "y": 2, "z": 30}),
        ("<<: [*a, *b]\n  x: 7", {"x": 7, "y": 2, "z": 3}),
        ("x: 7\n  <<: [*a, *b]", {"x": 7, "y": 2, "z": 3}),
        ("<<: *b", {"x": 10, "z": 30}),
        ("<<: [{x: 5, <<: *b}, *a]", {"x": 5, "y": 2, "z": 30}),
    ],
)
def test_of_several_merged_mappings_the_first_counts(tmp_path, text, expected):
    path = tmp_path / "merged.yaml"
    path.write_text(f"x-a: &a {{x: 1, y: 2, z: 3}}\nx-b: &b {{x: 10, z: 30}}\nc:\n  {text}\n")
    assert Document(path).data == {"c": expected}


def test_every_number_is_read_as_yaml_1_2_has_it():
    text = "a: [1, -1, +1, 0, 1.5, 1e3, 1.e-3, .5, -.inf, 010, 0x1, 1_0, 1:2, on, y, 2024-01-01]"
    found = Content(text).data["a"]
    assert found == [1, -1, 1, 0, 1.5, 1000.0, 1e-3, 0.5, float("-inf"), "010", "0x1", "1_0",
                     "1:2", "on", "y", "2024-01-01"]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("title: 2026-02-30", "2026-02-30"),
        ("title: 1.50", "1.50"),
        ("title: 'a: {b} # c'", "a: {b} # c"),
        ("title: !!str 7", "7"),
        ("%YAML 1.2\n---\ntitle: 007", "007"),
        ("x-t: &t {title: mine}\n<<: *t", "mine"),
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_text_is_that_of_the_file_whatever_it_could_mean(tmp_path, text, value, end):
    path = tmp_path / "mine.yaml"
    path.write_bytes(f"\ufeff{text}\ncoupon: {{}}\n".replace("\n", end).encode())
    assert load_any_study(path).title == value


@pytest.mark.parametrize(("name", "better"), [
    ("my study.yaml", "my_study"),
    ("größe.yaml", "groe"),
    ("coupon.yaml", "coupon_study"),
    ("$(touch x).yaml", "touch_x"),
])  # fmt: skip
def test_a_file_whose_name_cannot_be_that_of_the_study_is_told_what_to_do(tmp_path, name, better):
    path = tmp_path / name
    path.write_text("coupon: {}")
    with pytest.raises(StudyError, match=f"name: missing; .*; such as name: {better}$"):
        load_any_study(path)
