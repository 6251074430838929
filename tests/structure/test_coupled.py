"""Coupled runs on structures: a flat one in space is the panel, a curved one has its own places."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from pidpanel import Model
from pidpanel.coupled.excited_panel import LoadedShapes
from pidpanel.coupled.from_study import coupled_scenarios, read_excited_panel, write_scenario
from pidpanel.solve.source import PatchParts
from tests.jobs import PANEL as PANEL_FILES
from tests.jobs import SOUND as SOUND_FILES
from tests.jobs import files, make_panel, make_sound, within
from tests.structures import COMMON, CURVED, PANEL, grid_of, in_space

BED = {
    "particles": {"diameter_mm": 2.5, "density_kg_m3": 1190, "restitution": 0.8, "friction": 0.3},
    "cell": {"across_flats_mm": 6.35, "depth_mm": 8},
    "model": "coupled",
}
KEYS = {"duration_s": 0.25, "settle_s": 0.05, "runs": 1, "stations": 4, "cells": 8}
COUPLED = {
    **COMMON,
    "response": {"frequency_hz": [60, 300]},
    "dampers": {"bed": BED},
    "damping": {"coupled": KEYS},
    "scenarios": {"one": {"patch": "P", "fill_fraction": 0.6}},
}


def estimate(folder, write_study, values):
    """The estimate of the coupled run of a study."""
    path = write_study(folder, "study", values)
    make_panel(path, folder)
    make_sound(path, folder)
    study = Model(path).study
    upstream = files(within(folder, PANEL_FILES | SOUND_FILES))
    (label,) = coupled_scenarios(study)
    write_scenario(study, upstream, label, folder / "store", folder / label, folder / "run.nc")
    return xr.load_dataset(folder / "run.nc", engine="scipy")


@pytest.mark.liggghts
def test_a_flat_structure_in_space_answers_as_the_panel(tmp_path, write_study, structure):
    panel = estimate(tmp_path / "panel", write_study, {"panel": PANEL, **COUPLED})
    modes = xr.load_dataset(tmp_path / "panel/modes.nc", engine="scipy").rename(shape="mode")
    grid_of(SimpleNamespace(modes=lambda: modes), np.inf).save(tmp_path / "modes.vtu")
    values = {**structure, "modes": {"file": str(tmp_path / "modes.vtu"), "unit_m": 1}}
    turned = estimate(tmp_path / "modes", write_study, {"structure": values, **COUPLED})
    # of the same forces and beds: quadrature alone differs, and what a chaotic bed makes of it
    for name in ("displacement_psd", "linear_displacement_psd"):
        squares = [(run[name] * run["frequency"] ** 4).sum("frequency") for run in (panel, turned)]
        np.testing.assert_allclose(squares[1] / squares[0], 1, atol=0.05)
    damping = [run["equivalent_damping"].mean() for run in (panel, turned)]
    assert damping[1] == pytest.approx(damping[0], rel=0.15)


def test_cells_of_a_curved_patch_move_with_its_supports_along_their_normals(tmp_path, write_study):
    arch = copy.deepcopy(CURVED)
    arch["shell"]["supports"] = {"end": {"where": {"from_m": [-1, -2, -2], "to_m": [0, 2, 2]}}}
    values = {key: value for key, value in COUPLED.items() if key != "sound"}
    values["response"] = {"frequency_hz": [40, 150]}
    values["base"] = {"random": {"spectrum": "limit.csv"}, "direction": [0, 1, 0]}
    values["damping"] = {"coupled": {**KEYS, "duration_s": 0.5}}
    path = write_study(tmp_path, "study", {"structure": arch, **values})
    make_panel(path, tmp_path)
    excited = read_excited_panel(Model(path).study, files(within(tmp_path, PANEL_FILES)))
    patch = excited.patch("P", 4e-5, LoadedShapes(excited.modal, None))
    # a cylinder of radius 1 m about x: the normal has the direction of the place
    np.testing.assert_allclose(patch.shape[:, -1], patch.position[:, 1], atol=1e-3)
    assert np.ptp(patch.position[:, 1]) > 0.05
    assert excited.diameter > 0.8
    assert patch.distance.max() < 0.3


@pytest.mark.parametrize("length", [0.02, 0.2])
def test_parts_of_a_flat_patch_in_space_have_their_load_in_its_plane(length):
    x = (np.arange(8) + 0.5) / 80
    place = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    shape = np.stack([np.ones(64), np.sin(20 * place[:, 0])], axis=1)
    loads = [
        PatchParts(shape, np.full(64, 1 / 6400), position).coherent_load(length)
        for position in (place, in_space(place))
    ]
    # the squares of parts are turned to the line between them
    np.testing.assert_allclose(loads[1] / loads[0], 1, atol=5e-3)
