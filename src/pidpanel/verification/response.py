"""Response compared with published benchmarks, closed forms and the solution on all elements."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from scipy.integrate import quad
from scipy.interpolate import interp1d
from scipy.optimize import brentq

from pidpanel.arrays import Array
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import PanelBasis, basis_of, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import MODES_BEYOND, Shapes, panel_shapes
from pidpanel.panel.stretching import panel_stretching
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.solve import stress
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import DamperLayout
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, PanelResponse, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.power import power_balance
from pidpanel.solve.solvers import PanelSolver
from pidpanel.solve.stretching import StretchedPanel, duffing_excess, linearised_stiffness
from pidpanel.sound.field import diffuse_modal_force, uniform_modal_force, wavenumber
from pidpanel.verification.rows import Row, cases_of, comparison


def nafems_13r_rows(folder: Path) -> Iterator[Row]:
    """Compute NAFEMS selected benchmarks for forced vibration, tests 13 and 13R (report R0016).

    A square plate of 10 m, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³, 0.05 m thick, simply supported,
    ζ = 2 %, under one pressure of (100 Pa)²/Hz all over its face.
    """
    side, thickness, nu = 10.0, 0.05, 0.3
    rigidity = 200e9 * thickness**3 / (12 * (1 - nu**2))
    section = ThinSection(rigidity, 8000 * thickness, nu, thickness)
    outline = Rectangle((side / 2, side / 2), (side, side))
    finest = 1.25
    for size in (2 * finest, finest):
        path = folder / f"nafems_{size:g}.msh"
        mesh = mesh_triangles(path, outline, size, {}, {"centre": (5.0, 5.0)})
        plate = assemble_thin_plate(mesh, section)
        basis = basis_of(mesh, plate, panel_shapes(plate, 40.0))
        modal = ModalBasis(basis.natural_frequency, basis.modal_mass, 0.02)
        n = basis.natural_frequency.size
        motion = np.concatenate([basis.shape_at_points[:, None], basis.curvature_at_points], axis=1)
        lowest, patches = basis.natural_frequency[:1], Patches(np.zeros((0, n, n)), np.zeros(0))
        force = uniform_modal_force(PanelQuadrature.from_face(basis))
        (bare,) = bare_panels(lowest, modal, [patches], motion, [100.0**2], force)
        response = PanelResponse(bare.frequency, bare.point_psd)
        layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
        values = {
            "displacement PSD at the centre, at the first frequency": (
                response.displacement_psd[0, 0] * 1e6, 2063.20, 2064.24, "mm2/Hz",
            ),
            "extreme-fibre stress PSD at the centre, at the first frequency": (
                stress.layer_psd(response, layers)[0, 0, 0, 3] * 1e-12, 1025.44, 1025.85, "MPa2/Hz",
            ),
        }  # fmt: skip
        count = len(mesh.cells)
        published = comparison("nafems_13r", count=count, modes=n)
        if size != finest:
            published = replace(published, tolerance=np.nan)
        for quantity, (computed, target, closed, unit) in values.items():
            for source, reference in ((published.source, target), ("sine series", closed)):
                stated = replace(published, unit=unit, source=source)
                yield stated.row(quantity, computed, reference, resolution=count)


def miles_rows(_: Path) -> Iterator[Row]:
    """Compute one mode in white noise: ∫₀^∞ |H|² S df = (π/2) f Q S/k² (Miles 1954)."""
    mass, frequency, zeta, force_psd = 2.0, 100.0, 0.02, 4.0
    lines = frequency_grid(1.0, 1e4, zeta, [frequency])
    modal, white = ModalBasis([frequency], [mass], zeta), np.full(lines.size, force_psd)
    patches = Patches(np.zeros((0, 1, 1)), np.zeros(0))
    (bare,) = bare_panels(lines, modal, [patches], [[1.0]], white, np.eye(1))
    stiffness = mass * (2 * np.pi * frequency) ** 2
    expected = np.sqrt(np.pi / 2 * frequency / (2 * zeta) * force_psd) / stiffness
    computed = PanelResponse(lines, bare.point_psd).displacement_rms[0]
    yield comparison("miles").row("rms displacement", computed, expected)


SPEED = 343.0
SIZE, ELEMENTS = (1.5, 1.0), (30, 20)
SECTION = ThinSection(3273.07, 4.0)
POINTS = {"in the middle": (0.75, 0.5), "beside it": (0.35, 0.5), "near an edge": (0.10, 0.30)}
# α [1/s] and β [s] of C = αM + βK: a damping that sparse matrices can have too.
RAYLEIGH = (4.0, 6e-6)


class UniformDamper(NamedTuple):
    """C_e [N s/m³] and m_a [kg/m²] on a patch."""

    damping: float
    mass: float


@dataclass(frozen=True)
class DampedPanel:
    """A panel in its elements and in its modes and residual vectors, with Rayleigh damping."""

    plate: AssembledPlate
    basis: PanelBasis

    @property
    def modal(self) -> ModalBasis:
        """Frequencies, masses and damping of the shapes."""
        omega = 2 * np.pi * self.basis.natural_frequency
        ratio = RAYLEIGH[0] / (2 * omega) + RAYLEIGH[1] * omega / 2
        return ModalBasis(self.basis.natural_frequency, self.basis.modal_mass, ratio)

    def patches(self, dampers: Mapping[str, UniformDamper]) -> Patches:
        """Return the patches with dampers."""
        index = [self.basis.patch_names.index(name) for name in dampers]
        return Patches(self.basis.patch_overlap[index], patch_areas(self.basis)[index])

    def modal_force(self, frequency: Array) -> Array:
        """Return G (nf, n, n) of a diffuse field [m⁴]."""
        face = PanelQuadrature.from_face(self.basis)
        return np.stack([diffuse_modal_force(float(k), face) for k in wavenumber(frequency, SPEED)])

    def psd(self, frequency: Array, force: Array, dampers: Mapping[str, UniformDamper]) -> Array:
        """Return the displacement PSD at the points per S_p, (nf, n_points) [m²/Pa²]."""
        (bare,) = bare_panels(
            frequency, self.modal, [self.patches(dampers)], self.basis.shape_at_points,
            np.ones(frequency.size), force,
        )  # fmt: skip
        damping, mass = _values(dampers, frequency.size)
        return attach_dampers(bare, damping, mass).displacement_psd

    def psd_of_elements(self, frequency: float, dampers: Mapping[str, UniformDamper]) -> Array:
        """Return the displacement PSD at the points from all elements, (n_points,) [m²/Pa²].

        One sparse solve with unit forces at the points; by reciprocity its columns weigh the
        plane waves, 30 × 90 directions.
        """
        plate, omega = self.plate, 2 * np.pi * frequency
        K, M = plate.stiffness, plate.mass
        Z = K - omega**2 * M + 1j * omega * (RAYLEIGH[0] * M + RAYLEIGH[1] * K)
        for name, damper in dampers.items():
            stiffness = 1j * omega * damper.damping - omega**2 * damper.mass
            Z = Z + stiffness * plate.patch_overlap[name]
        pull = plate.interpolate(self.basis.point_position).toarray().T.astype(complex)
        answer = spla.splu(sp.csc_array(Z)).solve(pull)
        k = float(wavenumber(frequency, SPEED))
        cosine, weight = (half[30:] for half in np.polynomial.legendre.leggauss(60))
        load = plate.quadrature_weight[:, None] * (plate.at_quadrature @ answer)  # (nq, points)
        psd = np.zeros(pull.shape[1])
        for azimuth in 2 * np.pi * np.arange(90) / 90:
            distance = plate.quadrature_position @ np.array([np.cos(azimuth), np.sin(azimuth)])
            wave = np.exp(1j * k * np.outer(np.sqrt(1 - cosine**2), distance))
            psd += weight @ np.abs(wave @ load) ** 2 / 90
        return psd


def _values(dampers: Mapping[str, UniformDamper], count: int) -> tuple[Array, Array]:
    """Return C_e and m_a of dampers, (n_dampers, count) each."""
    values = np.array(list(dampers.values())).reshape(-1, 2)
    damping, mass = np.repeat(values.T[:, :, None], count, axis=2)
    return damping, mass


def damped_panel(folder: Path, dampers: Mapping[str, UniformDamper], highest: float) -> DampedPanel:
    """Return the paper's panel with the basis that a study has up to a frequency [Hz]."""
    patches = {name: PATCHES[name] for name in dampers}
    mesh = mesh_quadrilaterals(folder / "panel.msh", SIZE, ELEMENTS, patches, POINTS)
    plate = assemble_thin_plate(mesh, SECTION)
    mass = {name: damper.mass for name, damper in dampers.items()}
    shapes = panel_shapes(plate, MODES_BEYOND * highest, damper_mass=mass)
    return DampedPanel(plate, basis_of(mesh, plate, shapes))


