"""Standard errors carried to PSDs and rms values, against scenarios solved anew."""

import numpy as np
import pytest
from solving import panel_solver, solve_layout

from pidpanel.solve import uncertainty
from pidpanel.solve.layout import AttachedDamper, DamperLayout
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.solvers import Request

AREA, RATIO = 0.04, 0.02
FACTOR = 2.5  # S_p over the solver's
NODES = np.array([20.0, 60.0, 150.0, 300.0])


@pytest.fixture(scope="module")
def solvers():
    """A panel of two modes under white sound, heard beside its patch."""
    modes = np.array([65.0, 180.0])
    lines = frequency_grid(20.0, 300.0, RATIO, modes)
    basis = ModalBasis(modes, [1.5, 1.5], RATIO)
    patches = Patches(AREA * np.array([[[1.0, 0.6], [0.6, 0.5]]]), np.array([AREA]))
    points, force = np.array([[1.0, -0.4], [0.3, 1.0]]), np.array([[0.3, 0.1], [0.1, 0.2]])
    return {
        form: panel_solver(basis, patches, lines, points, force, is_diagonal=form == "diagonal")
        for form in ("full", "diagonal")
    }


@pytest.fixture(scope="module")
def solver(solvers):
    return solvers["full"]


def law(size, rise, fall, weight, lighter):
    """C_e = size (f/100)^rise Γ^−fall and m_a = weight − lighter ln Γ, altered over ln f."""

    def altered(log_damping=0.0, mass=0.0):
        def damping(frequency, level):
            x, at = np.log(frequency), np.log(NODES)
            change, more = (
                np.interp(x, at, np.broadcast_to(values, NODES.shape))
                for values in (log_damping, mass)
            )
            value = size * (frequency / 100) ** rise * level**-fall * np.exp(change)
            return value, weight - lighter * np.log(level) + more, np.ones(frequency.shape, bool)

        return damping

    return altered


moved, heavier = law(900, 0.5, 0.7, 2, 0.3), law(400, 0, 0.4, 5, 0.6)


def solve(solver, damping, stated=None):
    load = AttachedDamper(0, damping)
    return solve_layout(solver, [load], FACTOR, stated_acceleration_g=stated)


def answer(solver, damping, mass):
    (one,) = solver.responses([Request((0,), damping[None], mass[None], with_slope=True)])
    return one


@pytest.mark.parametrize("stated", [None, 3.0])
def test_derivatives_are_those_of_scenarios_solved_anew(solver, stated):
    found = solve(solver, moved(), stated)
    got = uncertainty.sensitivity(
        solver, DamperLayout([AttachedDamper(0, moved())], FACTOR, stated), found, NODES
    )
    step = 1e-3
    for number in range(8):
        change = step * np.eye(4)[number % 4]
        up, down = (
            solve(
                solver, moved(*((0, sign * change) if number > 3 else (sign * change, 0))), stated
            )
            for sign in (1, -1)
        )
        for of, derivative in (
            (lambda r: r.response.acceleration_rms, got.log_rms[number]),
            (lambda r: r.response.acceleration_psd, got.log_psd[number]),
            (lambda r: r.acceleration_g, got.log_acceleration[number]),
        ):
            anew = np.log(of(up) / of(down)) / (2 * step)
            # central differences over 5 %, squared; the search closes to 1e-6 over 2e-3
            np.testing.assert_allclose(derivative, anew, atol=0.01 * (0.05 + np.abs(anew).max()))


def test_a_mass_that_alone_depends_on_the_motion_is_followed_to_where_the_motion_ends(solver):
    # m_a = 2 − 1.5 ln Γ is straight in ln Γ, so that the step of 5 % errs by nothing
    def damping(log_change):
        def of_motion(frequency, level):
            value = 300 * np.exp(log_change) * np.ones_like(frequency)
            return value, (2 - 1.5 * np.log(level)) * np.ones_like(frequency), frequency > 0

        return of_motion

    step = 2e-3
    found = solve(solver, damping(0.0))
    got = uncertainty.sensitivity(
        solver, DamperLayout([AttachedDamper(0, damping(0.0))], FACTOR), found, NODES
    )
    up, down = (solve(solver, damping(sign * step)).response.acceleration_psd for sign in (1, -1))
    anew = np.log(up / down) / (2 * step)
    by_motion = got.log_acceleration[:4, 0].sum() * 1.5
    assert abs(by_motion) > 0.05  # the mass moves enough to be seen
    # the search closes to 1e-6 over 4e-3; the rest is the change of slope over the step
    np.testing.assert_allclose(got.log_psd[:4].sum(axis=0), anew, atol=2e-3 * np.abs(anew).max())


def scatter(root, answer):
    """Standard deviation of answers to changes of covariance root rootᵀ, from 2 n such changes.

    Each is one standard deviation along a column of the root, in either direction.
    """
    answers = [answer(sign * change) for change in root.T for sign in (1, -1)]
    return np.sqrt(root.shape[1]) * np.std(answers, axis=0)


def root_of_errors(rng):
    """Root of a covariance (8, 8) of ln C_e and m_a at the nodes."""
    return np.tril(rng.normal(size=(8, 8))) * np.array([0.03] * 4 + [0.05] * 4)[:, None]


# ------------------------------------------------------------------ several dampers


