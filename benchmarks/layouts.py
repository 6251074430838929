"""What a layout of twenty dampers costs, with the search of all their motions.

    python benchmarks/layouts.py

2000 lines, 90 shapes, 20 patches of 0.2 m x 0.15 m together, 3 points; the search on three lines
to the bandwidth. One process and one thread, process CPU time. The references are what it costs
when every step is a dense solve on all lines of the result: the response alone, and the search by
plain iteration of all Γ.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import tempfile
import time
from pathlib import Path

import numpy as np

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import AttachedDamper, DamperLayout, solve_with
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.solvers import PanelSolver
from pidpanel.sound.field import tabulate_diffuse, wavenumber

LINES, MODES, SPEED = 2000, 90, 343.0
POINTS = {"326": (0.75, 0.50), "189": (0.10, 0.30), "318": (0.35, 0.50)}
PATCHES = {
    f"PID-{5 * row + column + 1}": Rectangle((0.15 + 0.3 * column, 0.125 + 0.25 * row), (0.2, 0.15))
    for row in range(4)
    for column in range(5)
}
DENSE_LINES = 100


def clock(work):
    """CPU seconds of the process, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def main():
    with tempfile.TemporaryDirectory() as folder:
        mesh = mesh_quadrilaterals(
            Path(folder) / "panel.msh", (1.5, 1.0), (30, 20), PATCHES, POINTS
        )
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    basis = basis_of(mesh, plate, panel_shapes(plate, 4000.0))
    shapes = slice(0, MODES)
    modal = ModalBasis(basis.natural_frequency[shapes], basis.modal_mass[shapes], 0.01)
    patches = Patches(basis.patch_overlap[:, shapes, shapes], patch_areas(basis))
    motion = np.concatenate(
        [basis.shape_at_points[:, None], basis.curvature_at_points, basis.shear_at_points], axis=1
    )[:, :, shapes]
    face = PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature[:, shapes]
    )
    frequency = np.geomspace(20.0, 2000.0, LINES)
    table = tabulate_diffuse(float(wavenumber(frequency[-1], SPEED)), face)
    search = frequency_grid(20.0, 2000.0, 0.01, lines_per_bandwidth=3.0)
    excitation = ModalForce(
        lambda f: np.full(f.size, 100.0), lambda f: table.matrix(wavenumber(f, SPEED))
    )

    def loads(seed):
        draw = np.random.default_rng(seed)
        return [
            AttachedDamper(number, damper(*draw.uniform([200, 0.3, 1], [800, 0.9, 6])))
            for number in range(len(PATCHES))
        ]

    def damper(damping, exponent, mass):
        """C_e that rises with f and falls with Γ beyond 2.5, m_a that falls slowly."""

        def law(f, gamma):
            share = (gamma / 2.5) ** -exponent / (1 + (2.5 / gamma) ** 4)
            return damping * np.sqrt(f / 100) * share, mass * gamma**-0.1 + 0 * f, f > 0

        return law

    solver = PanelSolver(ModalPanel(modal, patches, frequency, motion, search), excitation)

    def solve_layout(loads, stated=None):
        (answer,) = solve_with(solver, [DamperLayout(loads, stated_acceleration_g=stated)])
        return answer

    first, found = clock(lambda: solve_layout(loads(0)))
    further, again = clock(lambda: solve_layout(loads(1)))
    alone, _ = clock(lambda: solve_layout([loads(2)[0]]))
    stated, _ = clock(lambda: solve_layout(loads(3), 20.0))

    def dense():
        lines = np.linspace(0, LINES - 1, DENSE_LINES).astype(int)
        own = solver.with_lines(frequency[lines], motion)
        G = excitation(frequency[lines])
        psd = []
        for place, line in enumerate(lines):
            omega = 2 * np.pi * frequency[line]
            Z = np.diag(modal.dynamic_stiffness(frequency[line : line + 1])[0])
            s = (
                1j * omega * found.equivalent_damping[:, line]
                - omega**2 * found.apparent_mass[:, line]
            )
            Z = Z + np.tensordot(s, patches.overlap, axes=1)
            H = np.linalg.inv(Z)
            S = 100.0 * H @ G[place] @ H.conj().T
            np.einsum("pij,ji->p", patches.overlap, S)
            psd.append(omega**4 * np.einsum("ai,ij,aj->a", motion[:, 0], S, motion[:, 0]).real)
        return lines, np.array(psd), own

    cost, (lines, psd, _) = clock(dense)
    cost *= LINES / DENSE_LINES
    error = np.max(np.abs(found.response.acceleration_psd[lines] / psd - 1))
    print(f"{LINES} lines x {MODES} shapes x {len(PATCHES)} patches x 3 points")
    for name, own in (
        ("first layout, with the search", first),
        ("further layout, with the search", further),
        ("further layout, stated motion", stated),
        ("one of its dampers alone", alone),
        ("dense solve of all lines, once", cost),
    ):
        print(f"  {name:32} {own:8.2f} CPU-s {cost / own:8.1f} x")
    print(f"largest difference of a PSD from the dense solve: {error:.1e}")
    for one in (found, again):
        print(
            f"Γ {one.acceleration_g.min():.3g} to {one.acceleration_g.max():.3g}, "
            f"{one.fixed_points} solution, residual {one.residual:.1e}"
        )


if __name__ == "__main__":
    main()
