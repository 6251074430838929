"""The panel in air from few factorisations, held to a solve of every line."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.in_air import NODES, PanelInAir, SmoothStiffness
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import bare_panels, dense_stiffness
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.added_mass import tabulate_added_mass
from pidpanel.sound.face import PanelQuadrature
from pidpanel.sound.field import tabulate_diffuse
from pidpanel.sound.radiation import Air

A, B = 0.8, 0.5
HIGHEST = 1500.0


@pytest.fixture(scope="module")
def panel():
    """Sines on a thin plate of 3 kg/m² in air, 56 of them, to more than twice the range."""
    at = [((np.arange(60) + 0.5) / 60 * side) for side in (A, B)]
    x, y = (one.ravel() for one in np.meshgrid(*at, indexing="ij"))
    order = np.array([(m, n) for m in range(1, 9) for n in range(1, 8)])
    shapes = np.sin(np.pi * np.outer(x, order[:, 0]) / A) * np.sin(
        np.pi * np.outer(y, order[:, 1]) / B
    )
    frequency = 9.0 * ((order[:, 0] / A) ** 2 + (order[:, 1] / B) ** 2)
    rank = np.argsort(frequency)
    quadrature = PanelQuadrature(
        np.stack([x, y], axis=1), np.full(x.size, A * B / x.size), shapes[:, rank]
    )
    basis = ModalBasis(frequency[rank], np.full(rank.size, 3.0 * A * B / 4), 0.01)
    k_max = 2 * np.pi * HIGHEST / 343.0
    air = Air(
        1.2, 343.0, 2, tabulate_diffuse(k_max, quadrature), tabulate_added_mass(k_max, quadrature)
    )
    observed = shapes[[700, 1711], :][:, rank].T * [1.0, 1e4]  # of columns in other units too
    return basis, air, observed


@dataclass
class Counted:
    """Air that counts the frequencies it is asked for."""

    air: Callable[[Array], Complexes]
    travel_time: float
    asked: int = 0

    def __call__(self, frequency):
        self.asked += frequency.size
        return self.air(frequency)


def line_by_line(frequency, basis, air, observed):
    return np.linalg.solve(dense_stiffness(frequency, basis, air(frequency)), observed[None])


def receptance(motion, observed):
    """WᵀZ₀⁻¹W (nf, nw, nw), each in parts of its own two diagonal values."""
    found = observed.T @ motion
    own = np.sqrt(np.abs(np.diagonal(found, axis1=1, axis2=2)))
    return found / own[:, :, None] / own[:, None]


@pytest.mark.parametrize(
    ("density", "damping"),
    [(1.2, 0.01), (1.2, 3e-3), (20.0, 0.01)],
    ids=["air", "little damping", "dense air"],
)
def test_few_factorisations_give_the_receptance_of_a_solve_of_every_line(panel, density, damping):
    # red: `- coupled @ resonant` → `+`; whole[np.ix_(far, near)] → its conjugate; `NODES - 4`;
    # `WINDOW = 1.2` (falls back to solves of every line: too many frequencies asked for)
    basis, air, observed = panel
    basis = ModalBasis(basis.natural_frequency, basis.modal_mass, damping)
    counted = Counted(replace(air, density=density), air.travel_time)
    frequency = frequency_grid(20.0, HIGHEST, damping)
    in_air = PanelInAir(frequency, basis, counted)
    chunks = np.array_split(frequency, 37)
    found = np.concatenate([in_air.motion(lines, observed) for lines in chunks])
    assert counted.asked < 0.4 * frequency.size
    exact = line_by_line(frequency, basis, counted.air, observed)
    # what the tails bound is 1e-7 of the damping; dropped columns of patches cost 2e-8
    left = receptance(found, observed) - receptance(exact, observed)
    assert np.abs(left).max() < 2e-8
    # and row by row, for curvatures weigh those shapes that move least
    unit = np.abs(observed).max(axis=0)
    size = np.max(np.abs(exact / unit), axis=2, keepdims=True)
    assert np.max(np.abs(found - exact) / unit / size) < 1e-7


def test_a_band_that_is_no_polynomial_is_solved_line_by_line(panel):
    # red: `if holds else None` left out; `TAIL = 1e-3`
    basis, air, observed = panel
    frequency = frequency_grid(20.0, HIGHEST, 0.02)

    def echo(frequency):  # its phase turns every 50 Hz, and it says nothing of that
        return air(frequency) * (1 + 0.5 * np.cos(2 * np.pi * frequency / 50.0))[:, None, None]

    counted = Counted(echo, 0.0)
    found = PanelInAir(frequency, basis, counted).motion(frequency, observed)
    assert counted.asked > frequency.size
    exact = line_by_line(frequency, basis, echo, observed)
    left = receptance(found, observed) - receptance(exact, observed)
    assert np.abs(left).max() < 2e-8


def test_a_single_motion_is_solved_too(panel):
    # red: `_width` that begins at 1
    basis, air, observed = panel
    frequency = frequency_grid(100.0, 200.0, 0.02)
    found = PanelInAir(frequency, basis, air).motion(frequency, observed[:, :1])
    exact = line_by_line(frequency, basis, air, observed[:, :1])
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7 * np.abs(exact).max())


def test_lines_in_any_pieces_are_the_same(panel):
    # red: the bands begin at the first line asked for
    basis, air, observed = panel
    frequency = frequency_grid(20.0, 700.0, 0.02)
    whole = PanelInAir(frequency, basis, air).motion(frequency, observed)
    one = PanelInAir(frequency, basis, air)
    backwards = [one.motion(part, observed) for part in np.array_split(frequency, 5)[::-1]][::-1]
    np.testing.assert_allclose(np.concatenate(backwards), whole, rtol=1e-9, atol=0)


def test_the_air_of_a_study_is_known_to_be_smooth(panel):
    # red: `travel_time` → another name; `isinstance(air_stiffness, SmoothStiffness)` → False
    basis, air, observed = panel
    assert isinstance(air, SmoothStiffness) and air.travel_time == pytest.approx(
        np.hypot(A, B) / 343.0, rel=0.2
    )
    counted = Counted(air, air.travel_time)
    frequency = frequency_grid(20.0, HIGHEST, 0.01)
    sound = np.ones_like(frequency)
    patches = Patches(np.zeros((0, 56, 56)), np.zeros(0))
    bare_panels(frequency, basis, [patches], observed.T, sound, np.eye(56), counted)
    assert NODES < counted.asked < 0.4 * frequency.size
