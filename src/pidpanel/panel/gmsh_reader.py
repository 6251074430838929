"""The process that reads a gmsh mesh: ``gmsh_reader.py MESH ANSWER``, without the package.

gmsh writes beyond its memory where a file contradicts itself, such as in its numbers of nodes. So
a process of its own reads files from others, and answers in JSON.
"""

import json
import re
import resource
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gmsh
import numpy as np

ALLOWED = "triangles and quadrilaterals of first order (of a curved shell, structure.shell.form)"
CORNERS = {2: 3, 3: 4}  # corners of the elements that are read, by gmsh's number of their kind
# The sections that are read; views, periods and partitions are not.
SECTION = re.compile(
    rb"^\$(MeshFormat|PhysicalNames|Entities|Nodes|Elements)[ \t]*\r?\n.*?^\$End\1\b",
    re.DOTALL | re.MULTILINE,
)
MEMORY = 1 << 30
# Most memory that a file may take in gmsh [bytes], besides that of each of its bytes.
MEMORY_PER_BYTE = 100


def main(mesh: Path, answer: Path) -> None:
    """Write the nodes and elements of a mesh to a file, or why it is refused."""
    gmsh.initialize(["gmsh", "-v", "0"], readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    try:
        values = _content(mesh)
    except ValueError as error:
        values = {"refusal": str(error)}
    answer.write_text(json.dumps(values), encoding="utf-8")


def _content(mesh: Path) -> dict[str, Any]:
    """Return nodes, elements, their groups, and whether the format is 2."""
    data = mesh.read_bytes()
    sections = {section[1]: section[0] for section in SECTION.finditer(data)}
    try:
        with bounded_memory(MEMORY + MEMORY_PER_BYTE * len(data)):
            gmsh.merge(str(mesh))
    except Exception as error:
        message = " ".join(str(error).split())
        # std::bad_alloc has no text
        message = message or "it states more nodes or elements than it has"
        raise ValueError(f"not a gmsh mesh: {message}") from None
    is_old = sections[b"MeshFormat"].split()[1].startswith(b"2")
    physical_tags = _physical_tags(sections) if is_old else None
    node, position, _ = gmsh.model.mesh.getNodes()
    element, corners, names = _elements(physical_tags)
    plane = sum(gmsh.option.getNumber(f"Mesh.Nb{kind}") for kind in ("Triangles", "Quadrangles"))
    if plane != len(element):
        message = f"gmsh has {plane:g} plane elements, {len(element)} of them in first order"
        raise ValueError(f"{message}; allowed are {ALLOWED}")
    _check_count(sections)
    groups = gmsh.model.getPhysicalGroups(2)
    return {
        "node": node.tolist(),
        "position": position.reshape(-1, 3).tolist(),
        "element": element,
        "corners": corners,
        "names": names,
        "numbers": {tag: gmsh.model.getPhysicalName(2, tag) for _, tag in groups},
        "is_old": is_old,
    }


def _check_count(sections: Mapping[bytes, bytes]) -> None:
    """Refuse a text of another number of elements than it states: a part would be missing."""
    if sections[b"MeshFormat"].split()[2] != b"0" or b"Elements" not in sections:
        return
    numbers = sections[b"Elements"].split(b"\n", 2)[1].split()
    stated = int(numbers[min(1, len(numbers) - 1)])
    count = sum(map(len, gmsh.model.mesh.getElements()[1]))
    if stated != count:
        raise ValueError(f"states {stated} elements and has {count}")


def _physical_tags(sections: Mapping[bytes, bytes]) -> dict[int, int]:
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
        raise ValueError(f"not a gmsh mesh: {error}") from None
    for noun, numbers in (("node", nodes), ("element", [number for number, _ in pairs])):
        values, copies = np.unique(numbers, return_counts=True)
        if copies.max(initial=0) > 1:
            raise ValueError(f"{noun} {values[np.argmax(copies)]} appears twice")
    return dict(pairs)


def _elements(
    physical_tags: Mapping[int, int] | None,
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
                raise ValueError(f"element {elements[0]} is a {shape}; allowed are {ALLOWED}")
            element += elements.tolist()
            corners += element_nodes.reshape(len(elements), -1).tolist()
            for number in elements.tolist():
                if physical_tags is None:
                    names.append(tuple(name.values()))
                else:
                    tag = physical_tags.get(number, 0)
                    names.append((name.get(tag, str(tag)),) if tag else ())
    return element, corners, names


@contextmanager
def bounded_memory(size: int) -> Iterator[None]:
    """Let allocations fail that take the process more than a size [bytes] beyond its present."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + size
    allowed = [limit] + [old for old in limits if old != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(allowed), limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
