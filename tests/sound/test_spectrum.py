"""Band levels, their files and the pressure PSD."""

import re
from pathlib import Path

import numpy as np
import pytest

from pidpanel.columns import ColumnsError
from pidpanel.sound.spectrum import BandSpectrum, Spectrum, SpectrumError, envelope, pressure_psd
from pidpanel.sound.table import read_spectrum
from pidpanel.spectra.break_points import BreakPoints

SPL = Path(__file__).parents[2] / "workflow" / "data" / "spl"
TABLES = sorted(SPL.glob("*.csv"))


def stated_oaspl(spectrum: BandSpectrum) -> float:
    match = re.search(r"stated OASPL ([\d.]+) dB", spectrum.source)
    return float(match.group(1))


def third_octaves(low: int = 20, high: int = 33) -> BandSpectrum:
    number = np.arange(low, high + 1)
    return BandSpectrum.of_levels("third octave", number, 120 + 3 * np.sin(number))


def write(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "spl.csv"
    path.write_text("\n".join(["# title", "center_hz,spl_db", *lines]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.stem)
def test_a_table_sums_to_the_oaspl_that_its_publisher_states(path):
    # 0.1 dB: levels and sums are published with one decimal
    spectrum = read_spectrum(path)
    assert spectrum.oaspl == pytest.approx(stated_oaspl(spectrum), abs=0.1)


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.stem)
def test_a_table_says_its_kind_of_band_and_the_centres_agree(path):
    spectrum = read_spectrum(path)
    assert spectrum.kind == ("octave" if "1/1 octave" in spectrum.source else "third octave")


@pytest.mark.parametrize("path", TABLES, ids=lambda path: path.stem)
def test_the_psd_integrates_to_the_oaspl(path):
    # midpoint rule on each band: exact for a step spectrum, so only rounding is left (1e-10)
    spectrum = read_spectrum(path)
    edge = spectrum.edge_frequency
    psd = pressure_psd(spectrum, (edge[1:] + edge[:-1]) / 2)
    mean_square = np.sum(psd * np.diff(edge))
    expected = 20e-6**2 * np.sum(10 ** (spectrum.band_spl / 10))
    assert mean_square == pytest.approx(expected, rel=1e-10)
    oaspl = 20 * np.log10(np.sqrt(mean_square) / 20e-6)
    assert oaspl == pytest.approx(stated_oaspl(spectrum), abs=0.1)


def test_third_octaves_of_equal_psd_rise_one_decibel_a_band():
    # white noise: bandwidths grow by 10^0.1, exactly 1 dB
    number = np.arange(15, 40)
    spectrum = BandSpectrum.of_levels("third octave", number, 100.0 + np.arange(number.size))
    psd = pressure_psd(spectrum, spectrum.center_frequency)
    np.testing.assert_allclose(psd, psd[0], rtol=1e-12)


def test_an_octave_is_three_thirds():
    octave = BandSpectrum.of_levels("octave", np.array([30]), np.array([100.0]))
    thirds = BandSpectrum.of_levels("third octave", np.array([29, 30, 31]), np.full(3, 95.0))
    np.testing.assert_allclose(octave.edge_frequency, thirds.edge_frequency[[0, -1]], rtol=1e-14)


def test_an_envelope_has_the_larger_psd_of_octaves_thirds_and_a_psd():
    thirds = third_octaves(17, 30)
    octaves = BandSpectrum.of_levels("octave", np.array([24, 27, 30]), np.array([127.0, 119, 130]))
    points = BreakPoints(np.array([60.0, 210.0]), np.array([500.0, 5.0]))
    spectra = thirds, octaves, Spectrum(points)
    highest, whose = envelope(spectra)
    assert highest.band_number.tolist() == list(range(17, 32))
    assert set(whose.tolist()) == {0, 1, 2} and whose[-1] == 1  # beyond the other tables
    for number, row in zip(highest.band_number, whose, strict=True):
        edge = 10 ** ((number + np.array([-0.5, 0.5])) / 10)
        inside = [
            s for s in spectra if s.reach[0] < edge[0] * 1.0001 and s.reach[1] > edge[1] / 1.0001
        ]
        squares = [s.points.mean_square(*edge) for s in inside]
        np.testing.assert_allclose(highest.points.mean_square(*edge), max(squares))
        assert spectra[row] is inside[int(np.argmax(squares))]


def test_spectra_with_a_gap_or_less_than_a_band_have_no_envelope():
    with pytest.raises(ColumnsError, match=r"no table has the third octave at 125\.9 Hz"):
        envelope([third_octaves(15, 20), third_octaves(22, 25)])
    with pytest.raises(ColumnsError, match="table 2 has no whole third octave"):
        envelope([third_octaves(), Spectrum(BreakPoints(np.array([99, 101.0]), np.ones(2)))])


def test_a_band_owns_its_lower_edge_and_the_last_band_both():
    spectrum = third_octaves()
    edge = spectrum.edge_frequency
    inside = pressure_psd(spectrum, spectrum.center_frequency)
    np.testing.assert_array_equal(pressure_psd(spectrum, edge), np.append(inside, inside[-1]))
    np.testing.assert_array_equal(
        pressure_psd(spectrum, np.nextafter(edge[1:-1], 0.0)), inside[:-1]
    )


@pytest.mark.parametrize("factor", [0.999, 1.001])
def test_nothing_is_extrapolated(factor):
    spectrum = third_octaves()
    end = spectrum.edge_frequency[0 if factor < 1 else -1]
    with pytest.raises(SpectrumError, match=r"not extrapolated"):
        pressure_psd(spectrum, [500.0, end * factor])


def test_a_spectrum_is_shifted_to_an_oaspl_band_by_band():
    spectrum = third_octaves()
    loud = spectrum.shifted(162.0 - spectrum.oaspl)
    assert loud.oaspl == pytest.approx(162.0, abs=1e-10)
    np.testing.assert_allclose(np.ptp(loud.band_spl - spectrum.band_spl), 0.0, atol=1e-10)
    assert loud.shifted(-10.0).oaspl == pytest.approx(152.0, abs=1e-10)


@pytest.mark.parametrize(("reference", "decibels"), [("room", 3.0103), ("incident", 6.0206)])
def test_a_rigid_face_sees_more_than_the_room_or_the_incident_wave(reference, decibels):
    spectrum = third_octaves()
    ratio = pressure_psd(spectrum, [500.0], reference) / pressure_psd(spectrum, [500.0])
    assert 10 * np.log10(ratio) == pytest.approx(decibels, abs=1e-4)


@pytest.mark.parametrize("nominal", [(31.5, 40, 50, 63), (31.25, 39.37, 49.6, 62.5)])
def test_nominal_and_base_two_centres_stand_for_the_exact_base_ten_ones(tmp_path, nominal):
    spectrum = read_spectrum(write(tmp_path, *(f"{center},120" for center in nominal)))
    np.testing.assert_allclose(spectrum.center_frequency, 10 ** np.array([1.5, 1.6, 1.7, 1.8]))


REFUSED = {
    # name: (lines after the header at line 2, what the message says)
    "unsorted": (["125,120", "100,120", "160,120"], "line 4: center_hz = 100 follows a higher"),
    "double": (["100,120", "100,121", "125,120"], "line 4: center_hz = 100 appears twice"),
    "gap": (["100,120", "125,120", "200,120"], "line 5: between 125 and 200 Hz there is a gap"),
    "octave gap in thirds": (
        ["100,120", "125,120", "250,120"],
        "line 5: between 125 and 250 Hz there is a gap; third octave bands must adjoin",
    ),
    "octave gap": (["63,120", "125,120", "500,120"], "line 5: between 125 and 500 Hz"),
    "every other third": (["100,120", "160,120"], "line 4: between 100 and 160 Hz"),
    "octaves off their centres": (["50,120", "100,120"], "line 3: center_hz = 50 is not an octave"),
    "not a centre": (["100,120", "110,120"], "line 4: center_hz = 110 is not a preferred centre"),
    "level in pascal squared": (
        ["100,120", "125,4e5"],
        "line 4: spl_db = 4e5: must be from -100 to 200 .in Pa",
    ),
    "a digit missing": (
        ["100,120", "125,12", "160,121"],
        "line 4: spl_db = 12: more than 40 dB below both neighbours, 120 and 121 dB",
    ),
    "a digit too many": (
        ["100,20", "125,120", "160,21"],
        "line 4: spl_db = 120: more than 40 dB above both neighbours, 20 and 21 dB",
    ),
    "one band": (["100,120"], "1 band; at least two"),
    "no band": ([], "no bands; at least two"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_table_that_cannot_be_meant_is_refused_by_line_and_value(tmp_path, name):
    lines, message = REFUSED[name]
    with pytest.raises(ColumnsError, match=message) as caught:
        read_spectrum(write(tmp_path, *lines))
    assert "spl.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("levels", [(130, 85, 84), (84, 130, 131)])
def test_levels_that_fall_or_rise_steeply_are_read(tmp_path, levels):
    rows = [f"{center},{level}" for center, level in zip((100, 125, 160), levels, strict=True)]
    spectrum = read_spectrum(write(tmp_path, *rows))
    np.testing.assert_array_equal(spectrum.band_spl, levels)


def test_a_comment_that_states_another_kind_of_band_is_refused(tmp_path):
    path = tmp_path / "spl.csv"
    path.write_text("# band: 1/1 octave\ncenter_hz,spl_db\n100,90\n125,90\n", encoding="utf-8")
    with pytest.raises(ColumnsError, match="line 1: the comment states octave bands"):
        read_spectrum(path)


def test_the_factor_to_another_level_is_that_of_the_shifted_spectrum():
    spectrum = BandSpectrum.of_levels("octave", np.array([27, 30]), np.array([100.0, 90.0]))
    louder = spectrum.shifted(130.0 - spectrum.oaspl)
    ratio = pressure_psd(louder, [500.0, 1000.0]) / pressure_psd(spectrum, [500.0, 1000.0])
    np.testing.assert_allclose(ratio, spectrum.pressure_factor(130.0), rtol=1e-12)
