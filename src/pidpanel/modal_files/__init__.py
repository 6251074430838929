"""Modes and meshes of other solvers: universal files, Nastran, CalculiX, VTU.

`read_modes` returns a `ModalModel`.
"""

from pidpanel.modal_files.files import read_modes
from pidpanel.modal_files.model import ModalModel

__all__ = ["ModalModel", "read_modes"]
