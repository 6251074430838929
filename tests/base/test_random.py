"""Random motion of the supports: an oscillator, the solver against transfer functions."""

from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from moving import (
    APPARENT,
    CARRIED,
    DAMPING,
    LEVEL,
    NATURAL,
    WHITE,
    ZETA,
    oscillator,
    solved,
)

from pidpanel.base import random
from pidpanel.base.random import force_slopes, interface_force_psd
from pidpanel.damping.broadband import BroadbandError
from pidpanel.response.cases import SolvedCase
from pidpanel.solve.base_motion import TABLE_MASS, BaseExcitation
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import AttachedDamper, DamperLayout, layouts, solve_with
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.uncertainty import StandardErrors


def test_the_own_force_of_particles_reaches_the_supports_through_the_spring():
    frequency, own, (damping, mass) = np.array([0.05, 20.0, 45.0, 300.0]), 7.0, (90.0, 0.4)
    basis = ModalBasis([NATURAL, 0.0], [CARRIED, TABLE_MASS * CARRIED], [ZETA, ZETA])
    excitation = BaseExcitation(
        lambda f: np.full(f.shape, LEVEL), np.array([-CARRIED, TABLE_MASS * CARRIED])
    )
    points = np.zeros((2, 2, 2))
    points[0], points[1] = [[1, 1], [1, 0]], [[CARRIED, CARRIED], [1, 1]]
    solver = PanelSolver(
        ModalPanel(basis, Patches(np.ones((1, 2, 2)), [1.0]), frequency, points, frequency),
        excitation,
    )
    load = AttachedDamper(0, lambda f, _gamma: (0 * f + damping, 0 * f + mass, f > 0), False)
    force = ModalForce(lambda f: np.ones(f.shape), own * np.ones((2, 2)))
    layout = DamperLayout((load,), force=force)
    (answer,) = solve_with(solver, [layout])
    none = SolvedCase(*[None] * len(fields(SolvedCase)))
    coupled = SimpleNamespace(is_coupled=True)
    case = replace(none, solver=solver, layout=layout, dampers=(), scenario=coupled)
    made = random._response(case, answer)
    omega = 2 * np.pi * frequency
    stiffness, dashpot = (
        CARRIED * (2 * np.pi * NATURAL) ** 2,
        2 * ZETA * CARRIED * 2 * np.pi * NATURAL,
    )
    spring = stiffness + 1j * omega * dashpot
    moved = spring + 1j * omega * damping - omega**2 * (CARRIED + mass)
    own_part = own * np.abs(spring / moved) ** 2
    np.testing.assert_allclose(
        made.force, oscillator(frequency, damping, mass)[2] + own_part, rtol=1e-6
    )


def test_a_damper_is_fixed_to_the_sky_and_its_mass_to_the_panel():
    frequency, C, m = np.array([3.0, 30.0, 45.0, 60.0, 400.0]), 40.0, 0.5
    omega = 2 * np.pi * frequency
    k, c = CARRIED * (2 * np.pi * NATURAL) ** 2, 2 * ZETA * CARRIED * 2 * np.pi * NATURAL
    link = k + 1j * omega * c
    ratio = link / (link - omega**2 * (CARRIED + m) + 1j * omega * C)
    absolute, _, force = oscillator(frequency, C, m)
    np.testing.assert_allclose(absolute, LEVEL * np.abs(ratio) ** 2, rtol=1e-6)
    whole = ((CARRIED + m) + C / (1j * omega)) * ratio
    np.testing.assert_allclose(force, LEVEL * np.abs(whole) ** 2, rtol=1e-6)


@pytest.mark.parametrize("loaded", [False, True])
def test_the_solver_agrees_with_transfer_functions(panel, loaded):
    frequency = np.array([30.0, 65.0, 130.0, 224.0, 390.0])
    modal = ModalPanel(panel.modal, panel.patches, frequency, panel.observed, frequency)
    load = AttachedDamper(0, lambda f, _gamma: (0 * f + DAMPING, 0 * f + APPARENT, f > 0), False)
    (answer,) = layouts(modal, panel.excitation, [DamperLayout((load,) if loaded else ())])
    motion, force, _ = solved(panel, frequency, *((DAMPING, APPARENT) if loaded else ()))
    psd = np.einsum("fpii->fpi", answer.response.cross_psd).real
    np.testing.assert_allclose(psd, WHITE * np.abs(motion) ** 2, rtol=1e-5)
    pulled = interface_force_psd(answer, answer.response.cross_psd[:, -1])
    np.testing.assert_allclose(pulled, WHITE * np.abs(force) ** 2, rtol=1e-5)


def test_the_slopes_of_the_force_are_those_of_the_solver(panel):
    frequency = np.array([30.0, 65.0, 130.0, 224.0, 390.0])
    modal = ModalPanel(panel.modal, panel.patches, frequency, panel.observed, frequency)
    solver = PanelSolver(modal, panel.excitation)

    def answer(damping, mass):
        load = AttachedDamper(0, lambda f, _gamma: (0 * f + damping, 0 * f + mass, f > 0), False)
        (response,) = layouts(modal, panel.excitation, [DamperLayout((load,))])
        return response, interface_force_psd(response, response.response.cross_psd[:, -1])

    response, psd = answer(DAMPING, APPARENT)
    slopes = force_slopes(solver, response, psd)
    h = 1e-3
    up, down = answer(DAMPING * np.exp(h), APPARENT)[1], answer(DAMPING * np.exp(-h), APPARENT)[1]
    np.testing.assert_allclose(slopes.of_damping[0, :, 0], np.log(up / down) / (2 * h), atol=1e-4)
    up, down = answer(DAMPING, APPARENT + h)[1], answer(DAMPING, APPARENT - h)[1]
    np.testing.assert_allclose(slopes.of_mass[0, :, 0], np.log(up / down) / (2 * h), atol=1e-4)
    assert np.abs(slopes.of_damping).max() > 0.1


