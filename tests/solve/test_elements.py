"""All elements beside the basis: the same answer as dense matrices, whatever the basis."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import Shapes, panel_shapes
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve import elements
from pidpanel.solve.elements import Elements
from pidpanel.solve.model import ModalBasis

ZETA, CUTOFF = 0.01, 800.0
PATCHES = {"left": Rectangle((0.5, 0.5), (0.6, 0.6)), "right": Rectangle((1.1, 0.5), (0.4, 0.4))}


class Pull(NamedTuple):
    """A frequency, and s of each patch."""

    frequency: float
    stiffness: np.ndarray


@dataclass
class Panel:
    """A small panel in elements and in a basis."""

    plate: object
    shapes: Shapes
    elements: Elements

    def motion(self, pull: Pull) -> elements.ElementMotion:
        (motion,) = self.elements.motions(pull.frequency, pull.stiffness[None])
        return motion

    def dense(self, pull: Pull) -> np.ndarray:
        """Z⁻¹ c with the damping from all modes of the dense eigenvalue problem."""
        K, M = self.plate.stiffness.toarray(), self.plate.mass.toarray()
        value, vector = la.eigh(K, M)
        omega, cutoff = np.sqrt(np.maximum(value, 0)), 2 * np.pi * self.elements.cutoff
        diagonal = 2 * ZETA * np.where(omega < cutoff, omega, omega**2 / cutoff)
        C = M @ vector @ np.diag(diagonal) @ vector.T @ M
        w = 2 * np.pi * pull.frequency
        Z = K - w**2 * M + 1j * w * C
        for s, D in zip(pull.stiffness, self.plate.patch_overlap.values(), strict=True):
            Z = Z + s * D.toarray()
        return np.linalg.solve(Z, self.elements.points.toarray().T)


def panel(tmp_path, support="simply_supported", mass=None) -> Panel:
    mesh = mesh_quadrilaterals(
        tmp_path / "panel.msh", (1.5, 1.0), (15, 10), PATCHES, {"a": (0.5, 0.5), "b": (1.1, 0.3)}
    )
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0), Supports(support))
    shapes = panel_shapes(plate, CUTOFF, damper_mass=mass)
    frequency = np.concatenate([shapes.frequency, shapes.residual_frequency])
    residual = np.arange(len(frequency)) >= len(shapes.frequency)
    modal_mass = np.einsum("ki,ki->i", shapes.vectors, plate.mass @ shapes.vectors)
    cutoff = max(CUTOFF, shapes.frequency.max())  # under heavy dampers modes beyond are kept
    ratio = np.where(residual, ZETA * frequency / cutoff, ZETA)
    positive = np.where(frequency > 0, frequency, 1e-9)
    return Panel(
        plate,
        shapes,
        Elements(
            plate,
            list(plate.patch_overlap.values()),
            shapes.vectors,
            ModalBasis(positive, modal_mass, ratio),
            residual,
            ZETA,
            cutoff,
            sp.csr_array(plate.interpolate(np.array([(0.5, 0.5), (1.1, 0.3)]))),
        ),
    )


def pull(frequency, damping, mass):
    omega = 2 * np.pi * frequency
    return Pull(frequency, 1j * omega * np.array(damping) - omega**2 * np.array(mass))


PULLS = [
    pull(60.0, (0.0, 0.0), (0.0, 0.0)),
    pull(250.0, (2000.0, 0.0), (8.0, 0.0)),
    pull(390.0, (500.0, 2000.0), (30.0, 60.0)),
    pull(395.0, (0.0, 0.0), (150.0, 0.0)),
]


def close_to_dense(found, one, motion):
    """A residual of 1e-3 of that of the basis may leave some 1e-2 of what the basis left out."""
    points = found.elements.points
    computed, expected = points @ motion.whole, points @ found.dense(one)
    left = 1e-2 * np.abs(points @ motion.remainder).max() + 1e-9 * np.abs(computed).max()
    np.testing.assert_allclose(computed, expected, rtol=0, atol=left)


@pytest.mark.parametrize(
    ("support", "mass"),
    [
        ("simply_supported", None),
        ("simply_supported", {"left": 30.0, "right": 60.0}),
        ("free", None),
    ],
)
def test_all_elements_answer_as_dense_matrices_do(tmp_path, support, mass):
    found = panel(tmp_path, support, mass)
    for one in PULLS:
        close_to_dense(found, one, found.motion(one))


@pytest.mark.parametrize(
    ("support", "mass", "most"),
    [
        ("simply_supported", None, (2, 2, 3, 11)),
        ("simply_supported", {"left": 30.0, "right": 60.0}, (2, 2, 3, 5)),
        ("free", None, (2, 2, 3, 5)),
    ],
)
def test_a_few_steps_find_what_the_basis_leaves_out(tmp_path, monkeypatch, support, mass, most):
    asked = []

    def static(self, right, known=Elements._static):
        asked.append(right)
        return known(self, right)

    monkeypatch.setattr(Elements, "_static", static)
    monkeypatch.setattr(Elements, "_direct", None)  # no line is factorised
    found = panel(tmp_path, support, mass)
    for one, steps in zip(PULLS, most, strict=True):
        asked.clear()
        found.motion(one)
        assert len(asked) <= steps


def test_the_factorisation_line_by_line_gives_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(elements, "MOST_STEPS", 0)
    found = panel(tmp_path)
    for one in PULLS:
        motion = found.motion(one)
        np.testing.assert_allclose(motion.whole, found.dense(one), rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("support", ["simply_supported", "free"])
@pytest.mark.parametrize("mass", [None, {"left": 30.0}])
def test_what_a_static_answer_pulls_at_the_shapes_is_known_from_what_they_have_of_it(
    tmp_path, support, mass
):
    found = panel(tmp_path, support, mass).elements
    V, M = found.shapes, found.plate.mass
    random = np.random.default_rng(2)
    s = np.array([one.stiffness for one in PULLS])
    right = random.standard_normal((len(V), len(s))) + 1j * random.standard_normal((len(V), len(s)))
    right -= V @ np.linalg.solve(V.T @ V, V.T @ right)  # has no part in the shapes
    x = found._static(right)
    of_x = V.T @ (M @ x) / found.basis.modal_mass[:, None]
    known = found._on_shapes(2000.0, s, x, of_x)
    whole = V.T @ found._applied(2000.0, s, x, of_x)
    np.testing.assert_allclose(known, whole, rtol=0, atol=1e-7 * np.abs(whole).max())


def test_what_the_basis_leaves_out_joins_it(tmp_path):
    found = panel(tmp_path)
    one = PULLS[2]
    motion = found.motion(one)
    more = np.hstack([motion.remainder.real, motion.remainder.imag])
    wider = found.shapes.joined_by(found.plate, more)
    expected = found.dense(one)
    V = wider.vectors
    K, M = found.plate.stiffness, found.plate.mass
    for matrix in (K, M):  # the basis stays diagonal in both
        small = V.T @ (matrix @ V)
        scale = np.sqrt(np.outer(np.diag(small), np.diag(small)))
        np.testing.assert_allclose((small - np.diag(np.diag(small))) / scale, 0.0, atol=1e-8)
    missing = la.lstsq(V, expected.real)[0]
    # what is left are two thousandths of what was missing, in each of two points
    assert la.norm(V @ missing - expected.real) < 0.01 * la.norm(motion.remainder.real)


def test_a_symmetric_system_is_solved_where_its_pivots_fail():
    right = np.array([[1.0 + 2.0j], [3.0]])
    for small in (0.0, 1e-14):
        matrix = sp.csr_array(np.array([[small, 1.0], [1.0, small]], dtype=complex))
        answer = elements._factorised_solution(matrix, right)
        np.testing.assert_allclose(matrix @ answer, right, rtol=1e-12)  # rounding of two unknowns


def test_sets_of_dampers_are_solved_together_two_by_two(tmp_path, monkeypatch):
    found = panel(tmp_path)
    stiffness = np.array([one.stiffness for one in PULLS])
    monkeypatch.setattr(elements, "COLUMNS_AT_ONCE", 4)
    together = found.elements.motions(250.0, stiffness)
    for s, motion in zip(stiffness, together, strict=True):
        close_to_dense(found, Pull(250.0, s), motion)