PATCHES = {
    "middle": Rectangle((0.75, 0.5), (0.2, 0.2)),
    "corner": Rectangle((0.1, 0.3), (0.2, 0.2)),
    "over the middle": Rectangle((0.7, 0.45), (0.3, 0.3)),
    "most": Rectangle((0.75, 0.475), (1.4, 0.85)),
}
STRONG = UniformDamper(3000.0, 5.0)
LAYOUTS = {
    "one strong damper": {"middle": STRONG},
    "two dampers": {"middle": UniformDamper(3000.0, 30.0), "corner": UniformDamper(800.0, 5.0)},
    "two that overlap, and a third": {
        "middle": UniformDamper(3000.0, 30.0),
        "corner": UniformDamper(800.0, 5.0),
        "over the middle": UniformDamper(1500.0, 8.0),
    },
    "steel on most of the panel": {"most": UniformDamper(2000.0, 14.0)},
    "tungsten in the middle": {"middle": UniformDamper(2000.0, 150.0)},
}
LINES = (60.0, 300.0, 600.0, 951.0)
HIGHEST = 1000.0


def layouts_rows(folder: Path, names: Collection[str] = tuple(LAYOUTS)) -> Iterator[Row]:
    """Compare layouts of dampers in the basis of a study with all elements."""
    frequency = np.array(LINES)
    for name in names:
        dampers = LAYOUTS[name]
        panel = damped_panel(folder, dampers, HIGHEST)
        computed = panel.psd(frequency, panel.modal_force(frequency), dampers)
        shapes = len(panel.basis.modal_mass)
        layout = comparison("layouts", shapes=shapes, points=len(POINTS))
        for f, psd in zip(LINES, computed, strict=True):
            reference = panel.psd_of_elements(f, dampers)
            worst = int(np.argmax(np.abs(psd / reference - 1)))
            quantity = f"{name}: displacement PSD {list(POINTS)[worst]}, {f:g} Hz"
            yield layout.row(quantity, psd[worst], reference[worst], f)


