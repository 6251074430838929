"""Do the stated errors of coupled runs hold? Many short runs of a small panel, counted.

A simply supported plate of 15 shapes with eight cells of spheres in LIGGGHTS is run many times,
each time with packings and a sound of its own. Groups of as few runs as a study has state values
with errors; the mean of all other runs is what they should have found. Printed is, by kind of
number, the root mean square of the difference over its stated error and how often it is within
one and two of them.

    python benchmarks/coupled_errors.py [folder] [runs]

Then the first four runs are repeated under their own sounds, with half the time step and with
twice the cells, and compared.

About eight CPU-minutes for 32 runs. Records are kept in the folder and not made again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from pidpanel.coupled import beds, force_record, pieces
from pidpanel.coupled.checkpoints import IDENTITY, read_record, write_record
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch
from pidpanel.coupled.estimate import estimate
from pidpanel.coupled.integration import Integration
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupon import attempts
from pidpanel.coupon.from_study import bed_of
from pidpanel.solve.bands import band_rms, whole_third_octaves
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.source import PatchParts
from pidpanel.study.coupon import Coupon

LOW, HIGH, PRESSURE = 30.0, 400.0, 3.0
SETTLE_S, DURATION_S, MODULUS = 0.2, 1.6, 10e6
ROW_S, INTERVALS = 1 / (10 * HIGH), 10  # a step of 25 µs, a third of the Rayleigh time
PACKINGS, CELLS = 16, 8
COUPON = Coupon.model_validate(
    {
        "cell": {"shape": "hexagon", "across_flats_mm": 6.35, "depth_mm": 8, "count": 2},
        "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50, "density_kg_m3": 1190},
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [10]},
    }
)
ORDER = [(m, n) for m in range(1, 6) for n in range(1, 4)]
STATIONS = np.array([[x, y] for x in (0.35, 0.45, 0.55, 0.65) for y in (0.3, 0.4)])
POINTS = np.array([[0.5, 0.35], [0.2, 0.1], [0.35, 0.35]])
AREA = np.full(len(STATIONS), 0.01)
MODAL = ModalBasis(
    [20.0 * (m**2 + (n / 0.7) ** 2) for m, n in ORDER], [4.0 * 0.7 / 4] * len(ORDER), 0.02
)


def shapes_at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the shapes (k, n) of a simply supported plate of 1 m × 0.7 m."""
    rows = [np.sin(m * np.pi * x) * np.sin(n * np.pi * y / 0.7) for m, n in ORDER]
    return np.array(rows).T


def panel(cells: int) -> CoupledPanel:
    """Return the plate under a sound that pushes its shapes alike, partly together."""
    felt, n, each = shapes_at(*STATIONS.T), len(ORDER), cells // len(AREA)
    patch = CoupledPatch(
        shape=np.repeat(felt, each, axis=0),
        area=np.repeat(AREA / each, each),
        position=np.repeat(STATIONS, each, axis=0),
        cell_area=bed_of(COUPON, 0.5, cells=cells, seed=1).packing.cell_area,
        overlap=(AREA * felt.T) @ felt,
        parts=PatchParts(felt, AREA, STATIONS),
    )
    return CoupledPanel(
        modal=MODAL,
        points=shapes_at(*POINTS.T),
        patches=[patch],
        excitation=ModalForce(lambda f: np.full(f.shape, PRESSURE), 0.05 * (np.eye(n) + 0.5)),
    )


