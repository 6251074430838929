"""Coupons of small cells with few spheres."""

from pidpanel.coupon.from_study import cases_of
from pidpanel.study.coupon import Coupon

SMALL = {
    "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 1},
    "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
    "sweep": {"fill_fraction": [0.5], "frequency_hz": [200], "acceleration_g": [10]},
}


def with_changes(values, changes):
    """Sections with some of their keys changed."""
    return values | {
        key: {**values.get(key, {}), **value} if isinstance(value, dict) else value
        for key, value in changes.items()
    }


def small_cases(**changes):
    """Cases of `SMALL` with some keys of its sections changed."""
    return cases_of(Coupon.model_validate(with_changes(SMALL, changes)))
