"""The particles' own force on the panel: its modal forces, and a panel that only it moves."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.integrate
from solving import panel_solver, solve_layout

from pidpanel.solve.excitation import ModalForce, Superposition
from pidpanel.solve.layout import AttachedDamper
from pidpanel.solve.solvers import Request
from pidpanel.solve.source import (
    PatchParts,
    elements_of_patch,
    interpolated_load,
    mean_coherence,
    own_force_load,
    particle_force,
)

SIDE = 0.2


def elements(panel, count):
    """Elements of PID-1, of a strip of which the other half is not part of it."""
    x, y = np.linspace(0.45, 0.85, 2 * count + 1), np.linspace(0.40, 0.60, count + 1)
    position = np.array([(a, b) for a in x for b in y])
    corner = np.array([i * (count + 1) + j for i in range(2 * count) for j in range(count)])
    quads = corner[:, None] + np.array([0, count + 1, count + 2, 1])
    inside = position[quads].mean(axis=1)[:, 0] > 0.65
    face = SimpleNamespace(
        vertex_position=position, cells=quads, shape_at_vertices=panel.shape(position)
    )
    return elements_of_patch(face, inside)


def exact(panel):
    """∫ φ dA over PID-1."""
    node, weight = np.polynomial.legendre.leggauss(20)
    x, y = np.meshgrid(0.75 + SIDE / 2 * node, 0.5 + SIDE / 2 * node, indexing="ij")
    shape = panel.shape(np.stack([x.ravel(), y.ravel()], axis=1))
    return np.outer(weight, weight).ravel() * SIDE**2 / 4 @ shape


def test_integrals_over_a_patch_are_within_a_tenth_at_six_elements_a_wave(panel):
    parts = elements(panel, 4)
    assert parts.area.sum() == pytest.approx(SIDE**2)
    # the trapezoid rule in x and y errs by h²k²/12 of what is integrated, here at most a wave
    # number of √(7² + (5·1.5)²) π/1.5 = 21.5 rad/m and h = 5 cm
    rest = np.abs(parts.area @ parts.shape - exact(panel))
    assert rest.max() < (0.05 * 21.5) ** 2 / 12 * np.abs(exact(panel)).max()
    fine = elements(panel, 16)
    finer = np.abs(fine.area @ fine.shape - exact(panel))
    assert finer.max() < rest.max() / 12  # 16 but for rounding
    # and the middles are those of the patch
    assert fine.area @ fine.position / SIDE**2 == pytest.approx([0.75, 0.5])


def test_a_force_with_the_same_value_everywhere_acts_as_a_pressure(panel):
    parts = elements(panel, 16)
    integral = parts.area @ parts.shape
    found = parts.coherent_load(1e6)
    wanted = np.outer(integral, integral)
    assert np.abs(found - wanted).max() < 1e-5 * np.abs(wanted).max()
    # against the integral itself: the parts leave h²k²/12 = 0.6 %
    size = np.outer(exact(panel), exact(panel))
    assert np.abs(found - size).max() < 0.01 * np.abs(size).max()


def test_a_force_of_short_coherence_acts_as_independent_areas(panel):
    # 2π l² D; a part of 12.5 mm loses about 2 l/side at its edges, and h²k²/12 as above
    length = 1e-4
    found = elements(panel, 16).coherent_load(length)
    wanted = 2 * np.pi * length**2 * panel.overlap((0.75, 0.5))
    assert np.abs(found - wanted).max() < 0.03 * np.abs(wanted).max()


@pytest.mark.parametrize("per_part", [0.1, 0.2, 0.5, 1.0, 4.0])
def test_the_load_of_a_patch_does_not_depend_on_its_parts(per_part):
    # ∬ exp(−d/l) of a square in 8 × 8 parts is its own mean coherence, to 0.3 % by quadrature
    middle = (np.arange(8) + 0.5) * SIDE / 8
    place = np.array([(x, y) for x in middle for y in middle])
    parts = PatchParts(np.ones((64, 1)), np.full(64, SIDE**2 / 64), place)
    length = per_part * SIDE / 8
    found = parts.coherent_load(length)[0, 0] / SIDE**4
    assert found == pytest.approx(float(mean_coherence(SIDE, length)), rel=4e-3)


def test_two_parts_share_the_mean_coherence_of_their_points():
    # by Gauss' rule in all four coordinates
    side, length = 0.1, 0.15
    place = np.array([[0.0, 0.0], [0.25, 0.12]])
    parts = PatchParts(np.eye(2), np.full(2, side**2), place)
    node, weight = np.polynomial.legendre.leggauss(8)
    x, y = np.meshgrid(side / 2 * node, side / 2 * node)
    inside = np.stack([x.ravel(), y.ravel()], axis=1)
    distance = np.linalg.norm(place[1] - place[0] + inside[:, None] - inside, axis=2)
    w = np.outer(weight, weight).ravel() * side**2 / 4
    wanted = w @ np.exp(-distance / length) @ w
    found = parts.coherent_load(length)
    np.testing.assert_allclose([found[0, 1], found[1, 0]], wanted, rtol=1e-4)


def test_the_own_force_is_coherent_in_part_and_independent_in_the_rest():
    # a patch of 0.2 m: far below λ/f all of it moves alike, far above it areas of 2π (λ/f)² do
    parts = PatchParts(np.ones((1, 1)), np.array([0.04]), np.zeros((1, 2)))
    frequency, coherence, length = np.array([1e-5, 1000.0]), np.array([0.25, 0.75]), 2.0
    found = own_force_load(parts, np.array([[0.002]]), frequency, coherence, length).ravel()
    far = 2 * np.pi * 0.01**2 - 16 * 0.01**3  # of sides of a hundred lengths
    wanted = [0.25 * 0.04**2 + 0.75 * 0.002, 0.75 * far * 0.04**2 + 0.25 * 0.002]
    np.testing.assert_allclose(found, wanted, rtol=1e-4)


def test_a_second_excitation_keeps_its_level_whatever_that_of_the_first():
    # G₁ + share S₂ G₂/S₁, and G₁ where S₁ is none
    f, G = np.array([1.0, 2.0, 3.0]), np.array([[2.0]])
    first = ModalForce(lambda f: np.array([0.5, 2.0, 0.0]), np.array([[7.0]]))
    second = ModalForce(lambda f: np.full(f.shape, 3.0), G)
    for share, found in ((1.0, Superposition(first, second)),
                         (0.5, Superposition(first, second, 0.5))):  # fmt: skip
        np.testing.assert_allclose(found(f).ravel(), 7 + share * np.array([12.0, 3.0, 0.0]))


@pytest.mark.parametrize("ratio", [0.01, 0.3, 1.0, 7.0, 60.0])
def test_mean_coherence_is_that_of_the_distance_of_two_points(ratio):
    # with the density of that distance (Ghosh 1951)
    def density(d):
        if d <= 1:
            return 2 * d * (np.pi - 4 * d + d**2)
        root = np.sqrt(d**2 - 1)
        return 2 * d * (4 * root - (d**2 + 2 - np.pi) - 4 * np.arctan(root))

    wanted, _ = scipy.integrate.quad(
        lambda d: np.exp(-ratio * d) * density(d), 0, np.sqrt(2), points=[1.0 / ratio, 1.0]
    )
    assert float(mean_coherence(ratio, 1.0)) == pytest.approx(wanted, rel=1e-5)


def test_loads_between_nodes_are_linear_over_the_logarithm():
    # and held beyond
    nodes, load = np.array([100.0, 400.0, 800.0]), np.array([1.0, 3.0, 7.0])[:, None, None]
    frequency = np.array([50.0, 100.0, 200.0, 400.0, 400 * np.sqrt(2), 800.0, 2000.0])
    wanted = [1.0, 1.0, 2.0, 3.0, 5.0, 7.0, 7.0]
    values = interpolated_load(frequency, nodes, load * np.eye(2))
    assert values[:, 0, 0] == pytest.approx(wanted)
    assert not values[:, 0, 1].any()
    # a single node holds everywhere
    alone = interpolated_load(frequency[:3], nodes[:1], load[:1])
    assert alone.ravel() == pytest.approx([1.0] * 3)


@pytest.mark.parametrize("is_diagonal", [False, True])
def test_a_solver_under_another_excitation_keeps_the_bare_panel_of_its_own(panel, is_diagonal):
    frequency = np.geomspace(40.0, 600.0, 30)
    force = np.outer(exact(panel), exact(panel))

    def spectrum(f):
        return np.full(f.shape, 7.0)

    solver = panel_solver(
        panel.basis, panel.patches, frequency, panel.points, force, spectrum,
        is_diagonal=is_diagonal,
    )  # fmt: skip
    louder = solver.with_excitation(ModalForce(spectrum, 3 * force))
    dampers = [Request((0,), np.full((1, 30), 500.0), np.full((1, 30), 2.0))]
    quiet, loud = (of.responses(dampers)[0].acceleration_psd for of in (solver, louder))
    assert loud == pytest.approx(3 * quiet)
    assert louder.bare_acceleration_rms == pytest.approx(solver.bare_acceleration_rms)


def test_a_force_beside_the_excitation_adds_its_own_response_whatever_the_level(panel):
    frequency = np.geomspace(40.0, 600.0, 30)
    force, other = np.outer(exact(panel), exact(panel)), np.diag(exact(panel) ** 2)
    inputs = (panel.basis, panel.patches, frequency, panel.points)
    solver = panel_solver(*inputs, force, lambda f: 1e3 / f)
    particles = particle_force(np.array([30.0, 700.0]), np.stack([other, other]))
    load = AttachedDamper(0, lambda f, _gamma: (0 * f + 500.0, 0 * f + 2.0, f > 0), False)
    whole, sound, alone = (
        solve_layout(of, [load], factor, force=beside).response.acceleration_psd
        for of, factor, beside in (
            (solver, 2.5, particles),
            (solver, 2.5, None),
            (panel_solver(*inputs, other), 1.0, None),
        )
    )
    np.testing.assert_allclose(whole, sound + alone, rtol=1e-9)