def power_rows(folder: Path) -> Iterator[Row]:
    """Compare the power lost in panel and damper with the power input of the field."""
    dampers = {"middle": STRONG}
    panel = damped_panel(folder, dampers, HIGHEST)
    frequency = np.array(LINES)
    balance = power_balance(
        frequency, panel.modal, panel.patches(dampers), np.ones(frequency.size),
        panel.modal_force(frequency), *_values(dampers, frequency.size),
    )  # fmt: skip
    lost = balance.structure + balance.patches.sum(axis=1)
    for f, computed, reference in zip(LINES, lost, balance.field, strict=True):
        yield comparison("power").row(f"{f:g} Hz", computed, reference, f)


def duffing_rows(_: Path) -> Iterator[Row]:
    """Compute the rms of a mode with a cubic stiffness in white noise; its density is exp(−V/T).

    The linearised rms with its stated error is that of the density, since the mode is alone.
    """
    duffing = comparison("duffing")
    for cubic in (0.0, 0.01, 0.1, 1.0, 10.0, 100.0):  # k₃T/k²
        tensor = np.full((1, 1, 1, 1), cubic / 2)
        stiffness = linearised_stiffness(tensor, lambda K: 1 / (1 + K))
        share = stiffness[0] / (1 + stiffness[0])
        computed = np.sqrt(1 / (1 + stiffness[0])) * (1 + duffing_excess(share))
        square, norm = (
            quad(lambda x, k=power, c=cubic: x**k * np.exp(-(x**2) / 2 - c * x**4 / 4), 0, 12)[0]
            for power in (2, 0)
        )
        yield duffing.row(f"k₃T/k² = {cubic:g}", computed[0], np.sqrt(square / norm), cubic)


STRETCHED_MODES, HIGHEST_FORCE = 5, 800.0  # number, [Hz]
HISTORIES, DURATION, SETTLING, RATE = 600, 2.5, 0.7, 8192.0  # number, [s], [s], [Hz]
SEED = 5
# Rms displacements in the middle over the thickness.
DEFLECTIONS = {"free": (0.5, 1.0), "held": (0.5, 1.0)}
# Two thin faces: 4 D/t².
STRETCHED_SECTION = replace(
    SECTION, extensional_stiffness=4 * SECTION.bending_stiffness / SECTION.thickness**2
)


