"""Shapes of the loaded panel in the basis, and the file of the plate."""

import numpy as np
import pytest
import scipy.linalg as la
import xarray as xr

from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.files import read_plate, write_plate
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.modes import loaded_modes
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.provenance.results import ResultsDamaged
from tests.panel_basis import panel_basis

SIZE = (1.5, 1.0)
PATCHES = {"all": Rectangle((0.75, 0.5), SIZE), "part": Rectangle((0.5, 0.5), (0.4, 0.4))}


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    path = tmp_path_factory.mktemp("loaded") / "panel.msh"
    mesh = mesh_quadrilaterals(path, SIZE, (15, 10), PATCHES, {"a": (0.8, 0.5)})
    return assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))


def frequencies_in(plate, vectors, mass):
    """Frequencies of the loaded panel within the span of some shapes [Hz]."""
    M = plate.mass + sum(value * plate.patch_overlap[name] for name, value in mass.items())
    value = la.eigh(vectors.T @ (plate.stiffness @ vectors), vectors.T @ (M @ vectors))[0]
    return np.sqrt(value) / (2 * np.pi)


def test_mass_all_over_the_panel_makes_the_modes_of_a_heavier_panel(plate):
    shapes = panel_shapes(plate, 400.0, damper_mass={"all": 12.0})
    expected = panel_shapes(plate, 600.0, residual_tolerance=1.0).frequency / np.sqrt(16.0 / 4.0)
    found = frequencies_in(plate, shapes.vectors, {"all": 12.0})[: len(expected)]
    # the modes of the loaded panel are in the basis as they are
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_under_a_heavy_damper_the_modes_that_it_lowers_are_kept(plate):
    shapes = panel_shapes(plate, 200.0, damper_mass={"all": 60.0})
    expected = panel_shapes(plate, 200.0 * np.sqrt(16.0), residual_tolerance=1.0).frequency
    np.testing.assert_allclose(shapes.frequency, expected, rtol=1e-9)
    light = panel_shapes(plate, 200.0, damper_mass={"part": 20.0})
    assert len(light.frequency) == 12


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
def test_the_basis_carries_every_mass_up_to_the_heaviest(plate, share):
    shapes = panel_shapes(plate, 400.0, damper_mass={"part": 80.0})
    mass = {"part": 80.0 * share}
    expected = np.sqrt(
        la.eigh(
            plate.stiffness.toarray(),
            (plate.mass + mass["part"] * plate.patch_overlap["part"]).toarray(),
            eigvals_only=True,
        )
    ) / (2 * np.pi)
    expected = expected[expected < 200.0]
    found = frequencies_in(plate, shapes.vectors, mass)[: len(expected)]
    # a PSD within 0.5 % asks for frequencies within a tenth of the bandwidth, 2ζ = 2 %
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_shapes_are_the_same_bits_on_two_cores(monkeypatch, plate):
    alone = panel_shapes(plate, 400.0, damper_mass={"part": 80.0})
    monkeypatch.setenv("PIDPANEL_CORES", "2")
    together = panel_shapes(plate, 400.0, damper_mass={"part": 80.0})
    np.testing.assert_array_equal(together.vectors, alone.vectors)
    np.testing.assert_array_equal(together.frequency, alone.frequency)


def test_a_light_damper_adds_few_shapes(plate):
    none = panel_shapes(plate, 400.0).vectors.shape[1]
    light = panel_shapes(plate, 400.0, damper_mass={"part": 0.01}).vectors.shape[1]
    heavy = panel_shapes(plate, 400.0, damper_mass={"part": 80.0}).vectors.shape[1]
    assert none <= light < heavy


def test_modes_of_the_loaded_panel_are_those_below_the_limit(plate):
    _, modes = loaded_modes(plate, {"part": 80.0}, 150.0)
    M = (plate.mass + 80.0 * plate.patch_overlap["part"]).toarray()
    value = la.eigh(plate.stiffness.toarray(), M, eigvals_only=True)
    assert modes.shape[1] == np.sum(value < (2 * np.pi * 150.0) ** 2)


