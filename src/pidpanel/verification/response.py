"""The response held to published benchmarks and closed forms; see also `response_layouts`."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.solve import stress
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, PanelResponse, Patches
from pidpanel.sound.face import PanelQuadrature
from pidpanel.sound.field import uniform_modal_force
from pidpanel.verification import response_layouts
from pidpanel.verification.rows import Row, comparison


def nafems_rows(folder: Path) -> list[Row]:
    """NAFEMS selected benchmarks for forced vibration, test 13 and 13R (report R0016).

    A square plate of 10 m, E = 200 GPa, ν = 0.3, ρ = 8000 kg/m³, 0.05 m thick, simply supported,
    ζ = 2 %, under one pressure of (100 Pa)²/Hz all over its face.
    """
    side, thickness, nu = 10.0, 0.05, 0.3
    rigidity = 200e9 * thickness**3 / (12 * (1 - nu**2))
    section = ThinSection(rigidity, 8000 * thickness, nu, thickness)
    rows = []
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
        (bare,) = bare_panels(
            basis.natural_frequency[:1],
            modal,
            [Patches(np.zeros((0, n, n)), np.zeros(0))],
            motion,
            [100.0**2],
            uniform_modal_force(PanelQuadrature.from_face(basis)),
        )
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
                known = replace(published, unit=unit, source=source)
                rows.append(known.row(quantity, computed, reference, resolution=count))
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
    computed = PanelResponse(lines, bare.point_psd).displacement_rms[0]
    return [comparison("miles").row("rms displacement", computed, expected)]


# Each computes in a folder and returns its rows.
CASES = {"nafems_13r": nafems_rows, "miles": miles_rows, **response_layouts.CASES}
