"""Draw modal force and damping of three modes, free in a room against a baffle.

The paper's panel with sine modes. `python benchmarks/surroundings.py` writes
``docs/surroundings.png``.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.sound.field import tabulate_diffuse
from pidpanel.sound.free_edges import FreePanel, tabulate_diffuse_room
from pidpanel.sound.rectangle import RectangleJumps

DOCS = Path(__file__).resolve().parents[1] / "docs"
SIDES = np.array([1.5, 1.0])  # [m]
MODAL_MASS, STIFFNESS, MASS = 1.5, 3273.07, 4.0  # [kg], [N m], [kg/m²]
DENSITY, SPEED = 1.2, 343.0
MODES = {(1, 1): "#0072b2", (2, 1): "#d55e00", (3, 1): "#009e73"}
FREQUENCY = np.geomspace(30, 1000, 300)  # [Hz]
RESOLVED = 20.0  # wavenumber of the face [rad/m]


def natural_frequency(m: int, n: int) -> float:
    """Return Navier's natural frequency [Hz]."""
    wavenumber_square = (m * np.pi / SIDES[0]) ** 2 + (n * np.pi / SIDES[1]) ** 2
    return float(wavenumber_square * np.sqrt(STIFFNESS / MASS) / (2 * np.pi))


def sine_face() -> PanelQuadrature:
    """Return the face in the modes."""
    node, weight = np.polynomial.legendre.leggauss(40)
    x, y = (side / 2 * (1 + node) for side in SIDES)
    weights = np.outer(weight, weight).ravel() * SIDES.prod() / 4
    shapes = [
        np.outer(np.sin(m * np.pi * x / SIDES[0]), np.sin(n * np.pi * y / SIDES[1])).ravel()
        for m, n in MODES
    ]
    position = np.stack([g.ravel() for g in np.meshgrid(x, y, indexing="ij")], axis=1)
    return condensed(PanelQuadrature(position, weights, np.stack(shapes, axis=1)), 2 * RESOLVED)


def modal_forces() -> dict[str, np.ndarray]:
    """Return G of one of two faces (nf, modes) [m⁴], free and in a baffle."""
    k = 2 * np.pi * FREQUENCY / SPEED
    face = sine_face()
    panel = FreePanel.of_jumps(RectangleJumps.of_box(np.zeros(2), SIDES, RESOLVED), k[-1])
    free, _ = tabulate_diffuse_room(panel, face)
    tables = {"free": free, "baffle": tabulate_diffuse(k[-1], face)}
    return {name: np.einsum("kii->ki", table.matrix(k)) for name, table in tables.items()}


def figure() -> Figure:
    """Return the force on the modes and their damping by the air over frequency."""
    forces = modal_forces()
    drawn = Figure(figsize=(9, 3.6), layout="constrained")
    left, right = drawn.subplots(1, 2)
    omega = 2 * np.pi * FREQUENCY
    for number, ((m, n), colour) in enumerate(MODES.items()):
        resonance = natural_frequency(m, n)
        # of the room's level on two faces; of the same level on one surface
        for name, level, faces, line in (("free", 4, 2, "-"), ("baffle", 1, 1, "--")):
            force = forces[name][:, number]
            label = f"({m},{n}), {resonance:.0f} Hz" if name == "free" else None
            damping = 100 * faces * DENSITY * omega * force / (4 * np.pi * SPEED * MODAL_MASS)
            for axes, values in ((left, level * force), (right, damping)):
                axes.loglog(FREQUENCY, values, line, color=colour, label=label)
                at = np.exp(np.interp(np.log(resonance), np.log(FREQUENCY), np.log(values)))
                axes.plot(resonance, at, "o", color=colour, markersize=5)
    left.set(ylabel="modal force / pressure PSD of the table, m⁴", ylim=(1e-3, 2))
    right.set(ylabel="damping ratio by the air, %", ylim=(0.03, 20))
    for axes in (left, right):
        axes.set(xlabel="frequency, Hz", xlim=(FREQUENCY[0], FREQUENCY[-1]))
        axes.grid(alpha=0.25)
        axes.set_xticks([50, 100, 200, 500, 1000], ["50", "100", "200", "500", "1000"])
        axes.set_xticks([], minor=True)
    right.yaxis.set_major_formatter("{x:g}")
    left.legend(title="mode; — free, - - baffle", fontsize=8, title_fontsize=8)
    return drawn


def main() -> None:
    forces = modal_forces()
    for number, (m, n) in enumerate(MODES):
        f = natural_frequency(m, n)
        free, baffle = (
            np.interp(f, FREQUENCY, forces[name][:, number]) for name in ("free", "baffle")
        )
        share = DENSITY * 2 * np.pi * f / (4 * np.pi * SPEED * MODAL_MASS)
        load = 10 * np.log10(4 * free / baffle)
        print(
            f"({m},{n}) {f:.1f} Hz: load {load:+.1f} dB, damping by the air"
            f" {200 * share * free:.2f} % free, {100 * share * baffle:.2f} % baffle"
        )
    figure().savefig(DOCS / "surroundings.png", dpi=130)


if __name__ == "__main__":
    main()
