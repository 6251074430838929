"""Plane meshes from gmsh's ``.msh`` files, which may come from anybody.

gmsh runs what it finds: a file that does not begin like a mesh is executed as a script, and so is
``panel.msh.opt`` next to ``panel.msh``. It also allocates what a file states. So gmsh reads a copy
of the sections that a plane mesh needs, alone in a folder and with bounded memory.
"""

import re
import resource
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import gmsh
import numpy as np

from pidpanel.panel.flat_mesh import FlatMesh, read_mesh_file
from pidpanel.panel.mesh import gmsh_session

CORNERS = {2: 3, 3: 4}  # corners of the elements that are read, by gmsh's number of their kind
BEGINNINGS = (b"$MeshFormat", b"$Comments")
# The sections that are read; views, periods and partitions are not.
SECTION = re.compile(
    rb"^\$(MeshFormat|PhysicalNames|Entities|Nodes|Elements)[ \t]*\r?\n.*?^\$End\1\b",
    re.DOTALL | re.MULTILINE,
)
NAME = re.compile(rb"^\$(?!End)[A-Z][A-Za-z]{3,}", re.MULTILINE)  # the beginning of any section
# Number of nodes or elements of a section in text, from version 4 on after that of blocks.
HEADER = re.compile(rb"^\$(Nodes|Elements)[ \t]*\r?\n([0-9 \t]+)\r?$", re.MULTILINE)
MEMORY = 1 << 30
# Most memory that a file may take in gmsh [bytes], besides that of each of its bytes.
MEMORY_PER_BYTE = 100


def read_gmsh(path: Path) -> FlatMesh:
    """Read a plane mesh of triangles and quadrilaterals of first order from a gmsh file.

    Groups are the names of the physical surfaces, or their numbers if they have none. Raises
    `ValueError` with one line: what is wrong and what is allowed.
    """
    data = read_mesh_file(path)
    if not data.lstrip().startswith(BEGINNINGS):
        raise ValueError(f"{path}: not a gmsh mesh: it must begin with $MeshFormat")
    for header in HEADER.finditer(data):
        numbers = header[2].split()
        count = int(numbers[min(1, len(numbers) - 1)][:20]) if numbers else 0
        if count > len(data):
            line = data[: header.start(2)].count(b"\n") + 1
            noun = header[1].decode().lower()
            raise ValueError(
                f"{path}:{line}: states {count} {noun}; a file of {len(data)} bytes has fewer"
            )
    with gmsh_session():
        _load(path, data)
        node, position, _ = gmsh.model.mesh.getNodes()
        element, corners, group = _elements(path)
    if not element:
        raise ValueError(f"{path}: no triangles or quadrilaterals; a mesh needs them")
    return FlatMesh.from_elements(
        path, node.tolist(), position.reshape(-1, 3), element, corners, np.array(group)
    )


def _load(path: Path, data: bytes) -> None:
    """Have gmsh read the sections of a mesh."""
    sections = [section[0] for section in SECTION.finditer(data)]
    if not sections or not sections[0].startswith(BEGINNINGS[0]):
        raise ValueError(f"{path}: not a gmsh mesh: it has no $MeshFormat with its $EndMeshFormat")
    for section in sections:
        if len(names := NAME.findall(section)) > 1:
            raise ValueError(
                f"{path}: section {names[1].decode()} begins inside {names[0].decode()}"
            )
    if sections[0].split()[2:3] == [b"0"]:  # in text, as Windows writes it
        sections = [section.replace(b"\r\n", b"\n") for section in sections]
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "panel.msh"
        copy.write_bytes(b"\n".join([*sections, b""]))
        try:
            with _bounded_memory(MEMORY + MEMORY_PER_BYTE * len(data)):
                gmsh.merge(str(copy))
        except Exception as error:
            message = " ".join(str(error).replace(str(copy), str(path)).split())
            # std::bad_alloc has no text
            message = message or "it states more nodes or elements than it has"
            raise ValueError(f"{path}: not a gmsh mesh: {message}") from None


def _elements(path: Path) -> tuple[list[int], list[list[int]], list[str]]:
    """Return the numbers, corners and groups of the plane elements of gmsh's model."""
    element, corners, group = [], [], []
    for dimension, surface in gmsh.model.getEntities():
        if dimension < 2:
            continue
        tags = gmsh.model.getPhysicalGroupsForEntity(dimension, surface)
        name = ""
        if len(tags):
            name = gmsh.model.getPhysicalName(dimension, tags[0]) or str(tags[0])
        kinds, numbers, nodes = gmsh.model.mesh.getElements(dimension, surface)
        for kind, elements, element_nodes in zip(kinds, numbers, nodes, strict=True):
            if kind not in CORNERS:
                shape = gmsh.model.mesh.getElementProperties(kind)[0]
                raise ValueError(
                    f"{path}: element {elements[0]} is a {shape}; allowed are triangles and"
                    " quadrilaterals of first order"
                )
            element += elements.tolist()
            corners += element_nodes.reshape(len(elements), -1).tolist()
            group += [name] * len(elements)
    return element, corners, group


@contextmanager
def _bounded_memory(size: int) -> Iterator[None]:
    """Let allocations fail that take the process more than a size [bytes] beyond its present."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + size
    allowed = [limit] + [old for old in before if old != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(allowed), before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
