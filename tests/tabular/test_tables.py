"""Texts of spreadsheets, specifications and old programs: the numbers that they state, or a line."""

import numpy as np
import pytest

from pidpanel.check import checked_study
from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY as G
from pidpanel.damping_ratio import read_damping_ratio
from pidpanel.measurement.files import read_measured
from pidpanel.sound.table import read_pressure
from pidpanel.spectra.acceleration_table import read_acceleration
from pidpanel.study import StudyError


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "t.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


LEVELS = [120, 121.5, 122]  # of 800, 1000, 1250 Hz
# (text, what is said of it)
SPECTRA = {
    "semicolons, decimal commas": ("Frequenz [Hz];Pegel [dB]\n800;120,0\n1000;121,5\n1250;122\n", "decimal comma"),
    "tabs, no header": ("800\t120\n1000\t121.5\n1250\t122\n", "no header, read as center_hz, spl_db"),
    "blanks, decimal commas": ("800 120\n1000 121,5\n\n1250 122,0\n", "blanks, decimal comma"),
    "aligned blanks": ("Frequency [Hz]    SPL [dB]\n  800   120\n 1000   121.5\n 1250   122.0\n", "blanks"),
    "bars": ("| Frequency (Hz) | SPL (dB) |\n|---|---:|\n|800|120|\n|1000|121.5|\n|1250|122|\n", "bars"),
    "a mark of UTF-8": ("\ufefff,L\r\n800,120\r\n1000,121.5\r\n1250,122\r\n", "'L' as spl_db"),
    "UTF-16, thousands": ("f;L\n800;120,0\n1.000;121,5\n1.250;122\n".encode("utf-16"), "UTF-16"),
    "Windows-1252": ("# für\nFréquence (Hz);SPL (dB re 20 µPa)\n800;120\n1000;121,5\n1250;122\n".encode("cp1252"), "Windows-1252"),
    "quoted thousands": ('f,"SPL, dB"\n800,120\n"1,000",121.5\n"1,250",122\n', "from t.csv"),
    "a header of two lines in quotes": ('"Frequency\n(Hz)","SPL\n(dB)"\n800,120\n1000,121.5\n1250,122\n', "from t.csv"),
    "a title, and units in a line": ("Launcher X, fairing\n\nFrequency,SPL\n(Hz),(dB)\n800,120\n1000,121.5\n1250,122\n", "from t.csv"),
    "kHz": ("Frequency (kHz),SPL (dB)\n0.8,120\n1,121.5\n1.25,122\n", "'Frequency (kHz)' as center_hz times 1000"),
    "units in cells": ("f,L\n800 Hz,120 dB\n1k,121.5dB\n1.25 kHz,122\n", "from t.csv"),
    "forms of numbers": ("f,L\n8e+02,120.\n1.0D+03,1.215E2\n1250,+122\n", "from t.csv"),
    "a header of NumPy": ("# freq spl\n8.0e+02 1.20e+02\n1e3 1.215e+02\n1.25e3 1.22e2\n", "'freq' as center_hz"),
    "an overall level": ("f,L\n800,120\n1000,121.5\n1250,122\nOASPL,126.0\n", "stated"),
    "an overall level at 0 Hz": ("f,L\n800,120\n1000,121.5\n1250,122\n0,126\n", "from t.csv"),
    "an overall level in words": ("f,L\nOverall = 126 dB\n800,120\n1000,121.5\n1250,122\n", "from t.csv"),
    "text and empty cells below": ("f;L;;\n800;120;;\n1000;121,5;;\n1250;122;;\n;;;\nNote: P95/50;;;\n", "1 line of text left out"),
    "a column of text": ("f,L,Notes\n800,120,lift-off\n1000,121.5,\n1250,122,max q\n", "column 'Notes' left out"),
    "another order": ("sep=,\nSPL [dB],1/3 Octave Band Center Frequency (Hz)\n120,800\n121.5,1000\n122,1250\n", "from t.csv"),
}  # fmt: skip


@pytest.mark.parametrize("name", SPECTRA)
def test_levels_of_one_spectrum_in_many_forms(written, name):
    text, remark = SPECTRA[name]
    spectrum, summary = read_pressure(written(text))
    np.testing.assert_allclose(spectrum.band_spl, LEVELS)
    np.testing.assert_array_equal(spectrum.band_number, [29, 30, 31])
    assert summary.startswith("3 third octaves 800 to 1250 Hz, 126.0 dB, from t.csv")
    assert remark in summary or remark == "stated"


def test_the_only_decimal_comma_may_be_that_of_the_overall_level(written):
    spectrum, _ = read_pressure(written("f;L\n800;120\n1000;121\n1250;122\nOASPL;125,9\n"))
    assert spectrum.oaspl == pytest.approx(10 * np.log10(1e12 + 10**12.1 + 10**12.2), abs=0.01)


