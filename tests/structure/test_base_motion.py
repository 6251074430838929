"""Base motion of modes from a file, with participation in a VTU or a mass that is uniform."""

import numpy as np
import pytest

from pidpanel import Model, StudyError
from tests.structures import COMMON, NORMAL, PANEL, grid_of

SHAKEN = {
    **{key: value for key, value in COMMON.items() if key != "sound"},
    "base": {"random": {"spectrum": "gevs_qualification.csv"}},
}


@pytest.fixture(scope="module")
def shaken():
    """The panel of `structures` on a shaker: its rms values."""
    return rms(Model({"name": "flat", "panel": PANEL, **SHAKEN}))


def rms(model):
    """(scenarios, points) of the acceleration, then (scenarios, 1) of the force on the supports."""
    psd = model.base().sel(input="stated")
    parts = psd["absolute_acceleration_psd"], psd["interface_force_psd"].expand_dims("point", -1)
    return np.sqrt(np.hstack([part.integrate("frequency").to_numpy() for part in parts]))


def moved(structure, grid, tmp_path, direction=NORMAL, **modes):
    grid.save(tmp_path / "modes.vtu")
    files = {"file": str(tmp_path / "modes.vtu"), "unit_m": 1, **modes}
    base = {**SHAKEN["base"], "direction": np.asarray(direction).tolist()}
    values = {"structure": {**structure, "modes": files}, **SHAKEN, "base": base}
    return Model({"name": "modes", **values})


@pytest.fixture
def grid(panel_model):
    """Modes with participation, that of a uniform mass on the cells of the panel."""
    grid = grid_of(panel_model, 2000.0)
    shapes = panel_model.modes()["shape_at_vertices"].to_numpy()[:, : grid.n_arrays]
    count = len(grid.field_data["frequencies"])
    cells = panel_model.modes()["cells"].to_numpy().astype(int)
    mean = shapes[:, :count][cells].mean(axis=(0, 1))
    for axis, component in zip("xyz", NORMAL, strict=True):
        grid.field_data[f"participation_{axis}"] = 6.0 * mean * component
    return grid


def test_participation_in_a_file_gives_g_rms_of_the_shaken_panel(shaken, structure, grid, tmp_path):
    ratio = rms(moved(structure, grid, tmp_path)) / shaken
    np.testing.assert_allclose(ratio, 1, atol=0.01)


def test_a_uniform_mass_gives_the_same(shaken, structure, grid, tmp_path):
    scales = np.linspace(0.5, 3, len(grid.field_data["frequencies"]))
    for name in list(grid.field_data.keys()):
        if name != "frequencies":
            del grid.field_data[name]
    for number, scale in enumerate(scales, 1):
        grid.point_data[f"mode_{number}"] *= scale
    ratio = rms(moved(structure, grid, tmp_path, uniform_mass=True)) / shaken
    np.testing.assert_allclose(ratio, 1, atol=0.01)


def test_a_motion_at_60_degrees_moves_the_points_by_half(shaken, structure, grid, tmp_path):
    across = np.cross(NORMAL, [0, 1.0, 2.0])
    across /= np.linalg.norm(across)
    slanted = 0.5 * NORMAL + np.sqrt(0.75) * across
    ratio = rms(moved(structure, grid, tmp_path, slanted)) / shaken
    np.testing.assert_allclose(ratio[:, :2], 0.5, atol=0.005)


def test_participation_that_no_structure_has_is_refused(structure, grid, tmp_path):
    stated = grid.field_data["participation_x"].copy()
    grid.field_data["participation_x"] = 3 * stated
    with pytest.raises(StudyError, match=r"mass_kg = 6: modes have effective masses of .* along x"):
        moved(structure, grid, tmp_path)
    grid.field_data["participation_x"] = stated[:-1]
    with pytest.raises(StudyError, match="participation_x in the field data must have"):
        moved(structure, grid, tmp_path)
    del grid.field_data["participation_x"]
    with pytest.raises(StudyError, match="participation_x in the field data must have"):
        moved(structure, grid, tmp_path)
