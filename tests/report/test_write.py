"""From files to pages: the scripts of the report on the results of small studies."""

import base64
import re
import shutil
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from pidpanel.coupon import coding
from pidpanel.coupon import rows as coupon_rows
from pidpanel.coupon.from_study import cases_of, write_table
from pidpanel.coupon.records import Shaken, ShakeOutcome
from pidpanel.report import read
from pidpanel.study import StudyError, load_any_study

GOLDEN = Path(__file__).parents[1] / "coupon" / "liggghts" / "golden" / "shake"

COUPON = """
title: One cell
coupon:
  cell: {count: 1, depth_mm: 10}
  particles: {diameter_mm: 2.5}
  sweep: {fill_fraction: [0.5], frequency_hz: [200], acceleration_g: [10]}
  accuracy: {seeds: 1}
"""


def script(name):
    return import_module(f"scripts.{name}").main


def images(page):
    """The pictures in a page, by the name of their figure."""
    found = re.findall(
        r'<figure id="(\w+)"[^>]*>\s*<img[^>]* src="data:image/\w+;base64,([^"]+)"', page
    )
    return {name: base64.b64decode(data) for name, data in found}


def assert_the_figures_are_those_of_the_page(page, folder):
    drawn = images(page.read_text(encoding="utf-8"))
    assert drawn
    assert {path.stem: path.read_bytes() for path in folder.iterdir()} == drawn


# --------------------------------------------------------------------------- a panel


@pytest.fixture(scope="module")
def table(tmp_path_factory, write_study, table_values):
    """Results of a study with measured damping, from mesh to maps; its file and its folder."""
    root = tmp_path_factory.mktemp("table")
    study, folder = write_study(root, "table", table_values()), root / "results" / "table"
    for stage in ("panel", "sound", "response"):
        (folder / stage).mkdir(parents=True)

    def at(*names):
        return [str(folder / name) for name in names]

    modes, force, air = at("panel/modes.nc", "sound/modal_force.nc", "sound/air.nc")
    section, plate = at("panel/section.csv", "panel/plate.nc")
    panel = at("panel/modes.csv", "panel/modes.vtu", "panel/mesh.msh")
    script("panel")([str(study), modes, *panel, section, plate])
    script("sound")([str(study), modes, *at("sound/spectrum.csv"), force, air])
    names = ("psd.nc", "summary.csv", "layouts.csv", "stress.nc", "stress.csv", "left_out.nc")
    response = at(*(f"response/{name}" for name in (*names, "radiation.csv")))
    script("response")([str(study), modes, force, plate, section, "none", air, *response])
    maps = at("response/left_out.nc", "response/psd.nc", "response/maps.nc", "response/maps")
    script("maps")([str(study), modes, force, "none", plate, *maps])
    script("report")([str(study), str(folder), str(folder.parent / "coupon")])
    return study, folder


def test_the_page_of_a_panel_holds_the_figures_beside_it(table):
    # red: write_page without the loop over the pictures
    _, folder = table
    assert_the_figures_are_those_of_the_page(folder / "report.html", folder / "report")
    assert {path.stem for path in (folder / "report").iterdir()} == {
        "panel", "answer", "reduction_mass", "mesh", "mode_shapes", "spectrum", "maps",
        *(f"steps_{family}_{point}" for family in ("fill", "place", "level") for point in ("centre", "Edge")),
        *(f"psd_{family}_{point}" for family in ("fill", "place", "level") for point in ("centre", "Edge")),
        *(f"{what}_{family}" for family in ("fill", "place", "level") for what in ("reduction", "damping")),
    }  # fmt: skip


def test_a_page_says_how_to_reproduce_it_and_names_files_that_exist(table):
    # red: radiation.csv named where it was not asked for; response/psd.csv for psd.nc
    study, folder = table
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert f"make run STUDY={study}" in page
    listed = re.search(r"are in results/table: ([^;]+);", page)[1].split(", ")
    assert "response/radiation.csv" in listed and "panel/section.csv" in listed
    assert [name for name in listed if not (folder / name).is_file()] == []


def test_the_page_has_its_parts_in_order(table):
    # red: maps before the responses; radiation left out where it was asked for
    page = (table[1] / "report.html").read_text(encoding="utf-8")
    assert re.findall(r'<h2 id="([^"]+)">', page) == [
        "outcome", "limitations", "panel", "sound", "response-fill", "response-place", "response-level",
        "radiation", "maps", "summary", "stress", "reproduce",
    ]  # fmt: skip


