"""Modal force, added mass and panels with free edges compared with independent integrals."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from skfem import MeshQuad, MeshTri

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.field import diffuse_modal_force, wavenumber
from pidpanel.sound.free_edges import FreePanel, Jumps
from pidpanel.sound.outline import OutlineJumps
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.rectangle import RectangleJumps
from pidpanel.verification.rows import Row, cases_of, comparison

SIDES = (1.5, 1.0)
SPEED = 343.0
ELEMENTS = (30, 20)

# Z of mode (1, 1) at 64.90 Hz [m³] by boundary elements in space: bilinear jumps on squares, the
# kernel exp(ikR)/4πR of the hypersingular operator integrated over their correlations; squares of
# 1/10, 1/20 and 1/40 m extrapolated in powers h and h² (`tests/sound/hats.py`).
BY_ELEMENTS = 0.270163 + 0.0093182j

WAVENUMBERS = np.linspace(0.5, 8.0, 10)  # [rad/m]

FACE = 40.0  # wavenumber to which the faces are condensed [rad/m]


def sine_panel(
    modes: list[tuple[int, int]], elements: tuple[int, int] = ELEMENTS
) -> PanelQuadrature:
    """Return products of sines at 3 × 3 Gauss points of each element of the paper's panel."""
    node, weight = np.polynomial.legendre.leggauss(3)
    axes = []
    for side, count in zip(SIDES, elements, strict=True):
        edge = side / count
        positions = ((np.arange(count)[:, None] + 0.5 + node / 2) * edge).ravel()
        axes.append((positions, np.tile(weight * edge / 2, count)))
    x, y = (axis.ravel() for axis in np.meshgrid(axes[0][0], axes[1][0], indexing="ij"))
    shape = [np.sin(m * np.pi * x / SIDES[0]) * np.sin(n * np.pi * y / SIDES[1]) for m, n in modes]
    area = np.outer(axes[0][1], axes[1][1]).ravel()
    return PanelQuadrature(np.stack([x, y], axis=1), area, np.stack(shape, axis=1))


def disc_mesh(radius: float, refinements: int = 4) -> tuple[Array, Index]:
    """Return vertices (n, 2) [m] and triangles of a disc."""
    mesh = MeshTri.init_circle(refinements)
    return radius * mesh.p.T, mesh.t.T


def l_mesh(refinements: int = 3) -> tuple[Array, Index]:
    """Return vertices (n, 2) [m] and triangles of an L of 1 m with arms of 0.5 m."""
    mesh = MeshTri.init_lshaped().refined(refinements)
    return (mesh.p.T + 1) / 2, mesh.t.T


def uniform_face(vertices: Array, cells: Index) -> PanelQuadrature:
    """Return a mesh that moves as one and tilts about y, condensed."""
    quadrature = OutlineJumps.of_mesh(vertices, cells, 1.0).functions
    shape = np.stack([np.ones(len(quadrature.weight)), quadrature.position[:, 0]], axis=1)
    return condensed(PanelQuadrature(quadrature.position, quadrature.weight, shape), FACE)


def impedances(panel: FreePanel, face: PanelQuadrature, wavenumbers: Array) -> Complexes:
    """Return the diagonal of Z (nk, n) [m³]."""
    couplings = panel.jumps.couplings(face)
    return np.array([np.diagonal(panel.impedance(k, couplings)) for k in wavenumbers])


def load_by_waves(panel: FreePanel, face: PanelQuadrature, k: float) -> Array:
    """Return the load (n,) [m⁴] of a room per mean square of its pressure, as a mean of waves."""
    couplings, count = panel.jumps.couplings(face), int(k * panel.jumps.diameter / 2) + 12
    cosine, weight = np.polynomial.legendre.leggauss(count)
    incidence = np.arccos((1 + cosine) / 2)
    azimuth = np.pi / count * np.arange(2 * count)
    pairs = np.repeat(incidence, azimuth.size), np.tile(azimuth, count)
    square = np.abs(panel.wave_forces(k, *pairs, couplings)) ** 2
    return np.asarray(weight / 2 @ square.reshape(count, azimuth.size, -1).mean(axis=1))


