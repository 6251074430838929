"""Plane meshes from gmsh's ``.msh`` files, which may come from anybody.

gmsh runs what it finds: a file that does not begin like a mesh is executed as a script, and so is
``panel.msh.opt`` next to ``panel.msh``. It also allocates what a file states. So gmsh reads a copy
of the sections that a plane mesh needs, alone in a folder and with bounded memory.
"""

import re
import resource
import tempfile
from collections.abc import Iterator, Mapping
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


def read_gmsh(path: Path, unit: float = 1.0) -> FlatMesh:
    """Read a plane mesh of triangles and quadrilaterals of first order from a gmsh file.

    Groups are the names of the physical surfaces, or their numbers if they have none. In format 2
    an element of two groups stands twice, with two numbers, and is the same element. Raises
    `ValueError` with one line: what is wrong and what is allowed.

    Parameters
    ----------
    unit
        Length unit of the file [m].
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
        sections = _load(path, data)
        node, position, _ = gmsh.model.mesh.getNodes()
        is_old = sections[b"MeshFormat"].split()[1].startswith(b"2")
        tags = _physical_tags(path, sections) if is_old else None
        element, corners, names = _elements(path, tags)
    if not element:
        raise ValueError(f"{path}: no triangles or quadrilaterals; a mesh needs them")
    if is_old:
        element, corners, names = _merged(element, corners, names)
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        for group in name:
            groups.setdefault(group, []).append(k)
    return FlatMesh.from_elements(
        path, node.tolist(), unit * position.reshape(-1, 3), element, corners, groups
    )


def _load(path: Path, data: bytes) -> dict[bytes, bytes]:
    """Have gmsh read the sections of a mesh; return them by name."""
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
    return {section[1:].split(None, 1)[0]: section for section in sections}


def _physical_tags(path: Path, sections: Mapping[bytes, bytes]) -> dict[int, int]:
    """Return the physical group, or 0, by number of each element of a file of format 2.

    Format 2 states the group of each element. gmsh has groups of whole surfaces instead, and takes
    the last of several nodes or elements with one number.
    """
    is_text = sections[b"MeshFormat"].split()[2] == b"0"
    pairs: list[tuple[int, int]] = []
    if not {b"Nodes", b"Elements"} <= set(sections):
        return {}
    try:
        _, count, body = sections[b"Nodes"].split(b"\n", 2)
        if is_text:
            nodes = [int(line.split()[0]) for line in body.splitlines()[:-1] if line.strip()]
        else:
            record = np.dtype([("number", "<i4"), ("position", "<f8", 3)])
            nodes = np.frombuffer(body, record, int(count))["number"].tolist()
        _, count, body = sections[b"Elements"].split(b"\n", 2)
        if is_text:
            rows = [[int(word) for word in line.split()] for line in body.splitlines()[:-1]]
            pairs += [(row[0], row[3] if row[2] else 0) for row in rows if row]
        else:
            words, k = np.frombuffer(body[: len(body) // 4 * 4], "<i4"), 0
            while len(pairs) < int(count):
                kind, number, tag_count = words[k : k + 3].tolist()
                width = 1 + tag_count + gmsh.model.mesh.getElementProperties(kind)[3]
                block = words[k + 3 : (k := k + 3 + number * width)].reshape(number, width)
                pairs += [(row[0], row[1] if tag_count else 0) for row in block.tolist()]
    except (IndexError, ValueError) as error:
        raise ValueError(f"{path}: not a gmsh mesh: {error}") from None
    for noun, numbers in (("node", nodes), ("element", [number for number, _ in pairs])):
        values, copies = np.unique(numbers, return_counts=True)
        if copies.max(initial=0) > 1:
            raise ValueError(f"{path}: {noun} {values[np.argmax(copies)]} appears twice")
    return dict(pairs)


def _elements(
    path: Path, physical_tags: dict[int, int] | None
) -> tuple[list[int], list[list[int]], list[tuple[str, ...]]]:
    """Return the numbers, corners and groups of the plane elements of gmsh's model."""
    element, corners, names = [], [], []
    for dimension, surface in gmsh.model.getEntities():
        if dimension < 2:
            continue
        groups = gmsh.model.getPhysicalGroupsForEntity(dimension, surface).tolist()
        name = {tag: gmsh.model.getPhysicalName(dimension, tag) or str(tag) for tag in groups}
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
            for number in elements.tolist():
                if physical_tags is None:
                    names.append(tuple(name.values()))
                else:
                    tag = physical_tags.get(number, 0)
                    names.append((name.get(tag, str(tag)),) if tag else ())
    return element, corners, names


def _merged(
    element: list[int], corners: list[list[int]], names: list[tuple[str, ...]]
) -> tuple[list[int], list[list[int]], list[tuple[str, ...]]]:
    """Return the elements of format 2 once: copies of one element are in different groups."""
    first: dict[tuple[int, ...], int] = {}
    kept: list[int] = []
    names = list(names)
    for k, nodes in enumerate(corners):
        row = first.setdefault(tuple(sorted(nodes)), k)
        if row == k or not set(names[k]).isdisjoint(names[row]) or not names[k]:
            kept.append(k)
        else:
            names[row] += names[k]
    return [element[k] for k in kept], [corners[k] for k in kept], [names[k] for k in kept]


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
