"""What is wrong with a study is told at its line before anything runs."""

import copy
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from pidpanel.check import check_machine, checked_study
from pidpanel.cli import MISTAKE, main
from pidpanel.cli.study_overview import overview
from pidpanel.coupon.from_study import distinct_cases
from pidpanel.coupon.liggghts.deck import TRUST
from pidpanel.solve.lines import LINES_AT_MOST, frequency_grid
from pidpanel.study import StudyError, load_any_study

STUDIES = Path(__file__).parents[1] / "workflow" / "studies"
TEMPLATES = Path(__file__).parents[1] / "templates"
SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
BED = SMOKE["dampers"]["acrylic"]
COUPON = {key: value for key, value in BED.items() if key != "model"}


def refused(tmp_path, values):
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    with pytest.raises(StudyError) as caught:
        checked_study(path)
    lines = path.read_text().splitlines()
    told = str(caught.value).replace(f"{tmp_path}/", "").split("\n")
    return [(lines[int(one.split(":")[1]) - 1].strip(), one.split(": ", 1)[1]) for one in told]


def changed(study, way, value):
    values = copy.deepcopy(yaml.safe_load((STUDIES / f"{study}.yaml").read_text()))
    section = values
    for key in way[:-1]:
        section = section[key]
    section[way[-1]] = value
    if study == "bdf_panel":
        section = values["panel"]["mesh"]
        section["file"] = str(STUDIES / "bdf_panel.bdf")
    return values


def test_a_deck_of_ones_own_is_found_beside_the_study(tmp_path, monkeypatch):
    monkeypatch.setenv(TRUST, "1")
    (tmp_path / "shake.in.j2").write_text((TEMPLATES / "shake.in.j2").read_text())
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"coupon": {**COUPON, "deck": "shake.in.j2"}}))
    assert checked_study(path).coupon.deck == tmp_path / "shake.in.j2"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{{ cycles_file }} {{ steps_per_cycle }} {{ viscosity }}", "unknown variable viscosity; allowed are acceleration, "),
        ("{{ cycles_file }}", "must use the variable steps_per_cycle; a deck writes one row per cycle"),
        ("\n{% if %}", "{folder}/own.in.j2:2: Expected an expression"),
    ],
)  # fmt: skip
def test_a_deck_of_ones_own_is_checked_at_once(tmp_path, text, message, monkeypatch):
    monkeypatch.setenv(TRUST, "1")
    (tmp_path / "own.in.j2").write_text(text)
    ((line, told),) = refused(tmp_path, {"coupon": {**COUPON, "deck": "own.in.j2"}})
    assert line == "deck: own.in.j2"
    assert told.startswith(f"coupon.deck = own.in.j2: {message}".replace("{folder}/", ""))


CYCLES = "{{ cycles_file }} {{ steps_per_cycle }} "


@pytest.mark.parametrize(
    ("coupon", "message"),
    [
        ({"deck_values": {"viscosity": 2, "gap": 4}}, ""),
        ({"deck_values": {"viscosity": 2}, "vary": {"deck_values.viscosity": [2, 3]}}, ""),
        ({}, "coupon.deck = own.in.j2: unknown variable viscosity; allowed are acceleration, "),
        ({"deck_values": {"viscosity": 2, "speed": 3}}, "coupon.deck_values.speed = 3: is a variable of all decks"),
        ({"deck_values": {"viscosity": 2, "density": 3}}, "coupon.deck_values.density = 3: not used by own.in.j2"),
        ({"deck_values": {"viscosity": "a lot"}}, "coupon.deck_values.viscosity = a lot: must be a number"),
        ({"deck_values": {"viscosity": 2}, "vary": {"deck_values.viscosty": [2]}}, "coupon.vary.deck_values.viscosty = [2]: unknown key; did you mean viscosity"),
        ({"deck_values": {"viscosity": 2}, "deck": None}, "coupon.deck_values.viscosity = 2: not used by any deck"),
    ],
)  # fmt: skip
def test_values_of_a_deck_are_those_that_it_uses(tmp_path, coupon, message, monkeypatch):
    monkeypatch.setenv(TRUST, "1")
    (tmp_path / "own.in.j2").write_text(CYCLES + "{% include 'part.j2' %}{{ viscosity }}")
    (tmp_path / "part.j2").write_text("{{ gap|default('') }} ")
    values = {
        key: value for key, value in {**COUPON, "deck": "own.in.j2", **coupon}.items() if value
    }
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump({"coupon": values}))
    if not message:
        decks = [case.point.deck_text() for case in distinct_cases(checked_study(path)).values()]
        assert {text.rpartition(" ")[2] for text in decks} == set("23" if "vary" in coupon else "2")
        return
    ((_, told),) = refused(tmp_path, {"coupon": values})
    assert told.startswith(message)


