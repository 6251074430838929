"""What the particles feel: steady acceleration, and restitution over the speed of impact.

    python benchmarks/particles.py [figures] [atlas]

`figures` draws the table of docs/particles.md, and the viscoelastic law of
`pidpanel.coupon.impacts` with single impacts in LIGGGHTS (`tests/verification`), to docs/.

`atlas` compares the atlas with particles_cases.csv: beds that set nothing in it, under 2, 4 and 7 g
along and across the motion, and 1, 2 and 4 g at 30, 45 and 60 degrees from it. They were drawn as
those of `atlas_design`, with equal Γ over their own acceleration. The rows are those of
``coupon/cases.csv``, the particles 2 mm acrylic.
"""

import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pidpanel.coupon.impacts import rebound, viscous_group
from pidpanel.damping.atlas import REGIMES, atlas_bed
from pidpanel.damping.atlas_files import read_atlas

CASES = Path(__file__).with_name("particles_cases.csv")
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
    axes.yaxis.set_major_formatter("{x:g}")
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


def prediction(row: Mapping[str, Any], across: float, gravity: float) -> np.ndarray:
    """Return ln C_e, m_a/m″, their standard errors and W/L of a case, by the atlas."""
    sizes = [1e-3 * row[key] for key in ("cell.across_flats_mm", "cell.depth_mm", "diameter_mm")]
    e, friction = row["particles.restitution"], row["particles.friction"]
    bed = atlas_bed(e, friction, *sizes, [across], gravity)
    mass, point = row["particle_mass_per_area_kg_m2"], (row["fill_fraction"], row["acceleration_g"])
    damping = read_atlas().damping_of(bed, mass / point[0])
    frequency = np.array([row["frequency_hz"]])
    values = damping(frequency, *point)
    error, mass_error = np.sqrt(np.diag(damping.cross_covariance(frequency, point, point)))
    stroke = damping.stroke_per_gap(frequency, *point)[0]
    damping_value, mass_value = values.equivalent_damping[0], values.apparent_mass[0]
    return np.array([np.log(damping_value), mass_value / mass, error, mass_error / mass, stroke])


def count() -> pd.DataFrame:
    """Return the errors of the atlas (n,) of ln C_e and m_a/m″, and z, of every case."""
    cases, found = pd.read_csv(CASES), []
    cases = cases[cases["equivalent_damping_n_s_m3"] > cases["equivalent_damping_error_n_s_m3"]]
    for row in cases.to_dict("records"):
        direction = np.array(row["gravity_direction"].split(), float)
        across = round(float(1 - direction[2] ** 2 / (direction @ direction)), 4)
        value, mass, error, mass_error, stroke = prediction(row, across, row["gravity_g"])
        c, m = row["equivalent_damping_n_s_m3"], row["apparent_mass_kg_m2"]
        weight = row["particle_mass_per_area_kg_m2"]
        errors = (
            row["equivalent_damping_error_n_s_m3"] / c,
            row["apparent_mass_error_kg_m2"] / weight,
        )
        away = value - np.log(c), mass - m / weight
        found.append({
            "gravity": {0: "along", 1: "across"}.get(across, "oblique"), "across": across,
            "regime": int(np.digitize(stroke, REGIMES)), "total_g": row["gravity_g"],
            "damping": away[0], "z": away[0] / np.hypot(error, errors[0]), "error": error,
            "mass": away[1], "z_mass": away[1] / np.hypot(mass_error, errors[1]),
        })  # fmt: skip
    return pd.DataFrame(found)


def print_count() -> None:
    """Print the table of the atlas."""
    names = "acceleration | cases | factor of C_e, median | mean of ln C_e | rms z | within 95 %"
    print(f"| {names} | m_a/m″, median | within 95 % |\n|{'---|' * 8}")
    found = count()
    for name, part in [*found.groupby("gravity"), *found.groupby("regime"), ("all", found)]:
        z, away = part[["z", "z_mass"]].to_numpy(), part["damping"]
        within = 100 * (np.abs(z) < 1.96).mean(axis=0)
        print(f"| {name} | {len(part)} | {np.exp(away.abs().median()):.2f} | "
              f"{away.mean():+.2f} ± {away.std() / np.sqrt(len(part)):.2f} | "
              f"{np.sqrt(np.mean(z[:, 0] ** 2)):.2f} | {within[0]:.0f} % | "
              f"{part['mass'].abs().median():.2f} | {within[1]:.0f} % |")  # fmt: skip


def main() -> None:
    """Draw the figures and print the table."""
    chosen = sys.argv[1:] or ["figures", "atlas"]
    if "atlas" in chosen:
        print_count()
    if "figures" not in chosen:
        return
    gravity().savefig(DOCS / "particles_gravity.png", dpi=130)
    restitution().savefig(DOCS / "particles_restitution.png", dpi=130)


if __name__ == "__main__":
    main()
