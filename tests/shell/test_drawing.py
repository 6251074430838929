"""Shapes by parameters and their patches."""

import numpy as np
import pytest

from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import SolidSection
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import ShellSupport
from pidpanel.shell.drawing import (
    cylinder_panel,
    edge_strips,
    flat_panels,
    mesh_surface,
    paraboloid,
)
from pidpanel.shell.resolution import (
    element_size,
    frequency_shifts,
    layer_depth,
    smallest_radius,
)
from pidpanel.shell.selections import Box, Line, Prism, Ring, Sphere
from pidpanel.shell.strains import Layup
from tests.shells import SANDWICH, plane


def paraboloid_area(focal_length, inner, outer):
    """Of z = r²/4F between two radii."""
    a, b = (8 * np.pi / 3 * focal_length**2 * (1 + (r / (2 * focal_length)) ** 2) ** 1.5
            for r in (inner, outer))  # fmt: skip
    return b - a


def test_a_paraboloid_and_its_rings_have_their_areas():
    rings = {
        "inner": Ring(0.2, 0.3),
        "outer": Ring(0.45, 0.55),
        "spot": Sphere((0.3, 0, 0.047), 0.03),
    }
    mesh = mesh_surface(paraboloid(1.2, 0.48, 0.24), 0.15, rings.values()).with_names(rings, {})
    shell = assemble_shell(mesh, Layup(SANDWICH))
    area = shell.quadrature_weight.reshape(len(mesh.cells), -1).sum(axis=1)
    assert area.sum() == pytest.approx(paraboloid_area(0.48, 0.12, 0.6), rel=1e-6)
    for name, radii in (("inner", (0.2, 0.3)), ("outer", (0.45, 0.55))):
        patch = area[mesh.patch_cells[name]].sum()
        assert patch == pytest.approx(paraboloid_area(0.48, *radii), rel=1e-5)
    assert area[mesh.patch_cells["spot"]].sum() == pytest.approx(np.pi * 0.03**2, rel=1e-3)
    x, y, z = shell.quadrature_position.T
    assert np.allclose(z, (x**2 + y**2) / (4 * 0.48), atol=3e-6)
    assert shell.quadrature_normal[:, 2].min() > 0.8


def test_a_whole_paraboloid_and_a_cylinder_panel_have_their_areas_and_boxes():
    dish = assemble_shell(mesh_surface(paraboloid(1.0, 0.4), 0.2), Layup(SANDWICH))
    assert dish.quadrature_weight.sum() == pytest.approx(paraboloid_area(0.4, 0, 0.5), rel=1e-5)
    box = Box((0.2, -0.2, 0.0), (0.6, 0.2, 2.0))
    mesh = mesh_surface(cylinder_panel(1.0, 0.8, 0.9), 0.2, [box]).with_names({"b": box}, {})
    shell = assemble_shell(mesh, Layup(SANDWICH))
    area = shell.quadrature_weight.reshape(len(mesh.cells), -1).sum(axis=1)
    assert area.sum() == pytest.approx(0.8 * 0.9, rel=1e-6)
    assert area[mesh.patch_cells["b"]].sum() == pytest.approx(0.4 * 2 * np.arcsin(0.2), rel=1e-6)


def test_strips_along_free_edges_and_a_line_leave_a_fifth_of_the_error():
    """The reference is of order 6, where little is left."""
    corners = {"A": [(0, 0, 0), (0.12, 0, 0), (0.12, 0.08, 0), (0, 0.08, 0)]}
    layup = Layup(SolidSection(70e9, 0.3, 2700.0, 0.002))
    middle = Line((0.06, 0, 0), (0.06, 0.08, 0))
    strips = edge_strips(corners, [middle], 4 * layer_depth(layup))
    assert np.linalg.norm(np.subtract(strips[-1].start, strips[-2].start)) == pytest.approx(
        8 * 0.002 / np.sqrt(10)  # on both sides
    )
    frequency = []
    for imprints, order in (([], 4), (strips, 4), (strips, 6)):
        mesh = mesh_surface(flat_panels(corners), 0.06, [middle, *imprints])
        shell = assemble_shell(mesh, layup, order=order)
        frequency.append(normal_modes(shell, 2000.0, 8)[0][6:8])
    plain, stripped = np.array(frequency[:2]) / frequency[2] - 1
    assert plain.max() > 1e-3
    assert -1e-6 < stripped.min() < stripped.max() < 0.2 * plain.max()


