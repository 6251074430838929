"""Masses and springs on a plate whose coordinates are monomials: all integrals are known."""

import dataclasses

import numpy as np
import pytest
import scipy.sparse as sp

from pidpanel.panel.attachments import Attachment, with_attachments
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection

# one cell of 0.4 m x 0.4 m, so that elements measure 0.4 m
SQUARE = 0.4 * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
MESH = PanelMesh(SQUARE, np.array([[0, 1, 2, 3]]), "quadrilaterals", {}, {})
STIFFNESS, MASS = np.diag([1.0, 2, 3]), np.diag([4.0, 5, 6])


def monomials(asked):
    """A plate with w = u_0 + u_1 x + u_2 y², which notes where it is asked for w."""

    def interpolate(position):
        asked.append(position)
        x, y = np.asarray(position).T
        return sp.csr_array(np.column_stack([np.ones_like(x), x, y**2]))

    empty = dict.fromkeys(field.name for field in dataclasses.fields(AssembledPlate))
    return AssembledPlate(
        **empty
        | {
            "stiffness": sp.csr_array(STIFFNESS),
            "mass": sp.csr_array(MASS),
            "inertia": np.zeros(3),
            "interpolate": interpolate,
            "section": ThinSection(1.0, 1.0),
            "reactions": (sp.csr_array((0, 3)),) * 2,
        }
    )


def test_a_spring_and_a_mass_at_a_point_add_the_squares_of_the_deflection_there():
    plate = with_attachments(
        monomials([]),
        [Attachment([(0.1, 0.3)], stiffness=7.0), Attachment([(0.2, 0.1)], 11.0)],
        MESH,
    )
    spring, mass = np.array([1, 0.1, 0.09]), np.array([1, 0.2, 0.01])
    np.testing.assert_allclose(
        plate.stiffness.toarray(), STIFFNESS + 7 * np.outer(spring, spring), rtol=1e-14
    )
    np.testing.assert_allclose(plate.mass.toarray(), MASS + 11 * np.outer(mass, mass), rtol=1e-14)


@pytest.mark.parametrize("reach", [0.05, 1.0, 3.0])
def test_a_line_mass_integrates_the_products_of_the_deflection_along_it(reach):
    # from (0.1, 0.2) by s (3, 2) reach: products are quartics, exact with three Gauss points
    line = Attachment([(0.1, 0.2), (0.1 + 3 * reach, 0.2 + 2 * reach)], 5.0)
    added = with_attachments(monomials([]), [line], MESH).mass.toarray() - MASS
    x = np.polynomial.Polynomial([0.1, 3 * reach])
    y = np.polynomial.Polynomial([0.2, 2 * reach])
    shapes = [np.polynomial.Polynomial([1.0]), x, y**2]
    expected = [[5.0 * (a * b).integ()(1.0) for b in shapes] for a in shapes]
    np.testing.assert_allclose(added, expected, rtol=1e-12, atol=1e-13)
