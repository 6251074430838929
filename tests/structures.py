"""A flat panel, its modes as a file of another solver, turned in space, and a curved shell."""

import numpy as np
import pyvista

SOUND = {"spectrum": "smc_s_016_2014_min_third.csv", "oaspl_db": 140}
COMMON = {
    "sound": SOUND,
    "response": {"frequency_hz": [30, 400]},
    "dampers": {"dashpot": {"equivalent_damping_n_s_m3": 2000, "apparent_mass_kg_m2": 3}},
    "scenarios": {"one": {"patch": "P"}},
}
PANEL = {
    "outline_m": [1.5, 1.0],
    "section": {"kind": "thin", "mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 5000},
    "mesh": {"kind": "quadrilaterals", "elements": [30, 20]},
    "patches": {"P": {"centre_m": [0.5, 0.5], "size_m": [0.2, 0.2]}},
    "points": {"mid": [0.75, 0.5], "off": [0.5, 0.4]},
}
CURVED = {
    "shell": {
        "form": {"kind": "cylinder_panel", "radius_m": 1, "length_m": 0.8, "arc_m": 0.8},
        "section": {
            "kind": "solid", "thickness_mm": 3, "youngs_modulus_gpa": 70, "poissons_ratio": 0.3,
            "density_kg_m3": 2700,
        },
        "size_m": 0.1,
    },
    "patches": {"P": {"centre_m": [0.4, 0, 1], "radius_m": 0.15}},
    "points": {"mid": {"at_m": [0.4, 0, 1]}},
}  # fmt: skip
ORIGIN, AXES = np.array([0.3, 1.0, -2.0]), np.array([[0, 0.6, 0.8], [0, -0.8, 0.6]])
NORMAL = np.cross(*AXES)


def in_space(place):
    """Where the panel has a place (..., 2)."""
    return ORIGIN + np.asarray(place) @ AXES


def grid_of(model, reach):
    """The modes of a panel below a frequency as a VTU grid, along its normal in space."""
    modes = model.modes()
    modes = modes.isel(mode=np.flatnonzero(modes["natural_frequency"].to_numpy() < reach))
    cells = modes["cells"].to_numpy().astype(int)
    points = in_space(modes["vertex_position"].to_numpy())
    grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: cells}, points)
    for number, shape in enumerate(modes["shape_at_vertices"].to_numpy().T, 1):
        grid.point_data[f"mode_{number}"] = shape[:, None] * NORMAL
    grid.field_data["frequencies"] = modes["natural_frequency"].to_numpy()
    grid.field_data["modal_masses"] = modes["modal_mass"].to_numpy()
    return grid
