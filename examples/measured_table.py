"""Damping measured in a laboratory: a CSV table, with errors, on a panel."""

import tempfile
from pathlib import Path

import pidpanel

folder = Path(tempfile.mkdtemp())
rows = [
    f"{fill},{frequency},{gamma},{900 * fill * (frequency / 100) * (20 / gamma) ** 0.5:.1f},"
    f"{60 * fill * (frequency / 100):.1f},{2.5 * fill / gamma**0.2:.3f}"
    for fill in (0.3, 0.5, 0.8)
    for frequency in (40, 100, 400)
    for gamma in (1, 10, 100)
]
head = (
    "fill_fraction,frequency_hz,acceleration_g,equivalent_damping_n_s_m3,"
    "equivalent_damping_error_n_s_m3,apparent_mass_kg_m2"
)
(folder / "lab.csv").write_text("\n".join([head, *rows]) + "\n")

model = pidpanel.Model(
    {
        "dampers": {"lab": {"table": "lab.csv"}},
        "panel": {
            "outline_m": [0.8, 0.5],
            "section": {"kind": "thin", "mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 800},
            "damping_ratio": 0.01,
            "mesh": {"kind": "quadrilaterals", "elements": [16, 10]},
            "patches": {"middle": {"centre_m": [0.4, 0.25], "size_m": [0.2, 0.2]}},
            "points": {"P": [0.4, 0.25]},
        },
        "sound": {
            "spectrum": "smc_s_016_2014_min_third.csv",
            "oaspl_db": 145,
            "surroundings": "free",
        },
        "response": {"frequency_hz": [40, 400]},
        "scenarios": {"fill": {"patch": "middle", "damper": "lab", "fill_fraction": [0.3, 0.8]}},
    },
    folder,
)
table = model.damping("lab", fill_fraction=0.5, frequency_hz=[50, 100, 200], acceleration_g=10)
print(table["equivalent_damping"].squeeze().to_pandas().rename("C_e, N s/m³ over frequency, Hz"))
found = model.response().sel(point="P")
for scenario in found["scenario"].to_numpy()[1:]:  # the first is the bare panel
    one = found.sel(scenario=scenario)
    print(f"{scenario}: {float(one['reduction']):.2f} ± {float(one['reduction_error']):.2f} dB")
