"""What a solver keeps between layouts: as much as fits, and no more."""

import numpy as np
import pytest
from solving import white

from pidpanel.solve import solvers
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.solvers import PanelSolver, Request

F = np.geomspace(40.0, 600.0, 30)


class Counted:
    """Matrices over frequency that count the lines they are asked for."""

    def __init__(self, matrix):
        self.matrix, self.asked = matrix, 0

    def __call__(self, frequency):
        self.asked += frequency.size
        return np.broadcast_to(self.matrix, (frequency.size, *self.matrix.shape)).copy()


def solver_of(panel, patches, in_air=False):
    n = len(panel.modes)
    force = Counted(np.eye(n))
    air = Counted(np.zeros((n, n), complex)) if in_air else None
    modal = ModalPanel(panel.basis, patches, F, panel.points, F, air)
    return PanelSolver(modal, ModalForce(white, force)), force


def ask(solver):
    dampers = np.full((1, F.size), 500.0), np.full((1, F.size), 2.0)
    (answer,) = solver.responses([Request((0,), *dampers)])
    return answer.acceleration_psd


@pytest.mark.parametrize("short", [0, 1])
@pytest.mark.parametrize("in_air", [False, True])
def test_matrices_of_direct_solves_that_fit_are_asked_for_once(panel, monkeypatch, in_air, short):
    # a patch on the whole panel is solved directly; 8 bytes of G and 16 of the air on every line
    # red: 9 or 25 bytes; kept where they do not fit; never solved directly
    n = len(panel.modes)
    whole = Patches(np.eye(n)[None], np.ones(1))
    solver, force = solver_of(panel, whole, in_air)
    monkeypatch.setattr(solvers, "KEPT_BYTES", F.size * n**2 * (24 if in_air else 8) - short)
    np.testing.assert_array_equal(ask(solver), ask(solver))
    assert force.asked == F.size * (1 + short)


def test_a_bare_panel_is_kept_where_its_arrays_fit(panel, monkeypatch):
    # red: the size of one line over the lines
    at_middle = panel.points[0]
    patches = Patches(0.01 * np.outer(at_middle, at_middle)[None], np.array([0.01]))
    solver, force = solver_of(panel, patches)
    ask(solver)
    parts = solver._kept.values()
    size = sum(p.receptance.nbytes + p.patch_psd.nbytes + p.point_psd.nbytes for p in parts)
    for short in (0, 1):
        monkeypatch.setattr(solvers, "KEPT_BYTES", size - short)
        solver, force = solver_of(panel, patches)
        np.testing.assert_array_equal(ask(solver), ask(solver))
        assert force.asked == F.size * (1 + short)