def test_names_that_look_like_numbers_stay_names(table):
    # red: _read_by_point without its dtype
    folder = table[1]
    for name in ("summary.csv", "stress.csv", "radiation.csv"):
        text = (
            (folder / "response" / name).read_text().replace("centre", "007").replace("Edge", "012")
        )
        (folder / "numbered.csv").write_text(text)
        frame = read._read_by_point(folder / "numbered.csv")
        assert set(frame["point"]) == {"007", "012"}, name


# --------------------------------------------------------------------------- a coupon


@pytest.fixture(scope="module")
def coupon(tmp_path_factory):
    """A study of one case and its run: the recorded one, its steps as this deck would count them."""
    folder = tmp_path_factory.mktemp("coupon")
    file = folder / "cell.yaml"
    file.write_text(COUPON)
    study = load_any_study(file)
    (case,) = cases_of(study.coupon)
    (run,), (outcome,) = case.runs, case.outcomes(folder / "runs")
    outcome.parent.mkdir(parents=True)
    for name in ("last.dump", "start.data"):
        shutil.copy(GOLDEN / name, outcome.parent)
    head = [line for line in (GOLDEN / "cycles_1.txt").read_text().splitlines() if line[0] == "#"]
    rows = np.loadtxt(GOLDEN / "cycles_1.txt")
    text = [f"{number * run.steps_per_cycle} " + " ".join(f"{x:.8g}" for x in row[1:])
            for number, row in enumerate(rows, 1)]  # fmt: skip
    (outcome.parent / "cycles_1.txt").write_text("\n".join([*head, *text]) + "\n")
    mass = 8 * 1190 * np.pi / 6 * 2.5e-3**3
    digest = coupon_rows.digest(run, outcome.parent, (len(rows),), len(rows))
    found = Shaken(len(rows), (len(rows),), 8, mass, "accuracy", None, digest)
    coding.write(outcome, ShakeOutcome("ok", "", 1, "3.8.0", 0.0, run, case.target, found))
    write_table(study, "coupon", folder / "runs", folder / "cases.csv")
    paths = ("cases.csv", "runs", "report.html", "report")
    script("coupon_report")([str(file), *(str(folder / path) for path in paths)])
    return file, folder, case


def test_the_page_of_a_coupon_holds_its_figures_its_case_and_its_run(coupon):
    # red: read_coupon that shows the cycles of no case
    _, folder, case = coupon
    assert_the_figures_are_those_of_the_page(folder / "report.html", folder / "report")
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "8 particles of 2.5 mm in 1 hexagonal cell of 6.35 mm × 10 mm, r = 0.5" in page
    assert case.label in page
    assert "1 case, 1 of them ok" in page
    assert {"particles", "steadiness"} <= set(images(page))
    assert "results/cell/coupon/cases.csv" in page


def test_the_cases_of_another_study_are_refused_by_name(coupon):
    # red: the comparison of labels left out, and a KeyError
    file, folder, case = coupon
    text = (folder / "cases.csv").read_text()
    (folder / "others.csv").write_text(text.replace(case.label, "r0.4_f200Hz"))
    with pytest.raises(StudyError, match=r"others\.csv: r0\.4_f200Hz: not a case of cell as it is"):
        read.read_coupon(load_any_study(file), "coupon", folder / "others.csv", folder / "runs")


# --------------------------------------------------------------------------- verification


def test_a_case_is_computed_shown_and_confirmed(tmp_path):
    # red: verify that returns no rows; a page of the rows of the first file alone
    first, second = str(tmp_path / "plate.csv"), str(tmp_path / "field.csv")
    script("verify")(["panel", "isotropic_core", first])
    script("verify")(["sound", "field", second])
    page, figures, said = (tmp_path / name for name in ("page.html", "figures", "verified.txt"))
    script("verification")([str(page), str(figures), first, second])
    script("verified")([str(said), first, second])
    count = int(re.match(r"(\d+) of \1 numbers within their tolerance\n", said.read_text())[1])
    text = page.read_text(encoding="utf-8")
    assert f"{count} of {count} numbers agree with their reference" in text
    assert "NOT MET" not in text
    # the plate, the field, and the piston with free edges that the field brings along
    assert len(re.findall(r'<h2 id="case-', text)) == 3
    assert list(figures.iterdir()) == []  # neither has a curve to show
