"""Structured meshes and symmetry planes of shells, whose triangles have mirror images."""

import numpy as np

from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import AXES, ShellSupport, Stiffener
from pidpanel.shell.drawing import flat_panels, mesh_surface
from pidpanel.shell.mesh import ShellMesh
from pidpanel.shell.selections import Box, Line
from pidpanel.shell.strains import Layup

X, Y, Z = AXES
FAR = 1e6
E, RHO = 70e9, 2700.0
ALUMINIUM = Material.isotropic(70e9, 0.3, 2700.0)
FACE = Ply(Material.isotropic(50e9, 0.3, 1600.0), 0.3e-3)
SANDWICH = SandwichSection((FACE,), (FACE,), Core(120e6, 120e6, 50.0, 12e-3))


def plane(axis, at):
    low, high = [-FAR] * 3, [FAR] * 3
    low[axis] = high[axis] = at
    return Box(tuple(low), tuple(high))


def mirror(axis, at):
    """Support of a plane of symmetry."""
    along = AXES[axis]
    return ShellSupport(plane(axis, at), (along,), tuple(e for e in AXES if e != along))


def grid(
    counts, low, high, surface=lambda p: np.pad(p, [(0, 0)] * (p.ndim - 1) + [(0, 1)]), order=4
):
    """Rectangles in two triangles each, of parameters from low to high, on a surface."""
    x, y = (np.linspace(a, b, n + 1) for a, b, n in zip(low, high, counts, strict=True))
    places = np.stack(np.meshgrid(x, y, indexing="ij"), -1).reshape(-1, 2)
    number = np.arange(len(places)).reshape(len(x), len(y))
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    cells = np.concatenate([np.stack([b, c, d], 1), np.stack([b, d, a], 1)])
    return ShellMesh.from_triangles(places, cells, surface, order)


def on_cylinder(radius):
    """(x, arc length) → place, the crown on top."""
    return lambda p: np.stack(
        [p[..., 0], radius * np.sin(p[..., 1] / radius), radius * np.cos(p[..., 1] / radius)], -1
    )


def on_paraboloid(focal_length):
    return lambda p: np.concatenate(
        [p[..., :2], np.sum(p[..., :2] ** 2, -1, keepdims=True) / (4 * focal_length)], -1
    )


def stiffened(height, thickness, blades, held):
    """Frequencies of a panel with blades: as shells with T-joints, and as beams."""
    panel = {"p": [(0, 0, 0), (0.6, 0, 0), (0.6, 0.4, 0), (0, 0.4, 0)]}
    walls = {
        f"b{y}": [(0, y, 0), (0.6, y, 0), (0.6, y, height), (0, y, height)] for y in blades
    }  # fmt: skip
    layup = {"p": Layup(SolidSection(E, 0.3, RHO, 2e-3))}
    blade = Layup(SolidSection(E, 0.3, RHO, thickness))
    shells = mesh_surface(flat_panels(panel | walls), 0.1)
    lines = [Line((0, y, 0), (0.6, y, 0)) for y in blades]
    beams = {
        f"s{k}": Stiffener(
            line, E, ALUMINIUM.G12, RHO, thickness * height, thickness * height**3 / 12,
            height * thickness**3 / 3, height / 2,
        )
        for k, line in enumerate(lines)
    }  # fmt: skip
    return [
        normal_modes(shell, 300.0)[0]
        for shell in (
            assemble_shell(shells, layup | dict.fromkeys(walls, blade), held),
            assemble_shell(mesh_surface(flat_panels(panel), 0.1, lines), layup["p"], held | beams),
        )
    ]
