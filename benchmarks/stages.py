"""What each stage costs beside its peer or floor, as ratios of CPU time: ``make bench``, 2 minutes.

    python benchmarks/stages.py

Peers do the same work the plain way or with the library alone; floors are a part of the work that
cannot be left out. One thread; process CPU time, of children too.
"""

import os

os.environ["OMP_NUM_THREADS"] = "1"

import platform
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import scipy
import scipy.sparse.linalg as spla

from pidpanel.constants import LIGGGHTS_VERSION
from pidpanel.coupon import attempts
from pidpanel.coupon.from_study import cases_of
from pidpanel.damping.gaussian_process import fit
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.field import tabulate_diffuse, wavenumber
from pidpanel.study.coupon import Coupon

ROOT = Path(__file__).resolve().parents[1]
HIGHEST = 2000.0


def used():
    """CPU seconds of this process and of its children that have ended."""
    own, children = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def clock(work):
    """CPU seconds of some work, and what it returns."""
    begun = used()
    found = work()
    return used() - begun, found


def say(stage, cost, what, peer):
    print(f"{stage:10} {cost:8.2f} {peer:8.2f} {cost / peer:8.2g}   {what}", flush=True)


def coupon(folder):
    """A case of two seeds from its beds to its outcomes, and its decks in LIGGGHTS alone."""
    values = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 25, "count": 3},
        "particles": {"diameter_mm": 2.0},
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [250], "acceleration_g": [20]},
        "accuracy": {"relative_error": 0.05, "seeds": 2, "min_cycles": 12, "min_time_s": 0.1},
    }
    (case,) = cases_of(Coupon.model_validate(values))
    for run in case.runs:
        packing = folder / "packing" / run.packing.label / "packing.json"
        attempts.pour_packing(run.packing, packing)
        attempts.loosen_bed(run.bed, packing, folder / "bed" / run.bed.label / "bed.json")
    cost, _ = clock(lambda: attempts.write_case(case, folder, case.outcome_file(folder)))

    def alone():
        for home in case.folders(folder):
            scratch = folder / "alone"
            shutil.copytree(home, scratch)
            for deck in sorted(scratch.glob("shake_*.in")):
                subprocess.run(
                    ["liggghts", "-in", deck.name, "-log", "none"],
                    cwd=scratch, env={**os.environ, "OMPI_MCA_ess_singleton_isolated": "1"},
                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True,
                )  # fmt: skip
            shutil.rmtree(scratch)

    say("coupon", cost, "LIGGGHTS alone on the decks of the same runs", clock(alone)[0])


def workflow(folder):
    """A plan of the paper's study, and Snakemake's own start."""
    snakemake = Path(sys.executable).with_name("snakemake")
    plan = [snakemake, "-s", ROOT / "Snakefile", "-d", folder, "-n", "-j2", "--quiet", "all"]
    plan += ["--configfile", ROOT / "workflow" / "studies" / "paper.yaml"]
    empty = folder / "empty.smk"
    empty.write_text("rule all:\n    input: []\n")
    start = [snakemake, "-s", empty, "-d", folder, "-n", "-j2", "--quiet", "all"]
    costs = []
    for command in (plan, start):
        work = [str(word) for word in command]
        costs.append(clock(lambda: subprocess.run(work, check=True, capture_output=True))[0])  # noqa: B023
    say("workflow", costs[0], "Snakemake with an empty Snakefile", costs[1])


def panel(folder):
    """The modes of the paper's panel, and ARPACK for as many."""
    patch = {"PID-1": Rectangle((0.75, 0.5), (0.2, 0.2))}
    mesh = mesh_quadrilaterals(folder / "panel.msh", (1.5, 1.0), (30, 20), patch, {})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    cost, (frequency, _) = clock(lambda: normal_modes(plate, HIGHEST))
    stiffness, mass = plate.stiffness.tocsc(), plate.mass.tocsc()
    peer, _ = clock(lambda: spla.eigsh(stiffness, len(frequency), mass, sigma=0.0))
    say("panel", cost, f"scipy's eigsh, {len(frequency)} modes", peer)
    return basis_of(mesh, plate, panel_shapes(plate, 1.5 * HIGHEST, residual_tolerance=1.0))


def sound_and_response(basis):
    """Modal force of a diffuse field; twelve fills of a patch, on 2000 lines with 70 modes."""
    shapes = slice(0, 70)
    face = PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature[:, shapes]
    )
    frequency = np.geomspace(20.0, HIGHEST, 2000)
    k = wavenumber(frequency, 343.0)
    cost, table = clock(lambda: tabulate_diffuse(float(k[-1]), face))
    shape = face.shape * face.weight[:, None]
    distance = np.linalg.norm(face.position[:, None] - face.position[None], axis=-1)

    def dense():
        return [shape.T @ np.sinc(one * distance / np.pi) @ shape for one in k[::500]]

    peer = clock(dense)[0] * len(k) / len(k[::500])
    say("sound", cost, "double sums over all points, a line at a time", peer)

    modal = ModalBasis(basis.natural_frequency[shapes], basis.modal_mass[shapes], 0.01)
    patches = Patches(basis.patch_overlap[:, shapes, shapes], patch_areas(basis))
    points = basis.shape_at_quadrature[:3, shapes]
    fills = [
        (400.0 * (1 + i) * np.sqrt(frequency / 100), np.full(2000, 0.5 + i)) for i in range(12)
    ]

    def response():
        (bare,) = bare_panels(
            frequency, modal, [patches], points, np.ones(2000),
            lambda lines: table.matrix(wavenumber(lines, 343.0)),
        )  # fmt: skip
        return [attach_dampers(bare, c[None], m[None]).acceleration_psd for c, m in fills]

    cost, _ = clock(response)
    some = slice(None, None, 20)
    stiffness = np.apply_along_axis(np.diag, 1, modal.dynamic_stiffness(frequency[some]))
    pull = np.broadcast_to(points.T.astype(complex), (len(stiffness), *points.T.shape))

    def lapack():
        return [np.linalg.solve(stiffness + 1j * patches.overlap[0], pull) for _ in fills]

    say("response", cost, "LAPACK's solves alone, a line and fill at a time", 20 * clock(lapack)[0])


def damping():
    """A Gaussian process of 90 cases, and the Cholesky factors that its fit needs at least."""
    rng = np.random.default_rng(0)
    points = rng.random((90, 3))
    values = np.sin(3 * points).sum(axis=1)
    cost, _ = clock(lambda: fit(points, values, np.full(90, 0.05)))
    matrix = np.eye(90) + 0.1

    def floor():
        for _ in range(60):
            np.linalg.inv(matrix)

    say("damping", cost, "sixty inverses of as many cases", clock(floor)[0])


def main():
    print(time.strftime("%Y-%m-%d"), platform.machine(), Path("/proc/cpuinfo").read_text().split(
        "model name\t: ")[-1].splitlines()[0], f"Python {platform.python_version()}",
        f"numpy {np.__version__}", f"scipy {scipy.__version__}", f"LIGGGHTS {LIGGGHTS_VERSION}",
        sep="; ")  # fmt: skip
    print(f"{'stage':10} {'CPU-s':>8} {'beside':>8} {'ratio':>8}   beside what")
    with tempfile.TemporaryDirectory() as name:
        coupon(Path(name))
        workflow(Path(name))
        basis = panel(Path(name))
    sound_and_response(basis)
    damping()


if __name__ == "__main__":
    main()
