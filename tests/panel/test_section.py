"""Sections, their waves and frequencies: integrals over the depth, dispersion and limits."""

import dataclasses
import re

import numpy as np
import pytest

from pidpanel.panel import navier, resolution
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection, ThinSection

HEAVY = Ply(Material.isotropic(70e9, 0.3, 2700.0), 0.6e-3)
LIGHT = Ply(Material(E1=300e9, E2=6e9, G12=4.5e9, nu12=0.3, density=1600.0), 0.2e-3, 0.4)
UNEVEN = SandwichSection((HEAVY,), (LIGHT, HEAVY, LIGHT), Core(186e6, 90e6, 32.0, 9.4e-3), 0.5)
SOLID = SolidSection(70e9, 0.33, 2700.0, 8e-3)


def test_rotary_inertia_is_the_second_moment_of_the_density_about_its_centre():
    # layer by layer from the bottom, by the theorem of parallel axes
    parts = [(p.material.density, p.thickness) for p in UNEVEN.bottom] + [(32.0, 9.4e-3)]
    parts += [(p.material.density, p.thickness) for p in UNEVEN.top[::-1]]
    density, thickness = np.array(parts).T
    middle = np.cumsum(thickness) - thickness / 2
    mass = density * thickness
    centre = mass @ middle / mass.sum()
    expected = (mass * (thickness**2 / 12 + (middle - centre) ** 2)).sum()
    assert UNEVEN.rotary_inertia == pytest.approx(expected, rel=1e-12)
    assert UNEVEN.mass_per_area == pytest.approx(mass.sum() + 0.5, rel=1e-12)


def test_uneven_faces_are_apart_by_the_core_and_half_of_each():
    # S = G d²/t_c
    d = 9.4e-3 + 0.3e-3 + 0.5e-3
    assert UNEVEN.distance == pytest.approx(d)
    np.testing.assert_allclose(UNEVEN.shear, np.diag([186e6, 90e6]) * d**2 / 9.4e-3)


