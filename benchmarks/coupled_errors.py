"""Do the stated errors of coupled runs hold? Many short runs of a small panel, counted.

A simply supported plate of 15 shapes with eight cells of spheres, the whole in LIGGGHTS, is run
many times, each with packings and a sound of its own. Groups of so few runs as a study has state
values with errors; the mean of all other runs is what they should have found. Printed is, by
kind of number, the root mean square of the difference over its stated error and how often it is
within one and two of them.

    python benchmarks/coupled_errors.py [folder] [runs]

Then four runs are made once more under their own sounds, with half the time step and with twice
the cells, and what they find is set beside what they found.

About five CPU-minutes for 48 runs. Records are kept in the folder and not made again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from pidpanel.coupled import pieces, sound_record
from pidpanel.coupled.integration import Integration, PanelShapes
from pidpanel.coupled.record_files import read_record, write_record
from pidpanel.coupled.results import CoupledPanel, CoupledPatch, SettledRecord, coupled_result
from pidpanel.coupon import attempts
from pidpanel.coupon.contact import rayleigh_time
from pidpanel.coupon.from_study import bed_of
from pidpanel.study.coupon import Coupon
from pidpanel.third_octaves import edge_frequency

LOW, HIGH, PRESSURE = 30.0, 400.0, 3.0
SETTLE_S, DURATION_S, MODULUS, STEPS = 0.2, 0.6, 10e6, 16
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


def shapes_at(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the shapes (k, n) of a simply supported plate of 1 m × 0.7 m."""
    rows = [np.sin(m * np.pi * x) * np.sin(n * np.pi * y / 0.7) for m, n in ORDER]
    return np.array(rows).T


FREQUENCY = np.array([20.0 * (m**2 + (n / 0.7) ** 2) for m, n in ORDER])
SHAPES = PanelShapes(
    angular_frequency=2 * np.pi * FREQUENCY,
    damping_ratio=np.full(len(ORDER), 0.02),
    modal_mass=np.full(len(ORDER), 4.0 * 0.7 / 4),
    at_stations=shapes_at(*STATIONS.T),
    at_points=shapes_at(*POINTS.T),
)


def panel(cell_area: float) -> CoupledPanel:
    """Return the plate under a sound that pushes its shapes alike, partly together."""

    def stiffness(f: np.ndarray) -> np.ndarray:
        omega, own = 2 * np.pi * f[:, None], SHAPES.angular_frequency
        return SHAPES.modal_mass * (own**2 - omega**2 + 2j * SHAPES.damping_ratio * own * omega)

    felt, n = SHAPES.at_stations, len(ORDER)
    return CoupledPanel(
        stiffness=stiffness,
        points=SHAPES.at_points,
        patches=[CoupledPatch(felt, AREA, cell_area, (AREA * felt.T) @ felt)],
        pressure_psd=lambda f: np.full(f.shape, PRESSURE),
        modal_force=lambda f: np.broadcast_to(0.05 * (np.eye(n) + 0.5), (len(f), n, n)),
    )


def record(seed: int, folder: Path, *, halvings: int = 0, cells: int = CELLS) -> SettledRecord:
    """Return one run, made where it is not there yet."""
    name = f"run{seed}{'_half' * halvings}" + (f"_{cells}cells" if cells != CELLS else "")
    file = folder / f"{name}.nc"
    if file.exists():
        return read_record(file)
    bed = bed_of(COUPON, 0.5, cells=cells, seed=1 + seed % PACKINGS)
    packing = folder / "packing" / bed.packing.label / "packing.json"
    loose = folder / "bed" / bed.label / "bed.json"
    if not loose.exists():
        attempts.pour_packing(bed.packing, packing)
        attempts.loosen_bed(bed, packing, loose)
    own = bed.packing
    step = 0.2 * rayleigh_time(own.sizes.smallest / 2, own.density, MODULUS, own.poissons_ratio)
    interval = STEPS * step
    step, steps = step / 2**halvings, STEPS * 2**halvings
    rows, settled = (round(t / interval) for t in (SETTLE_S + DURATION_S, SETTLE_S))
    first = int(np.ceil(LOW * rows * interval))
    lines = np.arange(first, int(HIGH * rows * interval) + 1) / (rows * interval)
    simulated = cells // len(AREA) * own.cell_area
    whole = panel(simulated)
    amplitude = sound_record.draw_modal_force(
        lines, whole.pressure_psd(lines), whole.modal_force, np.array([LOW, HIGH]),
        np.random.default_rng(seed),
    )  # fmt: skip
    held = amplitude * sound_record.before_hold(lines, interval)[:, None]
    force = sound_record.samples(held, first, rows)
    bare = amplitude / whole.stiffness(lines)
    start = np.stack([bare.real.sum(axis=0), (2j * np.pi * lines @ bare).real])
    run = Integration(
        SHAPES, AREA, np.full(len(AREA), simulated),
        np.concatenate([force, force[:1]]), step, steps, settled,
    )  # fmt: skip
    started = pieces.started(bed, MODULUS, loose)
    found = pieces.integrated(f"run {seed}", run, start, [started], 8, folder / name)
    kept = SettledRecord(
        lines, amplitude, first, rows, settled, interval,
        found.at_stations, found.at_points, found.impulse,
    )  # fmt: skip
    write_record(file, kept, {"balance_error": found.balance.error})
    return read_record(file)


def values(
    records: list[SettledRecord], cells: int = CELLS
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return by kind of number the values and their stated errors, both as ln or relative."""
    bed = bed_of(COUPON, 0.5, cells=8, seed=1)
    numbers = np.arange(16, 26)
    edge, centre = edge_frequency(numbers), 10 ** (numbers / 10)
    edge[0, 0], edge[-1, 1] = max(edge[0, 0], LOW), min(edge[-1, 1], HIGH)
    lines = np.geomspace(edge[0, 0], edge[-1, 1], 800)
    found = coupled_result(
        panel(cells // len(AREA) * bed.packing.cell_area), records, lines, centre, edge
    )
    return {
        "g rms": (np.log(found.mean_square) / 2, found.mean_square_error / 2),
        "third octave": (np.log(found.band_squares) / 2, found.band_error / 2),
        "C_e": (found.equivalent_damping, found.equivalent_damping_error),
        "m_a": (found.apparent_mass, found.apparent_mass_error),
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
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 48
    records = [record(seed, folder) for seed in range(runs)]
    for size in (2, 4):
        count(records, size)
    refine(folder, range(4))


if __name__ == "__main__":
    main()
