"""One paraboloid by another solver and as a shell of pidpanel: g rms with dampers by the atlas."""

from pathlib import Path

import numpy as np
import pytest

from pidpanel import Model
from pidpanel.structure import from_study
from tests.verification.test_shell import FACE, Core, FilledSandwich

pytestmark = [pytest.mark.verification, pytest.mark.slow, pytest.mark.long]
FOLDER = Path(__file__).parents[2] / "workflow" / "data" / "modes"
HUB, RING, ROUND = 0.12, 0.096, 22  # radius, and width and number of the elements of the file
POINTS = {
    "edge": {"at_m": [0.6, 0.0, 0.1875]},
    "side": {"at_m": [0.0, 0.6, 0.1875]},
    "inside": {"at_m": [0.2838, 0.1297, 0.0507]},
}
FACE_INPUT = {"a": {"youngs_modulus_gpa": 50, "poissons_ratio": 0.3, "density_kg_m3": 1600}}
CORE = {
    "thickness_mm": 12, "shear_modulus_l_mpa": 120, "shear_modulus_w_mpa": 120, "density_kg_m3": 50,
}  # fmt: skip
ACRYLIC = {"diameter_mm": 2, "density_kg_m3": 1190, "restitution": 0.8, "friction": 0.3}


def sector(rings, sectors):
    """The patch of elements as a polygon along z; their edges are cut at mid-side nodes."""
    angle = np.pi * np.arange(2 * sectors[0], 2 * sectors[1] + 1) / ROUND
    inner, outer = (HUB + RING * ring for ring in rings)
    turns = [(outer, t) for t in angle] + [(inner, t) for t in angle[::-1]]
    corners = [[float(r * np.cos(t)), float(r * np.sin(t)), 0.0] for r, t in turns]
    return {"corners_m": corners, "along": [0, 0, 1]}


OWN = {
    "shell": {
        "form": {
            "kind": "paraboloid", "diameter_m": 1.2, "focal_length_m": 0.48, "hub_diameter_m": 0.24,
        },
        "section": {
            "kind": "sandwich", "faces": [{"material": "a", "thickness_mm": 0.3}],
            "materials": FACE_INPUT, "core": CORE,
        },
        "size_m": 0.12,
        "supports": {"hub": {"where": {"centre_m": [0, 0, 0], "radii_m": [0, HUB], "along": [0, 0, 1]}}},
    },
    "patches": {"inner": sector((1, 3), (0, 3)), "outer": sector((3, 5), (11, 14))},
    "points": POINTS,
}  # fmt: skip
FOREIGN = {
    "modes": {
        "file": str(FOLDER / "paraboloid.frd"), "mesh": str(FOLDER / "paraboloid.inp"), "unit_m": 1,
        "pressures": [f"{name}_{part}" for name in ("INNER", "OUTER") for part in range(1, 7)],
    },
    "mass_kg": 1.856, "outward": [0, 0, 1],
    "patches": {"inner": {"group": "INNER"}, "outer": {"group": "OUTER"}}, "points": POINTS,
}  # fmt: skip


def test_a_paraboloid_answers_with_the_modes_of_another_solver_as_with_its_own(record, monkeypatch):
    section = FilledSandwich((FACE,), (FACE,), Core(120e6, 120e6, 50.0, 12e-3))
    monkeypatch.setattr(from_study, "section_of", lambda _: section)  # the solids' core stretches
    cell = {"across_flats_mm": 6.35, "depth_mm": 12}
    common = {
        "dampers": {"acrylic": {"particles": ACRYLIC, "cell": cell, "model": "atlas"}},
        "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "surroundings": "baffle"},
        "response": {"frequency_hz": [30, 400], "radiation": "none"},
        "scenarios": {
            f"{patch}{fill}": {"patch": patch, "damper": "acrylic", "fill_fraction": fill}
            for patch, fill in (("inner", 0.5), ("outer", 0.7), ("outer", 0.9))
        },
    }
    found, expected = (
        Model({"structure": structure, **common}).summary().set_index(["scenario", "point"])
        for structure in (FOREIGN, OWN)
    )
    for scenario, point in found.index[found["patch"] != "none"]:
        place = scenario, point
        record(
            f"acceleration rms, {point}", found["acceleration_rms_g"][place],
            expected["acceleration_rms_g"][place], unit="g",
            tolerance=0.01,
            case=f"Sandwich paraboloid of 1.2 m, acrylic spheres, {scenario}",
            method="20 modes and 12 static cases of CalculiX 2.20, 5 × 22 elements of C3D20R",
            source="shell of order 4 of the same reflector, meshed by pidpanel",
        )  # fmt: skip