def record(seed: int, folder: Path, *, halvings: int = 0, cells: int = CELLS) -> SettledRecord:
    """Return one run, made where it is not there yet."""
    name = f"run{seed}{'_half' * halvings}" + (f"_{cells}cells" if cells != CELLS else "")
    file = folder / f"{name}.nc"
    if (stored := read_record(file, name)) is not None:
        return stored
    bed = bed_of(COUPON, 0.5, cells=cells, seed=1 + seed % PACKINGS)
    packing = folder / "packing" / bed.packing.label / "packing.json"
    loose = folder / "bed" / bed.label / "bed.json"
    if not loose.exists():
        attempts.pour_packing(bed.packing, packing)
        attempts.loosen_bed(bed, packing, loose)
    rows, settled = (round(t / ROW_S) for t in (SETTLE_S + DURATION_S, SETTLE_S))
    period = rows - settled
    first = int(np.ceil(LOW * period * ROW_S))
    lines = np.arange(first, int(HIGH * period * ROW_S) + 1) / (period * ROW_S)
    whole, intervals = panel(cells), INTERVALS * 2**halvings
    amplitude = force_record.draw_modal_force(
        lines, whole.excitation, np.array([LOW, HIGH]), np.random.default_rng(seed),
    )  # fmt: skip
    held = amplitude * force_record.before_hold(lines, ROW_S)[:, None]
    force = force_record.samples(held, first, period)[np.arange(-settled, period + 1) % period]
    bare = amplitude * np.exp(-2j * np.pi * lines * settled * ROW_S)[:, None]
    bare = bare / whole.modal.dynamic_stiffness(lines)
    start = np.stack([bare.real.sum(axis=0), (2j * np.pi * lines @ bare).real])
    run = Integration(
        MODAL, whole.at_cells, whole.points, whole.area, np.full(cells, whole.patches[0].cell_area),
        force, ROW_S / intervals, 1, intervals, settled,
    )  # fmt: skip
    read, balance = pieces.integrated(
        f"run {seed}", run, start, [beds.started(bed, MODULUS, loose.parent)], folder / name
    )
    kept = SettledRecord(
        lines, amplitude, first, rows, settled, run.row_interval, read.at_cells, read.at_points,
        read.impulse / run.cell_area,
    )  # fmt: skip
    write_record(file, kept, {IDENTITY: name, "balance_error": balance.error})
    return kept


def values(
    records: list[SettledRecord], cells: int = CELLS
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return by kind of number the values and their stated errors, of g rms in logarithms."""
    centre, edge = whole_third_octaves(LOW, HIGH)
    lines = np.geomspace(LOW, HIGH, 800)
    found = estimate(panel(cells), records, lines, centre, edge)
    acceleration = (2 * np.pi * lines[:, None]) ** 4 * found.psd
    (patch,) = found.patches
    z = patch.impedance
    return {
        "g rms": (np.log(np.trapezoid(acceleration, lines, axis=0)) / 2, found.log_error / 2),
        "third octave": (np.log(band_rms(lines, acceleration, edge)), found.log_band_error / 2),
        "C_e": (z.value.real, patch.equivalent_damping_error),
        "m_a": (z.value.imag / (2 * np.pi * z.frequency), patch.apparent_mass_error),
    }


def count(records: list[SettledRecord], size: int) -> None:
    """Print how the values of groups of so many runs lie about those of all other runs."""
    scores: dict[str, list[np.ndarray]] = {}
    spread: dict[str, list[np.ndarray]] = {}
    for first in range(0, len(records) - size + 1, size):
        group = values(records[first : first + size])
        rest = values(records[:first] + records[first + size :])
        for kind, (value, error) in group.items():
            other, own = rest[kind]
            scores.setdefault(kind, []).append(((value - other) / np.hypot(error, own)).ravel())
            spread.setdefault(kind, []).append(np.stack([value - other, error]))
    for kind, parts in scores.items():
        z = np.abs(np.concatenate(parts))
        apart, stated = np.array(spread[kind]).swapaxes(0, 1)
        print(
            f"{size} runs, {kind:12}: {len(z):5} numbers, rms z {np.sqrt((z**2).mean()):5.2f}, "
            f"within one {np.mean(z < 1):.0%}, within two {np.mean(z < 2):.0%}; "
            f"rms of differences {np.sqrt((apart**2).mean()):.4g}, of errors "
            f"{np.sqrt((stated**2).mean()):.4g}",
            flush=True,
        )


def refine(folder: Path, seeds: range) -> None:
    """Print what half the time step and twice the cells change, over its stated error."""
    before = values([record(seed, folder) for seed in seeds])
    for what, after in {
        "half the step": values([record(seed, folder, halvings=1) for seed in seeds]),
        "twice the cells": values([record(s, folder, cells=2 * CELLS) for s in seeds], 2 * CELLS),
    }.items():
        for kind, (value, error) in after.items():
            change = value - before[kind][0]
            z = change / np.hypot(error, before[kind][1])
            print(
                f"{what}, {kind:12}: rms change {np.sqrt((change**2).mean()):.4g}, "
                f"{np.sqrt((z**2).mean()):.2f} of its error, largest {np.abs(z).max():.1f}",
                flush=True,
            )


def main() -> None:
    """Run and count."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/coupled_errors")
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 32
    records = [record(seed, folder) for seed in range(runs)]
    for size in (1, 2, 4):
        if size < runs:
            count(records, size)
    refine(folder, range(min(4, runs)))


if __name__ == "__main__":
    main()
