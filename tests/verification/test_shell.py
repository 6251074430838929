"""Curved shells against benchmarks, closed forms and other solvers."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.linalg as la

from pidpanel.panel.eigen import factors
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import ShellSupport
from pidpanel.shell.drawing import cylinder_panel, mesh_surface, paraboloid
from pidpanel.shell.resolution import element_size
from pidpanel.shell.selections import Ring, Sphere
from pidpanel.shell.strains import Layup
from tests.shells import (
    ALUMINIUM,
    FACE,
    SANDWICH,
    X,
    Y,
    Z,
    grid,
    mirror,
    on_cylinder,
    plane,
    stiffened,
)

pytestmark = [pytest.mark.verification, pytest.mark.slow]
METHOD = "degenerated shell of order 4, {} triangles"


def displacement(shell, force, position, direction):
    motion = shell.displacement(np.array([position]))
    row = sum(share * part for share, part in zip(direction, motion, strict=True))
    load = row.toarray()[0] * force if np.ndim(force) == 0 else force
    return (row @ factors(shell.stiffness).solve(load)).item()


def test_roof_hemisphere_and_cylinder_deflect_as_published(record):
    turn = np.radians(40)
    roof = grid((8, 8), (0, 0), (25, 25 * turn), on_cylinder(25.0))
    ends = {
        "end": ShellSupport(plane(0, 0), (Y, Z), ()), "middle": mirror(0, 25), "crown": mirror(1, 0)
    }  # fmt: skip
    shell = assemble_shell(roof, Layup(SolidSection(4.32e8, 0.0, 90 / 0.25, 0.25)), ends)
    edge = (25, 25 * np.sin(turn), 25 * np.cos(turn))
    record(
        "vertical deflection at the middle of the free edge",
        displacement(shell, -shell.participation[:, 2], edge, (0, 0, -1)), 0.3015,
        unit="m", tolerance=0.005, case="Scordelis-Lo roof, R = 25, L = 50, t = 0.25",
        method=METHOD.format(len(roof.cells)),
        source="MacNeal and Harder (1985): 0.3024; 0.3015 converged in orders 3 and 4",
    )  # fmt: skip

    def on_sphere(p):
        u, v = p[..., 0], p[..., 1]
        return 10 * np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], -1)

    half = grid((8, 8), (0, 0), (np.pi / 2, np.radians(72)), on_sphere)
    top = tuple(on_sphere(np.array([0, np.radians(72)])).tolist())
    held = {"x": mirror(0, 0), "y": mirror(1, 0), "z": ShellSupport(Sphere(top, 1e-6), (Z,), ())}
    shell = assemble_shell(half, Layup(SolidSection(6.825e7, 0.3, 1.0, 0.04)), held)
    (x, _, _), (_, y, _) = (shell.displacement(np.array([p])) for p in ((10, 0, 0), (0, 10, 0)))
    pull = (x - y).toarray()[0]
    record(
        "displacement under a force", (x @ factors(shell.stiffness).solve(pull)).item(), 0.0934,
        unit="m", tolerance=0.005, case="Pinched hemisphere with a hole of 18°, t = 0.04, R = 10",
        method=METHOD.format(len(half.cells)), source="MacNeal and Harder (1985), 0.0924 to 0.094",
    )  # fmt: skip

    octant = grid((8, 8), (0, 0), (300, 150 * np.pi), on_cylinder(300.0))
    held = {
        "end": ShellSupport(plane(0, 0), (Y, Z), ()), "middle": mirror(0, 300),
        "y": mirror(1, 0), "z": mirror(2, 0),
    }  # fmt: skip
    shell = assemble_shell(octant, Layup(SolidSection(3e6, 0.3, 1.0, 3.0)), held)
    record(
        "displacement under a force", displacement(shell, -0.25, (300, 0, 300), (0, 0, 1)) * -1,
        1.8248e-5, unit="m", tolerance=0.01, case="Pinched cylinder, R = 300, L = 600, t = 3",
        method=METHOD.format(len(octant.cells)),
        source="Belytschko et al. (1985); with shear the point under a force has no limit",
    )  # fmt: skip


@dataclass(frozen=True)
class FilledSandwich(SandwichSection):
    """A sandwich whose core of 240 MPa resists stretching."""

    @property
    def abd(self):
        A, B, D = (sum(parts) for parts in zip(super().abd, self.core_abd, strict=True))
        return A, B, D

    @property
    def core_abd(self):
        t, stiffness = self.core.thickness, 240e6 * np.diag([1, 1, 0.5])
        return stiffness * t, 0 * stiffness, stiffness * t**3 / 12


MODES = [1, 3, 5, 7, 9, 11, 20, 30]
SOLIDS = [75.604, 102.524, 153.211, 266.012, 286.211, 402.543, 812.902, 1129.476]


def test_a_paraboloid_vibrates_as_in_another_solver(record):
    mesh = mesh_surface(paraboloid(1.2, 0.48, 0.24), element_size(Layup(SANDWICH), 1200.0))
    section = FilledSandwich((FACE,), (FACE,), Core(120e6, 120e6, 50.0, 12e-3))
    hub = {"hub": ShellSupport(Ring(0.0, 0.12))}
    shell = assemble_shell(mesh, Layup(section), hub)
    frequency, _ = normal_modes(shell, 1200.0)
    for mode, solid in zip(MODES, SOLIDS, strict=True):
        record(
            f"frequency of mode {mode}", frequency[mode - 1], solid, unit="Hz", tolerance=0.001,
            case="Sandwich paraboloid of 1.2 m, F = 0.48 m, clamped at a hub of 0.24 m",
            method=METHOD.format(len(mesh.cells)),
            source="CalculiX 2.20, four layers of 48 × 48 C3D20R",
        )  # fmt: skip


def through_thickness(plies, S, inertia, size, waves):
    """Lowest frequency [Hz] of sin and cos along a cylinder panel with sheared normals.

    Strains at a radius R + ζ are exact: ε₂ = (v,₂ + ζβ₂,₂ + w/R)/(1 + ζ/R), and so on.
    """
    radius, (a, b) = size[0], size[1:]
    p, q = waves[0] * np.pi / a, waves[1] * np.pi / b
    K = np.zeros((5, 5))
    for Q, low, high in plies:
        for x, weight in zip(*np.polynomial.legendre.leggauss(4), strict=True):
            z = (low + high) / 2 + (high - low) / 2 * x
            f = 1 + z / radius
            strain = np.array(
                [
                    [-p, 0, 0, -p * z, 0],
                    [0, -q / f, 1 / radius / f, 0, -q * z / f],
                    [q / f, p, 0, q * z / f, p * z],
                ]
            )
            K += weight * (high - low) / 2 * f * strain.T @ Q @ strain
    shear = np.array([[0, 0, p, 1, 0], [0, -1 / radius, q, 0, 1]])
    m, first, second = inertia
    M = np.diag([m, m, m, second, second])
    M[0, 3] = M[3, 0] = M[1, 4] = M[4, 1] = first
    return np.sqrt(la.eigvalsh(K + shear.T @ S @ shear, M)[0]) / (2 * np.pi)


TAPE = Material(130e9, 9e9, 5e9, 0.3, 1600.0)
CROSS = (Ply(TAPE, 0.5e-3, 0.0), Ply(TAPE, 0.5e-3, np.pi / 2))
SIZES = {"aluminium": (1.0, 0.5, 0.4), "sandwich": (1.0, 0.8, 0.6), "[0/90]": (1.0, 0.5, 0.4)}
# Section and plies (Q, from, to) [Pa, m] from the inside; a core without shear of its own between
# two plies stands for a laminate without a core.
PANELS = {
    "aluminium": (
        SolidSection(70e9, 0.3, 2700.0, 2e-3), [(ALUMINIUM.stiffness, -1e-3, 1e-3)]
    ),
    "sandwich": (
        SANDWICH, [(FACE.stiffness, 6e-3, 6.3e-3), (FACE.stiffness, -6.3e-3, -6e-3)]
    ),
    "[0/90]": (
        SandwichSection(CROSS[1:], CROSS[:1], Core(3e9, 3e9, 0.0, 1e-5)),
        [(CROSS[0].stiffness, -5.05e-4, -5e-6), (CROSS[1].stiffness, 5e-6, 5.05e-4)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PANELS)
def test_cylinder_panels_vibrate_as_in_the_closed_form(record, name):
    (section, plies), (radius, length, arc) = PANELS[name], SIZES[name]
    layup, half = Layup(section), arc / radius / 2
    expected = sorted(
        through_thickness(plies, section.shear, layup.density, SIZES[name], (i, j))
        for i in range(1, 12) for j in range(1, 12)
    )[:8]  # fmt: skip
    mesh = mesh_surface(cylinder_panel(radius, length, arc), element_size(layup, expected[-1]))
    held = {"": ShellSupport(plane(0, 0), (Y, Z), (X,))}
    held["far"] = ShellSupport(plane(0, length), (Y, Z), (X,))
    for turn in (-half, half):
        normal, across = (0, np.sin(turn), np.cos(turn)), (0, np.cos(turn), -np.sin(turn))
        held[f"{turn}"] = ShellSupport(plane(1, radius * np.sin(turn)), (X, normal), (across,))
    frequency, _ = normal_modes(assemble_shell(mesh, layup, held), 1.2 * expected[-1])
    # in-plane families that the closed form has as further branches
    near = [float(frequency[np.abs(frequency - f).argmin()]) for f in expected]
    for mode, pair in enumerate(zip(near, expected, strict=True), 1):
        record(
            f"frequency {mode}", *pair, unit="Hz", tolerance=0.003,
            case=f"Cylinder panel, {name}, R = {radius:g} m, {length:g} m × {arc:g} m, supported",
            method=METHOD.format(len(mesh.cells)),
            source="sin and cos with sheared normals, integrated through the thickness",
        )  # fmt: skip


@pytest.mark.parametrize("height", [0.01, 0.02])
def test_a_stiffened_panel_vibrates_as_one_with_blades_of_shells(record, height):
    shells, beams = stiffened(height, 0.002, (0.1, 0.3), {})
    rigid = np.sum(shells == 0)
    for mode in range(rigid, 14):
        record(
            f"frequency of mode {mode - rigid + 1}", beams[mode], shells[mode], unit="Hz",
            tolerance=0.003, method="beams with an offset along edges of shells of order 4",
            case=f"Free panel of 0.6 m × 0.4 m × 2 mm with two blades of {1e3 * height:g} mm × 2 mm",
            source="blades as shells with T-joints",
        )  # fmt: skip
