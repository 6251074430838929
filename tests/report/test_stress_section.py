"""The table of strain and stress: worst layer, units, every point."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report.summary_section import stress_section
from pidpanel.response.tables import stress_rows
from pidpanel.solve.stress import CORE_QUANTITIES, QUANTITIES
from tests.page_reader import blocks_of

FREQUENCY = np.array([100.0, 150.0, 200.0])
"""100 Hz wide: a flat PSD of s²/100 has the rms s, whatever the rule of integration."""

STRAIN = [120e-6, 45.61e-6, 7e-6]
STRESS = [2e6, 3.456e6, 0.5e6, 4e6]


def rows_of(layer, quantities, rms_of_points, points=("7", "12"), scenario="bare"):
    """Rows of response/stress.csv from rms values in SI units, (n_points, n_quantities)."""
    psd = np.broadcast_to(np.square(rms_of_points) / 100, (3, len(points), len(quantities)))
    of = {"scenario": scenario, "layer": layer}
    return [{**of, **row} for row in stress_rows(FREQUENCY, psd, quantities, points)]


@pytest.fixture
def stress():
    """Worst below at point 7 and above at point 12, where the core has more than both."""
    low, high = np.array([*STRAIN, *STRESS]), 10 * np.array([*STRAIN, *STRESS])
    rows = rows_of("top", QUANTITIES, [low, high])
    rows += rows_of("bottom", QUANTITIES, [2 * low, low])
    rows += rows_of("core", CORE_QUANTITIES, [[9e9, 9e9]] * 2)
    rows += rows_of("top", QUANTITIES, [low, low], scenario="A_r0.5")
    return pd.DataFrame(rows)


def test_every_scenario_and_point_has_one_row_at_its_worst_layer(stress):
    (table,) = blocks_of(stress_section(stress))
    assert [row[:3] for row in table.rows] == [
        ["bare", "7", "bottom"],
        ["bare", "12", "top"],
        ["A_r0.5", "7", "top"],
        ["A_r0.5", "12", "top"],
    ]
    assert table.columns[:3] == ["scenario", "point", "layer"]
    assert table.folded


def test_rms_and_three_sigma_are_in_mpa_and_micrometres_per_metre(stress):
    (table,) = blocks_of(stress_section(stress))
    last = dict(zip(table.columns, table.rows[-1], strict=True))
    assert {head: last[head] for head in table.columns[3:]} == {
        "σ_v 3σ, MPa": "12.0",
        "σ_v, MPa": "4.00",
        "σ_xx, MPa": "2.00",
        "σ_yy, MPa": "3.46",
        "τ_xy, MPa": "0.500",
        "ε_xx, µm/m": "120",
        "ε_yy, µm/m": "45.6",
        "γ_xy, µm/m": "7.00",
    }
    assert table.rows[0][3:5] == ["24.0", "8.00"]
    assert table.rows[1][3:5] == ["120", "40.0"]