def test_a_varied_deck_is_told_where_it_is_in_its_list(tmp_path, monkeypatch):
    monkeypatch.setenv(TRUST, "1")
    (tmp_path / "own.in.j2").write_text("{{ cycles_file }}")
    vary = {"deck": ["shake.in.j2", "own.in.j2"]}
    ((line, told),) = refused(tmp_path, {"coupon": {**COUPON, "vary": vary}})
    assert line == "- own.in.j2"
    assert told.startswith("coupon.vary.deck[1] = own.in.j2: must use the variable steps_per_")


@pytest.mark.parametrize(
    ("study", "way", "value", "at", "told"),
    [
        ("smoke", ("response", "frequency_hz"), [10, 400], "frequency_hz:",
         "response.frequency_hz = [10, 400]: must be in the bands of smc_s_016_2014_min_third.csv, 28.184 to 11220 Hz"),
        ("paper", ("response", "frequency_hz"), [30, 2001], "frequency_hz:",
         "response.frequency_hz = [30, 2001]: must be in the range of the paper's law, 5 to 2000 Hz"),
        ("sandwich_hole_hinge", ("panel", "supports", "points", "hinge 1", "at_m"), [1.05, 0.65], "radius_m: 0.02", "panel.supports.points.hinge 1.radius_m = 0.02: patch 'foot of hinge 1'"),
        ("sandwich_hole_hinge", ("panel", "supports", "points", "hinge 1", "radius_m"), 0.2, "radius_m: 0.2", "panel.supports.points.hinge 1.radius_m = 0.2: patch 'foot of hinge 1'"),
        ("sandwich_hole_hinge", ("panel", "supports", "points", "hinge 1"), {"at_m": [1.05, 0.65], "kind": "hinge"}, "at_m:", "panel.supports.points.hinge 1.at_m = [1.05, 0.65]: point 'support hinge 1'"),
        ("sandwich_hole_hinge", ("panel", "masses", "connector", "at_m"), [3, 3], "at_m:", "panel.masses.connector.at_m = [3, 3]: point 'connector'"),
        ("sandwich_hole_hinge", ("panel", "masses", "P1"), {"at_m": [3, 3], "mass_kg": 1}, "at_m:", "panel.masses.P1.at_m = [3, 3]: point 'P1'"),
        ("sandwich_hole_hinge", ("panel", "masses", "harness", "to_m"), [3, 3], "to_m:", "panel.masses.harness.to_m = [3, 3]: point 'harness to_m'"),
        ("sandwich_hole_hinge", ("panel", "mesh", "size_m"), 0.2, "mesh:", "panel.mesh = {kind: triangles, size_m: 0.2, corner_size_m: 0.005}: element edges of 0.2 m are too coarse for 2000 Hz"),
        ("sandwich_hole_hinge", ("panel", "points", "centre"), [0.3, 0.3], "centre:", "panel.points.centre = [0.3, 0.3]: 'centre' names both a patch and a point"),
        ("l_panel", ("panel", "supports"), {"outline": "free", "edges": [{"from_m": [0, 0], "to_m": [9, 0], "kind": "clamped"}]}, "to_m:", "panel.supports.edges[0].to_m = [9, 0]: point 'supports.edges 1 to_m'"),
        ("sandwich_hole_hinge", ("panel", "supports", "points", "hinge 2", "at_m"), [0.33, 0.06], "radius_m: 0.02", "panel.supports.points.hinge 1.radius_m = 0.02: patch 'foot of hinge 1' meets the support 'hinge 2'"),
        ("sandwich_hole_hinge", ("panel", "masses", "harness", "to_m"), [1.3, 0.7], "to_m:", "panel.masses.harness.to_m = [1.3, 0.7]: point 'harness to_m' = (1.3, 0.7) m: the line to it from (0.1, 0.5) m leaves the panel"),
        ("l_panel", ("panel", "supports"), {"outline": "free", "edges": [{"from_m": [0, 0], "to_m": [0.5, 0.5], "kind": "clamped"}]}, "to_m:", "panel.supports.edges[0].to_m = [0.5, 0.5]: point 'supports.edges 1 to_m' = (0.5, 0.5) m: the boundary does not lead straight to it"),
        ("l_panel", ("panel", "supports"), {"outline": "free", "points": {"S": {"kind": "spring", "stiffness_n_m": 1e4, "at_m": [3, 3]}}}, "at_m:", "panel.supports.points.S.at_m = [3, 3]: point 'support S' = (3, 3) m leaves the panel"),
        ("bdf_panel", ("panel", "points", "left", "grid"), 99, "grid: 99", "panel.points.left.grid = 99: no node 99"),
        ("bdf_panel", ("panel", "supports", "points", "H2", "grid"), 98, "grid: 98", "panel.supports.points.H2.grid = 98: no node 98"),
        ("bdf_panel", ("panel", "patches", "side", "centre_m"), [1.1, 0.7], "side:", "panel.patches.side = {centre_m: [1.1, 0.7], size_m: [0.2, 0.2]}: patch 'side'"),
    ],
)  # fmt: skip
def test_what_the_stages_refuse_is_told_at_the_key_that_they_name(
    tmp_path, study, way, value, at, told
):
    ((line, message),) = refused(tmp_path, changed(study, way, value))
    assert line.startswith(at)
    assert message.startswith(told.replace("{studies}", str(STUDIES)))


