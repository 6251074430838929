"""Springs along edges, from simply supported to clamped, against Levy's solution."""

import numpy as np
import pytest
from scipy.optimize import brentq

from pidpanel.geometry.polygon import Polygon
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import SolidSection, ThinSection
from pidpanel.panel.supports import EdgeSupport, Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles

A, B, D, MASS = 1.5, 1.0, 3273.07, 4.0


def levy(stiffness):
    """First frequency [Hz], simply supported at x = 0 and A, springs K at y = ±B/2.

    Y = cosh αy/cosh(αB/2) − cos βy/cos(βB/2) vanishes there, and D Y″ = −K Y′.
    """
    p = np.pi / A

    def surplus(k):
        alpha, beta = np.sqrt(k**2 + p**2), np.sqrt(k**2 - p**2)
        half = np.cos(beta * B / 2)
        turned = alpha * np.tanh(alpha * B / 2) * half + beta * np.sin(beta * B / 2)
        return D * (alpha**2 + beta**2) * half + stiffness * turned

    simple = np.hypot(p, np.pi / B)
    k = brentq(surplus, simple * (1 - 1e-9), 1.6 * simple, xtol=1e-13)
    return k**2 * np.sqrt(D / MASS) / (2 * np.pi)


def springs(stiffness):
    ends = [((0.0, y), (A, y)) for y in (0.0, B)]
    kind = "simply_supported"
    return Supports(edges=[EdgeSupport(start, end, kind, stiffness) for start, end in ends])


@pytest.mark.parametrize("stiffness", [0.0, 2e3, 2e4, 1e6])
def test_springs_along_two_edges_of_a_thin_plate_follow_levy(tmp_path, stiffness):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (12, 8), {}, {})
    plate = assemble_thin_plate(mesh, ThinSection(D, MASS), springs(stiffness))
    # bicubics of 12 cm are 2e-4 above
    assert normal_modes(plate, 150, 1)[0][0] == pytest.approx(levy(stiffness), rel=4e-4)


def test_springs_turn_a_plate_with_shear_likewise(tmp_path):
    outline = Polygon(((0.0, 0.0), (A, 0.0), (A, B), (0.0, B)))
    mesh = mesh_triangles(tmp_path / "m.msh", outline, 0.25, {}, {})
    thickness, nu = 1e-2, 0.3  # thin against the panel: shear lowers the first frequency by 1e-4
    modulus = D * 12 * (1 - nu**2) / thickness**3
    section = SolidSection(modulus, nu, MASS / thickness, thickness)
    plate = assemble_shear_plate(mesh, section, springs(2e4))
    assert normal_modes(plate, 150, 1)[0][0] == pytest.approx(levy(2e4), rel=1e-3)


def test_a_spring_on_the_outline_is_that_on_all_its_edges(tmp_path):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (A, B), (6, 4), {}, {})
    section, corners = ThinSection(D, MASS), [(0.0, 0.0), (A, 0.0), (A, B), (0.0, B)]
    sides = zip(corners, corners[1:] + corners[:1], strict=True)
    apart = [EdgeSupport(*ends, "simply_supported", 5e3) for ends in sides]
    first = assemble_thin_plate(mesh, section, Supports(edges=apart)).stiffness
    second = assemble_thin_plate(mesh, section, Supports(stiffness=5e3)).stiffness
    assert abs(first - second).max() < 1e-9 * abs(first).max()
