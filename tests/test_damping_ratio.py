"""The damping ratio of the panel over frequency and mode by mode, against Navier's closed form."""

import numpy as np
import pytest

import pidpanel
from pidpanel.columns import ColumnsError
from pidpanel.damping_ratio import DampingRatio, read_damping_ratio
from pidpanel.paths import DATA
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.table import read_spectrum

SIZE, D, MASS, AT = (1.5, 1.0), 3273.07, 4.0, (0.55, 0.35)
SPECTRUM = DATA / "spl" / "smc_s_016_2014_min_third.csv"
TABLE = [[50.0, 0.04], [200.0, 0.01]]


def model(ratio, folder=None):
    return pidpanel.Model({
        "panel": {
            "outline_m": list(SIZE), "damping_ratio": ratio,
            "section": {"mass_per_area_kg_m2": MASS, "bending_stiffness_n_m": D},
            "mesh": {"kind": "quadrilaterals", "elements": [30, 20]},
            "patches": {"p": {"centre_m": [0.75, 0.5], "size_m": [0.3, 0.2]}},
            "points": {"A": list(AT)},
        },
        "sound": {"spectrum": SPECTRUM.name, "field": "uniform"},
        "response": {"frequency_hz": [40, 400]},
        "dampers": {"d": {"equivalent_damping_n_s_m3": 300, "apparent_mass_kg_m2": 1}},
        "scenarios": {"s": {"layout": {"p": {"damper": "d"}}}},
    }, folder)  # fmt: skip


@pytest.fixture(scope="module")
def with_table():
    """The panel whose damping ratio is a table."""
    return model(TABLE)


def psd_of(found, scenario="bare"):
    return found.response()["acceleration_psd"].sel(scenario=scenario, point="A").squeeze()


def navier(frequency, ratio):
    """(nf,) PSD of the acceleration per PSD of a pressure all over a simply supported plate."""
    m, n = (odd.ravel() for odd in np.meshgrid(np.arange(1, 60, 2), np.arange(1, 60, 2)))
    kx, ky = m * np.pi / SIZE[0], n * np.pi / SIZE[1]
    natural = (kx**2 + ky**2) * np.sqrt(D / MASS)
    load = 4 / (kx * ky)  # ∫ sin sin dA of odd half waves
    shape = np.sin(kx * AT[0]) * np.sin(ky * AT[1])
    modal_mass = MASS * SIZE[0] * SIZE[1] / 4
    omega = 2 * np.pi * frequency[:, None]
    zeta = ratio(natural / (2 * np.pi))
    H = shape * load / modal_mass / (natural**2 - omega**2 + 2j * zeta * natural * omega)
    return np.abs(H.sum(axis=1)) ** 2 * omega[:, 0] ** 4


def test_a_table_over_frequency_is_that_of_the_closed_form(with_table):
    psd, sharper = psd_of(with_table), psd_of(model(0.01))
    f = psd["frequency"].to_numpy()
    pressure = pressure_psd(read_spectrum(SPECTRUM), f)

    def ratio(natural):
        return np.interp(np.log(natural), np.log([50.0, 200.0]), [0.04, 0.01])

    # 0.2 %: modes above twice the range respond statically in residual vectors of the patch alone
    np.testing.assert_allclose(psd, navier(f, ratio) * pressure, rtol=2e-3)
    # the first mode, 65 Hz, has 0.034 in place of 0.01
    assert psd[np.argmin(np.abs(f - 64.9))] < 0.11 * sharper.max()


def test_a_list_by_mode_is_the_table_at_the_frequencies_of_the_modes(with_table, tmp_path):
    natural = with_table.modes()["natural_frequency"].to_numpy()
    table_ratio = DampingRatio(*zip(*[(z, f) for f, z in TABLE], strict=True)).of_modes(natural)
    by_mode = model([float(z) for z in table_ratio])
    for scenario in ("bare", "s"):
        one, other = (psd_of(found, scenario) for found in (with_table, by_mode))
        np.testing.assert_allclose(one, other, rtol=1e-6)
    assert by_mode.summary()["basis_error"].max() < 0.005
    (tmp_path / "zeta.csv").write_text("frequency_hz,damping_ratio\n50,0.04\n200,0.01\n")
    from_file = model("zeta.csv", tmp_path)
    np.testing.assert_array_equal(psd_of(from_file, "s"), psd_of(with_table, "s"))


def test_the_smallest_ratio_of_a_range_is_that_of_its_modes():
    falling = DampingRatio((0.04, 0.01, 0.03), (50.0, 200.0, 800.0))
    assert falling.smallest(20.0, 60.0) == pytest.approx(0.04 - 0.03 * np.log(1.2) / np.log(4))
    assert falling.smallest(60.0, 400.0) == 0.01
    assert falling.smallest(800.0, 2000.0) == 0.03
    assert DampingRatio((0.02, 0.01)).smallest(0.0, 10.0) == 0.01


def test_modes_count_from_the_slowest_that_bends_and_ratios_scale():
    ratio = DampingRatio((0.01, 0.02, 0.04))
    found = ratio.times(0.5).of_modes(np.array([0.0, 0.0, 0.2, 0.7, 30.0]))
    np.testing.assert_allclose(found, [0.005, 0.005, 0.005, 0.01, 0.02])


def test_a_file_may_have_values_up_to_one_half_and_close_rows(tmp_path):
    path = tmp_path / "zeta.csv"
    path.write_text("frequency_hz,damping_ratio\n0.5,0.5\n0.75,0.01\n")
    assert read_damping_ratio(path) == DampingRatio((0.5, 0.01), (0.5, 0.75))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("frequency_hz,damping_ratio\n50,0.54\n", r"line 2: damping_ratio = 0\.54: .*in %"),
        ("frequency_hz,damping_ratio\n50,0\n", "line 2: damping_ratio = 0"),
        ("frequency_hz,damping_ratio\n0,0.01\n", "line 2: frequency_hz = 0"),
        ("frequency_hz,damping_ratio\n50,2\n", r"line 2: damping_ratio = 2: .*in %"),
        ("frequency_hz,damping_ratio\n50,0.02\n50,0.01\n", "line 3: frequency_hz = 50 must be"),
        ("frequency_hz,damping_ratio\n50,0.02\n50,0.01\n60,0.01\n", "line 3: frequency_hz = 50"),
        ("frequency_hz,loss\n50,0.02\n", "line 1: column 'loss': unknown"),
        ("frequency_hz\n50\n", "line 1: column damping_ratio: missing"),
        ("frequency_hz,damping_ratio\n", "no rows"),
    ],
)
def test_a_file_that_is_wrong_is_refused_by_its_line(tmp_path, text, message):
    (tmp_path / "zeta.csv").write_text(text)
    with pytest.raises(ColumnsError, match=message):
        read_damping_ratio(tmp_path / "zeta.csv")
    with pytest.raises(pidpanel.StudyError, match=message):
        model("zeta.csv", tmp_path)
