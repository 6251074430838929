"""Two studies against each other: a difference within the stated errors is none."""

import math

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.report.comparison import (
    BEST,
    NothingInCommon,
    Side,
    comparison_lines,
    comparison_page,
    differences,
    missing_scenarios,
)
from pidpanel.report.html import render


def side(name, values, source="single tones", point="P"):
    """A study of (scenario, rms, error) at one point."""
    rows = [
        {"damping_source": source, "scenario": scenario, "patch": "none" if scenario == "bare" else "A",
         "point": point, "acceleration_rms_g": rms, "acceleration_rms_error_g": error}
        for scenario, rms, error in values
    ]  # fmt: skip
    labels = [row["scenario"] for row in rows]
    psd = np.full((len(labels), 3, 1), 2.0)
    dims = ("scenario", "frequency", "point")
    coords = {
        "scenario": labels,
        "frequency": [100.0, 150, 200],
        "point": [point],
    }
    return Side(name, pd.DataFrame(rows), xr.Dataset({"acceleration_psd": (dims, psd)}, coords))


@pytest.mark.parametrize(
    ("one", "other", "verdict"),
    [
        ((10, 0.3), (9, 0.3), "lower"),  # 1 g against 2 √(0.03² + 0.033²) of it
        ((9, 0.3), (10, 0.3), "higher"),
        ((10, 0.3), (9.5, 0.3), "within the errors"),
        ((10, math.nan), (5, 0.3), "not judged: no stated error"),
        ((10, math.nan), (10.001, 0.3), "the same"),
        ((10, 0.0), (9.9, 0.0), "lower"),
    ],
)
def test_a_difference_counts_from_two_standard_errors(one, other, verdict):
    found = differences(side("one", [("a", *one)]), side("other", [("a", *other)]))
    assert set(found["verdict"]) == {verdict}


def test_the_reduction_and_its_error_are_those_of_the_ratio():
    found = differences(side("one", [("a", 10, 0.3)]), side("other", [("a", 8, 0.4)]))
    assert found["reduction"].tolist() == pytest.approx([20 * math.log10(10 / 8)] * 2)
    assert found["error"].tolist() == pytest.approx([8.685889638 * math.hypot(0.03, 0.05)] * 2)


def test_scenarios_of_one_name_are_compared_and_the_best_of_each():
    one = side("one", [("bare", 10, np.nan), ("x", 8, 0.1), ("y", 7, 0.1)])
    other = side("other", [("bare", 10, np.nan), ("x", 5, 0.1), ("z", 6, 0.1)], source="table")
    one.summary["added_mass_kg"], other.summary["added_mass_kg"] = [0, 0.2, 0.1], [0, 0.3, 0.4]
    found = differences(one, other).set_index("scenario")
    assert list(found.index) == ["bare", "x", BEST]
    assert found.loc[BEST, ["label_first", "label_second"]].tolist() == ["y", "x"]
    assert found.loc["bare", "verdict"] == "the same"
    assert list(missing_scenarios(one, other)) == ["only in one: y", "only in other: z"]
    lines = list(comparison_lines(one, other))
    assert lines[0].split()[:2] == ["scenario", "point"]
    message = "other against one, 3 rms accelerations: 1 the same, 2 lower by 2.9 to 4.1 dB. "
    assert (
        lines[-3].startswith(message)
        and lines[3].endswith("lower     0.10 | 0.30")
        and lines[-1] == "only in other: z"
    )


def test_studies_without_a_common_point_say_which_points_they_have():
    with pytest.raises(NothingInCommon, match="points of a are P, of b Q"):
        list(comparison_lines(side("a", [("x", 1, 0.1)]), side("b", [("x", 1, 0.1)], point="Q")))


def test_the_page_names_what_differs_for_certain_and_draws_both():
    one = side("one", [("bare", 10, np.nan), ("x", 8, 0.1), ("y", 7, 2.0)])
    other = side("other", [("bare", 10, np.nan), ("x", 5, 0.1), ("y", 6.9, 2.0)])
    page = comparison_page(one, other)
    assert [row[0] for row in page.first[0].values["rows"]] == ["x"]
    (picture,) = page.sections[0].blocks
    assert [curve.label.split(",")[0] for curve in picture.charts[0].curves] == ["one", "other"] * 2
    assert "within the errors" in render(page)


def test_the_best_is_that_of_a_level_and_is_drawn_over_the_bare_panel_of_that_level():
    values = [("bare", 100, np.nan), ("x", 50, 0.1), ("y", 40, 0.1)]
    quiet = [("bare_142", 10, np.nan), ("x_142", 4, 0.1), ("y_142", 5, 0.1)]
    sides = []
    for name in ("one", "other"):
        result = side(name, values + quiet)
        rows = result.summary
        rows["oaspl_db"] = [162.04] * 3 + [142.04] * 3
        rows["patch"] = ["none", "A", "A"] * 2
        sides.append(result)
    rows = differences(*sides)
    best = rows[rows["scenario"] == BEST].set_index("best_level")["label_first"]
    assert best.to_dict() == {162.0: "y", 142.0: "x_142"}
    lines = [line for line in comparison_lines(*sides) if BEST in line]
    assert [("best at 162 dB: y" in line, "best at 142 dB: x_142" in line) for line in lines] == [
        (True, False), (False, True),
    ]  # fmt: skip
    (section,) = (part for part in comparison_page(*sides).sections if part.name == "psd")
    curves = [[curve.label for curve in picture.charts[0].curves] for picture in section.blocks]
    assert curves == [
        ["one, x_142", "other, x_142", "one, bare_142", "other, bare_142"],
        ["one, y", "other, y", "one, bare", "other, bare"],
    ]
    # another level alone has no best in common
    sides[1].summary["oaspl_db"] += 3
    assert BEST not in set(differences(*sides)["scenario"])
    (section,) = (part for part in comparison_page(*sides).sections if part.name == "psd")
    assert len(section.blocks) == 1