def test_held_edges_need_a_symmetric_section(tmp_path):
    # two plies on one face: B ≠ 0, and no neutral plane
    values = changed("sandwich_hole_hinge", ("panel", "supports"), "simply_supported")
    values["panel"]["in_plane_edges"] = "held"
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(values, allow_unicode=True))
    checked_study(tmp_path / "mine.yaml")
    section = values["panel"]["section"]
    plies = section.pop("faces")
    section["top"], section["bottom"] = plies, plies[:2]
    ((line, message),) = refused(tmp_path, values)
    assert line.startswith("in_plane_edges:")
    assert (
        message
        == "panel.in_plane_edges = held: in_plane_edges must be free: the section is not symmetric"
    )


def test_a_table_that_cannot_be_read_is_told_at_its_key(tmp_path):
    (tmp_path / "mine.csv").write_text("center_hz,spl_db\n100,120\n160,121\n125,122\n")
    values = changed("smoke", ("sound", "spectrum"), "mine.csv")
    values["dampers"]["paper"] = {"table": "lab.csv"}
    (tmp_path / "lab.csv").write_text("fill_fraction\n1\n")
    *tables, spectrum = refused(tmp_path, values)
    for table, column in zip(tables, ("frequency_hz", "equivalent_damping_n_s_m3"), strict=True):
        assert table[0] == "table: lab.csv"
        assert f"lab.csv, line 1: column {column}" in table[1].removeprefix(
            "dampers.paper.table = lab.csv: "
        )
    assert spectrum[0] == "spectrum: mine.csv"
    assert "mine.csv, line 4: " in spectrum[1].removeprefix("sound.spectrum = mine.csv: ")


