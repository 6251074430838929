"""Panels and beds of `atlas_sound`, drawn at random."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml
from atlas_design import LEAST_SPHERES, SLENDEREST, full_cell

from pidpanel import Model, StudyError
from pidpanel.geometry.cells import bulk_fraction
from pidpanel.paths import DATA, WORKFLOW

SEED = 482
OTHERS, PER_PANEL = 8, 3  # other panels, and scenarios on each
ON_PAPERS = {"paper_baffle": ("baffle", 12), "paper_free": ("free", 12)}  # its scenarios
FILLS, LEVELS = (0.2, 0.95), (122.0, 152.0)
RESTITUTION, FRICTION = (0.5, 0.9), (0.1, 0.5)
DIAMETERS_MM = (1.0, 1.5, 2.0, 2.5, 3.0)
WIDTH, DEPTH = (2.3, 4.5), (4.5, 14.0)  # of a cell over the diameter
DEEPEST_MM = 30.0
MOST_SPHERES = 1200  # of 16 cells
HEAVIEST = 5.0  # mass of the particles over that of the panel below them
# density [kg/m³], Young's modulus [MPa], Poisson's ratio
MATERIALS = {
    "acrylic": (1190, 3200, 0.35), "glass": (2500, 65000, 0.22), "steel": (7850, 200000, 0.3),
}  # fmt: skip
CELLS = 16  # of a coupled run
FULL = 0.6  # fill from which contacts of beds that may cross are stiffer
GRADES = ("1/4-5056-0.001", "3/16-5056-0.0007", "3/8-5056-0.0015")
FACES = ("Al 2024-T3", "T300/5208 carbon")
EDGE = 0.05  # least distance of patches from each other and from the edges [m]


def spread(rng: np.random.Generator, count: int, ends: tuple[float, float]) -> np.ndarray:
    """Return values (count,) one in each equal part of a range, in random order."""
    return (
        ends[0] + (ends[1] - ends[0]) * (rng.permutation(count) + rng.uniform(size=count)) / count
    )


def drawn_patches(rng: np.random.Generator, outline: list[float], count: int) -> list[Any]:
    """Return centres and sizes of patches that do not touch, on a grid of 1 cm [m]."""
    patches: list[Any] = []
    while len(patches) < count:
        size = rng.integers(6, 14, 2) * 0.02
        low, high = EDGE + size / 2, np.array(outline) - EDGE - size / 2
        centre = rng.uniform(low, high).round(2)
        apart = [np.max(np.abs(centre - c) - (size + s) / 2) >= EDGE for c, s in patches]
        if all(apart):
            patches.append((centre, size))
    return [{"centre_m": c.round(3).tolist(), "size_m": s.round(3).tolist()} for c, s in patches]


def drawn_bed(rng: np.random.Generator, fill: float, panel_mass: float) -> dict[str, Any]:
    """Return a damper in the ranges of the atlas, not too heavy and not of too many spheres."""
    while True:
        diameter = float(rng.choice(DIAMETERS_MM))
        width, depth = rng.uniform(*WIDTH), rng.uniform(*DEPTH)
        material = str(rng.choice(list(MATERIALS)))
        e, friction = rng.uniform(*RESTITUTION), rng.uniform(*FRICTION)
        is_upright = bool(rng.uniform() < 0.4)
        spheres = fill * full_cell(width, depth)
        density, modulus, ratio = MATERIALS[material]
        mass = 1e-3 * fill * bulk_fraction(1.0, width) * depth * diameter * density
        if depth * diameter > DEEPEST_MM or CELLS * spheres > MOST_SPHERES:
            continue
        if depth * width / (width - 1) ** 2 > SLENDEREST or spheres < LEAST_SPHERES:
            continue
        if mass <= HEAVIEST * panel_mass:
            break
    return {
        "cell": {
            "shape": "hexagon", "across_flats_mm": round(width * diameter, 2),
            "depth_mm": round(depth * diameter, 1), "count": 3,
        },
        "particles": {
            "diameter_mm": diameter, "density_kg_m3": density, "youngs_modulus_mpa": modulus,
            "poissons_ratio": ratio, "restitution": round(e, 2), "friction": round(friction, 2),
        },
        "gravity_direction": [1, 0, 0] if is_upright else [0, 0, -1],
        "model": "atlas",
    }  # fmt: skip


def papers_panel() -> tuple[dict[str, Any], float]:
    """Return the paper's panel without patches, and its mass per area [kg/m²]."""
    study = yaml.safe_load((WORKFLOW / "studies" / "layouts.yaml").read_text(encoding="utf-8"))
    return study["panel"], study["panel"]["section"]["mass_per_area_kg_m2"]


