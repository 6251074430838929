"""Single contacts of LIGGGHTS: a collision, and a slide that friction ends."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact
from pidpanel.coupon.liggghts import deck, sphere_dump
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import Constants
from pidpanel.verification.rows import Row

POISSONS_RATIO = 0.35
DENSITY = 1190.0
DIAMETER = 2e-3
MODULUS = 5e7
FRICTION = 0.3
RAYLEIGH = contact.rayleigh_time(DIAMETER / 2, DENSITY, MODULUS, POISSONS_RATIO)

COLLISION = "Head-on collision of two spheres"
# At a tenth of the Rayleigh time: the error is of first order in the step, and was 1.0 %.
COLLISION_TOLERANCE = 0.02

SLIDING = "Sphere set sliding on a floor"
SLIDING_TOLERANCE = 1e-3  # no time constant is in the answer, only momentum; 3e-5 was seen

# Velocity Verlet keeps the energy to the square of the step at least; 8e-5 was seen.
LOSSLESS_TOLERANCE = 5e-4


# Pairs of spheres that meet at different moments within a time step: the loss of one collision
# depends on that moment, and only the worst of several falls steadily with the step.
PAIRS = 8


def alike(youngs_modulus: float, restitution: float, friction: float) -> Constants:
    """Constants of contacts where walls are of the spheres' material; no rolling friction."""
    return Constants(
        youngs_modulus=youngs_modulus,
        wall_youngs_modulus=youngs_modulus,
        poissons_ratio=POISSONS_RATIO,
        wall_poissons_ratio=POISSONS_RATIO,
        restitution=restitution,
        wall_restitution=restitution,
        friction=friction,
        wall_friction=friction,
        rolling_friction=0.0,
        wall_rolling_friction=0.0,
    )


def _pair(restitution: float, step: float, **options: Any) -> dict[str, Any]:
    """Values of the decks of one contact; ``step`` is the time step over the Rayleigh time."""
    return {
        **alike(MODULUS, restitution, FRICTION).deck_values,
        "diameter": DIAMETER,
        "density": DENSITY,
        "time_step": step * RAYLEIGH,
        **options,
    }


def energy_lost(folder: Path, restitution: float, step: float, speed: float = 0.1) -> Array:
    """Share of the kinetic energy that head-on collisions at ±speed take, (`PAIRS`,)."""
    time_step = step * RAYLEIGH
    gaps = 0.01 * DIAMETER + 2 * speed * time_step * np.arange(PAIRS) / PAIRS
    # long enough for the slowest rebound to part them again
    lasting = gaps[-1] / (2 * speed) + 4 * contact.wall_contact_time(
        DIAMETER / 2, DENSITY, MODULUS, POISSONS_RATIO, speed
    )
    steps = math.ceil(lasting / time_step)
    values = _pair(restitution, step, steps=steps, speed=speed, gaps=gaps.tolist())
    folder.mkdir(parents=True, exist_ok=True)
    with Liggghts(folder, "collide") as solver:
        solver.read_deck(deck.render("verification/collide.in.j2", values))
        solver.run_and_dump(steps, steps, "ends.dump", ("vx",))
        solver.finish()
    ends = sphere_dump.read_dump(
        (folder / "ends.dump").read_text(), str(folder / "ends.dump"), ("vx",)
    )
    initial, final = (ends[[0, -1], :, 0] ** 2).reshape(2, PAIRS, 2).sum(axis=2)
    return 1 - final / initial


def rolling_speed(folder: Path, speed: float = 0.2) -> float:
    """Final over first speed of a sphere set sliding on a floor without spin."""
    weight = DENSITY * math.pi / 6 * DIAMETER**3 * STANDARD_GRAVITY
    # at rest on the floor, sunk in by its weight: F = (4/3) E* √R δ^{3/2}
    effective = MODULUS / (2 * (1 - POISSONS_RATIO**2))
    sunk = (3 * weight / (4 * effective * math.sqrt(DIAMETER / 2))) ** (2 / 3)
    # sliding lasts 2 v/(7 μ g); three times that and it rolls
    lasting = 3 * 2 * speed / (7 * FRICTION * STANDARD_GRAVITY)
    steps = math.ceil(lasting / (0.1 * RAYLEIGH))
    height = DIAMETER / 2 - sunk
    values = _pair(0.5, 0.1, steps=steps, gravity=STANDARD_GRAVITY, height=height)
    folder.mkdir(parents=True, exist_ok=True)
    with Liggghts(folder, "slide") as solver:
        solver.read_deck(deck.render("verification/slide.in.j2", values))
        solver.set_velocity(speed, 0.0, 0.0)
        last = solver.run(steps, "mean_speed").value
        solver.finish()
    return last / speed


STEP_TEXT = f"step {0.1 * RAYLEIGH * 1e6:.2g} µs (0.1 Rayleigh)"


def collision_rows(folder: Path) -> list[Row]:
    """Head-on collisions over restitution, the worst pair of each."""
    rows = []
    for restitution in (0.3, 0.6, 0.8, 0.95, 1.0):
        reference = 1 - restitution**2
        lost = energy_lost(folder / f"e{restitution}", restitution, 0.1)
        rows.append(
            Row(
                case=COLLISION,
                quantity=f"share of energy lost, e = {restitution:g}",
                computed=float(lost[np.argmax(np.abs(lost - reference))]),
                reference=reference,
                unit="1",
                tolerance=COLLISION_TOLERANCE if reference else LOSSLESS_TOLERANCE,
                method=f"worst of {PAIRS} pairs, {STEP_TEXT}",
                source="1 − e²",
                at=restitution,
            )
        )
    return rows


def sliding_rows(folder: Path) -> list[Row]:
    """A sphere that friction brings from sliding to rolling."""
    return [
        Row(
            case=SLIDING,
            quantity="speed when it rolls, over the first",
            computed=rolling_speed(folder),
            reference=5 / 7,
            unit="1",
            tolerance=SLIDING_TOLERANCE,
            method=f"1 sphere, μ = {FRICTION:g}, {STEP_TEXT}",
            source="angular momentum about the contact, I = (2/5) m R²",
        )
    ]
