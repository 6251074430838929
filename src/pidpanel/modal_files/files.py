"""Files of modes and meshes by their suffixes."""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from pidpanel.modal_files import calculix, nastran, universal
from pidpanel.modal_files.model import ModalModel, modal_model
from pidpanel.modal_files.op2 import read_op2
from pidpanel.modal_files.shapes import ModeShapes, SurfaceElements
from pidpanel.modal_files.vtu import read_vtu
from pidpanel.tabular.units import UnitError

T = TypeVar("T")
UNIVERSAL = (".uff", ".unv", ".uf55")
MODES: dict[str, Callable[[Path], ModeShapes]] = {
    ".vtu": lambda path: read_vtu(path)[1],
    **dict.fromkeys(UNIVERSAL, universal.read_shapes),
    ".op2": read_op2,
    ".frd": calculix.read_shapes,
}
MESHES: dict[str, Callable[[Path], SurfaceElements]] = {
    ".vtu": lambda path: read_vtu(path)[0],
    **dict.fromkeys(UNIVERSAL, universal.read_mesh),
    **dict.fromkeys((".bdf", ".dat", ".nas", ".fem", ".blk"), nastran.read_mesh),
    ".inp": calculix.read_mesh,
    ".frd": calculix.read_result_mesh,
}


def read_modes(
    file: Path,
    mesh: Path | None = None,
    unit_m: float | None = None,
    *,
    unit_kg: float | None = None,
    normalised: str = "",
    static: Path | None = None,
    uniform_kg: float | None = None,
) -> ModalModel:
    """Read the modes of a structure that another solver has computed.

    Parameters
    ----------
    file
        Modes in VTU, universal file (data sets 55, 2414), OP2 of Nastran or ``.frd`` of CalculiX.
    mesh
        Nodes and surface elements; the file of modes if it has them.
    unit_m
        Length unit of the files [m]; not needed where data set 164 states it.
    unit_kg
        Mass unit of the files [kg]. Metres imply kg, millimetres t, inches lbf s²/in, feet slug.
    normalised
        ``mass`` where modes are scaled to modal masses of 1 that the file need not have.
    static
        A file of static cases in the format of the modes, if they are not with these.
    uniform_kg
        Mass [kg] that is spread evenly over the surface, where the file has no modal masses.

    Raises
    ------
    ValueError
        In one line: the files and the place, what is wrong and what is allowed.
    """
    mesh = file if mesh is None else mesh
    place = file.name if mesh == file else f"{file.name} with {mesh.name}"
    shapes, elements = _read(MODES, file, "modes"), _read(MESHES, mesh, "the mesh")
    if static is not None:
        cases = _read(MODES, static, "static cases")
        if sorted(cases.node) != sorted(shapes.node):
            raise ValueError(f"{static}: its nodes are not those of {file.name}")
        order = cases.node.argsort()[shapes.node.argsort().argsort()]
        shapes = shapes._replace(static=cases.static[order])
    units = [_units(path) for path in {file, mesh}]
    for length, mass in filter(None, units):
        for name, stated, value in (("unit_m", unit_m, length), ("unit_kg", unit_kg, mass)):
            if stated is not None and not math.isclose(stated, value, rel_tol=1e-3):
                message = f"{name} = {stated:g} contradicts {value:g} of data set 164"
                raise ValueError(f"{place}: {message}")
        unit_m, unit_kg = length, mass
    if unit_m is None:
        raise ValueError(f"{place}: unit_m is missing; such as 0.001 for millimetres")
    return modal_model(place, elements, shapes, unit_m, unit_kg, normalised, uniform_kg)


def _read(readers: Mapping[str, Callable[[Path], T]], path: Path, content: str) -> T:
    """Read a file by its suffix."""
    if path.suffix.lower() not in readers:
        allowed = ", ".join(readers)
        if path.suffix.lower() in MODES:
            raise ValueError(f"{path}: has no mesh that is read; state one, of {allowed}")
        raise ValueError(f"{path}: {content} cannot be in this format; allowed are {allowed}")
    try:
        return readers[path.suffix.lower()](path)
    except RecursionError:
        raise ValueError(f"{path}: files include each other") from None


def _units(path: Path) -> tuple[float, float] | None:
    """Return the units of length [m] and mass [kg] that a file states."""
    try:
        return universal.read_units(path) if path.suffix.lower() in UNIVERSAL else None
    except UnitError as error:
        raise ValueError(f"{path}: data set 164: {error}") from None
