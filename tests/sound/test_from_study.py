"""The sound of a study: its level, its field and its air, through the script of the stage."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature
from pidpanel.panel.files import read_basis
from pidpanel.sound import field, from_study
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, read_table
from pidpanel.sound.free_edges import FreePanel
from pidpanel.sound.from_study import excitation_of, spectrum_of
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.rectangle import RectangleJumps
from pidpanel.sound.wavenumber_table import TRANSITION, FieldError
from pidpanel.study import load_study
from pidpanel.study.sound import Sound
from tests.jobs import make_panel, make_sound
from tests.sound.surfaces import paraboloid, paraboloid_mesh

STUDY = """
dampers: {{paper: {{law: paper_corrected}}}}
panel:
  outline_m: [0.9, 0.6]
  section: {{kind: thin, mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07}}
  mesh: {{elements: [18, 12]}}
  patches: {{P: {{centre_m: [0.4, 0.3], size_m: [0.2, 0.2]}}}}
  points: {{A: [0.4, 0.3]}}
sound: {{spectrum: bands.csv, {sound}}}
response: {{frequency_hz: [30, 250], air_mass: {air_mass}}}
scenarios: {{one: {{title: "One", patch: [P], fill_fraction: 0.5}}}}
"""
BANDS = "center_hz,spl_db\n31.5,110\n63,120\n125,130\n250,120\n"
K_MAX = 2 * np.pi * 250.0 / 340.0


@pytest.fixture(scope="module")
def basis(tmp_path_factory):
    """The file of a panel's basis; the sound does not change it."""
    folder = tmp_path_factory.mktemp("basis")
    (folder / "bands.csv").write_text(BANDS)
    (folder / "small.yaml").write_text(STUDY.format(sound="field: uniform", air_mass="true"))
    make_panel(folder / "small.yaml", folder)
    return folder / "modes.nc"


@pytest.fixture
def run(tmp_path, basis):
    """Run the script on a study with these keys of ``sound``; the folder of what it wrote."""

    def main(keys, air=False, air_mass="true", highest=250):
        (tmp_path / "bands.csv").write_text(BANDS)
        text = STUDY.format(sound=keys, air_mass=air_mass).replace("[30, 250]", f"[30, {highest}]")
        (tmp_path / "small.yaml").write_text(text)
        make_sound(tmp_path / "small.yaml", tmp_path, modes=basis, air=air)
        return tmp_path

    return main


def face_of(path):
    basis = read_basis(path)
    return PanelQuadrature(
        basis.quadrature_position,
        basis.quadrature_weight,
        basis.shape_at_quadrature,
        basis.quadrature_wavenumber,
        basis.face_overlap,
    )


@pytest.mark.parametrize(
    ("keys", "oaspl"),
    [
        ({}, 10 * np.log10(1e11 + 2e12 + 1e13)),
        ({"shift_db": 3.0}, 3 + 10 * np.log10(1e11 + 2e12 + 1e13)),
        ({"oaspl_db": 145.0}, 145.0),
    ],
)
def test_spectrum_is_the_tables_shifted_or_at_the_stated_level(tmp_path, keys, oaspl):
    (tmp_path / "bands.csv").write_text(BANDS)
    spectrum = spectrum_of(Sound(spectrum=tmp_path / "bands.csv", **keys))
    assert spectrum.oaspl == pytest.approx(oaspl, abs=1e-12)
    assert spectrum.band_spl[2] - spectrum.band_spl[0] == pytest.approx(20.0, abs=1e-12)


def test_bands_hold_the_pressure_on_the_face(run):
    folder = run("field: uniform, oaspl_db: 150, loaded_sides: 2, pressure_reference: room")
    bands = pd.read_csv(folder / "spectrum.csv")
    width = bands["upper_hz"] - bands["lower_hz"]
    mean_square = (bands["surface_pressure_psd_pa2_hz"] * width).sum()
    # two sides, doubled at a rigid face; seven figures are written
    assert mean_square == pytest.approx(2 * 2 * (20e-6) ** 2 * 1e15, rel=1e-6)
    octave = 10**0.3
    np.testing.assert_allclose(bands["upper_hz"] / bands["lower_hz"], octave, rtol=1e-6)
    np.testing.assert_allclose(bands["center_hz"], [31.6228, 63.0957, 125.893, 251.189], rtol=1e-5)