def test_shapes_that_rest_at_all_vertices_are_as_large_as_the_others(tmp_path):
    # sin(5πx/a) on five elements: scaled by what rounding leaves at the vertices, it was 1e13 times
    # the others, and cut them all off from the patch (g rms of a whole panel full as of a bare one)
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, (5, 4), {"all": PATCHES["all"]}, {})
    coarse = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    shapes = panel_shapes(coarse, 900.0, damper_mass={"all": 60.0})
    at_vertices = np.abs(coarse.at_vertices @ shapes.vectors).max(axis=0)
    between = np.abs(coarse.at_quadrature @ shapes.vectors).max(axis=0)
    assert np.any(at_vertices < 1e-6)  # the case is one
    largest = np.maximum(at_vertices, between)
    assert largest.min() > 0.99 and largest.max() <= 10  # what HIDDEN allows


def test_the_plate_comes_back_from_its_file(plate, tmp_path):
    shapes = panel_shapes(plate, 300.0)
    write_plate(tmp_path / "plate.nc", plate.with_shapes(shapes.vectors), {"study_hash": "x"})
    found = read_plate(tmp_path / "plate.nc")
    for name in ("stiffness", "mass", "at_vertices", "at_quadrature"):
        before, after = getattr(plate, name), getattr(found, name)
        assert after.shape == before.shape
        assert abs(after - before).max() <= 1e-15 * abs(before).max()  # symmetric to rounding
    assert list(found.patch_overlap) == list(plate.patch_overlap)
    for name, overlap in plate.patch_overlap.items():
        assert abs(found.patch_overlap[name] - overlap).max() == 0
    for name in ("curvature_at_vertices", "shear_at_vertices"):
        for before, after in zip(getattr(plate, name), getattr(found, name), strict=True):
            assert after.shape == before.shape and abs(after - before).sum() == 0
    np.testing.assert_array_equal(found.shapes, shapes.vectors.astype(np.float32))


def test_another_file_is_no_plate(tmp_path):
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="scipy")
    with pytest.raises(ResultsDamaged, match=r"other\.nc: has no stiffness_data"):
        read_plate(tmp_path / "other.nc")


def test_a_patch_on_the_whole_panel_needs_no_residual_vectors(tmp_path):
    # D = M/m″, so that the modes answer their own forces; what is left is rounding
    whole = {"all": PATCHES["all"]}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, (15, 10), whole, {})
    shapes = panel_shapes(assemble_thin_plate(mesh, ThinSection(3273.07, 4.0)), 1000.0)
    assert shapes.residuals.shape[1] == 0 and len(shapes.frequency) > 12


def test_a_basis_has_the_static_answers_of_all_higher_modes_down_to_one_in_ten_thousand(tmp_path):
    # singular values of φᵀ D Φ / ω over the modes φ that are left out, of which one is 1.05e-4 of
    # the largest
    patch = {"a": Rectangle((0.35, 0.2), (0.3, 0.2))}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", (1.0, 0.8), (10, 8), patch, {})
    plate = assemble_thin_plate(mesh, ThinSection(3273.07, 4.0))
    basis, shapes = panel_basis(mesh, plate, 1600.0), panel_shapes(plate, 1600.0)
    square, vectors = la.eigh(plate.stiffness.toarray(), plate.mass.toarray())
    below = np.sqrt(square) < 2 * np.pi * 1600
    modes, others = vectors[:, below], vectors[:, ~below] / np.sqrt(square[~below])
    modes = modes / np.abs(plate.at_vertices @ modes).max(axis=0)
    size = la.svdvals(others.T @ (plate.patch_overlap["a"] @ modes))
    assert basis.is_residual.tolist() == [False] * below.sum() + [True] * np.sum(
        size > 1e-4 * size[0]
    )
    assert shapes.residuals.shape[1] == basis.is_residual.sum()
