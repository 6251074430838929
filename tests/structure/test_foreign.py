"""Modes of another solver give what the same panel gives here."""

import os
import shutil

import numpy as np
import pytest

from pidpanel import Model, StudyError
from pidpanel.modal_files import read_modes
from pidpanel.structure import from_study
from pidpanel.structure.from_study import structure_of
from tests.structures import COMMON, NORMAL, grid_of, in_space


def model_of(structure, **changed):
    return Model({"name": "modes", "structure": structure, **COMMON, **changed})


def rms(model):
    return model.summary().set_index(["scenario", "point"])["acceleration_rms_g"]


def test_modes_of_a_flat_panel_in_space_give_its_g_rms_in_a_baffle(panel_model, structure):
    # linear between nodes, as files have them: 0.5 % on thirty cells
    ratio = rms(model_of(structure)) / rms(panel_model)
    np.testing.assert_allclose(ratio, 1, atol=0.01)


def test_the_sense_of_the_normals_changes_nothing(structure):
    turned = {**structure, "outward": (-NORMAL).tolist()}
    np.testing.assert_allclose(rms(model_of(turned)), rms(model_of(structure)), rtol=1e-9)


def test_a_direction_across_the_motion_sees_none_and_one_at_60_degrees_half(structure):
    across = np.cross(NORMAL, [1.0, 2.0, 3.0])
    across /= np.linalg.norm(across)
    slanted = 0.5 * NORMAL + np.sqrt(0.75) * across
    place = structure["points"]["mid"]["at_m"]
    points = {
        "normal": {"at_m": place},
        "slanted": {"at_m": place, "direction": slanted.tolist()},
        "across": {"at_m": place, "direction": across.tolist()},
    }
    table = model_of({**structure, "points": points}).summary().set_index(["scenario", "point"])
    value = table["acceleration_rms_g"].unstack()
    np.testing.assert_allclose(
        value["slanted"] / value["normal"], 0.5, rtol=1e-5
    )  # shapes in single precision
    assert table["status"].unstack()["across"].eq("held").all()


def test_too_few_modes_are_refused_and_an_error_is_stated(panel_model, structure, tmp_path):
    path = tmp_path / "few.vtu"
    grid_of(panel_model, 500.0).save(path)
    few = model_of({**structure, "modes": {"file": str(path), "unit_m": 1}})
    truth, table = rms(panel_model), few.summary()
    error = table.groupby("scenario")["basis_error"].first() / 2
    found = np.abs(rms(few) / truth - 1).groupby("scenario").max()
    assert (found < error + 0.006).all()  # with that of linear shapes
    grid_of(panel_model, 300.0).save(path)
    with pytest.raises(StudyError, match="modes end at"):
        model_of({**structure, "modes": {"file": str(path), "unit_m": 1}})


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"mass_kg": 6000}, "structure.mass_kg"),
        ({"patches": {"P": {"group": "NONE"}}}, "structure.patches.P.group"),
        ({"patches": {"P": {"centre_m": [9, 9, 9], "radius_m": 0.1}}}, "structure.patches.P"),
        ({"points": {"mid": {"at_m": [9, 9, 9]}}}, "structure.points.mid.at_m"),
        ({"points": {"mid": {"node": 99999}}}, "structure.points.mid.node"),
        ({"outward": [0, 0, 0]}, "structure.outward"),
    ],
)
def test_what_is_off_the_structure_is_refused_at_its_key(structure, change, key):
    with pytest.raises(StudyError, match=key):
        model_of({**structure, **change})


def test_a_point_beside_its_node_is_moved_there_which_is_stated(structure):
    points = {"near": {"at_m": in_space([0.76, 0.5]).tolist()}, **structure["points"]}
    remarks = structure_of(model_of({**structure, "points": points}).study.panel).remarks
    moved = [remark for remark in remarks if "nearest node" in remark]
    assert moved == ["point near is at the nearest node, 10 mm away"]


def test_modes_are_read_once_and_again_after_their_file_changes(structure, tmp_path, monkeypatch):
    copy, reads = tmp_path / "modes.vtu", []

    def counted(*files, **options):
        reads.append(files)
        return read_modes(*files, **options)

    shutil.copy(structure["modes"]["file"], copy)
    monkeypatch.setattr(from_study, "read_modes", counted)
    structure["modes"]["file"] = str(copy)
    model_of(structure)
    assert len(reads) == 1
    os.utime(copy, ns=(1, 1))
    model_of(structure)
    assert len(reads) == 2
