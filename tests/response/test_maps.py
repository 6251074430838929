"""Maps of rms values, held to the response at single points; their files read back."""

import xml.etree.ElementTree as ET

import meshio
import numpy as np
import xarray as xr

from pidpanel.response import stress
from pidpanel.response.dampers import attach_dampers
from pidpanel.response.map_files import UNITS, map_dataset, write_paraview
from pidpanel.response.maps import layer_maps, modal_covariances, rms_map
from pidpanel.response.modal import bare_panels
from pidpanel.response.radiation import air_resistance

LAYERS = stress.Layers(("top",), 0.01 * np.eye(3)[None], 1e8 * np.diag([1.0, 1.0, 0.35])[None])


def test_a_map_holds_at_its_points_what_the_response_there_has(panel, lines):
    # the same lines and trapezoids; what is left are the eigenvalues of D that maps drop, 5e-4
    # red: omega4 → omega4**0.5; factor * left out; weight / 2 → weight; VON_MISES → its diagonal
    omega = 2 * np.pi * lines.frequency[:, None, None]
    resistance = air_resistance(lines.frequency, lines.modal_force, 1.2, 343.0)
    motion = np.random.default_rng(5).standard_normal((3, 6, len(panel.modes)))
    motion[:, 0] = panel.points
    sound = (lines.pressure_psd, lines.modal_force, 1j * omega * resistance)
    dampers = (lines.equivalent_damping, lines.apparent_mass)
    (bare,) = bare_panels(
        lines.frequency, panel.basis, [panel.patches], motion, *sound, overlap_cutoff=1e-14
    )
    response = attach_dampers(bare, *dampers).under(4.0)
    psd = stress.layer_psd(response, LAYERS)[:, :, 0]
    expected = np.sqrt(np.trapezoid(psd, lines.frequency, axis=0))
    _, found = modal_covariances(
        lines.frequency,
        panel.basis,
        panel.patches,
        lines.pressure_psd,
        lambda f: lines.modal_force[np.searchsorted(lines.frequency, f)],
        [(*dampers, 1.0), (*dampers, 4.0)],
        lambda f: (1j * omega * resistance)[np.searchsorted(lines.frequency, f)],
    )
    points = panel.points
    np.testing.assert_allclose(
        rms_map(found.acceleration, points), response.acceleration_rms, rtol=1e-3
    )
    np.testing.assert_allclose(
        rms_map(found.displacement, points), response.displacement_rms, rtol=1e-3
    )
    maps = layer_maps(found.displacement, motion[:, 1:4], LAYERS)
    for index, name in enumerate(stress.QUANTITIES):
        np.testing.assert_allclose(maps[name][0], expected[:, index], rtol=1e-3)


def test_paraview_finds_every_case_with_units_in_the_names(tmp_path):
    # red: values.sel(layer=layer) → values.isel(layer=0)
    vertices = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    cells = np.array([[0, 1, 2, 3]])
    maps = {name: np.arange(4.0) for name in ("acceleration", "displacement")}
    maps |= {name: np.arange(8.0).reshape(2, 4) for name in UNITS if name not in maps}
    found = {("dem", "bare"): maps, ("dem", "PID-1_r0.5"): maps}
    path = tmp_path / "maps.nc"
    map_dataset(found, [0.1] * len(found), vertices, cells, ["top", "bottom"]).to_netcdf(
        path, engine="scipy"
    )
    with xr.open_dataset(path, engine="scipy") as dataset:
        assert dataset["acceleration_rms"].attrs["units"] == "m s-2"
        write_paraview(tmp_path / "maps", dataset.load())
    root = ET.parse(tmp_path / "maps" / "maps.pvd").getroot()
    files = [entry.attrib["file"] for entry in root.iter("DataSet")]
    assert files == ["dem_bare.vtu", "dem_PID-1_r0.5.vtu"]
    mesh = meshio.read(tmp_path / "maps" / files[1])
    np.testing.assert_array_equal(mesh.point_data["von_mises_rms_Pa_bottom"], np.arange(4.0, 8.0))
    np.testing.assert_array_equal(mesh.point_data["acceleration_rms_m_s-2"], np.arange(4.0))