@pytest.fixture(scope="module")
def three():
    """Three modes under white sound, two patches that feel all of them."""
    modes = np.array([65.0, 120.0, 180.0])
    lines = frequency_grid(20.0, 300.0, RATIO, modes)
    root = np.array([[[1.0, 0.5, 0.2], [0.3, 0.8, -0.4]], [[0.4, -0.6, 0.9], [0.1, 0.5, 0.5]]])
    patches = Patches(AREA * root.swapaxes(1, 2) @ root, np.array([AREA, 0.5 * AREA]))
    force = np.array([[0.3, 0.1, 0.0], [0.1, 0.2, 0.05], [0.0, 0.05, 0.3]])
    basis = ModalBasis(modes, [1.5, 1.2, 1.5], RATIO)
    points = np.array([[1.0, -0.4, 0.2], [0.3, 1.0, -0.7]])
    return {
        form: panel_solver(basis, patches, lines, points, force, is_diagonal=form == "diagonal")
        for form in ("full", "diagonal")
    }


def loads_with(change, stays=False):
    """Two loads with a change (16,) of ln C_e and m_a at the nodes; the second without Γ or not."""
    one, two = change[:8], change[8:]
    second = heavier(two[:4], two[4:])
    if stays:
        return [
            AttachedDamper(0, moved(one[:4], one[4:])),
            AttachedDamper(1, lambda f, _level: second(f, 3.0), False),
        ]
    return [AttachedDamper(0, moved(one[:4], one[4:])), AttachedDamper(1, second)]


@pytest.mark.parametrize(("form", "stays"), [("full", False), ("diagonal", True)])
def test_derivatives_of_two_dampers_are_those_of_layouts_solved_anew(three, form, stays):
    # every Γ follows what is changed on either patch
    one, step = three[form], 1e-3
    loads = loads_with(np.zeros(16), stays)
    found = solve_layout(one, loads, FACTOR, with_slope=True)
    own = DamperLayout(loads, FACTOR).follows_motion
    got = uncertainty.sensitivity(one, DamperLayout(loads, FACTOR), found, NODES)
    assert got.log_acceleration.shape == (16, 2)
    for number in range(16):
        up, down = (
            solve_layout(one, loads_with(sign * step * np.eye(16)[number], stays), FACTOR)
            for sign in (1, -1)
        )
        for of, derivative in (
            (lambda r: r.response.acceleration_rms, got.log_rms[number]),
            (lambda r: r.response.acceleration_psd, got.log_psd[number]),
            (lambda r: r.acceleration_g[own], got.log_acceleration[number][own]),
        ):
            anew = np.log(of(up) / of(down)) / (2 * step)
            # the search closes to 1e-6 over 2e-3, and central differences over 5 % of Γ
            np.testing.assert_allclose(derivative, anew, atol=0.005 * (0.1 + np.abs(anew).max()))
    if stays:
        assert np.all(got.log_acceleration[:, 1] == 0)


def test_dead_weight_has_no_slope_in_its_damping(three):
    # ∂/∂ ln C_e at C_e = 0 is 0, its mass counts
    loads = [
        AttachedDamper(patch, lambda f, _level: (0 * f, 0 * f + 4.0, f > 0), False)
        for patch in (0, 1)
    ]
    found = solve_layout(three["full"], loads, FACTOR)
    got = uncertainty.sensitivity(three["full"], DamperLayout(loads, FACTOR), found, NODES)
    by_load = got.log_rms.reshape(2, 2, 4, 2)
    assert np.all(by_load[:, 0] == 0)
    assert np.all(np.abs(by_load[:, 1]).max(axis=(1, 2)) > 1e-3)
    heavier_by = 1e-4
    more = [
        AttachedDamper(
            load.patch, lambda f, _level: (0 * f, 0 * f + 4.0 + heavier_by, f > 0), False
        )
        for load in loads
    ]
    up = solve_layout(three["full"], more, FACTOR).response.acceleration_rms
    anew = np.log(up / found.response.acceleration_rms) / heavier_by
    np.testing.assert_allclose(by_load[:, 1].sum(axis=(0, 1)), anew, rtol=1e-2)


def test_damping_that_sets_in_with_the_motion_has_no_slope_where_there_is_none_below():
    # C_e is Γ^1.5 from an onset on that rises with f: 0 at the line that sets in within the step
    def damping(frequency, level):
        value = np.where(level > frequency / 100, level**1.5, 0.0)
        return value, 2 * np.log(level) + 0 * frequency, np.ones(frequency.shape, bool)

    lines, gamma = np.array([90.0, 100.0, 110.0]), np.array([1.0])
    of_damping, of_mass = uncertainty._with_motion([AttachedDamper(0, damping)], lines, gamma, [0])
    np.testing.assert_allclose(of_damping, [[1.5, 0, 0]])
    np.testing.assert_allclose(of_mass, [[2, 2, 2]])


def test_errors_of_one_damper_on_two_patches_add_up_and_those_of_two_dampers_do_not(three):
    def answer(change):
        response = solve_layout(three["full"], loads_with(change), FACTOR)
        return [*np.log(response.response.acceleration_rms), *np.log(response.acceleration_g)]

    root = root_of_errors(np.random.default_rng(5))
    own, none = root @ root.T, np.zeros((8, 8))
    loads = loads_with(np.zeros(16))
    found = solve_layout(three["full"], loads, FACTOR, with_slope=True)
    got = uncertainty.sensitivity(three["full"], DamperLayout(loads, FACTOR), found, NODES)
    errors = []
    for cross, changes in (
        (own, np.vstack([root, root])),
        (none, np.block([[root, none], [none, root]])),
    ):
        stated = got.standard_errors(np.block([[own, cross], [cross, own]]))
        errors.append([*stated.log_rms, *stated.log_acceleration])
        # what the linearisation leaves out
        np.testing.assert_allclose(scatter(changes, answer), errors[-1], rtol=0.005)
    assert np.max(np.abs(np.divide(*errors) - 1)) > 0.2
