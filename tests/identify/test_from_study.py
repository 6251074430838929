"""From the file of a measurement to the identified particles, as tables, a page and a study."""

import contextlib
import functools
import io

import numpy as np
import pandas as pd
import pytest
import yaml

from pidpanel.cli import main
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.identify import next_tones, posterior
from pidpanel.identify.from_study import identify_file, measured_table, read_measurement
from pidpanel.identify.prediction import Tones
from pidpanel.report.identify_page import answer_of
from pidpanel.study import StudyError, load_study

STUDY = """title: Damper 12
coupon:
  cell: {across_flats_mm: 6.35, depth_mm: 25}
  particles: {diameter_mm: 2, density_kg_m3: 1190}
"""
ROWS = "frequency_hz,acceleration_g,equivalent_damping_n_s_m3,apparent_mass_kg_m2\n"
# of the table of the atlas: e = 0.8, μ = 0.3, r = 0.5
TABLE = (
    ROWS + "30,20,1478.7,4.4555\n80,4,1577.7,0.4763\n80,20,413.3,-0.1645\n250,20,1374.2,-0.1275\n"
)
MEASURED = "fill_fraction: 0.5\nmeasured: {file: tones.csv, relative_error: 0.03}\n"


def write_measurement(folder, rest=MEASURED, table=TABLE):
    """Write the file of a measurement."""
    (folder / "tones.csv").write_text(table)
    (folder / "lab.yaml").write_text(STUDY + rest)
    return folder / "lab.yaml"


@pytest.fixture(scope="module", autouse=True)
def grids():
    """Fewer points and samples, on which no answer here depends (test_posterior)."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(posterior, "COARSE", (10, 6, 5))
        patch.setattr(posterior, "FINE", (13, 9, 7))
        patch.setattr(next_tones, "SAMPLES", 40)
        yield


@pytest.fixture
def laboratory(tmp_path):
    """(rest of the file, table) → the file of a measurement."""
    return functools.partial(write_measurement, tmp_path)


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Folder of the results of the command, and the lines that it prints."""
    folder, printed = tmp_path_factory.mktemp("identified"), io.StringIO()
    file = write_measurement(folder)
    with contextlib.redirect_stdout(printed):
        assert main(["identify", str(file), "-d", str(folder)]) == 0
    return folder / "results" / "lab" / "identify", printed.getvalue().splitlines()


def test_the_command_prints_and_writes_the_particles(identified):
    folder, lines = identified
    assert [line[:4] for line in lines[:3]] == ["e = ", "μ = ", "r = "]
    *_, further, page, damper = lines
    assert further.startswith("A further tone at ") and page.endswith("report.html")
    assert damper.endswith("identified.yaml")
    summary = pd.read_csv(folder / "summary.csv").set_index("parameter")
    for name, true in (("restitution", 0.8), ("friction", 0.3), ("fill_fraction", 0.5)):
        row = summary.loc[name]
        assert row["low_90"] < true < row["high_90"]
        assert row["low_90"] < row["value"] < row["high_90"]
    table = pd.read_csv(folder / "posterior.csv")
    assert table["probability"].sum() == pytest.approx(1, abs=1e-4)
    mean = (table["probability"] * table["restitution"]).sum()
    assert mean == pytest.approx(summary.loc["restitution", "value"], abs=1e-4)
    assert summary["determined"].all()
    further = pd.read_csv(folder / "next_tests.csv")
    assert further["information_nat"].is_monotonic_decreasing
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Damper 12" in page and "Further tests" in page
    assert f"{', '.join(lines[:3])}. {lines[3]}" in page


