"""Modal force, added mass and panels with free edges against independent integrals."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.special import spherical_jn, spherical_yn
from skfem import MeshQuad, MeshTri

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.field import diffuse_modal_force, wavenumber
from pidpanel.sound.free_edges import FreePanel, FreeSurface
from pidpanel.sound.outline import OutlineJumps
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.rectangle import RectangleJumps
from pidpanel.sound.surface import tabulate_diffuse_surface
from pidpanel.sound.triangles import SurfaceJumps
from tests.sound.hats import BY_ELEMENTS
from tests.sound.panels import SIDES, l_mesh, sine_panel
from tests.sound.surfaces import oriented, plate, sphere, sphere_mesh

pytestmark = [pytest.mark.verification, pytest.mark.slow]

SPEED = 343.0
FACE = 40.0  # wavenumber to which the faces are condensed [rad/m]


@pytest.fixture
def free(record):
    return partial(record, tolerance=0.01, method="Chebyshev functions in wavenumbers")


def disc_mesh(radius, refinements=4):
    mesh = MeshTri.init_circle(refinements)
    return radius * mesh.p.T, mesh.t.T


def uniform_face(vertices, cells):
    """A mesh that moves as one and tilts about y."""
    points = OutlineJumps.of_mesh(vertices, cells, 1.0).functions
    shape = np.stack([np.ones(len(points.weight)), points.position[:, 0]], axis=1)
    return condensed(PanelQuadrature(points.position, points.weight, shape), FACE)


def impedances(panel, face, wavenumbers):
    """The diagonal of Z (nk, n) [m³]."""
    couplings = panel.jumps.couplings(face)
    return np.array([np.diagonal(panel.impedance(k, couplings)) for k in wavenumbers])


def load_by_waves(panel, face, k):
    """Load (n,) [m⁴] of a room per mean square of its pressure, as a mean of waves."""
    couplings, count = panel.jumps.couplings(face), int(k * panel.jumps.diameter / 2) + 12
    cosine, weight = np.polynomial.legendre.leggauss(count)
    incidence = np.arccos((1 + cosine) / 2)
    azimuth = np.pi / count * np.arange(2 * count)
    pairs = np.repeat(incidence, azimuth.size), np.tile(azimuth, count)
    square = np.abs(panel.wave_forces(k, *pairs, couplings)) ** 2
    return weight / 2 @ square.reshape(count, azimuth.size, -1).mean(axis=1)


def test_a_free_disc_in_long_waves_has_its_closed_forms(free):
    # triangles leave a polygon of 64 corners, of 0.2 % less area
    radius, k = 0.5, 0.05
    vertices, cells = disc_mesh(radius, 5)
    panel = FreePanel.of_jumps(OutlineJumps.of_mesh(vertices, cells, 2.0), 1.0)
    impedance = impedances(panel, uniform_face(vertices, cells), [k])[0, 0]
    volume, load = 8 * radius**3 / 3, (8 * k * radius**3 / 3) ** 2 / 3
    row = partial(
        free, case="Disc that hangs free in a room, long waves",
        method="functions of any outline on triangles",
        source="8a³/3 and (8ka³/3)²/3, from the jump (4/π) √(a² − r²) per velocity potential "
        "(Lamb, §102)",
    )  # fmt: skip
    row("added volume over that in closed form, ka = 0.025", impedance.real / volume, 1.0)
    row("load over that in closed form", 4 * np.pi / k * impedance.imag / load, 1.0)


def rectangle_case():
    return RectangleJumps.of_box([0, 0], SIDES, 10.0), condensed(sine_panel([(1, 1), (2, 1)]), FACE)


def outline_case(mesh):
    return OutlineJumps.of_mesh(*mesh, 10.0), uniform_face(*mesh)


@pytest.mark.parametrize(
    ("name", "jumps_and_face"),
    [
        ("rectangle, modes (1, 1) and (2, 1)", rectangle_case),
        ("L, moves as one and tilts", lambda: outline_case(l_mesh())),
        ("disc, moves as one and tilts", lambda: outline_case(disc_mesh(0.6))),
    ],
)
def test_plane_waves_load_a_panel_as_its_radiation_says(free, name, jumps_and_face):
    jumps, face = jumps_and_face()
    wavenumbers = np.linspace(0.5, 8.0, 10)
    panel = FreePanel.of_jumps(jumps, 8.0)
    loads = 4 * np.pi * impedances(panel, face, wavenumbers).imag / wavenumbers[:, None]
    ratio = np.array([load_by_waves(panel, face, k) for k in wavenumbers]) / loads
    free(
        f"{name}: worst ratio of loads", ratio.flat[np.argmax(np.abs(ratio - 1))], 1.0,
        tolerance=0.001,
        case="Load of a diffuse room on a free panel, by plane waves and by reciprocity",
        method="mean over plane waves from all sides",
        source="(4π/k) |Im Z|, Shorter and Langley (2005)",
    )  # fmt: skip


def test_the_first_mode_of_a_free_rectangle_is_that_of_other_functions_and_of_limits(free):
    k = float(wavenumber(64.90, SPEED))
    face = condensed(sine_panel([(1, 1)]), FACE)
    panel = FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 12.0), 12.0)
    low, high = impedances(panel, face, [k, 10.0])[:, 0]
    # the elements are extrapolated in their size; with both methods five digits were seen
    row = partial(
        free, tolerance=0.002,
        case="Panel of 1.5 m × 1 m that hangs free in a room, mode (1, 1) at 64.9 Hz",
        source="boundary elements in space, bilinear on squares, extrapolated",
    )  # fmt: skip
    row("mass over that by boundary elements", low.real / BY_ELEMENTS.real, 1.0)
    row("load over that by boundary elements", low.imag / BY_ELEMENTS.imag, 1.0)
    mesh = MeshQuad.init_tensor(np.linspace(0, SIDES[0], 31), np.linspace(0, SIDES[1], 21))
    other = FreePanel.of_jumps(OutlineJumps.of_mesh(mesh.p.T, mesh.t.T, 12.0), 12.0)
    low_by_torsion, high_by_torsion = impedances(other, face, [k, 10.0])[:, 0]
    row = partial(
        free, case="Functions of any outline on a rectangle, mode (1, 1)",
        method="torsion function and polynomials on 30 × 20 elements",
        source="Chebyshev functions in wavenumbers",
    )  # fmt: skip
    row("mass by functions of any outline", low_by_torsion.real / low.real, 1.0)
    row("load by functions of any outline", low_by_torsion.imag / low.imag, 1.0)
    row("load at 546 Hz by functions of any outline", high_by_torsion.imag / high.imag, 1.0)
    faces = 4 * diffuse_modal_force(10.0, sine_panel([(1, 1)]))[0, 0]
    free(
        "load over that of two independent faces, 546 Hz",
        4 * np.pi / 10.0 * high.imag / faces, 1.0, tolerance=0.047,  # 0.2 dB
        case="Panel of 1.5 m × 1 m that hangs free in a room, short waves",
        source="twice the diffuse modal force of a blocked face, on each of two faces",
    )  # fmt: skip


def test_a_close_wall_is_the_air_spring_of_the_gap(free):
    gap, low, high = 0.001, 1.0, 3.0
    jumps = RectangleJumps.of_box([0, 0], SIDES, 4.0)
    panel = FreePanel.of_jumps(jumps, high, gap)
    # ψ = (1 − ξ²)^(3/2) (1 − η²)^(3/2), from the functions of degree 0 and 2: flat at the edges
    parts = [np.zeros(np.arange(0, side.degree.size, 2).size) for side in (jumps.x, jumps.y)]
    for part in parts:
        part[:2] = 3 / 4, -1 / 4
    jump = np.kron(*parts)
    square = np.prod([16 / 35 * 2 * side.half for side in (jumps.x, jumps.y)])
    at_low, at_high = (jump @ panel.operator[0].matrix([k])[0].real @ jump for k in (low, high))
    spring = (at_low - at_high) / ((high**2 - low**2) * square * gap)
    # the tolerance is of order d/a
    free(
        "spring over that of the closed gap, ρc²/d, d = 1 mm", 1 / spring, 1.0,
        case="Free panel before a close wall",
        method="Chebyshev functions in wavenumbers, with the image", source="ρc²/d",
    )  # fmt: skip


@pytest.mark.parametrize("ka", [0.5, 2.0, 5.0])
def test_a_diffuse_field_on_a_sphere_has_its_closed_form(record, ka):
    radius = 0.5
    table = tabulate_diffuse_surface(11.0, sphere(radius))
    for degree, force in enumerate(np.diagonal(table.matrix([ka / radius])[0])):
        expected = (4 * np.pi * radius**2 * spherical_jn(degree, ka)) ** 2 / (2 * degree + 1)
        record(
            f"modal force G of P_{degree}(cos θ) at ka = {ka:g}", force, expected, unit="m4",
            tolerance=1e-9, case="Sphere of 0.5 m in a diffuse field, incident pressure",
            method="Legendre polynomials in depth, plane waves",
            source="(4πa² j_l(ka))²/(2l + 1), by the addition theorem of sin(kR)/(kR)",
        )  # fmt: skip


@pytest.fixture
def elements(record):
    return partial(record, method="hats on triangles")


def test_triangles_on_a_flat_panel_are_its_chebyshev_functions(elements):
    mesh = MeshTri.init_tensor(np.linspace(0, SIDES[0], 31), np.linspace(0, SIDES[1], 21))
    panel = FreeSurface.of_hats(SurfaceJumps.of_surface(*oriented(mesh.p.T, mesh.t.T), 10.0), 8.0)
    points = sine_panel([(1, 1), (2, 1)])
    reference = FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 12.0), 8.0)
    wavenumbers = [0.3, 1.2, 3.0, 8.0]
    found = impedances(panel, plate(points, np.eye(3)), wavenumbers)
    expected = impedances(reference, condensed(points, FACE), wavenumbers)
    for k, row, other in zip(wavenumbers, found, expected, strict=True):
        for name, value, exact in zip(("(1, 1)", "(2, 1)"), row, other, strict=True):
            case = "Flat panel of 1.5 m × 1 m that hangs free, as a surface of any form"
            source = "Chebyshev functions in wavenumbers"
            elements(
                f"load of mode {name} over that of a flat panel, k = {k:g}/m",
                value.imag / exact.imag, 1.0, tolerance=0.01, case=case, source=source,
            )  # fmt: skip
            elements(
                f"error of its mass over |Z|, k = {k:g}/m", (value.real - exact.real) / abs(exact),
                0.0, tolerance=0.01, case=case, source=source,
            )  # fmt: skip


def test_triangles_on_a_disc_have_its_closed_forms_in_long_waves(elements):
    radius, k = 0.5, 0.05
    mesh = oriented(*disc_mesh(radius, 5))
    panel = FreeSurface.of_hats(SurfaceJumps.of_surface(*mesh, 1.0), 1.0)
    vertices, cells = disc_mesh(radius, 5)
    points = OutlineJumps.of_mesh(vertices, cells, 1.0).functions
    moved = plate(replace(points, shape=np.ones((len(points.weight), 1))), np.eye(3))
    impedance = impedances(panel, moved, [k])[0, 0]
    volume, load = 8 * radius**3 / 3, (8 * k * radius**3 / 3) ** 2 / 3
    row = partial(
        elements, case="Disc that hangs free in a room, long waves",
        source="8a³/3 and (8ka³/3)²/3 (Lamb, §102)",
    )  # fmt: skip
    row("added volume over that in closed form", impedance.real / volume, 1.0, tolerance=0.01)
    quantity = "load over that in closed form"
    row(quantity, 4 * np.pi / k * impedance.imag / load, 1.0, tolerance=0.015)


@pytest.mark.parametrize("ka", [0.5, 1.0])
def test_a_closed_sphere_has_the_load_of_a_rigid_one(elements, ka):
    # facets of edge h leave an error of order h²: two meshes are extrapolated
    radius, degrees = 0.5, np.arange(3)
    coarse, fine = (
        impedances(
            FreeSurface.of_hats(SurfaceJumps.of_mesh(*sphere_mesh(n, radius)), ka / radius),
            sphere(radius, degrees), [ka / radius],
        )[0]
        for n in (2, 3)
    )  # fmt: skip
    outward = spherical_jn(degrees, ka, True) + 1j * spherical_yn(degrees, ka, True)
    load = (4 * np.pi * radius**2 / ka**2 / np.abs(outward)) ** 2 / (2 * degrees + 1)
    found = 4 * np.pi * radius / ka * (fine + (fine - coarse) / 3).imag
    for degree in degrees:
        elements(
            f"load on P_{degree}(cos θ) at ka = {ka:g}", found[degree], load[degree], unit="m4",
            tolerance=0.01, case="Closed rigid sphere of 0.5 m in a diffuse room",
            source="(4πa²/((ka)² |h_l′(ka)|))²/(2l + 1) (Morse and Ingard, 8.2)",
        )  # fmt: skip


# ---- in a rigid wall; references by adaptive quadrature of the double integral in the distance,
# where the autocorrelations of the sines are closed forms, to five figures


@pytest.fixture
def field(record):
    return partial(
        record, case="Simply supported panel of 1.5 m × 1 m in a diffuse field",
        source="double integral by the autocorrelation of sines",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("mode", "frequency", "reference"),
    [((1, 1), 64.90, 0.34386), ((3, 3), 584.1316, 0.028115), ((9, 1), 1662.5284, 0.0032727)],
)
def test_the_modal_force_of_a_diffuse_field_is_its_double_integral(
    field, mode, frequency, reference
):
    panel, k = sine_panel([mode]), float(wavenumber(frequency, SPEED))
    row = partial(field, method="plane waves, order-5 load quadrature on 30 × 20 elements")
    force = diffuse_modal_force(k, panel).item()
    quantity = f"modal force G of mode {mode} at {frequency:.2f} Hz"
    row(quantity, force, reference, unit="m4", tolerance=3e-5)
    if mode == (1, 1):
        # by reciprocity G_ii = (2π/k²) σ_i ∫φ_i² dA
        sigma = k**2 * force / (2 * np.pi * panel.product_integral.item())
        quantity = f"radiation efficiency of mode (1, 1) at {frequency:.2f} Hz"
        row(quantity, sigma, 0.2063, tolerance=3e-4)


def test_the_added_mass_of_slow_sines_and_of_a_piston_is_their_double_integral(field):
    volumes = {(1, 1): 0.18613, (3, 2): 0.04819}
    row = partial(field, unit="m3", tolerance=0.001, method="integral over wavenumber")
    static = tabulate_added_mass(36.6, sine_panel(list(volumes))).matrix([0.0])[0]
    for i, (mode, volume) in enumerate(volumes.items()):
        row(f"added mass over density of mode {mode}, k = 0", static[i, i].real, volume)
    panel = sine_panel([(1, 1)])
    piston = tabulate_added_mass(36.6, replace(panel, shape=np.ones_like(panel.shape)))
    row(
        "added mass over density, k = 0", piston.matrix([0.0])[0].real.item(),
        piston_volume(*SIDES), case="Rigid piston with free edges, 1.5 m × 1 m",
        source="closed form of ∬∬ dA dA′/R over a rectangle",
    )  # fmt: skip


def piston_volume(a, b):
    """V = (1/2π) ∬∬ dA dA′/R [m³] over a rectangle of the sides a, b [m].

    By four integrations of 1/R, the energy of a plate of uniform charge.
    """
    d = np.hypot(a, b)
    double = 2 * a**2 * b * np.log((b + d) / a) + 2 * a * b**2 * np.log((a + d) / b)
    return (double + 2 / 3 * (a**3 + b**3 - d**3)) / (2 * np.pi)
