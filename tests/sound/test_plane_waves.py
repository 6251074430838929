"""Some sources in place of a diffuse field: independent, or with one drive."""

import numpy as np
import pytest

from pidpanel.sound.field import plane_wave_modal_force
from pidpanel.sound.free_edges import (
    plane_wave_force,
    tabulate_free_plane_waves,
)
from pidpanel.sound.from_study import plane_waves
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.study import Study, StudyError, load_study
from tests.sound.panels import SIDES
from tests.sound.test_from_study import BANDS, STUDY

K = 3.7


def evenly(count, **keys):
    """Return waves from all sides, `count` in cos θ and 2 `count` in azimuth."""
    cosine = np.polynomial.legendre.leggauss(count)
    azimuth = np.pi * np.arange(2 * count) / count
    theta, alpha = (g.ravel() for g in np.meshgrid(np.arccos(cosine[0]), azimuth, indexing="ij"))
    return PlaneWaves(theta, alpha, np.repeat(cosine[1], azimuth.size) / 4 / count, **keys)


def test_two_waves_with_one_drive_stand(face):
    # k and −k along x: p = √2 cos(kx sin θ) about the middle, √(1/2) each; odd modes see none
    opposite = np.array([0.4, 0.4]), np.array([0.0, np.pi]), np.full(2, 0.5)
    (together,) = plane_wave_modal_force([K], PlaneWaves(*opposite, has_one_drive=True), face)
    (apart,) = plane_wave_modal_force([K], PlaneWaves(*opposite), face)
    distance = face.position[:, 0] - SIDES[0] / 2
    force = face.weight @ (face.shape * np.cos(K * np.sin(0.4) * distance)[:, None])
    assert together[0, 0].real == pytest.approx(2 * force[0] ** 2, rel=1e-9)
    assert apart[0, 0].real == pytest.approx(force[0] ** 2, rel=1e-9)
    assert together[1, 1].real < 1e-12 * apart[1, 1].real


def test_independent_sources_on_all_sides_are_a_diffuse_room(panel, face):
    couplings = panel.jumps.couplings(face)
    many = plane_wave_force(panel, K, evenly(12), couplings)
    impedance = panel.impedance(K, couplings)
    # both by the same functions of the jump: what is left is the sum over directions
    expected = np.pi / K * impedance.imag
    np.testing.assert_allclose(many, expected, atol=1e-3 * np.abs(expected).max())


def test_equal_sources_on_both_sides_with_one_drive_leave_a_thin_panel_at_rest(panel, face):
    both = np.array([0.6, np.pi - 0.6]), np.array([0.3, 0.3]), np.full(2, 0.5)
    couplings = panel.jumps.couplings(face)
    together, apart = (
        np.abs(plane_wave_force(panel, K, PlaneWaves(*both, drive), couplings)).max()
        for drive in (True, False)
    )
    assert together < 1e-20
    assert apart > 1e-4


def test_a_table_of_sources_is_their_force_at_any_wavenumber(panel, face):
    waves = PlaneWaves(np.array([0.2, 2.5]), np.array([0.0, 1.0]), np.array([0.8, 0.2]), True)
    table = tabulate_free_plane_waves(panel, face, waves)
    largest = np.abs(table.even).max() * K**2
    for k in (1.1, K, 7.7):
        direct = plane_wave_force(panel, k, waves, panel.jumps.couplings(face))
        np.testing.assert_allclose(table.matrix([k])[0], direct, atol=1e-3 * largest)


def study_with(tmp_path, sound) -> Study:
    (tmp_path / "bands.csv").write_text(BANDS)
    (tmp_path / "small.yaml").write_text(STUDY.format(sound=sound, air_mass="true"))
    return load_study(tmp_path / "small.yaml")


def test_levels_of_sources_share_the_spectrum(tmp_path):
    sources = "[{incidence_deg: 20}, {incidence_deg: 150, azimuth_deg: 90, level_db: 6}]"
    sound = f"surroundings: free, field: {{sources: {sources}, one_drive: true}}"
    study = study_with(tmp_path, sound)
    waves = plane_waves(study.acoustics)
    assert waves.has_one_drive
    assert waves.share[1] / waves.share[0] == pytest.approx(10**0.6)
    assert waves.share.sum() == pytest.approx(1)
    np.testing.assert_allclose(np.degrees(waves.incidence), [20, 150])
    assert "free among sources" in study.setting
    assert "level of the sources alone" in study.setting


@pytest.mark.parametrize(
    ("sound", "message"),
    [
        ("field: {sources: []}", "sound.field.sources"),
        ("field: {sources: [{incidence_deg: 120}]}", "must be at most 90 in a baffle"),
        (
            "surroundings: free, field: {sources: [{incidence_deg: 90}]}",
            "must be below 90 with free edges",
        ),
        ("field: {sources: [{incidence_deg: 9}]}, incidence_deg: 9", "not allowed otherwise"),
        ("field: {sources: [{incidence_deg: 9}], coherent: true}", "coherent"),
        ("field: speakers", "must be 'diffuse'"),
    ],
)
def test_sources_that_are_refused(tmp_path, sound, message):
    with pytest.raises(StudyError, match=message):
        study_with(tmp_path, sound)


def test_eight_sources_scatter_about_the_diffuse_room(panel, face):
    # eight at random: at a point of a panel the load of its first modes is off by decibels
    rng, couplings = np.random.default_rng(3), panel.jumps.couplings(face)
    diffuse = np.diagonal(np.pi / K * panel.impedance(K, couplings).imag)
    levels = []
    for _ in range(60):
        theta, alpha = np.arccos(rng.uniform(-1, 1, 8)), rng.uniform(0, 2 * np.pi, 8)
        waves = PlaneWaves(theta, alpha, np.full(8, 1 / 8))
        levels.append(np.diagonal(plane_wave_force(panel, K, waves, couplings)).real / diffuse)
    assert np.mean(levels) == pytest.approx(1, abs=0.1)
    assert 0.5 < np.std(10 * np.log10(np.array(levels)[:, 0])) < 3