FIELDS = {
    "field: diffuse": lambda k, face, _: field.diffuse_modal_force(k, face),
    "field: uniform": lambda k, face, _: field.uniform_modal_force(face),
    "field: uncorrelated": lambda k, _, basis: field.uncorrelated_modal_force(
        field.lumped_area(basis.vertex_position, basis.cells), basis.shape_at_vertices
    ),
    "field: plane_wave, incidence_deg: 30, azimuth_deg: 20": lambda k, face, _: (
        field.plane_wave_modal_force([k], PlaneWaves.lone(np.radians(30), np.radians(20)), face)[0]
    ),
    "field: progressive_wave, azimuth_deg: 20": lambda k, face, _: field.plane_wave_modal_force(
        [k], PlaneWaves.lone(np.pi / 2, np.radians(20)), face
    )[0],
}


@pytest.mark.parametrize("keys", FIELDS)
def test_modal_force_is_that_of_the_field_up_to_the_highest_frequency(run, basis, keys):
    folder = run(f"{keys}, speed_m_s: 340")
    table = read_table(folder / "modal_force.nc", MODAL_FORCE)
    for k in (0.4 * K_MAX, K_MAX):
        expected = FIELDS[keys](k, face_of(basis), read_basis(basis))
        # the tables are held to 1e-9 of the largest value, `field.TABLE_TOLERANCE`
        np.testing.assert_allclose(
            table.matrix([k])[0], expected, atol=1e-9 * np.abs(expected).max()
        )
    with pytest.raises(FieldError, match="the table reaches to"):
        table.matrix([1.001 * K_MAX])
    with xr.open_dataset(folder / "modal_force.nc", engine="scipy") as dataset:
        assert dataset.attrs["field"] == keys.split(",")[0].removeprefix("field: ")
        assert dataset.attrs["study"] == "small"


@pytest.mark.parametrize("keys", ["field: diffuse", "field: uniform"])
def test_air_answers_as_to_a_diffuse_field_whatever_drives_the_panel(run, basis, keys):
    # the diffuse field that drives the panel is not written twice
    folder = run(f"{keys}, speed_m_s: 340", air=True)
    face, k = face_of(basis), 0.7 * K_MAX
    expected = field.diffuse_modal_force(k, face)
    name = ("modal_force.nc", MODAL_FORCE) if "diffuse" in keys else ("air.nc", DIFFUSE)
    diffuse = read_table(folder / name[0], name[1]).matrix([k])[0]
    np.testing.assert_allclose(diffuse, expected, atol=1e-9 * np.abs(expected).max())
    added = read_table(folder / "air.nc", ADDED_VOLUME)
    np.testing.assert_array_equal(added.matrix([k]), tabulate_added_mass(K_MAX, face).matrix([k]))


def test_no_mass_of_the_air_is_tabulated_where_it_does_not_count(run):
    folder = run("field: uniform, speed_m_s: 340", air=True, air_mass="false")
    read_table(folder / "air.nc", DIFFUSE)
    with pytest.raises(KeyError):
        read_table(folder / "air.nc", ADDED_VOLUME)


def test_sound_beyond_the_waves_that_the_face_serves_is_refused(run):
    # the panel was condensed for twice the waves of its modes, 18 rad/m of bending at 500 Hz and
    # about one half more by Weyl's law with so few of them; 500 Hz at 100 m/s ask for twice 31.4
    with pytest.raises(FieldError, match=r"shapes are known to .* rad/m, 62.8319 are needed"):
        run("field: diffuse, speed_m_s: 100", highest=500)


FREE = "field: diffuse, surroundings: free, speed_m_s: 340"


