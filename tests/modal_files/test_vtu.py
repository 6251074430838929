"""Modes in VTU, written by VTK; units, masses and what is refused."""

import re

import numpy as np
import pytest
import pyvista
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

from pidpanel.modal_files import read_modes
from pidpanel.paths import PROJECT

AREAL_MASS = 3.0  # [kg/m²], of the plate


def grid_of(plate, unit_m=1.0, unit_kg=1.0):
    place = {number: k for k, number in enumerate(plate.node.tolist())}
    quads = np.vectorize(place.get)(plate.corners)
    grid = pyvista.UnstructuredGrid({pyvista.CellType.QUAD: quads}, plate.position / unit_m)
    for k in range(len(plate.frequency)):
        grid.point_data[f"mode_{k + 1}"] = plate.displacement[:, :, k]
    grid.field_data["frequencies"] = plate.frequency
    grid.field_data["modal_masses"] = plate.modal_mass / unit_kg
    grid.cell_data["group"] = 1 + (np.arange(len(quads)) % 4 == 0)
    grid.cell_data["rim"] = (np.arange(len(quads)) < 12).astype(int)
    return grid


def read(grid, tmp_path, unit_m=1.0, **options):
    grid.save(tmp_path / "modes.vtu")
    return read_modes(tmp_path / "modes.vtu", unit_m=unit_m, **options)


@pytest.mark.parametrize(("unit_m", "unit_kg"), [(1, 1), (1e-3, 1e3), (0.0254, 175.1268)])
def test_modes_are_in_si_whatever_the_units_of_the_file(plate, tmp_path, unit_m, unit_kg):
    model = read(grid_of(plate, unit_m, unit_kg), tmp_path, unit_m)
    np.testing.assert_allclose(model.position, plate.position, atol=1e-12)
    np.testing.assert_allclose(model.modal_mass, plate.modal_mass, rtol=1e-6)
    np.testing.assert_array_equal(model.displacement, plate.displacement)
    np.testing.assert_allclose(model.frequency, plate.frequency)


def test_the_modes_of_a_plate_move_its_areal_mass(plate, tmp_path):
    model = read(grid_of(plate), tmp_path)
    # the mean of sin² at the corners of a regular grid is exact
    np.testing.assert_allclose(model.areal_mass, AREAL_MASS)


def test_numbers_and_flags_of_cells_are_groups(plate, tmp_path):
    grid = grid_of(plate)
    grid.cell_data["rim"] = 1.0 * grid.cell_data["rim"]
    grid.cell_data["thickness"] = np.full(96, 0.5)
    groups = read(grid, tmp_path).groups
    assert groups.keys() == {"1", "2", "rim"}
    np.testing.assert_array_equal(groups["2"], np.arange(0, 96, 4))
    np.testing.assert_array_equal(groups["rim"], np.arange(12))


def test_a_compression_that_is_not_read_is_named(plate, tmp_path):
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid_of(plate))
    writer.SetFileName(f"{tmp_path / 'modes.vtu'}")
    writer.SetCompressorTypeToLZ4()
    writer.SetHeaderTypeToUInt64()
    writer.Write()
    with pytest.raises(ValueError, match=r"compressed otherwise than by zlib or lzma"):
        read_modes(tmp_path / "modes.vtu", unit_m=1.0)


def test_quadratic_cells_are_cut_at_their_nodes_between_the_corners(tmp_path):
    corners = np.array([[0, 0], [2, 0], [2, 1], [0, 1], [4, 0], [2, 1]])
    middles = np.array([[1, 0], [2, 0.5], [1, 1], [0, 0.5]])
    triangle = np.array([[2, 0], [4, 0], [2, 1], [3, 0], [3, 0.5], [2, 0.5]])
    flat = np.concatenate([corners[:4], middles, triangle])
    position = np.column_stack([flat, np.zeros(len(flat))])
    cells = {pyvista.CellType.QUADRATIC_QUAD: np.arange(8)[None],
             pyvista.CellType.QUADRATIC_TRIANGLE: 8 + np.arange(6)[None]}  # fmt: skip
    grid = pyvista.UnstructuredGrid(cells, position)
    grid.point_data["mode_1"] = np.tile([0.0, 0, 2], (14, 1))
    grid.cell_data["group"] = [3, 4]
    grid.field_data["frequencies"], grid.field_data["modal_masses"] = [1.0], [3 * 2.5 * 4]
    model = read(grid, tmp_path)
    np.testing.assert_allclose(model.areal_mass, 2.5)  # the area is 3 m²
    assert {name: len(cells) for name, cells in model.groups.items()} == {"3": 5, "4": 4}
    a, b, _, d = model.position[model.cells].transpose(1, 0, 2)
    assert (np.cross(b - a, d - a)[:, 2] > 0).all()  # the parts keep the side


