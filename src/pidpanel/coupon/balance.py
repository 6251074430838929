"""The energy balance of a run from its contacts: where the work of the shaker goes.

The paper's Eq. 3, with the relative velocity in both terms and F_n without its elastic part:

    D_n = −Σ_c ∫ (F_n − F_Hertz) v_n dt,   D_t = −Σ_c ∫ F_t · v_t dt

over all contacts c of spheres with spheres and with walls. Independently of the momentum that
`cycles` measures,

    W + W_g = D_n + D_t + ΔE_kin + ΔE_Hertz

with the work W of the inertial force and W_g of gravity. The residual is the error of the run: of
its time step, of a wall that leaks, of a wrong contact law. The energy in
tangential springs is not listed separately; its change over a cycle is negligible.
"""

from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.coupon.contact import ContactMaterial, contact_forces


@dataclass(frozen=True)
class Contacts:
    """Contacts listed at a number of instants (frames)."""

    frame: Index  # (n,) index of the frame
    first: Index  # (n,) the sphere on which the force acts, from 0
    second: Index  # (n,) the other sphere, from 0; for walls the triangle
    force: Array  # (n, 3) [N]
    # (n, 3) on the first sphere about its centre, as LIGGGHTS gives it [N m]; only rolling friction
    # is taken from it, so a deck without rolling friction needs none
    torque: Array | None = None


@dataclass(frozen=True)
class SphereFrames:
    """The spheres, and how they move in each frame."""

    # (k,) [m], [kg]
    radius: Array
    mass: Array
    # (frames, k, 3) [m], [m/s]
    position: Array
    velocity: Array
    spin: Array  # (frames, k, 3) [rad/s]
    # (frames, k, 3) half a step before [m/s], [rad/s]: those that the damping of the step saw
    earlier_velocity: Array
    earlier_spin: Array


@dataclass(frozen=True)
class EnergyBalance:
    """Energies of one run over a window [J]; see the head of the module.

    The last five are dissipated: along and across the normal between spheres and at walls, in
    rolling.
    """

    work: float
    gravity_work: float
    kinetic_change: float
    elastic_change: float
    sphere_normal: float
    sphere_tangential: float
    wall_normal: float
    wall_tangential: float
    rolling: float

    @property
    def dissipated(self) -> float:
        """All losses [J]."""
        between_spheres = self.sphere_normal + self.sphere_tangential
        return between_spheres + self.wall_normal + self.wall_tangential + self.rolling

    @property
    def residual(self) -> float:
        """Dissipated less what there was to dissipate [J]."""
        supplied = self.work + self.gravity_work - self.kinetic_change - self.elastic_change
        return self.dissipated - supplied


# LIGGGHTS lists forces with six digits.
ROUNDING = 1e-5


def _dot(a: Array, b: Array) -> Array:
    """Return scalar products (n,) of vectors (n, 3), four times as fast as a sum of products."""
    return np.einsum("ij,ij->i", a, b)


def _relative_velocity(contacts: Contacts, velocity: Array, spin: Array, arms: Array) -> Array:
    """Return the velocity (n, 3) of the first surface against the second in each contact [m/s].

    ``arms`` (1 or 2, n, 3) go from the centre of each sphere to the contact; a wall has none and
    is at rest.
    """
    f = contacts.frame
    first, *second = (
        velocity[f, sphere] + np.cross(spin[f, sphere], arm)
        for sphere, arm in zip((contacts.first, contacts.second), arms, strict=False)
    )
    return np.asarray(first - second[0] if second else first)