def test_a_measurement_that_nothing_explains_is_to_be_checked(laboratory, tmp_path, capsys):
    rows = [row.split(",") for row in TABLE.splitlines()[1:]]
    table = ROWS + "".join(f"{f},{gamma},{float(c) * 30:g},{m}\n" for f, gamma, c, m in rows)
    assert main(["identify", str(laboratory(table=table)), "-d", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("No particles of the atlas explain the measurement")
    assert lines[0].endswith("for 8 values (probability of a larger one below 0.1 %).")
    assert lines[-3].startswith("Check units, cell, particles and fill")


def test_an_apparent_mass_far_above_that_of_the_particles_is_refused(laboratory):
    message = "an apparent mass of 44. kg/m².*times the mass of the particles.* in g/m²"
    with pytest.raises(StudyError, match=message):
        identify_file(laboratory(table=TABLE.replace("4.4555", "445.55")))


def test_particles_that_weigh_less_than_stated_are_refused(laboratory):
    # 2 mm of 1190 kg/m³ weigh 4.98 mg; with 30 % of 1.4 mm the mean is 4.0 mg
    message = "particle_mass_mg = 4: contradicts .* 4.98 mg each, .*10%; another size, or two"
    with pytest.raises(StudyError, match=message):
        identify_file(laboratory("particle_mass_mg: 4\n" + MEASURED))
    lines = answer_of(identify_file(laboratory("particle_mass_mg: 4.9\n" + MEASURED)))
    assert not any("size of the particles was not checked" in line for line in lines)
    lines = answer_of(identify_file(laboratory()))
    assert any("size of the particles was not checked" in line for line in lines)


def test_gravity_that_is_stated_wrongly_is_named(laboratory):
    file = laboratory()
    text = "  gravity_direction: [1, 0, 0]\n"
    file.write_text(file.read_text().replace("coupon:\n", f"coupon:\n{text}"))
    lines = " ".join(answer_of(identify_file(file)))
    assert "Caution: gravity along the motion explains the measurement" in lines


def test_the_identified_particles_are_a_damper_of_a_study(identified, tmp_path):
    folder, _ = identified
    snippet = (folder / "identified.yaml").read_text()
    panel = {
        "outline_m": [0.8, 0.5],
        "section": {"kind": "thin", "mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 800},
        "damping_ratio": 0.01,
        "patches": {"middle": {"centre_m": [0.4, 0.25], "size_m": [0.2, 0.2]}},
        "points": {"P": [0.4, 0.25]},
    }
    values = {
        **yaml.safe_load(snippet), "panel": panel,
        "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
        "scenarios": {"full": {"layout": {"middle": {"damper": "lab", "fill_fraction": 0.5}}}},
    }  # fmt: skip
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(values))
    study = load_study(tmp_path / "study.yaml")
    summary = pd.read_csv(folder / "summary.csv").set_index("parameter")
    particles = study.dampers["lab"].particles
    assert particles.restitution == pytest.approx(summary.loc["restitution", "value"], abs=5e-4)
    assert particles.friction == pytest.approx(summary.loc["friction", "value"], rel=5e-3)
    assert study.dampers["lab"].cell.depth_mm == 25


def test_tones_that_all_lie_outside_the_atlas_are_refused(laboratory):
    fast = ROWS + "15000,2,1478.7,4.4555\n18000,2,413.3,-0.1645\n"
    with pytest.raises(StudyError, match=r"measured.file = .*: no tone lies in the atlas.*in Hz"):
        identify_file(laboratory(table=fast))


def test_frequencies_in_kilohertz_are_refused(laboratory):
    # W/L of a tone of 0.5 g lies in the atlas
    kilohertz = ROWS + "0.08,20,413.3,-0.1645\n2,1.6,413.3,-0.1645\n"
    with pytest.raises(StudyError, match=r"at most 2 Hz, below those of the shaker.*; in kHz"):
        read_measurement(laboratory(table=kilohertz), read_atlas())


@pytest.mark.parametrize("key", ["record: 1", "area_mm2: 2000", "fixture_mass_kg: 0.4"])
def test_keys_of_universal_files_are_refused_with_a_table(laboratory, key):
    rest = MEASURED.replace("}", f", {key}}}")
    with pytest.raises(StudyError, match=f"{key[:6]}.*only allowed with a universal file"):
        read_measurement(laboratory(rest), read_atlas())


def test_differences_are_those_of_the_table(laboratory):
    result = identify_file(laboratory())
    rows = result.predictions
    assert len(rows) == 4 and rows["inside"].all() and result.outside == 0
    away = np.log(
        rows["measured_equivalent_damping_n_s_m3"] / rows["atlas_equivalent_damping_n_s_m3"]
    )
    relative = (
        rows["atlas_equivalent_damping_error_n_s_m3"] / rows["atlas_equivalent_damping_n_s_m3"]
    )
    score = away / np.hypot(relative, 0.03)
    np.testing.assert_allclose(rows["damping_difference_over_error"], score, rtol=1e-6)
    # W/L of 20 g at 80 Hz in a half full cell of 25 mm: W = 0.776 mm, L = 25 mm (1 − 0.94 r)
    assert rows["stroke_per_gap"][2] == pytest.approx(0.776 / (25 * (1 - 0.94 * 0.5)), rel=0.03)


def test_columns_become_damping_and_mass_per_area():
    f = np.array([100.0, 200.0])
    omega = 2 * np.pi * f
    tones = Tones(f, np.full(2, 5.0), np.zeros(2, bool))
    loss = measured_table(
        {"frequency_hz": f, "loss_factor": np.array([0.2, 0.4]), "loss_factor_error": f * 1e-4,
         "particle_mass_per_area_kg_m2": np.full(2, 10.0)}, tones, 0.05, 10.0,
    )  # fmt: skip
    np.testing.assert_allclose(loss.damping, [2 * omega[0], 4 * omega[1]])
    np.testing.assert_allclose(loss.damping_error, 1e-3 * f * omega)
    assert np.isnan(loss.mass).all()
    complex_one = measured_table(
        {"frequency_hz": f, "impedance_real_n_s_m3": np.array([-1.0, 300.0]),
         "impedance_imag_n_s_m3": 3 * omega}, tones, 0.05, 10.0,
    )  # fmt: skip
    assert np.isnan(complex_one.damping[0]) and complex_one.damping_error[1] == 15.0
    np.testing.assert_allclose(complex_one.mass, 3.0)
    np.testing.assert_allclose(complex_one.mass_error, 0.5)


def test_a_weak_damper_counts_and_one_without_damping_does_not():
    tones = Tones(np.full(2, 80.0), np.full(2, 5.0), np.zeros(2, bool))
    columns = {"frequency_hz": tones.frequency, "equivalent_damping_n_s_m3": np.array([0.5, 0.0])}
    np.testing.assert_array_equal(measured_table(columns, tones, 0.1, 1.0).damping, [0.5, np.nan])


def test_a_random_test_has_the_tone_of_its_rms_acceleration(laboratory):
    random = "measured: {file: tones.csv, relative_error: 0.1, acceleration_rms_g: 10}\n"
    plain = "frequency_hz,equivalent_damping_n_s_m3\n80,413\n"
    _, specimen, measured = read_measurement(laboratory(random, plain), read_atlas())
    assert measured.tones.acceleration_g[0] == pytest.approx(14.142, rel=1e-3)
    assert measured.tones.is_broadband.all() and specimen.particle_mass is None


def test_a_random_test_by_its_spectrum_says_so(laboratory, tmp_path):
    spectrum = "frequency_hz,acceleration_psd_g2_hz\n20,0.05\n2000,0.05\n"
    (tmp_path / "psd.csv").write_text(spectrum)
    rest = "measured: {file: tones.csv, relative_error: 0.1, spectrum: psd.csv}\n"
    plain = "frequency_hz,equivalent_damping_n_s_m3\n80,413\n"
    _, _, measured = read_measurement(laboratory(rest, plain), read_atlas())
    assert measured.tones.acceleration_g[0] == pytest.approx(np.sqrt(2 * 0.05 * 1980), rel=1e-6)


def test_rows_in_which_the_particles_ride_along_do_not_count(laboratory):
    _, _, measured = read_measurement(laboratory(table=TABLE + "100,0.8,20,6\n"), read_atlas())
    assert len(measured.damping) == 4
    with pytest.raises(StudyError, match="an acceleration above 1 g"):
        read_measurement(laboratory(table=ROWS + "100,0.8,20,6\n"), read_atlas())


@pytest.mark.parametrize(
    ("rest", "table", "message"),
    [
        (MEASURED, "fill_fraction," + ROWS + "0.5,30,20,1479,4\n", "use the key fill_fraction"),
        (MEASURED, ROWS + "\n".join(f"{f},20,1479,4" for f in range(10, 90)), "has 80 rows; allowed are 60"),
        ("measured: {file: tones.csv, relative_error: 0.1}\n", "frequency_hz,loss_factor\n80,0.2\n", "particle_mass_per_area_kg_m2: missing"),
        ("measured: {file: tones.csv, relative_error: 0.1}\n", "frequency_hz,equivalent_damping_n_s_m3\n80,20\n", "measured.acceleration_g: missing; needed"),
        ("measured: {file: tones.csv}\n", ROWS + "80,20,413,5\n", "measured.relative_error: missing; needed"),
    ],
)  # fmt: skip
def test_tables_that_do_not_suffice_are_refused(laboratory, rest, table, message):
    with pytest.raises(StudyError, match=message):
        read_measurement(laboratory(rest, table), read_atlas())


def test_particles_that_were_weighed_state_their_fill(laboratory):
    weighed = (
        "particle_mass_per_area_kg_m2: 7.145\nmeasured: {file: tones.csv, relative_error: 0.03}\n"
    )
    found = identify_file(laboratory(weighed)).posterior
    assert found.mean[2] == pytest.approx(0.5, abs=0.03)
    assert found.estimate(2).error < 0.03


def test_force_over_acceleration_is_a_measurement(laboratory, force_file):
    f = np.arange(20.0, 500.0, 2.0)
    force_file(0.4 + 2e-3 * (5.0 - 800j / (2 * np.pi * f)), f)
    test = "fill_fraction: 0.5\nmeasured: {file: frf.uff, acceleration_g: 5, area_mm2: 2000, fixture_mass_kg: 0.4"
    _, _, measured = read_measurement(laboratory(f"{test}, relative_error: 0.05}}\n"), read_atlas())
    np.testing.assert_allclose(measured.damping, 800, rtol=1e-5)
    np.testing.assert_allclose(measured.damping_error, 40, rtol=1e-3)
    np.testing.assert_allclose(measured.mass, 5, rtol=1e-5)
    assert (measured.tones.acceleration_g == 5).all()
    for left, key in ((", area_mm2: 2000", "area_mm2"), (", acceleration_g: 5", "acceleration_g")):
        with pytest.raises(StudyError, match=f"measured.{key}: missing"):
            read_measurement(
                laboratory(test.replace(left, "") + ", relative_error: 0.05}\n"), read_atlas()
            )
