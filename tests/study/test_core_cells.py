"""Truths of cells: without sizes of their own they are those of the core, and others are named."""

import copy

import pytest

from pidpanel.study import Study

BED = {"particles": {"diameter_mm": 2}}
VALUES = {
    "name": "mine",
    "panel": {
        "outline_m": [1.2, 0.8],
        "section": {
            "kind": "sandwich",
            "materials": {"foil": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.3, "density_kg_m3": 2700}},
            "faces": [{"material": "foil", "thickness_mm": 0.3}],
            "core": {"grade": "3/16-5056-0.0007", "thickness_mm": 20},
        },
        "mesh": {"kind": "triangles", "size_m": 0.08},
        "points": {"A": [0.6, 0.4]},
    },
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
    "dampers": {"bed": BED, "other": BED},
}  # fmt: skip


def study_with(**cell):
    values = copy.deepcopy(VALUES)
    values["dampers"]["other"] = {**BED, "cell": cell}
    return Study.model_validate(values)


def test_cells_are_those_of_the_core_by_default():
    study = study_with(count=2)
    for bed in study.dampers.values():
        assert bed.cell.across_flats_mm == pytest.approx(3 / 16 * 25.4)
        assert bed.cell.depth_mm == 20
    assert study.differing_cells == []


@pytest.mark.parametrize(
    ("cell", "remark"),
    [
        ({"across_flats_mm": 4.7625, "depth_mm": 20}, None),
        ({"across_flats_mm": 4.76}, None),
        ({"across_flats_mm": 9.525}, "other has hexagonal cells 9.53 mm wide, 20 mm deep; those of the core are 4.76 mm wide, 20 mm deep"),
        ({"depth_mm": 15}, "other has hexagonal cells 4.76 mm wide, 15 mm deep"),
        ({"shape": "circle", "across_flats_mm": 4.7625}, "other has round cells"),
    ],
)  # fmt: skip
def test_other_cells_are_named_with_both_sizes(cell, remark):
    remarks = study_with(**cell).differing_cells
    assert len(remarks) == (remark is not None)
    assert all(line.startswith(remark) for line in remarks)


def sizes(cell):
    return cell.across_flats_mm, cell.depth_mm


def test_a_core_by_its_moduli_has_a_depth_alone_and_a_plate_no_cells():
    values = copy.deepcopy(VALUES)
    core = {"shear_modulus_l_mpa": 186, "shear_modulus_w_mpa": 90, "density_kg_m3": 32}
    values["panel"]["section"]["core"] = {**core, "thickness_mm": 15}
    study = Study.model_validate(values)
    assert sizes(study.dampers["bed"].cell) == (6.35, 15)
    assert study.differing_cells == []
    values["panel"]["section"] = {"mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 3273}
    study = Study.model_validate(values)
    assert sizes(study.dampers["bed"].cell) == (6.35, 25)
    assert study.differing_cells == []