def contact_losses(
    contacts: Contacts, spheres: SphereFrames, material: ContactMaterial, planes: Array | None
) -> tuple[Array, Array, Array, Array]:
    """Return the power lost in each contact: normal, tangential, rolling [W]; 2/5 F δ [J].

    ``planes`` are those of walls, which do not move; None between spheres.

    Notes
    -----
    A force acts with the velocity half a step before, v′, and does the work F · v dt with that at
    the end of the step, v. LIGGGHTS lists the forces evaluated again with v, so the viscous parts
    are taken back to v′. A contact slides if its spring reaches μ|F_n|; its force is then μ|F_n|
    without a viscous part, which the list may have added. In a contact that sticks, spring and
    viscous force together may exceed μ|F_n|: LIGGGHTS limits only the spring.
    """
    i, j, f = contacts.first, contacts.second, contacts.frame
    radii, masses = [spheres.radius[i]], [spheres.mass[i]]
    # towards the first sphere, and how deep they touch
    if planes is None:
        separation = spheres.position[f, i] - spheres.position[f, j]
        distance = np.sqrt(_dot(separation, separation))
        normal, overlap = separation / distance[:, None], radii[0] + spheres.radius[j] - distance
        radii, masses = [*radii, spheres.radius[j]], [*masses, spheres.mass[j]]
    else:
        normal = planes[j, :3]
        overlap = radii[0] + planes[j, 3] - _dot(spheres.position[f, i], normal)
    # the contact lies half the overlap inside each surface; LIGGGHTS has it so at walls, too
    sides = zip((-1, 1), radii, strict=False)
    arms = np.array([side * (radius - overlap / 2)[:, None] * normal for side, radius in sides])
    velocity = _relative_velocity(contacts, spheres.velocity, spheres.spin, arms)
    earlier = _relative_velocity(contacts, spheres.earlier_velocity, spheres.earlier_spin, arms)
    speed, earlier_speed = _dot(velocity, normal), _dot(earlier, normal)
    slip = velocity - speed[:, None] * normal
    earlier_slip = earlier - earlier_speed[:, None] * normal

    depth = np.maximum(overlap, 0.0)
    curvature, mobility = (np.sum(1 / np.array(part), axis=0) for part in (radii, masses))
    hertz, viscous, sideways_viscous = contact_forces(material, depth, curvature, mobility)
    push = _dot(contacts.force, normal)
    sideways = contacts.force - push[:, None] * normal
    limit = material.friction * np.abs(push + viscous * (speed - earlier_speed))
    sideways = _acting(
        sideways, sideways_viscous[:, None] * slip, sideways_viscous[:, None] * earlier_slip,
        limit, material.friction * np.abs(push),
    )  # fmt: skip
    rolling = np.zeros(len(speed))
    if contacts.torque is not None:
        # what is left of the torque is rolling friction
        rest = contacts.torque - np.cross(arms[0], contacts.force - push[:, None] * normal)
        turning = spheres.spin[f, i] - (spheres.spin[f, j] if planes is None else 0.0)
        rolling = -_dot(rest, turning)
    return -(push - hertz) * earlier_speed, -_dot(sideways, slip), rolling, 2 / 5 * hertz * depth


def _acting(
    listed: Array, viscous: Array, earlier_viscous: Array, limit: Array, listed_limit: Array
) -> Array:
    """Return the tangential forces (n, 3) [N] from those listed; see `contact_losses`.

    ``viscous`` and ``earlier_viscous`` (n, 3) resist the motion at the end of the step and half a
    step before; the limits μ|F_n| (n,) are those of the step and of the list.
    """
    size = np.sqrt(_dot(listed, listed))
    spring = listed + viscous
    slides = np.sqrt(_dot(spring, spring)) >= limit - ROUNDING * size
    slides |= np.abs(size - listed_limit) <= ROUNDING * size
    sliding = listed * (limit / np.maximum(size, 1e-300))[:, None]
    return np.where(slides[:, None], sliding, spring - earlier_viscous)


def _kinetic_energy(spheres: SphereFrames) -> Array:
    """Return the kinetic energy of all spheres with their spin in each frame, (frames,) [J]."""
    inertia = 0.4 * spheres.mass * spheres.radius**2
    return 0.5 * (
        (spheres.mass * (spheres.velocity**2).sum(axis=-1)).sum(axis=1)
        + (inertia * (spheres.spin**2).sum(axis=-1)).sum(axis=1)
    )


def energy_balance(
    spheres: SphereFrames,
    pairs: Contacts,
    touches: Contacts,
    planes: Array,
    materials: tuple[ContactMaterial, ContactMaterial],
    acceleration: Array,
    gravity: Array,
    step: float,
) -> EnergyBalance:
    """Return the energy balance over frames a ``step`` [s] apart, by the trapezoidal rule.

    ``planes`` (t, 4) are unit normal into the cell and offset of each wall triangle, n·x = offset
    on it; ``materials`` those of sphere on sphere and of sphere on wall; ``acceleration`` (frames,)
    that of the inertial force along z as seen from the cells, ``gravity`` (3,) [m/s²].
    """
    frames = len(spheres.position)
    pair = contact_losses(pairs, spheres, materials[0], None)
    wall = contact_losses(touches, spheres, materials[1], planes)

    def per_frame(frame: Index, values: Array) -> Array:
        return np.bincount(frame, values, minlength=frames).astype(float)

    def total(frame: Index, values: Array) -> float:
        return float(np.trapezoid(per_frame(frame, values), dx=step))

    momentum = (spheres.mass[:, None] * spheres.velocity).sum(axis=1)
    kinetic = _kinetic_energy(spheres)
    elastic = per_frame(pairs.frame, pair[3]) + per_frame(touches.frame, wall[3])
    fall = (spheres.mass[:, None] * (spheres.position[-1] - spheres.position[0])).sum(axis=0)
    return EnergyBalance(
        work=float(np.trapezoid(acceleration * momentum[:, 2], dx=step)),
        gravity_work=float(gravity @ fall),
        kinetic_change=float(kinetic[-1] - kinetic[0]),
        elastic_change=float(elastic[-1] - elastic[0]),
        sphere_normal=total(pairs.frame, pair[0]),
        sphere_tangential=total(pairs.frame, pair[1]),
        wall_normal=total(touches.frame, wall[0]),
        wall_tangential=total(touches.frame, wall[1]),
        rolling=total(pairs.frame, pair[2]) + total(touches.frame, wall[2]),
    )
