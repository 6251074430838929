"""What a real wing costs before its dampers are attached, in the way of today and in that before.

    python benchmarks/wing.py

The panel of `workflow/studies/wing.yaml`: modes, residual vectors, face, modal force and added
mass, one process, one thread; CPU time of the process. The ways before are timed beside: modes one
column at a time (ARPACK), plane waves over all points of the mesh, the added mass as a search for
a wavenumber beyond which nothing is left. What takes too long is timed on a share and scaled.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import resource
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy.sparse.linalg as spla

from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.panel.basis import basis_of, face_wavenumber, with_condensed_face
from pidpanel.panel.eigen import eigenpairs, factors
from pidpanel.panel.files import write_basis
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.modes import count_modes_below, normalise
from pidpanel.panel.shapes import Shapes, residual_vectors
from pidpanel.paths import PROJECT
from pidpanel.sound.field import half_circle, tabulate_diffuse, transform
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.sound.wavenumber_table import node_count
from pidpanel.study import load_study

STUDY = PROJECT / "workflow" / "studies" / "wing.yaml"
ITERATIONS = 3
"""Of the search for the added mass before: to 2, 3 and 4.5 times the wavenumber of the sound. It
ended there in an error: the mesh resolves no more."""
TIMED = 512
"""Plane waves of the way before that are timed."""


def clock(work):
    """CPU seconds of the process, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def before_field(panel, k_max):
    """CPU seconds of the plane waves of the modal force over all points, scaled."""
    waves = node_count(k_max, panel.diameter / 2) * len(half_circle(k_max, panel.diameter))
    return some_waves(panel, k_max) * waves / TIMED


def before_added_mass(panel, k_max):
    """CPU seconds of those of the added mass, scaled."""
    waves = 0
    for step in range(ITERATIONS):
        reach = 2 * k_max * 1.5**step
        waves += node_count(reach, panel.diameter) * len(half_circle(reach * 0.6, panel.diameter))
    return some_waves(panel, k_max) * waves / TIMED


def some_waves(panel, k_max):
    """CPU seconds of `TIMED` plane waves over all points."""
    azimuth = np.linspace(0, np.pi, 32, endpoint=False)
    return clock(lambda: transform(np.linspace(1, k_max, TIMED // 32), azimuth, panel))[0]


def main():
    study = load_study(STUDY)
    studied, highest = StudiedPanel(study.panel), study.response.frequency_hz[1]
    k_max = 2 * np.pi * highest / study.sound.speed_m_s
    with tempfile.TemporaryDirectory() as folder:
        mesh = studied.mesh(Path(folder) / "panel.msh")
    plate = studied.plate(mesh)
    K, M = plate.stiffness, plate.mass
    count = count_modes_below(plate, 2 * highest)
    limit = (4 * np.pi * highest) ** 2
    modes_cost, (value, modes) = clock(lambda: eigenpairs(K, M, limit, count))
    wanted, shift = count + 8, 1e-4 * limit

    def arpack():
        solve = factors(K + shift * M).solve
        return spla.eigsh(
            K, k=wanted, M=M, sigma=-shift, OPinv=spla.LinearOperator(K.shape, solve),
            v0=np.random.default_rng(0).standard_normal(len(modes)), ncv=3 * wanted,
        )  # fmt: skip

    arpack_cost, (reference, _) = clock(arpack)
    same = float(np.max(np.abs(value / np.sort(reference)[:count] - 1)))
    residual_cost, (frequency, residuals) = clock(lambda: residual_vectors(plate, modes, 1e-4))
    vectors = normalise(plate, np.hstack([modes, residuals]))
    basis = basis_of(mesh, plate, Shapes(np.sqrt(value) / (2 * np.pi), frequency, vectors))
    reach = face_wavenumber(basis, k_max)
    face_cost, few = clock(lambda: with_condensed_face(basis, reach))
    raw = PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
    )
    face = PanelQuadrature(
        few.quadrature_position, few.quadrature_weight, few.shape_at_quadrature,
        few.quadrature_wavenumber, few.face_overlap,
    )  # fmt: skip
    field_cost, _ = clock(lambda: tabulate_diffuse(k_max, face))
    air_cost, _ = clock(lambda: tabulate_added_mass(k_max, face))
    with tempfile.TemporaryDirectory() as folder:
        write_basis(Path(folder) / "modes.nc", few, {})
        size = (Path(folder) / "modes.nc").stat().st_size / 1e6
    arrays = [getattr(basis, name) for name in vars(basis)]
    whole = sum(one.nbytes for one in arrays if isinstance(one, np.ndarray)) / 1e6

    print(f"{count} modes, {len(frequency)} residual vectors, {len(modes)} coordinates,")
    print(f"{raw.weight.size} points of the mesh, {face.weight.size} of the condensed face")
    for name, cost, before in (
        ("modes", modes_cost, arpack_cost),
        ("modal force to 2 kHz", face_cost + field_cost, before_field(raw, k_max)),
        ("added mass", air_cost, before_added_mass(raw, k_max)),
    ):
        print(f"  {name:24} {cost:8.1f} CPU-s, before {before:8.1f}, {before / cost:6.1f} x")
    print(f"  {'residual vectors':24} {residual_cost:8.1f} CPU-s")
    print(f"  {'modes.nc':24} {size:8.1f} MB, before {whole:10.1f}, {whole / size:6.1f} x")
    print(f"largest difference of an eigenvalue between the two ways: {same:.1e}")
    print(f"memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20:.1f} GiB")


if __name__ == "__main__":
    main()
