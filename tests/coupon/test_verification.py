"""The solver's contacts against closed forms: one collision, one slide (real LIGGGHTS)."""

import math

import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import contact, deck
from pidpanel.coupon.solver import Liggghts

pytestmark = pytest.mark.liggghts

DIAMETER, DENSITY, MODULUS, NU = 2e-3, 1190.0, 5e7, 0.35


def values(restitution, friction, step_over_rayleigh, **more):
    rayleigh = contact.rayleigh_time(DIAMETER / 2, DENSITY, MODULUS, NU)
    return {
        "youngs_modulus": MODULUS,
        "poissons_ratio": NU,
        "restitution": restitution,
        "wall_restitution": restitution,
        "friction": friction,
        "wall_friction": friction,
        "diameter": DIAMETER,
        "density": DENSITY,
        "time_step": step_over_rayleigh * rayleigh,
        **more,
    }


def loss_of_a_collision(folder, restitution, step_over_rayleigh, speed=0.1):
    """Share of the kinetic energy that a head-on collision at ±speed takes."""
    settings = values(restitution, 0.3, step_over_rayleigh, speed=speed)
    gap = 0.01 * DIAMETER
    lasting = gap / (2 * speed) + 4 * contact.wall_contact_time(
        DIAMETER / 2, DENSITY, MODULUS, NU, speed
    )
    steps = math.ceil(lasting / settings["time_step"])
    folder.mkdir()
    with Liggghts(folder, "collide") as process:
        process.execute(deck.render("verification/collide.in.j2", {**settings, "steps": steps}))
        _, _, before = process.execute("run 0", "ke")
        _, _, after = process.execute(f"run {steps}", "ke")
        process.finish()
    return 1 - after / before


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.8, 0.95])
def test_a_collision_loses_what_its_restitution_says(tmp_path, restitution):
    loss = loss_of_a_collision(tmp_path / "c", restitution, 0.1)
    # first order in the step: 1.1 % was seen at a tenth of the Rayleigh time
    assert loss == pytest.approx(1 - restitution**2, rel=0.02)


def test_the_error_of_a_collision_falls_with_the_step(tmp_path):
    truth = 1 - 0.8**2
    coarse, fine = (
        abs(loss_of_a_collision(tmp_path / f"{step}", 0.8, step) - truth) for step in (0.2, 0.05)
    )
    # at least first order: a quarter of the step leaves less than a half of the error
    assert fine < 0.5 * coarse
    assert fine < 0.01 * truth


def test_a_collision_without_loss_loses_nothing(tmp_path):
    # symplectic Verlet keeps the energy to the square of the step, which is small here
    assert abs(loss_of_a_collision(tmp_path / "c", 1.0, 0.05)) < 2e-3


def test_a_sliding_sphere_ends_rolling_at_five_sevenths_of_its_speed(tmp_path):
    weight = DENSITY * math.pi / 6 * DIAMETER**3 * STANDARD_GRAVITY
    # at rest on the floor, sunk in by its weight: F = (4/3) E* √R δ^{3/2}
    effective = MODULUS / (2 * (1 - NU**2))
    sunk = (3 * weight / (4 * effective * math.sqrt(DIAMETER / 2))) ** (2 / 3)
    settings = values(
        0.5, 0.3, 0.1, gravity=STANDARD_GRAVITY, height=DIAMETER / 2 - sunk, steps=1000
    )
    # sliding lasts 2 v/(7 μ g); three times that and it rolls
    speed = 0.2
    steps = math.ceil(3 * 2 * speed / (7 * 0.3 * STANDARD_GRAVITY) / settings["time_step"])
    with Liggghts(tmp_path, "slide") as process:
        process.execute(deck.render("verification/slide.in.j2", settings))
        process.execute(f"velocity all set {speed} 0 0")
        _, _, rolling = process.execute(f"run {steps}", "v_speed")
        process.finish()
    # no time constant is in the answer, only momentum: 3e-5 was seen
    assert rolling / speed == pytest.approx(5 / 7, rel=1e-3)
