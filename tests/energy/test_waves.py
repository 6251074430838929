"""Waves and mode counts against Navier's frequencies, reflections in closed form, finite elements."""

import math

import numpy as np
import pytest

from pidpanel.energy.waves import PanelWaves, edge_factor_thin, wave_frequency
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import count_modes_below
from pidpanel.panel.navier import shear_plate_frequency, thin_plate_frequency
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from tests.energy.panels import SANDWICH, energy_panel
from tests.energy.rectangles import orders

SIZE = np.array([1.5, 1.0])


def test_a_mode_of_a_sandwich_is_a_wave_in_its_own_direction():
    # published closed forms, orthotropic core; see `tests/verification/test_panel.py`
    known = {(1, 1): 131.395, (2, 1): 250.475, (1, 2): 389.143, (3, 1): 444.475, (2, 2): 501.871,
             (3, 2): 685.934, (3, 3): 1055.296}  # fmt: skip
    k = np.pi * np.array(list(known)) / SIZE
    found = wave_frequency(SANDWICH, np.hypot(*k.T), np.arctan2(*k.T[::-1])) / (2 * np.pi)
    np.testing.assert_allclose(found, list(known.values()), rtol=1e-5)


def test_wavenumbers_in_between_belong_to_their_frequencies():
    waves, angle = PanelWaves(SANDWICH), np.array([0.3, 1.234, 2.9])
    omega = 2 * np.pi * np.array([200.0, 3000.0])
    kappa = waves.wavenumber_towards(omega, angle)
    np.testing.assert_allclose(wave_frequency(SANDWICH, kappa, angle), omega[:, None] * np.ones(3),
                               rtol=1e-5)  # fmt: skip


@pytest.mark.parametrize("section", [SANDWICH, ThinSection(51.9, 5.4)], ids=["sandwich", "thin"])
def test_the_smooth_count_is_that_of_navier_modes(section):
    # the corners of a rectangle add 1/4, and the count steps by one at each mode
    pairs, _ = orders(SIZE, 45.0)
    modes = shear_plate_frequency if section is SANDWICH else thin_plate_frequency
    natural = np.sort(modes(*pairs.T, SIZE, section))[20:150]  # complete up to there
    middle = np.arange(20, 150) + 0.5
    difference = middle - energy_panel(section, SIZE).mode_count(natural)
    assert np.mean(difference) == pytest.approx(0.25, abs=0.1)


def test_a_clamped_edge_has_the_constant_of_its_closed_form():
    exact = -1 - math.gamma(0.75) / (math.sqrt(math.pi) * math.gamma(1.25))
    assert edge_factor_thin("clamped", 0.3) == pytest.approx(exact, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["clamped", "free"])
@pytest.mark.parametrize("is_thin", [True, False], ids=["thin", "sandwich"])
def test_the_smooth_count_is_that_of_finite_elements(tmp_path, kind, is_thin):
    # corners add a constant of about one mode, the count scatters by one, and the edge of a
    # sandwich is between the two limits that are known
    section = ThinSection(3273.07, 4.0) if is_thin else SANDWICH
    outline = Rectangle(tuple(SIZE / 2), tuple(SIZE))
    mesh = mesh_triangles(tmp_path / "panel.msh", outline, 0.09 if is_thin else 0.05, {}, {})
    assemble = assemble_thin_plate if is_thin else assemble_shear_plate
    plate = assemble(mesh, section, Supports(kind))
    f = np.linspace(1500.0, 3000.0, 8) + 0.123
    counted = np.array([count_modes_below(plate, x) for x in f])
    smooth = energy_panel(section, SIZE, kind=kind).mode_count(f)
    assert 0 < np.mean(counted - smooth) < 2.5
    # what edges do is more than that
    assert np.abs(smooth - energy_panel(section, SIZE).mode_count(f)).mean() > 3