def stretching_rows(folder: Path) -> Iterator[Row]:
    """Compute five modes of the paper's panel in a diffuse field, also by time integration.

    The pressure has one PSD up to `HIGHEST_FORCE`, beyond the modes. Its level gives deflections.
    """
    mesh = mesh_quadrilaterals(folder / "panel.msh", SIZE, ELEMENTS, {}, POINTS)
    plate = assemble_thin_plate(mesh, STRETCHED_SECTION)
    shapes = panel_shapes(plate, 600.0)
    basis, n = basis_of(mesh, plate, shapes), STRETCHED_MODES
    face = PanelQuadrature.from_face(basis)
    frequency = np.linspace(1.0, HIGHEST_FORCE, 1600)
    nodes = np.linspace(1.0, HIGHEST_FORCE, 33)
    force = np.stack(
        [diffuse_modal_force(float(k), face)[:n, :n] for k in wavenumber(nodes, SPEED)]
    )
    excitation = ModalForce(
        np.ones_like, lambda f: interp1d(nodes, force, axis=0, fill_value="extrapolate")(f)
    )
    modal = ModalBasis(basis.natural_frequency[:n], basis.modal_mass[:n], 0.01)
    points, patches = basis.shape_at_points[:, :n], Patches(np.zeros((0, n, n)), np.zeros(0))
    solver = PanelSolver(ModalPanel(modal, patches, frequency, points, frequency), excitation)
    (bare,) = bare_panels(frequency, modal, [patches], points, np.ones_like(frequency), excitation)
    linear_rms = PanelResponse(frequency, bare.point_psd).displacement_rms
    for edges, deflections in DEFLECTIONS.items():
        held = Supports() if edges == "held" else None
        modes = Shapes(shapes.frequency[:n], np.zeros(0), shapes.vectors[:, :n])
        stretching = panel_stretching(mesh, plate, modes, 1.0, held)
        if stretching is None:
            raise ValueError("the section of the paper's panel has a neutral plane")
        panel = StretchedPanel(solver, stretching, ())

        def rms(level: float, panel: StretchedPanel = panel) -> Array:
            answer = panel.response(DamperLayout((), level), np.zeros(0))
            return answer.displacement * np.sqrt(level) * linear_rms

        def excess(log_level: float, target: float, rms: Callable[[float], Array] = rms) -> float:
            return float(np.log(rms(10**log_level)[0] / target))

        for deflection in deflections:
            target = deflection * SECTION.thickness
            lowest = 2 * np.log10(target / linear_rms[0])  # without stretching
            level = 10 ** brentq(excess, lowest, lowest + 1.5, (target,))
            simulated = _rms_of_histories(modal, stretching.tensor, excitation, level, points)
            name = "stretching" if edges == "free" or deflection < 1 else "stretching_far"
            row = comparison(name, histories=HISTORIES, duration=DURATION)
            for point, *pair in zip(POINTS, rms(level), simulated, strict=True):
                quantity = f"edges {edges}, w/h = {deflection:g}: rms displacement {point}"
                yield row.row(quantity, *pair)


def _rms_of_histories(
    modal: ModalBasis, tensor: Array, excitation: ModalForce, level: float, points: Array
) -> Array:
    """Return rms displacements (n_points,) [m] by velocity Verlet, from rest."""
    n, steps = len(tensor), int((SETTLING + DURATION) * RATE)
    rng = np.random.default_rng(SEED)
    lines = np.asarray(np.fft.rfftfreq(steps, 1 / RATE), np.float64)
    inside = (lines > 0) & (lines <= HIGHEST_FORCE)
    value, vector = np.linalg.eigh(level * excitation(lines[inside]))
    root = vector * np.sqrt(np.maximum(value, 0.0))[:, None]  # one pressure at low frequencies
    spectrum = np.zeros((HISTORIES, len(lines), n), complex)
    noise = rng.normal(size=(2, HISTORIES, int(inside.sum()), n))
    # one-sided PSD S: amplitudes √(S Δf) of sine and cosine
    spectrum[:, inside] = np.einsum("fij,hfj->hfi", root, noise[0] + 1j * noise[1])
    force = np.fft.irfft(spectrum, steps, axis=1) * np.sqrt(RATE / steps) * steps / 2
    pairs, mass, step = tensor.reshape(n * n, n * n), modal.modal_mass, 1 / RATE
    stiffness, damping = mass * modal.angular_frequency**2, modal.damping
    q, v, total = np.zeros((HISTORIES, n)), np.zeros((HISTORIES, n)), np.zeros((n, n))

    def acceleration(q: Array, v: Array, time: int) -> Array:
        membrane = ((q[:, :, None] * q[:, None]).reshape(-1, n * n) @ pairs).reshape(-1, n, n)
        pull = stiffness * q + 2 * np.einsum("hij,hj->hi", membrane, q) + damping * v
        return np.asarray((force[:, time] - pull) / mass)

    a = acceleration(q, v, 0)
    for time in range(1, steps):
        q = q + step * v + step**2 / 2 * a
        following = acceleration(q, v + step * a, time)
        v = v + step / 2 * (a + following)
        a = following
        if time >= SETTLING * RATE:
            total += q.T @ q
    count = HISTORIES * (steps - int(SETTLING * RATE))
    return np.sqrt(np.einsum("pi,ij,pj->p", points, total / count, points))


CASES = cases_of(globals())
