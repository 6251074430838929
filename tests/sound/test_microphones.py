"""A field that microphones measured: against fields that are known everywhere."""

import numpy as np
import pandas as pd
import pytest
import pyuff
from scipy.special import roots_legendre

from pidpanel.columns import ColumnsError
from pidpanel.panel.files import read_basis
from pidpanel.sound.field import diffuse_modal_force, plane_wave_modal_force
from pidpanel.sound.field_files import MODAL_FORCE, read_table, write_tables
from pidpanel.sound.free_edges import plane_wave_force, tabulate_diffuse_room
from pidpanel.sound.from_study import excitation_of, modal_force_at, plane_waves
from pidpanel.sound.microphone_files import read_cross_spectra
from pidpanel.sound.microphones import (
    MeasuredTable,
    Microphones,
    tabulate_in_room,
    tabulate_on_wall,
)
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.study import load_study
from tests.jobs import make_panel, make_sound
from tests.sound.panels import SIDES, sines
from tests.sound.test_from_study import BANDS, STUDY

K = 3.7
MODES = [(1, 1), (2, 1), (3, 2)]  # of the fixture `face`
NOISE = 1e-4


def grid(z):
    """Return 24 microphones over the panel [m]."""
    x, y = np.meshgrid(SIDES[0] * (np.arange(6) + 0.5) / 6, SIDES[1] * (np.arange(4) + 0.5) / 4)
    return np.column_stack([x.ravel(), y.ravel(), np.full(24, z)])


def waves_at(waves, position, k, *, before_wall):
    """Return pressures (nw, M) of waves of unit pressure on the wall, or in the room."""
    sine = np.sin(waves.incidence)
    normal = np.cos(waves.incidence)
    direction = np.stack([sine * np.cos(waves.azimuth), sine * np.sin(waves.azimuth), normal], 1)
    if before_wall:
        along = np.exp(-1j * k * direction[:, :2] @ position[:, :2].T)
        return along * np.cos(k * np.outer(normal, position[:, 2]))
    return np.exp(-1j * k * direction @ position.T)


def measured(waves, position, k, *, before_wall, noise=NOISE):
    pressure = np.sqrt(waves.share)[:, None] * waves_at(waves, position, k, before_wall=before_wall)
    spectra = pressure.T @ pressure.conj() + noise * np.eye(len(position))
    lines = np.array([0.5, 1.5]) * k
    return Microphones(position, noise, before_wall, lines, np.array([spectra, spectra]))


FEW = PlaneWaves(np.array([0.3, 0.9, 1.2]), np.array([0.0, 2.0, 4.0]), np.array([0.6, 0.3, 0.1]))
BOTH_SIDES = PlaneWaves(
    np.array([0.3, 2.4, 1.2]), np.array([0.0, 2.0, 4.0]), np.array([0.6, 0.3, 0.1])
)


@pytest.mark.parametrize("z", [0.0, 0.05])
def test_few_waves_on_a_wall_are_found_by_24_microphones(face, z):
    (expected,) = plane_wave_modal_force([K], FEW, face)
    microphones = measured(FEW, grid(z), K, before_wall=True)
    diffuse = diffuse_modal_force(K, face)
    coupling = microphones.on_wall(K, face)
    (force,) = microphones.conditioned(np.array([K]), diffuse[None], coupling[None])
    levels = 10 * np.log10(np.diagonal(force).real / np.diagonal(expected).real)
    off = 10 * np.log10(np.diagonal(diffuse) / np.diagonal(expected).real)
    assert np.abs(levels).max() < 0.05
    assert np.abs(off).max() > 1  # what a diffuse field of that level errs by
    # the imaginary part has the sense of the waves along the panel
    np.testing.assert_allclose(force, expected, atol=0.02 * np.abs(expected).max())


def test_few_waves_in_a_room_are_found_by_microphones_on_both_sides(panel, face):
    couplings = panel.jumps.couplings(face)
    expected = plane_wave_force(panel, K, BOTH_SIDES, couplings)
    position = np.concatenate([grid(0.3), grid(-0.3)])
    microphones = measured(BOTH_SIDES, position, K, before_wall=False)
    diffuse = np.pi / K * panel.impedance(K, couplings).imag
    coupling = microphones.in_room(K, panel, couplings, face.center)
    (force,) = microphones.conditioned(np.array([K]), diffuse[None], coupling[None])
    levels = 10 * np.log10(np.diagonal(force).real / np.diagonal(expected).real)
    assert np.abs(levels).max() < 0.1
    np.testing.assert_allclose(force, expected, atol=0.05 * np.abs(expected).max())


