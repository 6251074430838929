"""Apparent mass of a resting bed over frequency, in LIGGGHTS: does it resonate?

    python benchmarks/resting.py [folder] [case ...]

A bed at rest under gravity, with the material's own modulus, moved below Γ = 1, where no particle
leaves its neighbours; then g rms of the panel of launch.yaml with this mass in place of a rigid
one. Ten to thirty CPU-seconds a case. resting.md has the table.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml
from scipy.optimize import brentq
from scipy.special import jv

import pidpanel
from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import balance, geometry, preparation, rows, window
from pidpanel.coupon.bed import Bed, Run, run_at
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.liggghts import output
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import Packing
from pidpanel.geometry.sizes import Sizes
from pidpanel.paths import WORKFLOW

WIDTH, DIAMETER, CELLS = 6.35e-3, 2e-3, 4  # [m], [m], cells in a run
# [Hz]; below, tones have M/m = 1.01 − 0.001 i at 0.1 g, less than what a step tells
FREQUENCIES = np.geomspace(400, 8000, 50)
# Duration and relaxation time of the drags under which a bed settles [s]: the overlaps of the pour,
# 2 µm at 20 MPa, would throw the spheres up by millimetres; a bed that falls; one that rattles
DRAGS = ((0.005, 1e-4), (0.15, 0.01), (0.03, 1e-3))
TRANSIENT, LASTING = 0.03, 0.03  # [s]
STRIDE = 5  # steps between the samples of a momentum
WALL_FREQUENCY = 400.0  # at which the share of the side walls is measured [Hz]


@dataclass(frozen=True)
class Resting:
    """A bed of a height [m] at an acceleration [g]; modulus [Pa], density [kg/m³]."""

    height: float
    acceleration: float
    youngs_modulus: float = 3.2e9
    poissons_ratio: float = 0.35
    density: float = 1190.0
    restitution: float = 0.8
    friction: float = 0.3
    seed: int = 1

    @property
    def constants(self) -> Constants:
        """Of spheres and walls alike."""
        return Constants.alike(
            self.youngs_modulus, self.poissons_ratio, self.restitution, self.friction
        )

    @property
    def packing(self) -> Packing:
        """Of cells filled to the height."""
        return Packing(
            shape="hexagon",
            across_flats=WIDTH,
            depth=self.height,
            count=CELLS,
            diameter=DIAMETER,
            sizes=Sizes("mono", DIAMETER, DIAMETER),
            density=self.density,
            poissons_ratio=self.poissons_ratio,
            friction=self.friction,
            wall_friction=self.friction,
            seed=self.seed,
        )

    def run(self, frequency: float) -> Run:
        """The bed under a tone, in cells twice as deep, whose lid is never met."""
        deep = replace(self.packing, depth=2 * self.height)
        bed = Bed(deep, 0.5, STANDARD_GRAVITY, (0.0, 0.0, -1.0), self.constants)
        return run_at(
            bed,
            Tone(frequency, self.acceleration * STANDARD_GRAVITY),
            self.constants,
            time_step_rayleigh=0.2,
            samples_per_cycle=50,
        )


GLASS = {"youngs_modulus": 65e9, "poissons_ratio": 0.22, "density": 2500.0}
CASES = {
    "acrylic_12mm": Resting(12e-3, 0.1),
    "acrylic_8mm": Resting(8e-3, 0.1),
    "acrylic_20mm": Resting(20e-3, 0.1),
    "acrylic_12mm_0.5g": Resting(12e-3, 0.5),
    "acrylic_12mm_seed2": Resting(12e-3, 0.1, seed=2),
    "glass_12mm": Resting(12e-3, 0.1, **GLASS),
}


TONES = ("acrylic_8mm", "acrylic_12mm", "acrylic_20mm")  # also under tones


def poured(resting: Resting, folder: Path) -> Array:
    """Spheres of a poured bed that lie wholly below its height, (n, 4) [m]."""
    full = preparation.pour(resting.packing, folder).spheres_full
    cell, spheres = preparation.read_packing(folder)
    return spheres[geometry.lowest(cell, spheres[:, 2], full)]


def settled(resting: Resting, spheres: Array, run: Run, folder: Path, solver: Liggghts) -> None:
    """Let a bed come to rest under drag with the moduli of the run, and then without."""
    mass = float(geometry.masses(spheres[:, 3], resting.density).mean())
    solver.read_deck(run.deck_text())
    for time, relaxation in DRAGS:
        solver.read_deck(f"fix drag all viscous {mass / relaxation:.6g}")
        solver.run(math.ceil(time * run.drive.frequency) * run.steps_per_cycle)
        solver.read_deck("unfix drag")
    solver.run(math.ceil(TRANSIENT * run.drive.frequency) * run.steps_per_cycle)


def apparent_mass(resting: Resting, spheres: Array, folder: Path) -> tuple[Array, float]:
    """M(ω)/m at `FREQUENCIES` from the answer to a step of the cells' velocity, and the noise.

    The step is a/(2π 1 kHz). With u(t) the mean velocity of the spheres in the cells, u(0) = −v:
    M/m = 1 + iω ∫ u e^(−iωt) dt/v. The noise is the rms speed of the spheres
    before it over v.
    """
    run = replace(resting, acceleration=0.0).run(200.0)
    preparation.write_start(folder, run.packing, spheres)
    speed = resting.acceleration * STANDARD_GRAVITY / (2 * math.pi * 1000)
    with Liggghts(folder, "shake") as solver:
        settled(resting, spheres, run, folder, solver)
        before = solver.run(1, read_energy=True)
        solver.read_deck(f"fix series all ave/time {STRIDE} 1 {STRIDE} v_p file momentum.txt")
        solver.set_velocity(0.0, 0.0, -speed)
        solver.run(math.ceil(LASTING / run.time_step))
        solver.finish()
    momentum = np.loadtxt(folder / "momentum.txt")
    momentum = momentum[momentum[:, 0] > momentum[0, 0]]
    time = (momentum[:, 0] - momentum[0, 0] + STRIDE) * run.time_step
    mass = float(geometry.masses(spheres[:, 3], resting.density).sum())
    answer = np.concatenate([[-1.0], momentum[:, 1] / (mass * speed)])
    time = np.concatenate([[0.0], time])
    omega = 2 * math.pi * FREQUENCIES[:, None]
    integral = np.trapezoid(answer * np.exp(-1j * omega * time), time, axis=1)
    noise = math.sqrt(2 * before.value / mass) / speed
    return 1 + 1j * omega[:, 0] * integral, noise


def under_tone(
    resting: Resting, spheres: Array, frequency: float, folder: Path
) -> tuple[complex, float, float]:
    """M(ω)/m at a frequency from a tone, its standard error, and the share of the side walls."""
    run = resting.run(frequency)
    preparation.write_start(folder, run.packing, spheres)
    mass = float(geometry.masses(spheres[:, 3], resting.density).sum())
    lasting = math.ceil(LASTING * frequency)
    with Liggghts(folder, "shake") as solver:
        settled(resting, spheres, run, folder, solver)
        solver.run(lasting * run.steps_per_cycle)
        share = wall_share(solver, run, len(spheres), folder)
        solver.finish()
    times = (*(time for time, _ in DRAGS), TRANSIENT)
    before = sum(math.ceil(time * frequency) for time in times)
    read = rows.read_rows(run, folder, [before + lasting], before + lasting)[before:]
    damping, inertia = rows.harmonic(run, read, mass)
    values = (inertia - 1j * damping / run.drive.angular_frequency) * run.packing.area / mass
    error = float(np.abs(values - values.mean()).std() / math.sqrt(lasting))
    return complex(values.mean()), error, share


def wall_share(solver: Liggghts, run: Run, spheres: int, folder: Path) -> float:
    """Share of the side walls in the walls' force in phase with the motion, over four cycles."""
    solver.end_rows(by_cell=run.cells_listed > 0)
    stride = run.steps_per_cycle // run.samples_per_cycle
    first, files = solver.list_contacts(4 * run.steps_per_cycle, stride, rolling=False)
    planes = window.wall_planes(run.packing)
    frames = 4 * run.samples_per_cycle + 1
    touches: balance.Contacts = output.read_contacts(
        files.touches.read_text(), "touches", frames=frames, ids=(spheres, len(planes)),
        with_wall=True, rolling=False,
    )  # fmt: skip
    force = np.zeros((2, frames))
    side = (np.abs(planes[touches.second, 2]) < 0.5).astype(int)
    np.add.at(force, (side, touches.frame), touches.force[:, 2])
    steps = first + stride * np.arange(frames)
    phase = np.sin(2 * np.pi * steps / run.steps_per_cycle)[:-1]
    floor, sides = (force[:, :-1] * phase).sum(axis=1)
    return float(sides / (floor + sides))


