"""The particles' own force on the panel: its modal forces, and a panel that only it moves."""

import numpy as np
import pytest

from pidpanel.response.solvers import DiagonalSolver, PanelInField, PanelSolver, Request
from pidpanel.response.source import force_psd, patch_integrals

SIDE = 0.2


def grid(panel, cells):
    """Vertices, cells and their areas over PID-1 and a strip beside it."""
    x, y = np.linspace(0.65, 1.05, 2 * cells + 1), np.linspace(0.40, 0.60, cells + 1)
    position = np.array([(a, b) for a in x for b in y])
    corner = np.array([i * (cells + 1) + j for i in range(2 * cells) for j in range(cells)])
    quads = corner[:, None] + np.array([0, cells + 1, cells + 2, 1])
    in_patch = position[quads].mean(axis=1)[:, 0] < 0.85
    area = np.full(len(quads), (SIDE / cells) ** 2)
    return panel.shape(position), quads, area, in_patch[None]


def exact(panel):
    node, weight = np.polynomial.legendre.leggauss(20)
    x, y = np.meshgrid(0.75 + SIDE / 2 * node, 0.5 + SIDE / 2 * node, indexing="ij")
    shape = panel.shape(np.stack([x.ravel(), y.ravel()], axis=1))
    return np.outer(weight, weight).ravel() * SIDE**2 / 4 @ shape


def test_integrals_over_a_patch_are_within_a_tenth_at_six_cells_a_wave(panel):
    # red: `.mean(axis=1)` → `.sum(axis=1)`; `cell_in_patch` left out
    integrals = patch_integrals(*grid(panel, 4))[0]
    # the trapezoid rule in x and y errs by h²k²/12 of what is integrated, here at most a wave
    # number of √(7² + (5·1.5)²) π/1.5 = 21.5 rad/m and h = 5 cm
    rest = np.abs(integrals - exact(panel))
    assert rest.max() < (0.05 * 21.5) ** 2 / 12 * np.abs(exact(panel)).max()
    finer = np.abs(patch_integrals(*grid(panel, 16))[0] - exact(panel))
    assert finer.max() < rest.max() / 12  # 16 but for rounding


def test_modal_forces_of_independent_cells_and_of_a_common_pressure(panel):
    # red: `integrals[:, None, :]` → `integrals[:, :, None]`; own and common exchanged
    rng = np.random.default_rng(1)
    node = np.linspace(-0.5, 0.5, 41)[:-1] + 0.0125
    x, y = np.meshgrid(0.75 + SIDE * node, 0.5 + SIDE * node, indexing="ij")
    shape = panel.shape(np.stack([x.ravel(), y.ravel()], axis=1))
    cell = SIDE**2 / len(shape)
    # a coupon of three cells whose mean pressure has the PSD 5 in all, of which 2 are shared
    common, own, area = 2.0, 3.0, 3 * cell
    pressure = np.sqrt(common) * rng.standard_normal((4000, 1)) + np.sqrt(
        3 * own
    ) * rng.standard_normal((4000, len(shape)))
    forces = pressure @ shape * cell
    expected = forces.T @ forces / 4000
    found = force_psd(
        np.array([[common]]),
        np.array([[own * area]]),
        exact(panel)[None],
        panel.overlap((0.75, 0.5))[None],
    )[0]
    # 4000 draws know a variance to 2.2 %; the middle of cells of 5 mm to 0.2 %
    assert np.abs(found - expected).max() < 0.1 * np.abs(expected).max()
    assert np.diag(found) == pytest.approx(np.diag(expected), rel=0.1, abs=1e-3 * found.max())


@pytest.mark.parametrize("kind", [PanelSolver, DiagonalSolver])
def test_a_solver_in_another_field_keeps_the_bare_panel_of_its_own(panel, kind):
    # red: `type(self)(panel,` → `type(self)(self.panel,` in in_field; no bare_acceleration_rms
    frequency = np.geomspace(40.0, 600.0, 30)

    def field(size):
        force = size * np.outer(exact(panel), exact(panel))
        return PanelInField(panel.basis, panel.patches, lambda f: np.full(f.shape, 7.0), force)

    solver = kind(field(1.0), frequency, panel.points, frequency)
    louder = solver.in_field(field(3.0))
    ask = [Request((0,), np.full((1, 30), 500.0), np.full((1, 30), 2.0))]
    one, other = (of.responses(ask)[0].response.acceleration_psd for of in (solver, louder))
    assert other == pytest.approx(3 * one)
    assert louder.bare_acceleration_rms == pytest.approx(solver.bare_acceleration_rms)