SPEAKERS = np.array([[0.2, 0.1, 0.9], [2.5, 1.0, 1.5], [0.4, -1.5, 2.0], [1.2, 0.8, 3.0]])
ROOM = np.array([6.1, 4.9, 4.2])  # sides [m]; the panel is in its wall z = 0


def images(source, order=3, reflection=0.9):
    """Return images of a point source in a room, and their amplitudes; the wall z = 0 is rigid."""
    number = np.arange(-order, order + 1)
    grid = np.stack(np.meshgrid(number, number, number, indexing="ij"), -1).reshape(-1, 3)
    places, amplitudes = [], []
    for sign in np.stack(np.meshgrid([1, -1], [1, -1], [1, -1]), -1).reshape(-1, 3):
        places.append(2 * grid * ROOM + sign * source)
        counts = np.abs(2 * grid - (sign < 0))
        counts[:, 2] = np.abs(grid[:, 2])  # of these the far wall alone absorbs
        amplitudes.append(reflection ** counts.sum(axis=1))
    return np.concatenate(places), np.concatenate(amplitudes)


def spherical(position, places, amplitudes, k):
    distance = np.linalg.norm(position[:, None] - places, axis=2)
    return np.exp(-1j * k * distance) / distance @ amplitudes


@pytest.mark.parametrize("k", [1.2, K, 7.5])
@pytest.mark.parametrize("is_room", [False, True])
def test_point_sources_on_a_wall_are_found_though_no_wave_is_plane(face, k, is_room):
    """Closed-form spherical waves and a plain quadrature: nothing of this is plane waves."""
    if is_room:
        origin = np.array([2.0, 1.6, 0.0])  # of the panel in the wall
        fields = [images(source + origin) for source in SPEAKERS]
        fields = [(places - origin, amplitudes) for places, amplitudes in fields]
    else:
        mirror = np.array([1, 1, -1])
        fields = [(np.array([source, source * mirror]), np.ones(2)) for source in SPEAKERS]

    (x, along_x), (y, along_y) = (roots_legendre(count) for count in (24, 16))
    x, y = SIDES[0] * (1 + x) / 2, SIDES[1] * (1 + y) / 2
    place = np.stack([*np.meshgrid(x, y, indexing="ij"), np.zeros((24, 16))], -1).reshape(-1, 3)
    area = SIDES[0] * SIDES[1] / 4 * np.outer(along_x, along_y).ravel()
    pressure = np.array([spherical(place, *field, k) for field in fields])
    forces = pressure @ (area[:, None] * sines(place[:, :2], MODES))
    expected = np.sum(np.abs(forces) ** 2, axis=0)
    position = grid(0.0)
    pressure = np.array([spherical(position, *field, k) for field in fields])
    spectra = pressure.T @ pressure.conj()
    level = np.mean(np.diagonal(spectra).real)
    spectra = spectra / level + NOISE * np.eye(24)
    lines = np.array([0.5, 1.5]) * k
    microphones = Microphones(position, NOISE, True, lines, np.array([spectra, spectra]))
    diffuse, coupling = diffuse_modal_force(k, face), microphones.on_wall(k, face)
    (force_found,) = microphones.conditioned(np.array([k]), diffuse[None], coupling[None])
    levels = 10 * np.log10(level * np.diagonal(force_found).real / expected)
    off = 10 * np.log10(level * np.diagonal(diffuse) / expected)
    assert np.abs(levels[expected > 0.05 * expected.max()]).max() < 0.2
    assert np.abs(levels).max() < 0.35  # modes with a hundredth of that load
    assert np.abs(off).max() > 1


@pytest.mark.parametrize("is_level", [True, False])
def test_the_error_of_averages_is_that_of_drawn_cross_spectra(face, is_level):
    averages, draws = 12, 4000
    truth = measured(FEW, grid(0.0), K, before_wall=True, noise=1e-2)
    diffuse = diffuse_modal_force(K, face)[None]
    coupling = truth.on_wall(K, face)[None]
    stated = truth.average_error(np.array([K]), diffuse, coupling, averages, is_level=is_level)[0]
    rng = np.random.default_rng(4)
    shape = draws, averages, 24
    blocks = (rng.normal(size=shape) + 1j * rng.normal(size=shape)) / np.sqrt(2)
    blocks = blocks @ np.linalg.cholesky(truth.spectra[0]).T
    drawn = np.einsum("dam,dan->dmn", blocks, blocks.conj()) / averages
    level = np.mean(np.diagonal(drawn, axis1=1, axis2=2).real, axis=1)
    k = K * (1 + 1e-9 * np.arange(draws))
    found = Microphones(truth.position, truth.noise, True, k, drawn / level[:, None, None])
    force = found.conditioned(k, diffuse.repeat(draws, 0), coupling.repeat(draws, 0))
    loads = np.diagonal(force, axis1=1, axis2=2).real * (level[:, None] if is_level else 1)
    # a standard deviation of 4000 draws errs by 1.2 %, one over a ratio of 12 blocks is of order 1/n
    np.testing.assert_allclose(loads.std(0) / loads.mean(0), stated, rtol=0.05 if is_level else 0.1)


