"""What YAML allows beside plain keys and values: refused or read as it is meant, with its line."""

import pytest
import yaml

from pidpanel.study import load_any_study, yaml_loader
from pidpanel.study.document import Document

EMPTY = "has no value; give one, or omit the key"
NO_YAML = "not YAML:"
KEYS = "must be a mapping with keys such as name, coupon, panel"
NAME = "must have a name of 1 to 80 printable characters without '/', '\"' or surrounding spaces, because files and mesh groups use it"
LAUGHS = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12)
)
MERGED_LAUGHS = "a0: &a0 {x: 1}\n" + "".join(
    f"a{k}: &a{k} {{<<: [{', '.join([f'*a{k - 1}'] * 9)}]}}\n" for k in range(1, 12)
)

WRONG = [
    # values that YAML 1.1 would take for something else
    ("coupon", "count: 2", "count: on", "coupon.cell.count = on: must be a whole number"),
    ("coupon", "count: 2", "count: yes", "coupon.cell.count = yes: must be a whole number"),
    ("coupon", "depth_mm: 10", "depth_mm: on", "coupon.cell.depth_mm = on: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: 1:30", "coupon.cell.depth_mm = 1:30: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: 031", "coupon.cell.depth_mm = 031: must be a number without leading zeros, which some programs read as octal"),
    ("coupon", "depth_mm: 10", "depth_mm: 0o31", "coupon.cell.depth_mm = 0o31: must be a number, without its unit"),
    ("coupon", "depth_mm: 10", "depth_mm: 0x1F", "coupon.cell.depth_mm = 0x1F: must be a number, without its unit"),
    ("coupon", "depth_mm: 10", "depth_mm: 1_0", "coupon.cell.depth_mm = 1_0: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: 10,5", "coupon.cell.depth_mm = 10,5: must be a number, with a decimal point"),
    ("coupon", "depth_mm: 10", "depth_mm: 10 mm", "coupon.cell.depth_mm = 10 mm: must be a number, without its unit"),
    ("coupon", "depth_mm: 10", "depth_mm: 2024-01-31", "coupon.cell.depth_mm = 2024-01-31: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: [10]", "coupon.cell.depth_mm = [10]: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: {value: 10}", "coupon.cell.depth_mm = {value: 10}: must be a number"),
    ("coupon", "depth_mm: 10", "depth_mm: 9" + "9" * 5000, "coupon.cell.depth_mm = " + "9" * 60 + "…: must be a finite number"),
    ("coupon", "count: 2", "count: 9" + "9" * 400, "coupon.cell.count = " + "9" * 60 + "…: must be a finite number"),
    ("coupon", "count: 2", "count: 1e30", "coupon.cell.count = 1e30: must be from 1 to 200"),
    ("thin", "fill_fraction: 0.5", "fill_fraction: 0:5", "scenarios.place.fill_fraction = 0:5: must be a number or a list"),
    ("thin", "[100, 400]", "[100, 1:40]", "response.frequency_hz[1] = 1:40: must be a number"),
    # keys without a value
    ("coupon", "depth_mm: 10", "depth_mm:", f"coupon.cell.depth_mm: {EMPTY}"),
    ("coupon", "depth_mm: 10", "depth_mm: ~", f"coupon.cell.depth_mm = ~: {EMPTY}"),
    ("coupon", "depth_mm: 10", "depth_mm: null", f"coupon.cell.depth_mm = null: {EMPTY}"),
    ("coupon", "[0.4, 0.8]", "[0.4, ~]", f"coupon.sweep.fill_fraction[1] = ~: {EMPTY}"),
    ("coupon", "[0.4, 0.8]", "", f"coupon.sweep.fill_fraction: {EMPTY}"),
    ("thin", "  oaspl_db: 150", "  oaspl_db:", f"sound.oaspl_db: {EMPTY}"),
    ("thin", "  oaspl_db: 150", "  oaspl_db: ~", f"sound.oaspl_db = ~: {EMPTY}"),
    ("thin", "title: A small panel", "title:", f"title: {EMPTY}"),
    ("thin", "  supports: simply_supported", "  supports:", f"panel.supports: {EMPTY}"),
    ("thin", "  supports: simply_supported", "  supports: ~", f"panel.supports = ~: {EMPTY}"),
    ("thin", "    fill_fraction: [0.4, 0.8]", "    fill_fraction:", f"scenarios.fill.fill_fraction: {EMPTY}"),
    ("thin", "    centre: [0.7, 0.5]", "    centre:", f"panel.points.centre: {EMPTY}"),
    ("thin", "spectrum: spectrum.csv", "spectrum:", f"sound.spectrum: {EMPTY}"),
    ("thin", "[paper_corrected]", "", f"damping.readings: {EMPTY}"),
    # keys
    ("coupon", "    count: 2", "    count: 2\n    count: 3", "@    count: 3| coupon.cell.count: duplicate key; already in line 6"),
    ("thin", "    Edge: [0.1, 0.5]", "    centre: [0.1, 0.5]", "panel.points.centre: duplicate key; already in line 27"),
    ("thin", "response:", "sound: {}\nresponse:", "sound: duplicate key; already in line 29", "sound.spectrum: missing"),
    ("coupon", "    count: 2", "    Count: 2", "coupon.cell.Count = 2: unknown key; did you mean count?"),
    ("coupon", "    count: 2", "    COUNT: 2", "coupon.cell.COUNT = 2: unknown key; did you mean count?"),
    ("coupon", "    depth_mm: 10", "    depth: 10", "coupon.cell.depth = 10: unknown key; did you mean depth_mm?"),
    ("coupon", "    depth_mm: 10", "    dpeth_mm: 10", "coupon.cell.dpeth_mm = 10: unknown key; did you mean depth_mm?"),
    ("coupon", "    depth_mm: 10", "    depth_m: 0.01", "coupon.cell.depth_m = 0.01: unknown key; did you mean depth_mm?"),
    ("coupon", "    count: 2", "    [1, 2]: 2", f"{NO_YAML} a key must be text"),
    ("coupon", "    count: 2", "    ? {a: 1}\n    : 2", f"{NO_YAML} a key must be text"),
    ("coupon", "    count: 2", "    '': 2", "coupon.cell.'' = 2: unknown key; allowed are shape, across_flats_mm, depth_mm, count"),
    ("thin", "sound:", "Sound:", "@| sound: missing", "@Sound:| Sound = {spectrum: spectrum.csv, oaspl_db: 150, field: diffuse, spee…: unknown key; did you mean sound?"),
    ("thin", "panel:", "panels:", "@| panel: missing", "@panels:| panels = {outline_m: [1.5, 1.0], section: {kind: thin, mass_per_area_…: unknown key; did you mean panel?"),
    # no YAML
    ("coupon", "    depth_mm: 10", "\tdepth_mm: 10", f"{NO_YAML} a tab; indent with spaces"),
    ("coupon", "depth_mm: 10", "depth_mm: [10", f"{NO_YAML} a list is not closed: ',' or ']' is missing"),
    ("coupon", "depth_mm: 10", "depth_mm: {a: 10", f"{NO_YAML} a mapping is not closed: ',' or '}}' is missing"),
    ("coupon", "depth_mm: 10", "depth_mm: '10", f"{NO_YAML} a quote is not closed"),
    ("thin", "title: A small panel", "title: A panel: small", f"{NO_YAML} a ':' within a value; put the value in quotes, or correct the indentation"),
    ("coupon", "    depth_mm: 10", "    depth_mm 10", f"{NO_YAML} a key without ':'"),
    ("coupon", "    depth_mm: 10", "   depth_mm: 10", f"{NO_YAML} the indentation differs from that of the lines above"),
    ("coupon", "    depth_mm: 10", "    depth_mm: *d", f"{NO_YAML} found undefined alias 'd'"),
    ("coupon", "depth_mm: 10", "depth_mm: !!python/object/apply:os.system [ls]", f"{NO_YAML} the tag !!python/object/apply:os.system is not allowed"),
    ("coupon", "depth_mm: 10", "depth_mm: !mm 10", f"{NO_YAML} the tag !mm is not allowed"),
    ("coupon", "depth_mm: 10", "depth_mm: !!timestamp today", f"{NO_YAML} the tag !!timestamp is not allowed"),
    ("coupon", "depth_mm: 10", "depth_mm: !!int ten", f"{NO_YAML} ten is not a number"),
    ("coupon", "depth_mm: 10", "depth_mm: &a [*a]", f"{NO_YAML} an alias contains itself"),
    ("coupon", "    depth_mm: 10", "    <<: 10", f"{NO_YAML} << must be a mapping or a list of mappings"),
    ("coupon", "    coverage: 0.8\n", "    coverage: 0.8\n---\ncoupon: {}\n", f"@---| {NO_YAML} a second document begins with '---'; must be one"),
    # what does not fit into memory
    ("coupon", "", LAUGHS, f"@| {NO_YAML} has 3.57e+11 values with its aliases written out; allowed are 500000"),
    ("coupon", "", MERGED_LAUGHS, f"@| {NO_YAML} has 1.19e+11 values with its aliases written out; allowed are 500000"),
    ("coupon", "depth_mm: 10", "depth_mm: " + "[" * 2000 + "]" * 2000, "@| lists and mappings are nested too deeply"),
    ("coupon", "", "# " + "x" * 1_100_000 + "\n", "@| has 1.1 MB; allowed are 1 MB"),
    ("coupon", "[0.4, 0.8]", "[" + ", ".join(f"{0.02 + k * 1e-6:.6f}" for k in range(60000)) + "]", "@sweep:| coupon.sweep = {fill_fraction: [0.020000, 0.020001, 0.020002, 0.020003, 0.0…: 240000 cases, 480000 runs; allowed are 200000 runs"),
    # repetition, with the line where a wrong value is written
    ("coupon", "  particles:\n", "  walls: &w\n    friction: 30\n  particles:\n    <<: *w\n", "@friction: 30| coupon.walls.friction = 30: must be from 0 to 5; 30 % would be 0.3"),
    ("thin", "    Left wing:\n      centre_m: [0.3, 0.5]\n      size_m: [0.2, 0.2]", "    Left wing: &p\n      centre_m: [0.3, 0.5]\n      size_m: [0.2, 200]\n    Right:\n      <<: *p", "@size_m: [0.2, 200]| panel.patches.Left wing.size_m[1] = 200: must be from 0.0001 to 30; 200 mm would be 0.2", "@size_m: [0.2, 200]| panel.patches.Right.size_m[1] = 200: must be from 0.0001 to 30; 200 mm would be 0.2"),
    ("thin", "title: A small panel", "x-common: &c\n  patch: PID-9\nzzz: 3\ntitle: A small panel", "@zzz| zzz = 3: unknown key; allowed are name, title, assumptions, coupon, dampers, damping, panel, sound, response, scenarios"),
    ("thin", "    patch: PID-1\n    fill_fraction: [0.4, 0.8]", "    <<: {patch: PID-9, fill_fraction: [0.4, 0.8]}", "scenarios.fill.patch = PID-9: must be one of panel.patches: PID-1, Left wing; did you mean PID-1?"),
    # names
    ("thin", "    PID-1:\n", "    '':\n", "panel.patches.'' = {centre_m: [0.75, 0.5], size_m: [0.3, 0.2]}: " + NAME, "@patch: PID-1| scenarios.fill.patch = PID-1: must be one of panel.patches: , Left wing", "@patch: [PID-1| scenarios.place.patch[0] = PID-1: must be one of panel.patches: , Left wing"),
    ("coupon", "coupon:\n", "name: coupon\ncoupon:\n", "name = coupon: must be another name; results/coupon is shared by all studies"),
    ("coupon", "coupon:\n", "name: verification\ncoupon:\n", "name = verification: must be another name; results/verification is shared by all studies"),
    ("coupon", "coupon:\n", "name: ../paper\ncoupon:\n", "name = ../paper: must be letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
    ("coupon", "coupon:\n", "name: ''\ncoupon:\n", "name: must be letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
    ("coupon", "coupon:\n", "name: .\ncoupon:\n", "name = .: must be letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
    ("coupon", "coupon:\n", "name: größe\ncoupon:\n", "name = größe: must be letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
    ("coupon", "coupon:\n", "name: [a]\ncoupon:\n", "name = [a]: must be text"),
]  # fmt: skip


@pytest.mark.parametrize("case", WRONG, ids=lambda case: f"{case[0]}: {case[2][:50]!r}")
def test_what_yaml_allows_and_a_study_does_not_is_refused(wrong, case):
    # red: yaml.SafeLoader's resolvers in `Loader`; no `_count`, no `_mistakes`, no PROBLEMS
    wrong(*case)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (b"", f"mine.yaml: is empty; {KEYS}"),
        (b"\n\n# nothing\n", f"mine.yaml: is empty; {KEYS}"),
        (b"---\n", f"mine.yaml: {KEYS}"),
        (b"study\n", f"mine.yaml: {KEYS}"),
        (b"- coupon\n", f"mine.yaml: {KEYS}"),
        (b"3\n", f"mine.yaml: {KEYS}"),
        (b"~\n", f"mine.yaml: {KEYS}"),
        (b"{}\n", "mine.yaml: panel: missing\nmine.yaml: sound: missing"),
        ("title: größe\n".encode("latin-1"), "mine.yaml:1: must be text in UTF-8; the byte 0xf6 is ö in Latin-1"),
        ("title: a\nassumptions: [λ, größe]\n".encode("cp1253", "ignore"), "mine.yaml:2: must be text in UTF-8; the byte 0xeb is ë in Latin-1"),
        ("title: größe\n".encode("utf-16"), "mine.yaml: must be text in UTF-8; it is in UTF-16"),
        ("title: größe\n".encode("utf-16-be"), "mine.yaml:1: must be text in UTF-8; it has a byte 0x00, as of a binary file"),
        ("title: größe\n".encode("utf-32"), "mine.yaml: must be text in UTF-8; it is in UTF-16"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", "mine.yaml:3: must be text in UTF-8; it has a byte 0x00, as of a binary file"),
        (b"\x1f\x8b\x08\x08", "mine.yaml:1: must be text in UTF-8; the byte 0x8b is not text"),
        (b"title: a\x07b\n", "mine.yaml: not YAML: the character U+0007 is not allowed"),
        (b"<html></html>\n", f"mine.yaml: {KEYS}"),
        (b'{"coupon": {', "mine.yaml:1: not YAML: a list or a mapping is not closed"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_study_is_refused(written, text, told):
    # red: read_text without one of its conditions
    assert written(text).told() == told.split("\n")


ACCEPTED = [
    # (base, what is there, what is written instead, way to a value, the value it must have)
    ("coupon", "depth_mm: 10", "depth_mm: 1e1", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "depth_mm: 10", "depth_mm: 1E+1", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "depth_mm: 10", "depth_mm: +10", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "depth_mm: 10", "depth_mm: '10'", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "depth_mm: 10", "depth_mm: 10.", ("coupon", "cell", "depth_mm"), 10.0),
    ("coupon", "restitution: 0.8", "restitution: .8", ("coupon", "particles", "restitution"), 0.8),
    ("coupon", "count: 2", "count: 2.0", ("coupon", "cell", "count"), 2),
    ("coupon", "count: 2", "count: !!int 2", ("coupon", "cell", "count"), 2),
    ("coupon", "coupon:\n", "title: 2024-01-31\ncoupon:\n", ("title",), "2024-01-31"),
    ("coupon", "coupon:\n", "title: 1.50\ncoupon:\n", ("title",), "1.50"),
    ("coupon", "coupon:\n", "title: on\ncoupon:\n", ("title",), "on"),
    ("coupon", "coupon:\n", "title: 'a: {b} # c'\ncoupon:\n", ("title",), "a: {b} # c"),
    ("coupon", "coupon:\n", "title: größe 日本\ncoupon:\n", ("title",), "größe 日本"),
    ("coupon", "coupon:\n", "title: >\n  folded\n  text\ncoupon:\n", ("title",), "folded text\n"),
    ("coupon", "coupon:\n", "name: 007\ncoupon:\n", ("name",), "007"),
    ("coupon", "coupon:\n", "name: 2024\ncoupon:\n", ("name",), "2024"),
    ("coupon", "coupon:\n", "%YAML 1.2\n---\ncoupon:\n", ("name",), "mine"),
    ("coupon", "coupon:\n", "x-cells: &c {count: 7, depth_mm: 12}\ncoupon:\n", ("coupon", "cell", "count"), 2),
    ("coupon", "  cell:\n    shape: hexagon\n    across_flats_mm: 6.35\n    depth_mm: 10\n    count: 2\n", "  cell: {<<: {count: 7, depth_mm: 12}, count: 3}\n", ("coupon", "cell", "count"), 3),
    ("coupon", "    friction: 0.3\n", "    friction: 0.3\n    <<: [{friction: 1, restitution: 0.5}, {restitution: 0.6}]\n", ("coupon", "particles", "friction"), 0.3),
    ("coupon", "accuracy:\n", "vary: {particles.shell_mm: [~, 0.2]}\n  accuracy:\n", ("coupon", "vary", "particles.shell_mm"), (None, 0.2)),
    ("thin", "damper_mass: true", "damper_mass: on", ("response", "damper_mass"), True),
    ("thin", "damper_mass: true", "damper_mass: no", ("response", "damper_mass"), False),
    ("thin", "  patches:\n    PID-1:", "  patches:\n    7: &p\n      centre_m: [0.75, 0.5]\n      size_m: [0.3, 0.2]\n    PID-1:", ("panel", "patches", "7", "size_m"), (0.3, 0.2)),
    ("thin", "    PID-1:\n", "    on: &p\n      centre_m: [0.75, 0.5]\n      size_m: [0.3, 0.2]\n    PID-1:\n      <<: *p\n    PID-2:\n", ("panel", "patches", "PID-1", "size_m"), (0.3, 0.2)),
    ("thin", "    centre: [0.7, 0.5]", "    ~: [0.7, 0.5]", ("panel", "points", "~"), (0.7, 0.5)),
    ("thin", "    centre: [0.7, 0.5]", "    031: [0.7, 0.5]", ("panel", "points", "031"), (0.7, 0.5)),
    ("thin", "    centre: [0.7, 0.5]", "    1:30: [0.7, 0.5]", ("panel", "points", "1:30"), (0.7, 0.5)),
    ("thin", "    centre: [0.7, 0.5]", "    {0/90}s: [0.7, 0.5]".replace("/", "-").replace("{0-90}s", "'{0-90}s'"), ("panel", "points", "{0-90}s"), (0.7, 0.5)),
    ("thin", "outline_m: [1.5, 1.0]", "outline_m:\n  - 1.5\n  - 1", ("panel", "outline_m"), (1.5, 1.0)),
    ("thin", "scenarios:\n  fill:\n    title: Effect of fill\n", "scenarios:\n  fill: &f\n    title: Effect of fill\n", ("scenarios", "fill", "patch"), "PID-1"),
    ("thin", "sound:\n", "sound: &s\n", ("sound", "oaspl_db"), 150.0),
    ("sandwich", "      slanted: {damper: foil}", "      slanted: {damper: foil}\n  more:\n    layout: {round: {damper: lab, fill_fraction: 0.5}}", ("scenarios", "more", "layout", "round", "fill_fraction"), 0.5),
]  # fmt: skip


@pytest.mark.parametrize("case", ACCEPTED, ids=lambda case: f"{case[0]}: {case[2][:50]!r}")
def test_what_is_odd_and_right_is_read_as_it_is_meant(written, bases, change, case):
    # red: yaml.SafeLoader's resolvers; keys constructed; no `written` in base._as_written
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
    lambda text: (text + "...\n").encode(),
    lambda text: b"\n\n" + text.encode() + b"\n\n",
])  # fmt: skip
def test_a_text_of_any_system_is_read(written, bases, encode):
    # red: decode("utf-8") in text_files.decoded
    place = written(encode(bases["thin"]))
    assert place.told() == []
    assert load_any_study(place.study).title == "A small panel"


@pytest.mark.parametrize(("name", "better"), [
    ("my study.yaml", "my_study"),
    ("größe.yaml", "groe"),
    ("coupon.yaml", "coupon_study"),
    ("verification.yaml", "verification_study"),
    ("$(touch x).yaml", "touch_x"),
    ("-.yaml", "my_study"),
])  # fmt: skip
def test_a_file_whose_name_cannot_be_that_of_the_study_is_told_what_to_do(
    written, bases, name, better
):
    # red: reading._of_file_name returns the mistake as it is
    (told,) = written(bases["coupon"], name).told()
    assert told.startswith(f"{name}: name: missing; the name of the file, ")
    assert told.endswith(f"; such as name: {better}")
    assert written(f"name: {better}\n" + bases["coupon"], name).told() == []


def test_every_number_is_read_as_yaml_1_2_has_it():
    # red: a resolver of YAML 1.1
    text = "a: [1, -1, +1, 0, 1.5, 1e3, 1.e-3, .5, -.inf, 010, 0x1, 1_0, 1:2, on, y, 2024-01-01]"
    found = yaml.load(text, yaml_loader.Loader)["a"]
    assert found == [1, -1, 1, 0, 1.5, 1000.0, 1e-3, 0.5, float("-inf"), "010", "0x1", "1_0",
                     "1:2", "on", "y", "2024-01-01"]  # fmt: skip


def test_a_merged_list_of_mappings_has_the_line_of_the_one_that_counts(written, bases, change):
    # red: `node.value` without reversed in document._entry
    text = "x: &a\n  patch: 1\ny: &b\n  patch: 2\nz:\n  <<: [*a, *b]\n"
    document = Document(written(text).study)
    assert document.data["z"] == {"patch": 1}
