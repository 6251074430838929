"""The response held to published benchmarks, closed forms and a solve of the full elements."""

from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import panel_basis, patch_areas
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.polygon import Rectangle
from pidpanel.response import stress
from pidpanel.response.dampers import attach_dampers
from pidpanel.response.lines import frequency_grid
from pidpanel.response.modal import bare_panels
from pidpanel.response.model import ModalBasis, Patches, Response
from pidpanel.response.power import power_balance
from pidpanel.sound.face import PanelQuadrature
from pidpanel.sound.field import (
    diffuse_modal_force,
    uniform_modal_force,
    wavenumber,
)
from pidpanel.verification import Row

SPEED = 343.0


def nafems_rows(folder: Path) -> list[Row]:
    """NAFEMS selected benchmarks for forced vibration, test 13 and 13R (report R0016).

    A square plate of 10 m, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³, 0.05 m thick, simply supported,
    ζ = 2 %, under one pressure of (100 Pa)²/Hz all over its face.
    """
    case = "NAFEMS 13R: plate under one random pressure"
    side, thickness, nu = 10.0, 0.05, 0.3
    rigidity = 200e9 * thickness**3 / (12 * (1 - nu**2))
    section = ThinSection(rigidity, 8000 * thickness, nu, thickness)
    rows = []
    outline = Rectangle((side / 2, side / 2), (side, side))
    finest = 1.25
    for size in (2 * finest, finest):
        path = folder / f"nafems_{size:g}.msh"
        mesh = mesh_triangles(path, outline, size, {}, {"centre": (5.0, 5.0)})
        basis = panel_basis(mesh, assemble_thin_plate(mesh, section), 40.0)
        modal = ModalBasis(basis.natural_frequency, basis.modal_mass, 0.02)
        face = PanelQuadrature(
            basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
        )
        n = basis.natural_frequency.size
        motion = np.concatenate([basis.shape_at_points[:, None], basis.curvature_at_points], axis=1)
        (bare,) = bare_panels(
            basis.natural_frequency[:1],
            modal,
            [Patches(np.zeros((0, n, n)), np.zeros(0))],
            motion,
            [100.0**2],
            uniform_modal_force(face),
        )
        response = Response(bare.frequency, bare.point_psd)
        layers = stress.distinct_layers(basis.layer_names, basis.layer_strain, basis.layer_stress)
        found = {
            "displacement PSD at the centre, at the first frequency": (
                response.displacement_psd[0, 0] * 1e6, 2063.20, 2064.24, "mm2/Hz",
            ),
            "extreme-fibre stress PSD at the centre, at the first frequency": (
                stress.layer_psd(response, layers)[0, 0, 0, 3] * 1e-12, 1025.44, 1025.85, "MPa2/Hz",
            ),
        }  # fmt: skip
        method = f"{len(mesh.cells)} Argyris triangles, {n} modes"
        for quantity, (computed, target, closed, unit) in found.items():
            held = 1e-3 if size == finest else np.nan
            for source, reference in (("NAFEMS R0016", target), ("sine series", closed)):
                rows.append(
                    Row(
                        case, quantity, float(computed), reference, unit, held, method, source,
                        resolution=len(mesh.cells),
                    )
                )  # fmt: skip
        if size == finest:
            targets = {0: 2.377, 1: 5.942, 3: 9.507, 4: 11.884, 6: 15.449}
            rows += [
                Row(
                    case, f"natural frequency {index + 1}", float(basis.natural_frequency[index]),
                    target, "Hz", 1e-3, method, "NAFEMS R0016",
                )
                for index, target in targets.items()
            ]  # fmt: skip
    return rows


def miles_rows(folder: Path) -> list[Row]:
    """One mode in white noise: ∫₀^∞ |H|² S df = (π/2) f Q S/k² (Miles 1954)."""
    mass, frequency, zeta, force_psd = 2.0, 100.0, 0.02, 4.0
    lines = frequency_grid(1.0, 1e4, zeta, [frequency])
    (bare,) = bare_panels(
        lines,
        ModalBasis([frequency], [mass], zeta),
        [Patches(np.zeros((0, 1, 1)), np.zeros(0))],
        [[1.0]],
        np.full(lines.size, force_psd),
        np.eye(1),
    )
    stiffness = mass * (2 * np.pi * frequency) ** 2
    expected = np.sqrt(np.pi / 2 * frequency / (2 * zeta) * force_psd) / stiffness
    computed = float(Response(lines, bare.point_psd).displacement_rms[0])
    method = "8 lines to the bandwidth, 1 Hz to 10 kHz"
    return [
        Row(
            "One mode in white noise", "rms displacement", computed, float(expected), "m", 5e-4,
            method, "Miles 1954",
        )
    ]  # fmt: skip


