"""Files of the maps: NetCDF to compute with, VTU and one PVD for ParaView."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np
import xarray as xr

from pidpanel.arrays import Array, Index, variable
from pidpanel.solve.stress import QUANTITIES

# Unit of each map; strains and stresses have one for each layer.
UNITS = {"acceleration": "m s-2", "displacement": "m", **QUANTITIES}

CORE_STRESSES = ("core_shear_xz", "core_shear_yz")  # maps of a panel with a core [Pa]


def map_dataset(
    maps: Mapping[tuple[str, str], Mapping[str, Array]],
    relative_error: Sequence[float],
    vertex_position: Array,
    cells: Index,
    layers: Sequence[str],
) -> xr.Dataset:
    """Return rms maps of some scenarios over the vertices of the mesh."""
    variables = {}
    for name in next(iter(maps.values())):
        unit = UNITS.get(name, "Pa")
        values = np.array([maps[name] for maps in maps.values()])
        dims = "case layer vertex" if values.ndim == 3 else "case vertex"
        variables[f"{name}_rms"] = variable(dims, values, unit, f"rms of {name}")
    errors = np.array(relative_error, dtype=np.float64)
    meaning = "largest standard error of the points' g rms"
    variables["relative_error"] = variable("case", errors, "1", meaning)
    position = variable("vertex axis", vertex_position, "m", "vertices of the mesh")
    variables["vertex_position"] = position
    variables["cells"] = variable("cell corner", cells, "1", "vertex numbers")
    coordinates = {
        "reading": ("case", [reading for reading, _ in maps]),
        "scenario": ("case", [label for _, label in maps]),
        "layer": list(layers),
    }
    return xr.Dataset(variables, coordinates)


def write_paraview(folder: Path, dataset: xr.Dataset) -> None:
    """Write a VTU file for each case, and ``maps.pvd`` with all of them as steps."""
    folder.mkdir(exist_ok=True)
    position = np.pad(dataset["vertex_position"].to_numpy(), ((0, 0), (0, 1)))
    cells = dataset["cells"].to_numpy()
    kind = {4: "quad", 3: "triangle"}[cells.shape[1]]
    entries = []
    for step in range(dataset.sizes["case"]):
        case = dataset.isel(case=step)
        data = {}
        for name in [str(name) for name in dataset.data_vars if str(name).endswith("_rms")]:
            values = case[name]
            unit = values.attrs["units"].replace(" ", "_")
            if "layer" not in values.dims:
                data[f"{name}_{unit}"] = values.to_numpy()
                continue
            for layer in case["layer"].to_numpy():
                key = f"{name}_{unit}_{layer}".replace(" ", "_")
                data[key] = values.sel(layer=layer).to_numpy()
        name = f"{case['reading'].item()}_{case['scenario'].item()}.vtu"
        meshio.Mesh(position, [(kind, cells)], point_data=data).write(folder / name)
        entries.append(f'<DataSet timestep="{step}" part="0" file={quoteattr(name)}/>')
    (folder / "maps.pvd").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        + "\n".join(entries)
        + "\n</Collection>\n</VTKFile>\n",
        encoding="utf-8",
    )