def test_the_tables_of_dampers_are_told_at_their_keys(tmp_path):
    real = "frequency_hz,equivalent_damping_n_s_m3\n100,-5\n"
    (tmp_path / "lab.csv").write_text(real)
    dampers = {"bed": {"table": "lab.csv"}, "tuned": {"impedance": "lab.csv"}}
    values = changed("l_panel", ("dampers",), dampers)
    for family in values["scenarios"].values():
        family["damper"] = "bed"
    table, *impedance = refused(tmp_path, values)
    assert table[0] == "table: lab.csv"
    assert table[1].startswith("dampers.bed.table = lab.csv: ")
    assert table[1].endswith("line 2: equivalent_damping_n_s_m3 = -5: must be at least 0")
    assert [told.partition("line ")[2][:36] for _, told in impedance] == [
        "1: column apparent_mass_kg_m2: missi", "2: equivalent_damping_n_s_m3 = -5: m",
    ]  # fmt: skip
    assert all(line == "impedance: lab.csv" for line, _ in impedance)


@pytest.mark.parametrize(("low", "high"), [(30, 2000), (100, 110)])
def test_a_panel_damped_too_lightly_for_its_lines_is_told_how_lightly_it_may_be(
    tmp_path, low, high
):
    values = changed("l_panel", ("response", "frequency_hz"), [low, high])
    values["panel"] |= {"damping_ratio": 1e-6, "mesh": {"kind": "triangles", "size_m": 0.015}}
    (line, told), *_ = refused(tmp_path, values)  # whatever the mesh is too coarse for
    assert line == "damping_ratio: 1.0e-06"
    # eight lines to 2ζf
    count = 4e6 * math.log(high / low)
    lines, least = re.search(
        r"takes (\d+) frequency lines .* ratios from ([\d.e-]+)", told
    ).groups()
    assert int(lines) == pytest.approx(count, abs=3)
    assert float(least) == pytest.approx(count * 1e-6 / 20_000, rel=0.03)
    values["panel"]["damping_ratio"] = float(least)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    checked_study(path)
    grid = frequency_grid(low, high, float(least))
    assert 0.95 * LINES_AT_MOST < len(grid) <= LINES_AT_MOST


def test_a_results_folder_that_is_not_writable_is_named(tmp_path):
    path = tmp_path / "results"
    path.write_text("a file")
    study = load_any_study(STUDIES / "l_panel.yaml")
    with pytest.raises(StudyError, match=r"results: must be a writable folder \(File exists\)"):
        check_machine(study, path)


