"""What the response costs, against a dense solve a line and a sparse solve of all elements.

    python benchmarks/response.py

2000 lines, 70 modes, 12 scenarios on one patch, 3 points, all in one process and one thread;
process CPU time. The dense and the sparse solves are timed on a share of the lines and scaled.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.field import tabulate_diffuse, wavenumber

LINES, MODES, SCENARIOS = 2000, 70, 12
POINTS = {"326": (0.75, 0.50), "189": (0.10, 0.30), "318": (0.35, 0.50)}
DENSE_LINES, SPARSE_LINES = 100, 5


def clock(work):
    """CPU seconds of the process, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def main():
    with tempfile.TemporaryDirectory() as folder:
        patch = {"PID-1": Rectangle((0.75, 0.5), (0.2, 0.2))}
        mesh = mesh_quadrilaterals(Path(folder) / "panel.msh", (1.5, 1.0), (30, 20), patch, POINTS)
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    basis = basis_of(mesh, plate, panel_shapes(plate, 3300.0, residual_tolerance=1.0))
    shapes = slice(0, MODES)
    modal = ModalBasis(basis.natural_frequency[shapes], basis.modal_mass[shapes], 0.01)
    patches = Patches(basis.patch_overlap[:, shapes, shapes], patch_areas(basis))
    points = basis.shape_at_points[:, shapes]
    face = PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature[:, shapes]
    )
    frequency = np.geomspace(20.0, 2000.0, LINES)
    k = wavenumber(frequency, 343.0)
    table_cost, table = clock(lambda: tabulate_diffuse(float(k[-1]), face))
    spectrum = np.full(LINES, 100.0)
    dampers = [
        (400 * (1 + i) * np.sqrt(frequency / 100), np.full(LINES, 0.5 * (1 + i)))
        for i in range(SCENARIOS)
    ]

    def force(lines):
        return table.matrix(wavenumber(lines, 343.0))

    def low_rank():
        (bare,) = bare_panels(
            frequency,
            modal,
            [patches],
            points,
            spectrum,
            lambda f: table.matrix(wavenumber(f, 343.0)),
        )
        return [attach_dampers(bare, c[None], m[None]).acceleration_psd for c, m in dampers]

    def dense(lines):
        at_lines = table.matrix(k[lines])
        psd = []
        for c, m in dampers:
            for line, G in zip(lines, at_lines, strict=True):
                omega = 2 * np.pi * frequency[line]
                s = 1j * omega * c[line] - omega**2 * m[line]
                Z = np.diag(modal.dynamic_stiffness(frequency[line : line + 1])[0])
                H = np.linalg.solve(Z + s * patches.overlap[0], np.eye(MODES))
                S = omega**4 * spectrum[line] * H @ G @ H.conj().T
                psd.append(np.einsum("ai,ij,aj->a", points, S, points).real)
        return np.reshape(psd, (SCENARIOS, len(lines), 3))

    def sparse(lines):
        pull = plate.interpolate(np.array(list(POINTS.values()))).toarray().T.astype(complex)
        D = plate.patch_overlap["PID-1"]
        for c, m in dampers:
            for line in lines:
                omega = 2 * np.pi * frequency[line]
                Z = plate.stiffness * (1 + 0.02j) - omega**2 * (plate.mass + m[line] * D)
                Z = sp.csc_array(Z + 1j * omega * c[line] * D)
                answer = spla.splu(Z).solve(pull)
                plate.at_quadrature @ answer  # what the sound is then summed with

    fast_cost, fast = clock(low_rank)
    some = np.linspace(0, LINES - 1, DENSE_LINES).astype(int)
    dense_cost, reference = clock(lambda: dense(some))
    dense_cost *= LINES / DENSE_LINES
    few = np.linspace(0, LINES - 1, SPARSE_LINES).astype(int)
    sparse_cost = clock(lambda: sparse(few))[0] * LINES / SPARSE_LINES
    error = max(
        float(np.max(np.abs(one[some] / other - 1)))
        for one, other in zip(fast, reference, strict=True)
    )
    print(f"modal force table to 2 kHz, {MODES} modes: {table_cost:.1f} CPU-s")
    print(f"{LINES} lines x {MODES} modes x {SCENARIOS} scenarios x 3 points:")
    for name, cost in (
        ("low rank, as in the product", fast_cost),
        ("dense solve a line", dense_cost),
        ("sparse solve of all elements", sparse_cost),
    ):
        print(f"  {name:30} {cost:8.2f} CPU-s {cost / fast_cost:8.1f} x")
    print(f"largest difference of a PSD, low rank against dense: {error:.1e}")


if __name__ == "__main__":
    main()
