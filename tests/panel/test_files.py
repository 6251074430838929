"""Truths of the files of the basis."""

import dataclasses

import meshio
import numpy as np
import pytest
import xarray as xr

from pidpanel.geometry.polygon import Polygon
from pidpanel.panel.files import OPTIONAL, PACKED, SINGLE, read_basis, write_basis, write_shapes
from pidpanel.panel.section import ThinSection
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.provenance.results import ResultsDamaged
from tests.panel_basis import panel_basis

SECTION = ThinSection(bending_stiffness=3273.07, mass_per_area=4.0)


@pytest.fixture
def bare_triangles(tmp_path):
    """A basis without patches and points, on triangles."""
    outline = Polygon(((0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0)))
    mesh = mesh_triangles(tmp_path / "m.msh", outline, 0.5, {}, {})
    return panel_basis(mesh, assemble_thin_plate(mesh, SECTION), 200.0)


@pytest.mark.parametrize("which", ["paper_basis", "bare_triangles"])
def test_a_basis_comes_back_as_it_was_written(tmp_path, request, which):
    basis = request.getfixturevalue(which)
    write_basis(tmp_path / "basis.nc", basis, {})
    again = read_basis(tmp_path / "basis.nc")
    for field in dataclasses.fields(basis):
        before, after = getattr(basis, field.name), getattr(again, field.name)
        assert type(after) is type(before)
        if field.name in SINGLE:
            np.testing.assert_allclose(after, before, rtol=6e-8, atol=1e-37)
        elif field.name in PACKED:  # half a step of 32767
            largest = np.abs(before).max(axis=(0, 1))
            assert np.all(np.abs(after - before) <= 0.51 / 32767 * largest)
        else:
            np.testing.assert_array_equal(after, before)
        if isinstance(before, np.ndarray):
            assert after.dtype == before.dtype


def test_every_variable_says_its_unit_and_its_name_and_the_file_its_study(tmp_path, paper_basis):
    write_basis(tmp_path / "basis.nc", paper_basis, {"study": "paper-1234"})
    with xr.open_dataset(tmp_path / "basis.nc", engine="scipy") as dataset:
        assert dataset.attrs == {"study": "paper-1234"}
        fields = {field.name for field in dataclasses.fields(paper_basis)} - OPTIONAL
        assert set(dataset.variables) == fields | {f"{name}_step" for name in PACKED}
        for variable in dataset.variables.values():
            assert variable.attrs["units"] and variable.attrs["long_name"]
        assert dataset["natural_frequency"].units == "Hz"
        assert dataset["modal_mass"].units == "kg"
        assert dataset["patch_overlap"].units == "m2"


def test_the_same_basis_makes_the_same_file(tmp_path, paper_basis):
    for name in ("1.nc", "2.nc"):
        write_basis(tmp_path / name, paper_basis, {"study": "x"})
    assert (tmp_path / "1.nc").read_bytes() == (tmp_path / "2.nc").read_bytes()


def test_a_file_that_is_no_basis_says_what_is_missing(tmp_path, paper_basis):
    write_basis(tmp_path / "basis.nc", paper_basis, {})
    with xr.open_dataset(tmp_path / "basis.nc", engine="scipy") as dataset:
        dataset.drop_vars("modal_mass").to_netcdf(tmp_path / "less.nc", engine="scipy")
    with pytest.raises(ResultsDamaged, match=r"less.nc: has no modal_mass"):
        read_basis(tmp_path / "less.nc")


@pytest.mark.parametrize("which", ["paper_basis", "bare_triangles"])
def test_shapes_to_look_at_stand_on_the_mesh(tmp_path, request, which):
    basis = request.getfixturevalue(which)
    write_shapes(tmp_path / "shapes.vtu", basis)
    grid = meshio.read(tmp_path / "shapes.vtu")
    np.testing.assert_array_equal(grid.cells[0].data, basis.cells)
    np.testing.assert_array_equal(grid.points[:, :2], basis.vertex_position)
    names = list(grid.point_data)
    assert names[0].startswith("mode_001_64.9")
    assert sum(name.startswith("residual") for name in names) == basis.is_residual.sum()
    for i, name in enumerate(names):
        np.testing.assert_array_equal(grid.point_data[name], basis.shape_at_vertices[:, i])