def test_a_study_without_a_coupon_needs_no_liggghts(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    check_machine(load_any_study(STUDIES / "l_panel.yaml"), tmp_path / "results")
    with pytest.raises(StudyError, match="apt-get install liggghts"):
        check_machine(load_any_study(STUDIES / "smoke.yaml"), tmp_path / "results")
    # without a sweep
    coupled = load_any_study(STUDIES / "layouts.yaml")
    assert not coupled.coupons
    with pytest.raises(StudyError, match="apt-get install liggghts"):
        check_machine(coupled, tmp_path / "results")


def test_a_study_of_the_coupon_alone_imports_no_panel():
    code = (
        "import sys; from pidpanel.check import checked_study;"
        f"checked_study({str(STUDIES / 'coupon_friction.yaml')!r});"
        "print([name for name in ('gmsh', 'skfem', 'scipy.sparse', 'pandas', 'xarray')"
        " if name in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout == "[]\n"


def test_particles_without_a_mass_are_named_in_check_and_on_the_page(tmp_path, capsys):
    table = "frequency_hz,loss_factor,particle_mass_per_area_kg_m2\n30,0.2,10\n2000,0.2,10\n"
    (tmp_path / "steel.csv").write_text(table)
    values = changed("l_panel", ("dampers",), {"bed": {"table": "steel.csv"}})
    values["panel"]["mesh"]["size_m"] = 0.06
    values["scenarios"] = {"s": {"layout": {"arm": {"damper": "bed"}}}}
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    assert main(["check", str(path)]) == 0
    assert re.search(
        r"particles of bed have no mass in the computation; dampers\.bed\.apparent_mass: particles",
        capsys.readouterr().out,
    )
    study = checked_study(path)
    assert list(study.massless_dampers) == ["bed"]
    values["dampers"]["bed"]["apparent_mass"] = "particles"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    assert main(["check", str(path)]) == 0
    assert "no mass" not in capsys.readouterr().out
    assert not checked_study(path).massless_dampers
    assert checked_study(path).damper_masses(with_rows=True) == {"arm": 10.0}


@pytest.mark.parametrize(
    ("study", "way", "value", "message"),
    [
        # 900 mm at 300 Hz is 326 000 g
        ("coupon_size", ("coupon", "sweep", "displacement_mm"), [0.1, 900], "at most 2000 g, "),
        ("l_panel", ("response", "frequency_hz"), [100, 100.1], "at least 1.02 times the first"),
        ("coupon_size", ("damping",), {"coupled": {"runs": 2}}, "only in a study with a panel"),
    ],
)
def test_what_no_test_is_like_is_refused_with_what_is_allowed(study, way, value, message, tmp_path):
    values = changed(study, way, value)
    if "displacement_mm" in way:
        del values["coupon"]["sweep"]["acceleration_g"]
    told = [line for _, line in refused(tmp_path, values)]
    assert len(told) == 1 and message in told[0]


def test_a_spectrum_in_pascal_is_refused_unless_its_level_is_stated(tmp_path):
    bands = [31.5, 63, 125, 250, 500, 1000, 2000]
    pascal = [25, 40, 60, 80, 70, 50, 30]
    rows = [f"{f:g},{p}" for f, p in zip(bands, pascal, strict=True)]
    (tmp_path / "pa.csv").write_text("\n".join(["center_hz,spl_db", *rows]))
    values = changed("l_panel", ("sound", "spectrum"), "pa.csv")
    values["response"]["frequency_hz"] = [50, 1000]
    ((line, told),) = refused(tmp_path, values)
    assert line.startswith("spectrum:") and "far below a launch; in Pa or Pa²/Hz?" in told
    values["sound"]["oaspl_db"] = 80.4
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    checked_study(path)


def test_the_frequencies_of_a_response_by_default_are_stated_where_they_do_not_fit(tmp_path):
    (tmp_path / "levels.csv").write_text("center_hz,spl_db\n63,126\n125,130\n250,129\n")
    values = changed("l_panel", ("sound", "spectrum"), "levels.csv")
    values["response"]["frequency_hz"] = [30, 300]
    assert refused(tmp_path, values)[0][1].endswith(
        "must be in the bands of levels.csv, 44.668 to 354.81 Hz"
    )
    del values["response"]["frequency_hz"]
    assert refused(tmp_path, values)[0][1].endswith("354.81 Hz; by default it is 20 to 2000 Hz")


def test_points_on_supported_edges_and_tables_that_end_early_are_named(tmp_path):
    text = "frequency_hz,equivalent_damping_n_s_m3\n100,500\n1000,500\n"
    (tmp_path / "short.csv").write_text(text)
    values = changed("l_panel", ("title",), "A short table")
    for damper in values["dampers"].values():
        if "table" in damper:
            damper["table"] = "short.csv"
    values["panel"]["points"]["A"] = [0, 0]
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    lines = overview(checked_study(path)).splitlines()
    message = (
        "short.csv has 100 to 1000 Hz, the response 30 to 2000 Hz; damping is held constant outside"
    )
    assert f"  data     {message}" in lines
    (points,) = (line for line in lines if line.startswith("  points"))
    assert "A on no patch, on a supported edge, where it does not move; B on corner; C on" in points
    assert not any(
        "held constant" in line
        for line in overview(load_any_study(STUDIES / "l_panel.yaml")).splitlines()
    )


def test_a_point_on_a_hinge_is_named(tmp_path):
    values = yaml.safe_load((STUDIES / "sandwich_hole_hinge.yaml").read_text())
    del values["sound"]  # no table of free edges
    values["base"] = {"random": {"spectrum": "gevs_qualification.csv"}}
    name, support = next(iter(values["panel"]["supports"]["points"].items()))
    values["panel"]["points"] = {"P": support["at_m"], "Q": [0.6, 0.55]}
    study = tmp_path / "hinge.yaml"
    study.write_text(yaml.safe_dump(values))
    text = overview(load_any_study(study))
    assert f"P on no patch, on {name}, where it does not move; Q on centre" in text


PASCAL = {
    "quiet": [25, 40, 60, 80, 70, 50, 30],  # 137 dB in Pa, 80.4 as levels
    "loud": [3, 30, 70, 120, 90, 60, 20],  # 139 dB in Pa, 120 as levels
    "loudest": [61, 70, 90, 175, 160, 80, 70],  # 142 dB in Pa, 175 as levels
}
CHAMBER = [121, 128, 131, 133, 130, 124, 96]
FILTERED = [-40, 2, 131, 133, 130, 124, 96]


@pytest.mark.parametrize(
    ("levels", "oaspl_db", "message"),
    [
        (PASCAL["quiet"], None, "far below a launch; in Pa or Pa²/Hz?"),
        (PASCAL["quiet"], 137.2, "must be levels in dB, not in Pa"),
        (PASCAL["quiet"], 140, "must be levels in dB, not in Pa"),
        (PASCAL["quiet"], 80.4, ""),
        (PASCAL["loud"], None, "not those of a launch; in Pa?"),
        (PASCAL["loud"], 145, "must be levels in dB, not in Pa"),
        (PASCAL["loud"], 120, ""),
        (PASCAL["loudest"], None, "not those of a launch; in Pa?"),
        (PASCAL["loudest"], 175.1, ""),
        (CHAMBER, None, ""),
        (CHAMBER, 160, ""),
        (FILTERED, None, ""),
        (FILTERED, 160, ""),
    ],
)
def test_pressures_are_not_taken_as_levels(tmp_path, levels, oaspl_db, message):
    bands = [31.5, 63, 125, 250, 500, 1000, 2000]
    rows = [f"{f:g},{level}" for f, level in zip(bands, levels, strict=True)]
    (tmp_path / "levels.csv").write_text("\n".join(["center_hz,spl_db", *rows]))
    values = changed("l_panel", ("sound", "spectrum"), "levels.csv")
    values["response"]["frequency_hz"] = [50, 1000]
    if oaspl_db is not None:
        values["sound"]["oaspl_db"] = oaspl_db
    if message:
        ((line, told),) = refused(tmp_path, values)
        assert line.startswith("spectrum:") and message in told
    else:
        path = tmp_path / "mine.yaml"
        path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
        checked_study(path)


def test_a_file_whose_name_has_a_new_line_leaves_messages_on_one_line(
    tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "le\nvels.csv").write_text("center_hz,spl_db\n63,126\n")
    values = changed("l_panel", ("sound", "spectrum"), "le\nvels.csv")
    Path("st\nudy.yaml").write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    for command in ("check", "compare"):
        names = ["st\nudy.yaml"] if command == "check" else ["no\nstudy", "st\nudy.yaml"]
        assert main([command, *names]) == MISTAKE
        (told,) = capsys.readouterr().err.splitlines()
        assert "\\n" in told
    for unreadable in ("a: [", "", "- 1"):
        Path("st\nudy.yaml").write_text(unreadable)
        assert main(["check", "st\nudy.yaml"]) == MISTAKE
        (told,) = capsys.readouterr().err.splitlines()
        assert told.startswith("st\\nudy.yaml:")


@pytest.mark.parametrize(("scale", "is_refused"), [(1e-3, True), (1.0, False)])
def test_a_damping_ratio_over_kilohertz_is_refused(tmp_path, scale, is_refused):
    table = [[50 * scale, 0.02], [900 * scale, 0.01]]
    values = changed("l_panel", ("panel", "damping_ratio"), table)
    (tmp_path / "ratio.csv").write_text(
        "frequency_hz,damping_ratio\n" + "".join(f"{f:g},{z:g}\n" for f, z in table)
    )
    from_file = changed("l_panel", ("panel", "damping_ratio"), "ratio.csv")
    for study in (values, from_file):
        if is_refused:
            ((line, told),) = refused(tmp_path, study)
            assert line.startswith("damping_ratio:") and told.endswith("in kHz?")
        else:
            path = tmp_path / "mine.yaml"
            path.write_text(yaml.safe_dump(study, sort_keys=False, allow_unicode=True))
            checked_study(path)
