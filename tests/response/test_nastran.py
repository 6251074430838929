"""Cards fill the columns that Nastran reads: a name of 8 characters, fields of 16."""

import numpy as np
import pytest

from pidpanel.response.nastran import large_field_table, modal_damping_ratio, write_tabdmp1


def test_fields_fill_their_columns_and_the_table_ends():
    x, y = np.array([20.0, 31.5, 2000.0]), np.array([1e-12, 0.25, 3e5])
    lines = "".join(large_field_table("TABRND1", 7, ["LINEAR", "LINEAR"], x, y)).splitlines()
    assert lines[0] == "TABRND1*" + f"{7:16d}" + 2 * f"{'LINEAR':>16}" + 16 * " "
    assert lines[1] == "*"
    fields = []
    for line in lines[2:]:
        assert line[:8] == "*       " and len(line) <= 72
        fields += [line[k : k + 16] for k in range(8, len(line), 16)]
    assert [float(field) for field in fields[:-1]] == [20.0, 1e-12, 31.5, 0.25, 2000.0, 3e5]
    assert fields[-1].strip() == "ENDT"


def read_tabdmp1(text):
    """Tables of a bulk data file in large field: (type, pairs) by number."""
    tables, cells = {}, None
    for line in text.splitlines():
        if line.startswith("$"):
            continue
        fields = [line[8 + 16 * k : 24 + 16 * k].strip() for k in range(4)]
        if line.startswith("TABDMP1*"):
            cells = []
            tables[int(fields[0])] = (fields[1], cells)
        else:
            assert line.startswith("*")
            cells += [f for f in fields if f]
    return {
        number: (kind, np.array(cells[: cells.index("ENDT")], float).reshape(-1, 2))
        for number, (kind, cells) in tables.items()
    }


def test_the_cards_read_back_are_what_was_written(tmp_path):
    frequency = np.array([64.8966, 124.6, 200.0, 1700.123456])
    ratios = {"dem, PID-1 r = 0.5": np.array([0.012, 0.3, 0.01, 0.0456789]),
              "dem, bare": np.full(4, 0.01)}  # fmt: skip
    write_tabdmp1(tmp_path / "t.bdf", frequency, ratios, "study")
    text = (tmp_path / "t.bdf").read_text()
    assert max(len(line) for line in text.splitlines()) <= 80
    tables = read_tabdmp1(text)
    for number, ratio in enumerate(ratios.values(), start=1):
        kind, pairs = tables[number]
        assert kind == "CRIT"
        np.testing.assert_allclose(pairs[:, 0], frequency, rtol=1e-8)
        np.testing.assert_allclose(pairs[:, 1], ratio, rtol=1e-8)


def test_modes_of_one_frequency_share_their_mean(tmp_path):
    write_tabdmp1(tmp_path / "t.bdf", np.array([100.0, 100.0, 200.0]),
                  {"a": np.array([0.02, 0.04, 0.1])}, "study")  # fmt: skip
    _, pairs = read_tabdmp1((tmp_path / "t.bdf").read_text())[1]
    np.testing.assert_allclose(pairs, [[100, 0.03], [200, 0.1]])


def test_the_ratio_is_that_of_one_oscillator_with_a_dashpot():
    # m ẍ + (c + C_e D) ẋ + k x: half the bandwidth at half power over the frequency
    mass, f, area, damping = 1.5, 80.0, 0.04, 60.0
    omega = 2 * np.pi * f
    total = 2 * 0.01 * mass * omega + damping * area
    (ratio,) = modal_damping_ratio(0.01, *(np.array([v]) for v in (f, mass, area, damping)))
    w = omega * np.linspace(0.9, 1.1, 200001)
    power = 1 / ((mass * (omega**2 - w**2)) ** 2 + (total * w) ** 2)
    band = w[power > power.max() / 2]
    # exact to second order in ζ, and to the step of w
    assert ratio == pytest.approx((band[-1] - band[0]) / (2 * omega), rel=1e-3)
