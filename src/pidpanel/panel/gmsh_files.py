"""Plane meshes from gmsh's ``.msh`` files, which may come from anybody.

gmsh runs what it finds: a file that does not begin like a mesh is executed as a script, and so is
``panel.msh.opt`` next to ``panel.msh``. It also allocates what a file states. So gmsh reads a copy
of the sections that a plane mesh needs, alone in a folder, with bounded memory and in a process of
its own (`gmsh_reader`).
"""

import json
import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.panel import gmsh_reader
from pidpanel.panel.flat_mesh import FlatMesh, read_mesh_file
from pidpanel.panel.gmsh_reader import SECTION

BEGINNINGS = (b"$MeshFormat", b"$Comments")
NAME = re.compile(rb"^\$(?!End)[A-Z][A-Za-z]{3,}", re.MULTILINE)  # the beginning of any section
# Number of nodes or elements of a section in text, from version 4 on after that of blocks.
HEADER = re.compile(rb"^\$(Nodes|Elements)[ \t]*\r?\n([0-9 \t]+)\r?$", re.MULTILINE)


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
    content = _content(path, data)
    element, corners = content["element"], content["corners"]
    names = [tuple(groups) for groups in content["names"]]
    if not element:
        raise ValueError(f"{path}: no triangles or quadrilaterals; a mesh needs them")
    if content["is_old"]:
        element, corners, names = _merged(element, corners, names)
    groups: dict[str, list[int]] = {}
    for k, name in enumerate(names):
        for group in name:
            groups.setdefault(group, []).append(k)
    position = unit * np.array(content["position"])
    mesh = FlatMesh.from_elements(path, content["node"], position, element, corners, groups)
    return replace(mesh, numbers=content["numbers"])


def _content(path: Path, data: bytes) -> dict[str, Any]:
    """Have gmsh read the sections of a mesh in a process of its own."""
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
        copy, answer = Path(folder) / "panel.msh", Path(folder) / "answer.json"
        copy.write_bytes(b"\n".join([*sections, b""]))
        command = [sys.executable, "-P", gmsh_reader.__file__, str(copy), str(answer)]
        process = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, check=False
        )
        if process.returncode or not answer.exists():
            message = "its numbers of nodes and elements contradict what it has"
            raise ValueError(f"{path}: not a gmsh mesh: {message}")
        content: dict[str, Any] = json.loads(answer.read_bytes())
    if "refusal" in content:
        raise ValueError(f"{path}: {content['refusal'].replace(str(copy), str(path))}")
    return content


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
