"""Panels of a family against each of them assembled and solved on its own."""

import numpy as np
import pytest

from pidpanel.margin.family import PanelFamily, Parts, compressed
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate

ENDS = [(3273.0, 10.0), (3273.0, 1e3), (3273.0, 1e5)]  # D [N m] and springs [N]
BETWEEN = [(3000.0, 100.0), (3600.0, 1e4)]


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    mesh = mesh_quadrilaterals(tmp_path_factory.mktemp("m") / "m.msh", (1.5, 1.0), (12, 8), {}, {})
    return [
        assemble_thin_plate(mesh, ThinSection(D, 4.0), Supports(stiffness=k))
        for D, k in ENDS + BETWEEN
    ]


def test_frequencies_of_panels_between_the_ends_are_those_of_their_own_solution(plates):
    parts = Parts.spanning(np.array(ENDS + BETWEEN))
    shapes = [normal_modes(plate, 600, 12)[1] for plate in plates[: len(ENDS)]]
    V = compressed(shapes, plates[0].stiffness, plates[0].mass, 600.0)
    stiffness = np.array([V.T @ (plates[n].stiffness @ V) for n in parts.chosen.tolist()])
    family = PanelFamily(stiffness, (V.T @ (plates[0].mass @ V))[None])
    for number in range(len(ENDS), len(plates)):
        found, vectors = family.modes(parts.share[number], np.ones(1))
        alone = normal_modes(plates[number], 600, 12)[0]
        # springs over four decades between three ends
        assert found[: len(alone)] == pytest.approx(alone, rel=2e-4)
        mass = vectors.T @ (V.T @ (plates[number].mass @ (V @ vectors)))
        assert np.allclose(mass, np.eye(len(found)), atol=1e-8)


def test_few_panels_make_up_all(plates):
    parts = Parts.spanning(np.array(ENDS + BETWEEN))
    assert len(parts.chosen) == 2
    for number, plate in enumerate(plates):
        total = sum(
            c * plates[n].stiffness
            for c, n in zip(parts.share[number].tolist(), parts.chosen.tolist(), strict=True)
        )
        assert abs(total - plate.stiffness).max() < 1e-8 * abs(plate.stiffness).max()


def test_panels_that_differ_by_a_factor_have_the_same_shapes():
    parts = Parts.spanning(np.array([[1.0, 2.0], [3.0, 6.0], [1.0, 5.0]]))
    assert parts.distinct(np.arange(3)).tolist() == [0, 2]
