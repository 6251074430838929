"""What maps over the panel take from the PSDs: errors of their points, dampers on fewer lines."""

import xml.etree.ElementTree as ET
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
import xarray as xr

from pidpanel.response import mapping
from pidpanel.response.mapping import UNITS, _dampers, _error_of_points, map_dataset, write_paraview

KEY = ("s",)


def psds(psd, error=None):
    """Of points (nf, n) on lines 2 Hz apart."""
    lines = 2.0 * np.arange(len(psd))
    names = ("scenario", "frequency", "point")
    values = {"acceleration_psd": (names, np.array(psd, float)[None])}
    if error is not None:
        values["acceleration_psd_log_error"] = (names, np.array(error, float)[None])
    return xr.Dataset(values, {"scenario": ["s"], "frequency": lines})


def test_the_error_is_half_of_that_of_the_mean_square_and_of_the_worst_point():
    found = _error_of_points(psds([[1, 5, 0], [3, 5, 0]], [[0.2, 0.1, 9], [0.4, 0.1, 9]]), *KEY)
    assert found == pytest.approx((0.2 + 1.2) / (2 * 4))
    small = _error_of_points(psds([[0.1], [0.3]], [[0.2], [0.4]]), *KEY)
    assert small == pytest.approx(found)
    assert np.isnan(_error_of_points(psds([[1.0], [2.0]]), *KEY))
    assert np.isnan(_error_of_points(psds([[0.0], [0.0]], [[0.1], [0.1]]), *KEY))


def test_dampers_are_read_on_the_lines_of_the_maps():
    lines, coarse = np.array([10.0, 20.0, 40.0]), np.array([15.0, 30.0])
    names = ("scenario", "frequency", "patch")
    values = np.array([[1.0, 10], [3, 20], [7, 40]])[None]
    psd = xr.Dataset(
        {"equivalent_damping": (names, values), "apparent_mass": (names, 2 * values)},
        {"scenario": ["s"], "frequency": lines, "patch": ["a", "b"]},
    )
    scenario = SimpleNamespace(is_bare=False, label="s", patches=("b", "a"), factor=2.5)
    damping, mass, factor = _dampers(coarse, psd, scenario, scenario.patches)
    np.testing.assert_allclose(damping, [[15, 30], [2, 5]])
    np.testing.assert_allclose(mass, 2 * damping)
    assert factor == 2.5
    bare = _dampers(coarse, psd, SimpleNamespace(is_bare=True, factor=0.5), ("a", "b"))
    assert bare[0].shape == (2, 2) and not bare[0].any() and not bare[1].any() and bare[2] == 0.5


class Force:
    """An excitation of level 1."""

    def spectrum(self, frequency):
        return np.ones(frequency.shape)


def test_maps_are_of_every_scenario_with_the_force_of_its_own_particles(tmp_path, monkeypatch):
    # no core where a component of its stress is none
    asked = []

    def covariances(frequency, weights, modal, patches, spectrum, excitation, dampers, air):
        asked.append((excitation, patches, dampers))
        return [np.array([[[4.0]], [[9.0]]])] * len(dampers)

    known = {
        "modal_covariances": covariances,
        "write_paraview": lambda folder, dataset: None,
        "is_steady": lambda psd, label: True,
        "_error_of_points": lambda psd, label: 0.1,
        "_dampers": lambda lines, psd, scenario, names: scenario.label,
        "own_force_of": lambda panel, scenario: scenario.force,
    }
    for name, function in known.items():
        monkeypatch.setattr(mapping, name, function)
    shape = np.arange(1.0, 5.0)[:, None]
    basis = SimpleNamespace(
        layer_names=["top"], layer_strain=np.eye(3)[None], layer_stress=np.eye(3)[None],
        patch_names=["a", "b"], shape_at_vertices=shape, curvature_at_vertices=np.zeros((4, 3, 1)),
        shear_at_vertices=0.1 * np.ones((4, 2, 1)), core_stress=np.diag([2.0, 0.0]),
        vertex_position=np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), cells=np.array([[0, 1, 2, 3]]),
    )  # fmt: skip
    force = Force()
    panel = SimpleNamespace(
        basis=basis, excitation=force, coarse_frequency=np.array([1.0, 2.0]), modal=None, air=None,
        patches=SimpleNamespace(subset=tuple), particle_force=lambda sources: sources,
    )  # fmt: skip
    scenarios = [
        SimpleNamespace(
            label="bare", patches=(), is_bare=True, is_coupled=False, factor=2.5, force=None
        ),
        SimpleNamespace(
            label="s", patches=("b",), is_bare=False, is_coupled=True, factor=2.5, force="its own"
        ),
        SimpleNamespace(
            label="t", patches=("b",), is_bare=False, is_coupled=False, factor=2.5, force=None
        ),
    ]
    path = tmp_path / "maps.nc"
    output = SimpleNamespace(maps=path, folder=tmp_path)
    mapping.write_rms_maps(panel, scenarios, None, {}, output)
    assert [dampers for *_, dampers in asked] == [["bare", "t"], ["s"]]
    assert [patches for _, patches, _ in asked] == [(1,), (1,)]
    assert asked[0][0] is force
    own = asked[1][0]
    assert (own.first, own.second, own.share) == (force, "its own", 0.4)
    with xr.open_dataset(path, engine="scipy") as maps:
        values = {name: maps[name].values for name in maps.data_vars}
    np.testing.assert_allclose(values["acceleration_rms"], [[2, 4, 6, 8]] * 3)
    np.testing.assert_allclose(values["displacement_rms"], [[3, 6, 9, 12]] * 3)
    np.testing.assert_allclose(values["core_shear_xz_rms"], 3 * 2 * 0.1)
    assert not values["core_shear_yz_rms"].any() and (values["relative_error"] == 0.1).all()


def test_paraview_finds_every_case_with_units_in_the_names(tmp_path):
    vertices = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    cells = np.array([[0, 1, 2, 3]])
    maps = {name: np.arange(4.0) for name in ("acceleration", "displacement")}
    maps |= {name: np.arange(8.0).reshape(2, 4) for name in UNITS if name not in maps}
    found = {"bare": maps, "PID-1_r0.5": maps}
    path = tmp_path / "maps.nc"
    map_dataset(found, [0.1] * len(found), vertices, cells, ["top", "bottom"]).to_netcdf(
        path, engine="scipy"
    )
    with xr.open_dataset(path, engine="scipy") as dataset:
        assert dataset["acceleration_rms"].attrs["units"] == "m s-2"
        write_paraview(tmp_path / "maps", dataset.load())
    root = ET.parse(tmp_path / "maps" / "maps.pvd").getroot()
    files = [entry.attrib["file"] for entry in root.iter("DataSet")]
    assert files == ["bare.vtu", "PID-1_r0.5.vtu"]
    mesh = meshio.read(tmp_path / "maps" / files[1])
    np.testing.assert_array_equal(mesh.point_data["von_mises_rms_Pa_bottom"], np.arange(4.0, 8.0))
    np.testing.assert_array_equal(mesh.point_data["acceleration_rms_m_s-2"], np.arange(4.0))