LINES = np.array([10.0, 20.0])


def made_up(square, inside=None, loads=(), stiffness=(0.0, 0.0), is_coupled=False):
    """A case whose points and momenta have a matrix of cross-PSDs (3, 3) on two lines."""
    cross = np.zeros((2, 3, 3, 3), np.complex128)
    cross[:] = square
    C, m = (np.full((len(loads), 2), value) for value in stiffness)
    answer = SimpleNamespace(
        response=SimpleNamespace(frequency=LINES, cross_psd=cross),
        inside=np.zeros((0, 2), bool) if inside is None else inside,
        patches=np.array(loads, int), equivalent_damping=C, apparent_mass=m,
        patch_acceleration_g=np.zeros(len(loads)),
    )  # fmt: skip
    excitation = SimpleNamespace(spectrum=lambda f: 3 * f)
    solver = SimpleNamespace(excitation=excitation)
    layout = DamperLayout(())
    return SimpleNamespace(
        solver=solver, scenario=SimpleNamespace(is_coupled=is_coupled), dampers=loads, layout=layout
    ), answer


def test_a_response_has_accelerations_deflections_and_the_force_of_its_patches():
    square = np.diag([2.0, 5.0, 7.0])
    inside = np.array([[True, True], [True, False]])
    case, answer = made_up(square, inside, (0, 1), (3.0, 0.5), is_coupled=True)
    made = random._response(case, answer)
    omega = np.array([62.83185307, 125.66370614])
    np.testing.assert_allclose(made.input, [30, 60])
    np.testing.assert_allclose(made.absolute, 2 * np.outer(omega**4, [1, 1]), rtol=1e-6)
    np.testing.assert_allclose(made.relative, np.full((2, 2), 5.0))
    pull = np.abs(3j * omega - 0.5 * omega**2) ** 2
    np.testing.assert_allclose(made.force, 2 * omega**4 + (5 + 7) * pull, rtol=1e-6)
    assert made.outside_share == 0.5 and made.errors is None
    assert random._response(*made_up(square)).outside_share == 0


def test_errors_of_coupled_runs_are_of_points_alone():
    errors = random._of_points(StandardErrors(np.ones((2, 3)), np.ones(3), np.ones(1)))
    np.testing.assert_array_equal(errors.log_psd, [[1, 1, 1, np.nan]] * 2)
    np.testing.assert_array_equal(errors.log_rms, [1, 1, 1, np.nan])


@pytest.mark.parametrize("dead", [False, True])
def test_errors_of_the_force_are_in_place_of_its_momentum_with_those_of_the_model(
    monkeypatch, dead
):
    # a force of which damping takes 3/4 of the PSD, half of the rms value
    stated = StandardErrors(np.array([[1.0, 2, 3, 4, 5]] * 2), np.arange(1.0, 6), np.ones(1))
    model = StandardErrors(np.zeros((2, 4)), np.zeros(4), np.zeros(1))
    monkeypatch.setattr(random, "error_parts", lambda *_: (stated, None))
    monkeypatch.setattr(random, "force_slopes", lambda *_: None)
    monkeypatch.setattr(random, "model_error_of", lambda *_: model)
    monkeypatch.setattr(random, "broadband_error_of", lambda _: BroadbandError(4 / np.log(2), 3.0))
    momentum = np.diag([2.0, 5.0, 7.0])
    case, answer = made_up(momentum, loads=(0,))
    _, case.bare = made_up(momentum * (0.1 if dead else 1))
    case.dead_weight = made_up(momentum)[1] if dead else None
    undamped = 2 * (2 * np.pi * LINES) ** 4
    errors = random._errors(case, answer, undamped / 4)
    np.testing.assert_allclose(errors.log_psd[:, :3], [[1, 2, 3]] * 2)
    np.testing.assert_allclose(errors.log_psd[:, 3], np.hypot(5, np.hypot(8, 6)))
    np.testing.assert_allclose(errors.log_rms, [1, 2, 3, np.hypot(5, 5)])
    case.scenario.is_coupled = True
    assert random._errors(case, answer, undamped / 4) is None
    case.scenario.is_coupled, case.dampers = False, ()
    assert random._errors(case, answer, undamped) is None


def test_errors_of_coupled_runs_are_those_of_their_own_cases(monkeypatch):
    none = SolvedCase(*[None] * len(fields(SolvedCase)))
    cases = [replace(none, scenario=SimpleNamespace(label=label)) for label in "ab"]
    plan = SimpleNamespace(solve=lambda _: cases)
    monkeypatch.setattr(random, "plan_cases", lambda *_: plan)
    empty = random.RandomResponse(*[np.zeros((2, 1))] * 4, None, 0.0)
    monkeypatch.setattr(random, "_response", lambda *_: empty)
    panel = SimpleNamespace(
        solver=lambda: SimpleNamespace(with_lines=lambda *_: None), frequency=LINES
    )
    errors = {"a": StandardErrors(np.ones((2, 1)), np.ones(1), np.ones(1))}
    # of the point and, last, of the base
    inputs = StandardErrors(np.full((2, 2), 0.75), np.full(2, 0.75), np.zeros(1))
    monkeypatch.setattr(random, "error_parts", lambda *_: (None, inputs))
    made = random.random_cases(panel, np.zeros(0), [], [], errors)
    assert [case.stated.errors is None for case in made] == [False, True]
    np.testing.assert_array_equal(made[0].stated.errors.log_rms, [1.25, np.nan])