def disc_rows(_: Path) -> Iterator[Row]:
    """Return the added volume of a free disc and the load on it for long waves."""
    radius, k = 0.5, 0.05
    vertices, cells = disc_mesh(radius, 5)
    panel = FreePanel.of_jumps(OutlineJumps.of_mesh(vertices, cells, 2.0), 1.0)
    impedance = impedances(panel, uniform_face(vertices, cells), np.array([k]))[0, 0]
    volume, load = 8 * radius**3 / 3, (8 * k * radius**3 / 3) ** 2 / 3
    row = comparison("free_disc").row
    yield row("added volume over that in closed form, ka = 0.025", impedance.real / volume, 1.0, k)
    yield row("load over that in closed form", 4 * np.pi / k * impedance.imag / load, 1.0, k)


def reciprocity_rows(_: Path) -> Iterator[Row]:
    """Return the load by plane waves over that from Im Z, the worst of ten wavenumbers."""
    k_max, resolved = float(WAVENUMBERS[-1]), 10.0
    rectangle = RectangleJumps.of_box([0, 0], SIDES, resolved)
    cases: dict[str, tuple[Jumps, PanelQuadrature]] = {"rectangle, modes (1, 1) and (2, 1)": (
        rectangle, condensed(sine_panel([(1, 1), (2, 1)]), FACE)
    )}  # fmt: skip
    for name, mesh in {
        "L, moves as one and tilts": l_mesh(),
        "disc, moves as one and tilts": disc_mesh(0.6),
    }.items():
        cases[name] = OutlineJumps.of_mesh(*mesh, resolved), uniform_face(*mesh)
    for name, (jumps, face) in cases.items():
        panel = FreePanel.of_jumps(jumps, k_max)
        loads = 4 * np.pi * impedances(panel, face, WAVENUMBERS).imag / WAVENUMBERS[:, None]
        by_waves = np.array([load_by_waves(panel, face, k) for k in WAVENUMBERS])
        ratio = (by_waves / loads).ravel()
        worst = ratio[np.argmax(np.abs(ratio - 1))]
        yield comparison("reciprocity").row(f"{name}: worst ratio of loads", worst, 1.0, k_max)


def rectangle_rows(_: Path) -> Iterator[Row]:
    """Return load and mass of the paper's panel, by two sets of functions and in the limits."""
    k = float(wavenumber(64.90, SPEED))
    face = condensed(sine_panel([(1, 1)]), FACE)
    jumps = RectangleJumps.of_box([0, 0], SIDES, 12.0)
    panel = FreePanel.of_jumps(jumps, 12.0)
    impedance = impedances(panel, face, np.array([k, 10.0]))[:, 0]
    row = comparison("free_rectangle").row
    for name, value, reference in (
        ("mass", impedance[0].real, BY_ELEMENTS.real),
        ("load", impedance[0].imag, BY_ELEMENTS.imag),
    ):
        yield row(f"{name} over that by boundary elements", value / reference, 1.0, 64.9)
    mesh = MeshQuad.init_tensor(np.linspace(0, SIDES[0], 31), np.linspace(0, SIDES[1], 21))
    other = FreePanel.of_jumps(OutlineJumps.of_mesh(mesh.p.T, mesh.t.T, 12.0), 12.0)
    by_torsion = impedances(other, face, np.array([k, 10.0]))[:, 0]
    row = comparison("free_outline").row
    for name, value, reference in (
        ("mass", by_torsion[0].real, impedance[0].real),
        ("load", by_torsion[0].imag, impedance[0].imag),
        ("load at 546 Hz", by_torsion[1].imag, impedance[1].imag),
    ):
        yield row(f"{name} by functions of any outline", value / reference, 1.0, 64.9)
    faces = 4 * diffuse_modal_force(10.0, sine_panel([(1, 1)]))[0, 0]
    load = 4 * np.pi / 10.0 * impedance[1].imag
    quantity = "load over that of two independent faces, 546 Hz"
    yield comparison("independent_faces").row(quantity, load / faces, 1.0, 546.0)


