"""The energy balance against motions whose losses are known."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pidpanel.coupon import balance, contact, geometry, window
from pidpanel.coupon.from_study import cases_of
from pidpanel.geometry.cells import SHAPES
from pidpanel.study.coupon import Coupon

RADIUS, MASS = 1e-3, 5e-6


def elastic(modulus, friction):
    """A material whose tangential forces have no viscous part."""
    return contact.ContactMaterial(modulus, 0.0, friction, 0.0)


STEEL = elastic(2.85e7, 0.3)
FLOOR = np.array([[0.0, 0.0, 1.0, 0.0]])


def spheres(radius, mass, position, velocity, spin=None, earlier=None):
    position, velocity = np.asarray(position, float), np.asarray(velocity, float)
    return balance.SphereFrames(
        np.asarray(radius, float), np.asarray(mass, float), position, velocity,
        np.zeros_like(velocity) if spin is None else np.asarray(spin, float),
        velocity if earlier is None else np.asarray(earlier, float),
        np.zeros_like(velocity) if spin is None else np.asarray(spin, float),
    )  # fmt: skip


def contacts(frame=(), first=(), second=(), force=(), torque=None):
    return balance.Contacts(
        np.array(frame, int), np.array(first, int), np.array(second, int),
        np.array(force, float).reshape(-1, 3),
        None if torque is None else np.array(torque, float).reshape(-1, 3),
    )  # fmt: skip


def one(*motion):
    """A sphere in frames: position, velocity and further columns of `spheres`, (frames, 3) each."""
    return spheres(
        [RADIUS], [MASS], *(None if a is None else np.asarray(a)[:, None] for a in motion)
    )


def closed(
    moving, pairs=None, touches=None, step=1e-3, *, gravity=(0, 0, 0), acceleration=None,
    planes=FLOOR, wall=STEEL,
):  # fmt: skip
    frames = len(moving.position)
    return balance.energy_balance(
        moving, pairs or contacts(), touches or contacts(), planes, (STEEL, wall),
        np.zeros(frames) if acceleration is None else acceleration, np.array(gravity, float), step,
    )  # fmt: skip


def test_a_damped_hertz_collision_dissipates_the_kinetic_energy_that_is_gone():
    """Two spheres head-on; the motion from an integrator of its own at a relative 1e-10."""
    damping, speed = 0.6, 0.2
    stiffness = 4 / 3 * STEEL.effective_modulus * math.sqrt(RADIUS / 2)

    def force(depth, rate):
        return stiffness * max(depth, 0) ** 1.5 + damping * max(depth, 0) ** 0.25 * rate

    def motion(_, state):
        depth, rate = state
        return [rate, -2 * force(depth, rate) / MASS]

    end = 4e-4
    solution = solve_ivp(
        motion, (0, end), [0.0, 2 * speed], rtol=1e-10, atol=1e-14, dense_output=True
    )
    t = np.linspace(0, end, 4001)
    depth, rate = solution.sol(t)
    inside = depth > 0
    x = RADIUS - depth / 2
    zero = np.zeros_like(x)
    place = np.stack([np.stack([-x, zero, zero], 1), np.stack([x, zero, zero], 1)], axis=1)
    speed_ = np.stack(
        [np.stack([rate / 2, zero, zero], 1), np.stack([-rate / 2, zero, zero], 1)], 1
    )
    pushed = np.array([-force(d, r) for d, r in zip(depth, rate, strict=True)])
    (frame,) = np.nonzero(inside)
    pairs = contacts(
        frame, 0 * frame, 0 * frame + 1, np.stack([pushed, zero, zero], axis=1)[inside]
    )
    last = int(frame[-1]) + 2  # a frame after they have parted
    cut = spheres(np.full(2, RADIUS), np.full(2, MASS), place[:last], speed_[:last])
    found = closed(cut, pairs, step=t[1])
    gone = -found.kinetic_change
    assert gone > 0.1 * MASS * speed**2
    # 3000 frames over the contact, whose damping begins like δ^¼: the trapezoid is good to 1e-3
    assert found.sphere_normal == pytest.approx(gone, rel=1e-3)
    assert found.sphere_tangential == pytest.approx(0, abs=1e-12 * gone)
    assert abs(found.residual) < 1e-3 * gone


def test_friction_dissipates_force_times_way_and_no_more_than_coulomb_allows():
    t = np.linspace(0, 0.01, 11)
    depth = 1e-6
    normal = 4 / 3 * STEEL.effective_modulus * math.sqrt(RADIUS) * depth**1.5
    place = np.stack([0.3 * t, 0 * t, np.full_like(t, RADIUS - depth)], axis=1)
    velocity = np.tile([0.3, 0.0, 0.0], (11, 1))
    for listed, acting in ((0.2 * normal, 0.2 * normal), (0.45 * normal, 0.3 * normal)):
        force = np.tile([-listed, 0.0, normal], (11, 1))
        touches = balance.Contacts(np.arange(11), np.zeros(11, int), np.zeros(11, int), force)
        found = closed(one(place, velocity), None, touches, t[1])
        assert found.wall_tangential == pytest.approx(acting * 0.3 * 0.01)
        assert found.wall_normal == pytest.approx(0, abs=1e-15)


def test_a_rolling_sphere_loses_nothing_but_its_rolling_friction():
    t = np.linspace(0, 0.01, 11)
    depth, speed, resisting = 1e-6, 0.3, 1e-9
    normal = 4 / 3 * STEEL.effective_modulus * math.sqrt(RADIUS) * depth**1.5
    arm = RADIUS - depth / 2
    place = np.stack([speed * t, 0 * t, np.full_like(t, RADIUS - depth)], axis=1)
    velocity = np.tile([speed, 0.0, 0.0], (11, 1))
    spin = np.tile([0.0, speed / arm, 0.0], (11, 1))  # the point of contact stands still
    force = np.tile([-0.1 * normal, 0.0, normal], (11, 1))
    # of the tangential force about the centre, (0, 0, −arm) × F, and of rolling friction
    torque = np.tile([0.0, arm * 0.1 * normal - resisting, 0.0], (11, 1))
    touches = balance.Contacts(np.arange(11), np.zeros(11, int), np.zeros(11, int), force, torque)
    moving = one(place, velocity, spin)
    found = closed(moving, None, touches, t[1])
    assert found.wall_tangential == pytest.approx(0, abs=1e-18)
    assert found.rolling == pytest.approx(resisting * speed / arm * 0.01)
    unknown = dataclasses.replace(touches, torque=None)
    assert closed(moving, None, unknown, t[1]).rolling == 0


def test_work_and_weight_are_what_a_free_sphere_gains():
    t = np.linspace(0, 0.01, 2001)
    drive = 50 * np.sin(2 * np.pi * 100 * t)
    gravity = -9.81
    speed = gravity * t + 50 / (2 * np.pi * 100) * (1 - np.cos(2 * np.pi * 100 * t))
    place = np.cumsum(speed) * t[1]
    zero = 0 * t
    moving = one(np.stack([zero, zero, place], 1), np.stack([zero, zero, speed], 1))
    found = closed(moving, step=t[1], gravity=(0, 0, gravity), acceleration=drive)
    # the place is summed up by rectangles, good to a step in two thousand
    assert found.residual == pytest.approx(0, abs=2e-3 * abs(found.work))
    assert found.dissipated == 0


@pytest.mark.parametrize("shape", SHAPES)
def test_wall_planes_face_the_inside_of_their_own_cell(shape):
    sweep = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [5]}
    coupon = Coupon.model_validate({"cell": {"count": 3, "shape": shape}, "sweep": sweep})
    packing = cases_of(coupon)[0].point.packing
    planes, triangles = (
        window.wall_planes(packing),
        geometry.closed_cells(packing.outline, packing.centres, packing.depth),
    )
    assert len(planes) == len(triangles) == 3 * (len(packing.outline) + 2)
    np.testing.assert_allclose(np.linalg.norm(planes[:, :3], axis=1), 1)
    centres = geometry.cell_centres(packing.across_flats, 3)
    corners = len(packing.outline)
    for number, (plane, triangle) in enumerate(zip(planes, triangles, strict=True)):
        # all three corners lie on it, and the middle of the cell in front of it
        np.testing.assert_allclose(triangle @ plane[:3], plane[3], atol=1e-12)
        cell = number // corners if number < 3 * corners else (number - 3 * corners) % 3
        middle = np.array([*centres[cell], packing.depth / 2])
        distance = middle @ plane[:3] - plane[3]
        assert 0 < distance <= 1.001 * max(packing.across_flats, packing.depth) / 2


MODULUS = STEEL.effective_modulus
WALL = elastic(2 * MODULUS, 0.5)
STEP = 1e-3  # of `closed`


def hertz(relative_radius, depth, modulus=MODULUS):
    return 4 / 3 * modulus * np.sqrt(relative_radius) * depth**1.5


@pytest.mark.parametrize("pressed", [2, 0])
@pytest.mark.parametrize("offset", [0.0, -7e-3, 4e-3])
def test_a_sphere_that_a_wall_stops_trades_its_kinetic_energy_for_elastic(offset, pressed):
    # ½ m v² = (8/15) E* √R δ^(5/2) (Johnson, Contact Mechanics, eq. 11.22), with the modulus of
    # the wall, wherever that lies
    radius, mass, speed, modulus = 1e-3, 5e-6, 0.2, 2 * MODULUS
    depth = (15 * mass * speed**2 / (16 * modulus * np.sqrt(radius))) ** 0.4
    place, velocity = np.zeros((3, 1, 3)), np.zeros((3, 1, 3))
    place[..., 2], velocity[..., 2] = offset + radius, -speed
    place[pressed, 0, 2], velocity[pressed] = offset + radius - depth, 0
    found = closed(
        spheres([radius], [mass], place, velocity),
        touches=contacts([pressed], [0], [0], [0, 0, hertz(radius, depth, modulus)]),
        planes=np.array([[0.0, 0.0, 1.0, offset]]),
        wall=WALL,
    )
    energy = 0.5 * mass * speed**2 * (1 if pressed == 2 else -1)
    assert found.elastic_change == pytest.approx(energy)
    assert found.kinetic_change == pytest.approx(-energy)
    assert found.wall_normal == pytest.approx(0, abs=1e-9 * abs(energy))
    assert found.residual == pytest.approx(0, abs=1e-9 * abs(energy))


def test_two_spheres_that_have_stopped_each_other_hold_theirs():
    # unequal spheres, R* = R₁R₂/(R₁+R₂), speeds so that both stop at once
    r1, r2, m1, m2 = 1e-3, 2e-3, 5e-6, 4e-5
    relative = r1 * r2 / (r1 + r2)
    v1, v2 = 0.4, -0.4 * m1 / m2
    energy = 0.5 * m1 * v1**2 + 0.5 * m2 * v2**2
    depth = (energy * 15 / 8 / MODULUS / np.sqrt(relative)) ** 0.4
    place = [[[0, 0, 0], [r1 + r2, 0, 0]], [[0, 0, 0], [r1 + r2 - depth, 0, 0]]]
    moving = spheres([r1, r2], [m1, m2], place, [[[v1, 0, 0], [v2, 0, 0]], np.zeros((2, 3))])
    push = [-hertz(relative, depth), 0, 0]  # on the first, away from the second
    found = closed(moving, pairs=contacts([1], [0], [1], push))
    assert found.elastic_change == pytest.approx(energy)
    assert found.residual == pytest.approx(0, abs=1e-9 * energy)


def test_a_sphere_that_rolls_has_seven_tenths_of_m_v_squared():
    # ½ m v² + ½ (2/5 m R²)(v/R)²
    radius, mass, speed = 1e-3, 5e-6, 0.3
    moving = spheres(
        [radius], [mass], np.zeros((2, 1, 3)), [[[0, 0, 0]], [[speed, 0, 0]]],
        [[[0, 0, 0]], [[0, speed / radius, 0]]],
    )  # fmt: skip
    assert closed(moving).kinetic_change == pytest.approx(0.7 * mass * speed**2)


def pair_in_touch(spin1, spin2, velocity, force, torque=None, earlier=None):
    """Two unequal spheres along x for three frames, the contact listed in all."""
    r1, r2, depth = 1e-3, 2e-3, 2e-6
    place = np.broadcast_to([[r1 + r2 - depth, 0, 0], [0, 0, 0]], (3, 2, 3))
    moving = spheres(
        [r1, r2], [5e-6, 4e-5], place, np.broadcast_to(velocity, (3, 2, 3)),
        np.broadcast_to([spin1, spin2], (3, 2, 3)),
        None if earlier is None else np.broadcast_to(earlier, (3, 2, 3)),
    )  # fmt: skip
    full = [hertz(r1 * r2 / (r1 + r2), depth) + force[0], *force[1:]]
    listed = contacts(
        range(3), [0] * 3, [1] * 3, [full] * 3, None if torque is None else [torque] * 3
    )
    return closed(moving, pairs=listed), (r1 - depth / 2, r2 - depth / 2)


def test_spheres_geared_to_each_other_rub_nothing():
    # equal speeds of both surfaces at the contact, ω₁ a₁ = −ω₂ a₂, on top of a common motion
    arms = 1e-3 - 1e-6, 2e-3 - 1e-6
    common = [[0.3, 0.2, -0.1]] * 2
    found, _ = pair_in_touch([0, 0, 90.0], [0, 0, -90.0 * arms[0] / arms[1]], common, [0, 1e-6, 0])
    slip = 90.0 * arms[0] * 1e-6 * 2 * STEP  # what one sphere alone would rub
    assert found.sphere_tangential == pytest.approx(0, abs=1e-12 * slip)
    assert found.sphere_normal == pytest.approx(0, abs=1e-12 * slip)


def test_spheres_that_turn_alike_rub_force_times_way():
    # both surfaces move apart along y at ω (a₁ + a₂); the force on the first points the other way
    still = np.zeros((2, 3))
    found, (a1, a2) = pair_in_touch([0, 0, 90.0], [0, 0, 90.0], still, [0, 1e-6, 0])
    # the contact lies at −x of the first: its surface moves along −y there, the second's along +y
    assert found.sphere_tangential == pytest.approx(90.0 * (a1 + a2) * 1e-6 * 2 * STEP)


def test_damping_along_the_normal_takes_force_times_the_speed_half_a_step_before():
    # the first comes at −0.3 m/s and came at −0.5; the second leaves at −0.1 and left at −0.05
    found, _ = pair_in_touch(
        [0, 0, 0], [0, 0, 0], [[-0.3, 0, 0], [-0.1, 0, 0]], [2e-4, 0, 0],
        earlier=[[-0.5, 0, 0], [-0.05, 0, 0]],
    )  # fmt: skip
    assert found.sphere_normal == pytest.approx(2e-4 * 0.45 * 2 * STEP)


def test_what_is_left_of_the_torque_is_rolling_friction_of_the_relative_spin():
    # torque of the tangential force about the first centre, (−a₁, 0, 0) × (0, F, 0), less a
    # resistance M against the spin
    resisting, force = 1e-9, 1e-6
    arm = 1e-3 - 1e-6
    torque = [0, 0, -arm * force - resisting]
    found, _ = pair_in_touch([0, 0, 90.0], [0, 0, 30.0], np.zeros((2, 3)), [0, force, 0], torque)
    assert found.rolling == pytest.approx(resisting * 60.0 * 2 * STEP)


def test_rolling_is_no_matter_of_a_force_along_the_normal():
    # the torque of a normal force about the centre is none, however large; the one listed is all
    found, _ = pair_in_touch(
        [0, 0, 90.0], [0, 0, 0], np.zeros((2, 3)), [-5e-3, 0, 0], [0, 0, -1e-9]
    )
    assert found.rolling == pytest.approx(1e-9 * 90.0 * 2 * STEP)


def test_a_force_that_pulls_rubs_as_one_that_pushes():
    # cohesive or damped contacts pull: μ |F_n| bounds their friction too
    pull = 3 * hertz(1e-3 * 2e-3 / 3e-3, 2e-6)
    found, _ = pair_in_touch([0, 0, 0], [0, 0, 0], [[0, -0.2, 0], [0, 0, 0]], [-pull, 9.0, 0])
    assert found.sphere_tangential == pytest.approx(0.3 * 2 / 3 * pull * 0.2 * 2 * STEP)


def test_two_unlike_materials_are_springs_in_series():
    # 1/E* = (1 − ν₁²)/E₁ + (1 − ν₂²)/E₂: the softer decides, its Poisson's ratio counts
    found = contact.contact_material((3e9, 0.3), (5e7, 0.4), 0.3, 0.5)
    assert 1 / found.effective_modulus == pytest.approx(0.91 / 3e9 + 0.84 / 5e7)


def test_gravity_works_on_what_falls_and_losses_and_work_close():
    # two spheres of two masses, one moved along gravity: m g h; all parts of the sum
    place = [[[1, 2, 3.0], [0, 0, 0]], [[1, 2, 9.0], [0, 5, 0]], [[1, 2, 2.5], [0, 0.1, 0]]]
    moving = spheres([1e-3, 1e-3], [2e-6, 3e-6], place, np.zeros((3, 2, 3)))
    found = closed(moving, gravity=(0.0, 1.0, -9.81))
    assert found.gravity_work == pytest.approx(2e-6 * 9.81 * 0.5 + 3e-6 * 0.1)
    parts = balance.EnergyBalance(1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0)
    assert parts.dissipated == 16 + 32 + 64 + 128 + 256
    assert parts.residual == parts.dissipated - (1 + 2 - 4 - 8)


def test_the_effective_shear_modulus_is_that_of_mindlin():
    # 1/G* = (2 − ν)/G for each, G = E/(2(1 + ν))
    moduli, ratios = (3.0e9, 7.0e10), (0.35, 0.2)
    compliance = sum((2 - n) / (e / (2 * (1 + n))) for e, n in zip(moduli, ratios, strict=True))
    material = contact.contact_material(*zip(moduli, ratios, strict=True), 0.3, 0.5)
    assert material.effective_shear_modulus == pytest.approx(1 / compliance)


@pytest.mark.parametrize(
    ("share", "speed", "slides"),
    [
        (0.5, 0.2, False), (1.0 - 5e-6, 0.2, True), (1.0 - 5e-5, 0.2, False), (1.5, 0.2, True),
        (None, 0.2, True), (None, 3.0, True),
    ],
)  # fmt: skip
def test_a_contact_slides_at_its_limit_and_sticks_below(share, speed, slides):
    # a sphere on a floor, v′ half a step before v: the spring is a share of μ|F_n| with v′, or the
    # listed force is μ|F_n| with v, also where it pulls.
    material = contact.contact_material((5e7, 0.3), (5e7, 0.3), 0.4, 0.6)
    radius, mass, depth = 1e-3, 5e-6, 2e-5
    earlier_speed, slip, earlier_slip = -0.3, 0.1, 0.15
    one = np.ones(1)
    hertz, along, across = (
        float(value[0])
        for value in contact.contact_forces(material, depth * one, one / radius, one / mass)
    )
    push = hertz - along * speed
    limit = 0.4 * abs(hertz - along * earlier_speed)
    listed = 0.4 * abs(push) if share is None else share * limit - across * slip
    assert (push < 0) == (speed > 1)
    moving = spheres(
        radius * one, mass * one, [[[0, 0, radius - depth]]], [[[slip, 0, speed]]],
        earlier=[[[earlier_slip, 0, earlier_speed]]],
    )  # fmt: skip
    touch = contacts([0], [0], [0], [listed, 0, push])
    normal, tangential, rolling, elastic = balance.contact_losses(touch, moving, material, FLOOR)
    acting = np.sign(listed) * limit if slides else listed + across * (slip - earlier_slip)
    assert tangential[0] == pytest.approx(-acting * slip, rel=1e-9)
    assert normal[0] == pytest.approx(along * speed * earlier_speed)
    assert elastic[0] == pytest.approx(2 / 5 * hertz * depth) and rolling[0] == 0