@pytest.mark.parametrize("reference", ["20 µPa", "2×10^-5 Pa", "2 x 10-5 Pa", "2e-5 Pa"])
def test_levels_state_their_reference_in_any_of_its_forms(written, reference):
    text = f"f (Hz);Level (dB ref {reference})\n800;120\n1000;121.5\n1250;122\n"
    assert read_pressure(written(text))[0].band_spl.tolist() == LEVELS


def test_centres_without_their_decimals(written):
    spectrum, _ = read_pressure(written("12,100\n16,100\n20,100\n25,100\n31,100\n"))
    assert spectrum.band_number.tolist() == [11, 12, 13, 14, 15]


GEVS = "20,0.026\n50,0.16\n800,0.16\n2000,0.026\n"
INPUTS = {  # of GEVS qualification
    "points": GEVS,
    "a specification": "Frequency (Hz);ASD level\n20;0,026 g²/Hz\n20-50;+6 dB/oct\n50–800;0,16\n800 to 2000;-6 dB/octave\n2000 Hz;0,026\nOverall;14,1 Grms\n",
    "slopes in a column": "Hz,g²/Hz,dB/oct\n20,,+6 dB/Oct.\n50,0.16,0\n800,0.16,-6\n2000,,\n",
    "slopes for levels": "f,psd\n20,+6 dB/oct\n50,0.16\n800,0.16\n2000,0.026\n",
    "SI": f"Frequency [Hz],PSD [(m/s²)²/Hz]\n20,{0.026 * G**2}\n50,{0.16 * G**2}\n800,{0.16 * G**2}\n2000,{0.026 * G**2}\n",
    "mm": f"f (Hz),mm²/s⁴/Hz\n20,{0.026e6 * G**2}\n50,{0.16e6 * G**2}\n800,{0.16e6 * G**2}\n2000,{0.026e6 * G**2}\n",
}  # fmt: skip


@pytest.mark.parametrize("name", INPUTS)
def test_break_points_of_one_input_in_many_forms(written, name):
    points, summary = read_acceleration(written(INPUTS[name]))
    np.testing.assert_allclose(points.frequency, [20, 50, 800, 2000])
    np.testing.assert_allclose(points.psd, [0.026, 0.16, 0.16, 0.026], rtol=0.02)
    assert summary.startswith("4 break points 20 to 2000 Hz, 14.1 g rms, from t.csv")


@pytest.mark.parametrize(
    ("text", "frequency"),
    [
        ("1 Hz to 2 kHz", [1, 2000]),
        ("1 kHz to 2000 Hz", [1000, 2000]),
        ("1k-2k", [1000, 2000]),
        ("1-2 kHz", [1000, 2000]),
        ("1-2 Hz", [1, 2]),
    ],
)
@pytest.mark.parametrize("unit", ["Hz", "kHz"])
def test_each_end_of_a_range_has_its_own_unit(written, text, frequency, unit):
    points, _ = read_acceleration(written(f"f ({unit}),psd\n{text},0.01\n"))
    np.testing.assert_allclose(points.frequency, frequency)