def test_elements_follow_a_polygon_that_is_projected():
    square = ((0.2, 0.0, 0.0), (0.4, 0.0, 0.0), (0.4, 0.2, 0.0), (0.2, 0.2, 0.0))
    prism = Prism(square, (0.0, 0.0, 1.0))
    mesh = mesh_surface(paraboloid(1.2, 0.48, 0.24), 0.2, [prism]).with_names({"P": prism}, {})
    shell = assemble_shell(mesh, Layup(SANDWICH))
    area = shell.quadrature_weight.reshape(len(mesh.cells), -1).sum(axis=1)
    x, y = np.meshgrid(0.2 + 0.2 * (np.arange(400) + 0.5) / 400, 0.2 * (np.arange(400) + 0.5) / 400)
    exact = 0.04 * np.sqrt(1 + (x**2 + y**2) / (4 * 0.48**2)).mean()
    assert area[mesh.patch_cells["P"]].sum() == pytest.approx(exact, rel=1e-5)


def test_parts_that_overlap_are_refused():
    a = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    b = [(x + 0.5, y, z) for x, y, z in a]
    with pytest.raises(ValueError, match="b and a overlap"):
        mesh_surface(flat_panels({"a": a, "b": b}), 0.5)


def test_panels_of_a_box_share_their_edges():
    a, b, c = 0.5, 0.4, 0.3
    sides = {
        "bottom": [(0, 0, 0), (a, 0, 0), (a, b, 0), (0, b, 0)],
        "top": [(0, 0, c), (a, 0, c), (a, b, c), (0, b, c)],
        "front": [(0, 0, 0), (a, 0, 0), (a, 0, c), (0, 0, c)],
        "back": [(0, b, 0), (a, b, 0), (a, b, c), (0, b, c)],
        "left": [(0, 0, 0), (0, b, 0), (0, b, c), (0, 0, c)],
        "right": [(a, 0, 0), (a, b, 0), (a, b, c), (a, 0, c)],
    }
    mesh = mesh_surface(flat_panels(sides), 0.3)
    shell = assemble_shell(mesh, {name: Layup(SANDWICH) for name in sides})
    outward = np.sum(
        shell.quadrature_normal * (shell.quadrature_position - [a / 2, b / 2, c / 2]), 1
    )
    assert outward.min() > 0.1
    assert np.sum(normal_modes(shell, 10.0, 8)[0] == 0) == 6  # one piece


def test_the_smallest_radius_is_that_of_the_surface_and_shortens_elements():
    cylinder, flat = (
        mesh_surface(draw, 0.3)
        for draw in (
            cylinder_panel(0.7, 0.5, 0.4),
            flat_panels({"a": [(0, 0, 1), (1, 0, 1), (0, 1, 1)]}),
        )
    )
    assert smallest_radius(cylinder) == pytest.approx(0.7, rel=5e-3)
    assert np.isinf(smallest_radius(flat))
    thin = Layup(SolidSection(70e9, 0.3, 2700.0, 0.5e-3))
    assert element_size(thin, 30.0, 0.7) == pytest.approx(3 * np.sqrt(0.7 * 0.5e-3), rel=1e-6)
    # k of a thin plate, k⁴ = m″ω²/D
    k = (2700 * 0.5e-3 * (2 * np.pi * 30) ** 2 * 12 * 0.91 / (70e9 * 0.5e-3**3)) ** 0.25
    assert element_size(thin, 30.0) == pytest.approx(0.35 * 2 * np.pi / k, rel=1e-3)


L_PLATE = {"a": [(0, 0, 0), (0.8, 0, 0), (0.8, 0.3, 0), (0.3, 0.3, 0), (0.3, 0.7, 0), (0, 0.7, 0)]}
ANGLE = {
    "a": [(0, 0, 0), (0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0)],
    "b": [(0, 0, 0), (0, 0.5, 0), (0.1, 0.5, 0.4), (0.1, 0, 0.4)],
}


@pytest.mark.parametrize(
    ("draw", "section", "highest"),
    [
        (cylinder_panel(1.0, 0.8, 0.6), SANDWICH, 700.0),
        (flat_panels(L_PLATE), SolidSection(70e9, 0.3, 2700.0, 4e-3), 300.0),
        (flat_panels(ANGLE), SANDWICH, 500.0),
    ],
)
def test_the_stated_error_of_a_mesh_is_one_to_three_times_the_true_one(draw, section, highest):
    layup, held = Layup(section), {"": ShellSupport(plane(0, 0), rotation=())}
    size = 1.3 * element_size(layup, highest)
    mesh = mesh_surface(draw, size)
    frequency, _ = normal_modes(assemble_shell(mesh, layup, held), highest)
    shell = assemble_shell(mesh_surface(draw, size / 2), layup, held, order=6)
    fine = normal_modes(shell, highest, len(frequency))[0][: len(frequency)]
    elastic = frequency > 1.0  # not of an angle that turns about its edge
    stated = np.maximum.accumulate(frequency_shifts(mesh, layup, held, frequency=frequency))
    true = np.maximum.accumulate(frequency / np.maximum(fine, 1.0) - 1)
    ratio = stated[elastic] / true[elastic]
    assert ratio.min() > 1
    assert ratio.max() < 3
