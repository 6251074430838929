"""Draw what the particles feel: steady acceleration, and restitution over the speed of impact.

`python benchmarks/particles.py` draws the table of docs/particles.md, and the viscoelastic law of
`pidpanel.coupon.impacts` with single impacts in LIGGGHTS (`tests/verification`), to docs/.
"""

import re
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pidpanel.coupon.impacts import rebound, viscous_group

DOCS = Path(__file__).resolve().parents[1] / "docs"
BLUE, ORANGE, GREEN = "#0072b2", "#d55e00", "#009e73"
INDEPENDENT = 0.02  # standard error of the independent code [1]
APART = 0.05  # of both marks from their acceleration [g]
STATED, AT = 0.8, 1.0  # e, and its speed [m/s]
# e of two spheres of 2 mm that meet at a speed [m/s]; with a wall it is the same within 1e-4.
SIMULATED = {0.05: 0.8838, 0.1: 0.8679, 0.2: 0.8500, 0.5: 0.8231, 1: 0.7999, 2: 0.7742, 5: 0.7361}


def rows(level: float) -> np.ndarray:
    """Return total acceleration [g], g rms, its error and that of the independent code, (n, 4)."""
    text = (DOCS / "particles.md").read_text(encoding="utf-8")
    number = r"([\d.]+)"
    row = rf"\| {level:g} dB \| {number} g \| {number} ± {number} \| {number} \|"
    return np.array(re.findall(row, text), float)


def draw_level(axes: Axes, level: float, ends: tuple[float, float]) -> None:
    """Draw g rms over the acceleration along the normal at a level."""
    total, rms, error, independent = rows(level).T
    axes.errorbar(total - APART, rms, error, fmt="o-", color=BLUE, capsize=3, label="coupled runs")
    axes.errorbar(
        total + APART, independent, INDEPENDENT * independent, fmt="s--", color=ORANGE, capsize=3,
        markerfacecolor="white", label="independent code",
    )  # fmt: skip
    axes.set(title=f"{level:g} dB", xlabel="total acceleration along the normal, g")
    axes.set(ylabel="rms acceleration at 326, g", ylim=ends, xticks=total)
    axes.grid(alpha=0.25)


def gravity() -> Figure:
    """Return the figure of the steady acceleration."""
    drawn = Figure(figsize=(8, 3.4), layout="constrained")
    left, right = drawn.subplots(1, 2)
    draw_level(left, 136.7, (14, 26))
    draw_level(right, 122, (2.4, 4.2))
    left.legend(loc="lower left")
    return drawn


def restitution() -> Figure:
    """Return the figure of the restitution."""
    drawn = Figure(figsize=(5, 3.2), layout="constrained")
    axes, speed = drawn.subplots(), np.geomspace(0.02, 10, 100)
    group = viscous_group(STATED)
    law = [rebound(group * (v / AT) ** 0.2) for v in speed]
    axes.semilogx(speed, law, color=BLUE, label="viscoelastic law, integrated")
    axes.plot(
        SIMULATED.keys(), SIMULATED.values(), "o", color=ORANGE, label="single impacts, LIGGGHTS"
    )
    axes.axhline(STATED, color=GREEN, ls="--", label="constant")
    axes.set(xlabel="speed of impact, m/s", ylabel="coefficient of restitution")
    axes.set(xlim=(speed[0], speed[-1]), ylim=(0.68, 0.95))
    axes.set_xticks([0.05, 0.2, 1, 5], ["0.05", "0.2", "1", "5"])
    axes.grid(alpha=0.25)
    axes.legend()
    return drawn


def main() -> None:
    gravity().savefig(DOCS / "particles_gravity.png", dpi=130)
    restitution().savefig(DOCS / "particles_restitution.png", dpi=130)


if __name__ == "__main__":
    main()
