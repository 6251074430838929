"""A pressure PSD in Pa²/Hz: integrals in closed form, and the same answer as equal band levels."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

import pidpanel
from pidpanel.columns import ColumnsError
from pidpanel.paths import DATA
from pidpanel.sound.spectrum import REFERENCE_PRESSURE, Spectrum, SpectrumError, pressure_psd
from pidpanel.sound.table import read_spectrum
from pidpanel.spectra.break_points import BreakPoints

BANDS = DATA / "spl" / "smc_s_016_2014_min_third.csv"
POINTS = BreakPoints(np.array([50.0, 200, 200, 800, 2000]), np.array([2.0, 8, 4, 1, 0.01]))


def model(spectrum, folder, **sound):
    return pidpanel.Model({
        "panel": {
            "outline_m": [0.6, 0.5], "damping_ratio": 0.02,
            "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 1000.0},
            "mesh": {"kind": "quadrilaterals", "elements": [12, 10]},
            "patches": {"p": {"centre_m": [0.3, 0.25], "size_m": [0.2, 0.2]}},
            "points": {"A": [0.3, 0.25]},
        },
        "sound": {"spectrum": str(spectrum), **sound},
        "response": {"frequency_hz": [40, 500]},
        "dampers": {"d": {"equivalent_damping_n_s_m3": 300, "apparent_mass_kg_m2": 1}},
        "scenarios": {"s": {"layout": {"p": {"damper": "d"}}}},
    }, folder)  # fmt: skip


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    """The band levels as a PSD that is flat in each band."""
    path = tmp_path_factory.mktemp("psd") / "flat.csv"
    bands = read_spectrum(BANDS)
    edge = bands.edge_frequency
    psd = REFERENCE_PRESSURE**2 * 10 ** (bands.band_spl / 10) / np.diff(edge)
    frequency = np.repeat(edge, 2)[1:-1].tolist()
    rows = [f"{f!r},{s!r}" for f, s in zip(frequency, np.repeat(psd, 2).tolist(), strict=True)]
    path.write_text("# flat\nfrequency_hz,psd_pa2_hz\n" + "\n".join(rows) + "\n")
    return path


@pytest.mark.parametrize("sound", [{}, {"oaspl_db": 145, "pressure_reference": "room"}])
def test_flat_bands_give_the_answer_of_their_levels(flat, sound):
    of_bands, of_psd = model(BANDS, flat.parent, **sound), model(flat, flat.parent, **sound)
    one, other = (found.response()["acceleration_psd"] for found in (of_bands, of_psd))
    np.testing.assert_array_equal(one["frequency"], other["frequency"])
    np.testing.assert_allclose(one, other, rtol=1e-9)
    rms = [found.summary()["acceleration_rms_g"] for found in (of_bands, of_psd)]
    np.testing.assert_allclose(*rms, rtol=1e-9)


def test_the_bands_of_a_flat_psd_are_its_levels(flat):
    bands, again = read_spectrum(BANDS), read_spectrum(flat)
    np.testing.assert_array_equal(again.bands().band_number, bands.band_number)
    np.testing.assert_allclose(again.bands().band_spl, bands.band_spl, atol=1e-9)
    assert again.oaspl == pytest.approx(bands.oaspl, abs=1e-9)
    assert again.reach == pytest.approx(bands.reach) and again.source == "flat"
    tables = [model(path, flat.parent).sound().to_dataframe() for path in (BANDS, flat)]
    pd.testing.assert_frame_equal(*tables, rtol=1e-6)


@pytest.mark.parametrize("ends", [(50, 2000), (60, 150), (150, 300), (900, 1000), (200, 800)])
def test_the_mean_square_is_the_integral(ends):
    inner = [f for f in (200.0, 800.0) if ends[0] < f < ends[1]]
    true = quad(lambda f: float(POINTS(np.array([f]))[0]), *ends, points=inner, epsrel=1e-10)[0]
    assert POINTS.mean_square(*ends) == pytest.approx(true, rel=1e-7)
    spectrum = Spectrum(POINTS)
    assert spectrum.shifted(3.0).points.mean_square(*ends) == pytest.approx(
        true * 10**0.3, rel=1e-7
    )
    overall = 10 * np.log10(POINTS.mean_square(50, 2000) / 4e-10)
    assert spectrum.oaspl == pytest.approx(overall)


def test_nothing_is_extrapolated():
    with pytest.raises(SpectrumError, match="the rows reach from 50 to 2000 Hz"):
        pressure_psd(Spectrum(POINTS), [49.0])
    at_step = pressure_psd(Spectrum(POINTS), [np.nextafter(200, 0), 200.0, 2000.0])
    np.testing.assert_allclose(at_step, [8.0, 4.0, 0.01])


def written(path, *rows):
    path.write_text("frequency_hz,psd_pa2_hz\n" + "\n".join(rows) + "\n")
    return path


def test_small_values_and_up_to_two_hundred_decibels_in_a_hertz_are_read(tmp_path):
    rows = read_spectrum(written(tmp_path / "psd.csv", "0.5,0.25", "0.75,4e10", "0.75,3", "9,5"))
    assert rows.points.frequency.tolist() == [0.5, 0.75, 0.75, 9.0]
    assert rows.points.psd.tolist() == [0.25, 4e10, 3.0, 5.0]


@pytest.mark.parametrize(
    ("rows", "lines"),
    [
        (("0,1", "50,1"), [2]),
        (("20,0", "50,4.2e10"), [2, 3]),
        (("20,1", "50,1", "40,1", "30,1", "90,1"), [4, 5]),
        (("20,1", "20,2", "50,1", "90,1"), [3]),
        (("20,1", "50,1", "90,1", "90,2"), [5]),
        (("20,1", "50,1", "50,2", "50,3", "90,1"), [4]),
    ],
)
def test_each_row_that_is_wrong_is_named_by_its_line(tmp_path, rows, lines):
    # values of none or beyond 200 dB; frequencies that fall; steps at an end or of three rows
    with pytest.raises(ColumnsError) as error:
        read_spectrum(written(tmp_path / "psd.csv", *rows))
    named = [int(fault.partition("line ")[2].partition(":")[0]) for fault in error.value.faults]
    assert named == lines
