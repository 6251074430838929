"""Feet, hinges, masses and stiffeners of shells."""

import numpy as np
import pytest

from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import SolidSection
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import Hinge, PointMass, RigidFoot, ShellSupport, Stiffener
from pidpanel.shell.drawing import flat_panels, mesh_surface
from pidpanel.shell.selections import Box, Line, Sphere
from pidpanel.shell.strains import Layup
from tests.shells import ALUMINIUM, RHO, SANDWICH, E, grid, plane, stiffened

G = ALUMINIUM.G12
STIFF = SolidSection(7e12, 0.3, 1000.0, 10e-3)  # 10 kg/m², hardly bends
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def test_two_stiff_panels_swing_about_their_hinge_as_two_rigid_bodies():
    """Two squares of 1 m: the spring sees I₁I₂/(I₁ + I₂) of free bars joined at a hinge."""
    panels = {"a": SQUARE, "b": [(x + 1.1, y, z) for x, y, z in SQUARE]}
    mesh = mesh_surface(flat_panels(panels), 0.7)
    parts, spring = {}, 50.0
    for name, x in (("a", 1.0), ("b", 1.1)):
        parts[name] = RigidFoot(Box((x, -1, -1), (x, 2, 1)), (x, 0.5, 0.0))
    parts["hinge"] = Hinge(("a", "b"), (1.05, 0.5, 0.0), (0.0, 1.0, 0.0), spring)
    frequency, _ = normal_modes(assemble_shell(mesh, Layup(STIFF), parts), 5.0, 8)
    assert np.sum(frequency == 0) == 6
    # mass m each, centre at c of the hinge, J about it: symmetric motion, the hinge rises
    m, c, J = 10.0, 0.55, 10.0 / 12
    effective = J + m * c**2 - (2 * m * c) ** 2 / (4 * m)
    assert frequency[6] == pytest.approx(
        np.sqrt(4 * spring / (2 * effective)) / (2 * np.pi), rel=2e-3
    )


def test_a_foot_with_a_heavy_mass_holds_and_one_without_does_not_add_any():
    mesh = grid((4, 4), (0.0, 0.0), (0.6, 0.4))
    where = Sphere((0.0, 0.0, 0.0), 0.16)
    held = assemble_shell(
        mesh, Layup(SANDWICH), {"foot": RigidFoot(where, (0, 0, 0), ShellSupport(where))}
    )
    heavy = RigidFoot(where, (0, 0, 0), mass=1e6, inertia=(1e6, 1e6, 1e6))
    loose = assemble_shell(mesh, Layup(SANDWICH), {"foot": heavy})
    expected, _ = normal_modes(held, 1.0, 5)
    frequency, _ = normal_modes(loose, 1.0, 11)
    assert np.allclose(frequency[6:], expected, rtol=1e-5)
    assert loose.total_mass == pytest.approx(1e6 + SANDWICH.mass_per_area * 0.24)
    hinged = RigidFoot(where, (0, 0, 0), ShellSupport(where, rotation=()))
    frequency, _ = normal_modes(assemble_shell(mesh, Layup(SANDWICH), {"foot": hinged}), 1.0, 5)
    assert np.sum(frequency == 0) == 3


def test_a_mass_lowers_a_mode_by_its_share_of_the_kinetic_energy():
    mesh = grid((3, 2), (0.0, 0.0), (0.6, 0.4)).with_names({}, {"A": (0.45, 0.2, 0.0)})
    held = {"edge": ShellSupport(plane(0, 0.0))}
    bare = assemble_shell(mesh, Layup(SANDWICH), held)
    frequency, modes = normal_modes(bare, 1.0, 3)
    mass = 1e-5
    loaded = assemble_shell(mesh, Layup(SANDWICH), held | {"m": PointMass((0.45, 0.2, 0.0), mass)})
    lower, _ = normal_modes(loaded, 1.0, 3)
    shape = (bare.at_points @ modes)[0]
    share = mass * shape**2 / np.einsum("ki,ki->i", modes, bare.mass @ modes)
    assert np.allclose(1 - lower / frequency, share / 2, rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize("is_held", [False, True])
def test_stiffeners_are_blades_of_shells(is_held):
    held = {"end": ShellSupport(Box((0, -1, -1), (0, 1, 1)))} if is_held else {}
    shells, beams = stiffened(20e-3, 2e-3, (0.1, 0.3), held)
    rigid = np.sum(shells == 0)
    count = min(len(shells), len(beams))
    assert count > 10
    assert np.allclose(beams[rigid:count], shells[rigid:count], rtol=3e-3)


def test_a_stiffener_off_every_edge_is_refused():
    mesh = grid((2, 2), (0.0, 0.0), (0.6, 0.4))
    beam = Stiffener(Line((0, 0.1, 0), (0.6, 0.1, 0)), E, G, RHO, 1e-4, 1e-9, 1e-10)
    with pytest.raises(ValueError, match="rib at Line"):
        assemble_shell(mesh, Layup(SANDWICH), {"rib": beam})