def column_frequency(resting: Resting, bulk_fraction: float, coordination: float = 5.0) -> float:
    """Quarter-wave frequency of a bed under its weight by effective medium [Hz].

    Digby and Walton: contacts of stiffness k_n = 2 E* √(R* δ) and k_t under p = ρ g depth, K = φ Z
    k_n/(12πR), G = φ Z (k_n + 3/2 k_t)/(20πR). The speed grows like depth^⅙, so that u =
    x^⅓ J_(−2/5)(…), whose first zero 1.751 gives f = (5/6) 1.751 c(h)/(2π h).
    """
    ratio, radius = resting.poissons_ratio, DIAMETER / 2
    stiff = resting.youngs_modulus / (2 * (1 - ratio**2))
    density = bulk_fraction * resting.density
    pressure = density * STANDARD_GRAVITY * resting.height
    force = 4 * math.pi * radius**2 * pressure / (bulk_fraction * coordination)
    depth = (3 * force / (4 * stiff * math.sqrt(radius / 2))) ** (2 / 3)
    normal = 2 * stiff * math.sqrt(radius / 2 * depth)
    tangential = normal * 2 * (1 - ratio) / (2 - ratio)
    per = bulk_fraction * coordination / (math.pi * radius)
    modulus = per * (normal / 12 + 4 / 3 * (normal + 1.5 * tangential) / 20)
    zero = brentq(lambda x: jv(-0.4, x), 1.0, 2.4)
    return 5 / 6 * zero * math.sqrt(modulus / density) / (2 * math.pi * resting.height)