SIZE, ELEMENTS = (1.5, 1.0), (30, 20)
POINTS = {"in the patch": (0.75, 0.5), "beside it": (0.35, 0.5), "near an edge": (0.10, 0.30)}
LINES = (60.0, 300.0, 1000.0, 1600.0, 1900.0, 2000.0)
"""Lines [Hz] at which modes stand beside all elements."""

TRUNCATION = 5e-3
"""Largest error of a PSD. Near the end of the range the modes left out, pushed by the sound below
their own frequencies, move the panel by more than they do in the middle."""

RAYLEIGH = (4.0, 6e-6)
"""α [1/s] and β [s] of C = αM + βK: a damping that sparse matrices can have too."""


def damped_panel(
    folder: Path,
) -> tuple[AssembledPlate, ModalBasis, Patches, "PanelQuadrature", Array]:
    """Return the paper's panel with PID-1, in elements and in the modes of a study to 2 kHz."""
    mesh = mesh_quadrilaterals(
        folder / "damped.msh", SIZE, ELEMENTS, {"PID-1": Rectangle((0.75, 0.5), (0.2, 0.2))}, POINTS
    )
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    basis = panel_basis(mesh, plate, 4000.0)
    omega = 2 * np.pi * basis.natural_frequency
    ratio = RAYLEIGH[0] / (2 * omega) + RAYLEIGH[1] * omega / 2
    modal = ModalBasis(basis.natural_frequency, basis.modal_mass, ratio)
    face = PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
    )
    return (
        plate,
        modal,
        Patches(basis.patch_overlap, patch_areas(basis)),
        face,
        basis.shape_at_points,
    )


def full_displacement_psd(
    plate: AssembledPlate, frequency: float, damping: float, mass: float
) -> Array:
    """PSDs at `POINTS` per S_p from the whole elements, [m²/Pa²]: one sparse solve a point.

    With Z symmetric, w at a point under the load F of a plane wave is (Z⁻¹ c)ᵀF; the diffuse field
    is the mean over its plane waves, here by Gauss in cos θ and even steps in azimuth.
    """
    omega = 2 * np.pi * frequency
    D = plate.patch_overlap["PID-1"]
    K = plate.stiffness
    stiffness = (
        K
        + 1j * omega * (RAYLEIGH[0] * plate.mass + RAYLEIGH[1] * K + damping * D)
        - omega**2 * (plate.mass + mass * D)
    )
    pull = plate.interpolate(np.array(list(POINTS.values()))).toarray().T.astype(complex)
    answer = spla.splu(sp.csc_matrix(stiffness)).solve(pull)
    k = float(wavenumber(frequency, SPEED))
    cosine, weight = (half[30:] for half in np.polynomial.legendre.leggauss(60))
    load = plate.quadrature_weight[:, None] * (plate.at_quadrature @ answer)  # (nq, points)
    psd = np.zeros(len(POINTS))
    for azimuth in 2 * np.pi * np.arange(90) / 90:
        along = plate.quadrature_position @ np.array([np.cos(azimuth), np.sin(azimuth)])
        wave = np.exp(1j * k * np.outer(np.sqrt(1 - cosine**2), along))
        psd += weight @ np.abs(wave @ load) ** 2 / 90
    return psd


def damper_rows(folder: Path) -> list[Row]:
    """Compare a strong, heavy damper at single lines: modes, all elements, the power."""
    case = "Panel with a damper in a diffuse field: modes against all elements"
    plate, modal, patches, face, points = damped_panel(folder)
    frequency = np.array(LINES)
    force = np.stack([diffuse_modal_force(float(k), face) for k in wavenumber(frequency, SPEED)])
    damping, mass = 3000 * np.sqrt(frequency / 100), np.full(frequency.size, 5.0)
    sound = (np.ones(frequency.size), force)
    (bare,) = bare_panels(frequency, modal, [patches], points, *sound)
    found = attach_dampers(bare, damping[None], mass[None]).displacement_psd
    balance = power_balance(frequency, modal, patches, *sound, damping[None], mass[None])
    lost = balance.structure + balance.patches.sum(axis=1)
    method = f"{points.shape[1]} modes and residual vectors"
    rows = []
    for line, f in enumerate(frequency.tolist()):
        full = full_displacement_psd(plate, f, damping[line], mass[line])
        rows += [
            Row(
                case, f"displacement PSD {name}, {f:g} Hz", float(one), float(other), "m2/Pa2",
                TRUNCATION, method, f"sparse solve of {plate.mass.shape[0]} coordinates", at=f,
            )
            for name, one, other in zip(POINTS, found[line], full, strict=True)
        ]  # fmt: skip
        rows.append(
            Row(
                case, f"power lost in panel and damper, {f:g} Hz", float(lost[line]),
                float(balance.field[line]), "W/Pa2", 1e-6, "low-rank solve",
                "power put in by the field, dense solve", at=f,
            )
        )  # fmt: skip
    return rows


CASES = {
    "nafems_13r": nafems_rows,
    "miles": miles_rows,
    "damper": damper_rows,
}
"""Each computes in a folder and returns its rows."""
