"""Statistical energy against sums over modes in closed form, and random matrices."""

import numpy as np
import pytest

from pidpanel.energy.response import DamperLoad, Medium, radiation_efficiency, relative_variance
from pidpanel.panel.navier import shear_plate_frequency, thin_plate_frequency
from pidpanel.panel.section import ThinSection
from tests.energy.panels import SANDWICH, energy_panel
from tests.energy.rectangles import (
    HALF,
    SPEED,
    band_mean,
    modal_forces,
    modes_in_band,
    orders,
)

THIRD = HALF - 1 / HALF
PAPER, PLATE = ThinSection(3273.07, 4.0), ThinSection(51.9, 5.4)
PANELS = {
    "paper": (PAPER, np.array([1.5, 1.0]), thin_plate_frequency),
    "sandwich": (SANDWICH, np.array([2.1, 1.5]), shear_plate_frequency),
    "plate of 2 mm": (PLATE, np.array([1.2, 0.8]), thin_plate_frequency),
}
LINES = np.linspace(1 / HALF, HALF, 21)[1::2]


def difference_db(name, centre, load=None, loss=0.02):
    """Energy over the sum over modes in a third octave, its standard error, and its response."""
    section, size, modes = PANELS[name]
    panel = energy_panel(section, size)
    found = panel.response(centre * LINES, load)
    kappa = panel.waves.wavenumber(2 * np.pi * np.array([centre])).max()

    def natural(pairs):
        return modes(*pairs.T, size, section)

    exact = band_mean(size, section.mass_per_area, natural, loss, centre, kappa)
    pairs = modes_in_band(size, natural, centre, kappa)
    force = modal_forces(size, pairs, 2 * np.pi * centre / SPEED)
    factor = np.mean(force**2) / np.mean(force) ** 2
    count = found.modal_density.mean() * centre * THIRD
    error = found.resonant_share.mean() * np.sqrt(relative_variance(count, loss, factor, THIRD))
    return 10 * np.log10(found.acceleration.mean() / exact), 10 / np.log(10) * error, found


@pytest.mark.parametrize("centre", [1585, 2512, 3981, 6310])
def test_the_papers_panel_is_within_03_db_of_its_modes(centre):
    difference, error, _ = difference_db("paper", 10 ** (round(10 * np.log10(centre)) / 10))
    assert abs(difference) < 0.3
    assert error < 0.4


@pytest.mark.parametrize("centre", [1995.262, 2511.886, 3981.072])
def test_a_sandwich_with_an_orthotropic_core_is_within_025_db_of_its_modes(centre):
    difference, *_ = difference_db("sandwich", centre)
    assert abs(difference) < 0.25


@pytest.mark.parametrize("centre", [630.957, 1258.925, 1995.262])
def test_far_below_coincidence_edges_radiate_and_long_waves_force(centre):
    difference, _, found = difference_db("plate of 2 mm", centre)
    assert abs(difference) < 0.4
    assert 0.6 < found.resonant_share.mean() < 0.85
    assert not found.at_coincidence.any()


def test_coincidence_is_marked_where_modes_differ_by_more_than_a_decibel():
    difference, _, found = difference_db("plate of 2 mm", 5011.872)
    assert abs(difference) > 1
    assert found.at_coincidence.any()


def test_a_damper_all_over_the_panel_adds_its_loss_factor():
    # C_e/(m″ω) = 0.01 at the centre doubles the loss of ζ = 0.5 %
    centre, resistance = 1995.262, 0.01 * 4.0 * 2 * np.pi * 1995.262 * 1.5
    difference, _, found = difference_db("paper", centre, DamperLoad(resistance), loss=0.03)
    assert found.damper_loss_factor.mean() == pytest.approx(0.01, rel=0.01)
    assert abs(difference) < 0.3


def test_a_mass_all_over_the_panel_is_a_heavier_panel():
    f = np.array([2000.0, 4000.0])
    load = DamperLoad(0.0, np.full(2, 1.5 * 1.0))
    found = energy_panel(PAPER, [1.5, 1.0]).response(f, load)
    heavier = energy_panel(ThinSection(3273.07, 5.0), [1.5, 1.0]).response(f)
    np.testing.assert_allclose(found.acceleration, heavier.acceleration, rtol=1e-6)
    np.testing.assert_allclose(found.modal_density, heavier.modal_density, rtol=1e-4)


def test_a_large_panel_above_coincidence_is_an_infinite_one():
    # coincidence angle alone: ∫ dμ/|1 − (k²(1 − μ²)/κ²)² (1 + iη)|², no modes and no edges
    f, size, eta = 4000.0, [60.0, 40.0], 2e-3
    found = energy_panel(PAPER, size, zeta=eta / 2).response(np.array([f])).acceleration[0]
    omega = 2 * np.pi * f
    kappa2, k2 = omega * np.sqrt(4.0 / 3273.07), (omega / SPEED) ** 2
    mu = (np.arange(4_000_000) + 0.5) / 4_000_000
    ratio = (k2 * (1 - mu**2) / kappa2) ** 2
    infinite = np.mean(1 / np.abs(1 - ratio * (1 + 1j * eta)) ** 2) / 4.0**2
    assert found == pytest.approx(infinite, rel=0.01)


def test_air_takes_the_power_that_a_baffled_piston_radiates():
    # far above coincidence σ = 1: R = ρ₀c₀ a side
    f = np.array([200e3])
    panel = energy_panel(PAPER, [1.5, 1.0], medium=Medium(SPEED, 1.2, 2, True))
    found = panel.response(f).loss_factor - 0.02
    np.testing.assert_allclose(found, 2 * 1.2 * SPEED / (2 * np.pi * f * 4.0), rtol=0.01)


def test_radiation_below_coincidence_is_the_mean_of_modes():
    # modes in a ring of wavenumbers; those at its axes radiate along a whole edge
    size, kappa, k = np.array([1.2, 0.8]), 80.0, 30.0
    pairs, of_mode = orders(size, 1.1 * kappa)
    pairs = pairs[of_mode > 0.9 * kappa]
    efficiency = modal_forces(size, pairs, k) * 4 / np.prod(size) * k**2 / (2 * np.pi)
    found = radiation_efficiency(np.array(kappa), np.array(k), 0.96, 4.0)
    assert found == pytest.approx(np.mean(efficiency), rel=0.1)
    clamped = radiation_efficiency(np.array(kappa), np.array(k), 0.96, 4.0, edge=2.0)
    assert clamped == pytest.approx(2 * found, rel=1e-3)


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_the_scatter_of_a_band_is_that_of_random_matrices(factor):
    # eigenvalues of the orthogonal ensemble, unfolded by the semicircle; forces of given spread
    rng, modes, eta, count = np.random.default_rng(3), 12.0, 0.02, 240
    found = []
    for _ in range(300):
        matrix = rng.normal(size=(count, count))
        value = np.linalg.eigvalsh(matrix + matrix.T) / np.sqrt(2 * count)
        x = np.clip(value / 2, -1, 1)
        level = count * (0.5 + (x * np.sqrt(1 - x**2) + np.arcsin(x)) / np.pi) - count / 2
        natural = 1 + level * THIRD / modes
        power = 1.0 if factor == 1 else rng.exponential(size=count)
        f = np.linspace(1 / HALF, HALF, 121)[:, None]
        found.append(np.sum(power / ((natural - f) ** 2 + (eta / 2) ** 2), axis=1).mean())
    scatter = np.var(found) / np.mean(found) ** 2
    assert relative_variance(modes, eta, factor, THIRD) == pytest.approx(scatter, rel=0.25)