def test_what_a_diffuse_field_has_at_the_microphones_changes_nothing(face):
    microphones = measured(FEW, grid(0.1), K, before_wall=True)
    lines = microphones.wavenumber
    expected = microphones.expected(lines) + NOISE * np.eye(24)
    same = Microphones(microphones.position, NOISE, True, lines, expected.astype(complex))
    diffuse = diffuse_modal_force(lines[0], face)
    coupling = same.on_wall(lines[0], face)
    (force,) = same.conditioned(lines[:1], diffuse[None], coupling[None])
    np.testing.assert_allclose(force, diffuse, atol=1e-12 * diffuse.max())
    share = same.known_share(lines[:1], diffuse[None], coupling[None])
    assert np.all((share > 0.99) & (share < 1.0001))


def test_far_microphones_leave_the_field_diffuse_and_power_positive(face):
    position = grid(0.0) + np.array([40.0, 0.0, 0.0])
    microphones = measured(FEW, position, K, before_wall=True)
    diffuse = diffuse_modal_force(K, face)
    coupling = microphones.on_wall(K, face)
    (force,) = microphones.conditioned(np.array([K]), diffuse[None], coupling[None])
    np.testing.assert_allclose(np.diagonal(force).real, np.diagonal(diffuse), rtol=0.05)
    assert np.linalg.eigvalsh(force)[0] > -1e-12 * np.abs(force).max()


def test_tables_are_the_coupling_between_their_nodes_and_survive_a_file(tmp_path, panel, face):
    wall = measured(FEW, grid(0.05), K, before_wall=True)
    room = measured(BOTH_SIDES, grid(0.3), K, before_wall=False)
    on_wall, in_room = tabulate_on_wall(8.0, face, wall), tabulate_in_room(panel, face, room)
    couplings = panel.jumps.couplings(face)
    for k in (0.3, K, 7.9):
        direct = wall.on_wall(k, face)
        np.testing.assert_allclose(on_wall.matrix([k])[0], direct, atol=1e-9 * abs(direct).max())
        direct = room.in_room(k, panel, couplings, face.center)
        np.testing.assert_allclose(in_room.matrix([k])[0], direct, atol=1e-3 * abs(direct).max())
    table = MeasuredTable(tabulate_diffuse_room(panel, face)[0], in_room, room)
    write_tables(tmp_path / "force.nc", {MODAL_FORCE: table}, {})
    again = read_table(tmp_path / "force.nc", MODAL_FORCE)
    np.testing.assert_array_equal(again.matrix([2.0, K]), table.matrix([2.0, K]))


POSITIONS = "microphone,x_m,y_m,z_m\n1,0.1,0.1,0\n2,0.5,0.1,0\n"
LINES = [(f, 1, 1, 2.0, 0), (f, 2, 2, 3.0, 0), (f, 1, 2, 1.0, 0.5)] if (f := 100.0) else []
LINES = [*LINES, *[(200.0, *row[1:]) for row in LINES]]
COLUMNS = ["frequency_hz", "microphone", "other", "real_pa2_hz", "imaginary_pa2_hz"]


def read(tmp_path, rows, positions=POSITIONS):
    pd.DataFrame(rows, columns=COLUMNS).to_csv(tmp_path / "cross.csv", index=False)
    (tmp_path / "mics.csv").write_text(positions)
    return read_cross_spectra(tmp_path / "cross.csv", tmp_path / "mics.csv")


def test_a_table_gives_hermitian_matrices(tmp_path):
    found = read(tmp_path, LINES)
    np.testing.assert_array_equal(found.frequency, [100, 200])
    np.testing.assert_array_equal(found.spectra[0], [[2, 1 + 0.5j], [1 - 0.5j, 3]])
    rounded = [(float(np.float32(f)) + 1e-6 * (m != n), m, n, *z) for f, m, n, *z in LINES[::-1]]
    silent = [(0.0, 1, 1, 9.0, 0.0)]
    np.testing.assert_array_equal(read(tmp_path, silent + rounded).spectra, found.spectra)
    both_ways = [*LINES, (100.0, 2, 1, 1.0, -0.5)]
    np.testing.assert_array_equal(read(tmp_path, both_ways).spectra, found.spectra)


