"""What a panel of 50 000 coordinates costs: mesh, assembly, 100 modes, residual vectors.

    python benchmarks/panel.py

A sandwich of 3 m x 2 m in Reissner-Mindlin elements with two patches, one process, one thread;
CPU time of the process, and its largest memory.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from pidpanel.geometry.polygon import Circle, Polygon, Rectangle
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import Core, Material, Ply, SandwichSection
from pidpanel.panel.shapes import residual_vectors
from pidpanel.panel.triangles import mesh_triangles

OUTLINE = Polygon(((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)))
PATCHES = {"A": Rectangle((1.0, 1.0), (0.3, 0.3)), "B": Circle.of_equal_area((2.2, 0.8), 0.15)}
FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
SECTION = SandwichSection((FACE,), (FACE,), Core(186e6, 90e6, 32.0, 24.4e-3), 1.5)
HIGHEST = 1300.0


def main():
    start = time.process_time()

    def say(what):
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(f"{what}: {time.process_time() - start:.1f} CPU-s, {memory:.2f} GiB")

    with tempfile.TemporaryDirectory() as folder:
        mesh = mesh_triangles(Path(folder) / "panel.msh", OUTLINE, 0.054, PATCHES, {})
    say(f"mesh of {len(mesh.cells)} triangles")
    plate = assemble_shear_plate(mesh, SECTION)
    say(f"{plate.stiffness.shape[0]} coordinates assembled")
    frequency, modes = normal_modes(plate, HIGHEST)
    say(f"{len(frequency)} modes below {HIGHEST:g} Hz")
    residual, _ = residual_vectors(plate, modes, 1e-4)
    say(f"{len(residual)} residual vectors")
    assert np.all(np.diff(frequency) >= 0)


if __name__ == "__main__":
    main()
