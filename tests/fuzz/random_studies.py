"""Studies drawn at random, of all that a panel may be, and what carries one out to its results."""

import math
import random
from pathlib import Path

import yaml

from pidpanel.panel.files import read_basis
from pidpanel.report.from_study import write_study_page
from pidpanel.response.from_study import write_export, write_maps, write_response
from pidpanel.sound.from_study import write_sound
from pidpanel.structure.from_study import write_panel
from tests.jobs import PANEL, RESPONSE, SOUND, files, within

TABLE = """\
fill_fraction,frequency_hz,acceleration_g,equivalent_damping_n_s_m3,apparent_mass_kg_m2
0.3,50,1,820,5.1
0.3,500,1,1450,4.6
0.3,50,100,510,2.2
0.3,500,100,1100,1.9
0.9,50,1,1820,9.1
0.9,500,1,2450,8.6
0.9,50,100,1510,4.2
0.9,500,100,2100,3.9
"""
IMPEDANCE = """\
frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2
50,820,5.1
500,1450,4.6
"""


def drawn(seed: int) -> dict:
    """The values of a study; the same for the same number."""
    rng = random.Random(seed)
    length, width = round(rng.uniform(0.2, 2), 3), round(rng.uniform(0.2, 1.2), 3)
    rectangle = rng.random() < 0.4
    panel = {
        "outline_m": [length, width],
        "section": _section(rng),
        "damping_ratio": rng.choice([0.005, 0.01, 0.03, 0.1]),
    }
    if rectangle and panel["section"]["kind"] == "thin":
        columns, rows = rng.randint(4, 14), rng.randint(4, 10)
        panel["mesh"] = {"kind": "quadrilaterals", "elements": [columns, rows]}
        size = [length / columns * 2, width / rows * 2]
        centres = {"a": [length / columns * 2, width / rows * 2]}
        if columns >= 8:
            centres["b"] = [length / columns * 6, width / rows * 2]
        panel["patches"] = {k: {"centre_m": c, "size_m": size} for k, c in centres.items()}
        panel["supports"] = rng.choice(["simply_supported", "clamped", "simply_supported_soft"])
    else:
        panel["mesh"] = {"kind": "triangles", "size_m": round(min(length, width) / 8, 4)}
        _free_form(rng, panel, length, width)

    def place():
        if panel["mesh"]["kind"] == "triangles":
            return _place(rng, length, width)
        columns, rows = panel["mesh"]["elements"]
        return [
            length / columns * rng.randrange(1, columns),
            width / rows * rng.randrange(1, rows),
        ]

    panel["points"] = {"p": place(), "q": place()}
    if rng.random() < 0.4:
        panel["masses"] = {"box": {"at_m": place(), "mass_kg": rng.choice([0.01, 0.3, 2.0])}}
    low = rng.choice([30, 40, 90])
    return {
        "name": f"drawn{seed}",
        "panel": panel,
        "sound": _sound(rng),
        "response": {
            "frequency_hz": [low, low * rng.choice([2, 3, 5])],
            "radiation": rng.choice(["none"] * 8 + ["one_side", "two_sides"]),
            "air_mass": rng.random() < 0.7,
        },
        **_fillings(rng, list(panel["patches"])),
    }


def _place(rng, length, width):
    return [round(rng.uniform(0.02, 0.98) * length, 3), round(rng.uniform(0.02, 0.98) * width, 3)]


def _section(rng):
    kind = rng.choice(["thin", "solid", "sandwich", "sandwich"])
    if kind == "thin":
        thickness = rng.choice([2, 10, 25])
        return {
            "kind": "thin", "thickness_mm": thickness,
            "mass_per_area_kg_m2": rng.choice([1.5, 4, 12]),
            "bending_stiffness_n_m": rng.choice([0.5, 5, 20]) * thickness**2 / 10,
        }  # fmt: skip
    metal = {"youngs_modulus_gpa": 70, "poissons_ratio": 0.33, "density_kg_m3": 2700}
    if kind == "solid":
        return {"kind": "solid", "thickness_mm": rng.choice([0.8, 3, 12]), **metal}
    tape = {"e1_gpa": 280, "e2_gpa": 6.5, "g12_gpa": 4.5, "nu12": 0.3, "density_kg_m3": 1600}
    plies = [
        {"material": rng.choice(["tape", "metal"]), "thickness_mm": rng.choice([0.1, 0.3]),
         "angle_deg": rng.choice([0, 45, 90, -60])}
        for _ in range(rng.randint(1, 3))
    ]  # fmt: skip
    core = {"grade": rng.choice(["3/16-5056-0.0007", "1/4-5056-0.001"])}
    if rng.random() < 0.4:
        core = {"shear_modulus_l_mpa": 186, "shear_modulus_w_mpa": 90, "density_kg_m3": 32}
    return {
        "kind": "sandwich", "materials": {"tape": tape, "metal": metal}, "faces": plies,
        "core": {**core, "thickness_mm": rng.choice([6, 15, 40]), "ribbon_deg": rng.choice([0, 30])},
        "extra_mass_per_area_kg_m2": rng.choice([0, 1.5]),
    }  # fmt: skip