def refused(grid, tmp_path, message, **options):
    with pytest.raises(ValueError, match=message) as error:
        read(grid, tmp_path, **{"unit_m": 1.0, **options})
    assert "modes.vtu" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("frequencies", [4, 3, 2, 1], r"mode 2 has 3 Hz after 4 Hz"),
        ("frequencies", [-1, 3, 4, 5], r"mode 1 has -1 Hz; 0 to 1e"),
        ("frequencies", [1, 3, np.nan, 5], r"mode 3 has nan Hz"),
        ("frequencies", [1, 3, 4, 1e300], r"mode 4 has 1e\+300 Hz; 0 to 1e\+06 is allowed"),
        ("frequencies", [0, 0, 0, 0], "modes are rigid motions alone"),
        ("frequencies", [1, 3], "4 arrays mode_1 … of points and 2 frequencies"),
        ("modal_masses", [1, 0, 1, 1], "mode 2 has no modal mass; state normalised: mass"),
        ("modal_masses", [1.0, -2, 1, 1], "mode 2 has a modal mass of -2; it must be positive"),
        ("modal_masses", [1.0, 1, 1, 1], "largest components of all modes are 1"),
        (
            "modal_masses",
            [7e3] * 4,
            r"modes move 29[0-9.]+ kg/m² of the surface; allowed .*unit_kg",
        ),
    ],
)
def test_frequencies_and_masses_that_no_structure_has_are_refused(
    plate, tmp_path, name, values, message
):
    if message.startswith("largest"):  # a grid without a node at the antinodes has less
        plate = plate._replace(
            displacement=plate.displacement / np.abs(plate.displacement).max((0, 1))
        )
    grid = grid_of(plate)
    grid.field_data[name] = np.array(values, dtype=float)
    refused(grid, tmp_path, message)


def test_other_broken_models_are_refused(plate, tmp_path):
    refused(grid_of(plate), tmp_path, "0.00[0-9]+ m large with unit_m = 0.001", unit_m=1e-3)
    grid = grid_of(plate)
    del grid.field_data["modal_masses"]
    refused(grid, tmp_path, "mode 1 has no modal mass")
    refused(grid_of(plate), tmp_path, "unit_m = 0.01 needs unit_kg; only 1, 0.001", unit_m=0.01)
    refused(grid_of(plate), tmp_path, "mode 1 has a modal mass of 0.72; normalised: mass needs 1",
            normalised="mass")  # fmt: skip
    grid = grid_of(plate)
    grid.point_data["mode_2"][7, 1] = np.inf
    refused(grid, tmp_path, "node 8: its displacement is not finite")
    grid = grid_of(plate)
    grid.point_data["mode_3"][:] = 0
    refused(grid, tmp_path, "mode 3 has no displacement on the surface")
    grid.point_data["mode_3"] = -2 * grid.point_data["mode_2"]
    refused(grid, tmp_path, "modes 2 and 3 have the same shape")
    grid = grid_of(plate)
    grid.points[grid.cells[1:5]] = grid.points[grid.cells[1]]
    refused(grid, tmp_path, "an element at node [0-9]+ has no area")
    grid.points[6] = np.nan
    refused(grid, tmp_path, "node 7: its position is not finite")
    grid = grid_of(plate)
    del grid.point_data["mode_3"]
    refused(grid, tmp_path, "array mode_3 is missing; it has 4")
    grid = grid_of(plate)
    grid.point_data["mode_3"] = np.ones(len(plate.node))
    refused(grid, tmp_path, "array mode_3 must have three real components")
    (tmp_path / "cut.vtu").write_bytes((tmp_path / "modes.vtu").read_bytes()[:900])
    with pytest.raises(ValueError, match=r"cut.vtu: is no VTU that can be read"):
        read_modes(tmp_path / "cut.vtu", unit_m=1)


def test_masses_may_be_declared(plate, tmp_path):
    scale = plate.modal_mass**-0.5
    grid = grid_of(plate._replace(displacement=plate.displacement * scale))
    del grid.field_data["modal_masses"]
    model = read(grid, tmp_path, normalised="mass")
    np.testing.assert_allclose(model.areal_mass, AREAL_MASS)
    grid.point_data["mode_4"] *= 0.1
    refused(grid, tmp_path, "modes move 3 to 300 kg/m² of the surface", normalised="mass")


def test_static_cases_are_displacements_per_pascal(plate, tmp_path):
    """A pressure of 1 in mm, t, s is 1 MPa."""
    grid = grid_of(plate, 1e-3, 1e3)
    grid.point_data["static_1"] = 5e3 * plate.displacement[:, :, 0]  # 5 m
    model = read(grid, tmp_path, 1e-3)
    np.testing.assert_allclose(
        model.static_displacement[:, :, 0], 5e-6 * plate.displacement[..., 0]
    )


def test_the_documented_lines_write_what_is_read(tmp_path, monkeypatch):
    text = (PROJECT / "docs" / "structures.md").read_text(encoding="utf-8")
    _, lines = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    variables = {}
    exec(lines, variables)
    model = read_modes(tmp_path / "modes.vtu", unit_m=1.0)
    np.testing.assert_allclose(model.frequency, variables["frequencies"])
    np.testing.assert_allclose(np.moveaxis(model.displacement, 2, 0), variables["shapes"])
    assert {name: cells.tolist() for name, cells in model.groups.items()} == {
        "1": [0, 3], "2": [1, 2], "damper": [1]
    }  # fmt: skip
