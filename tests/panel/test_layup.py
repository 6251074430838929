"""Truths of sandwich sections: hand formulas, rotations, and what symmetry forbids."""

import numpy as np
import pytest

from pidpanel.panel.section import Core, Material, Ply, SandwichSection

# the sandwich of the closed forms: 0.3 mm isotropic faces on a 24.4 mm core
FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
CORE = Core(186e6, 90e6, 32.0, 24.4e-3)
SANDWICH = SandwichSection((FACE,), (FACE,), CORE)
# a carbon tape: E1, E2, G12 and nu12 of a high-modulus unidirectional ply
TAPE = Material(E1=300e9, E2=6e9, G12=4.5e9, nu12=0.3, density=1600.0)


def laminate(*degrees):
    return tuple(Ply(TAPE, 0.1e-3, np.radians(angle)) for angle in degrees)


def test_isotropic_faces_give_the_hand_formulas():
    E, nu, t, d = 60e9, 0.3, 0.3e-3, 24.7e-3
    D = E / (1 - nu**2) * (t * d**2 / 2 + t**3 / 6)
    matrix = D * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    np.testing.assert_allclose(SANDWICH.bending, matrix, rtol=1e-12, atol=1e-9)
    assert pytest.approx(6034.15, rel=1e-6) == D
    np.testing.assert_allclose(np.diag(SANDWICH.shear), [4.6507e6, 2.2503e6], rtol=2e-5)
    assert SANDWICH.mass_per_area == pytest.approx(1.7408, rel=1e-12)
    assert SANDWICH.rotary_inertia == pytest.approx(1.8517e-4, rel=2e-5)


def test_a_ply_turned_by_45_degrees_is_the_textbooks():
    # Jones, eq. 2.84: Q11' = Q22' = (Q11 + Q22 + 2 Q12 + 4 Q66)/4, Q66' = (Q11 + Q22 - 2 Q12)/4,
    # Q16' = Q26' = (Q11 - Q22)/4
    Q = TAPE.stiffness
    q11, q22, q12, q66 = Q[0, 0], Q[1, 1], Q[0, 1], Q[2, 2]
    assert q11 == pytest.approx(300e9 / (1 - 0.09 * 6 / 300))
    turned = Ply(TAPE, 1.0, np.pi / 4).stiffness
    along = (q11 + q22 + 2 * q12 + 4 * q66) / 4
    expected = np.array([[along, along - 2 * q66, 0], [along - 2 * q66, along, 0], [0, 0, 0]])
    expected += (q11 - q22) / 4 * np.array([[0, 0, 1], [0, 0, 1], [1, 1, 0]])
    expected[2, 2] = (q11 + q22 - 2 * q12) / 4
    np.testing.assert_allclose(turned, expected, rtol=1e-12, atol=1.0)


def test_fibres_across_change_x_for_y():
    swap = np.ix_([1, 0, 2], [1, 0, 2])
    along = SandwichSection(laminate(0), laminate(0), CORE)
    across = SandwichSection(laminate(90), laminate(90), CORE)
    np.testing.assert_allclose(across.bending, along.bending[swap], rtol=1e-12, atol=1e-6)


def test_quasi_isotropic_faces_stretch_alike_in_every_direction():
    faces = laminate(0, 60, -60)
    A, _, _ = SandwichSection(faces, faces, CORE).abd
    assert A[0, 0] == pytest.approx(A[1, 1], rel=1e-12)
    assert A[2, 2] == pytest.approx((A[0, 0] - A[0, 1]) / 2, rel=1e-12)
    # shear does not couple to stretch: rounding of 1e8 N/m
    np.testing.assert_allclose(A[:2, 2], 0, atol=1e-6)


def test_mirrored_faces_do_not_couple_bending_and_stretch():
    faces = laminate(0, 45, 90)
    _, B, D = SandwichSection(faces, faces, CORE).abd
    np.testing.assert_allclose(B, 0, atol=1e-12 * D.max() / 0.025)


def test_two_different_isotropic_faces_bend_about_their_common_centroid():
    # classical: faces E1 t1 and E2 t2 apart by d bend with E1 t1 E2 t2 d^2 / (E1 t1 + E2 t2),
    # here with one Poisson's ratio, plus their own bending
    nu = 0.3
    thick = Ply(Material.isotropic(70e9, nu, 2700.0), 0.6e-3)
    section = SandwichSection((thick,), (FACE,), CORE)
    k1, k2 = 70e9 * 0.6e-3, 60e9 * 0.3e-3
    d = 24.4e-3 + 0.45e-3
    D = (k1 * k2 / (k1 + k2) * d**2 + (70e9 * 0.6e-3**3 + 60e9 * 0.3e-3**3) / 12) / (1 - nu**2)
    assert section.bending[0, 0] == pytest.approx(D, rel=1e-12)
    assert section.bending[0, 1] == pytest.approx(nu * D, rel=1e-12)
    # the neutral plane lies k2 d / (k1 + k2) below the middle of the top face
    above = k2 * d / (k1 + k2) + 0.3e-3
    assert section.layers[0].strain[0, 0] == pytest.approx(above, rel=1e-12)


@pytest.mark.parametrize("degrees", [0, 30, 90])
def test_core_shear_turns_with_the_ribbon(degrees):
    angle = np.radians(degrees)
    turned = SandwichSection((FACE,), (FACE,), Core(186e6, 90e6, 32.0, 24.4e-3, angle)).shear
    direction = np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(turned @ direction, SANDWICH.shear[0, 0] * direction, rtol=1e-12)
    assert np.trace(turned) == pytest.approx(np.trace(SANDWICH.shear), rel=1e-12)


def test_stresses_of_the_plies_add_up_to_the_moment():
    section = SandwichSection(laminate(0, 45, 90), laminate(90, 0), CORE, 0.5)
    kappa = np.array([0.3, -0.1, 0.2])
    A, B, _ = section.abd
    neutral = np.linalg.solve(A, B) @ kappa
    moment, force = np.zeros(3), np.zeros(3)
    for _, ply, outer, inner in section.placed:
        z = np.linspace(min(outer, inner), max(outer, inner), 3)
        stress = ply.stiffness @ (z * kappa[:, None] - neutral[:, None])
        simpson = ply.thickness / 6 * np.array([1, 4, 1])  # exact: stress is linear in z
        moment += stress @ (simpson * z)
        force += stress @ simpson
    np.testing.assert_allclose(moment, section.bending @ kappa, rtol=1e-10)
    np.testing.assert_allclose(force, 0, atol=1e-10 * np.abs(A @ kappa).max())
    # and the layers' own numbers are those of the fibre axes
    layer, (_, ply, outer, _) = section.layers[1], section.placed[1]
    strain = outer * kappa - neutral
    np.testing.assert_allclose(layer.strain @ kappa, ply.strain_in_fibre_axes @ strain)
    turned_back = ply.strain_in_fibre_axes.T @ (layer.stress @ kappa)
    np.testing.assert_allclose(turned_back, ply.stiffness @ strain, rtol=1e-10)


def test_core_stress_times_the_distance_of_the_faces_is_the_shear_force():
    np.testing.assert_allclose(SANDWICH.core_stress * 24.7e-3, SANDWICH.shear, rtol=1e-12)


def test_layers_are_named_from_the_outside():
    section = SandwichSection(laminate(0, 45), (FACE,), CORE)
    assert [layer.name for layer in section.layers] == ["top ply 1", "top ply 2", "bottom"]
