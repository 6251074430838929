"""Panels with free edges: against boundary elements in space, closed forms and limits."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.solve import moved_panel
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.field import diffuse_modal_force, wavenumber
from pidpanel.sound.free_edges import (
    FreePanel,
    tabulate_diffuse_room,
    tabulate_free_plane_waves,
)
from pidpanel.sound.outline import OutlineJumps
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.radiation import Air
from pidpanel.sound.rectangle import RectangleJumps
from pidpanel.sound.wavenumber_table import JoinedTable
from tests.sound.hats import BY_ELEMENTS, extrapolated
from tests.sound.panels import SIDES, l_mesh, sine_panel, sines

K = float(wavenumber(64.9, 343.0))
MODES = [(1, 1), (2, 1), (3, 2)]


@pytest.fixture(scope="module")
def panel():
    return FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 14.0), 12.0)


def diagonal(panel, face, k):
    return np.diagonal(panel.impedance(k, panel.jumps.couplings(face)))


@pytest.mark.slow
def test_the_rectangle_is_that_of_boundary_elements_in_space(panel, face):
    for index, k in ((0, K), (1, 2.29)):
        expected = extrapolated(SIDES, (12, 8), k, MODES[index])
        found = diagonal(panel, face, k)[index]
        # what the extrapolation leaves: 1e-3 of the load at 8 elements
        assert found.real == pytest.approx(expected.real, rel=2e-3)
        assert found.imag == pytest.approx(expected.imag, rel=4e-3)
        if k == K:
            assert expected == pytest.approx(BY_ELEMENTS, rel=1e-3)


def test_first_mode_has_11_45_db_less_than_two_faces_and_a_fifth_of_its_mass_in_air(panel, face):
    # the prototype of issue 44, whose integral ends at a finite wavenumber, has −11.43 dB
    Z = diagonal(panel, face, K)[0]
    faces = 4 * diffuse_modal_force(K, sine_panel([(1, 1)]))[0, 0]
    assert 10 * np.log10(4 * np.pi / K * Z.imag / faces) == pytest.approx(-11.449, abs=2e-3)
    assert 1.2 * Z.real / (4.0 * SIDES[0] * SIDES[1] / 4) == pytest.approx(0.2162, abs=1e-4)


def test_more_functions_change_nothing_that_is_resolved(panel, face):
    finer = FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 22.0), 12.0)
    for k in (0.3, 3.0, 12.0):
        few, many = diagonal(panel, face, k), diagonal(finer, face, k)
        np.testing.assert_allclose(few.real, many.real, rtol=2e-3)
        np.testing.assert_allclose(few.imag, many.imag, rtol=2e-3)


def test_tables_are_the_impedance_between_their_nodes(panel, face):
    force, volume = tabulate_diffuse_room(panel, face)
    load = np.max(np.diagonal(force.even, axis1=1, axis2=2), axis=0)  # over k²
    for k in (0.05, 0.7, 4.4, 11.9):
        Z = panel.impedance(k, panel.jumps.couplings(face))
        missed = np.abs(force.matrix([k])[0] - np.pi / k * Z.imag) / k**2
        assert np.max(missed / np.sqrt(np.outer(load, load))) < 1e-3
        assert np.max(np.abs(volume.matrix([k])[0] - Z.real / 2)) < 1e-3 * np.abs(Z.real).max()


def test_a_table_of_a_plane_wave_is_its_force_and_a_grazing_wave_has_none(panel, face):
    angles = np.array([0.6]), np.array([0.4])
    table = tabulate_free_plane_waves(panel, face, PlaneWaves(*angles, np.ones(1)))
    couplings = panel.jumps.couplings(face)
    for k in (0.8, 6.3):
        (force,) = panel.wave_forces(k, *angles, couplings)
        expected = np.outer(force, force.conj()) / 4
        np.testing.assert_allclose(
            table.matrix([k])[0], expected, atol=2e-3 * np.abs(expected).max()
        )
    grazing = panel.wave_forces(3.0, np.array([np.pi / 2]), angles[1], couplings)
    assert np.abs(grazing).max() < 1e-12


def test_short_waves_from_the_front_press_with_twice_their_pressure(panel, face):
    # what flows round the edges is of order 1/(ka), here 1/6
    (force,) = panel.wave_forces(12.0, np.zeros(1), np.zeros(1), panel.jumps.couplings(face))
    assert abs(force[0]) == pytest.approx(2 * 4 / np.pi**2 * SIDES[0] * SIDES[1], rel=0.07)


def test_a_far_wall_is_none_and_a_close_one_takes_load_and_adds_mass(face):
    # the image of a dipole acts with 3/(2kd) at most
    jumps = RectangleJumps.of_box([0, 0], SIDES, 8.0)
    free, far, close = (
        diagonal(FreePanel.of_jumps(jumps, 2.0, wall), face, K)[0] for wall in (np.inf, 40.0, 0.2)
    )
    assert far.real == pytest.approx(free.real, rel=0.01)
    assert far.imag == pytest.approx(free.imag, rel=3 / (2 * K * 40))
    assert close.imag < 0.3 * free.imag
    assert close.real > 1.2 * free.real


def test_shapes_of_any_outline_couple_as_at_the_points_of_the_mesh():
    jumps = OutlineJumps.of_mesh(*l_mesh(), 6.0)
    points = jumps.functions
    x, y = points.position.T
    shape = np.stack([np.cos(3 * x + y), np.sin(5 * x - 4 * y), np.ones_like(x)], axis=1)
    moved = PanelQuadrature(points.position, points.weight, shape)
    direct = points.shape.T @ (points.weight[:, None] * shape)
    (coupling,) = jumps.couplings(condensed(moved, 60.0))
    np.testing.assert_allclose(coupling, direct, atol=2e-4 * np.abs(direct).max())


@pytest.mark.parametrize("damping", [0.0, 800.0])
def test_shapes_far_above_a_line_need_no_coupling_by_air_with_each_other(monkeypatch, damping):
    # g rms of the paper's panel from 30 to 220 Hz
    # red: `_pushed` or `_followed` without the other shapes; SHAPES_IN_AIR, LEAST_IN_AIR = 1, 10
    numbers = [(m, n) for m in range(1, 14) for n in range(1, 10) if (m / 1.5) ** 2 + n**2 < 80]
    natural = np.array(
        [np.pi / 2 * np.sqrt(3273.07 / 4) * ((m / 1.5) ** 2 + n**2) for m, n in numbers]
    )
    basis = ModalBasis(natural, np.full(natural.size, 1.5), 0.01)
    free = FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 22.0), 4.2)
    force, volume = tabulate_diffuse_room(free, condensed(sine_panel(numbers), 40.0))
    air = Air(1.2, 343.0, 2, force, volume)
    x, y = (side * np.arange(0.45, 0.55, 0.01) for side in SIDES)
    rows = sines(np.array(list(product(x, y))), numbers)
    patch = Patches.of_rows(rows[None] * np.sqrt(0.02 / len(rows)), [0.02])
    points = sines(np.array([(0.75, 0.5), (0.4, 0.3)]), numbers)
    lines = frequency_grid(30.0, 220.0, 0.01, lines_per_bandwidth=3)

    def rms():
        (bare,) = bare_panels(
            lines, basis, [patch], points, np.ones(lines.size),
            lambda f: force.matrix(wavenumber(f, 343.0)), air,
        )  # fmt: skip
        dampers = np.full((2, 1, lines.size), [[[damping]], [[damping / 200]]])
        return attach_dampers(bare, *dampers).acceleration_rms

    found = rms()
    monkeypatch.setattr(moved_panel, "SHAPES_IN_AIR", 1e3)
    expected = rms()
    np.testing.assert_allclose(found, expected, rtol=5e-6)
    assert np.all(found != expected)


def test_the_air_on_some_shapes_is_columns_of_its_matrix(panel, face):
    # below, in and above the transition between two tables
    force, volume = tabulate_diffuse_room(panel, face)
    joined = JoinedTable(replace(force, wavenumber_max=6.0), force)
    frequency, shapes = np.array([20.0, 280.0, 600.0]), np.array([0, 2])
    air = Air(1.2, 343.0, 2, joined, volume)
    for part in (frequency, frequency[:1], frequency[2:]):
        block = air(part)[:, :, shapes]
        np.testing.assert_allclose(air.columns(part, shapes), block, rtol=1e-12)