def _free_form(rng, panel, length, width):
    """An outline of corners, holes, patches of all shapes, supports of all kinds."""
    if rng.random() < 0.5:
        cut = rng.uniform(0.5, 0.9)
        panel["outline_m"] = [
            [0, 0], [length, 0], [length, round(cut * width, 3)], [round(cut * length, 3), width],
            [0, width],
        ]  # fmt: skip
    if rng.random() < 0.3:
        panel["corner_radius_m"] = round(0.05 * min(length, width), 4)
        if len(panel["outline_m"]) == 2:
            panel["outline_m"] = [[0, 0], [length, 0], [length, width], [0, width]]
    if rng.random() < 0.4:
        panel["holes"] = {
            "h": {
                "centre_m": [round(0.55 * length, 3), round(0.7 * width, 3)],
                "diameter_m": round(0.2 * min(length, width), 3),
            }
        }
    side = round(0.18 * min(length, width), 3)
    shapes = {
        "round": {"centre_m": [round(0.25 * length, 3), round(0.3 * width, 3)], "diameter_m": side},
        "slanted": {
            "corners_m": [
                [round(x * length, 3), round(y * width, 3)]
                for x, y in ((0.6, 0.2), (0.85, 0.25), (0.8, 0.45))
            ]
        },
    }
    kept = rng.sample(sorted(shapes), rng.randint(1, 2))
    panel["patches"] = {name: shapes[name] for name in kept}
    kind = rng.choice(["outline", "free", "feet"])
    if kind == "outline":
        panel["supports"] = rng.choice(["simply_supported", "clamped"])
        return
    panel["supports"] = {"outline": "free"}
    if kind == "feet":
        panel["supports"]["points"] = {
            f"foot {number}": _foot(rng, [round(x * length, 3), round(y * width, 3)], length, width)
            for number, (x, y) in enumerate([(0.1, 0.1), (0.9, 0.1), (0.12, 0.85)])
        }


def _foot(rng, at, length, width):
    kind = rng.choice(["hinge", "hold_down", "spring"])
    if kind == "spring":
        return {"at_m": at, "kind": kind, "stiffness_n_m": rng.choice([1e3, 1e6])}
    radius = rng.choice([0, round(0.03 * min(length, width), 4)])
    return {"at_m": at, "kind": kind, **({"radius_m": radius} if radius else {})}


def _sound(rng):
    field = rng.choice(
        ["diffuse", "diffuse", "uncorrelated", "uniform", "plane_wave", "progressive_wave"]
    )
    found = {"spectrum": "smc_s_016_2014_min_third.csv", "field": field}
    if field == "plane_wave":
        found["incidence_deg"] = rng.choice([0, 37, 90])
    if field in ("plane_wave", "progressive_wave"):
        found["azimuth_deg"] = rng.choice([-90, 0, 25])
    if rng.random() < 0.7:
        found["oaspl_db"] = rng.choice([120, 142, 165])
    found["pressure_reference"] = rng.choice(["surface", "room", "incident"])
    found["loaded_sides"] = rng.choice([1, 2])
    return found


def _fillings(rng, patches):
    """Dampers of all kinds without LIGGGHTS, and scenarios of them; sometimes none."""
    if rng.random() < 0.1:
        return {}
    dampers = {
        "lab": {"table": "lab.csv"},
        "tuned": {"impedance": "tuned.csv"},
        "dashpot": {"equivalent_damping_n_s_m3": rng.choice([50, 2000, 50000])},
        "weight": {"equivalent_damping_n_s_m3": 0, "apparent_mass_kg_m2": rng.choice([1, 20])},
        "layer": {"loss_factor": 0.2, "patch_mass_per_area_kg_m2": 5},
        "law": {"law": "paper_corrected"},
    }
    names = rng.sample(sorted(dampers), rng.randint(1, 3))
    filled = [name for name in names if name in ("lab", "law")]

    def one(name):
        fill = {"fill_fraction": rng.choice([0.3, 0.5, 0.9])} if name in filled else {}
        return {"damper": name, **fill}

    scenarios = {"layout": {"layout": {patch: one(rng.choice(names)) for patch in patches}}}
    if filled:
        scenarios["fill"] = {"patch": patches[0], "damper": filled[0], "fill_fraction": [0.4, 0.8]}
    if rng.random() < 0.3:
        scenarios["place"] = {"patch": patches, **one(names[0])}
    return {"dampers": {name: dampers[name] for name in names}, "scenarios": scenarios}


def written(folder: Path, values: dict) -> Path:
    """The file of a study, its tables beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "lab.csv").write_text(TABLE)
    (folder / "tuned.csv").write_text(IMPEDANCE)
    path = folder / "drawn.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False))
    return path


def carried_out(study, file: Path, folder: Path, *, page: bool) -> Path:
    """Do what the workflow does, and return the table of the responses."""
    for stage in ("panel", "sound", "response"):
        (folder / stage).mkdir(parents=True, exist_ok=True)
    panel = files(within(folder / "panel", PANEL))
    write_panel(study, panel)
    radiates = study.radiation != "none"
    sound = within(folder / "sound", SOUND | ({"air": "air.nc"} if radiates else {}))
    write_sound(study, read_basis(panel.modes), files(sound))
    upstream = within(folder / "panel", PANEL) | sound
    response = within(folder / "response", RESPONSE)
    write_response(study, files(upstream), files(response), None, None)
    maps = within(folder / "response", {"maps": "maps.nc", "folder": "maps"})
    write_maps(study, files(upstream | response), files(maps))
    if page:
        export = folder / "response" / "export"
        write_export(study, panel[0], response["psd"], response["summary"], export)
        write_study_page(study, file, folder, folder / "report.html", folder / "report")
    return response["summary"]


def is_finite(text: str) -> bool:
    """Whether a cell is a finite number."""
    return math.isfinite(float(text or "nan"))