@pytest.mark.parametrize(
    ("rows", "positions", "message"),
    [
        (LINES[:-1], POSITIONS, "200 Hz, microphones 1 and 2: is missing"),
        ([*LINES, (100.0, 1, 2, 9.0, 0.5)], POSITIONS, "given twice, with other values"),
        ([*LINES[:1], (100.0, 2, 2, -3.0, 0), *LINES[2:]], POSITIONS, "must be real and above 0"),
        ([*LINES[:2], (100.0, 1, 2, 7.0, 0.5), *LINES[3:]], POSITIONS, "negative power"),
        ([(100.0, 3, 3, 1.0, 0), *LINES], POSITIONS, "microphone 3 is not in mics.csv"),
        (LINES[:3], POSITIONS, "at least two frequencies"),
        (LINES, POSITIONS + "2,0.7,0.1,0\n", "microphone = 2 is given twice"),
        (LINES, "microphone,x_m,y_m\n1,0,0\n", "column z_m: missing"),
        (LINES, "x_m,y_m,z_m\n0.1,0.1,0\n", "column microphone: missing"),
        (LINES, POSITIONS.replace("0.5,", "0.1,"), "microphones 1 and 2 are at one place"),
        (LINES, POSITIONS.replace("0.5,", "500,"), "x_m = 500: must be from -100 to 100"),
        ([*LINES, (100.0, 2, 1, 1.0, 0.5)], POSITIONS, "the other half must be conjugate"),
        ([(100.0, 1.4, 1, 2.0, 0), *LINES[1:]], POSITIONS, "microphone = 1.4: must be a whole"),
        ([*LINES, (-100.0, 1, 1, 2.0, 0)], POSITIONS, "frequency_hz = -100.0: must be at least 0"),
        (
            [(f * low, *pair, 100 + r, 0) for low in (1, 5) for f, *pair, r, _ in LINES],
            POSITIONS,
            "all are 101 to 103, as levels in dB are",
        ),
        (
            [(f, m, n, np.hypot(r, i), np.degrees(np.arctan2(i, r))) for f, m, n, r, i in LINES],
            POSITIONS,
            "negative power",  # magnitude and degrees
        ),
    ],
)
def test_cross_spectra_that_are_refused(tmp_path, rows, positions, message):
    with pytest.raises(ColumnsError, match=message):
        read(tmp_path, rows, positions)


def study_text(field, surroundings):
    return STUDY.format(sound=f"surroundings: {surroundings}, field: {field}", air_mass="true")


MEASURED = "{cross_spectra: cross.csv, microphones: mics.csv}"
ANGLES = "{incidence_deg: 20}, {incidence_deg: 65, azimuth_deg: 130, level_db: -3}"


@pytest.mark.parametrize("surroundings", ["baffle", "free"])
def test_a_study_of_measured_sources_has_their_modal_force(tmp_path, surroundings):
    """The same through the files: 40 microphones among two sources, and the sources themselves."""
    (tmp_path / "bands.csv").write_text(BANDS)
    (tmp_path / "sources.yaml").write_text(study_text(f"{{sources: [{ANGLES}]}}", surroundings))
    measured = study_text(MEASURED, surroundings).replace("spectrum: bands.csv, ", "")
    (tmp_path / "measured.yaml").write_text(measured)
    waves = plane_waves(load_study(tmp_path / "sources.yaml").acoustics)
    x, y = np.meshgrid(np.linspace(0, 0.9, 5), np.linspace(0, 0.6, 4))
    heights = (0.02, 0.02) if surroundings == "baffle" else (0.2, -0.2)
    shifted = [np.column_stack([x.ravel() + 0.01 * n, y.ravel(), np.full(20, z)])
               for n, z in enumerate(heights)]  # fmt: skip
    position = np.concatenate(shifted)
    write_microphones(tmp_path, waves, position, before_wall=surroundings == "baffle")
    forces = {}
    make_panel(tmp_path / "sources.yaml", tmp_path)
    for name in ("sources", "measured"):
        study = load_study(tmp_path / f"{name}.yaml")
        make_sound(tmp_path / f"{name}.yaml", tmp_path, modes=tmp_path / "modes.nc")
        table = read_table(tmp_path / "modal_force.nc", MODAL_FORCE)
        excitation = excitation_of(study.acoustics, table)
        lines = np.array([80.0, 200.0])
        forces[name] = excitation(lines)
        direct = modal_force_at(study, 200.0, read_basis(tmp_path / "modes.nc"))
        np.testing.assert_allclose(excitation(lines)[1], direct, atol=2e-3 * np.abs(direct).max())
    # one pascal squared per hertz in the room loads both faces with twice that
    face = 4 if surroundings == "free" else 1
    np.testing.assert_allclose(excitation.spectrum(lines), face, rtol=0.02)
    expected = np.diagonal(forces["sources"], axis1=1, axis2=2).real
    found = np.diagonal(forces["measured"], axis1=1, axis2=2).real
    loud = expected > 0.02 * expected.max(axis=1, keepdims=True)
    assert np.abs(10 * np.log10(found[loud] / expected[loud])).max() < 0.2


