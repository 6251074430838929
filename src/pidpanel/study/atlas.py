"""What the atlas of particle beds requires of a coupon; its data: docs/atlas.md."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Literal

from pidpanel.constants import ATLAS
from pidpanel.study.mistakes import Keys, Mistake
from pidpanel.study.particles import Mono

if TYPE_CHECKING:
    from pidpanel.study.coupon import Coupon
    from pidpanel.study.study import Study

FILLS = (0.05, 0.95)  # range of the fill fraction r
RESTITUTION, FRICTION = (0.3, 0.95), (0.05, 0.8)  # of e and μ, equal for particles and walls
WIDTH, DEPTH = (2.0, 10.0), (4.0, 40.0)  # of a cell over the diameter
REMEDY = "; the damping model 'coupled' or 'dem' simulates it"


def direction_of(coupon: Coupon) -> Literal["flat", "upright"] | None:
    """Return the direction of gravity, along or across the motion; None if it is neither."""
    x, y, z = coupon.gravity_direction
    if x == y == 0:
        return "flat"
    return "upright" if z == 0 else None


def mistakes_of_atlas(study: Study) -> Iterator[Mistake]:
    """Yield what of the coupons that are read from the atlas, or start from it, lies outside."""
    if ATLAS in study.readings and not study.atlas_coupons:
        says = f"the damping model '{ATLAS}' needs a scenario with a coupon; there is none"
        yield Mistake(("damping", "readings"), says)
    for name, coupon in {**study.atlas_coupons, **study.prior_coupons}.items():
        keys: Keys = ("coupon",) if coupon is study.coupon else ("dampers", name, "coupon")
        yield from (mistake.prefix(*keys) for mistake in mistakes_of_coupon(coupon))
        for way, fill in study.fills(name):
            yield from mistakes_of_fill(way, fill)


def mistakes_of_fill(keys: Keys, fill: float) -> Iterator[Mistake]:
    """Yield a fill fraction outside the atlas."""
    if not FILLS[0] <= fill <= FILLS[1]:
        yield Mistake(keys, _outside(FILLS))


def mistakes_of_coupon(coupon: Coupon) -> Iterator[Mistake]:
    """Yield what of a coupon lies outside the atlas."""
    particles, cell = coupon.particles, coupon.cell
    diameter = coupon.diameters[0] * 1e3
    directions = "along the motion, [0, 0, -1], or across it, [1, 0, 0],"
    only: Mapping[Keys, tuple[bool, str]] = {
        ("cell", "shape"): (cell.shape == "hexagon", "hexagon"),
        ("particles", "distribution"): (isinstance(particles.distribution, Mono), "kind: mono"),
        ("particles", "rolling_friction"): (particles.rolling_friction == 0, "0"),
        ("gravity_g",): (coupon.gravity_g > 0, "above 0"),
        ("gravity_direction",): (direction_of(coupon) is not None, directions),
    }
    for keys, (is_met, allowed) in only.items():
        if not is_met:
            yield Mistake(keys, f"must be {allowed} for the damping model '{ATLAS}'{REMEDY}")
    for key in ("restitution", "friction"):
        wall = getattr(coupon.walls, key)
        if wall is not None and wall != getattr(particles, key):
            says = f"must equal particles.{key} for the damping model '{ATLAS}'{REMEDY}"
            yield Mistake(("walls", key), says)
    ranges: Mapping[Keys, tuple[float, tuple[float, float], float]] = {
        ("particles", "restitution"): (particles.restitution, RESTITUTION, 1.0),
        ("particles", "friction"): (particles.friction, FRICTION, 1.0),
        ("cell", "across_flats_mm"): (cell.across_flats_mm, WIDTH, diameter),
        ("cell", "depth_mm"): (cell.depth_mm, DEPTH, diameter),
    }
    for keys, (value, (low, high), unit) in ranges.items():
        if not low * unit <= value <= high * unit:
            yield Mistake(keys, _outside((low * unit, high * unit)) + REMEDY)


def _outside(allowed: tuple[float, float]) -> str:
    return f"must be in the range of the atlas, {allowed[0]:g} to {allowed[1]:g}"
