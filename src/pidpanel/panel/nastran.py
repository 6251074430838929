"""Plane meshes from Nastran bulk data: GRID, CTRIA3 and CQUAD4.

A deck with any other card (supports, masses, other elements, coordinate systems, includes)
describes another panel than would be read, so it is refused with the card and its line, unless
the study lists the card as ignored. Properties and materials are ignored: the section comes from
the study. So are parameters, and the executive and case control before ``BEGIN BULK``. Fields may
be short (8), long (16, ``GRID*``) or free (commas).
"""

import math
import re
from collections.abc import Collection, Iterator
from pathlib import Path

import numpy as np

from pidpanel.panel.flat_mesh import FlatMesh, MeshFileError, read_mesh_file
from pidpanel.text_files import lines_of

CORNERS = {"CTRIA3": 3, "CQUAD4": 4}
# Cards replaced by the section of the study, and cards of an analysis
IGNORED = ("PSHELL", "PCOMP", "PCOMPG", "MAT1", "MAT2", "MAT8", "PARAM", "EIGRL", "EIGR")
BULK = ["BEGIN", "BULK"]
ALLOWED = ", ".join(("GRID", *CORNERS, *IGNORED, "BEGIN BULK", "ENDDATA"))
ADVICE = "state supports and masses in the study and list their cards in panel.mesh.ignore"
# More than any card that is read or ignored has
MOST_FIELDS = 64
# A file with more mistakes is not read to its end
COUNTED_FAULTS = 1000
# Nastran may leave out the E of an exponent: 1.5-3 is 0.0015
SHORT_EXPONENT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")


def read_nastran(path: Path, ignored: Collection[str] = ()) -> FlatMesh:
    """Read a plane mesh from bulk data; groups are the property numbers of the elements.

    Further cards to ignore may be given, such as SPC1 and CONM2. Nodes that no element uses are
    then omitted: those cards used them.

    Raises
    ------
    MeshFileError
        A line for each mistake: file, line, card, what is allowed.
    ValueError
        If `FlatMesh.from_elements` refuses the elements.
    """
    node: list[int] = []
    position: list[list[float]] = []
    element: list[int] = []
    corners: list[list[int]] = []
    group: list[str] = []

    def read(where: str, name: str, fields: list[str]) -> None:
        if name == "GRID":
            number, system, x, y, z, out_system, constraints, *trailing = fields + 8 * [""]
            unread = [(system, "CP"), (out_system, "CD"), (constraints, "PS")]
            for field, label in unread + [(field, "a field after PS") for field in trailing]:
                if field not in ("", "0"):
                    raise ValueError(
                        f"{where}: {label} = {field} is not read; allowed is blank"
                        " (positions in the basic system, supports in the study)"
                    )
            tag = _integer(where, number)
            position.append([_real(where, value or "0") for value in (x, y, z)])
            node.append(tag)
        elif name in CORNERS:
            count = CORNERS[name]
            number, property_number, *tail = fields + 6 * [""]
            tag, nodes = _integer(where, number), [_integer(where, text) for text in tail[:count]]
            for value in tail[count:]:
                if value and _real(where, value) != 0:
                    raise ValueError(
                        f"{where}: field {value} after the nodes is not read; allowed is blank"
                        " (angles and offsets belong to the section)"
                    )
            element.append(tag)
            group.append(property_number or number)
            corners.append(nodes)

    faults: list[str] = []
    for line, name, fields in _cards(path, {*IGNORED, *ignored}, faults):
        try:
            read(f"{path}:{line}: {name}", name, fields)
        except ValueError as error:
            faults.append(str(error))
    if faults:
        raise MeshFileError(faults)
    if not element:
        raise ValueError(f"{path}: no CTRIA3 or CQUAD4; a mesh needs one")
    if ignored:
        used = {number for nodes in corners for number in nodes}
        rows = [row for row, number in enumerate(node) if number in used]
        node, position = [node[row] for row in rows], [position[row] for row in rows]
    return FlatMesh.from_elements(
        path, node, np.array(position).reshape(-1, 3), element, corners, np.array(group)
    )


def _cards(
    path: Path, ignored: Collection[str], faults: list[str]
) -> Iterator[tuple[int, str, list[str]]]:
    """Yield line number, name and fields of each card that is read; add faults of the others."""
    pending: tuple[int, str, list[str]] | None = None
    unknown: set[str] = set()
    data = read_mesh_file(path)
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise ValueError(f"{path}:{line}: must be text; it has a byte 0x00, as of a binary file")
    # comments may be in any encoding
    lines = [raw.split("$")[0].rstrip().expandtabs(8) for raw in lines_of(data.decode("latin-1"))]
    control = next((k for k, text in enumerate(lines) if text.upper().split() == BULK), 0)
    for number, text in enumerate(lines, 1):
        if not text.strip() or (number <= control and not text.upper().startswith("INCLUDE")):
            continue
        if text.strip().upper() == "ENDDATA" or len(faults) > COUNTED_FAULTS:
            break
        if text.upper().split() == BULK:
            continue
        head, fields = _fields(text)
        name = head.rstrip("*").strip().upper()
        if name in ("", "+") or head.startswith(("+", "*")):
            if pending is None:
                faults.append(f"{path}:{number}: a continuation without a card")
            elif len(pending[2]) > MOST_FIELDS:
                faults.append(f"{path}:{number}: a card has more than {MOST_FIELDS} fields")
                break
            else:
                pending[2].extend(fields)
            continue
        if pending is not None and pending[1] not in ignored:
            yield pending
        pending = number, name, fields
        if name not in ("GRID", *CORNERS, *ignored):
            if name not in unknown:  # reported once
                faults.append(
                    f"{path}:{number}: card {name} is not read; allowed are {ALLOWED}; {ADVICE}"
                )
            unknown.add(name)
            pending = number, IGNORED[0], fields
    if pending is not None and pending[1] not in ignored:
        yield pending


def _fields(text: str) -> tuple[str, list[str]]:
    """Return the name of a card and its fields, without the continuation mark at the end."""
    if "," in text:
        # fields 2 to 9; the tenth marks a continuation
        head, *fields = (field.strip() for field in text.split(","))
        return head, fields[: 4 if "*" in head else 8]
    head, body = text[:8].strip(), text[8:72]
    width = 16 if "*" in head else 8
    return head, [body[k : k + width].strip() for k in range(0, 64, width)]


def _integer(where: str, text: str) -> int:
    number = int(text) if re.fullmatch("[0-9]{1,18}", text) else 0
    if number < 1:
        raise ValueError(f"{where}: {text or 'a blank'} is not allowed; a number from 1 is needed")
    return number


def _real(where: str, text: str) -> float:
    try:
        number = float(SHORT_EXPONENT.sub(r"e\1", text.upper().replace("D", "E")))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{where}: {text} is not a number")
    return number