def test_a_solid_plate_is_integrated_over_its_depth():
    # stress by Hooke's law in plane stress; the shear stress is a parabola whose resultant is S γ
    E, nu, rho, t = 70e9, 0.33, 2700.0, 8e-3
    z = np.linspace(-t / 2, t / 2, 20001)
    hooke = E / (1 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    np.testing.assert_allclose(SOLID.bending, hooke * np.trapezoid(z**2, z), rtol=1e-7)
    assert SOLID.rotary_inertia == pytest.approx(rho * np.trapezoid(z**2, z), rel=1e-7)
    assert SOLID.mass_per_area == pytest.approx(rho * t)
    for layer, side in zip(SOLID.layers, (t / 2, -t / 2), strict=True):
        np.testing.assert_allclose(layer.strain, side * np.eye(3))
        np.testing.assert_allclose(layer.stress, side * hooke, rtol=1e-12, atol=1e-6)
    parabola = 1 - (2 * z / t) ** 2
    resultant = SOLID.core_stress * np.trapezoid(parabola, z)
    np.testing.assert_allclose(resultant, SOLID.shear, rtol=1e-7)
    np.testing.assert_allclose(SOLID.shear, 5 / 6 * E / (2 * (1 + nu)) * t * np.eye(2))


@pytest.mark.parametrize("section", [ThinSection(3273.07, 4.0), UNEVEN, SOLID])
@pytest.mark.parametrize("frequency", [100.0, 2000.0])
def test_half_a_wave_meets_the_dispersion_of_the_weaker_direction(section, frequency):
    # D k⁴ = m″ω² (1 + D k²/S)
    D = min(section.bending[0, 0], section.bending[1, 1])
    shear = getattr(section, "shear", np.diag([np.inf, np.inf]))
    k = np.pi / resolution.half_wave(section, frequency)
    inertia = section.mass_per_area * (2 * np.pi * frequency) ** 2
    assert D * k**4 == pytest.approx(inertia * (1 + D * k**2 / min(np.diag(shear))), rel=1e-9)


@pytest.mark.parametrize("frequency", [300.0, 450.0, 800.0])
def test_the_longest_edge_of_a_message_is_allowed(frequency):
    section = ThinSection(3273.07, 4.0)
    kind = resolution.ElementKind("thin quadrilaterals", section)
    for ratio, patch_mass in ((0.2, 0.0), (0.01, 0.0), (0.001, 0.0), (0.01, 40.0)):

        def regions_of(edge, patch_mass=patch_mass):
            patches = [resolution.Region("p", 0.1, edge, patch_mass)] if patch_mass else []
            return [resolution.Region("", 1.0, edge), *patches]

        with pytest.raises(ValueError, match="at most") as caught:
            kind.check(regions_of(0.4), frequency, ratio)
        edge = float(re.findall(r"at most ([\d.e-]+) m", str(caught.value))[0])
        kind.check(regions_of(edge), frequency, ratio)
        with pytest.raises(ValueError, match="at most"):
            kind.check(regions_of(1.01 * edge), frequency, ratio)


def test_each_part_of_a_panel_has_its_share_of_the_modes():
    # two halves alike are the whole
    section, ratio = ThinSection(3273.07, 4.0), 0.01
    whole, halves = (
        resolution.ElementKind("thin quadrilaterals", section).line_error_db(
            [resolution.Region("", 1.5 / n, 0.05)] * n, 900.0, ratio
        )
        for n in (1, 2)
    )
    assert halves == pytest.approx(whole)


def test_the_error_of_a_line_is_that_of_even_resonances_that_are_shifted():
    # N = A f/2 √(m″/D); S = sinh x/(cosh x − cos 2πf/δ), x = 2πζf/δ, δ = 1/N′
    area, edge, ratio, high = 1.5, 0.04, 0.01, 1000.0
    section = ThinSection(3273.07, 4.0)
    density = area / 2 * np.sqrt(4.0 / 3273.07)
    phase = np.linspace(0, 2 * np.pi, 4001)
    errors = []
    for f in high * np.geomspace(1 / 30, 1, 60):
        x = 2 * np.pi * ratio * f * density
        level = 10 * np.log10(np.sinh(x) / (np.cosh(x) - np.cos(phase)))
        steepest = np.abs(np.gradient(level, phase)).max() * 2 * np.pi * density  # [dB/Hz]
        half = np.pi / np.sqrt(2 * np.pi * f * np.sqrt(4.0 / 3273.07))
        shift = 0.01 * (edge / (0.65 * half)) ** 4
        errors.append(shift * f * steepest if f * density >= 1 else 0.0)
    regions = [resolution.Region("", area, edge)]
    found = resolution.ElementKind("thin quadrilaterals", section).line_error_db(
        regions, high, ratio
    )
    assert found == pytest.approx(max(errors), rel=0.01)


def test_below_the_first_resonance_no_line_errs():
    # N = A f/2 √(m″/D) = 1 at 38.1 Hz
    section, regions = ThinSection(3273.07, 4.0), [resolution.Region("", 1.5, 0.3)]
    first = 2 / 1.5 * np.sqrt(3273.07 / 4.0)
    errors = [
        resolution.ElementKind("thin quadrilaterals", section).line_error_db(
            regions, share * first, 0.01
        )
        for share in (0.98, 1.04)
    ]
    assert errors[0] == 0.0 < errors[1]


def test_a_damper_all_over_is_a_heavier_panel_of_less_damping():
    # C_e aside, c ω of the panel is spread over more mass
    heavy = resolution.Region("p", 1.5, 0.05, 12.0)
    bare = resolution.Region("", 1.5, 0.05)
    of_damper, of_section = (
        resolution.ElementKind("thin quadrilaterals", section).line_error_db([region], 900.0, ratio)
        for region, section, ratio in (
            (heavy, ThinSection(3273.07, 4.0), 0.02), (bare, ThinSection(3273.07, 16.0), 0.01)
        )
    )  # fmt: skip
    assert of_damper == pytest.approx(of_section)


def test_waves_are_shorter_under_a_damper_by_the_fourth_root_of_the_mass():
    section = ThinSection(3273.07, 4.0)
    ratio = resolution.half_wave(section, 500.0) / resolution.half_wave(section, 500.0, 60.0)
    assert ratio == pytest.approx(2.0)


def test_a_heavy_damper_needs_shorter_elements_below_it():
    section = ThinSection(3273.07, 4.0)
    for mass, frequency, edge in ((30.0, 300.0, 0.25), (150.0, 1200.0, 0.125)):
        bare = resolution.Region("", 1.0, edge)
        resolution.ElementKind("thin quadrilaterals", section).check([bare], frequency, 0.2)
        heavy = resolution.Region("p", 1.5, edge, mass)
        with pytest.raises(
            ValueError, match=f"under p, whose damper can weigh {mass:g} kg/m², are "
        ):
            resolution.ElementKind("thin quadrilaterals", section).check([heavy], frequency, 0.2)


def test_a_lightly_damped_panel_needs_shorter_elements():
    section, region = ThinSection(3273.07, 4.0), resolution.Region("", 1.5, 0.05)
    resolution.ElementKind("thin quadrilaterals", section).check([region], 2000.0, 0.01)
    with pytest.raises(
        ValueError, match=r"damping_ratio = 0\.001 changes PSDs by about .* 0\.5 dB"
    ):
        resolution.ElementKind("thin quadrilaterals", section).check([region], 2000.0, 0.001)


SIZE = (1.5, 1.1)
ORDERS = ([1, 2, 3, 1], [1, 1, 2, 4])


@dataclasses.dataclass(frozen=True)
class Given:
    """A section by its numbers."""

    bending: np.ndarray
    shear: np.ndarray
    mass_per_area: float
    rotary_inertia: float


ORTHOTROPIC = np.array([[5000.0, 700.0, 0], [700.0, 2000.0, 0], [0, 0, 900.0]])


def test_a_rigid_core_leaves_the_orthotropic_thin_plate():
    # ω² m″ = D₁₁p⁴ + 2(D₁₂ + 2D₆₆)p²q² + D₂₂q⁴ (Leissa, Vibration of Plates, eq. 9.12)
    section = Given(ORTHOTROPIC, 1e13 * np.eye(2), 4.0, 1e-12)
    p, q = (np.pi * np.array(n) / side for n, side in zip(ORDERS, SIZE, strict=True))
    D = ORTHOTROPIC
    energy = D[0, 0] * p**4 + 2 * (D[0, 1] + 2 * D[2, 2]) * p**2 * q**2 + D[1, 1] * q**4
    expected = np.sqrt(energy / 4.0) / (2 * np.pi)
    found = navier.shear_plate_frequency(*ORDERS, SIZE, section)
    # D k²/S is 1e-8, rounding of 1e13 beside 1e3 as much again
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_rigid_faces_leave_a_shear_membrane():
    # ω² m″ = S₁p² + S₂q²
    section = Given(1e12 * ORTHOTROPIC, np.diag([3e6, 1e6]), 4.0, 1e-3)
    p, q = (np.pi * np.array(n) / side for n, side in zip(ORDERS, SIZE, strict=True))
    expected = np.sqrt((3e6 * p**2 + 1e6 * q**2) / 4.0) / (2 * np.pi)
    # the rotations are not all held: the membrane's own S over D is 1e-8
    np.testing.assert_allclose(
        navier.shear_plate_frequency(*ORDERS, SIZE, section), expected, rtol=1e-4
    )


def wave_number_squared():
    """k² = (mπ/a)² + (nπ/b)²."""
    return np.sum((np.pi * np.array(ORDERS).T / SIZE) ** 2, axis=1)


def in_series(D, S, mass):
    """Frequencies of springs in series: 1/ω² = 1/ω_b² + 1/ω_s², ω_s² = S k²/m″."""
    k2 = wave_number_squared()
    bends = navier.thin_plate_frequency(*ORDERS, SIZE, ThinSection(D, mass))
    shears = np.sqrt(S * k2 / mass) / (2 * np.pi)
    return (bends**-2.0 + shears**-2.0) ** -0.5


def test_an_isotropic_sandwich_without_rotary_inertia_is_its_closed_form_and_inertia_slows_it():
    thin = ThinSection(3273.07, 4.0)
    section = Given(thin.bending, 2e5 * np.eye(2), 4.0, 1e-9)
    closed = in_series(3273.07, 2e5, 4.0)
    found = navier.shear_plate_frequency(*ORDERS, SIZE, section)
    np.testing.assert_allclose(found, closed, rtol=1e-6)
    # to first order in I: ω²(1 + (I/m″) k² (1/(1 + Dk²/S))²), Rayleigh with the mode without I
    heavy = navier.shear_plate_frequency(
        *ORDERS, SIZE, dataclasses.replace(section, rotary_inertia=1e-3)
    )
    k2 = wave_number_squared()
    share = 1e-3 / 4.0 * k2 / (1 + 3273.07 * k2 / 2e5) ** 2
    np.testing.assert_allclose((closed / heavy) ** 2 - 1, share, rtol=0.02)


def test_a_section_is_aligned_where_nothing_couples():
    aligned = Given(ORTHOTROPIC, np.diag([3e6, 1e6]), 4.0, 1e-3)
    assert navier.is_aligned(aligned)
    # either sign of a coupling counts, and rounding of the largest stiffness does not
    for size, expected in ((1e-4, False), (-1e-4, False), (1e-13, True), (-1e-13, True)):
        twisted, sheared = ORTHOTROPIC.copy(), np.diag([3e6, 1e6])
        twisted[1, 2] = twisted[2, 1] = size * ORTHOTROPIC.max()
        sheared[0, 1] = sheared[1, 0] = size * sheared.max()
        assert navier.is_aligned(dataclasses.replace(aligned, bending=twisted)) is expected
        assert navier.is_aligned(dataclasses.replace(aligned, shear=sheared)) is expected
    sheared[0, 1] = sheared[1, 0] = 1e3
    with pytest.raises(ValueError, match="couple"):
        navier.shear_plate_frequency(1, 1, SIZE, dataclasses.replace(aligned, shear=sheared))


def test_sines_have_their_nodes_and_crests_in_a_panel_of_any_sides():
    # 2 by 3 half waves on 1.5 by 1.1 m
    place = np.array([[0.75, 0.2], [0.4, 1.1 / 3], [1.5, 1.0], [0.375, 1.1 / 6], [1.125, 1.1 / 2]])
    found = navier.sine_shapes([2], [3], (1.5, 1.1), place)[:, 0]
    np.testing.assert_allclose(found, [0, 0, 0, 1, 1], atol=1e-12)


def test_a_rigid_mode_has_an_infinite_half_wave_and_no_shift():
    section = ThinSection(3273.07, 4.0)
    assert resolution.half_wave(section, 0.0) == np.inf
    assert (
        resolution.ElementKind("thin quadrilaterals", section).frequency_shift(0.05, 0.0, 30.0)
        == 0.0
    )
