"""Two layouts of the same mass of dampers: one heavy patch, or two light ones."""

import pidpanel

layouts = {
    "one": {"middle": {"damper": "heavy"}},
    "two": {"left": {"damper": "light"}, "right": {"damper": "light"}},
}
size = {"size_m": [0.1, 0.1]}
model = pidpanel.Model(
    {
        "dampers": {
            "heavy": {"equivalent_damping_n_s_m3": 2000, "apparent_mass_kg_m2": 4},
            "light": {"equivalent_damping_n_s_m3": 1000, "apparent_mass_kg_m2": 2},
        },
        "panel": {
            "outline_m": [0.8, 0.5],
            "section": {"kind": "thin", "mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 800},
            "damping_ratio": 0.01,
            "mesh": {"kind": "quadrilaterals", "elements": [16, 10]},
            "patches": {
                "left": {"centre_m": [0.2, 0.25], **size},
                "middle": {"centre_m": [0.4, 0.25], **size},
                "right": {"centre_m": [0.6, 0.25], **size},
            },
            "points": {"P": [0.4, 0.25], "Q": [0.2, 0.25]},
        },
        "sound": {
            "spectrum": "smc_s_016_2014_min_third.csv",
            "oaspl_db": 145,
            "surroundings": "free",
        },
        "response": {"frequency_hz": [40, 400]},
        "scenarios": {name: {"layout": layout} for name, layout in layouts.items()},
    }
)
response = model.response()
table = response["reduction"].sel(scenario=list(layouts)).to_pandas()
print(f"reduction, dB:\n{table.round(1)}")
best = response["acceleration_rms"].sel(scenario=list(layouts)).max("point").idxmin("scenario")
print(f"the lower rms at the worst point has: {best.item()}")