def free_panel_of(basis):
    jumps = RectangleJumps.of_box([0, 0], [0.9, 0.6], basis.quadrature_wavenumber / 2)
    panel = FreePanel.of_jumps(jumps, K_MAX)
    return panel, jumps.couplings(PanelQuadrature.from_face(basis))


def test_a_panel_with_free_edges_has_the_load_and_the_air_of_one_matrix(run, basis):
    folder, k = run(FREE, air=True), 0.7 * K_MAX
    panel, couplings = free_panel_of(read_basis(basis))
    expected = panel.impedance(k, couplings)
    force = read_table(folder / "modal_force.nc", MODAL_FORCE).matrix([k])[0]
    volume = read_table(folder / "air.nc", ADDED_VOLUME).matrix([k])[0]
    largest = np.abs(expected).max()
    np.testing.assert_allclose(force, np.pi / k * expected.imag, atol=1e-3 * largest)
    np.testing.assert_allclose(volume, expected.real / 2, atol=1e-3 * largest)
    # four times G is the load per PSD of the room, twice V its mass
    sound = Sound(spectrum=folder / "bands.csv", surroundings="free")
    excitation = excitation_of(sound, None)
    room = spectrum_of(sound).points(np.array([100.0]))
    np.testing.assert_allclose(excitation.spectrum(np.array([100.0])), 4 * room)


def test_above_the_wavenumber_that_functions_resolve_both_faces_are_independent(
    run, basis, monkeypatch
):
    monkeypatch.setattr("pidpanel.sound.rectangle.MOST_FUNCTIONS", 36)
    from_study.tabulated_panel.cache_clear()
    folder = run(FREE, air=True)
    from_study.tabulated_panel.cache_clear()
    table = read_table(folder / "modal_force.nc", MODAL_FORCE)
    end = table.lower.wavenumber_max
    assert end < K_MAX
    expected = field.diffuse_modal_force(K_MAX, face_of(basis))
    found = table.matrix([K_MAX])[0]
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    k = np.array([0.5, TRANSITION, 0.9, 1.0]) * end
    lower, upper, joined = (part.matrix(k) for part in (table.lower, table.upper, table))
    np.testing.assert_array_equal(joined[:2], lower[:2])
    np.testing.assert_allclose(joined[2], (lower[2] + upper[2]) / 2, rtol=1e-9)
    np.testing.assert_allclose(joined[3], upper[3], rtol=1e-12)
    assert table.factors_at([0.9 * end]) is None


def test_the_air_of_a_panel_with_free_edges_is_on_both_faces_or_left_out(tmp_path):
    (tmp_path / "bands.csv").write_text(BANDS)
    text = STUDY.format(sound=FREE, air_mass="true")
    for name, expected in (("", "two_sides"), (", radiation: none", "none")):
        (tmp_path / "a.yaml").write_text(text.replace(", air_mass: true", name))
        assert load_study(tmp_path / "a.yaml").radiation == expected
    baffled = text.replace("surroundings: free, ", "")
    (tmp_path / "a.yaml").write_text(baffled)
    assert load_study(tmp_path / "a.yaml").radiation == "none"


def test_a_curved_surface_has_free_edges_to_the_highest_frequency(tmp_path):
    (tmp_path / "bands.csv").write_text(BANDS)
    text = STUDY.format(sound="surroundings: free", air_mass="true").replace("250]", "200]")
    (tmp_path / "small.yaml").write_text(text)
    study, surface, (vertices, cells) = (
        load_study(tmp_path / "small.yaml"), paraboloid(), paraboloid_mesh()
    )  # fmt: skip
    face = MovedFace(
        surface.position, surface.weight, surface.shape, np.inf, vertices, cells,
        np.ones((len(vertices), 4)), quadrature_normal=surface.normal,
    )  # fmt: skip
    k_max = 2 * np.pi * 200 / 343
    assert from_study.free_panel(study, face).wavenumber_max == k_max
    wavenumber, error = from_study.load_error_of(study, face)
    assert wavenumber.max() < k_max
    assert error.shape == (len(wavenumber), 4)
    assert 1e-4 < error[-1, 0] < 0.05
