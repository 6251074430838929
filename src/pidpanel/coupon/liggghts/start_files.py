"""What LIGGGHTS starts from, as text: the data file of the spheres, the STL of the walls.

A change of the bits that are written takes a new version number in `packing` or `bed`.
"""

import numpy as np

from pidpanel.arrays import Array


def data_file(positions: Array, diameters: Array, density: float, box: Array) -> str:
    """Return a data file of LIGGGHTS: centres (n, 3), diameters (n,) [m], density [kg/m³].

    The box has the lower and upper bounds of the simulation (3, 2) [m].
    """
    bounds = "".join(
        f"{low:.9g} {high:.9g} {axis}lo {axis}hi\n"
        for (low, high), axis in zip(box, "xyz", strict=True)
    )
    atoms = "".join(
        f"{i} 1 {d:.9g} {density:.9g} {x:.12g} {y:.12g} {z:.12g}\n"
        for i, ((x, y, z), d) in enumerate(zip(positions, diameters, strict=True), 1)
    )
    return f"spheres\n\n{len(positions)} atoms\n2 atom types\n\n{bounds}\nAtoms\n\n{atoms}"


def read_diameters(data: str) -> Array:
    """Return the diameters of the spheres of a `data_file`, (n,) [m]."""
    rows = data.partition("Atoms\n\n")[2].splitlines()
    return np.array([float(row.split()[2]) for row in rows])


def walls_file(triangles: Array) -> str:
    """Return an STL file of wall triangles, (n, 3, 3) [m]."""
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {:.12g} {:.12g} {:.12g}\n".format(*corner) for corner in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    )
    return f"solid cells\n{facets}endsolid cells\n"