def test_steps_high_levels_and_low_frequencies_of_an_input(written):
    points, _ = read_acceleration(written("f,psd\n0.1-5,20\n5-10,0.2\n"))
    assert points.frequency.tolist() == [0.1, 5, 5, 10]
    assert points.jumps.tolist() == [5]
    assert points.rms == pytest.approx(np.sqrt(20 * 4.9 + 0.2 * 5))
    part = points.segment(1.0, 5.0)
    assert (part.frequency.tolist(), part.psd.tolist()) == ([1, 5], [20, 20])
    assert points.segment(5.0, 99.0).psd.tolist() == [0.2, 0.2]
    assert points.segment(2.0, 8.0).rms == pytest.approx(np.sqrt(60 + 0.6))


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        (read_pressure, "f;L\n800;120\n1000;12x1\n", "line 3: spl_db = '12x1': must be a finite"),
        (read_pressure, "800,12x0\n1000,121\n", "line 1: spl_db = '12x0': must be a finite"),
        (read_pressure, "f,L\n800,120\n1000,121\nx,122\n", "line 4: center_hz = 'x': must be"),
        (read_pressure, "f,L\n800,120\n1000,121\n1.2.50,y\n", "line 4: center_hz = '1.2.50'"),
        (read_pressure, "800Ω120\n1000\t121\n1250\t122\n", "line 1: "),
        (read_pressure, "f;L\n800;120\n1000;121#5\n", "line 3: spl_db = '121#5'"),
        (read_pressure, "f;L\n800;120\n%1000;121\n", "line 3: center_hz = '%1000'"),
        (read_pressure, 'f;L\n800;120\n1000;"21\n', "line 3: unexpected end of data"),
        (read_pressure, "800 120\n1000 121 5\n", "line 2: has 3 values"),
        (read_pressure, "f,SPL [dB(A)]\n800,120\n1000,121\n", "'SPL [dB(A)]': must be in dB"),
        (read_pressure, "f,A-weighted SPL (dB)\n800,120\n1000,121\n", "'A-weighted SPL (dB)': unknown"),
        (read_pressure, "Frequency,SPL\nHz,dBA\n800,120\n1000,121\n", "spl_db = 'dBA'"),
        (read_pressure, "f,L1 (dB),L2 (dB)\n800,120,1\n1000,121,2\n", "spl_db: given twice, 'L1 (dB)' and 'L2 (dB)'"),
        (read_pressure, "f,L\n800,120\n1000,121\nOASPL,128\n", "line 4: states 128 dB, its bands sum to 123.5"),
        (read_pressure, "1,000;120\n2,000;121\n", "line 1: '1,000' may be 1000 or 1.000"),
        (read_pressure, "f;L\n800;120,5\n1000;121.5\n", "line 3: '121.5' has another mark of decimals"),
        (read_pressure, "800,120,1\n1000,121,1\n", "must name the columns, found the numbers"),
        (read_pressure, b"\xff\xfe\x00", "must be text in UTF-8"),
        (read_acceleration, "f,psd\n20-80,0.04\n100-500,0.02\n", "line 3: no row has 80 to 100 Hz"),
        (read_acceleration, "f,ASD (g/√Hz)\n20,0.1\n80,0.2\n", "'ASD (g/√Hz)': must be in g^2/Hz"),
        (read_acceleration, "f,g/sqrt(Hz)\n20,0.1\n80,0.2\n", "column 'g/sqrt(Hz)': unknown"),
        (read_acceleration, "f,Acceleration (g)\n20,0.1\n80,0.2\n", "'Acceleration (g)': unknown"),
        (read_acceleration, "f,psd\n20,0.1\n80,0.2\nGrms,5\n", "line 4: states 5 g rms"),
        (read_measured, "f,Transmissibility (dB)\n20,1\n80,2\n", "must be a ratio"),
    ],
)  # fmt: skip
def test_what_may_be_wrong_is_refused_in_a_line(written, read, text, message):
    with pytest.raises(ColumnsError) as error:
        read(written(text))
    assert message in str(error.value)


def test_measured_curves_and_damping_ratios_have_usual_headers(written):
    path = written("Frequency (Hz);A1 (g²/Hz);A2 (g²/Hz)\n20;0,1;0,2\n30;0,2;0,4\n")
    assert read_measured(path, point="A2").psd.tolist() == [0.2, 0.4]
    curve = read_measured(written("f,Transmissibility [g/g]\n20,1\n30,2\n"))
    assert (curve.psd.tolist(), curve.over_base) == ([1, 4], True)
    ratio = read_damping_ratio(written("Frequency (Hz);Damping ratio (%)\n20;1,5\n30;2\n"))
    assert ratio.ratio == pytest.approx((0.015, 0.02))


STUDY = """
panel:
  outline_m: [1.2, 0.8]
  section: {mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273}
  mesh: {kind: quadrilaterals, elements: [12, 8]}
  patches: {p: {centre_m: [0.47, 0.33], size_m: [0.21, 0.17]}}
  points: {A: [0.5, 0.37], B: [0.31, 0.22]}
base: {random: {spectrum: t.csv}}
response: {frequency_hz: [20, 400]}
dampers: {d: {equivalent_damping_n_s_m3: 500, apparent_mass_kg_m2: 1}}
scenarios: {s: {layout: {p: {damper: d}}}}
"""


def test_an_input_that_may_be_in_si_is_refused_until_its_overall_value_is_stated(written, tmp_path):
    # red: levels above 10 taken as they are; refused though stated
    written("20,15.4\n500,15.4\n")
    study = tmp_path / "mine.yaml"
    study.write_text(STUDY)
    with pytest.raises(StudyError, match=r"have 86 g rms; in \(m/s²\)²/Hz\? base.random.overall_g"):
        checked_study(study)
    study.write_text(STUDY.replace("t.csv}", "t.csv, overall_g: 86}"))
    assert checked_study(study).base.random.overall_g == 86


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("", "is an acceleration over force; the key drive must name the point that was hit: A, B"),
        (", drive: C", "drive = C: unknown point; allowed are A, B"),
        (", drive: B, scenario: s", "not allowed with an acceleration over force"),
        (", drive: B", None),
    ],
)
def test_a_hammer_hits_a_point_of_the_bare_panel(written, tmp_path, keys, message):
    # red: the first point hit
    written("20,0.01\n500,0.01\n")
    (tmp_path / "tap.csv").write_text("f,Accelerance (m/s²/N)\n20,1\n400,2\n")
    study = tmp_path / "mine.yaml"
    study.write_text(f"{STUDY}measurements: {{tap: {{file: tap.csv, point: A{keys}}}}}\n")
    if message is None:
        assert checked_study(study).measurements["tap"].drive == "B"
        return
    with pytest.raises(StudyError) as error:
        checked_study(study)
    assert message in str(error.value)
