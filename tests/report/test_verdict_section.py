"""Which damping model holds, on the page."""

import pandas as pd
import pytest

from pidpanel.report.verdict_files import BARE, COLUMNS
from pidpanel.report.verdict_section import verdict_section, worst
from tests.page_reader import blocks_of

TITLES = {"beads": "Single tones", "lab": "Table"}


def row(damper, point, level, difference, band, holds):
    values = (f"P_{level}", level, damper, point, 10.0, 11.0, 0.01, difference, 63.0, band, 0.1,
              holds)  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


@pytest.fixture
def verdict():
    return pd.DataFrame(
        [
            row(damper, point, level, difference * sign, band * sign, holds)
            for level in (122.0, 136.7)
            for damper, difference, band, holds in (
                (BARE, 0.3, 3.0, "no"), ("beads", -0.1, -1.0, "no"), ("lab", 0.01, 0.2, "yes"),
            )
            for point, sign in (("a", 1), ("b", -0.5))
        ]
    )  # fmt: skip


def test_what_is_worst_of_the_points_counts(verdict):
    verdict.loc[(verdict["damper"] == "lab") & (verdict["point"] == "b"), "holds"] = "open"
    found = worst(verdict).set_index(["damper", "scenario"])
    assert found.loc[("beads", "P_122.0"), "difference"] == -0.1
    assert found.loc[("beads", "P_122.0"), "band_difference_db"] == -1.0
    assert found.loc[("lab", "P_122.0"), "holds"] == "open"


def test_the_section_counts_scenarios_in_which_a_model_holds(verdict):
    verdict.loc[(verdict["damper"] == "lab") & (verdict["oaspl_db"] > 130), "holds"] = "open"
    section = verdict_section(verdict, ["a", "b"], TITLES)
    text = blocks_of(section)[0].text
    assert "Single tones: holds in 0 of 2, does not hold in 2;" in text
    assert "Table: holds in 1 of 2, open in 1" in text
    assert "Bare" not in text  # no model


def test_every_model_has_a_row_and_every_scenario_a_column(verdict):
    table = blocks_of(verdict_section(verdict, ["a", "b"], TITLES))[-1]
    assert list(table.columns) == ["damping model", "P_122.0", "P_136.7"]
    assert len(table.rows) == 3
    assert table.rows[1][1].startswith("−10.0 ± 1.0 %; −1.00 ± 0.10 dB at 63 Hz")
