"""The panel that the solver gets: lines, carriers of dampers, elements of patches, own force."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.sparse as sp

from pidpanel.damping_ratio import DampingRatio
from pidpanel.response.panel import (
    ResponsePanel,
    Settings,
    widen,
)
from pidpanel.solve.model import Patches
from pidpanel.solve.panel import PatchElements
from pidpanel.solve.source import PatchParts, own_force_load

BASIS = SimpleNamespace(
    natural_frequency=np.array([100.0, 300.0, 123.4]),
    modal_mass=np.ones(3),
    is_residual=np.array([False, False, True]),
    patch_overlap=np.stack([np.eye(3), 2 * np.eye(3)]),
    shape_at_points=np.array([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]),
    shape_at_vertices=np.ones((4, 3)),
    curvature_at_points=np.full((2, 3, 3), 4.0),
    shear_at_points=np.full((2, 2, 3), 5.0),
)
ELEMENTS = PatchElements(Patches(np.stack([np.eye(3)] * 3), [1.0, 2.0, 3.0]), np.array([0, 1, 1]))


def panel(elements=None, least=None, **settings):
    values = {"frequency_range": (50.0, 200.0), "damping_ratio": DampingRatio((0.01,))}
    made = ResponsePanel(Settings(**(values | settings)), BASIS, None, 1.0, None, 0.0,
                         elements=elements, least_damping_ratio=least)  # fmt: skip
    made.__dict__["patch_area"] = np.array([1.0, 5.0])
    return made


def test_lines_resolve_the_panel_and_have_its_modes_and_the_steps_of_the_input():
    # eight to a bandwidth 2 ζ f and three in the search
    for least, ratio in ((None, 0.01), (0.004, 0.004)):
        made = panel(least=least, jumps=(141.0,))
        assert made.resolved_ratio == ratio
        for lines, count in ((made.frequency, 8), (made.coarse_frequency, 3)):
            assert lines[[0, -1]].tolist() == pytest.approx([50.0, 200.0])
            widest = np.diff(np.log(lines)).max()
            assert 0.98 * 2 * ratio / count < widest <= 2 * ratio / count * (1 + 1e-9)
            assert np.sum(np.abs(lines - 141.0) < 1e-6) == 2
        assert 100.0 in made.frequency and 123.4 not in made.frequency


@pytest.mark.parametrize("elements", [None, ELEMENTS])
@pytest.mark.parametrize("by_element", [False, True])
def test_elements_carry_dampers_where_a_study_wants_it_and_they_are_known(elements, by_element):
    made = panel(elements, by_element=by_element)
    split = by_element and elements is not None
    assert made.by_element == split
    assert made.carriers.tolist() == ([0, 1, 1] if split else [0, 1])
    assert made.carrier_patches.area.tolist() == ([1, 2, 3] if split else [1, 5])
    solver = made.solver()
    assert (solver.panel.cells is None) == (elements is None or by_element)
    loads = SimpleNamespace(patches=np.array([1, 0]))
    assert made.load_area(loads).tolist() == ([2, 1] if split else [5, 1])
    none = PatchElements(SimpleNamespace(), np.zeros(0, int))
    assert panel(none, by_element=by_element).carrier_patches.area.tolist() == [1, 5]
    assert by_element or panel(none).solver().panel.cells is None


def test_a_solver_for_rms_values_has_few_lines_and_deflections_alone():
    made = panel(is_diagonal=True)
    few, whole = made.solver(rms_only=True).panel, made.solver(full=True).panel
    assert few.frequency.size == few.search_frequency.size < whole.frequency.size
    assert few.points.shape == (2, 1, 3) and whole.points.shape == (2, 6, 3)
    np.testing.assert_array_equal(whole.points[0, :, 0], [1, 4, 4, 4, 5, 5])
    assert few.is_diagonal and not whole.is_diagonal and not panel().solver().panel.is_diagonal


def test_a_basis_that_lacks_nothing_stays_and_has_its_elements():
    plate = SimpleNamespace(
        quadrature_weight=np.arange(1.0, 7.0), at_quadrature=sp.csr_array(np.eye(6)),
        shapes=np.ones((6, 3), np.float32),
    )  # fmt: skip
    inside = np.array([[True, True, False], [False, True, True]])
    basis = SimpleNamespace(**vars(BASIS), cells=np.zeros((3, 4)), cell_in_patch=inside)
    made = replace(panel(), basis=basis)
    same = widen(made, plate, np.zeros((6, 0)), None)
    assert same.basis is basis and same.elements.patch.tolist() == [0, 0, 1, 1]


def test_the_force_of_particles_is_the_sum_of_their_patches():
    # two square cells of a mesh, a patch each, on 25 lines even in ln f
    position = np.array([[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]) * 0.1
    cells = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    shape = np.ones((6, 1))
    basis = SimpleNamespace(
        vertex_position=position, cells=cells, shape_at_vertices=shape,
        cell_in_patch=np.eye(2, dtype=bool), patch_overlap=np.full((2, 1, 1), 0.01),
    )  # fmt: skip
    settings = SimpleNamespace(frequency_range=(20.0, 2000.0))

    def bed(level):
        return SimpleNamespace(
            own_force=lambda f: (np.full(f.shape, level), np.full(f.shape, 0.25)),
            own_length=30.0, cell_area=4e-5,
        )  # fmt: skip

    found = ResponsePanel.particle_force(SimpleNamespace(basis=basis, settings=settings),
                                         {0: bed(3.0), 1: bed(5.0)})  # fmt: skip
    nodes = np.geomspace(20.0, 2000.0, 25)
    part = PatchParts(np.ones((1, 1)), np.array([0.01]), np.zeros((1, 2)))
    alone = own_force_load(part, np.array([[4e-7]]), nodes, np.full(25, 0.25), 30.0)
    np.testing.assert_allclose(found(nodes), 8 * alone, rtol=1e-12)
