"""What YAML allows beside plain keys and values: refused or read as it is meant, with its line."""

import pytest

from pidpanel.study import load_any_study
from pidpanel.study.loader import Content

KEYS = "must be a mapping with keys such as name, coupon, panel"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (b"", f"mine.yaml: is empty; {KEYS}"),
        (b"---\n", f"mine.yaml: {KEYS}"),
        (b"~\n", f"mine.yaml: {KEYS}"),
        ("title: größe\n".encode("latin-1"), "mine.yaml:1: must be text in UTF-8; the byte 0xf6 is ö in Latin-1"),
        ("title: größe\n".encode("utf-16"), "mine.yaml: must be text in UTF-8; it is in UTF-16"),
        (b'title: a\ntext: "\\ud800"\n', "mine.yaml:2: not YAML: the character U+D800 is not allowed"),
        (b'"a\\0b": 1\n', "mine.yaml:1: not YAML: the character U+0000 is not allowed"),
        (b'{"coupon": {', "mine.yaml:1: not YAML: a list or a mapping is not closed"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_study_is_refused(written, text, told):
    assert written(text).told() == told.split("\n")


ACCEPTED = [
    # (base, what is there, what is written instead, way to a value, the value it must have)
    ("coupon", "depth_mm: 10", "depth_mm: 1e1", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "depth_mm: 10", "depth_mm: '10'", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "count: 2", "count: !!int 2", ("coupon", "cell", "count"), 2),
    ("coupon", "coupon:\n", "title: 2024-01-31\ncoupon:\n", ("title",), "2024-01-31"),
    ("coupon", "coupon:\n", "title: 'a: {b} # c'\ncoupon:\n", ("title",), "a: {b} # c"),
    ("coupon", "coupon:\n", "name: 007\ncoupon:\n", ("name",), "007"),
    ("coupon", "coupon:\n", "%YAML 1.2\n---\ncoupon:\n", ("name",), "mine"),
    ("coupon", "  cell:\n    shape: hexagon\n    across_flats_mm: 6.35\n    depth_mm: 10\n    count: 2\n", "  cell: {<<: {count: 7, depth_mm: 12}, count: 3}\n", ("coupon", "cell", "count"), 3),
    ("coupon", "    friction: 0.3\n", "    friction: 0.3\n    <<: [{friction: 1, restitution: 0.5}, {restitution: 0.6}]\n", ("coupon", "particles", "friction"), 0.3),
    ("coupon", "accuracy:\n", "vary: {particles.shell_mm: [~, 0.2]}\n  accuracy:\n", ("coupon", "vary", "particles.shell_mm"), (None, 0.2)),
    ("thin", "damper_mass: true", "damper_mass: on", ("response", "damper_mass"), True),
    ("thin", "  patches:\n    PID-1:", "  patches:\n    7: &p\n      centre_m: [0.75, 0.5]\n      size_m: [0.3, 0.2]\n    PID-1:", ("panel", "patches", "7", "size_m"), (0.3, 0.2)),
    ("thin", "    PID-1:\n", "    on: &p\n      centre_m: [0.75, 0.5]\n      size_m: [0.3, 0.2]\n    PID-1:\n      <<: *p\n    PID-2:\n", ("panel", "patches", "PID-1", "size_m"), (0.3, 0.2)),
    ("thin", "    centre: [0.7, 0.5]", "    031: [0.7, 0.5]", ("panel", "points", "031"), (0.7, 0.5)),
]  # fmt: skip


@pytest.mark.parametrize("case", ACCEPTED, ids=lambda case: f"{case[0]}: {case[2][:50]!r}")
def test_what_is_odd_and_right_is_read_as_it_is_meant(written, bases, change, case):
    base, old, new, way, value = case
    place = written(change(bases[base], old, new))
    assert place.told() == []
    found = load_any_study(place.study)
    for key in way:
        found = found[key] if isinstance(found, dict) else getattr(found, key)
    assert found == value
    assert type(found) is type(value) or isinstance(value, tuple)


@pytest.mark.parametrize("encode", [
    lambda text: b"\xef\xbb\xbf" + text.encode(),
    lambda text: text.replace("\n", "\r\n").encode(),
    lambda text: text.replace("\n", "\r").encode(),
    lambda text: text.rstrip("\n").encode(),
])  # fmt: skip
def test_a_text_of_any_system_is_read(written, bases, encode):
    place = written(encode(bases["thin"]))
    assert place.told() == []
    assert load_any_study(place.study).title == "A small panel"


@pytest.mark.parametrize(("name", "better"), [
    ("my study.yaml", "my_study"),
    ("größe.yaml", "groe"),
    ("coupon.yaml", "coupon_study"),
    ("$(touch x).yaml", "touch_x"),
])  # fmt: skip
def test_a_file_whose_name_cannot_be_that_of_the_study_is_told_what_to_do(
    written, bases, name, better
):
    (told,) = written(bases["coupon"], name).told()
    assert told.startswith(f"{name}: name: missing; the name of the file, ")
    assert told.endswith(f"; such as name: {better}")
    assert written(f"name: {better}\n" + bases["coupon"], name).told() == []


def test_every_number_is_read_as_yaml_1_2_has_it():
    text = "a: [1, -1, +1, 0, 1.5, 1e3, 1.e-3, .5, -.inf, 010, 0x1, 1_0, 1:2, on, y, 2024-01-01]"
    found = Content(text).data["a"]
    assert found == [1, -1, 1, 0, 1.5, 1000.0, 1e-3, 0.5, float("-inf"), "010", "0x1", "1_0",
                     "1:2", "on", "y", "2024-01-01"]  # fmt: skip
