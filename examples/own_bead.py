"""A bead of one's own, shaken by LIGGGHTS: steel spheres in two cells, a few seconds of it."""

import tempfile

import pidpanel

model = pidpanel.Model(
    {
        "name": "steel",
        "coupon": {
            "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 2},
            "particles": {
                "diameter_mm": 2.5,
                "density_kg_m3": 7850,
                "youngs_modulus_mpa": 50,  # softened: quick, and not to be used
                "poissons_ratio": 0.3,
                "restitution": 0.8,
                "friction": 0.2,
            },
            "sweep": {
                "fill_fraction": [0.4, 0.8],
                "frequency_hz": [100, 400],
                "acceleration_g": [10, 100],
            },
            # few cycles, of which not all are steady
            "accuracy": {"seeds": 1, "min_cycles": 10, "max_cycles": 15, "coverage": 0.5},
        },
    },
    tempfile.mkdtemp(),
)
cases = model.run("coupon/cases.csv").cases()
print(cases[["fill_fraction", "frequency_hz", "acceleration_g", "equivalent_damping_n_s_m3"]])
surface = model.damping(fill_fraction=[0.4, 0.8], frequency_hz=[100, 200], acceleration_g=[20])
print("C_e, N s/m³ over fill fraction and frequency, Hz:")
print(surface["equivalent_damping"].squeeze("acceleration").to_pandas())
