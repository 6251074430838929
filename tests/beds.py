"""Beds of spheres in hexagonal cells."""

from pidpanel.coupon.from_study import bed_of
from pidpanel.study.coupon import Coupon


def hexagons(youngs_modulus_mpa=3300, diameter_mm=2.5, seed=1, **particles):
    """Eight cells of 6.35 mm across flats and 8 mm deep, half full of acrylic."""
    coupon = {
        "cell": {"shape": "hexagon", "across_flats_mm": 6.35, "depth_mm": 8, "count": 2},
        "particles": {
            "diameter_mm": diameter_mm, "youngs_modulus_mpa": youngs_modulus_mpa,
            "density_kg_m3": 1190, **particles,
        },
        "sweep": {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [10]},
    }  # fmt: skip
    return bed_of(Coupon.model_validate(coupon), 0.5, cells=8, seed=seed)
