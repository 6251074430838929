"""Shells that are meshed here: a flat one is a panel, a reflector is that of another solver."""

import numpy as np

from pidpanel import Model
from tests.structures import COMMON, PANEL

SANDWICH = {
    "kind": "sandwich",
    "materials": {"skin": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.3, "density_kg_m3": 2700}},
    "faces": [{"material": "skin", "thickness_mm": 0.3}],
    "core": {"thickness_mm": 20, "grade": "1/4-5056-0.0007"},
}
CORNERS = [[0, 0, 1], [1.5, 0, 1], [1.5, 1, 1], [0, 1, 1]]


def flat_shell(**changed):
    return {
        "shell": {
            "form": {"kind": "panels", "corners_m": {"plate": CORNERS}},
            "section": SANDWICH,
            "size_m": 0.25,
            **changed,
        },
        "patches": {"P": {"from_m": [0.4, 0.4, 0], "to_m": [0.6, 0.6, 2]}},
        "points": {"mid": {"at_m": [0.75, 0.5, 1]}, "off": {"at_m": [0.5, 0.4, 1]}},
    }


def rms(values):
    table = Model(values).summary().set_index(["scenario", "point"])
    return table["acceleration_rms_g"]


def test_a_free_flat_shell_answers_as_the_panel_free_in_a_room():
    common = {**COMMON, "sound": {**COMMON["sound"], "surroundings": "free"}}
    panel = {
        **PANEL, "section": SANDWICH, "supports": "free",
        "mesh": {"kind": "triangles", "size_m": 0.08},
    }  # fmt: skip
    shell = rms({"name": "shell", "structure": flat_shell(), **common})
    np.testing.assert_allclose(
        shell / rms({"name": "panel", "panel": panel, **common}), 1, atol=6e-3
    )


def test_base_motion_along_the_normal_is_that_of_a_panel_and_a_slanted_one_its_cosine():
    base = {"sine": {"frequency_hz": [30, 400], "acceleration_g": 1}}
    common = {k: v for k, v in COMMON.items() if k != "sound"}
    edges = {
        f"edge {k}": {
            "where": {"from_m": low, "to_m": high}, "kind": "clamped",
        }
        for k, (low, high) in enumerate(
            [([-1, -1, 0], [0, 2, 2]), ([1.5, -1, 0], [2, 2, 2]),
             ([-1, -1, 0], [2, 0, 2]), ([-1, 1, 0], [2, 2, 2])]
        )
    }  # fmt: skip
    panel = {
        **PANEL, "section": SANDWICH, "supports": "clamped",
        "mesh": {"kind": "triangles", "size_m": 0.07},
    }  # fmt: skip
    shell = flat_shell(supports=edges)

    def peaks(values):
        sine = Model(values).base("sine")
        return sine["acceleration"].max("frequency").to_numpy()

    straight = peaks({"name": "shell", "structure": shell, **common, "base": base})
    of_panel = peaks({"name": "panel", "panel": panel, **common, "base": base})
    np.testing.assert_allclose(straight, of_panel, rtol=0.02)
    slanted = {**base, "direction": [np.sqrt(3), 0, 1]}
    found = peaks({"name": "shell", "structure": shell, **common, "base": slanted})
    np.testing.assert_allclose(found / straight, 0.5, rtol=1e-6)
