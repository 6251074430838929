"""Shells that are meshed here: a flat one is a panel, a reflector is that of another solver."""

import numpy as np
import pandas as pd
import pytest

from pidpanel import Model
from pidpanel.panel.files import read_basis
from pidpanel.shell.assembly import assemble_shell
from pidpanel.structure.from_study import read_moved_panel, structure_of
from pidpanel.study import StudyError
from tests.structures import COMMON, CURVED, PANEL

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


def two_parts(**changed):
    """The flat shell in two halves, along x."""
    halves = {
        "left": [[0, 0, 1], [0.75, 0, 1], [0.75, 1, 1], [0, 1, 1]],
        "right": [[0.75, 0, 1], [1.5, 0, 1], [1.5, 1, 1], [0.75, 1, 1]],
    }
    return flat_shell(form={"kind": "panels", "corners_m": halves}, **changed)


def panel_of(structure):
    study = {"name": "shell", "structure": structure, **COMMON}
    study["sound"] = {**COMMON["sound"], "surroundings": "free"}
    return structure_of(Model(study).study.panel)


def test_parts_with_one_section_are_the_whole_and_with_two_they_are_symmetric():
    heavy = {**SANDWICH, "faces": [{"material": "skin", "thickness_mm": 0.5}]}
    whole = panel_of(flat_shell()).first_frequency
    same = panel_of(two_parts(parts={"right": {"section": SANDWICH}}))
    np.testing.assert_allclose(same.first_frequency, whole, rtol=5e-4)
    left, right = (
        panel_of(two_parts(parts={side: {"section": heavy}})) for side in ("left", "right")
    )
    np.testing.assert_allclose(left.first_frequency, right.first_frequency, rtol=5e-4)
    assert abs(left.first_frequency[0] / whole[0] - 1) > 0.02
    # the mean of 2 (ρ t) of the faces
    difference = left.section.mass_per_area - same.section.mass_per_area
    np.testing.assert_allclose(difference, 2700 * 2 * 0.2e-3 / 2, rtol=1e-9)


def test_the_axis_of_a_part_is_the_turn_of_its_section():
    core = {"thickness_mm": 20, "shear_modulus_l_mpa": 200, "shear_modulus_w_mpa": 40,
            "density_kg_m3": 30}  # fmt: skip
    along = {**SANDWICH, "core": {**core, "ribbon_deg": 90}}
    by_angle = panel_of(two_parts(parts={"left": {"section": along}}))
    by_axis = panel_of(
        two_parts(parts={"left": {"section": {**SANDWICH, "core": core}, "axis": [0, 1, 0]}})
    )
    np.testing.assert_allclose(by_axis.first_frequency, by_angle.first_frequency, rtol=1e-9)


def test_an_unknown_part_is_refused():
    with pytest.raises(StudyError, match=r"parts\.middle.*must be one of left, right"):
        panel_of(two_parts(parts={"middle": {"section": SANDWICH}}))


def test_the_page_of_several_sections_states_no_stiffness():
    plate = {"kind": "solid", "youngs_modulus_gpa": 70, "density_kg_m3": 2700, "thickness_mm": 12}
    study = Model({
        "name": "shell", "structure": two_parts(parts={"left": {"section": plate}}), **COMMON
    }).study  # fmt: skip
    assert study.panel.section.kind == "unknown" and study.panel.section.thickness_mm == 12


def test_strengths_of_several_sections_are_refused():
    study = {
        "name": "shell", "structure": two_parts(parts={"left": {"section": SANDWICH}}), **COMMON,
        "severity": {"duration_s": 60, "strength": {"core": {"shear_xz_mpa": 1, "shear_yz_mpa": 1}}},
    }  # fmt: skip
    with pytest.raises(StudyError, match=r"severity\.strength.*stresses are not computed"):
        Model(study)


def test_base_motion_of_a_shell_without_patches_has_the_mesh_error_of_its_modes():
    end = {"end": {"where": {"from_m": [-1, -2, -2], "to_m": [0, 2, 2]}}}
    structure = {**CURVED, "patches": {}, "shell": {**CURVED["shell"], "supports": end}}
    values = {
        "name": "arch", "structure": structure, "response": {"frequency_hz": [20, 150]},
        "base": {"random": {"spectrum": "gevs_acceptance.csv"}},
    }  # fmt: skip
    model = Model(values)
    summary = pd.read_csv(model._stages.files("base").summary)
    basis = read_basis(model._stages.files("panel").modes)
    # a shift e of a resonance changes its PSD by e/ζ at most
    bound = np.max(basis.frequency_shift) / 0.01
    assert (summary["mesh_error"] > 0).all()
    assert (summary["mesh_error"] < 5 * bound).all()
    # maps move along the normals of the cylinder, not of its facets
    *_, translation = read_moved_panel(model.study, model._stages.files("panel"))
    up = basis.vertex_position[:, 2]  # of a radius of 1 m
    np.testing.assert_allclose(translation.vertices, up, atol=1e-5)


def test_the_base_moves_points_along_the_normals_of_the_curved_surface():
    turns = np.array([0.0, 0.3, -0.37])
    normals = np.stack([0 * turns, np.sin(turns), np.cos(turns)], axis=1)
    points = {f"p{k}": {"at_m": [0.4, *n[1:].tolist()]} for k, n in enumerate(normals)}
    structure = panel_of({**CURVED, "points": points})
    shell = assemble_shell(structure.shell, structure.layups, structure.attached, order=2)
    # slopes of order 4 on an arc of h = 0.1 R are off by some (h/R)⁴/30
    found = structure._with_directions(shell).point_direction
    np.testing.assert_allclose(found, normals, atol=1e-5)
