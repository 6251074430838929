"""From files to pages: the scripts of the report on the results of small studies."""

import base64
import re
from dataclasses import replace

import pytest

from pidpanel.report import from_study, inputs
from pidpanel.report.html import write_figures
from pidpanel.study import StudyError, load_any_study, load_study


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


def test_the_page_of_a_panel_holds_the_figures_beside_it(table):
    _, folder = table
    assert_the_figures_are_those_of_the_page(folder / "report.html", folder / "report")
    assert {path.stem for path in (folder / "report").iterdir()} == {
        "panel", "reduction_mass", "mode_shapes", "maps", "failure_maps",
    }  # fmt: skip
    page = (folder / "report.html").read_text(encoding="utf-8")
    figures = set(re.findall(r'<figure id="(\w+)"', page))
    assert figures - set(images(page)) == {
        "answer", "spectrum", "oscillators", "measurement_1",
        *(f"psd_{family}_{point}" for family in ("fill", "place", "level") for point in ("centre", "Edge")),
        *(f"{what}_{family}" for family in ("fill", "place", "level") for what in ("reduction", "damping")),
    }  # fmt: skip


def test_figures_are_written_as_vectors(table, tmp_path):
    study, folder = table
    page = replace(from_study.page_of(load_study(study), study, folder), sections=[])
    write_figures(page, ("svg", "pdf"), tmp_path / "figures")
    for name in ("panel", "answer", "reduction_mass"):
        svg, pdf = (tmp_path / "figures" / f"{name}.{ending}" for ending in ("svg", "pdf"))
        assert "<path" in svg.read_text() and "<dc:date>" not in svg.read_text()
        assert pdf.read_bytes().startswith(b"%PDF")


def test_names_that_look_like_numbers_stay_names(table):
    folder = table[1]
    for name in ("summary.csv", "stress.csv"):
        text = (
            (folder / "response" / name).read_text().replace("centre", "007").replace("Edge", "012")
        )
        (folder / "numbered.csv").write_text(text)
        frame = inputs.read_by_point(folder / "numbered.csv")
        assert set(frame["point"]) == {"007", "012"}, name


# --------------------------------------------------------------------------- a coupon


def test_the_page_of_a_coupon_holds_its_figures_its_case_and_its_run(coupon):
    _, folder, _ = coupon
    assert_the_figures_are_those_of_the_page(folder / "report.html", folder / "report")
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "1 hexagonal cell, 6.35 mm wide, 10 mm deep" in page
    assert "1 case, 1 of them ok" in page
    assert "results/cell;" in page


def test_the_cases_of_another_study_are_refused_by_name(coupon):
    file, folder, case = coupon
    text = (folder / "cases.csv").read_text()
    (folder / "others.csv").write_text(text.replace(case.label, "r0.4_f200Hz"))
    with pytest.raises(StudyError, match=r"others\.csv: r0\.4_f200Hz: not a case of cell as it is"):
        from_study.read_coupon(load_any_study(file), "coupon", folder / "others.csv")
