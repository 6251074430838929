"""Files for other programs, read back."""

import dataclasses

import numpy as np
import pandas as pd
import pytest
import pyuff
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.measurement.files import read_measured
from pidpanel.measurement.universal import RecordChoice
from pidpanel.response.exports import (
    Curve,
    third_octave_rows,
    write_base_exports,
    write_tabrnd1,
    write_uff58,
)
from pidpanel.response.results import write_csv
from pidpanel.solve.lines import frequency_grid

POSITION = np.array([[0.75, 0.5], [0.1, 0.3]])
FREQUENCY = np.geomspace(50.0, 200.0, 101)
LOW = 3.21098765e-7 * FREQUENCY**2
CURVES = [
    Curve("bare", "326", 1, 1e3 / FREQUENCY, 1e3 / FREQUENCY),
    Curve("PID-1_r0.5", "middle", 2, LOW, 4 * LOW),
]


def cards(text):
    """{table: (x, y)} of large-field TABRND1 cards, as Nastran reads them: fields of 16."""
    tables = {}
    for line in text.splitlines():
        if line.startswith("$"):
            continue
        fields = [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
        if line.startswith("TABRND1*"):
            values = tables[int(fields[0])] = []
        elif line.startswith("*"):
            values += [field for field in fields if field]
    for number, values in tables.items():
        assert values.pop() == "ENDT"
        tables[number] = np.array(values, dtype=float).reshape(-1, 2).T
    return tables


def test_nastran_cards_hold_the_psd_to_ten_figures(tmp_path):
    path = tmp_path / "tabrnd1.bdf"
    write_tabrnd1(path, FREQUENCY, CURVES, "study")
    text = path.read_text()
    assert max(len(line) for line in text.splitlines()) <= 72  # a card of large fields
    assert "$ subcase 1, grid 2, component 3: PID-1_r0.5, point middle" in text
    tables = cards(text)
    assert list(tables) == [1, 2]
    for curve, (x, y) in zip(CURVES, tables.values(), strict=True):
        np.testing.assert_allclose(x, FREQUENCY, rtol=1e-9)
        np.testing.assert_allclose(y, curve.acceleration_psd, rtol=1e-9)


def test_universal_files_are_read_back_with_node_direction_and_units(tmp_path):
    path = tmp_path / "psd.uff"
    write_uff58(path, FREQUENCY, CURVES, "study", POSITION)
    sets = pyuff.UFF(str(path)).read_sets()
    assert [one["type"] for one in sets] == [151, 164, 15, 58, 58]
    for curve, read in zip(CURVES, sets[3:], strict=True):
        np.testing.assert_array_equal(read["x"], FREQUENCY)
        np.testing.assert_array_equal(read["data"], curve.acceleration_psd)
        assert (read["rsp_node"], read["rsp_dir"], read["func_type"]) == (curve.node, 3, 9)
        assert read["rsp_ent_name"].strip() == curve.point
        assert read["ordinate_axis_units_lab"].strip() == "(m/s**2)**2/Hz"
        assert curve.scenario in read["id1"]


def test_lines_at_a_step_of_the_input_come_back_from_our_own_files(tmp_path):
    lines = frequency_grid(50.0, 200.0, 0.01, jumps=[100.0, 125.0])
    psd = np.where(lines < 100, 2.0, np.where(lines < 125, 1.0, 0.5))
    write_uff58(tmp_path / "psd.uff", lines, [Curve("bare", "P", 1, psd, psd)], "s", POSITION)
    columns = {"acceleration_psd_g2_hz_P": psd, "velocity_psd_m2_s2_hz_P": 7.0,
               "acceleration_psd_g2_hz_other": 7.0}  # fmt: skip
    write_csv(tmp_path / "psd.csv", pd.DataFrame({"frequency_hz": lines, **columns}), 7)
    for name, unit in (("psd.uff", STANDARD_GRAVITY**-2), ("psd.csv", 1.0)):
        measured = read_measured(tmp_path / name, point="P")
        np.testing.assert_allclose(measured.psd, unit * psd, rtol=1e-12)
        np.testing.assert_allclose(measured.frequency, lines, rtol=1e-6)
        assert (np.diff(measured.frequency) > 0).all()
        steps = measured.frequency[:-1][np.diff(measured.psd) != 0]
        assert steps.tolist() == [np.nextafter(100.0, 0), np.nextafter(125.0, 0)]


def test_universal_files_hold_points_and_units_in_the_columns_of_the_format(tmp_path):
    # read by the columns of its description (SDRC), not by the library that writes data set 58
    path = tmp_path / "psd.uff"
    write_uff58(path, FREQUENCY, CURVES, "a study", POSITION)
    lines = path.read_text(encoding="latin-1").splitlines()
    marks = [number for number, line in enumerate(lines) if line.strip() == "-1"]
    sets = {
        int(lines[start + 1][:6]): lines[start + 2 : end]
        for start, end in zip(marks[:6:2], marks[1:6:2], strict=True)
    }
    assert sets[151][0] == "a study" and len(sets[151]) == 7
    assert (int(sets[164][0][:10]), int(sets[164][0][30:40])) == (1, 2)
    factors = [float(sets[164][1][k : k + 25].replace("D", "E")) for k in (0, 25, 50)]
    assert factors == [1.0, 1.0, 1.0]
    for node, (line, place) in enumerate(zip(sets[15], POSITION, strict=True), start=1):
        assert int(line[:10]) == node
        read = [float(line[k : k + 13]) for k in (40, 53, 66)]
        np.testing.assert_allclose(read, [*place, 0.0], atol=1e-5)


def test_third_octaves_hold_the_whole_mean_square_and_the_reduction():
    # bands that adjoin add up to ∫ S df where they cover the range; straight lines in both: 1e-3
    known = [dataclasses.replace(curve, log_error=np.full(FREQUENCY.size, 0.2)) for curve in CURVES]
    # 0.2 of every PSD is 0.1 of every rms value
    rows = third_octave_rows(FREQUENCY, known)
    np.testing.assert_allclose(
        rows["acceleration_rms_error_g"], 0.1 * rows["acceleration_rms_g"], rtol=1e-9
    )
    rows = third_octave_rows(FREQUENCY, CURVES)
    assert rows["acceleration_rms_error_g"].isna().all()
    for curve, gained in zip(CURVES, (0.0, 20 * np.log10(2)), strict=True):
        own = rows[rows["scenario"] == curve.scenario]
        covered = (own["lower_hz"].min(), own["upper_hz"].max())
        lines = np.linspace(*covered, 20001)
        whole = np.trapezoid(np.interp(lines, FREQUENCY, curve.acceleration_psd), lines)
        total = (own["mean_acceleration_psd_g2_hz"] * (own["upper_hz"] - own["lower_hz"])).sum()
        assert total * STANDARD_GRAVITY**2 == pytest.approx(whole, rel=1e-4)
        np.testing.assert_allclose(own["reduction_db"], gained, atol=1e-9)


def test_base_motion_has_files_of_its_points_and_of_the_supports(tmp_path):
    scale = xr.DataArray(
        [[1.0, 0.5], [0.4, np.nan]],
        dims=("scenario", "input"),
        coords={"scenario": ["bare", "s"], "input": ["stated", "notched"]},
    )
    line = xr.DataArray(LOW, dims="frequency", coords={"frequency": FREQUENCY})
    gain = xr.DataArray([3.0, 7.0], dims="point", coords={"point": ["A", "B"]})
    psd = xr.Dataset({
        "input_psd": scale * line, "absolute_acceleration_psd": scale * line * gain,
        "log_error": 0.1 * scale * line * gain,
    })  # fmt: skip
    summary = pd.DataFrame(
        [("bare", "stated", ""), ("bare", "notched", "coarse"), ("s", "stated", ""),
         ("s", "notched", "")], columns=["scenario", "input", "doubts"],
    )  # fmt: skip
    write_base_exports(psd, summary, "a study", POSITION, tmp_path / "export")
    bands = pd.read_csv(tmp_path / "export" / "third_octaves.csv")
    at_b = bands[(bands["scenario"] == "s") & (bands["point"] == "B")]
    np.testing.assert_allclose(at_b["reduction_db"], -10 * np.log10(0.4), rtol=1e-4)
    tables = cards((tmp_path / "export" / "tabrnd1.bdf").read_text())
    assert len(tables) == 9
    path, g2 = tmp_path / "export" / "psd.uff", STANDARD_GRAVITY**2
    for record, factor in ((1, 0.5), (3, 3.5), (4, 1.0), (9, 2.8)):
        read = read_measured(path, RecordChoice(record)).psd * g2
        np.testing.assert_allclose(read, factor * LOW, rtol=1e-12)
        np.testing.assert_allclose(tables[record][1], factor * LOW, rtol=1e-8)
