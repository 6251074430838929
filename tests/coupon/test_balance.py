"""The energy balance against motions whose losses are known."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pidpanel.coupon import balance, geometry, window
from pidpanel.coupon.from_study import cases_of
from pidpanel.geometry.cells import SHAPES
from pidpanel.study.coupon import Coupon

RADIUS, MASS = 1e-3, 5e-6
STEEL = balance.Material(effective_modulus=2.85e7, friction=0.3)
NOTHING = balance.Contacts(np.empty(0, int), np.empty(0, int), np.empty(0, int), np.empty((0, 3)))
FLOOR = np.array([[0.0, 0.0, 1.0, 0.0]])


def one(position, velocity, spin=None, earlier=None):
    """A sphere in frames, (frames, 3) each."""
    position, velocity = np.asarray(position)[:, None], np.asarray(velocity)[:, None]
    return balance.Spheres(
        radius=np.array([RADIUS]),
        mass=np.array([MASS]),
        position=position,
        velocity=velocity,
        spin=np.zeros_like(velocity) if spin is None else np.asarray(spin)[:, None],
        earlier_velocity=velocity if earlier is None else np.asarray(earlier)[:, None],
    )


def closed(spheres, pairs, touches, step, *, gravity=(0, 0, 0), acceleration=None):
    frames = len(spheres.position)
    return balance.energy_balance(
        spheres, pairs, touches, FLOOR, (STEEL, STEEL),
        np.zeros(frames) if acceleration is None else acceleration,
        np.array(gravity, float), step,
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
    spheres = balance.Spheres(
        np.full(2, RADIUS), np.full(2, MASS), place, speed_, np.zeros_like(speed_), speed_
    )
    pushed = np.array([-force(d, r) for d, r in zip(depth, rate, strict=True)])
    (frame,) = np.nonzero(inside)
    pairs = balance.Contacts(
        frame, np.zeros(len(frame), int), np.ones(len(frame), int),
        np.stack([pushed[inside], zero[inside], zero[inside]], axis=1),
    )  # fmt: skip
    last = int(frame[-1]) + 2  # a frame after they have parted
    cut = balance.Spheres(
        spheres.radius, spheres.mass, place[:last], speed_[:last], np.zeros_like(speed_[:last]),
        speed_[:last],
    )  # fmt: skip
    found = closed(cut, pairs, NOTHING, t[1])
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
        found = closed(one(place, velocity), NOTHING, touches, t[1])
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
    spheres = one(place, velocity, spin)
    found = closed(spheres, NOTHING, touches, t[1])
    assert found.wall_tangential == pytest.approx(0, abs=1e-18)
    assert found.rolling == pytest.approx(resisting * speed / arm * 0.01)
    unknown = dataclasses.replace(touches, torque=None)
    assert closed(spheres, NOTHING, unknown, t[1]).rolling == 0


def test_work_and_weight_are_what_a_free_sphere_gains():
    t = np.linspace(0, 0.01, 2001)
    drive = 50 * np.sin(2 * np.pi * 100 * t)
    gravity = -9.81
    speed = gravity * t + 50 / (2 * np.pi * 100) * (1 - np.cos(2 * np.pi * 100 * t))
    place = np.cumsum(speed) * t[1]
    zero = 0 * t
    spheres = one(np.stack([zero, zero, place], 1), np.stack([zero, zero, speed], 1))
    found = closed(spheres, NOTHING, NOTHING, t[1], gravity=(0, 0, gravity), acceleration=drive)
    # the place is summed up by rectangles, good to a step in two thousand
    assert found.residual == pytest.approx(0, abs=2e-3 * abs(found.work))
    assert found.dissipated == 0


def test_the_effective_modulus_of_two_materials_is_that_of_springs_in_series():
    assert balance.effective_modulus((2e9, 2e9), (0.0, 0.0)) == pytest.approx(1e9)
    assert balance.effective_modulus((2e9, 1e20), (0.5, 0.3)) == pytest.approx(2e9 / 0.75)


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
