"""Measured PSDs: read from files, and compared with computed ones in third octaves."""

import numpy as np
import pandas as pd
import pytest
import pyuff

from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.measurement.differences import band_differences
from pidpanel.measurement.files import (
    FORCE_COLUMN,
    PSD_COLUMN,
    RATIO_COLUMN,
    MeasuredPsd,
    read_measured,
)
from pidpanel.measurement.universal import RecordChoice
from pidpanel.response.exports import Curve, write_uff58
from pidpanel.solve.bands import band_rms

HEAD = "frequency_hz,acceleration_psd_g2_hz\n"
FREQUENCY = np.geomspace(20.0, 400.0, 300)
PSD = 2.0 + np.cos(FREQUENCY / 9)


def universal(path, **changes):
    """A universal file of one data set 58."""
    values = {
        "func_type": 9, "abscissa_spacing": 0, "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "g^2/Hz",
        "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0,
        "id1": "a", "rsp_node": 1, "rsp_dir": 3, "ref_node": 0, "ref_dir": 0,
        "x": FREQUENCY, "data": PSD,
    }  # fmt: skip
    pyuff.UFF(str(path)).write_sets([pyuff.prepare_58(**(values | changes))], mode="add")
    return path


def test_a_table_and_universal_files_in_either_unit_give_one_psd(tmp_path):
    table = tmp_path / "test.csv"
    frame = pd.DataFrame({"frequency_hz": FREQUENCY, "acceleration_psd_g2_hz": PSD})
    frame.to_csv(table, index=False)
    ours = tmp_path / "ours.uff"
    curves = [Curve("bare", "p", 1, *[PSD * STANDARD_GRAVITY**2] * 2)]
    write_uff58(ours, FREQUENCY, curves, "study", np.zeros((1, 2)))
    for path in (table, ours, universal(tmp_path / "g.unv")):
        read = read_measured(path)
        np.testing.assert_allclose(read.frequency, FREQUENCY, rtol=1e-5)
        np.testing.assert_allclose(read.psd, PSD, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.csv", "frequency_hz,phase\n20,1\n", "column 'phase': unknown"),
        ("a.csv", f"{HEAD}20,1\n", "at least two lines"),
        ("a.csv", f"{HEAD}20,1\n10,1\n", "must rise; 10 Hz follows 20 Hz"),
        ("a.csv", "frequency_hz,transmissibility\n20,0\n30,0\n", "the transmissibility must be"),
        ("a.csv", f"{HEAD}0,1\n20,1\n", "frequency_hz = 0: must be above 0"),
        ("a.csv", f"{HEAD}20,1\n30,1.05e6\n", "from 0 to 1e+06"),
        ("a.csv", "frequency_hz,transmissibility\n20,1\n30,1.05e6\n", "from 0 to 1e+06"),
        ("a.csv", f"{HEAD}20,1\n20,1\n30,1\n", "20 Hz is given twice"),
        ("a.csv", f"{HEAD}20,1\n30,1\n30,2\n30,3\n", "30 Hz is given twice"),
        ("a.csv", f"{HEAD}20,1\n30,1\n30,2\n20,3\n", "20 Hz follows 30 Hz"),
        ("a.csv", "frequency_hz,acceleration_psd_g2_hz\n20,-1\n30,1\n", "from 0 to 1e+06"),
        ("a.csv", "frequency_hz,acceleration_psd_g2_hz\n20,0\n30,0\n", "not 0 everywhere"),
        ("a.uff", "no data set\n", "has no data set 58"),
        ("a.uff", "    -1\n    58\nbroken\n    -1\n", "no universal file that can be read"),
    ],
)
def test_a_file_that_is_wrong_is_refused_in_a_line(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(ColumnsError) as error:
        read_measured(path)
    (fault,) = error.value.faults
    assert fault.startswith(str(path)) and message in fault


def test_two_lines_at_one_frequency_are_a_step(tmp_path):
    path = tmp_path / "steps.csv"
    path.write_text(f"{HEAD}0.4,4\n0.5,4\n0.5,1\n0.9,1\n")
    assert read_measured(path).frequency.tolist() == [0.4, np.nextafter(0.5, 0), 0.5, 0.9]
    path.write_text(f"{HEAD}40,4\n100,4\n100,1\n140,1\n")
    measured = read_measured(path)
    assert measured.frequency.tolist() == [40.0, np.nextafter(100.0, 0), 100.0, 140.0]
    rms = band_rms(measured.frequency, measured.psd, np.array([[40.0, 140.0], [90.0, 110.0]]))
    np.testing.assert_allclose(rms**2, [280.0, 50.0], rtol=1e-12)


def test_a_table_of_several_points_gives_that_of_a_point(tmp_path):
    path = tmp_path / "points.csv"
    head = f"frequency_hz,{PSD_COLUMN}_P,velocity_psd_m2_s2_hz_P,{PSD_COLUMN}_Q\n"
    path.write_text(f"{head}20,1,7,4\n30,2,8,5\n")
    for point, values in (("P", [1, 2]), ("Q", [4, 5])):
        measured = read_measured(path, point=point)
        assert measured.frequency.tolist() == [20, 30] and measured.psd.tolist() == values
    with pytest.raises(ColumnsError, match="'acceleration_psd_g2_hz_P': unknown"):
        read_measured(path, point="R")
    path.write_text(f"{head}20,1,7,4\n30,2,8\n40,3,9,6\n")
    with pytest.raises(ColumnsError, match="line 3: has 3 values, must have 2"):
        read_measured(path, point="Q")


@pytest.mark.parametrize("name", [PSD_COLUMN, RATIO_COLUMN, FORCE_COLUMN])
def test_columns_of_a_curve_are_those_of_its_table(name):
    columns = MeasuredPsd(np.array([20.0, 30.0]), np.array([4.0, 9.0]), name).columns
    assert list(columns) == ["frequency_hz", name]
    assert columns[name].tolist() == ([4, 9] if name == PSD_COLUMN else [2, 3])


def test_the_number_of_a_data_set_belongs_to_universal_files(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(f"{HEAD}20,1\n30,1\n")
    with pytest.raises(
        ColumnsError, match="record, node and direction are only allowed with a universal file"
    ):
        read_measured(path, RecordChoice(1))


def test_a_universal_file_of_another_function_or_of_several_is_refused(tmp_path):
    with pytest.raises(ColumnsError, match="6 is a coherence"):
        read_measured(universal(tmp_path / "coherence.uff", func_type=6))
    with pytest.raises(ColumnsError, match="must be an acceleration"):
        read_measured(universal(tmp_path / "force.uff", ordinate_spec_data_type=13))
    two = universal(universal(tmp_path / "two.uff"), data=3 * PSD)
    with pytest.raises(ColumnsError, match="has 2 data sets 58, 2 of them as selected; record, or"):
        read_measured(two)
    np.testing.assert_allclose(read_measured(two, RecordChoice(2)).psd, 3 * PSD, rtol=1e-6)
    with pytest.raises(ColumnsError, match="has 2 data sets 58, none of them as selected"):
        read_measured(two, RecordChoice(3))


def test_a_transmissibility_is_read_from_a_table_and_a_frequency_response(tmp_path):
    gain = PSD * np.exp(2j * FREQUENCY)
    table = tmp_path / "gain.csv"
    frame = pd.DataFrame({"frequency_hz": FREQUENCY, "transmissibility": np.abs(gain)})
    frame.to_csv(table, index=False)
    accelerations = {"func_type": 4, "data": gain, "orddenom_spec_data_type": 12}
    labels = {"ordinate_axis_units_lab": "m/s^2", "orddenom_axis_units_lab": "m/s^2"}
    for path in (table, universal(tmp_path / "frf.uff", **accelerations, **labels)):
        read = read_measured(path)
        assert read.over_base
        np.testing.assert_allclose(read.psd, PSD**2, rtol=1e-6)
    forces = accelerations | {"orddenom_spec_data_type": 13}
    with pytest.raises(ColumnsError, match="acceleration over force must be in"):
        read_measured(universal(tmp_path / "force.uff", **forces))


def test_differences_are_those_of_the_bands_that_both_have():
    frequency = np.linspace(50.0, 900.0, 2000)
    computed = 2 * np.interp(frequency, FREQUENCY, PSD)
    error = np.full(frequency.size, 0.1)
    bands = list(
        band_differences(MeasuredPsd(FREQUENCY, PSD), frequency, computed, error).itertuples()
    )
    assert (bands[0].lower_hz, bands[-1].upper_hz) == (50.0, 400.0)
    for band in bands:
        # lines of the two are not the same: 1e-2 of a PSD that waves
        assert band.difference_db == pytest.approx(10 * np.log10(2), abs=0.05)
        assert band.difference_error_db == pytest.approx(1 / np.log(10), rel=1e-6)
    assert band_differences(MeasuredPsd(FREQUENCY / 100, PSD), frequency, computed).empty


def test_all_frequencies_of_a_computation_within_a_measurement_are_compared():
    frequency = np.linspace(50.0, 200.0, 151)
    measured, psd = MeasuredPsd(np.array([20.0, 400.0]), np.full(2, 4.0)), np.full(151, 1.0)
    gap = np.where(frequency == 60, np.nan, 0.1)
    for error in (None, gap):
        bands = list(band_differences(measured, frequency, psd, error).itertuples())
        assert (bands[0].lower_hz, bands[-1].upper_hz) == (50.0, 200.0)
        for band in bands:
            assert band.difference_db == pytest.approx(-20 * np.log10(2))
            assert np.isnan(band.difference_error_db)


@pytest.mark.parametrize(
    ("column", "end", "power"),
    [(PSD_COLUMN, "psd_g2_hz", 1), (RATIO_COLUMN, RATIO_COLUMN, 0.5),
     (FORCE_COLUMN, FORCE_COLUMN, 0.5)],
)  # fmt: skip
def test_a_band_has_its_mean_psd_or_the_rms_of_its_ratio(column, end, power):
    measured = MeasuredPsd(np.array([20.0, 400.0]), np.full(2, 25.0), column)
    bands = band_differences(measured, np.linspace(50.0, 200.0, 151), np.full(151, 9.0))
    assert bands[f"measured_{end}"].tolist() == pytest.approx([25.0**power] * len(bands))
    assert bands[f"computed_{end}"].tolist() == pytest.approx([9.0**power] * len(bands))
