"""Panels from arrays, and single layouts on them."""

import numpy as np

from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import DamperLayout, solve_with
from pidpanel.solve.model import UnstableDamping
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.solvers import PanelSolver


def air_resistance(frequency, diffuse, sides=1):
    """R = sides ρ₀ω²/(2πc₀) G of air of 1.2 kg/m³ and 343 m/s."""
    omega = 2 * np.pi * frequency[:, None, None]
    return sides * 1.2 * omega**2 / (2 * np.pi * 343.0) * diffuse


def white(frequency):
    return np.ones(frequency.size)


def panel_solver(basis, patches, lines, points, force, spectrum=white, search=None, **more):
    """A solver; the lines of the search are those of the result unless they are given."""
    search = lines if search is None else search
    panel = ModalPanel(basis, patches, lines, np.asarray(points), search, **more)
    return PanelSolver(panel, ModalForce(spectrum, force))


def solve_layout(solver, loads, factor=1.0, **more):
    """The response to one layout, or its error."""
    (answer,) = solve_with(solver, [DamperLayout(tuple(loads), factor, **more)])
    if isinstance(answer, UnstableDamping):
        raise answer
    return answer


def solve_bare(solver, factor=1.0):
    return solve_layout(solver, (), factor)
