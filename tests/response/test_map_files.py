"""Files of the maps, read back."""

import xml.etree.ElementTree as ET

import meshio
import numpy as np
import xarray as xr

from pidpanel.response.map_files import UNITS, map_dataset, write_paraview


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