def wall_rows(_: Path) -> Iterator[Row]:
    """Return the air spring of a closed gap, and a far wall."""
    gap, low, high = 0.001, 1.0, 3.0
    jumps = RectangleJumps.of_box([0, 0], SIDES, 4.0)
    panel = FreePanel.of_jumps(jumps, high, gap)
    # ψ = (1 − ξ²)^(3/2) (1 − η²)^(3/2), from the functions of degree 0 and 2: flat at the edges
    even = [(np.arange(0, side.degree.size, 2).size) for side in (jumps.x, jumps.y)]
    parts = [np.zeros(count) for count in even]
    for part in parts:
        part[:2] = 3 / 4, -1 / 4
    jump = np.kron(*parts)
    square = np.prod([16 / 35 * 2 * side.half for side in (jumps.x, jumps.y)])
    at_low, at_high = (jump @ panel.operator[0].matrix([k])[0].real @ jump for k in (low, high))
    spring = (at_low - at_high) / ((high**2 - low**2) * square * gap)
    quantity = "spring over that of the closed gap, ρc²/d, d = 1 mm"
    yield comparison("wall").row(quantity, 1 / spring, 1.0, gap)


# ---- in a rigid wall

# Mode → frequency [Hz], G_ii [m⁴] by adaptive quadrature of the double integral in the distance,
# where the autocorrelations of the sines are closed forms; five figures.
JOINT_ACCEPTANCE = {
    (1, 1): (64.90, 0.34386),
    (3, 3): (584.1316, 0.028115),
    (9, 1): (1662.5284, 0.0032727),
}

# Mode → V at k = 0 [m³] by the same; five figures.
ADDED_VOLUME = {(1, 1): 0.18613, (3, 2): 0.04819}


def field_rows(_: Path) -> Iterator[Row]:
    """Return joint acceptances, a radiation efficiency and added masses of a 1.5 m × 1 m panel."""
    force = comparison("modal_force")
    panel = sine_panel(list(JOINT_ACCEPTANCE))
    for index, (mode, (frequency, reference)) in enumerate(JOINT_ACCEPTANCE.items()):
        k = float(wavenumber(frequency, SPEED))
        G = diffuse_modal_force(k, panel)
        quantity = f"modal force G of mode {mode} at {frequency:.2f} Hz"
        yield force.row(quantity, G[index, index], reference, frequency)
        if mode == (1, 1):
            # by reciprocity G_ii = (2π/k²) σ_i ∫φ_i² dA
            sigma = k**2 * G[0, 0] / (2 * np.pi * panel.product_integral[0, 0])
            quantity = f"radiation efficiency of mode (1, 1) at {frequency:.2f} Hz"
            yield comparison("efficiency").row(quantity, sigma, 0.2063, frequency)
    static = tabulate_added_mass(36.6, sine_panel(list(ADDED_VOLUME))).matrix([0.0])[0]
    mass = comparison("added_mass")
    for i, (mode, volume) in enumerate(ADDED_VOLUME.items()):
        yield mass.row(f"added mass over density of mode {mode}, k = 0", static[i, i].real, volume)
    panel = sine_panel([(1, 1)])
    piston = replace(panel, shape=np.ones_like(panel.shape))
    rigid = comparison("piston")
    volume = tabulate_added_mass(36.6, piston).matrix([0.0])[0, 0, 0].real
    yield rigid.row("added mass over density, k = 0", volume, piston_volume(*SIDES))


def piston_volume(a: float, b: float) -> float:
    """Return V = (1/2π) ∬∬ dA dA′/R [m³] over a rectangle of the sides a, b [m].

    By four integrations of 1/R, the energy of a plate of uniform charge.

    Examples
    --------
    Of a square of 1 m, (4/3)(1 − √2 + 3 ln(1 + √2))/2π:

    >>> round(piston_volume(1.0, 1.0), 5)
    0.4732
    """
    d = np.hypot(a, b)
    double = 2 * a**2 * b * np.log((b + d) / a) + 2 * a * b**2 * np.log((a + d) / b)
    return float((double + 2 / 3 * (a**3 + b**3 - d**3)) / (2 * np.pi))


CASES = cases_of(globals())