def panel_rms(mass: Array, mass_per_area: float, folder: Path) -> dict[str, float]:
    """G rms of the launch panel at 100 dB with a resting and with a rigid mass on PID-1."""
    damping = np.maximum(0.0, -mass.imag) * mass_per_area * 2 * math.pi * FREQUENCIES
    table = np.column_stack([FREQUENCIES, damping, mass.real * mass_per_area])
    table = np.vstack([[20.0, 0.0, mass_per_area], [380.0, 0.0, mass_per_area], table])
    names = "frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2"
    np.savetxt(folder / "bed.csv", table, "%.6g", delimiter=",", header=names, comments="")
    values = yaml.safe_load((WORKFLOW / "studies" / "launch.yaml").read_text())
    dampers = {
        "resting": {"impedance": "bed.csv", "interpolation": "linear"},
        "rigid": {"equivalent_damping_n_s_m3": 0, "apparent_mass_kg_m2": mass_per_area},
    }
    values["panel"]["mesh"]["elements"] = [60, 40]  # resolves a resonant mass
    values = {key: values[key] for key in ("panel", "sound")} | {
        "dampers": dampers,
        "response": {"frequency_hz": [30, 2000]},
        "scenarios": {
            name: {"layout": {"PID-1": {"damper": name}}, "oaspl_db": 100} for name in dampers
        },
    }
    response = pidpanel.Model(values, folder).response()
    rms = response["acceleration_rms"].sel(point="326") / STANDARD_GRAVITY
    return {name: float(rms.sel(scenario=name)) for name in dampers}


def main() -> None:
    """Print M(ω)/m of the cases."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "build/resting").resolve()
    for name in sys.argv[2:] or CASES:
        resting = CASES[name]
        spheres = poured(resting, folder / name / "pour")
        bulk = len(spheres) * math.pi / 6 * DIAMETER**3 / (resting.packing.area * resting.height)
        expected = column_frequency(resting, bulk)
        print(f"{name}: {len(spheres)} spheres, fraction {bulk:.3f}, expected {expected:.0f} Hz")
        mass, noise = apparent_mass(resting, spheres, folder / name / "step")
        np.savetxt(folder / name / "mass.csv", np.c_[FREQUENCIES, mass.real, mass.imag],
                   delimiter=",", header="frequency_hz,real,imaginary", comments="")  # fmt: skip
        peak = int(np.argmax(-mass.imag))
        print(
            f"  largest loss {-mass.imag[peak]:.2f} m at {FREQUENCIES[peak]:.0f} Hz, "
            f"noise {noise:.3f}"
        )
        area_mass = bulk * resting.density * resting.height
        print(f"  g rms at 100 dB: {panel_rms(mass, area_mass, folder / name)}")
        for index in range(0, len(FREQUENCIES), 4):
            value = mass[index]
            print(
                f"  {FREQUENCIES[index]:6.0f} Hz  {value.real:+.3f} {value.imag:+.3f}i", flush=True
            )
        if name in TONES:
            for frequency in (WALL_FREQUENCY, float(FREQUENCIES[peak])):
                value, error, share = under_tone(
                    resting, spheres, frequency, folder / name / f"{frequency:.0f}"
                )
                print(
                    f"  tone {frequency:.0f} Hz {value:.3f} ± {error:.3f}, sides {share:.2f}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