def write_microphones(folder, waves, position, *, before_wall):
    """Write the cross-spectra of waves with 1 Pa²/Hz on the face, and the positions."""
    number = np.arange(1, len(position) + 1)
    frame = pd.DataFrame(position, columns=["x_m", "y_m", "z_m"])
    frame.insert(0, "microphone", number)
    frame.to_csv(folder / "mics.csv", index=False)
    one, other = np.triu_indices(len(position))
    blocks = []
    for frequency in np.linspace(25, 260, 24):
        k = 2 * np.pi * frequency / 343
        pressure = np.sqrt(waves.share)[:, None] * waves_at(
            waves, position, k, before_wall=before_wall
        )
        values = (pressure.T @ pressure.conj())[one, other]
        columns = np.full(one.size, frequency), number[one], number[other], values.real, values.imag
        blocks.append(np.column_stack(columns))
    pd.DataFrame(np.concatenate(blocks), columns=COLUMNS).to_csv(folder / "cross.csv", index=False)


def write_universal(path, cross=1 + 0.5j, **changes):
    """Write the cross-spectra of `LINES` as data sets 58 with a static line in front."""
    path.unlink(missing_ok=True)
    shared = {
        "func_type": 9, "abscissa_spacing": 0, "abscissa_spec_data_type": 18,
        "ordinate_spec_data_type": 15, "ordinate_axis_units_lab": "Pa^2/Hz",
        "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "id1": "a", "rsp_dir": 0,
        "ref_dir": 0, "x": np.array([0.0, 100.0, 200.0]), **changes,
    }  # fmt: skip
    sets = [
        pyuff.prepare_58(**shared, rsp_node=one, ref_node=other, data=np.array([9.0, value, value]))
        for one, other, value in ((1, 1, 2.0), (2, 2, 3.0), (1, 2, cross))
    ]
    pyuff.UFF(str(path)).write_sets(sets, mode="add")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ordinate_axis_units_lab": "psi^2/Hz"}, "unit 'psi\\^2/Hz'; must be Pa\\^2/Hz"),
        ({"ordinate_axis_units_lab": "dB"}, "unit 'dB'"),
        ({"ordinate_axis_units_lab": "Pa^2"}, "unit 'Pa\\^2'"),
        ({"cross": 1.2}, "microphones 1 and 2: is real; a cross-spectrum must have its phase"),
        (
            {"abscissa_spec_data_type": 0, "abscissa_axis_units_lab": "rpm"},
            "abscissa in 'rpm'; must be in Hz",
        ),
        ({"x": np.array([-100.0, 100.0, 200.0])}, "below 0; must be one-sided"),
        ({"func_type": 4}, "no data set 58 with a cross-spectrum"),
    ],
)
def test_universal_files_that_are_refused(tmp_path, changes, message):
    (tmp_path / "mics.csv").write_text(POSITIONS)
    write_universal(tmp_path / "cross.unv", **changes)
    with pytest.raises(ColumnsError, match=message):
        read_cross_spectra(tmp_path / "cross.unv", tmp_path / "mics.csv")


def test_a_universal_file_gives_the_same_matrices(tmp_path):
    expected = read(tmp_path, LINES)
    for unit in ("Pa^2/Hz", "(Pa)²/Hz"):
        write_universal(tmp_path / "cross.unv", ordinate_axis_units_lab=unit)
        found = read_cross_spectra(tmp_path / "cross.unv", tmp_path / "mics.csv")
        np.testing.assert_array_equal(found.frequency, expected.frequency)
        np.testing.assert_allclose(found.spectra, expected.spectra)
    (tmp_path / "broken.unv").write_text("    -1\n    58\n garbage\n    -1\n")
    with pytest.raises(ColumnsError, match="is no universal file"):
        read_cross_spectra(tmp_path / "broken.unv", tmp_path / "mics.csv")
