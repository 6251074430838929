"""Tables of break points: levels and slopes, or one line for what is wrong."""

import numpy as np
import pytest

from pidpanel.columns import ColumnsError
from pidpanel.paths import DATA
from pidpanel.spectra.acceleration_table import read_base_table

HEADER = "frequency_hz,acceleration_psd_g2_hz,slope_db_octave\n"


@pytest.fixture
def read(tmp_path):
    def read(text, header=HEADER):
        path = tmp_path / "input.csv"
        path.write_text(header + text)
        return read_base_table(path)

    return read


@pytest.mark.parametrize(("name", "overall"), [("qualification", 14.1), ("acceptance", 10.0)])
def test_gevs_integrates_to_its_overall_value(name, overall):
    spectrum = read_base_table(DATA / "base" / f"gevs_{name}.csv")
    assert spectrum.rms == pytest.approx(overall, rel=5e-3)
    f = np.geomspace(20, 2000, 200_001)
    assert spectrum.rms == pytest.approx(np.sqrt(np.trapezoid(spectrum(f), f)), rel=1e-6)


def test_slopes_give_levels_forward_and_backward(read):
    spectrum = read("20,,3.0103\n40,0.1,0\n400,,-6.0206\n800,,\n")
    np.testing.assert_allclose(spectrum.psd, [0.05, 0.1, 0.1, 0.025], rtol=1e-5)
    np.testing.assert_allclose(spectrum(np.array([20.0, 80.0, 800.0])), [0.05, 0.1, 0.025], 1e-5)


def test_slopes_lead_over_several_rows_either_way(read):
    spectrum = read("20,,3\n80,,-6\n160,0.1,3\n1280,,-2\n2560,,\n")
    decibels = [0.0, 6.0, 0.0, 9.0, 7.0]
    np.testing.assert_allclose(10 * np.log10(spectrum.psd / 0.1), decibels, atol=1e-9)


def test_the_last_level_alone_leads_back_and_the_first_not_to_the_last(read):
    np.testing.assert_allclose(read("20,0.1,\n40,,3.0103\n80,0.1,\n").psd, [0.1, 0.05, 0.1], 1e-5)
    with pytest.raises(ColumnsError) as error:
        read("20,0.1,\n40,,3\n80,,\n")
    assert [message.split("empty at ")[1][:5] for message in error.value.faults] == [
        "40 Hz",
        "80 Hz",
    ]


def test_the_slope_of_minus_three_decibels_has_its_own_integral(read):
    spectrum = read("20,0.1\n40,0.05\n", "frequency_hz,acceleration_psd_g2_hz\n")
    assert spectrum.rms == pytest.approx(np.sqrt(2 * np.log(2)))


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("20,0.01,\n50,,\n800,0.16,\n", 3, "a gap: acceleration_psd_g2_hz is empty at 50 Hz"),
        ("20,0.01,\n20,0.16,\n", 3, "a step at an end is not allowed"),
        ("50,0.01,\n20,0.16,\n", 3, "frequency_hz = 20 follows 50"),
        ("20,0.01,-6\n50,0.16,\n", 2, "slope_db_octave = -6 between 20 and 50 Hz, where"),
        ("20,0.01,\n50,0.16,-6\n", 3, "at the last row leads nowhere"),
        ("20,0.01,\n50,-0.1,\n", 3, "must be above 0"),
        ("20,0.1,\n50,0.1,\n50,0.1,\n80,0.1,\n", 3, "is given twice with one level"),
        ("20,0.01,\n100100,0.1,\n", 3, "at most 100000"),
        ("20,0.01,-101\n20.2,,\n", 2, "must be from -100 to 100"),
        ("20,0.01,101\n20.2,,\n", 2, "must be from -100 to 100"),
        ("20,0.1,0.52\n40,0.1,\n", 2, "= 0.52 between 20 and 40 Hz, where the levels give +0.00"),
        ("20,0.1,\n40,0.1,\n80,0.1,3\n", 4, "slope_db_octave = 3 at the last row"),
        ("20,0.01,steep\n50,0.1,\n", 2, "must be a finite number"),
        ("20,0.01\n50,0.1,\n", 2, "has 2 values, must have 3"),
    ],
)
def test_each_mistake_is_told_in_a_line(read, text, line, message):
    with pytest.raises(ColumnsError) as error:
        read(text)
    (told,) = error.value.faults
    assert f"line {line}: " in told and message in told


def test_a_table_needs_two_rows(read):
    with pytest.raises(ColumnsError, match="at least two break points"):
        read("20,0.1,\n")