def other_panel(rng: np.random.Generator) -> tuple[dict[str, Any], float]:
    """Return a panel, thin or a sandwich, and about its mass per area [kg/m²]."""
    outline = [round(rng.uniform(0.8, 1.6), 2), round(rng.uniform(0.6, 1.1), 2)]
    supports = str(rng.choice(["simply_supported", "clamped"]))
    panel = {"outline_m": outline, "supports": supports,
             "damping_ratio": round(rng.uniform(0.007, 0.02), 4)}  # fmt: skip
    if rng.uniform() < 0.25:
        mass = round(rng.uniform(2.5, 6), 2)
        stiffness = round(float(np.exp(rng.uniform(*np.log([1e3, 8e3])))))
        panel["section"] = {"kind": "thin", "thickness_mm": 25, "mass_per_area_kg_m2": mass,
                            "bending_stiffness_n_m": stiffness}  # fmt: skip
        panel["mesh"] = {"kind": "quadrilaterals", "elements": [24, 18]}
        return panel, mass
    face, core = round(rng.uniform(0.2, 0.5), 2), round(rng.uniform(10, 30), 1)
    extra = round(rng.uniform(0.5, 1.5), 2)
    material, grade = str(rng.choice(FACES)), str(rng.choice(GRADES))
    if "carbon" in material:
        plies = [{"material": material, "thickness_mm": round(face / 4, 4), "angle_deg": angle}
                 for angle in (0, 45, -45, 90)]  # fmt: skip
    else:
        plies = [{"material": material, "thickness_mm": face}]
    panel["section"] = {"kind": "sandwich", "faces": plies,
                        "core": {"grade": grade, "thickness_mm": core},
                        "extra_mass_per_area_kg_m2": extra}  # fmt: skip
    panel["mesh"] = {"kind": "triangles", "size_m": 0.1}
    return panel, 2 * 2.2 * face + 0.035 * core + extra


def meshed(study: dict[str, Any]) -> dict[str, Any]:
    """Return a study with a mesh that resolves the waves up to its highest frequency."""
    mesh = study["panel"]["mesh"]
    while True:
        try:
            Model(study)
        except StudyError as error:
            if "panel.mesh" not in str(error):
                raise
            if "size_m" in mesh:
                mesh["size_m"] = round(0.85 * mesh["size_m"], 4)
            else:
                mesh["elements"] = [round(1.2 * count) for count in mesh["elements"]]
        else:
            return study


def row_of(
    label: str, panel: str, where: str, patch: str, fill: float, level: float, bed: dict[str, Any]
) -> dict[str, Any]:
    """Return what describes a scenario in the table."""
    particles, cell = bed["particles"], bed["cell"]
    material = next(k for k, v in MATERIALS.items() if v[0] == particles["density_kg_m3"])
    return {
        "scenario": label, "panel": panel, "surroundings": where, "patch": patch,
        "fill_fraction": fill, "oaspl_db": level, "material": material,
        **{key: particles[key] for key in ("diameter_mm", "restitution", "friction")},
        **{key: cell[key] for key in ("across_flats_mm", "depth_mm")},
        "gravity": "along" if bed["gravity_direction"][2] else "across",
    }  # fmt: skip


def drawn_panels() -> dict[str, tuple[dict[str, Any], list[dict[str, Any]]]]:
    """Return the study of each panel, and what describes each of its scenarios."""
    rng = np.random.default_rng(SEED)
    spectra = sorted(path.name for path in (DATA / "spl").glob("*third.csv"))
    plan = [(name, where, count) for name, (where, count) in ON_PAPERS.items()]
    plan += [(f"other_{k + 1}", ("free", "baffle")[k % 2], PER_PANEL) for k in range(OTHERS)]
    total = sum(count for *_, count in plan)
    fills, levels = spread(rng, total, FILLS).round(2), spread(rng, total, LEVELS).round(1)
    studies, number = {}, 0
    for name, where, count in plan:
        panel, mass = papers_panel() if name in ON_PAPERS else other_panel(rng)
        spectrum = "smc_s_016_2014_min_third.csv" if name in ON_PAPERS else str(rng.choice(spectra))
        at_once = min(count, 4)
        patches = drawn_patches(rng, panel["outline_m"], at_once)
        panel["patches"] = {f"P{k + 1}": patch for k, patch in enumerate(patches)}
        panel["points"] = {
            f"at_{key}": patch["centre_m"] for key, patch in panel["patches"].items()
        }
        study: dict[str, Any] = {
            "title": name, "assumptions": ["Drawn at random."], "dampers": {}, "panel": panel,
            "sound": {"spectrum": spectrum, "surroundings": where},
            "response": {"frequency_hz": [30, 2000]}, "scenarios": {},
        }  # fmt: skip
        beds = []
        for index in range(count):
            number += 1
            fill, level, label = float(fills[number - 1]), float(levels[number - 1]), f"n{number}"
            bed, patch = drawn_bed(rng, fill, mass), f"P{index % at_once + 1}"
            study["dampers"][label] = bed
            study["scenarios"][label] = {
                "layout": {patch: {"damper": label, "fill_fraction": fill}}, "oaspl_db": level,
            }  # fmt: skip
            beds.append(row_of(label, name, where, patch, fill, level, bed))
        studies[name] = (meshed(study), beds)
    return studies
