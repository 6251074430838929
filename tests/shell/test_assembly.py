"""Shells as matrices: rigid motion, plates, kinks, and what is downstream."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse.linalg import spsolve
from scipy.spatial.transform import Rotation
from scipy.special import j1, jvp, y1, yvp

from pidpanel.geometry.polygon import Polygon
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.supports import Supports
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import PointMass, ShellSupport
from pidpanel.shell.drawing import flat_panels, mesh_surface, paraboloid
from pidpanel.shell.mesh import ShellMesh
from pidpanel.shell.selections import Box, Line, Ring
from pidpanel.shell.strains import Layup
from tests.shells import (
    FAR,
    RHO,
    SANDWICH,
    E,
    X,
    Y,
    Z,
    grid,
    mirror,
    on_cylinder,
    on_paraboloid,
    plane,
)

TAPE = Material(130e9, 9e9, 5e9, 0.3, 1600.0)
# faces that differ: their membrane forces bend, and their mass is off the middle of the core
SKEW = SandwichSection(
    (Ply(TAPE, 0.4e-3, 0.3),), (Ply(TAPE, 0.2e-3, 1.1),), Core(3e8, 1e8, 50.0, 8e-3, 0.5), 0.3
)


def rigid_motions(shell, node_position):
    """Six motions of a body in the coordinates of a free shell."""
    arms = [np.cross(axis, node_position) for axis in np.eye(3)]
    columns = [np.tile(unit, (len(node_position), 1)) for unit in np.eye(3)]
    still = np.zeros_like(node_position)
    return np.stack(
        [np.hstack([u, still]).ravel() for u in columns]
        + [np.hstack([arm, still + axis]).ravel() for arm, axis in zip(arms, np.eye(3), strict=True)],
        axis=1,
    )  # fmt: skip


def test_a_free_shell_moves_as_a_rigid_body_without_energy_and_with_its_mass():
    mesh = grid((2, 2), (-0.4, -0.3), (0.5, 0.3), on_paraboloid(0.4))
    shell = assemble_shell(mesh, Layup(SKEW), {"m": PointMass((0.1, 0.1, 0.0125), 0.7)})
    _, nodes = mesh.nodes(4)
    motion = rigid_motions(shell, nodes)
    energy = np.einsum("ki,ki->i", motion, shell.stiffness @ motion)
    scale = np.einsum("ki,ki->i", abs(motion), abs(shell.stiffness) @ abs(motion))
    assert np.all(np.abs(energy) < 1e-12 * scale)
    area = shell.quadrature_weight.sum()
    mass = motion.T @ shell.mass @ motion
    assert np.allclose(mass[:3, :3], (SKEW.mass_per_area * area + 0.7) * np.eye(3))
    assert shell.total_mass == pytest.approx(mass[0, 0])
    assert np.allclose(shell.participation.T @ motion[:, :3], mass[:3, :3])
    frequency, _ = normal_modes(shell, 200.0, 8)
    assert np.sum(frequency == 0) == 6


def test_mass_off_the_middle_of_the_core_moves_as_the_shell_turns():
    mesh = grid((2, 2), (-0.4, -0.3), (0.4, 0.3))
    shell = assemble_shell(mesh, Layup(SKEW))
    motion = rigid_motions(shell, mesh.nodes(4)[1])
    first = 1600 * 0.48 * (0.4e-3 * 4.2e-3 - 0.2e-3 * 4.1e-3)
    mass = motion.T @ shell.mass @ motion
    # e_x × z e_z = −z e_y
    assert mass[1, 3] == pytest.approx(-first)
    assert mass[0, 4] == pytest.approx(first)
    assert mass[3, 3] == pytest.approx(SKEW.mass_per_area * 0.48 * 0.6**2 / 12, rel=2e-3)


def test_a_folded_element_is_refused():
    mesh = grid((2, 2), (0.0, 0.0), (0.5, 0.5))
    mesh.geometry[3, 8] = mesh.geometry[3, 0] + [0.0, 0.0, 0.4]
    with pytest.raises(ValueError, match=r"the element at .* m is folded"):
        assemble_shell(mesh, Layup(SANDWICH))


def test_w_is_the_motion_along_the_normal_and_positions_have_three_columns():
    mesh = grid((2, 2), (-0.4, -0.3), (0.5, 0.3), on_paraboloid(0.4))
    shell = assemble_shell(mesh.with_names({}, {"A": (0.2, 0.1, 0.03125)}), Layup(SANDWICH))
    _, nodes = mesh.nodes(4)
    motion = rigid_motions(shell, nodes)[:, :3]
    assert np.allclose(shell.at_quadrature @ motion, shell.quadrature_normal, atol=1e-9)
    slope = shell.quadrature_position[:, :2] / 0.8
    normal = np.column_stack([-slope, np.ones(len(slope))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert np.allclose(shell.quadrature_normal, normal, atol=1e-4)
    at_A = np.array([-0.25, -0.125, 1.0])
    assert np.allclose(shell.at_points @ motion, at_A / np.linalg.norm(at_A), atol=1e-4)
    assert np.allclose(shell.motion_at_vertices[1] @ motion, [[0, 1, 0]])
    assert shell.point_weight.sum() == pytest.approx(1.0)


def test_a_flat_shell_vibrates_as_the_plate_and_has_its_curvature(tmp_path):
    outline = Polygon(((0.0, 0.0), (0.9, 0.0), (0.9, 0.6), (0.0, 0.6)))
    section = SandwichSection((Ply(TAPE, 0.3e-3, 0.3),), (Ply(TAPE, 0.3e-3, 0.3),), SKEW.core)
    flat = mesh_triangles(tmp_path / "a.msh", outline, 0.05, {}, {})
    plate = assemble_shear_plate(flat, section, Supports("clamped"))
    expected, _ = normal_modes(plate, 650.0)
    rim = {f"{axis}{at}": ShellSupport(plane(axis, at)) for axis, at in
           ((0, 0.0), (0, 0.9), (1, 0.0), (1, 0.6))}  # fmt: skip
    mesh = ShellMesh.from_triangles(flat.vertices, flat.cells, lambda p: np.concatenate(
        [p, 0 * p[..., :1]], -1))  # fmt: skip
    shell = assemble_shell(mesh, Layup(section), rim)
    frequency, modes = normal_modes(shell, 650.0)
    assert np.allclose(frequency, expected, rtol=1e-3)
    _, vectors = normal_modes(plate, 650.0)
    inside = np.flatnonzero((np.abs(flat.vertices - [0.45, 0.3]) < 0.2).all(axis=1))
    for ours, theirs in zip(
        (*shell.curvature_at_vertices[:3], *shell.shear_at_vertices),
        (*plate.curvature_at_vertices, *plate.shear_at_vertices), strict=True,
    ):  # fmt: skip
        a, b = (ours @ modes[:, 0])[inside], (theirs @ vectors[:, 0])[inside]
        assert np.abs(a - b).max() < 0.1 * np.abs(b).max()


@pytest.mark.parametrize("section", [SANDWICH, SolidSection(70e9, 0.3, 2700.0, 2e-3)])
def test_a_cylinder_under_pressure_has_the_hoop_stress_of_a_boiler(section):
    radius, pressure = 0.5, 1e3
    quarter = grid((2, 4), (0.0, 0.0), (0.4, 0.25 * np.pi), on_cylinder(radius))
    held = {"x": mirror(0, 0.0), "y": mirror(1, 0.0), "z": mirror(2, 0.0)}
    shell = assemble_shell(quarter, Layup(section), held)
    load = shell.at_quadrature.T @ (shell.quadrature_weight * pressure)
    motion = spsolve(shell.stiffness.tocsc(), load)
    rows = np.array([matrix @ motion for matrix in shell.curvature_at_vertices])
    thickness = 0.6e-3 if section is SANDWICH else 2e-3
    for layer in shell.layers:
        stress = layer.stress @ rows
        assert np.allclose(stress[1], pressure * radius / thickness, rtol=0.03)
        assert np.abs(stress[[0, 2]]).max() < 0.03 * stress[1].max()
        modulus = 50e9 if section is SANDWICH else 70e9
        assert np.allclose((layer.strain @ rows)[1], stress[1] / modulus, rtol=0.03)


def test_a_kinked_orthotropic_structure_turned_in_space_has_the_same_frequencies():
    corners = {
        "floor": [(0, 0, 0), (0.5, 0, 0), (0.5, 0.4, 0), (0, 0.4, 0)],
        "wall": [(0.2, 0, 0), (0.2, 0.4, 0), (0.2, 0.4, 0.3), (0.2, 0, 0.3)],  # a T-joint
    }
    axis, held = (0.0, 1.0, 0.0), ((0.2, 0.4, 0.3), (0.2, 0.0, 0.3))
    frequencies = []
    for turn in (Rotation.identity(), Rotation.from_euler("xyz", (0.4, -1.1, 2.0))):
        places = {name: turn.apply(values) for name, values in corners.items()}
        mesh = mesh_surface(flat_panels(places), 0.2, outward=tuple(turn.apply((0.3, 0.1, 1.0))))
        support = {"edge": ShellSupport(Line(*(tuple(turn.apply(end)) for end in held)))}
        shell = assemble_shell(mesh, Layup(SKEW, tuple(turn.apply(axis))), support)
        frequencies.append(normal_modes(shell, 10.0, 8)[0])
    assert np.allclose(*frequencies, rtol=5e-3)  # gmsh meshes a turned panel differently


def test_a_quarter_and_its_mirror_image_have_the_symmetric_modes_of_the_whole():
    """A cylinder panel of 40°, free but for its ends."""
    ends = {"end": ShellSupport(plane(0, 0.0)), "far": ShellSupport(plane(0, 0.6))}
    whole = assemble_shell(
        grid((6, 6), (0.0, -0.35), (0.6, 0.35), on_cylinder(1.0)), Layup(SANDWICH), ends
    )
    half = assemble_shell(
        grid((6, 3), (0.0, 0.0), (0.6, 0.35), on_cylinder(1.0)), Layup(SANDWICH),
        ends | {"crown": ShellSupport(plane(1, 0.0), ((0, 1, 0),), ((1, 0, 0), (0, 0, 1)))},
    )  # fmt: skip
    every, symmetric = (normal_modes(shell, 900.0)[0] for shell in (whole, half))
    nearest = every[np.abs(every[:, None] - symmetric).argmin(axis=0)]
    assert len(symmetric) > 1
    assert np.allclose(nearest, symmetric, rtol=2e-3)


def test_modes_and_residual_vectors_answer_for_a_damper_as_all_elements_do():
    mesh = grid((4, 4), (-0.5, -0.5), (0.5, 0.5), on_paraboloid(0.5))
    patches = {"P": Box((0.0, 0.0, -1.0), (0.25, 0.25, 1.0))}
    mesh = mesh.with_names(patches, {"A": (0.3, 0.2, 0.065)})
    shell = assemble_shell(mesh, Layup(SANDWICH), {"edge": ShellSupport(plane(0, -0.5))})
    shapes = panel_shapes(shell, 800.0, damper_mass={"P": 12.0})
    V, omega = shapes.vectors, 2 * np.pi * 310.0
    Z = shell.stiffness * (1 + 0.02j) - omega**2 * shell.mass
    Z = Z + (2000j * omega - 12 * omega**2) * shell.patch_overlap["P"]
    force = shell.at_quadrature.T @ (shell.quadrature_weight * shell.quadrature_position[:, 0])
    whole = shell.at_points @ spsolve(Z.tocsc(), force)
    of_basis = (shell.at_points @ V) @ np.linalg.solve(V.T @ (Z @ V), V.T @ force)
    assert abs(of_basis / whole - 1) < 5e-3
    of_modes = V[:, : len(shapes.frequency)]
    modal = np.linalg.solve(of_modes.T @ (Z @ of_modes), of_modes.T @ force)
    assert abs(shell.at_points @ of_modes @ modal / whole - 1) > 5e-3  # the residual vectors matter


@pytest.mark.parametrize("section", [SKEW, SolidSection(E, 0.3, RHO, 8e-3)])
def test_a_free_plate_has_the_same_modes_wherever_its_nodes_are(section):
    mesh = grid((3, 2), (0.0, 0.0), (0.6, 0.4))
    middle, below = (Layup(section, offset=z) for z in (0.0, 7e-3))
    wanted, found = (normal_modes(assemble_shell(mesh, one), 600.0)[0] for one in (middle, below))
    assert np.count_nonzero(wanted > 1) > 3
    np.testing.assert_allclose(found[wanted > 1], wanted[wanted > 1], rtol=1e-4)
    # bent about its middle it has the same strains and stresses
    bend = np.array([1.0, -0.4, 0.3])
    for first, second in zip(middle.layers, below.layers, strict=True):
        motion = np.r_[bend, 0, 0, 0], np.r_[bend, -7e-3 * bend / below.half]
        for rows, moved in ((first.strain, second.strain), (first.stress, second.stress)):
            np.testing.assert_allclose(moved @ motion[1], rows @ motion[0], rtol=1e-9)


def test_a_patch_that_moves_with_the_supports_has_the_overlaps_of_a_rigid_motion():
    mesh = grid((2, 2), (-0.5, -0.5), (0.5, 0.5), on_paraboloid(0.5))
    mesh = mesh.with_names({"P": Box((0.0, 0.0, -1.0), (0.5, 0.5, 1.0))}, {})
    shell = assemble_shell(mesh, Layup(SANDWICH))
    _, nodes = mesh.nodes(4)
    motions, overlap = rigid_motions(shell, nodes)[:, :3], shell.patch_overlap["P"]
    *forces, x, y, z = shell.patch_translation[0]
    pushed = overlap @ motions
    assert np.allclose(forces, pushed, rtol=0, atol=1e-12 * np.abs(pushed).max())
    assert np.allclose([x, y, z], motions.T @ pushed, rtol=1e-10)


def test_an_axis_along_the_normal_and_a_cell_without_section_are_refused():
    mesh = grid((2, 2), (0.0, 0.0), (0.5, 0.5))
    with pytest.raises(ValueError, match="along the normal"):
        assemble_shell(mesh, Layup(SKEW, (0.0, 0.0, 1.0)))
    assemble_shell(mesh, Layup(SolidSection(70e9, 0.3, 2700.0, 1e-3), (0.0, 0.0, 1.0)))
    with pytest.raises(ValueError, match="0 sections; it needs one"):
        assemble_shell(mesh, {})


def test_a_clamped_disc_turns_in_its_plane_as_in_the_closed_form():
    # the rotation about the normal is held at clamped nodes, and jumps there
    section, held = SolidSection(E, 0.3, RHO, 5e-3), Box((-FAR,) * 3, (FAR,) * 3)
    inner, outer = 0.12, 0.6
    mesh = mesh_surface(paraboloid(2 * outer, 1e4, 2 * inner), 0.15)
    shell = assemble_shell(
        mesh, Layup(section),
        {"hub": ShellSupport(Ring(0.0, inner)), "flat": ShellSupport(held, (Z,), (X, Y))},
    )  # fmt: skip

    def twist_at_rim(k):  # u = J₁(kr) Y₁(ka) − Y₁(kr) J₁(ka), u′ = u/r at the rim
        slope = jvp(1, k * outer) * y1(k * inner) - yvp(1, k * outer) * j1(k * inner)
        return k * slope - (j1(k * outer) * y1(k * inner) - y1(k * outer) * j1(k * inner)) / outer

    k = brentq(twist_at_rim, 0.5, 4.0)
    expected = k * np.sqrt(E / 2.6 / RHO) / (2 * np.pi)
    frequency, _ = normal_modes(shell, 2.0 * expected)
    assert np.abs(frequency / expected - 1).min() < 5e-4
