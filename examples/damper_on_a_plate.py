"""A damper on a plate: how much quieter it gets, in ten lines."""

import pidpanel

plate = pidpanel.Model({
    "panel": {"outline_m": [0.8, 0.5], "supports": "simply_supported", "damping_ratio": 0.01,
              "section": {"kind": "thin", "mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 800},
              "mesh": {"kind": "triangles", "size_m": 0.1},
              "patches": {"middle": {"centre_m": [0.4, 0.25], "diameter_m": 0.15}},
              "points": {"P": [0.4, 0.25]}},
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "surroundings": "free"},
    "response": {"frequency_hz": [40, 400]},
    "dampers": {"pot": {"equivalent_damping_n_s_m3": 1000, "apparent_mass_kg_m2": 2}},
    "scenarios": {"damped": {"layout": {"middle": {"damper": "pot"}}}},
})  # fmt: skip
rms = plate.response()["acceleration_rms"].sel(point="P")
print(rms.to_series().rename(f"rms acceleration, {rms.units}"))
