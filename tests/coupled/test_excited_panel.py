"""The panel of a study with the patches of a scenario, against sines and plain sums."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.coupled.scenario import CoupledScenario, SimulatedPatch
from pidpanel.coupled.softening import RmsMotion, softened, softest
from pidpanel.damping.models import Damper, DampingValues, FilledDamper
from pidpanel.damping_ratio import DampingRatio
from tests.beds import hexagons

STIFF = 3.3e9
BED = hexagons()
LINES = np.linspace(40.0, 150.0, 4001)


class ByAcceleration(Damper):
    """C_e = 10 Γ r f, without a mass."""

    def __call__(self, frequency, fill_fraction, acceleration_g):
        damping = 10 * acceleration_g * fill_fraction * frequency
        none = np.zeros_like(damping)
        return DampingValues(damping, none, none, none == 0)


def scenario(factor=1.0, dampers=None):
    patches = (SimulatedPatch("middle", STIFF, (BED,)),)
    return CoupledScenario("one", factor, patches, dampers or {})


def sine(place, m=1, n=1):
    return np.sin(m * np.pi * place[:, 0] / 1.5) * np.sin(n * np.pi * place[:, 1])


def psds(excited, twice_ratio=0.04):
    """Cross-PSDs (nf, n, n) of the coordinates of the bare panel."""
    basis = excited.basis
    omega, own = 2 * np.pi * LINES[:, None], 2 * np.pi * basis.natural_frequency
    per_force = 1 / (basis.modal_mass * (own**2 - omega**2 + 1j * twice_ratio * own * omega))
    force = excited.excitation(LINES)[0] * (2.0 + LINES / 50)[:, None, None]
    return per_force[:, :, None] * force * per_force[:, None, :].conj()


def mean_square(excited, overlap, order):
    """∫ ω^order Σ_ij D_ij S_ij df of a motion."""
    psd = np.einsum("fij,ij->f", psds(excited), overlap).real
    return np.trapezoid((2 * np.pi * LINES) ** order * psd, LINES)


def test_modes_have_the_damping_ratio_of_the_panel(excited):
    wanted = 44.9332 * (1 / 1.5**2 + 1)
    assert excited.modal.natural_frequency[0] == pytest.approx(wanted, rel=1e-3)
    assert excited.modal.damping_ratio[:4].tolist() == [0.02] * 4
    assert excited.diameter == pytest.approx(np.hypot(1.5, 1.0))


def test_coarse_lines_give_rms_values_within_a_thousandth(excited):
    # the lines of one g rms per lg f
    def rms(f):
        own = excited.basis.natural_frequency[0]
        psd = f**4 / np.abs(own**2 - f**2 + 0.04j * own * f) ** 2
        return np.sqrt(np.trapezoid(psd, f))

    coarse = excited.coarse_frequency
    assert (coarse[0], coarse[-1]) == pytest.approx((40.0, 150.0))
    assert len(coarse) < 150
    assert rms(coarse) == pytest.approx(rms(LINES), rel=1e-3)


def test_cells_stand_at_their_stations_and_stand_for_their_area(excited):
    # the first shapes are products of sines
    patch = excited.with_patches(scenario()).patches[0]
    assert patch.shape.shape[0] == len(patch.area) == len(patch.position) == 8
    assert patch.area.sum() == pytest.approx(0.8)
    assert patch.area == pytest.approx(np.full(8, 0.1))
    assert patch.position[0] == pytest.approx(patch.position[1])
    assert patch.shape[:, 0] == pytest.approx(sine(patch.position), abs=1e-3)
    # four stations near the middles of the quarters
    assert np.unique(patch.position, axis=0) == pytest.approx(
        np.array([[x, y] for x in (0.5, 1.0) for y in (0.3, 0.7)]), abs=0.07
    )
    assert patch.cell_area == BED.packing.cell_area
    # of the sines, ∫ sin² over the patch
    of_x = 0.5 - 1.5 / (2 * np.pi) * (np.sin(2.5 * np.pi / 1.5) - np.sin(0.5 * np.pi / 1.5)) / 2
    of_y = 0.4 - (np.sin(1.8 * np.pi) - np.sin(0.2 * np.pi)) / (4 * np.pi)
    assert patch.overlap[0, 0] == pytest.approx(of_x * of_y, rel=1e-3)


def test_the_level_of_a_scenario_multiplies_the_excitation(excited):
    panel = excited.with_patches(scenario(factor=4.0))
    frequency = np.array([50.0, 100.0])
    wanted = 4.0 * np.array([3.0, 4.0])[:, None, None] * excited.excitation(frequency)
    assert panel.load(frequency) == pytest.approx(wanted, rel=1e-9)
    assert panel.points[:, 0] == pytest.approx([1.0, sine(np.array([[0.25, 0.2]]))[0]], abs=1e-3)


def test_a_given_damper_has_the_motion_of_the_bare_patch(excited):
    # C_e = 10 Γ r f with Γ = √2 a_rms/g, the mean of the patch, which the modes' damping shows
    damper = FilledDamper("pot", ByAcceleration(), 0.7)
    found = excited.with_patches(scenario(factor=3.0, dampers={"side": damper})).modal
    overlap = excited.basis.patch_overlap[1]
    square = mean_square(excited, overlap, 4) / (0.25 * 0.8)
    gamma = np.sqrt(2 * 3.0 * square) / 9.80665
    modal = excited.modal
    frequency = np.clip(modal.natural_frequency, 40.0, 150.0)
    more = 10 * gamma * 0.7 * frequency * np.diagonal(overlap)
    assert found.natural_frequency == pytest.approx(modal.natural_frequency)
    wanted = (modal.damping + more) / modal.modal_mass
    assert found.damping == pytest.approx(wanted, rel=2e-3)
    assert more[0] > 0.02 * modal.damping[0]


def test_the_whole_panel_has_all_of_its_air_and_the_dampers_in_it(excited):
    # air that doubles each modal mass, with which a patch moves less
    mass = excited.modal.modal_mass

    def air(frequency):
        return -((2 * np.pi * frequency[:, None, None]) ** 2) * np.diag(mass) + 0j

    wet, damper = replace(excited, air=air), FilledDamper("pot", ByAcceleration(), 0.7)
    level = scenario(factor=3.0, dampers={"side": damper})
    frequency = np.array([50.0, 120.0])
    found = wet.whole(level).dynamic_stiffness(frequency)
    heavy = replace(excited, basis=replace(excited.basis, modal_mass=2 * mass,
        natural_frequency=excited.basis.natural_frequency / np.sqrt(2)))  # fmt: skip
    # 2 ζ_i m_i ω_i of the bare panel, of a mass that is twice as large
    ratio = DampingRatio((0.02 / np.sqrt(2),))
    heavy = replace(heavy, settings=replace(excited.settings, damping_ratio=ratio))
    overlap = excited.basis.patch_overlap[1]
    square = np.trapezoid((2 * np.pi * LINES) ** 4 * np.einsum(
        "fij,ij->f", psds(heavy, 0.04 / np.sqrt(2)), overlap).real, LINES) / (0.25 * 0.8)  # fmt: skip
    gamma = np.sqrt(2 * 3.0 * square) / 9.80665
    damping = 10 * gamma * 0.7 * frequency * 2j * np.pi * frequency
    wanted = excited.modal.dynamic_stiffness(frequency)[:, :, None] * np.eye(len(mass))
    wanted = wanted + air(frequency) + damping[:, None, None] * overlap
    assert np.abs(found - wanted).max() < 2e-3 * np.abs(damping[:, None, None] * overlap).max()
    (run,) = [wet.with_patches(level)]
    assert run.added is None


@pytest.mark.parametrize("share", [0.97, 1.03])
def test_contacts_follow_the_rms_motion_of_the_stations(excited, share):
    # at a level where the bed just does not cross its gap, and where it does
    patch = excited.with_patches(scenario()).patches[0]
    weight = patch.area / patch.area.sum()
    stations = (patch.shape * weight[:, None]).T @ patch.shape
    velocity, acceleration = (np.sqrt(mean_square(excited, stations, k)) for k in (2, 4))
    stroke = np.sqrt(2) * velocity**2 / acceleration
    limit = 0.2 * 8e-3 * (1 - 0.94 * 0.5)
    root = share * limit / stroke
    level = scenario(factor=root**2)
    panel = excited.with_patches(level)
    motion = RmsMotion(root * velocity, root * acceleration)
    (found,) = excited.moduli(level, panel)
    assert found.modulus == softest(STIFF, BED, motion).modulus
    given = replace(excited, settings=replace(excited.settings, youngs_modulus=50e6))
    (found,) = given.moduli(level, panel)
    assert found.modulus == 50e6
    assert found == pytest.approx(softened(STIFF, BED, motion, 50e6), rel=2e-3)
    assert (found.bias > 0) == (share > 1)
